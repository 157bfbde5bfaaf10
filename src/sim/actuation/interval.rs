//! Ranges of an input or a force.

use crate::numbers::{each_lane, numbers};
use crate::scalar::Scalar;

/// A closed interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval<P = f64> {
    /// The lower end.
    pub lower: P,
    /// The upper end, not below the lower one.
    pub upper: P,
}

numbers! { pub struct Interval {
    lower: Ordered("least"),
    upper: Ordered("largest"),
} }

impl<P: Scalar> Interval<P> {
    /// Both sides of zero.
    pub(in crate::sim) fn symmetric(limit: P) -> Self {
        Self {
            lower: -limit,
            upper: limit,
        }
    }

    /// The number of the interval that is nearest to `x`; at an end with the derivative of the inner side.
    pub(crate) fn nearest(&self, x: P) -> P {
        let x = self.upper.select_lt(x, self.upper, x);
        x.select_lt(self.lower, self.lower, x)
    }

    /// The numbers that are in both, of which there is one at the least: the end of this one that is nearest.
    pub(super) fn within(&self, other: &Self) -> Self {
        Self {
            lower: other.nearest(self.lower),
            upper: other.nearest(self.upper),
        }
    }

    /// # Panics
    /// If the upper end is below the lower one.
    pub(super) fn check_order(&self, of: &str) {
        each_lane([self.lower, self.upper], |[lower, upper]| {
            assert!(
                lower <= upper,
                "the {of} of a servo go from {lower} to {upper}, which are not in order"
            );
        });
    }
}
