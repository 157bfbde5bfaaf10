//! Torque–speed curves of motors.

use crate::numbers::{each_lane, numbers};
use crate::scalar::{Over, Scalar};

/// Torque–speed curve of a motor: the available torque at each speed, symmetric in torque and speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueSpeed<P = f64> {
    /// `τ_max`, N·m or N.
    pub torque: P,
    /// `ω_th`, the speed up to which the full torque is available, rad/s or m/s.
    pub threshold: P,
    /// `ω_max`, the speed at which the torque is zero, rad/s or m/s; larger than `ω_th`.
    pub maximum: P,
}

numbers! { pub struct TorqueSpeed {
    torque: NotNegative("motor torque", "torque of a motor"),
    threshold: NotNegativeOrdered("motor threshold speed", "threshold speed of a motor"),
    maximum: Ordered("motor largest speed", "largest speed of a motor"),
} }

impl<P: Scalar> TorqueSpeed<P> {
    /// # Panics
    /// If the largest speed is not above the threshold.
    pub(super) fn check_order(&self) {
        each_lane([self.threshold, self.maximum], |[threshold, maximum]| {
            let falls = maximum > threshold;
            assert!(
                falls,
                "a largest speed of a motor of {maximum} is not above the threshold of {threshold}"
            );
        });
    }

    /// `τ_max` (`ω_max` − |v|) / (`ω_max` − `ω_th`), within 0 and `τ_max`.
    pub(super) fn available<T: Over<P>>(&self, v: T) -> T {
        let (zero, torque) = (T::zero(), T::from(self.torque));
        let (threshold, maximum) = (T::from(self.threshold), T::from(self.maximum));
        let speed = v.abs();
        let sloped = torque * (maximum - speed) / (maximum - threshold);
        let falling = speed.select_lt(maximum, sloped, zero);
        threshold.select_lt(speed, falling, torque)
    }
}
