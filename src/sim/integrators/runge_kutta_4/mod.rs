//! The classical method of fourth order, in tangent coordinates of the configuration.
//!
//! Tangent coordinates x = (offset from q, v) turn the step into one of an ordinary differential equation: each stage is a state at
//! q ⊕ offset, whose rates are the tangent rate of the offset, v̇, and ṁ of the state of contact.
//!
//! # References
//! [Munthe-Kaas 1999].

mod pullback;
mod pushforward;

use nalgebra::DVector;

use super::acceleration::AccelerationScratch;
use crate::scalar::{Over, Scalar};
use crate::sim::moment::Moment;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
pub(super) use pullback::StageAdjoint;
pub(crate) use pushforward::StageColumns;

/// Weight of the rates of a stage in the step, and the fraction of the step up to which they lead to the next stage.
const STAGES: [(f64, f64); 4] = [
    (1.0 / 6.0, 0.5),
    (1.0 / 3.0, 0.5),
    (1.0 / 3.0, 1.0),
    (1.0 / 6.0, 0.0),
];

/// Working memory: a stage, its rates, and their sums.
#[derive(Clone, Debug)]
pub(crate) struct Stages<T: Scalar> {
    /// The state at a stage.
    pub(crate) state: State<T>,
    /// The stage's configuration as a tangent at the start of the step.
    pub(crate) offset: DVector<T>,
    /// Rate of the offset.
    pub(crate) rate: DVector<T>,
    /// Weighted sums of the stages.
    pub(crate) sum_rate: DVector<T>,
    sum_a: DVector<T>,
    sum_contact: DVector<T>,
}

impl<T: Scalar> Stages<T> {
    pub(crate) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
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

    /// The first stage: the start of the step.
    pub(crate) fn start(&mut self, state: &State<T>) {
        self.state.q.copy_from(&state.q);
        self.state.v.copy_from(&state.v);
        self.state.contact.copy_from(&state.contact);
        self.offset.fill(T::zero());
        self.sum_rate.fill(T::zero());
        self.sum_a.fill(T::zero());
        self.sum_contact.fill(T::zero());
    }

    /// The rates at the stage: of the offset here, of velocity and contact in the scratch.
    pub(crate) fn evaluate<P: Scalar>(
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
        simulator.accelerate(&Moment::instant(simulator, &self.state, u), found);
    }

    /// Adds the rates to their sums, with the time for which they count.
    pub(crate) fn add<D: Scalar>(&mut self, found: &AccelerationScratch<T>, time: D)
    where
        T: Over<D>,
    {
        add_scaled(&mut self.sum_rate, self.rate.as_slice(), time);
        add_scaled(&mut self.sum_a, &found.a, time);
        let rates = self.sum_contact.iter_mut().zip(found.terms.contact.rates());
        rates.for_each(|(sum, rate)| *sum += rate * time);
    }

    /// The next stage: the start, moved on by the rates for some time.
    pub(crate) fn move_on<P: Scalar, D: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        start: &State<T>,
        found: &AccelerationScratch<T>,
        time: D,
    ) where
        T: Over<D>,
    {
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
    pub(crate) fn finish<P: Scalar>(
        &self,
        simulator: &Simulator<P>,
        start: &State<T>,
        next: &mut State<T>,
    ) {
        let (q, sum) = (start.q.as_slice(), self.sum_rate.as_slice());
        let model = simulator.model();
        model.integrate_into(q, sum, next.q.as_mut_slice());
        next.v.copy_from(&start.v);
        add_scaled(&mut next.v, self.sum_a.as_slice(), 1.0);
        next.contact.copy_from(&start.contact);
        add_scaled(&mut next.contact, self.sum_contact.as_slice(), 1.0);
    }
}

/// One step with the input `u` held.
pub(in crate::sim) fn step<P: Scalar, T: Over<P>>(
    simulator: &Simulator<P>,
    start: &State<T>,
    u: &[T],
    found: &mut AccelerationScratch<T>,
    stages: &mut Stages<T>,
    next: &mut State<T>,
) {
    let dt = simulator.time_step();
    stages.start(start);
    for (weight, fraction) in STAGES {
        stages.evaluate(simulator, u, found);
        stages.add(found, dt * weight);
        stages.move_on(simulator, start, found, dt * fraction);
    }
    stages.finish(simulator, start, next);
}

fn add_scaled<D: Scalar, T: Over<D>>(out: &mut DVector<T>, x: &[T], s: D) {
    out.iter_mut().zip(x).for_each(|(out, &x)| *out += x * s);
}
