//! Rows of constraints on dual numbers, some directions of configuration and velocity at a time.

use nalgebra::DVector;

use crate::autodiff::CHUNK;
use crate::constraint::ConstraintRows;
use crate::model::Model;
use crate::scalar::{Dual, Scalar};
use crate::sim::moment::Moment;
use crate::sim::simulator::Simulator;

/// Point at which rows y are differentiated, at fixed forces and accelerations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held<'a, T = f64> {
    /// ã.
    pub(crate) seen: &'a [T],
    /// Of the rows.
    pub(crate) forces: &'a [T],
    pub(crate) bias: Bias<'a, T>,
}

/// Which biases rows have.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Bias<'a, T = f64> {
    /// Those of a moment.
    Moment,
    /// Those of a step along the velocity of its start.
    Start,
    /// Those of a step, at the velocity after it under the acceleration ã that is given.
    Ahead(&'a [T]),
}

/// A number with its derivatives in some directions.
pub(super) type Local<T> = Dual<T, CHUNK>;

/// The rows, and the numbers on which they are evaluated.
#[derive(Clone, Debug)]
pub(super) struct HeldRows<T: Scalar> {
    rows: ConstraintRows<Local<T>>,
    start: Vec<Local<T>>,
    tangent: Vec<Local<T>>,
    q: DVector<Local<T>>,
    v: Vec<Local<T>>,
    next_v: Vec<Local<T>>,
}

impl<T: Scalar> HeldRows<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (model, zeros) = (simulator.model(), |n: usize| vec![Dual::from(0.0); n]);
        let nv = model.nv();
        Self {
            rows: ConstraintRows::new(simulator.held_rows(), nv),
            start: zeros(model.nq()),
            tangent: zeros(nv),
            q: DVector::from_element(model.nq(), Dual::from(0.0)),
            v: zeros(nv),
            next_v: zeros(nv),
        }
    }

    /// Number of rows of the last evaluation.
    pub(super) fn count(&self) -> usize {
        self.rows.rows.len()
    }

    /// Takes over the configuration.
    pub(super) fn start(&mut self, moment: &Moment<'_, f64, T>) {
        let start = self.start.iter_mut().zip(&moment.state.q);
        start.for_each(|(out, &x)| *out = Dual::constant_of(x));
    }

    /// Evaluates the rows in directions of q and v from one on. A velocity after the step moves as that of its start.
    pub(super) fn evaluate(&mut self, moment: &Moment<'_, f64, T>, at: &Held<'_, T>, first: usize) {
        let (model, nv): (&Model, _) = (moment.model(), moment.model().nv());
        let moved = |direction: usize, x: T| match direction.checked_sub(first) {
            Some(own) if own < CHUNK => Dual::variable(x, own),
            _ => Dual::constant_of(x),
        };
        for k in 0..nv {
            self.tangent[k] = moved(k, T::zero());
            self.v[k] = moved(nv + k, moment.v()[k]);
        }
        let q = self.q.as_mut_slice();
        model.integrate_into(&self.start, &self.tangent, q);
        let constraints = moment.simulator.constraints();
        self.rows.evaluate(model, constraints, q, &self.v);
        if let Bias::Ahead(a) = at.bias {
            for ((next, &v), &a) in self.next_v.iter_mut().zip(&self.v).zip(a) {
                *next = Dual::new(v.re + a * moment.dt(), v.eps);
            }
            let (rows, next_v) = (&mut self.rows, &self.next_v);
            rows.look_ahead(model, constraints, q, next_v);
        }
    }

    /// J of a row.
    pub(super) fn jacobian(&self, r: usize) -> &[Local<T>] {
        let nv = self.v.len();
        &self.rows.jacobian[nv * r..nv * (r + 1)]
    }

    /// y of a row at fixed ã.
    pub(super) fn row(&self, r: usize, at: &Held<'_, T>, dt: f64) -> Local<T> {
        let row = &self.rows.rows[r];
        let bias = match at.bias {
            Bias::Moment => row.at_moment(dt),
            Bias::Start => row.over_step(row.bias, dt),
            Bias::Ahead(_) => row.over_step(self.rows.bias_after(r), dt),
        };
        self.along(r, at.seen, bias)
    }

    /// J of a row times an acceleration, and something beside it.
    pub(super) fn along(&self, r: usize, a: &[T], beside: Local<T>) -> Local<T> {
        let along = self.jacobian(r).iter().zip(a);
        along.fold(beside, |sum, (&j, &a)| {
            j.zip(sum, |j, sum| j.mul_add(a, sum))
        })
    }

    /// Hands what y of a row holds of the velocity after the step, half of the bias there, to `each(coordinate, slope)`.
    pub(super) fn each_slope_by_next_v(
        &self,
        r: usize,
        directions: std::ops::Range<usize>,
        mut each: impl FnMut(usize, T),
    ) {
        let bias = self.rows.bias_after(r);
        for (direction, own) in directions.zip(0..) {
            if let Some(k) = direction.checked_sub(self.v.len()) {
                each(k, bias.eps[own] * 0.5);
            }
        }
    }
}
