//! Derivatives in the parameters of compliant constraints: maximum force, and those of a spring at an instant.
//!
//! Over a step the latter are among the numbers of its rows. At an instant the force of a spring follows from error and rate, and acts along J.

use super::constraint_derivatives::BilateralConstraint;
use super::local::OfCoordinate;
use super::numbers::Numbers;
use super::sink::BodySink;
use crate::constraint::{ConstraintKind, ConstraintRow, Hold};
use crate::linalg::product::dot;
use crate::scalar::{Dual, MapEach, Scalar};

/// Directions of stiffness, damping, bound and length of a spring at an instant.
const SPRING: [usize; 4] = [0, 1, 2, 3];

impl<T: Scalar> BilateralConstraint<'_, T> {
    /// Adds the derivatives in its largest force, and of a spring between anchors at an instant those in all its own numbers.
    pub(super) fn emit_own_numbers(&self, rows: &[ConstraintRow<T>], out: &mut Numbers<'_, T>) {
        let rows = &rows[self.first_row..][..self.constraint.rows()];
        self.emit_regularisation(rows, out);
        if self.is_spring_force() {
            let slopes = self.spring_slopes(rows, out);
            let [stiffness, damping, bound, length] = SPRING.map_each(|k| slopes.eps[k]);
            out.add(&self.slots.bound, &[bound]);
            match self.constraint.kind() {
                ConstraintKind::Distance { .. } => {
                    out.add(&self.slots.own, &[length, stiffness, damping]);
                }
                ConstraintKind::Weld(_) | ConstraintKind::Ball(_) => {
                    out.add(&self.slots.own, &[stiffness, damping]);
                }
                // The other numbers of these stand with those of their joints.
                ConstraintKind::Coupler { .. } | ConstraintKind::Tendon { .. } => {}
            }
        } else if self.at.balance().is_some() && !self.slots.bound.is_empty() {
            let mut sum = out.sum(None);
            for block in self.first_block..self.first_block + rows.len() {
                let bound = Dual::variable(T::zero(), 0);
                sum.friction(block, bound);
            }
            let slope = sum.value.eps[0];
            out.add(&self.slots.bound, &[slope]);
        }
    }

    /// −μᵀ Jᵀ f of a spring at an instant, over its numbers.
    fn spring_slopes(&self, rows: &[ConstraintRow<T>], out: &Numbers<'_, T>) -> OfCoordinate<T> {
        let mut sum = OfCoordinate::from(0.0);
        let (mu, Some(balance)) = (out.mu(), self.at.balance()) else {
            return sum;
        };
        let all = balance.rows().first_rows(self.first_row + rows.len());
        let jacobian = all.chunks_exact(mu.len().max(1)).skip(self.first_row);
        for (row, entries) in rows.iter().zip(jacobian) {
            let along = dot(entries, mu);
            if let Some(force) = over_spring(row).spring_force() {
                sum -= force.each(|x| x * along);
            }
        }
        sum
    }
}

/// A row over the parameters of its spring.
fn over_spring<T: Scalar>(row: &ConstraintRow<T>) -> ConstraintRow<OfCoordinate<T>> {
    let [stiffness, damping, bound, length] = SPRING;
    let mut error = OfCoordinate::constant_of(row.error);
    error.eps[length] = -T::one();
    let seeded = |x, k| OfCoordinate::variable(x, k);
    let hold = match row.hold {
        Hold::Rigid { time_constant } => Hold::Rigid {
            time_constant: Dual::constant_of(time_constant),
        },
        Hold::Spring {
            stiffness: k,
            damping: d,
        } => Hold::Spring {
            stiffness: seeded(k, stiffness),
            damping: seeded(d, damping),
        },
        soft @ Hold::Soft { .. } => soft.map(Dual::constant_of),
    };
    ConstraintRow {
        error,
        rate: Dual::constant_of(row.rate),
        bias: Dual::constant_of(row.bias),
        turning: Dual::constant_of(row.turning),
        hold,
        largest_force: row.largest_force.map(|x| seeded(x, bound)),
    }
}
