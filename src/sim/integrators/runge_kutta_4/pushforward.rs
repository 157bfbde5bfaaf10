//! Jacobians of a step of Runge and Kutta: the chain rule over its stages.
//!
//! A stage is the state x = (q ⊕ c Δt q̇, v + c Δt v̇, m + c Δt ṁ) with the rates of the stage before it, and has rates of its own. Those of v and m
//! have the Jacobians of the acceleration at a moment; that of the offset from q, and the way from an offset to the tangent space at the
//! stage, belong to each joint alone.

use nalgebra::DMatrix;

use super::{Memory, STAGES, times};
use crate::dynamics::{Blocks, Calls};
use crate::joint::MAX_NV;
use crate::model::{Body, Model};
use crate::scalar::{Differentiable, Scalar, is_nothing};
use crate::sim::integrators::acceleration::{AccelerationColumns, AccelerationScratch};
use crate::sim::integrators::joint_tangents::{JointTangent, integrated, tangent_rate};
use crate::sim::integrators::method::{Pushforward, Step, StepColumns, StepPoint};
use crate::sim::moment::Moment;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// Working memory of [`linearize`](Self::linearize): derivatives in (q, v, m, u) of the step's start, `nv` rows each but for contact.
#[derive(Clone, Debug)]
pub(crate) struct Columns<T: Differentiable> {
    stages: Memory<T>,
    found: AccelerationScratch<T>,
    next: State<T>,
    acceleration: AccelerationColumns<T>,
    /// Of the stage: its configuration in its own tangent space, the offset from the start, velocity, state of contact.
    q: DMatrix<T>,
    offset: DMatrix<T>,
    v: DMatrix<T>,
    contact: DMatrix<T>,
    /// Of the rates.
    rate: DMatrix<T>,
    a: DMatrix<T>,
    contact_rate: DMatrix<T>,
    /// Of their weighted sums.
    sum_rate: DMatrix<T>,
    sum_a: DMatrix<T>,
    sum_contact: DMatrix<T>,
    /// Jacobian of an acceleration or of rates of contact in the stage's own (q, v, m, u).
    local: DMatrix<T>,
}

impl<T: Differentiable> Pushforward<T> for Columns<T> {
    fn new(simulator: &Simulator, calls: Calls) -> Self {
        let (nv, contact) = (simulator.model().nv(), simulator.n_contact());
        let width = simulator.n_tangent() + simulator.nu();
        let zeros = || DMatrix::zeros(nv, width);
        let of_contact = || DMatrix::zeros(contact, width);
        Self {
            stages: Memory::new(simulator),
            found: AccelerationScratch::new(simulator, calls),
            next: simulator.neutral_state(),
            acceleration: AccelerationColumns::new(simulator, Calls::Many),
            q: zeros(),
            offset: zeros(),
            v: zeros(),
            contact: of_contact(),
            rate: zeros(),
            a: zeros(),
            contact_rate: of_contact(),
            sum_rate: zeros(),
            sum_a: zeros(),
            sum_contact: of_contact(),
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
        self.start(simulator);
        for stage in 0..STAGES.len() {
            self.stages.evaluate(simulator, at.u, &mut self.found);
            self.differentiate(simulator, at.u);
            (self.stages).move_on(simulator, at.state, &self.found, stage);
            self.move_on(simulator, at.state, stage);
        }
        self.stages.finish(simulator, at.state, &mut self.next);
        self.finish(simulator, at.state, out);
    }
}

impl<T: Differentiable> Columns<T> {
    /// The first stage is the start of the step.
    fn start(&mut self, simulator: &Simulator) {
        let nv = simulator.model().nv();
        for m in [&mut self.offset, &mut self.sum_rate, &mut self.sum_a] {
            m.fill(T::zero());
        }
        self.sum_contact.fill(T::zero());
        let firsts = [
            (&mut self.q, 0),
            (&mut self.v, nv),
            (&mut self.contact, 2 * nv),
        ];
        for (m, first) in firsts {
            set_identity(m, first);
        }
    }

    /// The rates at the stage.
    fn differentiate(&mut self, simulator: &Simulator, u: &[T]) {
        let (model, v) = (simulator.model(), &self.stages.state.v);
        let offset = self.stages.offset.as_slice();
        for body in model.independent() {
            let of_rate = tangent_rate(body, offset, v.as_slice());
            clear_rows(body, &mut self.rate);
            add_rows(body, &of_rate, Part::First, &self.offset, &mut self.rate);
            add_rows(body, &of_rate, Part::Second, &self.v, &mut self.rate);
        }
        let stage = Moment::instant(simulator, &self.stages.state, u);
        self.acceleration.linearize(&stage, &mut self.found);
        copy(self.acceleration.minus_a(), -1.0, &mut self.local);
        let motions = [&self.q, &self.v, &self.contact];
        chain(&self.local, motions, &mut self.a);
        copy(self.acceleration.bristles(), 1.0, &mut self.local);
        chain(&self.local, motions, &mut self.contact_rate);
    }

    /// Adds the rates to their sums, and goes on to the next stage, as the stages do.
    fn move_on(&mut self, simulator: &Simulator, start: &State<T>, stage: usize) {
        let [weight, time] = times(simulator, stage);
        add_scaled(&mut self.sum_rate, &self.rate, weight);
        add_scaled(&mut self.sum_a, &self.a, weight);
        add_scaled(&mut self.sum_contact, &self.contact_rate, weight);
        let (model, nv) = (simulator.model(), simulator.model().nv());
        scaled_into(&self.rate, time, &mut self.offset);
        let (stage, offset) = (
            self.stages.state.q.as_slice(),
            self.stages.offset.as_slice(),
        );
        integrate_columns(model, start, offset, stage, &self.offset, &mut self.q);
        scaled_into(&self.a, time, &mut self.v);
        add_identity(&mut self.v, nv);
        scaled_into(&self.contact_rate, time, &mut self.contact);
        add_identity(&mut self.contact, 2 * nv);
    }

    /// The state after the step.
    fn finish(&mut self, simulator: &Simulator, start: &State<T>, out: &mut StepColumns<'_, T>) {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let (sum, end) = (self.stages.sum_rate.as_slice(), self.next.q.as_slice());
        integrate_columns(model, start, sum, end, &self.sum_rate, &mut self.q);
        add_identity(&mut self.sum_a, nv);
        add_identity(&mut self.sum_contact, 2 * nv);
        let parts = [(0, &self.q), (nv, &self.sum_a), (2 * nv, &self.sum_contact)];
        let n = out.a.ncols();
        for (first, part) in parts {
            let rows = part.nrows();
            out.a.rows_mut(first, rows).copy_from(&part.columns(0, n));
            let inputs = part.columns(n, part.ncols() - n);
            out.b.rows_mut(first, rows).copy_from(&inputs);
        }
    }
}

fn set_identity<T: Scalar>(m: &mut DMatrix<T>, first: usize) {
    m.fill(T::zero());
    add_identity(m, first);
}

/// Adds 1 to each row in a column of its own, from one on.
fn add_identity<T: Scalar>(m: &mut DMatrix<T>, first: usize) {
    (0..m.nrows()).for_each(|k| m[(k, first + k)] += T::one());
}

fn add_scaled<T: Scalar>(sum: &mut DMatrix<T>, x: &DMatrix<T>, s: f64) {
    sum.iter_mut().zip(x).for_each(|(sum, &x)| *sum += x * s);
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
fn chain<T: Scalar>(local: &DMatrix<T>, motions: [&DMatrix<T>; 3], out: &mut DMatrix<T>) {
    let rows = out.nrows();
    out.fill(T::zero());
    let mut first = 0;
    if rows == 0 {
        return;
    }
    // It may have rows that are not asked for.
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
    offset: &[T],
    end: &[T],
    of_offset: &DMatrix<T>,
    out: &mut DMatrix<T>,
) {
    for body in model.independent() {
        let x = integrated(body, start.q.as_slice(), offset, end);
        clear_rows(body, out);
        add_own(body, &x, out);
        add_rows(body, &x, Part::Second, of_offset, out);
    }
}
