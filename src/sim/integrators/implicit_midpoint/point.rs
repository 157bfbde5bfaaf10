//! Momentum and force at the middle of a step with a velocity that is given, and the step that follows from it.
//!
//! Constraints add impulses to the momentum of the start, and to that of the end (`held.rs`).

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DMatrix;

use super::held::Held;
use super::joint::{at_end, at_middle, own};
use super::parts::TURN;
use super::saddle::Saddle;
use crate::dynamics::{
    CrbaScratch, RneaScratch, each_kinetic_derivative, inverse_dynamics_into, mass_matrix_into,
};
use crate::model::Model;
use crate::model::manifold::v_range;
use crate::scalar::{MapEach, Over, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::AccelerationScratch;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::spatial::{Force, Motion, Transform};

/// Derivatives of the kinetic energy.
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
        each_kinetic_derivative(model, &self.X_PB, v, &mut self.bodies, |k, p, slope| {
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
    /// Momentum of its start: that of the bodies, and with the impulses of constraints.
    bodies_p: Vec<T>,
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
    /// Residual of the momentum.
    pub(super) residual: Vec<T>,
    /// Work of the applied forces and of gravity over the step, J.
    work: f64,
    /// Momentum of its end.
    end_momentum: Vec<T>,
    pub(super) held: Held<T>,
    /// Of M and the rows at the end.
    pub(super) end: Saddle<T>,
    /// Configuration of the end.
    end_q: Vec<T>,
    kinetic: Kinetic<T>,
    rnea: RneaScratch<T>,
    crba: CrbaScratch<T>,
    mass: DMatrix<T>,
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
            bodies_p: zeros(),
            p: zeros(),
            offset: zeros(),
            half_offset: zeros(),
            state: simulator.neutral_state(),
            momentum: zeros(),
            force: zeros(),
            impulse: zeros(),
            residual: zeros(),
            work: 0.0,
            end_momentum: zeros(),
            held: Held::new(simulator),
            end: Saddle::new(simulator),
            end_q: vec![T::zero(); model.nq()],
            kinetic: Kinetic::new(model),
            rnea: RneaScratch::new(model),
            crba: CrbaScratch::new(model),
            mass: DMatrix::zeros(model.nv(), model.nv()),
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
        let (p, force) = (&mut self.bodies_p, &mut self.force);
        self.kinetic.find(model, state.q.as_slice(), v, p, force);
        add_armature(model, v, p);
        self.held.find_start(simulator, state);
        self.push();
    }

    /// Takes ξ and the impulses of the start that have been found on plain numbers.
    pub(super) fn take_values(&mut self, found: &Midpoint<f64>) {
        let both = [
            (&mut self.xi, &found.xi),
            (&mut self.held.impulses[0], &found.held.impulses[0]),
        ];
        for (own, values) in both {
            let pairs = own.iter_mut().zip(values);
            pairs.for_each(|(own, &x)| *own = T::constant(x));
        }
        self.push();
    }

    /// The momentum of the start with the impulses that there are.
    fn push(&mut self) {
        self.p.copy_from_slice(&self.bodies_p);
        self.held.push(&mut self.p);
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
        self.work = 0.0;
        for (k, force) in self.force.iter_mut().enumerate() {
            let generalized = applied.tau[k] - resisting[k];
            self.work += (generalized * self.offset[k]).value(0);
            *force += generalized;
            self.impulse[k] = *force * dt;
        }
    }

    /// Residual of the momentum of the middle, and errors of constraints at the end.
    pub(super) fn find_residual<P: Scalar>(&mut self, simulator: &Simulator<P>, start: &State<T>)
    where
        T: Over<P>,
    {
        if !simulator.constraints().is_empty() {
            self.find_end(simulator, start);
        }
        for body in simulator.model().independent() {
            let half_impulse = own(body, &self.impulse).map_each(|x| x * 0.5);
            let (phi, p) = (own(body, &self.half_offset), own(body, &self.p));
            let expected = at_middle(body.joint, &phi, &p, &half_impulse);
            for (k, expected) in v_range(body).zip(expected) {
                self.residual[k] = self.momentum[k] - expected;
            }
        }
    }

    fn find_end<P: Scalar>(&mut self, simulator: &Simulator<P>, start: &State<T>)
    where
        T: Over<P>,
    {
        let (q, end) = (start.q.as_slice(), &mut self.end_q);
        simulator.model().integrate_into(q, &self.offset, end);
        self.held.find_end(simulator, end, &self.xi);
    }

    /// Subtracts the solution from ξ and the impulses of the start; values are kept, only derivatives change.
    pub(super) fn move_by_residual(&mut self) {
        let held = &mut self.held;
        let both = [
            (&mut self.xi, &self.residual),
            (&mut held.impulses[0], &held.errors),
        ];
        for (own, changes) in both {
            for (own, &x) in own.iter_mut().zip(changes) {
                *own -= if T::ORDER > 0 { x - x.value(0) } else { x };
            }
        }
        self.push();
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
        self.find_end(simulator, start);
        let (model, q) = (simulator.model(), &self.end_q);
        next.q.as_mut_slice().copy_from_slice(q);
        mass_matrix_into(model, q, &mut self.crba, &mut self.mass);
        let jacobian = &self.held.end.jacobian;
        self.end.factorize(&self.mass, jacobian, jacobian);
        let v = next.v.as_mut_slice();
        for body in model.independent() {
            let (phi, p) = (own(body, &self.half_offset), own(body, &self.p));
            let p = at_end(body.joint, &phi, &p, &own(body, &self.impulse));
            for (k, p) in v_range(body).zip(p) {
                (v[k], self.end_momentum[k]) = (p, p);
            }
        }
        let impulses = &mut self.held.impulses[1];
        impulses.fill(T::zero());
        self.end.solve(v, impulses);
        next.contact.copy_from(&start.contact);
    }

    /// The change of the kinetic energy ½ pᵀ v over the step less the work Δt ξᵀ (τ − ∂U/∂q) of the middle, relative to the kinetic energy. Zero to rounding
    /// where the mass matrix is constant. Also zero near rest, where only rounding remains, and while open constraints are closed, which takes energy.
    pub(super) fn energy_error(&self, start: &State<T>, end: &State<T>) -> f64 {
        let is_slow = |x: &T| x.value(0).abs() <= TURN;
        if self.offset.iter().all(is_slow) || !self.held.is_closed() {
            return 0.0;
        }
        let kinetic = |p: &[T], v: &State<T>| {
            let products = p.iter().zip(v.v.iter()).map(|(&p, &v)| (p * v).value(0));
            0.5 * products.sum::<f64>()
        };
        let (p, end_p) = (&self.bodies_p, &self.end_momentum);
        let (before, after) = (kinetic(p, start), kinetic(end_p, end));
        let error = (after - before - self.work).abs();
        error / before.max(after).max(f64::MIN_POSITIVE)
    }
}

fn add_armature<P: Scalar, T: Over<P>>(model: &Model<P>, v: &[T], momentum: &mut [T]) {
    let armature = v.iter().zip(model.armature());
    for (p, (&v, &armature)) in momentum.iter_mut().zip(armature) {
        *p += v * armature;
    }
}
