//! A rollout along a direction, and its backward pass: forward over adjoint.

use nalgebra::DVector;

use super::direction::RolloutDirection;
use super::second_costs::{Along, Place, SecondCosts, TwicePoint, Weights};
use crate::dynamics::Calls;
use crate::scalar::Cast;
use crate::sim::{
    Pullback, Rollout, RolloutStatus, Simulator, State, StepAdjoint, StepGradientSum, StepPoint,
    StepScratch, add_integrated,
};

/// A state of a rollout, and the step from it, with their derivatives along a direction.
struct Moving {
    state: State<Along>,
    /// Of the state, along its tangent.
    dx: DVector<f64>,
    /// Empty at the end.
    u: Vec<Along>,
    acceleration: Vec<Along>,
}

/// The rollout under given inputs.
fn rollout_under(simulator: &Simulator, start: &State, inputs: &[DVector<f64>]) -> Rollout {
    simulator.check(start);
    (inputs.iter()).for_each(|u| simulator.check_input(u.as_slice()));
    let mut given = inputs.iter();
    simulator.rollout(start, inputs.len(), |_, _, u| {
        if let Some(given) = given.next() {
            u.copy_from_slice(given.as_slice());
        }
    })
}

/// A rollout, and working memory to take it along directions.
pub(super) struct Directed<'a> {
    simulator: &'a Simulator,
    pub(super) rollout: Rollout,
    step: StepScratch<Along>,
    adjoint: StepAdjoint<Along>,
    point: TwicePoint,
}

impl<'a> Directed<'a> {
    pub(super) fn new(simulator: &'a Simulator, start: &State, inputs: &[DVector<f64>]) -> Self {
        Self {
            simulator,
            rollout: rollout_under(simulator, start, inputs),
            step: StepScratch::awake(simulator),
            adjoint: StepAdjoint::new(simulator, Calls::Many),
            point: TwicePoint::new(simulator),
        }
    }

    /// ∂²J along a direction; zero unless the rollout is completed.
    pub(super) fn product(
        &mut self,
        costs: &mut dyn SecondCosts,
        along: &RolloutDirection,
    ) -> RolloutDirection {
        let mut out = RolloutDirection::zeros(self.simulator, along.inputs.len());
        if self.rollout.status != RolloutStatus::Completed {
            return out;
        }
        let moving = self.moving(along);
        let last = moving.len() - 1;
        let mut adjoint = vec![Along::from(0.0); self.simulator.n_tangent()];
        let none = DVector::zeros(0);
        self.add_cost(
            last,
            &moving[last],
            &none,
            &mut adjoint,
            |at, point, here| {
                costs.end(at, point, here);
            },
        );
        for (k, own) in moving.iter().enumerate().take(last).rev() {
            let (mut before, u) = self.back(own, &adjoint);
            let du = &along.inputs[k];
            let by_input = self.add_cost(k, own, du, &mut before, |at, point, here| {
                costs.stage(at, point, here);
            });
            let slopes = out.inputs[k].iter_mut().zip(u.iter().zip(&by_input));
            slopes.for_each(|(out, (u, x))| *out = u.eps[0] + x);
            adjoint = before;
        }
        self.leave(&moving[0], &adjoint, &mut out.start);
        out
    }

    /// The states along a direction.
    fn moving(&mut self, along: &RolloutDirection) -> Vec<Moving> {
        let (simulator, states) = (self.simulator, &self.rollout.states);
        let start: State<Along> = states[0].cast();
        let changes: Vec<_> = along
            .start
            .iter()
            .map(|&dx| Along::new(0.0, [dx]))
            .collect();
        let mut state = start.integrate(simulator.model(), &changes);
        let mut out = Vec::with_capacity(states.len());
        for (k, base) in states.iter().enumerate() {
            let deviation = state.deviation(simulator.model(), &base.cast());
            let mut own = Moving {
                dx: deviation.map(|x| x.eps[0]),
                u: Vec::new(),
                acceleration: Vec::new(),
                state,
            };
            let mut next = own.state.clone();
            if let Some(u) = self.rollout.inputs.get(k) {
                let pairs = u.iter().zip(&along.inputs[k]);
                own.u = pairs.map(|(&u, &du)| Along::new(u, [du])).collect();
                simulator.step_into(&own.state, &own.u, &mut self.step, &mut next);
                own.acceleration.clone_from(&self.step.acceleration().a);
            }
            out.push(own);
            state = next;
        }
        out
    }

    /// From the weights of the next state to those of a state and of the input, each along the tangent where it has moved.
    fn back(&mut self, own: &Moving, adjoint: &[Along]) -> (Vec<Along>, Vec<Along>) {
        let simulator = self.simulator;
        let nv = simulator.model().nv();
        let mut state = vec![Along::from(0.0); adjoint.len()];
        let mut u = vec![Along::from(0.0); own.u.len()];
        let (q, rest) = state.split_at_mut(nv);
        let (v, rest) = rest.split_at_mut(nv);
        let (contact, activation) = rest.split_at_mut(simulator.n_contact());
        let mut slopes = StepGradientSum {
            q,
            v,
            contact,
            activation,
            u: &mut u,
            parameters: &mut [],
            has_parts: false,
        };
        let at = StepPoint {
            state: &own.state,
            u: &own.u,
            acceleration: Some(&own.acceleration),
        };
        (self.adjoint).add_gradient(simulator, &at, adjoint, &mut slopes);
        (state, u)
    }

    /// Adds the gradient of a cost of a state, along the tangent at the moved state. Returns the change of the gradient in its input along the direction.
    fn add_cost(
        &mut self,
        step: usize,
        own: &Moving,
        du: &DVector<f64>,
        adjoint: &mut [Along],
        mut cost: impl FnMut(&Place<'_>, &mut TwicePoint, &mut Weights),
    ) -> DVector<f64> {
        let (simulator, base) = (self.simulator, &self.rollout.states[step]);
        let none = DVector::zeros(0);
        let at = Place {
            simulator,
            step,
            state: base,
            u: self.rollout.inputs.get(step).unwrap_or(&none),
            dx: &own.dx,
            du,
        };
        let mut here = Weights::zeros(simulator);
        cost(&at, &mut self.point, &mut here);
        let pairs = here.first.iter().zip(&here.second);
        let slopes: Vec<Along> = pairs.map(|(&x, &dx)| Along::new(x, [dx])).collect();
        let nv = simulator.model().nv();
        let (by_q, rest) = adjoint.split_at_mut(nv);
        let mut ends = vec![Along::from(0.0); nv];
        let still = ends.clone();
        let (q, base): (_, State<Along>) = (own.state.q.as_slice(), base.cast());
        let (end, model) = (base.q.as_slice(), simulator.model());
        add_integrated(model, q, &still, end, &slopes[..nv], by_q, &mut ends);
        let others = rest.iter_mut().zip(&slopes[nv..]);
        others.for_each(|(out, &x)| *out += x);
        here.second_input
    }

    /// From weights along the tangent where the start has moved to how those at the start itself change.
    fn leave(&self, own: &Moving, adjoint: &[Along], out: &mut DVector<f64>) {
        let (model, nv) = (self.simulator.model(), self.simulator.model().nv());
        let base: State<Along> = self.rollout.states[0].cast();
        let tangent: Vec<_> = own.dx.iter().map(|&dx| Along::new(0.0, [dx])).collect();
        let mut all = adjoint.to_vec();
        let by_q = &mut all[..nv];
        by_q.fill(Along::from(0.0));
        let (q, end) = (base.q.as_slice(), own.state.q.as_slice());
        let mut starts = vec![Along::from(0.0); nv];
        let (offset, weights) = (&tangent[..nv], &adjoint[..nv]);
        add_integrated(model, q, offset, end, weights, &mut starts, by_q);
        let entries = out.iter_mut().zip(&all);
        entries.for_each(|(out, x)| *out = x.eps[0]);
    }
}
