//! Dry friction that holds: a force τ with |τ| ≤ f at each joint that has it, such that over a step of Euler
//!
//! > v⁺ = 0,  or  τ = −f where v⁺ > 0,  or  τ = f where v⁺ < 0.
//!
//! Without a solver, an active set says which joints stick and which way the others slide. A joint that sticks has the acceleration −v / Δt, held by a resistance
//! beside M that nothing moves; a joint that slides has a constant force. Forward dynamics then shows which joints break their law: those go over to
//! another piece of it, until none does. Since M is positive definite there is one solution, which block pivots mostly find in one or two rounds, and
//! pivots one by one always. Beside other forces that a solver finds, each joint is a row with a bounded force.
//!
//! # References
//! [Júdice & Pires 1994].

use super::local::{OfCoordinate, RATE, TIME_STEP};
use super::numbers::Numbers;
use super::sink::{Acting, Sink, SlopePoint};
use super::term::{Term, TermSlopes};
use crate::cone::Block;
use crate::dynamics::{
    AbaScratch, RneaScratch, inverse_dynamics_into, resisted_forward_dynamics_into,
};
use crate::scalar::{Dual, Over, Scalar};
use crate::sim::actuation::OfActuator;
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::forces::Forces;
use crate::sim::simulator::Simulator;
use crate::spatial::Force;

/// Friction of a step.
#[derive(Clone, Debug)]
pub(crate) struct DryFriction<T: Scalar> {
    /// None where all forces are explicit.
    joints: Vec<Joint<T>>,
    /// Indices of the first row and the first block of a solver.
    first: [usize; 2],
    /// Joint forces at a = 0 and resistance, with friction.
    tau: Vec<T>,
    resistance: Vec<T>,
    /// Joint forces of the motion that has been found.
    needed: Vec<T>,
    /// For robots that have such friction.
    rnea: Option<Box<RneaScratch<T>>>,
}

/// A coordinate with friction.
#[derive(Clone, Copy, Debug)]
struct Joint<T> {
    coordinate: usize,
    /// f.
    bound: T,
    /// −v / Δt, the acceleration that brings it to rest.
    stop: T,
    /// Direction in which it slides, −1 or 1; 0 while it sticks.
    slip: T,
}

/// Forces beside which friction acts, and what resists beside M, by coordinates.
#[derive(Clone, Copy)]
pub(super) struct Given<'a, T> {
    pub(super) tau: &'a [T],
    pub(super) resistance: &'a [T],
    pub(super) bodies: &'a [Force<T>],
}

/// Resistance of a joint that sticks, kg or kg·m²: beside it the inertia of any robot is rounding. It holds as well as an infinite one, of which there are no
/// derivatives.
const HELD: f64 = 1e25;
/// Speed up to which a joint is first taken to stick, rad/s or m/s. It changes the number of rounds, not what they find.
const SLOW: f64 = 1e-9;
/// What a joint that sticks may carry beyond its bound, as a part of that: rounding of forces that are larger by some powers of ten does not make it slide.
const BEYOND: f64 = 1e-9;
/// Rounds in which all joints that break their law change at once; from then on the first of them.
const TOGETHER: usize = 10;
/// Most rounds; in random robots there were never more than 12.
const MOST_ROUNDS: usize = 1000;
/// Rounds while a step is recorded: two in which joints change, and one that finds none.
const RECORDED_ROUNDS: usize = 3;

/// −v / Δt
fn stop_of<T: Scalar>(v: T, dt: T) -> T {
    -(v / dt)
}

impl<T: Scalar> Joint<T> {
    fn new(coordinate: usize, bound: T, v: T, dt: T) -> Self {
        let (zero, one) = (T::zero(), T::one());
        let direction = v.select_lt(zero, -one, one);
        Self {
            coordinate,
            bound,
            stop: stop_of(v, dt),
            slip: v.abs().select_lt(T::constant(SLOW), zero, direction),
        }
    }

    /// One of two numbers, in each lane.
    fn select(&self, sticks: T, slides: T) -> T {
        self.slip.abs().select_lt(T::constant(0.5), sticks, slides)
    }

    /// Whether it may stick, in some lane.
    fn may_stick(&self) -> bool {
        !self.slip.has_value() || (0..T::LANES).any(|lane| self.slip.value(lane) == 0.0)
    }

    /// Direction in which it slides where it obeys its law.
    ///
    /// * `a` – its acceleration
    /// * `needed` – the force that it takes to stick
    fn next(&self, a: T, needed: T) -> T {
        let (zero, one, limit) = (T::zero(), T::one(), self.bound * (1.0 + BEYOND));
        let back = needed.select_lt(-limit, one, zero);
        let stuck = limit.select_lt(needed, -one, back);
        // v⁺ / Δt along the direction of sliding
        let ahead = (a - self.stop) * self.slip;
        self.select(stuck, ahead.select_lt(zero, zero, self.slip))
    }
}

impl<T: Scalar> DryFriction<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let joints = simulator.held_joints();
        let nv = if joints > 0 { simulator.model().nv() } else { 0 };
        let zeros = || vec![T::zero(); nv];
        Self {
            joints: Vec::with_capacity(joints),
            first: [0; 2],
            tau: zeros(),
            resistance: zeros(),
            needed: zeros(),
            rnea: (joints > 0).then(|| Box::new(RneaScratch::new(simulator.model()))),
        }
    }

    /// Whether no joint has such friction in the last step.
    pub(crate) fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// Resistance of coordinates in the last step without rows, that of joints that stick among it.
    pub(crate) fn resistance(&self) -> &[T] {
        &self.resistance
    }

    /// Finds v̇ under given forces and friction, by forward dynamics.
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
        if self.joints.is_empty() {
            let (tau, resistance) = (given.tau, given.resistance);
            return resisted_forward_dynamics_into(model, q, v, tau, resistance, bodies, aba, a);
        }
        for round in 1.. {
            self.hold(given);
            let (tau, resistance) = (&self.tau, &self.resistance);
            resisted_forward_dynamics_into(model, q, v, tau, resistance, bodies, aba, a);
            for joint in &self.joints {
                let a = &mut a[joint.coordinate];
                *a = joint.select(joint.stop, *a);
            }
            self.find_needed(at, given, a);
            if !self.revise(a, round) {
                return;
            }
        }
    }

    /// Adds friction to given forces and resistance.
    fn hold(&mut self, given: Given<'_, T>) {
        self.tau.copy_from_slice(given.tau);
        self.resistance.copy_from_slice(given.resistance);
        let held = T::constant(HELD);
        for joint in &self.joints {
            let k = joint.coordinate;
            let slides = self.tau[k] - joint.bound * joint.slip;
            self.tau[k] = joint.select(joint.stop * held, slides);
            self.resistance[k] = joint.select(held, self.resistance[k]);
        }
    }

    /// The force that it takes each joint to stick, if some may.
    fn find_needed<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        given: Given<'_, T>,
        a: &[T],
    ) where
        T: Over<P>,
    {
        let rnea = self.rnea.as_deref_mut();
        let Some(rnea) = rnea.filter(|_| self.joints.iter().any(Joint::may_stick)) else {
            return;
        };
        let (model, q, v, needed) = (at.model(), at.q(), at.v(), &mut self.needed);
        inverse_dynamics_into(model, q, v, a, given.bodies, rnea, needed);
        for joint in &self.joints {
            let k = joint.coordinate;
            needed[k] += given.resistance[k] * a[k] - given.tau[k];
        }
    }

    /// Lets joints that break their law go over to another piece of it, after so many rounds. Returns whether there are any: while a step is recorded, whether
    /// there may be.
    fn revise(&mut self, a: &[T], round: usize) -> bool {
        let mut changes = T::zero();
        for joint in &mut self.joints {
            let k = joint.coordinate;
            let mut next = joint.next(a[k], self.needed[k]);
            if round > TOGETHER {
                next = T::zero().select_lt(changes, joint.slip, next);
            }
            changes += (next - joint.slip).abs();
            joint.slip = next;
        }
        let may = !changes.has_value() && round < RECORDED_ROUNDS;
        let last = changes.has_value() && round == MOST_ROUNDS;
        let settled = || changes.is_at_most(0.0, "joints with dry friction stick or slide as found");
        !last && (may || !settled())
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for DryFriction<T> {
    #[inline]
    fn add_forces(&mut self, at: &EvaluationPoint<'_, P, T>, _: &mut Forces<T>) {
        self.joints.clear();
        let actuation = at.simulator.actuation();
        let Some(actuation) = actuation.filter(|_| at.at_end.has_joints()) else {
            return;
        };
        let (v, dt) = (at.v(), T::from(at.dt()));
        let frictions = actuation.exact_frictions();
        let joints = frictions.map(|(k, friction)| Joint::new(k, friction.force.into(), v[k], dt));
        self.joints.extend(joints);
    }

    /// A row for each joint, y = v⁺ / Δt.
    fn add_rows(&mut self, _: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>) {
        let rows = &mut balance.rows;
        self.first = [rows.count(), rows.blocks()];
        for joint in &self.joints {
            rows.push_unit(joint.coordinate, 1.0);
            rows.push_reference(joint.stop, T::zero());
            rows.push_block(Block::Interval, joint.bound);
        }
    }
}

/// Derivatives of the term; they need no memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DryFrictionSlopes<T>(std::marker::PhantomData<T>);

impl<T: Scalar> DryFrictionSlopes<T> {
    pub(super) fn new(_: &Simulator) -> Self {
        Self(std::marker::PhantomData)
    }
}

/// −v / Δt of a joint, with its derivatives in both.
fn moving_stop<T: Scalar>(at: &SlopePoint<'_, T>, joint: &Joint<T>) -> OfCoordinate<T> {
    let (v, dt) = (at.point.v()[joint.coordinate], at.point.dt());
    stop_of(
        Dual::variable(v, RATE),
        Dual::variable(T::constant(dt), TIME_STEP),
    )
}

/// Joints whose friction is found without rows; none where it does not act.
fn without_rows<'a, T: Scalar>(
    at: &SlopePoint<'_, T>,
    term: &'a DryFriction<T>,
) -> &'a [Joint<T>] {
    match at.acting {
        Acting::All(None) => &term.joints,
        _ => &[],
    }
}

/// Joints whose friction is that of rows, each with the indices of its row and its block.
fn with_rows<'a, T: Scalar>(
    at: &SlopePoint<'_, T>,
    term: &'a DryFriction<T>,
) -> impl Iterator<Item = ([usize; 2], &'a Joint<T>)> + use<'a, T> {
    let count = at.balance().map_or(0, |_| term.joints.len());
    let first = term.first;
    let joints = term.joints[..count].iter().enumerate();
    joints.map(move |(k, joint)| (first.map(|first| first + k), joint))
}

impl<T: Scalar> TermSlopes<T> for DryFrictionSlopes<T> {
    type Term = DryFriction<T>;

    /// A joint that sticks is held by the resistance; the force of one that slides is the same everywhere.
    fn emit_forces<S: Sink<T>>(
        &mut self,
        at: &SlopePoint<'_, T>,
        term: &DryFriction<T>,
        out: &mut S,
    ) {
        for joint in without_rows(at, term) {
            let held = joint.select(T::constant(HELD), T::zero());
            let force = moving_stop(at, joint).each(|x| x * held);
            out.coordinate(joint.coordinate, None, force);
            out.resistance(joint.coordinate, Dual::constant_of(held));
        }
    }

    fn emit_rows<S: Sink<T>>(
        &mut self,
        at: &SlopePoint<'_, T>,
        term: &DryFriction<T>,
        out: &mut S,
    ) {
        for ([row, _], joint) in with_rows(at, term) {
            out.coordinate_row(row, joint.coordinate, -moving_stop(at, joint));
        }
    }

    fn emit_numbers(
        &mut self,
        at: &SlopePoint<'_, T>,
        term: &DryFriction<T>,
        out: &mut Numbers<'_, T>,
    ) {
        if !out.has_parts() {
            return;
        }
        for joint in without_rows(at, term) {
            let mu = out.mu()[joint.coordinate];
            let held = joint.select(T::constant(HELD), T::zero());
            let by_stop = -(mu * held);
            add_numbers(at, joint, [by_stop, mu * joint.slip], out);
        }
        for ([row, block], joint) in with_rows(at, term) {
            let weights = [-out.row_weight(row), out.block_weight(block)];
            add_numbers(at, joint, weights, out);
        }
    }
}

/// Adds the gradient in the time step and in the numbers of the actuator of a joint.
///
/// * `weights` – of −v / Δt, and of f
fn add_numbers<T: Scalar>(
    at: &SlopePoint<'_, T>,
    joint: &Joint<T>,
    [stop, bound]: [T; 2],
    out: &mut Numbers<'_, T>,
) {
    out.add_time_step(moving_stop(at, joint).eps[TIME_STEP] * stop);
    let k = joint.coordinate;
    let actuation = at.point.simulator.actuation();
    let actuator = actuation.map(|all| all.actuators()[k].seeded());
    let friction = actuator.and_then(|actuator| actuator.friction);
    if let Some(friction) = friction {
        let force: OfActuator<T> = friction.force;
        let part = out.slots().0.actuators[k].clone();
        out.add(&part, &force.eps.map(|slope| slope * bound));
    }
}
