//! Speed limits.

use crate::numbers::numbers;
use crate::scalar::{Over, Scalar};

/// Speed limit: a damper that acts on the speed beyond it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityLimit<P = f64> {
    /// Speed above which the damper acts, rad/s or m/s.
    pub speed: P,
    /// Force per excess speed, N·m·s/rad or N·s/m.
    pub damping: P,
}

numbers! { pub struct VelocityLimit {
    speed: NotNegative("speed limit"),
    damping: NotNegative("speed limit damping", "damping of a speed limit"),
} }

impl<P: Scalar> VelocityLimit<P> {
    /// Force by excess of speed where there is excess, else 0.
    pub(super) fn damping<T: Over<P>>(&self, v: T) -> T {
        T::from(self.speed).select_lt(v.abs(), self.damping.into(), T::zero())
    }

    pub(super) fn force<T: Over<P>>(&self, v: T) -> T {
        let (zero, limit) = (T::zero(), T::from(self.speed));
        let over = limit.select_lt(v, v - limit, zero);
        let under = v.select_lt(-limit, v + limit, zero);
        -((over + under) * self.damping)
    }
}
