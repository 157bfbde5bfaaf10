//! The law of an interval on the central path: the force between two bounds, each with a multiplier of its own.
//!
//! f = Π(f − y) with the projection Π on [−b, b] is  y = z₋ − z₊  with  0 ≤ z₋ ⊥ b + f ≥ 0  and  0 ≤ z₊ ⊥ b − f ≥ 0. On the path both products are κ, so that
//! y = κ / (b + f) − κ / (b − f), the slope of the barrier −κ ln (b + f) − κ ln (b − f) with the other sign.

use crate::scalar::{MapEach, Scalar};

/// Bounds beside the size of a problem, both scaled, that the path distinguishes from none and from an infinite one.
const BOUNDS: (f64, f64) = (1e-9, 1e8);

/// A bound that the path can follow, from the one that is given.
pub(super) fn bound_on_path<T: Scalar>(bound: T, size: T) -> T {
    (bound.max(size * BOUNDS.0)).min(size * BOUNDS.1)
}

/// f within its bounds; those of no bound are zero.
pub(super) fn clamped<T: Scalar>(f: T, bound: T) -> T {
    f.max(-bound).min(bound)
}

/// The multipliers of both bounds, and how they follow the force in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Multipliers<T = f64> {
    /// z₋ and z₊.
    z: [T; 2],
    /// δz = constant − slope δf.
    constant: [T; 2],
    slope: [T; 2],
}

impl<T: Scalar> Multipliers<T> {
    /// Those of what has none.
    pub(super) fn none() -> Self {
        let [z, constant, slope] = [[T::zero(); 2]; 3];
        Self { z, constant, slope }
    }

    /// On the path at κ, with no force.
    pub(super) fn start(bound: T, kappa: T) -> Self {
        Self {
            z: [kappa / bound; 2],
            ..Self::none()
        }
    }

    /// Both products that equal κ on the central path.
    pub(super) fn products(&self, f: T, bound: T) -> [T; 2] {
        [self.z[0] * (bound + f), self.z[1] * (bound - f)]
    }

    /// H and c of  H δf + δy = c, from both products linearised. Multipliers follow the values alone.
    pub(super) fn linearize(&mut self, f: T, bound: T, kappa: T) -> (T, T) {
        let (mut h, mut c) = (T::zero(), T::zero());
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            let room = bound + f * sign;
            let (constant, slope) = (kappa / room - self.z[side], self.z[side] / room);
            h += slope;
            c += constant * sign;
            self.constant[side] = constant.detached();
            self.slope[side] = (slope * sign).detached();
        }
        (h, c)
    }

    /// Steps of both multipliers with one of the force.
    fn steps(&self, df: T) -> [T; 2] {
        [0, 1].map_each(|side| self.constant[side] - self.slope[side] * df)
    }

    /// Pairs of a number that stays positive and its step.
    pub(super) fn positive(&self, f: T, df: T, bound: T) -> [(T, T); 4] {
        let [below, above] = self.steps(df);
        [
            (bound + f, df),
            (bound - f, -df),
            (self.z[0], below),
            (self.z[1], above),
        ]
    }

    /// Goes a part of a step.
    pub(super) fn advance(&mut self, length: T, df: T) {
        let steps = self.steps(df);
        let all = self.z.iter_mut().zip(steps);
        all.for_each(|(z, step)| *z += length * step);
    }

    /// y, of which nothing is lost to rounding while steps add up.
    pub(super) fn velocity(&self) -> T {
        self.z[0] - self.z[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // z₋ (b + f) = κ and z₊ (b − f) = κ after a step that is short beside both.
    #[test]
    fn steps_keep_the_products_to_first_order() {
        let (bound, kappa) = (2.0, 0.3);
        let mut on_path = Multipliers::start(bound, kappa);
        assert_eq!(on_path.products(0.0, bound), [kappa; 2]);
        let df = 1e-4;
        let (h, c) = on_path.linearize(0.0, bound, kappa);
        on_path.advance(1.0, df);
        for product in on_path.products(df, bound) {
            assert!((product - kappa).abs() < 1e-8, "{product}");
        }
        assert!((on_path.velocity() - (c - h * df)).abs() < 1e-15);
    }

    #[test]
    fn bounds_of_none_and_infinite_ones_become_such_that_the_path_can_follow() {
        assert_eq!(bound_on_path(0.0, 2.0), 2e-9);
        assert_eq!(bound_on_path(f64::INFINITY, 2.0), 2e8);
        assert_eq!(bound_on_path(0.7, 2.0), 0.7);
        assert_eq!((clamped(3.0, 0.5), clamped(-3.0, 0.5)), (0.5, -0.5));
    }
}
