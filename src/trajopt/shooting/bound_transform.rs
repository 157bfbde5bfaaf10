//! The bound transform: inputs within bounds as smooth functions of free variables.
//!
//! ```text
//!   lower ≤ u ≤ upper   u = m + h sin(z / h)          m, h: middle and half of the range
//!   lower ≤ u           u = lower − 1 + √(z² + 1)
//!           u ≤ upper   u = upper + 1 − √(z² + 1)
//!   no bound            u = z
//! ```
//!
//! A bound is reached at a finite z, where the slope is zero and the curvature is not: an optimum at a bound is an
//! ordinary minimum in z, unlike with tanh, whose optimum is at infinity. At a bound that is not optimal the gradient is
//! zero as well, so guesses are taken a little inside.
//!
//! [James & Roos 1975, MINUIT, section 1.3.1].

/// Least distance of a guess from its bounds, as a share of half the range
/// (of one unit where only one side is bounded).
const INSET: f64 = 1e-3;

/// The bounds of one input.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoundTransform {
    pub(super) lower: f64,
    pub(super) upper: f64,
}

/// An input with its derivatives in its variable.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transformed {
    pub(super) value: f64,
    pub(super) slope: f64,
    pub(super) curvature: f64,
}

impl BoundTransform {
    /// u(z), u′(z), u″(z).
    pub(super) fn apply(self, z: f64) -> Transformed {
        let (middle, half) = self.range();
        let root = (z * z + 1.0).sqrt();
        let (value, slope, curvature) = match (self.lower.is_finite(), self.upper.is_finite()) {
            (true, true) if half == 0.0 => (middle, 0.0, 0.0),
            (true, true) => {
                let (sin, cos) = (z / half).sin_cos();
                (middle + half * sin, cos, -sin / half)
            }
            (true, false) => (self.lower - 1.0 + root, z / root, root.powi(-3)),
            (false, true) => (self.upper + 1.0 - root, -z / root, -root.powi(-3)),
            (false, false) => (z, 1.0, 0.0),
        };
        Transformed {
            // Rounding may leave the bounds by a last digit.
            value: value.clamp(self.lower, self.upper),
            slope,
            curvature,
        }
    }

    /// A z with u(z) = u, for u at least a little inside the bounds.
    pub(super) fn invert(self, u: f64) -> f64 {
        let (middle, half) = self.range();
        let of_distance = |distance: f64| {
            let root = distance.max(INSET) + 1.0;
            (root * root - 1.0).sqrt()
        };
        match (self.lower.is_finite(), self.upper.is_finite()) {
            (true, true) if half == 0.0 => 0.0,
            (true, true) => {
                let sin = ((u - middle) / half).clamp(INSET - 1.0, 1.0 - INSET);
                half * sin.asin()
            }
            (true, false) => of_distance(u - self.lower),
            (false, true) => -of_distance(self.upper - u),
            (false, false) => u,
        }
    }

    /// Middle and half of the range.
    fn range(self) -> (f64, f64) {
        let half = 0.5 * (self.upper - self.lower);
        (self.lower + half, half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{FINITE_DIFFERENCE, SAME_ALGEBRA};

    const INF: f64 = f64::INFINITY;
    const KINDS: [(f64, f64); 5] = [
        (-3.0, 5.0),
        (2.0, INF),
        (-INF, -1.0),
        (-INF, INF),
        (4.0, 4.0),
    ];

    #[test]
    fn derivatives_of_the_transform_equal_finite_differences() {
        for (lower, upper) in KINDS {
            let transform = BoundTransform { lower, upper };
            for z in [-7.0, -0.3, 0.0, 0.8, 12.0] {
                let (h, at) = (1e-5, transform.apply(z));
                let (before, after) = (transform.apply(z - h), transform.apply(z + h));
                let slope = (after.value - before.value) / (2.0 * h);
                let curvature = (after.slope - before.slope) / (2.0 * h);
                assert!(
                    (at.slope - slope).abs() < FINITE_DIFFERENCE,
                    "{transform:?} at {z}"
                );
                assert!(
                    (at.curvature - curvature).abs() < FINITE_DIFFERENCE,
                    "{transform:?} at {z}"
                );
                assert!((lower..=upper).contains(&at.value), "{transform:?} at {z}");
            }
        }
    }

    #[test]
    fn the_transform_of_an_inverse_is_the_input_itself_inside_the_bounds() {
        for (lower, upper, u) in [(-3.0, 5.0, 4.2), (2.0, INF, 2.5), (-INF, -1.0, -9.0)] {
            let transform = BoundTransform { lower, upper };
            assert!((transform.apply(transform.invert(u)).value - u).abs() < SAME_ALGEBRA);
            let finite = if lower.is_finite() { lower } else { upper };
            let at_bound = transform.apply(transform.invert(finite));
            assert!((at_bound.value - finite).abs() < 5e-3 && at_bound.slope != 0.0);
        }
    }
}
