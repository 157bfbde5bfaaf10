//! Derivatives in the parameters of regularised constraints, and in the time step, which bounds their time constants.
//!
//! At a state, a row depends on them only through its pull and its compliance, y = J ã + b + p + R f.

use super::constraint_derivatives::BilateralConstraint;
use super::numbers::Numbers;
use crate::constraint::{ConstraintRow, Hold, Regularisation};
use crate::numbers::Numbers as Parameters;
use crate::scalar::{Dual, MapEach, Scalar};

/// The most parameters of a regularisation; the direction of the time step follows.
const PARAMETERS: usize = <Regularisation as Parameters<f64>>::COUNT;
const TIME_STEP: usize = PARAMETERS;

/// A value over the parameters of a regularisation and the time step.
type OfRegularisation<T> = Dual<T, { PARAMETERS + 1 }>;

impl<T: Scalar> BilateralConstraint<'_, T> {
    /// Adds the derivatives in the parameters of a regularised constraint, and in the time step.
    ///
    /// * `rows` – its own
    pub(super) fn emit_regularisation(&self, rows: &[ConstraintRow<T>], out: &mut Numbers<'_, T>) {
        let Some(own) = self.constraint.regularisation() else {
            return;
        };
        let own: Regularisation<OfRegularisation<T>> = own.seed(0);
        let dt = Dual::variable(T::constant(self.at.point.dt()), TIME_STEP);
        let constant = OfRegularisation::constant_of;
        let gains = own.gains(self.squares(rows).map_each(constant), dt);
        let mut sum = constant(T::zero());
        for (k, (row, &force)) in rows.iter().zip(self.forces()).enumerate() {
            let hold = gains.hold(constant(row.error), constant(row.rate), k >= LINEAR);
            if let Hold::Soft { pull, compliance } = hold {
                let weight = out.row_weight(self.first_row + k);
                sum += (pull + compliance.each(|x| x * force)).each(|x| x * weight);
            }
        }
        out.add(&self.slots.law, &sum.eps[..PARAMETERS]);
        out.add_time_step(sum.eps[TIME_STEP]);
    }

    /// |p|² and |θ|² of the errors.
    fn squares(&self, rows: &[ConstraintRow<T>]) -> [T; 2] {
        let square = |rows: &[ConstraintRow<T>]| {
            let errors = rows.iter().map(|row| row.error * row.error);
            errors.fold(T::zero(), |sum, x| sum + x)
        };
        let (linear, angular) = rows.split_at(rows.len().min(LINEAR));
        [square(linear), square(angular)]
    }
}

/// Rows of a weld that are linear, the first ones.
const LINEAR: usize = 3;
