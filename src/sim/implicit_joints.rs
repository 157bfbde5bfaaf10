//! Forces of joints as they are at the end of a step: dampers, springs, dry friction, speed limits and stops.
//!
//! Each is linear in the velocity v⁺ = v + Δt a after the step, with the coefficients of its start. With dampers C and springs K that is
//!
//! > (M + Δt C + Δt² K) a = τ − h − Δt K v,
//!
//! a diagonal beside the mass matrix, which forward dynamics takes as it takes rotors. A stop with the spring s and the damper c pushes with
//! f = s (δ − Δt w⁺) − c w⁺ at the depth δ, where w is the velocity out of it: one more entry of K and C while f > 0. Those that would pull
//! are let go, and the acceleration is found again without them, until none pulls.

use super::simulator::Simulator;
use super::state::State;
use crate::contact::StepForce;
use crate::dynamics::{AbaScratch, resisted_forward_dynamics_into};
use crate::scalar::{Over, Scalar};
use crate::spatial::Force;

/// Working memory of [`accelerate`](Self::accelerate).
#[derive(Clone, Debug)]
pub(crate) struct ImplicitJoints<T> {
    /// Δt c + Δt² k of each coordinate, without stops.
    resistance: Vec<T>,
    /// The joint forces at a = 0, and the resistance, with the stops that push.
    pressed: Vec<T>,
    resisted: Vec<T>,
    /// All ends of joints, in the order of [`Simulator::each_end`].
    stops: Vec<Stop<T>>,
}

/// A stop in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop<T> {
    coordinate: usize,
    /// The direction of its push along the coordinate.
    inward: f64,
    /// Along that direction; zero if the stop is let go.
    force: StepForce<T>,
}

/// A state, and the forces on its bodies.
pub(super) struct Loaded<'a, P, T: Scalar> {
    pub(super) simulator: &'a Simulator<P>,
    pub(super) state: &'a State<T>,
    /// Force on each body, in the body; empty for none.
    pub(super) external: &'a [Force<T>],
}

impl<T: Scalar> Stop<T> {
    /// `true` if the stop pushes, which is decided in the first lane.
    pub(crate) fn is_pushing(&self) -> bool {
        self.force.resistance.value(0) > 0.0
    }

    /// Lets the stop go in the lanes where it pulls at the acceleration `a`. Returns whether there are any.
    fn let_go(&mut self, dt: f64, a: &[T]) -> bool {
        let zero = T::zero();
        let StepForce { push, resistance } = self.force;
        let force = push - resistance * a[self.coordinate] * (dt * self.inward);
        self.force = StepForce {
            push: force.select_lt(zero, zero, push),
            resistance: force.select_lt(zero, zero, resistance),
        };
        (0..T::LANES).any(|lane| force.value(lane) < 0.0)
    }
}

impl<T: Scalar> ImplicitJoints<T> {
    /// Memory for a simulator.
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let zeros = || vec![T::zero(); simulator.model().nv()];
        Self {
            resistance: zeros(),
            pressed: zeros(),
            resisted: zeros(),
            stops: Vec::with_capacity(2 * simulator.model().nv()),
        }
    }

    /// The ends of joints in the last step, in the order of [`Simulator::each_end`]; none if a solver finds the forces of stops.
    pub(crate) fn stops(&self) -> &[Stop<T>] {
        &self.stops
    }

    /// Takes joint forces of the start of a step, without stops, for those of its end at a = 0; stops are kept beside them.
    pub(super) fn start<P: Scalar>(&mut self, at: &Loaded<'_, P, T>, tau: &mut [T])
    where
        T: Over<P>,
    {
        self.resist(at, tau);
        self.meet_stops(at);
    }

    /// Resistance of dampers and springs of each coordinate, Δt c + Δt² k.
    pub(super) fn resistance(&self) -> &[T] {
        &self.resistance
    }

    /// The v̇ of a step under joint forces that [`start`](Self::start) has prepared.
    pub(super) fn accelerate<P: Scalar>(
        &mut self,
        at: &Loaded<'_, P, T>,
        tau: &[T],
        aba: &mut AbaScratch<T>,
        a: &mut [T],
    ) where
        T: Over<P>,
    {
        let (model, dt) = (at.simulator.model(), at.simulator.time_step());
        let motion = (at.state.q.as_slice(), at.state.v.as_slice());
        loop {
            self.press(tau, dt);
            let forces = (&self.pressed[..], &self.resisted[..]);
            resisted_forward_dynamics_into(model, motion, forces, at.external, aba, a);
            if !self.let_go(dt, a) {
                return;
            }
        }
    }

    /// Dampers and springs.
    fn resist<P: Scalar>(&mut self, at: &Loaded<'_, P, T>, tau: &mut [T])
    where
        T: Over<P>,
    {
        let (v, dt) = (at.state.v.as_slice(), at.simulator.time_step());
        let resistance = &mut self.resistance;
        at.simulator.each_resistance(v, |k, damping, stiffness| {
            let spring = stiffness * dt;
            resistance[k] = (damping + spring) * dt;
            tau[k] -= spring * v[k];
        });
    }

    /// All stops, as if those within reach of the step pushed.
    fn meet_stops<P: Scalar>(&mut self, at: &Loaded<'_, P, T>)
    where
        T: Over<P>,
    {
        let (v, dt) = (at.state.v.as_slice(), at.simulator.time_step());
        let stops = &mut self.stops;
        stops.clear();
        at.simulator
            .each_end(at.state.q.as_slice(), |coordinate, end| {
                let away = v[coordinate] * end.inward;
                stops.push(Stop {
                    coordinate,
                    inward: end.inward,
                    force: end.stop.step_force(end.depth, away, dt),
                });
            });
    }

    /// Adds the stops that push to joint forces and resistance.
    fn press(&mut self, tau: &[T], dt: f64) {
        self.pressed.copy_from_slice(tau);
        self.resisted.copy_from_slice(&self.resistance);
        for stop in &self.stops {
            self.pressed[stop.coordinate] += stop.force.push * stop.inward;
            self.resisted[stop.coordinate] += stop.force.resistance * dt;
        }
    }

    /// Lets go the stops that pull at the acceleration `a`. Returns whether there are any.
    fn let_go(&mut self, dt: f64, a: &[T]) -> bool {
        let mut any = false;
        for stop in &mut self.stops {
            any |= stop.let_go(dt, a);
        }
        any
    }
}
