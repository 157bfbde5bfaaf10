//! Contribution of kinematic constraints to the Jacobians of a step: their rows on dual numbers, some directions at a time.

use nalgebra::DVector;

use crate::autodiff::{CHUNK, Dual};
use crate::constraint::ConstraintRows;
use crate::dynamics::Blocks;
use crate::scalar::Scalar;
use crate::sim::{Simulator, State};

type Local = Dual<f64, CHUNK>;

/// Working memory for constraints.
#[derive(Clone, Debug)]
pub(super) struct ConstraintColumns {
    rows: ConstraintRows<Local>,
    start: Vec<Local>,
    tangent: Vec<Local>,
    q: DVector<Local>,
    v: Vec<Local>,
    next_v: Vec<Local>,
    /// Derivative ∂y/∂v⁺ in the velocity after a step, row after row.
    pub(super) by_next_v: Vec<f64>,
}

/// Where rows y are differentiated, at fixed forces and accelerations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held<'a> {
    /// ã.
    pub(super) seen: &'a [f64],
    /// Of the rows.
    pub(super) forces: &'a [f64],
    pub(super) bias: Bias<'a>,
}

/// Which biases rows have.
#[derive(Clone, Copy, Debug)]
pub(super) enum Bias<'a> {
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
    pub(super) fn hold(
        &mut self,
        (simulator, state): (&Simulator, &State),
        at: &Held<'_>,
        rows: &mut Blocks,
        columns: &mut Blocks,
    ) {
        if simulator.constraints().is_empty() {
            return;
        }
        let nv = simulator.model().nv();
        let start = self.start.iter_mut().zip(&state.q);
        start.for_each(|(out, &x)| *out = Dual::from(x));
        for first in (0..2 * nv).step_by(CHUNK) {
            self.evaluate((simulator, state), at, first);
            let directions = first..(2 * nv).min(first + CHUNK);
            for r in 0..self.rows.rows.len() {
                let y = self.row(r, at, simulator.time_step());
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
    fn evaluate(&mut self, (simulator, state): (&Simulator, &State), at: &Held<'_>, first: usize) {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let moved = |direction: usize, x: f64| match direction.checked_sub(first) {
            Some(own) if own < CHUNK => Dual::variable(x, own),
            _ => Dual::from(x),
        };
        for k in 0..nv {
            self.tangent[k] = moved(k, 0.0);
            self.v[k] = moved(nv + k, state.v[k]);
        }
        let q = self.q.as_mut_slice();
        model.integrate_into(&self.start, &self.tangent, q);
        let constraints = simulator.constraints();
        self.rows.evaluate(model, constraints, (q, &self.v));
        if let Bias::Ahead(a) = at.bias {
            for ((next, &v), a) in self.next_v.iter_mut().zip(&self.v).zip(a) {
                *next = v + a * simulator.time_step();
            }
            self.rows.look_ahead(model, constraints, (q, &self.next_v));
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
