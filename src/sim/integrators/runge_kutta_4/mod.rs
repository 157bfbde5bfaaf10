//! The classical method of fourth order, in tangent coordinates of the configuration.
//!
//! Tangent coordinates x = (offset from q, v) turn the step into one of an ordinary differential equation: each stage is a state at
//! q ⊕ offset, whose rates are the tangent rate of the offset, v̇, and ṁ of the contact state.
//!
//! # References
//! [Munthe-Kaas 1999].

mod pullback;
mod pushforward;

use std::ops::{Add, Div, Mul};

use nalgebra::DVector;

use super::AccelerationScratch;
use super::method::Step;
use crate::scalar::{MapEach, Over, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
pub(super) use pullback::Adjoint;
pub(super) use pushforward::Columns;

/// Weight of the rates of a stage in the step, and the fraction of the step up to which they lead to the next stage.
const STAGES: [(f64, f64); 4] = [
    (1.0 / 6.0, 0.5),
    (1.0 / 3.0, 0.5),
    (1.0 / 3.0, 1.0),
    (1.0 / 6.0, 0.0),
];

/// 1 + z + z²/2 + z³/6 + z⁴/24: the amplification of a linear motion with the rate z per step, a complex number or a matrix.
pub(crate) fn linear_factor<M>(z: &M, one: &M) -> M
where
    M: Clone + Add<Output = M> + Mul<Output = M> + Div<f64, Output = M>,
{
    let orders = (1..=4).rev().map(f64::from);
    orders.fold(one.clone(), |sum, k| one.clone() + z.clone() * sum / k)
}

/// Times for which the rates of a stage count: in the step, and up to the next stage, s.
fn times<P: Scalar>(simulator: &Simulator<P>, stage: usize) -> [P; 2] {
    let (weight, fraction) = STAGES[stage];
    [weight, fraction].map_each(|x| simulator.time_step() * x)
}

/// Working memory: a stage, its rates, and their sums.
#[derive(Clone, Debug)]
pub(crate) struct Memory<T: Scalar> {
    /// The state at a stage.
    state: State<T>,
    /// The stage's configuration as a tangent at the start of the step.
    offset: DVector<T>,
    /// Rate of the offset.
    rate: DVector<T>,
    /// Weighted sums of the stages.
    sum_rate: DVector<T>,
    sum_a: DVector<T>,
    sum_contact: DVector<T>,
}

impl<T: Scalar> Step<T> for Memory<T> {
    fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let zeros = || DVector::zeros(simulator.model().nv());
        Self {
            state: simulator.neutral_state(),
            offset: zeros(),
            rate: zeros(),
            sum_rate: zeros(),
            sum_a: zeros(),
            sum_contact: DVector::zeros(simulator.n_contact()),
        }
    }

    fn step<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        found: &mut AccelerationScratch<T>,
        next: &mut State<T>,
    ) where
        T: Over<P>,
    {
        self.start(state);
        for stage in 0..STAGES.len() {
            self.evaluate(simulator, u, found);
            self.move_on(simulator, state, found, stage);
        }
        self.finish(simulator, state, next);
    }
}

impl<T: Scalar> Memory<T> {
    /// The first stage: the start of the step.
    fn start(&mut self, state: &State<T>) {
        self.state.q.copy_from(&state.q);
        self.state.v.copy_from(&state.v);
        self.state.contact.copy_from(&state.contact);
        self.offset.fill(T::zero());
        self.sum_rate.fill(T::zero());
        self.sum_a.fill(T::zero());
        self.sum_contact.fill(T::zero());
    }

    /// The rates at the stage: of the offset here, of velocity and contact in the scratch.
    fn evaluate<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        u: &[T],
        found: &mut AccelerationScratch<T>,
    ) where
        T: Over<P>,
    {
        let (offset, v) = (self.offset.as_slice(), self.state.v.as_slice());
        let rate = self.rate.as_mut_slice();
        simulator.model().tangent_rate_into(offset, v, rate);
        simulator.accelerate(&EvaluationPoint::instant(simulator, &self.state, u), found);
    }

    /// Adds the rates to their sums, and forms the next stage: the start, moved by the rates for some time.
    fn move_on<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        start: &State<T>,
        found: &AccelerationScratch<T>,
        stage: usize,
    ) where
        T: Over<P>,
    {
        let [weight, time] = times(simulator, stage);
        add_scaled(&mut self.sum_rate, self.rate.as_slice(), weight);
        add_scaled(&mut self.sum_a, &found.a, weight);
        let rates = self.sum_contact.iter_mut().zip(found.terms.contact.rates());
        rates.for_each(|(sum, rate)| *sum += rate * weight);
        let rates = self.offset.iter_mut().zip(&self.rate);
        rates.for_each(|(offset, &rate)| *offset = rate * time);
        let (q, offset) = (start.q.as_slice(), self.offset.as_slice());
        let stage = &mut self.state;
        let model = simulator.model();
        model.integrate_into(q, offset, stage.q.as_mut_slice());
        stage.v.copy_from(&start.v);
        add_scaled(&mut stage.v, &found.a, time);
        let contact = stage.contact.iter_mut().zip(&start.contact);
        for ((stage, &m), rate) in contact.zip(found.terms.contact.rates()) {
            *stage = m + rate * time;
        }
    }

    /// The state after the step.
    fn finish<P: Scalar>(&self, simulator: &Simulator<P>, start: &State<T>, next: &mut State<T>) {
        let (q, sum) = (start.q.as_slice(), self.sum_rate.as_slice());
        let model = simulator.model();
        model.integrate_into(q, sum, next.q.as_mut_slice());
        next.v.copy_from(&start.v);
        add_scaled(&mut next.v, self.sum_a.as_slice(), 1.0);
        next.contact.copy_from(&start.contact);
        add_scaled(&mut next.contact, self.sum_contact.as_slice(), 1.0);
    }
}

fn add_scaled<D: Scalar, T: Over<D>>(out: &mut DVector<T>, x: &[T], s: D) {
    out.iter_mut().zip(x).for_each(|(out, &x)| *out += x * s);
}
