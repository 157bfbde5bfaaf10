//! Joint limits.

use crate::contact::HuntCrossley;
use crate::numbers::{each_lane, numbers};
use crate::scalar::{Over, Scalar};

/// Position limits of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionLimits<P = f64> {
    /// Least position, rad or m.
    pub lower: Option<P>,
    /// Largest position, rad or m.
    pub upper: Option<P>,
    /// The force of a joint limit, as a function of the depth beyond the limit and its rate.
    pub stop: HuntCrossley<P>,
}

numbers! { pub struct PositionLimits {
    lower: Ordered("lower limit", "position limit"),
    upper: Ordered("upper limit", "position limit"),
    stop: part(HuntCrossley, "stop {}", "{} of a joint limit"),
} }

impl<P: Scalar> PositionLimits<P> {
    /// # Panics
    /// If the lower end is above the upper one.
    pub(super) fn check_order(&self) {
        if let (Some(lower), Some(upper)) = (self.lower, self.upper) {
            each_lane([lower, upper], |[lower, upper]| {
                let ordered = lower <= upper;
                assert!(
                    ordered,
                    "a lower position limit of {lower} is above the upper one, {upper}"
                );
            });
        }
    }

    pub(super) fn force<T: Over<P>>(&self, q: T, v: T) -> T {
        let mut sum = T::zero();
        self.each_end(q, |end| {
            sum += end.force(v);
        });
        sum
    }

    /// Both ends that there are, at a position.
    pub(super) fn each_end<T: Over<P>>(&self, q: T, mut each: impl FnMut(&End<'_, P, T>)) {
        let ends = [(self.lower, 1.0), (self.upper, -1.0)];
        for (end, inward) in ends {
            if let Some(end) = end {
                each(&End {
                    depth: (-q + end) * inward,
                    inward,
                    stop: &self.stop,
                });
            }
        }
    }
}

/// An end of a joint.
pub(crate) struct End<'a, P, T> {
    /// Depth of the joint beyond the end, rad or m; negative before it.
    pub(crate) depth: T,
    /// The direction of its push along the coordinate.
    pub(crate) inward: f64,
    pub(crate) stop: &'a HuntCrossley<P>,
}

impl<P: Scalar, T: Over<P>> End<'_, P, T> {
    /// Force along the coordinate, which moves with `v`.
    pub(crate) fn force(&self, v: T) -> T {
        self.stop.force(self.depth, -(v * self.inward)) * self.inward
    }
}
