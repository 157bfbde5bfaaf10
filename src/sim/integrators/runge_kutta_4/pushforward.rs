//! Jacobians of a Runge–Kutta step: the chain rule over its stages.
//!
//! A stage is the state x = (q ⊕ c Δt q̇, v + c Δt v̇, m + c Δt ṁ) with the rates of the stage before it, and has rates of its own. Those of v and m
//! have the Jacobians of the acceleration at an instant; that of the offset from q, and the way from an offset to the tangent space at the
//! stage, belong to each joint alone.

use nalgebra::DMatrix;

use super::{Memory, STAGES, times};
use crate::dynamics::{Blocks, Calls};
use crate::joint::MAX_NV;
use crate::model::{Body, Model};
use crate::scalar::{Differentiable, Scalar, is_nothing};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::acceleration::{AccelerationColumns, AccelerationScratch};
use crate::sim::integrators::joint_tangents::{JointTangent, integrated, tangent_rate};
use crate::sim::integrators::method::{Pushforward, Step, StepColumns, StepPoint};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// Working memory: derivatives in (q, v, m, u) of the step's start, for each number a row.
#[derive(Clone, Debug)]
pub(crate) struct Columns<T: Differentiable> {
    stages: Memory<T>,
    found: AccelerationScratch<T>,
    next: State<T>,
    acceleration: AccelerationColumns<T>,
    /// Of the stage: its configuration in its own tangent space, velocity, contact state.
    stage: [DMatrix<T>; 3],
    /// Of its offset from the start.
    offset: DMatrix<T>,
    /// Of the rates of offset, velocity, contact state, and of their weighted sums.
    rates: [DMatrix<T>; 3],
    sums: [DMatrix<T>; 3],
    /// Jacobian of an acceleration or of rates of contact in the stage's own (q, v, m, u).
    local: DMatrix<T>,
}

impl<T: Differentiable> Pushforward<T> for Columns<T> {
    fn new(simulator: &Simulator, calls: Calls) -> Self {
        let (nv, contact) = (simulator.model().nv(), simulator.n_contact());
        let width = simulator.n_tangent() + simulator.nu();
        let parts = || [nv, nv, contact].map(|rows| DMatrix::zeros(rows, width));
        Self {
            stages: Memory::new(simulator),
            found: AccelerationScratch::new(simulator, calls),
            next: simulator.neutral_state(),
            acceleration: AccelerationColumns::new(simulator, Calls::Many),
            stage: parts(),
            offset: DMatrix::zeros(nv, width),
            rates: parts(),
            sums: parts(),
            local: DMatrix::zeros(nv.max(contact), width),
        }
    }

    fn linearize(
        &mut self,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        out: &mut StepColumns<'_, T>,
    ) {
        self.stages.start(at.state);
        self.start(simulator.model());
        for stage in 0..STAGES.len() {
            self.stages.evaluate(simulator, at.u, &mut self.found);
            self.differentiate(simulator, at.u);
            (self.stages).move_on(simulator, at.state, &self.found, stage);
            self.move_on(simulator.model(), at.state, times(simulator, stage));
        }
        self.stages.finish(simulator, at.state, &mut self.next);
        self.finish(simulator.model(), at.state, out);
    }
}

impl<T: Differentiable> Columns<T> {
    /// The first stage is the start of the step.
    fn start(&mut self, model: &Model) {
        for m in self.sums.iter_mut().chain([&mut self.offset]) {
            m.fill(T::zero());
        }
        for (k, m) in self.stage.iter_mut().enumerate() {
            m.fill(T::zero());
            add_identity(m, k * model.nv());
        }
    }

    /// The rates at the stage.
    fn differentiate(&mut self, simulator: &Simulator, u: &[T]) {
        let (model, v) = (simulator.model(), &self.stages.state.v);
        let offset = self.stages.offset.as_slice();
        let [of_offset, of_v, of_contact] = &mut self.rates;
        for body in model.independent() {
            let of_rate = tangent_rate(body, offset, v.as_slice());
            clear_rows(body, of_offset);
            add_rows(body, &of_rate, Part::First, &self.offset, of_offset);
            add_rows(body, &of_rate, Part::Second, &self.stage[1], of_offset);
        }
        let stage = EvaluationPoint::instant(simulator, &self.stages.state, u);
        self.acceleration.linearize(&stage, &mut self.found);
        copy(self.acceleration.minus_a(), -1.0, &mut self.local);
        chain(&self.local, &self.stage, of_v);
        copy(self.acceleration.bristles(), 1.0, &mut self.local);
        chain(&self.local, &self.stage, of_contact);
    }

    /// Adds the rates to their sums, and forms the next stage.
    fn move_on(&mut self, model: &Model, start: &State<T>, [weight, time]: [f64; 2]) {
        for (sum, rate) in self.sums.iter_mut().zip(&self.rates) {
            let entries = sum.iter_mut().zip(rate);
            entries.for_each(|(sum, &x)| *sum += x * weight);
        }
        scaled_into(&self.rates[0], time, &mut self.offset);
        let (q, offset) = (self.stages.state.q.as_slice(), &self.stages.offset);
        let tangent = (offset.as_slice(), &self.offset);
        integrate_columns(model, start, tangent, q, &mut self.stage[0]);
        for k in 1..3 {
            scaled_into(&self.rates[k], time, &mut self.stage[k]);
            add_identity(&mut self.stage[k], k * model.nv());
        }
    }

    /// The state after the step.
    fn finish(&mut self, model: &Model, start: &State<T>, out: &mut StepColumns<'_, T>) {
        let (sum, end) = (&self.stages.sum_rate, self.next.q.as_slice());
        let tangent = (sum.as_slice(), &self.sums[0]);
        integrate_columns(model, start, tangent, end, &mut self.stage[0]);
        for k in 1..3 {
            add_identity(&mut self.sums[k], k * model.nv());
        }
        let (n, [_, v, contact]) = (out.a.ncols(), &self.sums);
        for (k, part) in [&self.stage[0], v, contact].into_iter().enumerate() {
            let (first, rows) = (k * model.nv(), part.nrows());
            out.a.rows_mut(first, rows).copy_from(&part.columns(0, n));
            let inputs = part.columns(n, part.ncols() - n);
            out.b.rows_mut(first, rows).copy_from(&inputs);
        }
    }
}

/// Adds 1 to each row in a column of its own, from one on.
fn add_identity<T: Scalar>(m: &mut DMatrix<T>, first: usize) {
    (0..m.nrows()).for_each(|k| m[(k, first + k)] += T::one());
}

fn scaled_into<T: Scalar>(x: &DMatrix<T>, s: f64, out: &mut DMatrix<T>) {
    out.iter_mut().zip(x).for_each(|(out, &x)| *out = x * s);
}

fn copy<T: Scalar>(columns: &Blocks<T>, sign: f64, out: &mut DMatrix<T>) {
    let rows = out.nrows().max(1);
    let outputs = out.as_mut_slice().chunks_exact_mut(rows);
    columns.copy_columns_to(outputs, |x| x * sign);
}

/// D = (∂/∂q, ∂/∂v, ∂/∂m) applied to how these move, and ∂/∂u, of as many rows as there are. A product of matrices that does not allocate.
fn chain<T: Scalar>(local: &DMatrix<T>, motions: &[DMatrix<T>; 3], out: &mut DMatrix<T>) {
    let rows = out.nrows();
    out.fill(T::zero());
    let mut first = 0;
    if rows == 0 {
        return;
    }
    // It may have additional rows.
    let (height, local) = (local.nrows(), local.as_slice());
    let by = |k: usize| &local[height * k..height * k + rows];
    for motion in motions {
        let inner = motion.nrows();
        if inner == 0 {
            continue;
        }
        let columns = out.as_mut_slice().chunks_exact_mut(rows);
        for (out, motion) in columns.zip(motion.as_slice().chunks_exact(inner)) {
            for (k, &x) in motion.iter().enumerate() {
                if !is_nothing(&x) {
                    let by = by(first + k);
                    for i in 0..rows {
                        out[i] += x * by[i];
                    }
                }
            }
        }
        first += inner;
    }
    let columns = out.as_mut_slice().chunks_exact_mut(rows);
    for (k, out) in columns.enumerate().skip(first) {
        let by = by(k);
        for i in 0..rows {
            out[i] += by[i];
        }
    }
}

/// The first or the second of the two tangents in which that of a joint is differentiated.
#[derive(Clone, Copy)]
enum Part {
    First = 0,
    Second = MAX_NV as isize,
}

fn clear_rows<T: Scalar>(body: &Body<f64>, out: &mut DMatrix<T>) {
    out.rows_mut(body.v, body.joint.nv()).fill(T::zero());
}

/// Adds to the rows of one joint its derivatives in one of the two tangents, applied to how that moves.
fn add_rows<T: Scalar>(
    body: &Body<f64>,
    x: &JointTangent<T>,
    part: Part,
    of: &DMatrix<T>,
    out: &mut DMatrix<T>,
) {
    let nv = body.joint.nv();
    for (k, x) in x.iter().enumerate().take(nv) {
        let slopes = &x.eps[part as usize..][..nv];
        for column in 0..out.ncols() {
            let own = of.view((body.v, column), (nv, 1));
            let products = slopes.iter().zip(&own);
            let sum = products.fold(T::zero(), |sum, (&by, &x)| sum + by * x);
            out[(body.v + k, column)] += sum;
        }
    }
}

/// Adds to the rows of one joint its derivatives in the first tangent, which is that of the step's start.
fn add_own<T: Scalar>(body: &Body<f64>, x: &JointTangent<T>, out: &mut DMatrix<T>) {
    let nv = body.joint.nv();
    for (k, x) in x.iter().enumerate().take(nv) {
        for (l, &slope) in x.eps[..nv].iter().enumerate() {
            out[(body.v + k, body.v + l)] += slope;
        }
    }
}

/// [`integrated`] applied to how the offset moves.
fn integrate_columns<T: Scalar>(
    model: &Model,
    start: &State<T>,
    (offset, of_offset): (&[T], &DMatrix<T>),
    end: &[T],
    out: &mut DMatrix<T>,
) {
    for body in model.independent() {
        let x = integrated(body, start.q.as_slice(), offset, end);
        clear_rows(body, out);
        add_own(body, &x, out);
        add_rows(body, &x, Part::Second, of_offset, out);
    }
}
