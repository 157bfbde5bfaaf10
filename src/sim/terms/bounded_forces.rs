//! Bounded joint forces over a step: dry friction that holds, and servos that follow the motion within motor limits.
//!
//! Each is a line in the acceleration a of its coordinate within a bound b,  τ = Π(p − r a)  with the projection Π on [−b, b]. For friction the line is vertical,
//!
//! > v⁺ = 0,  or  τ = −b where v⁺ > 0,  or  τ = b where v⁺ < 0,
//!
//! so a sticking joint has the acceleration −v / Δt, and a sliding joint a constant force. For a servo the slope of the line is given by its gains at
//! the end of the step; the force is relative to the middle of the servo's limits, which acts in addition.
//!
//! An active set contains the forces on their line and those at a bound. Forces on their line are added to M. Forward dynamics then shows which
//! forces violate their law; these switch to another piece, until none does. M is positive definite, so there is one solution; block pivots usually
//! find it in one or two rounds, and single pivots always do. Beside forces of a solver, each round is a solution of it (`bounded_rows.rs`).
//!
//! # References
//! [Júdice & Pires 1994].

use super::bounded_beside::Beside;
use super::bounded_law::{Bounded, Kind, Site};
use super::rounds::{TOGETHER, goes_on};
use super::term::Term;
use crate::dynamics::{
    AbaScratch, BEYOND, Decision, Driven as DrivenRobot, JointFriction, RneaScratch,
    frictional_forward_dynamics_into, inverse_dynamics_into, resisted_forward_dynamics_into,
};
use crate::scalar::{Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::forces::Forces;
use crate::sim::simulator::Simulator;
use crate::spatial::Force;

/// Bounded forces of a step.
#[derive(Clone, Debug)]
pub(crate) struct BoundedForces<T: Scalar> {
    /// Where they act.
    sites: Vec<Site>,
    /// One for each site; none where all forces are explicit.
    forces: Vec<Bounded<T>>,
    /// 1 in lanes in which all are rows of a solver, 0 in those in which they are on the pieces that have been found.
    pub(super) in_rows: T,
    /// Indices of the first row and the first block of a solver.
    pub(super) first: [usize; 2],
    /// Joint forces at a = 0 and resistance, with those that are bounded.
    tau: Vec<T>,
    resistance: Vec<T>,
    /// Joint forces of the motion that has been found.
    pub(super) needed: Vec<T>,
    /// Whether some are those of servos.
    has_servos: bool,
    /// Friction of all coordinates, for forward dynamics, which of them decides about it, and whether that has settled.
    friction: Vec<JointFriction<T>>,
    decision: Decision,
    friction_is_settled: bool,
    /// For robots with friction that holds.
    rnea: Option<Box<RneaScratch<T>>>,
    /// For robots with rows.
    pub(super) beside: Option<Box<Beside<T>>>,
}

/// Other forces, and the implicit damping diagonal, by coordinate.
#[derive(Clone, Copy)]
pub(super) struct Given<'a, T> {
    pub(super) tau: &'a [T],
    pub(super) resistance: &'a [T],
    pub(super) bodies: &'a [Force<T>],
}

/// Relative tolerance of a force beyond its bound after some rounds, which rounding in single precision may need.
const FAR_BEYOND: f64 = 1e-5;
/// Rounds while a step is recorded: two in which forces change, and one that finds none.
const RECORDED_ROUNDS: usize = 3;

impl<T: Scalar> BoundedForces<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let sites = Site::all(simulator);
        let nv = match sites.is_empty() {
            true => 0,
            false => simulator.model().nv(),
        };
        let zeros = || vec![T::zero(); nv];
        let holds = sites.iter().any(Site::holds);
        Self {
            forces: Vec::with_capacity(sites.len()),
            in_rows: T::zero(),
            first: [0; 2],
            tau: zeros(),
            resistance: zeros(),
            needed: zeros(),
            has_servos: sites.iter().any(|site| !site.holds()),
            friction: vec![JointFriction::none(); if holds { nv } else { 0 }],
            decision: Decision::Own,
            friction_is_settled: false,
            rnea: holds.then(|| Box::new(RneaScratch::new(simulator.model()))),
            beside: (nv > 0 && simulator.needs_solver()).then(|| Beside::new(simulator.model())),
            sites,
        }
    }

    /// Whether there are none in the last step.
    pub(crate) fn is_empty(&self) -> bool {
        self.forces.is_empty()
    }

    /// Resistance of coordinates in the last step without rows, that of forces on their line among it.
    pub(crate) fn resistance(&self) -> &[T] {
        &self.resistance
    }

    /// Where they act, and the forces of the last step.
    pub(super) fn all(&self) -> impl Iterator<Item = (&Site, &Bounded<T>)> {
        self.sites.iter().zip(&self.forces)
    }

    /// Where they act, and the forces of the last step, which may be changed.
    pub(super) fn all_mut(&mut self) -> impl Iterator<Item = (&Site, &mut Bounded<T>)> {
        self.sites.iter().zip(&mut self.forces)
    }

    /// Finds v̇ under given forces and those that are bounded, by forward dynamics.
    pub(super) fn accelerate<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        given: Given<'_, T>,
        aba: &mut AbaScratch<T>,
        a: &mut [T],
    ) where
        T: Over<P>,
    {
        let (model, q, v, bodies) = (at.model(), at.q(), at.v(), given.bodies);
        if self.is_empty() {
            let (tau, resistance) = (given.tau, given.resistance);
            return resisted_forward_dynamics_into(model, q, v, tau, resistance, bodies, aba, a);
        }
        self.decision = Decision::Own;
        for round in 1.. {
            let changes = self.rub(at, given, aba, a);
            if changes.is_none() {
                self.push(given, |_| true);
                let (tau, resistance) = (&self.tau, &self.resistance);
                resisted_forward_dynamics_into(model, q, v, tau, resistance, bodies, aba, a);
            }
            self.stop(a);
            let is_settled = |changes: T| (0..T::LANES).all(|lane| changes.value(lane) == 0.0);
            self.friction_is_settled = changes.is_some_and(is_settled);
            if !self.friction_is_settled {
                self.decision = Decision::Given;
                self.find_needed(at, given, a);
            }
            let is_found = self.friction_is_settled && !self.has_servos;
            if is_found || !self.revise(a, round) {
                return self.resist(given.resistance);
            }
        }
    }

    /// Finds the resistance of all coordinates.
    fn resist(&mut self, given: &[T]) {
        self.resistance.copy_from_slice(given);
        for (site, own) in self.sites.iter().zip(&self.forces) {
            self.resistance[site.coordinate] += own.parts()[1];
        }
    }

    /// Finds v̇ with friction whose pieces forward dynamics finds, if it can, and the servos on their pieces. Returns by how many pieces the law of friction is
    /// broken.
    fn rub<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        given: Given<'_, T>,
        aba: &mut AbaScratch<T>,
        a: &mut [T],
    ) -> Option<T>
    where
        T: Over<P>,
    {
        self.rnea.as_ref()?;
        let has_servos = self.has_servos;
        if has_servos {
            self.push(given, |site| !site.holds());
        }
        let all = self.sites.iter().zip(&self.forces);
        for (site, own) in all.filter(|(site, _)| site.holds()) {
            self.friction[site.coordinate] = JointFriction {
                stop: own.stop,
                bound: own.line.bound,
                piece: own.piece,
            };
        }
        let driven = DrivenRobot {
            q: at.q(),
            v: at.v(),
            tau: if has_servos { &self.tau } else { given.tau },
            resistance: if has_servos {
                &self.resistance
            } else {
                given.resistance
            },
            external: given.bodies,
        };
        let (model, friction) = (at.model(), &mut self.friction);
        let decision = self.decision;
        let changes = frictional_forward_dynamics_into(model, &driven, friction, decision, aba, a);
        for (site, own) in self.sites.iter().zip(&mut self.forces) {
            if site.holds() {
                own.piece = self.friction[site.coordinate].piece;
            }
        }
        changes
    }

    /// Adds some of the forces to given ones, and their resistance.
    fn push(&mut self, given: Given<'_, T>, wanted: impl Fn(&Site) -> bool) {
        self.tau.copy_from_slice(given.tau);
        self.resistance.copy_from_slice(given.resistance);
        let all = self.sites.iter().zip(&self.forces);
        for (site, own) in all.filter(|(site, _)| wanted(site)) {
            let [push, resistance] = own.parts();
            self.tau[site.coordinate] += push;
            self.resistance[site.coordinate] += resistance;
        }
    }

    /// Sticking joints get exactly the acceleration that stops them.
    pub(super) fn stop(&self, a: &mut [T]) {
        let half = T::constant(0.5);
        for (site, own) in self.all().filter(|(site, _)| site.holds()) {
            let a = &mut a[site.coordinate];
            *a = half.select_lt(self.in_rows, *a, own.select(own.stop, *a));
        }
    }

    /// Whether a joint may stick, in some lane.
    pub(super) fn may_hold(&self) -> bool {
        let mut held = self.all().filter(|(site, _)| site.holds());
        held.any(|(_, own)| own.may_be_on_line())
    }

    /// The joint forces that friction has to give for joints to stick, if some may: as the line is steep, they do not follow from it.
    fn find_needed<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        given: Given<'_, T>,
        a: &[T],
    ) where
        T: Over<P>,
    {
        let some = self.may_hold();
        let Some(rnea) = self.rnea.as_deref_mut().filter(|_| some) else {
            return;
        };
        let (model, q, v, needed) = (at.model(), at.q(), at.v(), &mut self.needed);
        inverse_dynamics_into(model, q, v, a, given.bodies, rnea, needed);
        for (site, own) in self.sites.iter().zip(&self.forces) {
            let k = site.coordinate;
            let [push, resistance] = match site.kind {
                Kind::Friction => [given.tau[k], given.resistance[k]],
                Kind::Servo => own.parts(),
            };
            needed[k] += resistance * a[k] - push;
        }
    }

    /// Lets forces that break their law go over to another piece of it, after so many rounds. Returns whether there are any: while a step is recorded, whether
    /// there may be.
    fn revise(&mut self, a: &[T], round: usize) -> bool {
        let changes = self.change(a, round > TOGETHER);
        let condition = "joints with dry friction and servos at their limits are as found";
        goes_on(changes, round, RECORDED_ROUNDS, condition)
    }

    /// Lets forces that break their law, or the first of them, go over to another piece of it, where they are not rows. Returns by how many pieces.
    pub(super) fn change(&mut self, a: &[T], only_first: bool) -> T {
        let (mut changes, half) = (T::zero(), T::constant(0.5));
        let beyond = if only_first { FAR_BEYOND } else { BEYOND };
        let settled = self.friction_is_settled;
        let all = self.sites.iter().zip(&mut self.forces);
        for (site, own) in all.filter(|(site, _)| !(settled && site.holds())) {
            let (k, line) = (site.coordinate, &own.line);
            let force = match site.kind {
                Kind::Friction => self.needed[k],
                Kind::Servo => line.push - line.resistance * a[k],
            };
            let mut next = own.next(a[k], force, beyond);
            if only_first {
                next = T::zero().select_lt(changes, own.piece, next);
            }
            next = half.select_lt(self.in_rows, own.piece, next);
            changes += (next - own.piece).abs();
            own.piece = next;
        }
        changes
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for BoundedForces<T> {
    #[inline]
    fn add_forces(&mut self, at: &EvaluationPoint<'_, P, T>, _: &mut Forces<T>) {
        self.forces.clear();
        self.friction_is_settled = false;
        self.in_rows = T::zero();
        let actuation = at.simulator.actuation();
        let Some(actuation) = actuation.filter(|_| at.at_end.has_joints()) else {
            return;
        };
        let dt = T::from(at.dt());
        for site in &self.sites {
            let driven = site.driven(at);
            let line = site.line(&actuation.actuators()[site.coordinate], driven, dt);
            self.forces.push(Bounded::new(site, line, driven.v, dt));
        }
    }

    fn add_rows(&mut self, _: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>) {
        self.add_bounded_rows(balance);
    }
}
