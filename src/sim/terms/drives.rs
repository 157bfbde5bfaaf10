//! Joint drives: inputs through motors and servos, springs, dampers, smoothed friction and speed limits.
//!
//! Over a step whose joint forces are those of its end, each is linear in the velocity v⁺ = v + Δt a after the step, with the coefficients of
//! its start. With dampers C and springs K that is
//!
//! > (M + Δt C + Δt² K) a = τ − h − Δt K v,
//!
//! a diagonal added to the mass matrix, which forward dynamics treats like armature.

use std::marker::PhantomData;

use super::local::{INPUT, OfCoordinate, POSITION, RATE, TIME_STEP};
use super::numbers::Numbers;
use super::sink::{CoordinateSink, DerivativePoint, Sink};
use super::term::{Term, TermDerivatives};
use crate::dynamics::{Passive, each_passive};
use crate::scalar::{Dual, Over, Scalar};
use crate::sim::actuation::{Actuator, OfActuator};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::forces::Forces;
use crate::sim::simulator::Simulator;

/// The term; it needs no memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drives<T>(PhantomData<T>);

impl<T: Scalar> Drives<T> {
    pub(super) fn new<P: Scalar>(_: &Simulator<P>) -> Self {
        Self(PhantomData)
    }
}

/// A coordinate that is driven: its position where it has one, velocity and input.
#[derive(Clone, Copy)]
pub(super) struct Driven<L> {
    pub(super) q: Option<L>,
    pub(super) v: L,
    pub(super) u: L,
}

/// The joint force of a coordinate, without joint limits.
#[derive(Clone, Copy)]
struct Drive<L> {
    /// Along the coordinate at a = 0.
    force: L,
    /// The implicit damping diagonal Δt d + Δt² k; `None` if the force is that of the state.
    resistance: Option<L>,
}

impl<L: Scalar> Drive<L> {
    /// τ = A(v, u) − d v − k (q − rest) with the actuator A. Over a step of `dt` (s) at whose end damper and spring act, −Δt k v beside it, and without
    /// forces that are bounded over a step.
    #[inline(always)]
    fn of<P: Scalar, A: Scalar, D: Scalar>(
        passive: &Passive<P>,
        actuator: Option<&Actuator<A>>,
        at: Driven<L>,
        dt: Option<D>,
    ) -> Self
    where
        L: Over<P> + Over<A> + Over<D>,
    {
        let Some(dt) = dt else {
            let mut force = actuator.map_or(at.u, |actuator| actuator.motor(at.q, at.v, at.u));
            if let Some(actuator) = actuator {
                actuator.add_brakes(actuator.friction.as_ref(), at.v, &mut force);
            }
            passive.add_force(at.q, at.v, &mut force);
            return Self {
                force,
                resistance: None,
            };
        };
        let mut own = actuator.map_or((at.u, L::zero()), |actuator| {
            Self::of_actuator(actuator, at, dt.into())
        });
        passive.add_force(at.q, at.v, &mut own.0);
        let spring = at.q.map_or(L::zero(), |_| passive.stiffness.into()) * dt;
        let damper = L::from(passive.damping) + spring;
        Self {
            force: own.0 - spring * at.v,
            resistance: Some(damper * dt + own.1),
        }
    }

    /// Force of an actuator over a step at a = 0, and its implicit damping, without bounded forces.
    #[inline]
    fn of_actuator<A: Scalar>(actuator: &Actuator<A>, at: Driven<L>, dt: L) -> (L, L)
    where
        L: Over<A>,
    {
        let friction = actuator.smoothed_friction();
        let (mut force, loop_resistance) = match actuator.bounded_servo() {
            Some(_) => (actuator.band::<L>().0, L::zero()),
            None => actuator.motor_over_step(at.q, at.v, at.u, dt),
        };
        actuator.add_brakes(friction, at.v, &mut force);
        (
            force,
            actuator.damping(friction, at.v) * dt + loop_resistance,
        )
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for Drives<T> {
    #[inline]
    fn add_forces(&mut self, at: &EvaluationPoint<'_, P, T>, forces: &mut Forces<T>) {
        for (&k, &u) in at.simulator.actuated().iter().zip(at.u) {
            forces.tau[k] = u;
        }
        let actuators = at.simulator.actuation().map(|all| all.actuators());
        let dt = (!at.is_explicit()).then(|| at.dt());
        T::vectorized(
            #[inline(always)]
            || match (actuators, dt) {
                // By itself, since that is most robots, and a third of the instructions.
                (None, None) => drive_all(at, None, None, forces),
                (actuators, dt) => drive_all(at, actuators, dt, forces),
            },
        );
    }
}

/// The force of each coordinate for its input, and the implicit damping diagonal.
#[inline(always)]
fn drive_all<P: Scalar, T: Over<P>>(
    at: &EvaluationPoint<'_, P, T>,
    actuators: Option<&[Actuator<P>]>,
    dt: Option<P>,
    forces: &mut Forces<T>,
) {
    let (q, v) = (at.q(), at.v());
    let Forces {
        tau, resistance, ..
    } = forces;
    each_passive(
        at.model(),
        #[inline(always)]
        |k, own, passive| {
            let driven = Driven {
                q: own.map(|own| q[own]),
                v: v[k],
                u: tau[k],
            };
            let drive = Drive::of(passive, actuators.map(|all| &all[k]), driven, dt);
            tau[k] = drive.force;
            if let Some(x) = drive.resistance {
                resistance[k] = x;
            }
        },
    );
}

/// Derivatives of the term: each force depends on its own coordinate and input only.
#[derive(Clone, Debug)]
pub(crate) struct DriveDerivatives<T> {
    /// The input of each coordinate.
    inputs: Vec<Option<usize>>,
    of: PhantomData<T>,
}

impl<T: Scalar> DriveDerivatives<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            inputs: vec![None; simulator.model().nv()],
            of: PhantomData,
        }
    }

    fn find_inputs(&mut self, simulator: &Simulator) {
        self.inputs.fill(None);
        for (input, &k) in simulator.actuated().iter().enumerate() {
            self.inputs[k] = Some(input);
        }
    }

    /// Passes each coordinate with its input and actuator to `each`.
    fn each_driven(
        &self,
        at: &DerivativePoint<'_, T>,
        mut each: impl FnMut(usize, Option<usize>, &Passive<f64>, Option<&Actuator>, Driven<T>),
    ) {
        let point = at.point;
        let actuators = point.simulator.actuation().map(|all| all.actuators());
        each_passive(point.model(), |k, q, passive| {
            let input = self.inputs[k];
            let driven = Driven {
                q: q.map(|q| point.q()[q]),
                v: point.v()[k],
                u: input.map_or(T::zero(), |input| point.u[input]),
            };
            each(k, input, passive, actuators.map(|all| &all[k]), driven);
        });
    }
}

impl<L: Scalar> Drive<L> {
    fn emit(self, k: usize, input: Option<usize>, out: &mut impl CoordinateSink<L>) {
        out.coordinate(k, input, self.force);
        if let Some(resistance) = self.resistance {
            out.resistance(k, resistance);
        }
    }
}

/// The step at whose end a damper that there could be would act; `None` at an instant.
fn step_of<T: Scalar>(at: &DerivativePoint<'_, T>) -> Option<f64> {
    (!at.point.is_instant).then(|| at.point.dt())
}

impl<T: Scalar> TermDerivatives<T> for DriveDerivatives<T> {
    type Term = Drives<T>;

    fn emit_forces<S: Sink<T>>(&mut self, at: &DerivativePoint<'_, T>, _: &Drives<T>, out: &mut S) {
        self.find_inputs(at.point.simulator);
        let dt = (!at.point.is_explicit()).then(|| at.point.dt());
        self.each_driven(at, |k, input, passive, actuator, x| {
            let seeded = Driven {
                q: x.q.map(|q| OfCoordinate::variable(q, POSITION)),
                v: Dual::variable(x.v, RATE),
                u: Dual::variable(x.u, INPUT),
            };
            Drive::of(passive, actuator, seeded, dt).emit(k, input, out);
        });
    }

    fn emit_numbers(
        &mut self,
        at: &DerivativePoint<'_, T>,
        _: &Drives<T>,
        out: &mut Numbers<'_, T>,
    ) {
        self.each_driven(at, |k, _, passive, actuator, x| {
            let mut sum = out.sum(None);
            let fixed = x.map(OfCoordinate::constant_of);
            let seeded = Passive {
                damping: Dual::variable(T::constant(passive.damping), 0),
                stiffness: Dual::variable(T::constant(passive.stiffness), 1),
                rest: Dual::variable(T::constant(passive.rest), 2),
            };
            let dt = step_of(at).map(|dt| OfCoordinate::variable(T::constant(dt), TIME_STEP));
            Drive::of(&seeded, actuator, fixed, dt).emit(k, None, &mut sum);
            let [damping, stiffness, rest, time_step] = sum.value.eps;
            out.add_time_step(time_step);
            let (_, slots) = out.slots();
            let (own, spring) = (slots.damping + k, slots.spring[k]);
            out.add(&(own..own + 1), &[damping]);
            if let Some(spring) = spring {
                out.add(&(spring..spring + 2), &[stiffness, rest]);
            }
            if let Some(actuator) = actuator.filter(|_| out.has_parts()) {
                let mut sum = out.sum(None);
                let fixed = x.map(OfActuator::constant_of);
                let seeded = actuator.seeded();
                Drive::of(passive, Some(&seeded), fixed, step_of(at)).emit(k, None, &mut sum);
                let slopes = sum.value.eps;
                let part = out.slots().0.actuators[k].clone();
                out.add(&part, &slopes);
            }
        });
    }
}

impl<T> Driven<T> {
    pub(super) fn map<L>(self, to: impl Fn(T) -> L) -> Driven<L> {
        Driven {
            q: self.q.map(&to),
            v: to(self.v),
            u: to(self.u),
        }
    }
}
