//! Joint drives: inputs through motors, springs, dampers, dry friction and speed limits.
//!
//! Over a step whose joint forces are those of its end, each is linear in the velocity v⁺ = v + Δt a after the step, with the coefficients of
//! its start. With dampers C and springs K that is
//!
//! > (M + Δt C + Δt² K) a = τ − h − Δt K v,
//!
//! a diagonal beside the mass matrix, which forward dynamics takes as it takes armature.

use std::marker::PhantomData;

use super::adjoint::{AdjointPoint, StepSlopes, TermAdjoint};
use super::linear_point::{ForceColumns, LinearPoint, OfCoordinate};
use super::term::{Term, TermDerivatives};
use crate::dynamics::{ParameterSlots, Sweep, add_passive_forces, each_resistance};
use crate::model::Model;
use crate::scalar::{Differentiable, Dual, Over, Scalar};
use crate::sim::actuation::{Actuation, OfActuator};
use crate::sim::forces::Forces;
use crate::sim::moment::Moment;
use crate::sim::parameter_slots::{PartSlots, add_to_part};
use crate::sim::simulator::Simulator;

/// The term; it needs no memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drives<T>(PhantomData<T>);

impl<T: Scalar> Drives<T> {
    pub(super) fn new<P: Scalar>(_: &Simulator<P>) -> Self {
        Self(PhantomData)
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for Drives<T> {
    #[inline]
    fn add_forces(&mut self, at: &Moment<'_, P, T>, forces: &mut Forces<T>) {
        let (parts, v, tau) = (Parts::of(at.simulator), at.v(), &mut forces.tau);
        drive(
            &parts,
            &Driven {
                q: at.q(),
                v,
                u: at.u,
            },
            tau,
        );
        if at.is_explicit() {
            return;
        }
        let (dt, resistance) = (at.dt(), &mut forces.resistance);
        each_resistance_of(&parts, v, |k, damping, stiffness| {
            let at_end = AtEnd::new(damping, stiffness, dt);
            resistance[k] = at_end.resistance;
            tau[k] -= at_end.spring * v[k];
        });
    }
}

/// State and input of drives.
struct Driven<'a, T> {
    q: &'a [T],
    v: &'a [T],
    u: &'a [T],
}

/// Parts of drives.
#[derive(Clone, Copy)]
struct Parts<'a, P, A> {
    model: &'a Model<P>,
    actuation: Option<&'a Actuation<A>>,
    actuated: &'a [usize],
}

impl<'a, P: Scalar> Parts<'a, P, P> {
    #[inline]
    fn of(simulator: &'a Simulator<P>) -> Self {
        Self {
            model: simulator.model(),
            actuation: simulator.actuation(),
            actuated: simulator.actuated(),
        }
    }
}

/// τ = A(v, S u) − k (q − rest) − d v with the actuators A, without stops; `tau` is zero before.
fn drive<P: Scalar, A: Scalar, T: Over<P> + Over<A>>(
    parts: &Parts<'_, P, A>,
    at: &Driven<'_, T>,
    tau: &mut [T],
) {
    for (&k, &u) in parts.actuated.iter().zip(at.u) {
        tau[k] = u;
    }
    if let Some(actuation) = parts.actuation {
        actuation.drive(at.v, tau);
    }
    add_passive_forces(parts.model, at.q, at.v, tau);
}

/// Hands what every coordinate loses of its force by a velocity and by a displacement that grow to `each(coordinate, c, k)`, at the
/// velocity `v`.
fn each_resistance_of<P: Scalar, A: Scalar, T: Over<P> + Over<A>>(
    parts: &Parts<'_, P, A>,
    v: &[T],
    mut each: impl FnMut(usize, T, T),
) {
    each_resistance(parts.model, |k, damping, stiffness| {
        let own = parts.actuation;
        let own = own.map_or(T::zero(), |actuation| actuation.damping(k, v[k]));
        each(k, own + damping, stiffness.into());
    });
}

/// Effect of a damper and a spring on a coordinate over a step at whose end they act.
struct AtEnd<T> {
    /// Δt k, the force by the velocity of the start.
    spring: T,
    /// Δt d + Δt² k, which stands beside M.
    resistance: T,
}

impl<T: Scalar> AtEnd<T> {
    #[inline]
    fn new(damping: T, stiffness: T, dt: f64) -> Self {
        let spring = stiffness * dt;
        Self {
            spring,
            resistance: (damping + spring) * dt,
        }
    }
}

/// Velocity and acceleration of the coordinates.
struct Moving<'a, I, const N: usize> {
    v: &'a [Dual<I, N>],
    a: &'a [I],
}

/// Subtracts what dampers and springs do more at the end of a step than at its start, at an acceleration that has been found; keeps what stands beside M.
fn add_at_end<P: Scalar, A: Scalar, I: Scalar, const N: usize>(
    parts: &Parts<'_, P, A>,
    dt: f64,
    at: &Moving<'_, I, N>,
    resistance: &mut [Dual<I, N>],
    tau: &mut [Dual<I, N>],
) where
    Dual<I, N>: Over<P> + Over<A>,
{
    each_resistance_of(parts, at.v, |k, damping, stiffness| {
        let at_end = AtEnd::new(damping, stiffness, dt);
        resistance[k] = at_end.resistance;
        let by_acceleration = at_end.resistance.each(|x| x * at.a[k]);
        tau[k] -= by_acceleration + at_end.spring * at.v[k];
    });
}

/// Derivatives of the term: each force depends on its own coordinate and input only.
#[derive(Clone, Debug)]
pub(crate) struct DriveColumns<T> {
    tau: Vec<OfCoordinate<T>>,
}

impl<T: Scalar> DriveColumns<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            tau: vec![OfCoordinate::from(0.0); simulator.model().nv()],
        }
    }
}

impl<T: Differentiable> TermDerivatives<T> for DriveColumns<T> {
    type Term = Drives<T>;

    fn add_forces(&mut self, at: &LinearPoint<'_, T>, _: &Drives<T>, forces: &mut ForceColumns<T>) {
        let (simulator, x, tau) = (at.moment.simulator, at.coordinates, &mut self.tau);
        tau.fill(OfCoordinate::from(0.0));
        let (q, v, u, parts) = (&x.q[..], &x.v[..], &x.u[..], Parts::of(simulator));
        drive(&parts, &Driven { q, v, u }, tau);
        if !at.moment.is_explicit() {
            add_at_end(
                &parts,
                at.moment.dt(),
                &Moving { v, a: at.a },
                &mut forces.resistance,
                tau,
            );
        }
        for (k, tau) in tau.iter().enumerate() {
            forces.subtract_of_coordinate(k, tau);
        }
        let first = simulator.n_tangent();
        for (column, &row) in simulator.actuated().iter().enumerate() {
            *forces.columns().at(row, first + column) -= tau[row].eps[2];
        }
    }
}

/// Directions of a coordinate: its position, velocity and input, then its damper, the stiffness and the rest position of its spring.
const DIRECTIONS: usize = 6;
const DAMPING: usize = 3;
const STIFFNESS: usize = 4;
const REST: usize = 5;

/// A number of one coordinate with its derivatives in these.
type Local<T> = Dual<T, DIRECTIONS>;

/// The gradient of the term: the robot on numbers of which each depends on its own coordinate only.
#[derive(Clone, Debug)]
pub(crate) struct DriveAdjoint<T: Scalar> {
    model: Model<Local<T>>,
    q: Vec<Local<T>>,
    v: Vec<Local<T>>,
    u: Vec<Local<T>>,
    tau: Vec<Local<T>>,
    /// Diagonal beside M.
    resistance: Vec<Local<T>>,
    slots: PartSlots,
    /// Input of each coordinate.
    given: Vec<T>,
    /// Diagonal beside M, over the numbers of actuators.
    resistance_of_actuators: Vec<OfActuator<T>>,
    /// −μ.
    weights: Vec<T>,
}

impl<T: Scalar> DriveAdjoint<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (model, zeros) = (simulator.model(), |n: usize| vec![Local::from(0.0); n]);
        let slots = ParameterSlots::new(model);
        let (mut indices, mut values) = (Vec::new(), Vec::new());
        let mut seed = |index: usize, value: f64, direction: usize| {
            indices.push(index);
            values.push(Dual::variable(T::constant(value), direction));
        };
        for (k, (&damping, spring)) in model.damping().iter().zip(model.springs()).enumerate() {
            seed(slots.damping + k, damping, DAMPING);
            if let Some(slot) = slots.spring[k] {
                seed(slot, spring.stiffness, STIFFNESS);
                seed(slot + 1, spring.rest, REST);
            }
        }
        let seeded: Model<Local<T>> = model.with_some_parameters(&indices, &values);
        Self {
            model: seeded,
            q: zeros(model.nq()),
            v: zeros(model.nv()),
            u: zeros(simulator.nu()),
            tau: zeros(model.nv()),
            resistance: zeros(model.nv()),
            slots: PartSlots::new(simulator),
            given: vec![T::zero(); model.nv()],
            resistance_of_actuators: vec![OfActuator::from(0.0); model.nv()],
            weights: vec![T::zero(); model.nv()],
        }
    }

    /// Whether dampers and springs are those that the memory was made for.
    pub(crate) fn is_of(&self, model: &Model) -> bool {
        let mut dampers = self.model.damping().iter().zip(model.damping());
        let mut springs = self.model.springs().iter().zip(model.springs());
        dampers.all(|(own, given)| own.value(0) == *given)
            && springs.all(|(own, given)| {
                own.stiffness.value(0) == given.stiffness && own.rest.value(0) == given.rest
            })
    }

    /// The forces at the acceleration that has been found. Those of a step are those of its end also where nothing resists: a damper that there
    /// could be would.
    fn find(&mut self, at: &AdjointPoint<'_, T>) {
        let moment = at.moment;
        let given = [
            (&mut self.q, moment.q()),
            (&mut self.v, moment.v()),
            (&mut self.u, moment.u),
        ];
        for (direction, (out, x)) in given.into_iter().enumerate() {
            let moved = out.iter_mut().zip(x);
            moved.for_each(|(out, &x)| *out = Dual::variable(x, direction));
        }
        let parts = Parts {
            model: &self.model,
            actuation: moment.simulator.actuation(),
            actuated: moment.simulator.actuated(),
        };
        let (q, v, u, tau) = (&self.q[..], &self.v[..], &self.u[..], &mut self.tau);
        tau.fill(Local::from(0.0));
        drive(&parts, &Driven { q, v, u }, tau);
        if !moment.is_instant {
            add_at_end(
                &parts,
                moment.dt(),
                &Moving { v, a: at.a },
                &mut self.resistance,
                tau,
            );
        }
    }

    /// Adds the gradient of what stands beside M, with weights, at the step whose forces have been added.
    pub(crate) fn add_resistance(
        &self,
        weights: &[T],
        slots: &ParameterSlots,
        out: &mut StepSlopes<'_, T>,
    ) {
        for (k, (own, &weight)) in self.resistance.iter().zip(weights).enumerate() {
            out.v[k] += weight * own.eps[1];
        }
        if !out.parameters.is_empty() {
            add_parameters(&self.resistance, weights, slots, out.parameters);
            let own = self
                .resistance_of_actuators
                .iter()
                .zip(&self.slots.actuators);
            for ((resistance, part), &weight) in own.zip(weights) {
                add_to_part(out.parameters, part, &resistance.eps, weight);
            }
        }
    }

    /// Adds the gradient of −μᵀ τ in the numbers of actuators.
    fn add_actuators(&mut self, at: &AdjointPoint<'_, T>, parameters: &mut [T]) {
        let moment = at.moment;
        let Some(actuation) = moment.simulator.actuation() else {
            return;
        };
        self.given.fill(T::zero());
        for (&k, &u) in moment.simulator.actuated().iter().zip(moment.u) {
            self.given[k] = u;
        }
        for (k, actuator) in actuation.actuators().iter().enumerate() {
            let (own, v) = (actuator.seeded(), OfActuator::constant_of(moment.v()[k]));
            let mut tau = own.drive(v, OfActuator::constant_of(self.given[k]));
            if !moment.is_instant {
                let at_end = AtEnd::new(own.damping(v), OfActuator::from(0.0), moment.dt());
                tau -= at_end.resistance.each(|x| x * at.a[k]);
                self.resistance_of_actuators[k] = at_end.resistance;
            }
            add_to_part(
                parameters,
                &self.slots.actuators[k],
                &tau.eps,
                self.weights[k],
            );
        }
    }
}

/// Adds what the numbers of the robot do to numbers of coordinates, with weights.
fn add_parameters<T: Scalar>(x: &[Local<T>], weights: &[T], slots: &ParameterSlots, out: &mut [T]) {
    for (k, (x, &weight)) in x.iter().zip(weights).enumerate() {
        out[slots.damping + k] += weight * x.eps[DAMPING];
        if let Some(spring) = slots.spring[k] {
            out[spring] += weight * x.eps[STIFFNESS];
            out[spring + 1] += weight * x.eps[REST];
        }
    }
}

impl<T: Scalar> TermAdjoint<T> for DriveAdjoint<T> {
    type Term = Drives<T>;

    fn add_forces(
        &mut self,
        at: &AdjointPoint<'_, T>,
        _: &Drives<T>,
        sweep: &mut Sweep<T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        self.find(at);
        let minus_mu = self.weights.iter_mut().zip(at.mu);
        minus_mu.for_each(|(weight, &mu)| *weight = -mu);
        for (k, (tau, &weight)) in self.tau.iter().zip(&self.weights).enumerate() {
            out.q[k] += weight * tau.eps[0];
            out.v[k] += weight * tau.eps[1];
        }
        for (u, &k) in out.u.iter_mut().zip(at.moment.simulator.actuated()) {
            *u += self.weights[k] * self.tau[k].eps[2];
        }
        if !out.parameters.is_empty() {
            add_parameters(&self.tau, &self.weights, &sweep.slots, out.parameters);
        }
        if out.has_parts {
            self.add_actuators(at, out.parameters);
        }
    }
}
