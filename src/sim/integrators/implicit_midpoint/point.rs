//! Momentum and force at the middle of a step with a velocity that is given, and the step that follows from it.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::joint::{at_end, at_middle, own};
use crate::dynamics::{
    AbaScratch, RneaScratch, each_kinetic_slope, forward_dynamics_into, inverse_dynamics_into,
};
use crate::model::Model;
use crate::model::manifold::v_range;
use crate::scalar::{Over, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::AccelerationScratch;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::spatial::{Force, Motion, Transform};

/// Slopes of the kinetic energy.
#[derive(Clone, Debug)]
pub(super) struct Kinetic<T> {
    X_PB: Vec<Transform<T>>,
    bodies: Vec<(Motion<T>, Force<T>)>,
}

impl<T: Scalar> Kinetic<T> {
    pub(super) fn new<P: Scalar>(model: &Model<P>) -> Self {
        let n = model.n_bodies();
        Self {
            X_PB: vec![Transform::identity(); n],
            bodies: vec![(Motion::zero(), Force::zero()); n],
        }
    }

    /// Finds the momentum M v, without armature, and ∂T/∂q.
    pub(super) fn find<P: Scalar>(
        &mut self,
        model: &Model<P>,
        q: &[T],
        v: &[T],
        momentum: &mut [T],
        force: &mut [T],
    ) where
        T: Over<P>,
    {
        for (X, body) in self.X_PB.iter_mut().zip(model.bodies()) {
            *X = body.place(q);
        }
        momentum.fill(T::zero());
        force.fill(T::zero());
        each_kinetic_slope(model, &self.X_PB, v, &mut self.bodies, |k, p, slope| {
            momentum[k] += p;
            force[k] += slope;
        });
    }
}

/// The middle of a step.
#[derive(Clone, Debug)]
pub(super) struct Midpoint<T: Scalar> {
    /// The part of the time step that this step takes.
    pub(super) part: f64,
    /// Velocity of the step.
    pub(super) xi: Vec<T>,
    /// Momentum of its start.
    pub(super) p: Vec<T>,
    /// Δt ξ and half of it.
    pub(super) offset: Vec<T>,
    pub(super) half_offset: Vec<T>,
    /// Its middle, with ξ.
    pub(super) state: State<T>,
    /// Momentum and force there.
    pub(super) momentum: Vec<T>,
    pub(super) force: Vec<T>,
    /// Impulse of the force over the step.
    pub(super) impulse: Vec<T>,
    /// By how much the momentum is not what it should be.
    pub(super) residual: Vec<T>,
    kinetic: Kinetic<T>,
    rnea: RneaScratch<T>,
    aba: AbaScratch<T>,
    rest: Vec<T>,
    scratch: Vec<T>,
}

impl<T: Scalar> Midpoint<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let model = simulator.model();
        let zeros = || vec![T::zero(); model.nv()];
        Self {
            part: 1.0,
            xi: zeros(),
            p: zeros(),
            offset: zeros(),
            half_offset: zeros(),
            state: simulator.neutral_state(),
            momentum: zeros(),
            force: zeros(),
            impulse: zeros(),
            residual: zeros(),
            kinetic: Kinetic::new(model),
            rnea: RneaScratch::new(model),
            aba: AbaScratch::new(model),
            rest: zeros(),
            scratch: zeros(),
        }
    }

    /// Takes the start of a step, and its velocity for ξ.
    pub(super) fn start<P: Scalar>(&mut self, simulator: &Simulator<P>, state: &State<T>)
    where
        T: Over<P>,
    {
        let (model, v) = (simulator.model(), state.v.as_slice());
        self.xi.copy_from_slice(v);
        self.kinetic
            .find(model, state.q.as_slice(), v, &mut self.p, &mut self.force);
        add_armature(model, v, &mut self.p);
    }

    /// Momentum and force of the middle.
    pub(super) fn evaluate<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        start: &State<T>,
        u: &[T],
        found: &mut AccelerationScratch<T>,
    ) where
        T: Over<P>,
    {
        let (model, dt) = (simulator.model(), simulator.time_step() * self.part);
        for (k, &xi) in self.xi.iter().enumerate() {
            self.offset[k] = xi * dt;
            self.half_offset[k] = self.offset[k] * 0.5;
        }
        let mid = &mut self.state;
        let q = mid.q.as_mut_slice();
        model.integrate_into(start.q.as_slice(), &self.half_offset, q);
        mid.v.as_mut_slice().copy_from_slice(&self.xi);
        let (q, v) = (mid.q.as_slice(), mid.v.as_slice());
        self.kinetic
            .find(model, q, v, &mut self.momentum, &mut self.force);
        add_armature(model, v, &mut self.momentum);
        let applied = simulator.apply_terms(&EvaluationPoint::instant(simulator, mid, u), found);
        let (rest, resisting) = (&self.rest, &mut self.scratch);
        let bodies = &applied.bodies;
        inverse_dynamics_into(model, q, rest, rest, bodies, &mut self.rnea, resisting);
        for (k, force) in self.force.iter_mut().enumerate() {
            *force += applied.tau[k] - resisting[k];
            self.impulse[k] = *force * dt;
        }
    }

    /// By how much the momentum of the middle is not what start and force ask for.
    pub(super) fn find_residual<P: Scalar>(&mut self, simulator: &Simulator<P>) {
        for body in simulator.model().independent() {
            let half_impulse = own(body, &self.impulse).map(|x| x * 0.5);
            let (phi, p) = (own(body, &self.half_offset), own(body, &self.p));
            let expected = at_middle(body.joint, &phi, &p, &half_impulse);
            for (k, expected) in v_range(body).zip(expected) {
                self.residual[k] = self.momentum[k] - expected;
            }
        }
    }

    /// Takes from ξ what stands where the residual was; the value of a number that has one stays.
    pub(super) fn move_by_residual(&mut self) {
        for (xi, &x) in self.xi.iter_mut().zip(&self.residual) {
            *xi -= if T::ORDER > 0 { x - x.value(0) } else { x };
        }
    }

    /// The state after the step.
    pub(super) fn finish<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        start: &State<T>,
        next: &mut State<T>,
    ) where
        T: Over<P>,
    {
        let model = simulator.model();
        let (q, rest) = (next.q.as_mut_slice(), &self.rest);
        model.integrate_into(start.q.as_slice(), &self.offset, q);
        let force = &mut self.scratch;
        inverse_dynamics_into(model, q, rest, rest, &[], &mut self.rnea, force);
        for body in model.independent() {
            let (phi, p) = (own(body, &self.half_offset), own(body, &self.p));
            let p = at_end(body.joint, &phi, &p, &own(body, &self.impulse));
            for (k, p) in v_range(body).zip(p) {
                force[k] += p;
            }
        }
        // Forward dynamics at rest, with what holds the weight beside, is M⁻¹.
        let v = next.v.as_mut_slice();
        forward_dynamics_into(model, q, rest, force, &[], &mut self.aba, v);
        next.contact.copy_from(&start.contact);
    }
}

fn add_armature<P: Scalar, T: Over<P>>(model: &Model<P>, v: &[T], momentum: &mut [T]) {
    let armature = v.iter().zip(model.armature());
    for (p, (&v, &armature)) in momentum.iter_mut().zip(armature) {
        *p += v * armature;
    }
}
