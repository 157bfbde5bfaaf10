//! Gradient of a step of Runge and Kutta: its stages backwards.

use super::{STAGES, Stages};
use crate::dynamics::Calls;
use crate::linalg::product::{add_scaled, dot};
use crate::scalar::Scalar;
use crate::sim::integrators::acceleration::AccelerationAdjoint;
use crate::sim::integrators::balance::AccelerationWeights;
use crate::sim::integrators::joint_tangents::{add_integrated, add_tangent_rate};
use crate::sim::{AccelerationScratch, Moment, Simulator, State, StepSlopes};

/// A stage that has been evaluated.
#[derive(Clone, Debug)]
struct Evaluated<T: Scalar> {
    state: State<T>,
    /// Its configuration as a tangent at the start of the step, and the rate of that.
    offset: Vec<T>,
    rate: Vec<T>,
    found: AccelerationScratch<T>,
}

/// Weights of a stage's numbers.
#[derive(Clone, Debug)]
struct StageWeights<T> {
    /// Of its configuration in its own tangent space, and as an offset.
    q: Vec<T>,
    offset: Vec<T>,
    v: Vec<T>,
    contact: Vec<T>,
    /// Of its rates.
    rate: Vec<T>,
    a: Vec<T>,
    contact_rate: Vec<T>,
}

/// Working memory of [`add_gradient`](Self::add_gradient).
#[derive(Clone, Debug)]
pub(in crate::sim::integrators) struct StageAdjoint<T: Scalar> {
    stages: Stages<T>,
    evaluated: Vec<Evaluated<T>>,
    next: State<T>,
    weights: StageWeights<T>,
    /// Of the weighted sum of the rates of the offset.
    by_sum: Vec<T>,
    acceleration: AccelerationAdjoint<T>,
}

impl<T: Scalar> StageAdjoint<T> {
    pub(in crate::sim::integrators) fn new(simulator: &Simulator, calls: Calls) -> Self {
        let (nv, n_contact) = (simulator.model().nv(), simulator.n_contact());
        let (zeros, of_contact) = (|| vec![T::zero(); nv], || vec![T::zero(); n_contact]);
        let evaluated = STAGES.map(|_| Evaluated {
            state: simulator.neutral_state(),
            offset: zeros(),
            rate: zeros(),
            found: AccelerationScratch::new(simulator, calls),
        });
        Self {
            stages: Stages::new(simulator),
            evaluated: evaluated.into(),
            next: simulator.neutral_state(),
            weights: StageWeights {
                q: zeros(),
                offset: zeros(),
                v: zeros(),
                contact: of_contact(),
                rate: zeros(),
                a: zeros(),
                contact_rate: of_contact(),
            },
            by_sum: zeros(),
            acceleration: AccelerationAdjoint::new(simulator, calls),
        }
    }

    /// Adds the gradient of λᵀ x⁺ of the step from a moment.
    pub(in crate::sim::integrators) fn add_gradient(
        &mut self,
        at: &Moment<'_, f64, T>,
        adjoint: &[T],
        out: &mut StepSlopes<'_, T>,
    ) {
        self.evaluate(at);
        let (model, nv, dt) = (at.model(), at.model().nv(), at.dt());
        let (by_q, rest) = adjoint.split_at(nv);
        let (by_v, by_contact) = rest.split_at(nv);
        add_scaled(out.v, by_v, T::one());
        add_scaled(out.contact, by_contact, T::one());
        // q⁺ = q ⊕ Σ
        self.by_sum.fill(T::zero());
        let sum = self.stages.sum_rate.as_slice();
        let (end, by_sum) = (self.next.q.as_slice(), &mut self.by_sum);
        add_integrated(model, at.q(), sum, end, by_q, out.q, by_sum);
        self.weights.clear();
        for (stage, (weight, fraction)) in STAGES.iter().enumerate().rev() {
            let w = &mut self.weights;
            // What the rates count for in the sums, and in the stage after this one.
            for (rate, from, next) in [
                (&mut w.rate, &self.by_sum[..], &w.offset),
                (&mut w.a, by_v, &w.v),
                (&mut w.contact_rate, by_contact, &w.contact),
            ] {
                for ((rate, &from), &next) in rate.iter_mut().zip(from).zip(next) {
                    *rate = (from * *weight + next * *fraction) * dt;
                }
            }
            let by_log = self.evaluated[stage].weighted_rates(w);
            out.add_time_step(by_log * (1.0 / dt));
            self.add_stage(stage, at, out);
        }
    }

    /// The stages forwards.
    fn evaluate(&mut self, at: &Moment<'_, f64, T>) {
        let (simulator, dt) = (at.simulator, at.dt());
        self.stages.start(at.state);
        for (own, (weight, fraction)) in self.evaluated.iter_mut().zip(STAGES) {
            own.state.copy_from(&self.stages.state);
            own.offset.copy_from_slice(self.stages.offset.as_slice());
            self.stages.evaluate(simulator, at.u, &mut own.found);
            own.rate.copy_from_slice(self.stages.rate.as_slice());
            self.stages.add(&own.found, weight * dt);
            self.stages
                .move_on(simulator, at.state, &own.found, fraction * dt);
        }
        self.stages.finish(simulator, at.state, &mut self.next);
    }

    /// From the weights of the rates of a stage to those of its numbers, and of the start.
    fn add_stage(&mut self, stage: usize, at: &Moment<'_, f64, T>, out: &mut StepSlopes<'_, T>) {
        let (own, w) = (&mut self.evaluated[stage], &mut self.weights);
        let model = at.model();
        for x in [&mut w.q, &mut w.offset, &mut w.v, &mut w.contact] {
            x.fill(T::zero());
        }
        let moment = Moment::instant(at.simulator, &own.state, at.u);
        let of_rates = AccelerationWeights {
            a: &w.a,
            contact: &w.contact_rate,
            has_friction: out.has_parts,
        };
        let mut slopes = StepSlopes {
            q: &mut w.q,
            v: &mut w.v,
            contact: &mut w.contact,
            u: &mut *out.u,
            parameters: &mut *out.parameters,
            has_parts: out.has_parts,
        };
        self.acceleration
            .add(&moment, &mut own.found, &of_rates, &mut slopes);
        let v = own.state.v.as_slice();
        add_tangent_rate(model, &own.offset, v, &w.rate, &mut w.offset, &mut w.v);
        let (offset, end) = (&own.offset[..], own.state.q.as_slice());
        add_integrated(model, at.q(), offset, end, &w.q, out.q, &mut w.offset);
        add_scaled(out.v, &w.v, T::one());
        add_scaled(out.contact, &w.contact, T::one());
    }
}

impl<T: Scalar> Evaluated<T> {
    /// The weighted rates of the stage.
    fn weighted_rates(&self, weights: &StageWeights<T>) -> T {
        let contact = self.found.terms.contact.rates().zip(&weights.contact_rate);
        let of_contact = contact.fold(T::zero(), |sum, (rate, &weight)| sum + rate * weight);
        dot(&self.rate, &weights.rate) + dot(&self.found.a, &weights.a) + of_contact
    }
}

impl<T: Scalar> StageWeights<T> {
    fn clear(&mut self) {
        for x in [&mut self.offset, &mut self.v, &mut self.contact] {
            x.fill(T::zero());
        }
    }
}
