//! Derivatives of rows that couple joints: couplers and tendons.
//!
//! Such a row depends on its joints only through φ = Σ cᵢ qᵢ − length. One evaluation, over error, rate and the parameters of its force law,
//! suffices; the rest is linear in cᵢ, positions and rates.

use super::constraint_derivatives::BilateralConstraint;
use super::local::{OfCoordinate, POSITION, RATE};
use super::numbers::Numbers;
use super::sink::Sink;
use crate::constraint::{Constraint, ConstraintKind, ConstraintRow, Hold, JointMotion, TiedJoint};
use crate::scalar::{Dual, Scalar};

/// Directions of the parameters of the force law, after those of error and rate: time constant, or stiffness and damping.
const HOLD: usize = 2;

/// A row over error, rate and the parameters of its force law, except a regularised one.
fn seeded<T: Scalar>(
    constraint: &Constraint,
    row: &ConstraintRow<T>,
    dt: f64,
) -> ConstraintRow<OfCoordinate<T>> {
    let number = |x, k| OfCoordinate::variable(x, HOLD + k);
    let error = OfCoordinate::variable(row.error, POSITION);
    let rate = OfCoordinate::variable(row.rate, RATE);
    let hold = match row.hold {
        Hold::Rigid { time_constant } => Hold::Rigid {
            time_constant: number(time_constant, 0),
        },
        Hold::Spring { stiffness, damping } => Hold::Spring {
            stiffness: number(stiffness, 0),
            damping: number(damping, 1),
        },
        soft @ Hold::Soft { .. } => match constraint.regularisation() {
            Some(own) => {
                let squares = [error * error, Dual::from(0.0)];
                own.gains(squares, Dual::from(dt)).hold(error, rate, false)
            }
            None => soft.map(Dual::constant_of),
        },
    };
    ConstraintRow {
        error,
        rate,
        bias: Dual::constant_of(row.bias),
        turning: Dual::constant_of(row.turning),
        hold,
        largest_force: row.largest_force.map(Dual::constant_of),
    }
}

/// Derivatives in what a row knows of a joint.
#[derive(Clone, Copy)]
struct JointDerivatives<T> {
    position: T,
    rate: T,
    /// In the acceleration of the joint by ã, and in the weight μ of its coordinate.
    seen: T,
    mu: T,
}

impl<T: Scalar> BilateralConstraint<'_, T> {
    /// Whether it ties joints; else its row.
    fn tied_row<'a>(&self, rows: &'a [ConstraintRow<T>]) -> Option<&'a ConstraintRow<T>> {
        let ties = self.constraint.kind().joints().next().is_some();
        ties.then(|| &rows[self.first_row])
    }

    /// States the row in derivatives of one joint after the other; its forces on them are constant, except for those of a spring at an instant.
    pub(super) fn emit_tied(&self, rows: &[ConstraintRow<T>], out: &mut impl Sink<T>) {
        let Some(row) = self.tied_row(rows) else {
            return;
        };
        let row = seeded(self.constraint, row, self.at.point.dt());
        if self.is_ahead() {
            return;
        }
        if self.is_spring_force() {
            return self.emit_tied_force(&row, out);
        }
        let y = self.rest(&row, self.forces()[0]);
        self.each_entry(|k, c| out.coordinate_row(self.first_row, k, None, y.each(|x| x * c)));
    }

    /// States the force of a spring on each joint, in derivatives of each.
    fn emit_tied_force(&self, row: &ConstraintRow<OfCoordinate<T>>, out: &mut impl Sink<T>) {
        let Some(force) = row.spring_force() else {
            return;
        };
        self.each_entry(|k, c| {
            self.each_entry(|l, d| out.coupled(k, l, force.each(|x| x * (c * d))));
        });
    }

    /// Passes each entry of J to `each`, with its coordinate.
    fn each_entry(&self, mut each: impl FnMut(usize, T)) {
        for TiedJoint { body, coefficient } in self.constraint.kind().joints() {
            let body = self.at.point.model().body(body);
            each(body.v, body.scaled(T::constant(coefficient)));
        }
    }

    /// Adds the derivatives in its own numbers, and in ratio and offset of joints of it that follow another one.
    pub(super) fn emit_tied_numbers(
        &self,
        seen: &[T],
        rows: &[ConstraintRow<T>],
        out: &mut Numbers<'_, T>,
    ) {
        let Some(row) = self.tied_row(rows) else {
            return;
        };
        let row = seeded(self.constraint, row, self.at.point.dt());
        let (sum, slopes) = self.weighted(&row, out);
        let length = -slopes.position;
        self.add_coefficients(&slopes, seen, out);
        let first = self.slots.own.start;
        let length_at = match self.constraint.kind() {
            ConstraintKind::Coupler { .. } => first + 1,
            _ => first,
        };
        out.add(&(length_at..length_at + 1), &[length]);
        out.add(&(length_at + 1..self.slots.own.end), &sum.eps[HOLD..]);
    }

    /// λ y − μᵀ Jᵀ f, over error, rate and how it is held, and its derivatives in what it knows of a joint of coefficient 1.
    fn weighted(
        &self,
        row: &ConstraintRow<OfCoordinate<T>>,
        out: &Numbers<'_, T>,
    ) -> (OfCoordinate<T>, JointDerivatives<T>) {
        let mut along = T::zero();
        self.each_entry(|k, c| along += c * out.mu()[k]);
        let (weighted, seen, force) = match row.spring_force().filter(|_| self.is_spring_force()) {
            Some(force) => (-force.each(|x| x * along), T::zero(), force.re),
            None => {
                let (y, force) = (self.rest(row, self.forces()[0]), self.forces()[0]);
                let weight = out.row_weight(self.first_row);
                (y.each(|x| x * weight), weight, force)
            }
        };
        let slopes = JointDerivatives {
            position: weighted.eps[POSITION],
            rate: weighted.eps[RATE],
            seen,
            mu: -force,
        };
        (weighted, slopes)
    }

    /// Adds the derivatives in coefficients, and of joints that follow another one in its ratio r and its offset.
    fn add_coefficients(&self, by: &JointDerivatives<T>, seen: &[T], out: &mut Numbers<'_, T>) {
        let point = self.at.point;
        for (i, tied) in self.constraint.kind().joints().enumerate() {
            let body = point.model().body(tied.body);
            let JointMotion { position, rate } = JointMotion::of(body, point.q(), point.v());
            let (q, v) = (point.q()[body.q], point.v()[body.v]);
            let (a, mu) = (seen[body.v], out.mu()[body.v]);
            let scaled = |x: T| body.scaled(x);
            let by_coefficient =
                by.position * position + by.rate * rate + by.seen * scaled(a) + by.mu * scaled(mu);
            match self.constraint.kind() {
                // q₁ − ratio q₂
                ConstraintKind::Coupler { .. } if i == 1 => {
                    let ratio = self.slots.own.start;
                    out.add(&(ratio..ratio + 1), &[-by_coefficient]);
                }
                ConstraintKind::Tendon { .. } => {
                    let own = self.slots.placed.start + i;
                    out.add(&(own..own + 1), &[by_coefficient]);
                }
                _ => {}
            }
            if let Some(first) = out.slots().1.coupling[tied.body.0] {
                let c = T::constant(tied.coefficient);
                let by_ratio = by.position * q + by.rate * v + by.seen * a + by.mu * mu;
                out.add(&(first..first + 2), &[c * by_ratio, c * by.position]);
            }
        }
    }
}
