//! Moments of torsional and rolling friction at a point: rows of a solver, or explicit.

use nalgebra::Vector3;

use super::laws::{ContactRow, ROWS};
use super::turning::{LEAST, TurningFriction};
use crate::cone::Block;
use crate::scalar::{MapEach, Over, Scalar, from_each};
use crate::spatial::linear::{dot, scale};

/// Rate of rotation ω₀ below which explicit moments of soft contact decrease, rad/s.
const SLOW: f64 = 0.1;

/// Moments at a contact point: their coefficients, and the rotation that they brake.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turning<P, T> {
    pub(crate) friction: TurningFriction<P>,
    /// Rate of rotation of the first body less that of the second, in the world, rad/s.
    pub(crate) rate: Vector3<T>,
}

/// Blocks of moments of a point, each with its coefficient.
pub(crate) type TurningBlocks<T> = [(Block, T); 2];

impl<P: Scalar, T: Over<P>> Turning<P, T> {
    fn coefficient(&self, axis: usize) -> T {
        T::from(match axis {
            0 => self.friction.torsional,
            _ => self.friction.rolling,
        })
    }

    /// Rows of moments about all axes of a point.
    ///
    /// * `back` – part of a rate that a row takes back in a unit of time, 1/s
    /// * `compliance` – that of a row times the square of its coefficient, 1/kg
    pub(super) fn rows(
        &self,
        axes: &[Vector3<T>; ROWS],
        [back, compliance]: [T; 2],
    ) -> [ContactRow<T>; ROWS] {
        from_each(|k| {
            let (c, absent) = (self.coefficient(k), T::constant(f64::INFINITY));
            ContactRow {
                reference: -(back * dot(&axes[k], &self.rate)),
                compliance: T::constant(LEAST).select_lt(c, compliance / (c * c), absent),
            }
        })
    }

    /// All blocks of moments with their coefficients at a depth (m): none of a point that is met before it arrives.
    pub(crate) fn blocks(&self, depth: T, speculative: bool) -> TurningBlocks<T> {
        [(Block::Spin, 0), (Block::Roll, 1)].map_each(|(block, axis)| {
            let c = self.coefficient(axis);
            let none = T::zero();
            let c = if speculative {
                depth.select_lt(none, none, c)
            } else {
                c
            };
            (block, c)
        })
    }

    /// Explicit moment on the first body under a normal force, in the world, N·m.
    pub(crate) fn explicit_moment(&self, normal: &Vector3<T>, force: T) -> Vector3<T> {
        let spin = scale(normal, dot(normal, &self.rate));
        let roll = self.rate - spin;
        let braked = |rate: &Vector3<T>, c: T| {
            let size = (dot(rate, rate) + SLOW * SLOW).sqrt();
            scale(rate, -(c * force / size))
        };
        braked(&spin, self.coefficient(0)) + braked(&roll, self.coefficient(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // −c fₙ ω / √(‖ω‖² + ω₀²): nearly the bound, and against each part of the rotation by itself.
    #[test]
    fn explicit_moments_are_near_their_bounds_and_against_the_rotation() {
        let turning = Turning {
            friction: TurningFriction {
                torsional: 0.02,
                rolling: 0.01,
            },
            rate: Vector3::new(30.0, -40.0, 50.0),
        };
        let moment = turning.explicit_moment(&Vector3::z(), 10.0);
        let expected = Vector3::new(-0.06, 0.08, -0.2);
        assert!((moment - expected).norm() < 1e-5, "{moment}");
    }
}
