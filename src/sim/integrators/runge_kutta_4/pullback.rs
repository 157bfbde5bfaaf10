//! Gradient of a Runge–Kutta step: its stages backwards.

use super::{Memory, STAGES, times};
use crate::dynamics::Calls;
use crate::linalg::product::{add_scaled, dot};
use crate::scalar::Scalar;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::acceleration::{
    AccelerationAdjoint, AccelerationScratch, AccelerationWeights,
};
use crate::sim::integrators::joint_tangents::{add_integrated, add_tangent_rate};
use crate::sim::integrators::method::{Pullback, Step, StepPoint};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::StepGradientSum;

/// A stage that has been evaluated.
#[derive(Clone, Debug)]
struct Evaluated<T: Scalar> {
    state: State<T>,
    /// Its configuration as a tangent at the start of the step, and the rate of that.
    offset: Vec<T>,
    rate: Vec<T>,
    found: AccelerationScratch<T>,
}

/// Working memory of [`add_gradient`](Self::add_gradient).
#[derive(Clone, Debug)]
pub(crate) struct Adjoint<T: Scalar> {
    stages: Memory<T>,
    evaluated: Vec<Evaluated<T>>,
    next: State<T>,
    /// Weights of the stage: of its configuration in its own tangent space; of its offset from the start, velocity, contact state.
    by_q: Vec<T>,
    by_stage: [Vec<T>; 3],
    /// Of the rates of these.
    by_rates: [Vec<T>; 3],
    /// Of the weighted sum of the rates of the offset.
    by_sum: Vec<T>,
    acceleration: AccelerationAdjoint<T>,
}

impl<T: Scalar> Pullback<T> for Adjoint<T> {
    fn new(simulator: &Simulator, calls: Calls) -> Self {
        let (nv, n_contact) = (simulator.model().nv(), simulator.n_contact());
        let (zeros, of_contact) = (|| vec![T::zero(); nv], || vec![T::zero(); n_contact]);
        let evaluated = STAGES.map(|_| Evaluated {
            state: simulator.neutral_state(),
            offset: zeros(),
            rate: zeros(),
            found: AccelerationScratch::new(simulator, calls),
        });
        Self {
            stages: Memory::new(simulator),
            evaluated: evaluated.into(),
            next: simulator.neutral_state(),
            by_q: zeros(),
            by_stage: [zeros(), zeros(), of_contact()],
            by_rates: [zeros(), zeros(), of_contact()],
            by_sum: zeros(),
            acceleration: AccelerationAdjoint::new(simulator, calls),
        }
    }

    fn add_gradient(
        &mut self,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        adjoint: &[T],
        out: &mut StepGradientSum<'_, T>,
    ) {
        self.evaluate(simulator, at);
        let (model, nv, q) = (simulator.model(), out.v.len(), at.state.q.as_slice());
        let (by_q, rest) = adjoint.split_at(nv);
        let (by_v, by_contact) = rest.split_at(nv);
        add_scaled(out.v, by_v, T::one());
        add_scaled(out.contact, by_contact, T::one());
        // q⁺ = q ⊕ Σ
        self.by_sum.fill(T::zero());
        let sum = self.stages.sum_rate.as_slice();
        let (end, by_sum) = (self.next.q.as_slice(), &mut self.by_sum);
        add_integrated(model, q, sum, end, by_q, out.q, by_sum);
        self.by_stage.iter_mut().for_each(|x| x.fill(T::zero()));
        for stage in (0..STAGES.len()).rev() {
            // Weights of the rates in the sums and in the next stage.
            let [weight, time] = times(simulator, stage);
            let sums = [&self.by_sum[..], by_v, by_contact];
            for ((rate, next), sum) in self.by_rates.iter_mut().zip(&self.by_stage).zip(sums) {
                for ((rate, &next), &sum) in rate.iter_mut().zip(next).zip(sum) {
                    *rate = sum * weight + next * time;
                }
            }
            let by_log = self.evaluated[stage].weighted_rates(&self.by_rates);
            out.add_time_step(by_log * (1.0 / simulator.time_step()));
            self.add_stage(stage, simulator, at, out);
        }
    }
}

impl<T: Scalar> Adjoint<T> {
    /// The stages forwards.
    fn evaluate(&mut self, simulator: &Simulator, at: &StepPoint<'_, T>) {
        self.stages.start(at.state);
        for (stage, own) in self.evaluated.iter_mut().enumerate() {
            own.state.copy_from(&self.stages.state);
            own.offset.copy_from_slice(self.stages.offset.as_slice());
            self.stages.evaluate(simulator, at.u, &mut own.found);
            own.rate.copy_from_slice(self.stages.rate.as_slice());
            (self.stages).move_on(simulator, at.state, &own.found, stage);
        }
        self.stages.finish(simulator, at.state, &mut self.next);
    }

    /// From the weights of the rates of a stage to those of its numbers, and of the start.
    fn add_stage(
        &mut self,
        stage: usize,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let (own, by_q) = (&mut self.evaluated[stage], &mut self.by_q);
        let (model, q) = (simulator.model(), at.state.q.as_slice());
        by_q.fill(T::zero());
        self.by_stage.iter_mut().for_each(|x| x.fill(T::zero()));
        let ([by_offset, by_v, by_contact], [by_rate, by_a, by_contact_rate]) =
            (&mut self.by_stage, &self.by_rates);
        let of_rates = AccelerationWeights {
            a: by_a,
            contact: by_contact_rate,
            has_friction: out.has_parts,
        };
        let mut slopes = StepGradientSum {
            q: by_q,
            v: by_v,
            contact: by_contact,
            u: &mut *out.u,
            parameters: &mut *out.parameters,
            has_parts: out.has_parts,
        };
        let point = EvaluationPoint::instant(simulator, &own.state, at.u);
        (self.acceleration).add(&point, &mut own.found, &of_rates, &mut slopes);
        let v = own.state.v.as_slice();
        add_tangent_rate(model, &own.offset, v, by_rate, by_offset, by_v);
        let (offset, end) = (&own.offset[..], own.state.q.as_slice());
        add_integrated(model, q, offset, end, by_q, out.q, by_offset);
        add_scaled(out.v, by_v, T::one());
        add_scaled(out.contact, by_contact, T::one());
    }
}

impl<T: Scalar> Evaluated<T> {
    /// The weighted rates of the stage: of its offset, velocity and contact state.
    fn weighted_rates(&self, [by_rate, by_a, by_contact]: &[Vec<T>; 3]) -> T {
        let contact = self.found.terms.contact.rates().zip(by_contact);
        let of_contact = contact.fold(T::zero(), |sum, (rate, &weight)| sum + rate * weight);
        dot(&self.rate, by_rate) + dot(&self.found.a, by_a) + of_contact
    }
}
