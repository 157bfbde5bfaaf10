//! Form of a constraint row for the solver, in a step or at an instant.

use crate::constraint::{ConstraintRow, Hold};
use crate::contact::SpringDamper;
use crate::scalar::{Over, Scalar};

/// y = J ã + rest + R f.
#[derive(Clone, Copy, Debug)]
pub(super) struct BilateralRow<T> {
    pub(super) rest: T,
    /// R; infinite where the row has no force.
    pub(super) compliance: T,
}

impl<T: Scalar> BilateralRow<T> {
    /// Force law of a row.
    ///
    /// A spring and damper has, over a step, the force of its end, from the row of joint limits; at an instant its force follows from the state, and the row
    /// takes no part. A regularised row has the same law at an instant and over a step.
    ///
    /// * `after` – b⁺ over a step; `None` at an instant
    /// * `dt` – the step, s
    #[inline]
    pub(super) fn of<D: Scalar>(row: &ConstraintRow<T>, after: Option<T>, dt: D) -> Self
    where
        T: Over<D>,
    {
        match row.hold {
            Hold::Rigid { time_constant } => Self {
                rest: match after {
                    Some(after) => row.over_step(after, time_constant, dt),
                    None => row.at_moment(time_constant, dt),
                },
                compliance: T::zero(),
            },
            Hold::Soft { pull, compliance } => Self {
                rest: row.bias + pull,
                compliance,
            },
            Hold::Spring { .. } if after.is_none() => Self {
                rest: T::zero(),
                compliance: T::constant(f64::INFINITY),
            },
            Hold::Spring { stiffness, damping } => {
                let own = SpringDamper {
                    spring: stiffness,
                    damper: damping,
                };
                let own = own.row(-row.error, row.rate, dt);
                Self {
                    rest: row.bias - own.reference,
                    compliance: own.compliance,
                }
            }
        }
    }

    /// Whether a force may belong to it.
    pub(super) fn takes_part(&self) -> bool {
        let known = self.compliance.has_value();
        !known || self.compliance.value(0) < f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROW: ConstraintRow<f64> = ConstraintRow {
        error: 0.03,
        rate: 0.2,
        bias: 5.0,
        turning: 0.0,
        hold: Hold::Spring {
            stiffness: 400.0,
            damping: 10.0,
        },
        largest_force: None,
    };

    // y = 0 at f = −k φ⁺ − d φ̇⁺ with φ̇⁺ = φ̇ + Δt (J ã + b) and φ⁺ = φ + Δt φ̇⁺.
    #[test]
    fn force_of_a_spring_is_that_of_the_end_of_the_step() {
        let (dt, a) = (0.01, -3.0);
        let held = BilateralRow::of(&ROW, Some(7.0), dt);
        let rate = ROW.rate + dt * (a + ROW.bias);
        let force = -400.0 * (ROW.error + dt * rate) - 10.0 * rate;
        let y = a + held.rest + held.compliance * force;
        assert!(y.abs() < 1e-11, "{y:e}");
    }

    #[test]
    fn springs_take_no_part_at_a_moment_and_never_without_stiffness_and_damping() {
        assert!(BilateralRow::of(&ROW, Some(0.0), 0.01).takes_part());
        assert!(!BilateralRow::of(&ROW, None, 0.01).takes_part());
        let hold = Hold::Spring {
            stiffness: 0.0,
            damping: 0.0,
        };
        let held = BilateralRow::of(&ConstraintRow { hold, ..ROW }, Some(0.0), 0.01);
        assert!(!held.takes_part());
    }
}
