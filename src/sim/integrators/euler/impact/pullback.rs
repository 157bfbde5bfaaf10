//! Gradient of a step with an isolated impact: its parts backwards, and the impact time by the implicit function theorem.
//!
//! The weights of x₃ become those of x* through the impact, and the derivative of the sum in t is c. As δt = −δγ / γ̇, the gap has the additional
//! weight −c / γ̇ at x*.

use super::{IMPACT_TIME, Impact, LoneImpact, times, without_force};
use crate::linalg::product::add_scaled;
use crate::scalar::{MapEach, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::AccelerationScratch;
use crate::sim::integrators::acceleration::AccelerationWeights;
use crate::sim::integrators::euler::EvaluationAdjoint;
use crate::sim::integrators::joint_tangents::OfNumbers;
use crate::sim::integrators::kick_drift::{KickDrift, MotionGradientSum};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::StepGradientSum;

/// The numbers on which the times of motions depend: that of the impact, and the time step.
const TIME: usize = 0;
const TIME_STEP: usize = 1;

/// Working memory.
#[derive(Clone, Debug)]
pub(in crate::sim::integrators) struct Adjoint<T: Scalar> {
    impact: Impact<T>,
    lone: LoneImpact,
    /// γ̇, m/s.
    gap_rate: T,
    /// Weights of x₃ on the way to x₂, and of x* on the way to x₀.
    by_after: Vec<T>,
    by_touching: Vec<T>,
    /// A copy of the latter.
    trial: Vec<T>,
    /// Of the acceleration.
    by_a: Vec<T>,
    /// Of it, or of the input, where they are not wanted.
    unused: Vec<T>,
}

impl<T: Scalar> Adjoint<T> {
    pub(in crate::sim::integrators) fn new(simulator: &Simulator) -> Self {
        let zeros = || vec![T::zero(); simulator.n_motion()];
        Self {
            impact: Impact::new(simulator),
            lone: LoneImpact::default(),
            gap_rate: T::zero(),
            by_after: zeros(),
            by_touching: zeros(),
            trial: zeros(),
            by_a: vec![T::zero(); simulator.model().nv()],
            unused: vec![T::zero(); simulator.model().nv().max(simulator.nu())],
        }
    }

    /// [`Impact::step`], and the common part of its gradients.
    pub(in crate::sim::integrators) fn find(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        lone: LoneImpact,
        found: &mut AccelerationScratch<T>,
        next: &mut State<T>,
        own: &mut EvaluationAdjoint<T>,
    ) -> bool {
        if !self.impact.step(at, lone, found, next) {
            return false;
        }
        self.lone = lone;
        self.by_touching.fill(T::zero());
        self.weigh_gap(at, T::one(), own, &mut [], false);
        self.gap_rate = self.rate(at, &found.a, own);
        true
    }

    /// Adds the gradient of λᵀ x₃.
    ///
    /// * `found`, `next` – the evaluation without the force of the point, and x₃
    pub(in crate::sim::integrators) fn add(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        found: &mut AccelerationScratch<T>,
        next: &State<T>,
        adjoint: &[T],
        own: &mut EvaluationAdjoint<T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        self.by_a.fill(T::zero());
        self.by_after.copy_from_slice(adjoint);
        let [_, _, leave, from_velocity] = motions(at, &self.impact, &found.a, next);
        let mut slopes = MotionGradientSum {
            a: &mut self.by_a,
            parameters: out.parameters,
            slots: own.acceleration.slots(),
            numbers: [T::zero(); 2],
        };
        from_velocity.pull(&mut self.by_after, &mut slopes);
        leave.pull(&mut self.by_after, &mut slopes);
        let numbers = slopes.numbers;
        out.add_time_step(numbers[TIME_STEP]);
        self.add_impact(at, own, out);
        let by_time = numbers[TIME] + self.rate(at, &found.a, own);
        let weight = -(by_time / self.gap_rate);
        self.weigh_gap(at, weight, own, out.parameters, out.has_parts);
        self.add_start(at, found, own, out);
    }

    /// Weights of x* from those of x₂, and the gradient of the impact in input and parameters. The time that it lasts is none of these.
    fn add_impact(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        own: &mut EvaluationAdjoint<T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let Impact {
            touching,
            after,
            found,
            ..
        } = &mut self.impact;
        let point = EvaluationPoint::lasting(at.simulator, touching, at.u, IMPACT_TIME);
        self.by_touching.fill(T::zero());
        let by_time_step = out.parameters.last().copied().filter(|_| out.has_parts);
        let mut slopes = of_touching(&mut self.by_touching, at.model().nv());
        slopes.u = &mut *out.u;
        slopes.parameters = &mut *out.parameters;
        slopes.has_parts = out.has_parts;
        own.add(&point, found, after, &self.by_after, &mut slopes);
        if let Some((last, kept)) = out.parameters.last_mut().zip(by_time_step) {
            *last = kept;
        }
    }

    /// Adds the gradient of the gap at x*, times a weight.
    fn weigh_gap(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        weight: T,
        own: &mut EvaluationAdjoint<T>,
        parameters: &mut [T],
        has_parts: bool,
    ) {
        let Impact {
            touching,
            found,
            row,
            ..
        } = &self.impact;
        let point = EvaluationPoint::lasting(at.simulator, touching, at.u, IMPACT_TIME);
        let mut slopes = of_touching(&mut self.by_touching, at.model().nv());
        slopes.u = &mut self.unused;
        slopes.parameters = parameters;
        slopes.has_parts = has_parts;
        (own.acceleration).add_gap(&point, found, *row, weight, &mut slopes);
    }

    /// The slope of what is weighted at x* in the time of the impact.
    fn rate(&mut self, at: &EvaluationPoint<'_, f64, T>, a: &[T], own: &EvaluationAdjoint<T>) -> T {
        self.trial.copy_from_slice(&self.by_touching);
        let mut slopes = MotionGradientSum {
            a: &mut self.unused,
            parameters: &mut [],
            slots: own.acceleration.slots(),
            numbers: [T::zero(); 2],
        };
        // The motions until then, which do not depend on the end.
        let [arrive, to_velocity, ..] = motions(at, &self.impact, a, &self.impact.leaving);
        to_velocity.pull(&mut self.trial, &mut slopes);
        arrive.pull(&mut self.trial, &mut slopes);
        slopes.numbers[TIME]
    }

    /// Adds the gradient from the weights of x* and of the acceleration.
    fn add_start(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        found: &mut AccelerationScratch<T>,
        own: &mut EvaluationAdjoint<T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let mut slopes = MotionGradientSum {
            a: &mut self.by_a,
            parameters: out.parameters,
            slots: own.acceleration.slots(),
            numbers: [T::zero(); 2],
        };
        let [arrive, to_velocity, ..] = motions(at, &self.impact, &found.a, &self.impact.leaving);
        to_velocity.pull(&mut self.by_touching, &mut slopes);
        arrive.pull(&mut self.by_touching, &mut slopes);
        let by_time_step = slopes.numbers[TIME_STEP];
        out.add_time_step(by_time_step);
        let (by_q, by_v) = self.by_touching.split_at(at.model().nv());
        add_scaled(out.q, by_q, T::one());
        add_scaled(out.v, by_v, T::one());
        let weights = AccelerationWeights {
            a: &self.by_a,
            contact: &[],
            has_friction: out.has_parts,
        };
        let free = without_force(at, &self.lone);
        (own.acceleration).add(&free, found, &weights, out);
    }
}

/// The motions before the impact and after it, two each.
fn motions<'a, T: Scalar>(
    at: &EvaluationPoint<'a, f64, T>,
    impact: &'a Impact<T>,
    a: &'a [T],
    next: &'a State<T>,
) -> [KickDrift<'a, T>; 4] {
    let dt = OfNumbers::variable(T::constant(at.dt()), TIME_STEP);
    let [first, second, third, last] = times(dt, OfNumbers::variable(impact.time, TIME));
    let Impact {
        arriving,
        touching,
        after,
        leaving,
        ..
    } = impact;
    let parts = [
        (at.state, arriving, first),
        (arriving, touching, second),
        (after, leaving, third),
        (leaving, next, last),
    ];
    parts.map_each(|(from, to, times)| KickDrift {
        model: at.model(),
        from,
        a,
        to,
        times,
    })
}

/// Sums of weights of x* alone.
fn of_touching<T: Scalar>(weights: &mut [T], nv: usize) -> StepGradientSum<'_, T> {
    let (q, rest) = weights.split_at_mut(nv);
    let (v, contact) = rest.split_at_mut(nv);
    StepGradientSum {
        q,
        v,
        contact,
        activation: &mut [],
        u: &mut [],
        parameters: &mut [],
        has_parts: false,
    }
}
