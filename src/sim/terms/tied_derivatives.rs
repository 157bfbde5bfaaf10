//! Derivatives of rows that couple joints: couplers and tendons.
//!
//! Such a row depends on its joints only through φ = Σ gᵢ(qᵢ) − length. One evaluation, over error, rate and the parameters of its force law,
//! suffices; the rest follows from the gᵢ and their derivatives. Where g is a polynomial, J changes with the joint, and the row has a bias.

use super::constraint_derivatives::BilateralConstraint;
use super::local::{FURTHER, OfBody, OfCoordinate, POSITION, RATE};
use super::numbers::Numbers;
use super::sink::{BodyRow, Own, Sink};
use super::tied_joint::{RowSlopes, Tied};
use crate::constraint::{Constraint, ConstraintKind, ConstraintRow, Hold, JointMotion};
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

impl<T: Scalar> BilateralConstraint<'_, T> {
    /// Whether it ties joints; else its row.
    fn tied_row<'a>(&self, rows: &'a [ConstraintRow<T>]) -> Option<&'a ConstraintRow<T>> {
        let ties = self.constraint.kind().joints().next().is_some();
        ties.then(|| &rows[self.first_row])
    }

    /// States the row and its force in derivatives of one joint after the other.
    pub(super) fn emit_tied(&self, rows: &[ConstraintRow<T>], out: &mut impl Sink<T>) {
        let Some(row) = self.tied_row(rows) else {
            return;
        };
        if self.is_ahead() {
            return self.emit_tied_ahead(out);
        }
        let row = seeded(self.constraint, row, self.at.point.dt());
        if self.is_spring_force() {
            return self.emit_tied_force(&row, out);
        }
        let force = self.forces()[0];
        let (y, by_bias) = (self.rest(&row, force), self.by_bias(&row));
        self.each_tied(|tied| {
            let k = tied.body.v;
            let mut own = tied.through(&y);
            if !tied.own.is_linear() {
                own += tied.bias().each(|x| x * by_bias);
                own.eps[POSITION] += tied.g[2] * self.at.a[k];
                out.coupled(k, k, tied.force(force));
            }
            out.coordinate_row(self.first_row, k, None, own);
        });
    }

    /// States half of the bias at the velocity after a step, in derivatives of a joint and of the coefficients of its powers.
    fn emit_tied_ahead(&self, out: &mut impl Sink<T>) {
        if !self.has_rows() {
            return;
        }
        self.each_tied(|tied| {
            if tied.own.is_linear() {
                return;
            }
            let y = tied.bias() * 0.5;
            out.coordinate_row(self.first_row, tied.body.v, None, y);
            if !out.wants_parameters() {
                return;
            }
            let zero = T::zero();
            let ahead = RowSlopes {
                error: zero,
                rate: zero,
                bias: T::constant(-0.5),
                seen: zero,
                mu: zero,
            };
            let mut y = OfBody::from(0.0);
            for (n, slope) in (2..).zip(&mut y.eps[FURTHER + 1..]) {
                *slope = ahead.of_power(n, tied, zero, zero);
            }
            let row = BodyRow {
                row: self.first_row,
                y,
                ..BodyRow::zero()
            };
            out.turn_to(self.at, None, None);
            out.rows(&[row], Own::Parameters(self.slots.placed.clone()));
        });
    }

    /// States the force of a spring on each joint, in derivatives of each.
    fn emit_tied_force(&self, row: &ConstraintRow<OfCoordinate<T>>, out: &mut impl Sink<T>) {
        let Some(force) = row.spring_force() else {
            return;
        };
        self.each_tied(|on| {
            let (k, c) = (on.body.v, on.entry());
            self.each_tied(|of| out.coupled(k, of.body.v, of.through(&force).each(|x| x * c)));
            if !on.own.is_linear() {
                out.coupled(k, k, on.force(force.re));
            }
        });
    }

    /// Slope of y in the bias; zero where none of its joints has one.
    fn by_bias(&self, row: &ConstraintRow<OfCoordinate<T>>) -> T {
        if (self.constraint.kind().joints()).all(|tied| tied.is_linear()) {
            return T::zero();
        }
        let plain = row.map(|x| OfCoordinate::constant_of(x.re));
        let bias = OfCoordinate::variable(row.bias.re, 0);
        let row = ConstraintRow { bias, ..plain };
        self.rest(&row, self.forces()[0]).eps[0]
    }

    /// Passes each joint to `each`.
    fn each_tied(&self, mut each: impl FnMut(&Tied<'_, T>)) {
        let point = self.at.point;
        for own in self.constraint.kind().joints() {
            let body = point.model().body(own.body);
            let motion = JointMotion::of(body, point.q(), point.v());
            each(&Tied {
                own,
                body,
                motion,
                g: own.at(motion.position),
            });
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
        self.add_coefficients(&slopes, seen, out);
        let first = self.slots.own.start;
        let length_at = match self.constraint.kind() {
            ConstraintKind::Coupler { .. } => first + 1,
            _ => first,
        };
        out.add(&(length_at..length_at + 1), &[-slopes.error]);
        out.add(&(length_at + 1..self.slots.own.end), &sum.eps[HOLD..]);
    }

    /// λ y − μᵀ Jᵀ f, over error, rate and how it is held, and its slopes.
    fn weighted(
        &self,
        row: &ConstraintRow<OfCoordinate<T>>,
        out: &Numbers<'_, T>,
    ) -> (OfCoordinate<T>, RowSlopes<T>) {
        let mut along = T::zero();
        self.each_tied(|tied| along += tied.entry() * out.mu()[tied.body.v]);
        let (weighted, seen, force) = match row.spring_force().filter(|_| self.is_spring_force()) {
            Some(force) => (-force.each(|x| x * along), T::zero(), force.re),
            None => {
                let (y, force) = (self.rest(row, self.forces()[0]), self.forces()[0]);
                let weight = out.row_weight(self.first_row);
                (y.each(|x| x * weight), weight, force)
            }
        };
        let slopes = RowSlopes {
            error: weighted.eps[POSITION],
            rate: weighted.eps[RATE],
            bias: match self.is_spring_force() {
                true => T::zero(),
                false => seen * self.by_bias(row),
            },
            seen,
            mu: -force,
        };
        (weighted, slopes)
    }

    /// Adds the derivatives in coefficients, and of joints that follow another one in its ratio r and its offset.
    fn add_coefficients(&self, by: &RowSlopes<T>, seen: &[T], out: &mut Numbers<'_, T>) {
        let (point, placed) = (self.at.point, self.slots.placed.clone());
        let mut i = 0;
        self.each_tied(|tied| {
            let at = tied.body.v;
            let (a, mu) = (seen[at], out.mu()[at]);
            match self.constraint.kind() {
                // q₁ − ratio q₂ − Σ hₙ q₂ⁿ
                ConstraintKind::Coupler { .. } if i == 1 => {
                    let ratio = self.slots.own.start;
                    out.add(&(ratio..ratio + 1), &[-by.of_power(1, tied, a, mu)]);
                    for (n, slot) in (2..).zip(placed.clone()) {
                        out.add(&(slot..slot + 1), &[-by.of_power(n, tied, a, mu)]);
                    }
                }
                ConstraintKind::Tendon { .. } => {
                    let own = placed.start + i;
                    out.add(&(own..own + 1), &[by.of_power(1, tied, a, mu)]);
                }
                _ => {}
            }
            i += 1;
            if let Some(first) = out.slots().1.coupling[tied.own.body.0] {
                let (q, v) = (point.q()[tied.body.q], point.v()[at]);
                // Such a joint is tied linearly.
                let c = tied.g[1];
                let by_ratio = by.error * q + by.rate * v + by.seen * a + by.mu * mu;
                out.add(&(first..first + 2), &[c * by_ratio, c * by.error]);
            }
        });
    }
}
