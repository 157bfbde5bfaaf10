//! Kinematic constraints: rows whose forces hold loops closed.

use nalgebra::DVector;

use super::adjoint::{AdjointPoint, StepSlopes, TermAdjoint};
use super::columns::RowColumns;
use super::linear_point::{ForceColumns, LinearPoint};
use super::term::{Term, TermDerivatives};
use crate::autodiff::CHUNK;
use crate::constraint::ConstraintRows;
use crate::contact::cone::Block;
use crate::dynamics::{Blocks, Sweep};
use crate::model::Model;
use crate::model::manifold::v_range;
use crate::scalar::{Dual, Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::forces::Forces;
use crate::sim::moment::Moment;
use crate::sim::simulator::Simulator;

/// Constraints at a moment.
#[derive(Clone, Debug)]
pub(crate) struct Constraints<T> {
    rows: ConstraintRows<T>,
    /// The velocity with which the bias after the step is found.
    next_v: Vec<T>,
}

impl<T: Scalar> Constraints<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let (rows, nv) = (simulator.held_rows(), simulator.model().nv());
        Self {
            rows: ConstraintRows::new(rows, nv),
            next_v: Vec::with_capacity(nv),
        }
    }

    /// J, row after row, and the accelerations J a that hold the constraints along the velocity of the start of a step.
    pub(crate) fn held_along_start(&self, dt: f64) -> (&[T], impl Iterator<Item = T>) {
        let rows = self.rows.rows.iter();
        let wanted = rows.map(move |row| -(row.over_step(row.bias, dt) + row.turning));
        (&self.rows.jacobian, wanted)
    }

    /// Finds the biases at the velocity after a step with the acceleration `a`.
    fn look_ahead<P: Scalar>(&mut self, at: &Moment<'_, P, T>, a: &[T])
    where
        T: Over<P>,
    {
        self.next_v.clear();
        self.next_v.resize(a.len(), T::zero());
        step_velocity_into(at, a, &mut self.next_v);
        let constraints = at.simulator.constraints();
        let (rows, next_v) = (&mut self.rows, &self.next_v);
        rows.look_ahead(at.model(), constraints, at.q(), next_v);
    }
}

/// The velocity after a step, along the axes of before it.
fn step_velocity_into<P: Scalar, T: Over<P>>(at: &Moment<'_, P, T>, a: &[T], next_v: &mut [T]) {
    for body in at.model().independent() {
        let own = v_range(body);
        let (v, a) = (&at.v()[own.clone()], &a[own.clone()]);
        body.joint.step_velocity(v, a, at.dt(), &mut next_v[own]);
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for Constraints<T> {
    #[inline]
    fn add_forces(&mut self, at: &Moment<'_, P, T>, _: &mut Forces<T>) {
        let constraints = at.simulator.constraints();
        if !constraints.is_empty() {
            let rows = &mut self.rows;
            rows.evaluate(at.model(), constraints, at.q(), at.v());
        }
    }

    /// y = J ã − reference: at a moment, or over a step from the acceleration that would be without other rows.
    fn add_rows(&mut self, at: &Moment<'_, P, T>, balance: &mut Balance<T>) {
        let constraints = at.simulator.constraints();
        if constraints.is_empty() {
            return;
        }
        let dt = at.dt();
        let ahead = balance.gyroscopic().map(|gyroscopic| &gyroscopic.a[..]);
        if let Some(a) = ahead {
            self.look_ahead(at, a);
        }
        let over_step = ahead.is_some();
        let rows = &mut balance.rows;
        let own = rows.grow(self.rows.rows.len());
        own.copy_from_slice(&self.rows.jacobian);
        for (r, row) in self.rows.rows.iter().enumerate() {
            let bias = if over_step {
                row.over_step(self.rows.bias_after(r), dt)
            } else {
                row.at_moment(dt)
            };
            rows.push_reference(-bias, T::zero());
        }
        for constraint in constraints {
            rows.push_block(Block::Free(constraint.rows()), T::zero());
        }
    }
}

type Local = Dual<f64, CHUNK>;

/// Derivatives of the term: its rows on dual numbers, some directions at a time.
#[derive(Clone, Debug)]
pub(crate) struct ConstraintColumns {
    rows: ConstraintRows<Local>,
    start: Vec<Local>,
    tangent: Vec<Local>,
    q: DVector<Local>,
    v: Vec<Local>,
    next_v: Vec<Local>,
    /// Derivative ∂y/∂v⁺ in the velocity after a step, row after row.
    pub(crate) by_next_v: Vec<f64>,
}

/// Point at which rows y are differentiated, at fixed forces and accelerations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held<'a> {
    /// ã.
    pub(crate) seen: &'a [f64],
    /// Of the rows.
    pub(crate) forces: &'a [f64],
    pub(crate) bias: Bias<'a>,
}

/// Which biases rows have.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Bias<'a> {
    /// Those of a moment.
    Moment,
    /// Those of a step along the velocity of its start.
    Start,
    /// Those of a step, at the velocity after it under the acceleration ã that is given.
    Ahead(&'a [f64]),
}

impl ConstraintColumns {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (model, zeros) = (simulator.model(), |n: usize| vec![Dual::from(0.0); n]);
        let (rows, nv) = (simulator.held_rows(), model.nv());
        Self {
            rows: ConstraintRows::new(rows, nv),
            start: zeros(model.nq()),
            tangent: zeros(nv),
            q: DVector::zeros(model.nq()),
            v: zeros(nv),
            next_v: zeros(nv),
            by_next_v: vec![0.0; rows * nv],
        }
    }

    /// Adds ∂y of the first rows, and −∂Jᵀ f to the columns.
    pub(crate) fn hold(
        &mut self,
        moment: &Moment<'_, f64, f64>,
        at: &Held<'_>,
        rows: &mut Blocks,
        columns: &mut Blocks,
    ) {
        if moment.simulator.constraints().is_empty() {
            return;
        }
        let nv = moment.model().nv();
        let start = self.start.iter_mut().zip(&moment.state.q);
        start.for_each(|(out, &x)| *out = Dual::from(x));
        for first in (0..2 * nv).step_by(CHUNK) {
            self.evaluate(moment, at, first);
            let directions = first..(2 * nv).min(first + CHUNK);
            for r in 0..self.rows.rows.len() {
                let y = self.row(r, at, moment.dt());
                let jacobian = &self.rows.jacobian[nv * r..nv * (r + 1)];
                for (direction, own) in directions.clone().zip(0..) {
                    *rows.at(r, direction) += y.eps[own];
                    for (k, j) in jacobian.iter().enumerate() {
                        *columns.at(k, direction) -= j.eps[own] * at.forces[r];
                    }
                }
            }
            if let Bias::Ahead(_) = at.bias {
                self.keep_by_next_v(directions, nv);
            }
        }
    }

    /// The rows on dual numbers, in directions of q and v from one on. A velocity after the step moves as that of its start.
    fn evaluate(&mut self, moment: &Moment<'_, f64, f64>, at: &Held<'_>, first: usize) {
        let (model, nv): (&Model, _) = (moment.model(), moment.model().nv());
        let moved = |direction: usize, x: f64| match direction.checked_sub(first) {
            Some(own) if own < CHUNK => Dual::variable(x, own),
            _ => Dual::from(x),
        };
        for k in 0..nv {
            self.tangent[k] = moved(k, 0.0);
            self.v[k] = moved(nv + k, moment.v()[k]);
        }
        let q = self.q.as_mut_slice();
        model.integrate_into(&self.start, &self.tangent, q);
        let constraints = moment.simulator.constraints();
        self.rows.evaluate(model, constraints, q, &self.v);
        if let Bias::Ahead(a) = at.bias {
            for ((next, &v), a) in self.next_v.iter_mut().zip(&self.v).zip(a) {
                *next = v + a * moment.dt();
            }
            let (rows, next_v) = (&mut self.rows, &self.next_v);
            rows.look_ahead(model, constraints, q, next_v);
        }
    }

    /// y of a row at fixed ã.
    fn row(&self, r: usize, at: &Held<'_>, dt: f64) -> Local {
        let (row, nv) = (&self.rows.rows[r], self.v.len());
        let bias = match at.bias {
            Bias::Moment => row.at_moment(dt),
            Bias::Start => row.over_step(row.bias, dt),
            Bias::Ahead(_) => row.over_step(self.rows.bias_after(r), dt),
        };
        let along = self.rows.jacobian[nv * r..nv * (r + 1)].iter().zip(at.seen);
        along.fold(bias, |sum, (&j, &a)| j.mul_add_real(a, sum))
    }

    /// y holds half of the bias after the step.
    fn keep_by_next_v(&mut self, directions: std::ops::Range<usize>, nv: usize) {
        for r in 0..self.rows.rows.len() {
            let bias = self.rows.bias_after(r);
            for (direction, own) in directions.clone().zip(0..) {
                if let Some(k) = direction.checked_sub(nv) {
                    self.by_next_v[nv * r + k] = 0.5 * bias.eps[own];
                }
            }
        }
    }
}

impl TermDerivatives for ConstraintColumns {
    type Term = Constraints<f64>;

    fn add_forces(&mut self, _: &LinearPoint<'_>, _: &Constraints<f64>, _: &mut ForceColumns) {}

    fn add_rows(
        &mut self,
        at: &LinearPoint<'_>,
        _: &Constraints<f64>,
        rows: &mut RowColumns,
        forces: &mut ForceColumns,
    ) {
        let Some(balance) = at.balance else { return };
        let held = Held {
            seen: &rows.seen,
            forces: balance.rows.forces(),
            bias: at.ahead.map_or(Bias::Moment, Bias::Ahead),
        };
        self.hold(at.moment, &held, &mut rows.columns, forces.columns());
    }
}

/// The gradient of the term; it needs no memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConstraintAdjoint;

impl ConstraintAdjoint {
    pub(super) fn new(_: &Simulator) -> Self {
        Self
    }
}

impl TermAdjoint for ConstraintAdjoint {
    type Term = Constraints<f64>;

    fn add_forces(
        &mut self,
        _: &AdjointPoint<'_>,
        _: &Constraints<f64>,
        _: &mut Sweep<f64>,
        _: &mut StepSlopes<'_>,
    ) {
    }
}
