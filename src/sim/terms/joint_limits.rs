//! Joint limits.
//!
//! At an instant a joint limit pushes with the force of its law. Over a step whose joint forces are those of its end, a joint limit with the spring s and the
//! damper c pushes with f = s (δ − Δt w⁺) − c w⁺ at the depth δ, where w is the velocity out of it: one more entry of a damper and a spring
//! while f > 0. With a solver each limit is a compliant row. Without a solver, an active set contains the limits that push. Forward dynamics shows which
//! of them pull, and which of the others would be entered; these change, and the acceleration is computed again, until none does. The forces are a monotone
//! function of the acceleration and M is positive definite, so there is one solution, the same both ways. Changes of all limits at once usually find it in
//! one or two rounds, and changes of the first limit alone always do.
//!
//! # References
//! [Júdice & Pires 1994].

use std::marker::PhantomData;

use super::bounded_forces::{BoundedForces, Given};
use super::local::{OfCoordinate, RATE, TIME_STEP};
use super::numbers::Numbers;
use super::rounds::{TOGETHER, goes_on};
use super::sink::{Acting, CoordinateSink, DerivativePoint, Sink};
use super::term::{Term, TermDerivatives};
use crate::cone::Block;
use crate::contact::StepForce;
use crate::dynamics::{AbaScratch, BEYOND};
use crate::scalar::{Dual, MapEach, Over, Scalar};
use crate::sim::actuation::{End, OfActuator};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::forces::Forces;
use crate::sim::simulator::Simulator;

/// Stops of a step.
#[derive(Clone, Debug)]
pub(crate) struct JointLimits<T> {
    /// All ends of joints in the order of [`each_end`], as if those within reach of the step pushed; none where all forces are explicit or a
    /// solver finds them.
    ends: Vec<Stop<T>>,
    /// Whether one of them may push.
    near: bool,
    /// The rows of a solver, and in which direction each pushes.
    rows: Vec<(usize, f64)>,
    /// Joint forces at a = 0 and resistance, with the active joint limits.
    tau: Vec<T>,
    resistance: Vec<T>,
}

/// A joint limit in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop<T> {
    coordinate: usize,
    /// The direction of its push along the coordinate.
    inward: f64,
    /// Along that direction; zero if the joint limit is released.
    force: StepForce<T>,
    /// The same while it is not released.
    whole: StepForce<T>,
}

impl<T: Scalar> Stop<T> {
    /// `true` if the joint limit pushes in some lane, or if this is unknown.
    fn may_push(&self) -> bool {
        let resistance = self.force.resistance;
        !resistance.has_value() || (0..T::LANES).any(|lane| resistance.value(lane) > 0.0)
    }

    /// A number in the lanes in which the joint limit pushes, zero in others.
    fn where_pushing<const N: usize>(&self, x: Dual<T, N>) -> Dual<T, N> {
        let zero = T::zero();
        x.each(|x| zero.select_lt(self.force.resistance, x, zero))
    }

    /// `true` if the joint limit pushes, which is decided in the first lane.
    pub(crate) fn is_pushing(&self) -> bool {
        self.force.resistance.value(0) > 0.0
    }

    /// 1 in lanes in which the joint limit breaks its law at the acceleration `a`, since it pulls, or is released and would push; 0 in others.
    ///
    /// * `all_push` – whether none has been released yet
    fn breaks<D: Scalar>(&self, dt: D, a: &[T], all_push: bool) -> T
    where
        T: Over<D>,
    {
        let (zero, one) = (T::zero(), T::one());
        let StepForce { push, resistance } = self.whole;
        let force = push - resistance * a[self.coordinate] * (dt * self.inward);
        let pulls = force.select_lt(zero, one, zero);
        match all_push {
            true => pulls,
            false => self.select(pulls, (push.abs() * BEYOND).select_lt(force, one, zero)),
        }
    }

    /// One of two numbers, in each lane.
    fn select(&self, where_pushing: T, where_released: T) -> T {
        T::zero().select_lt(self.force.resistance, where_pushing, where_released)
    }

    /// Releases or engages the joint limit in lanes in which `changes` is positive.
    fn change(&mut self, changes: T) {
        let zero = T::zero();
        let next = |own, whole| zero.select_lt(changes, self.select(zero, whole), own);
        self.force = StepForce {
            push: next(self.force.push, self.whole.push),
            resistance: next(self.force.resistance, self.whole.resistance),
        };
    }
}

/// Rounds while a step is recorded: in the first all within reach push, in the second usually all that remain.
const RECORDED_ROUNDS: usize = 2;

/// Whether an end is beyond its limit in some lane, or would be after the step; while a step is recorded, each may be.
///
/// * `away` – velocity out of the limit
fn may_push<D: Scalar, T: Over<D>>(depth: T, away: T, dt: D) -> bool {
    let step = T::from(dt);
    let arriving = |lane| (-step.value(lane) * away.value(lane)).max(0.0);
    let near = |lane| depth.value(lane) + arriving(lane) > 0.0;
    let unknown = !depth.has_value() || !away.has_value() || !dt.has_value();
    unknown || (0..T::LANES).any(near)
}

/// Passes each limited end of each joint to `each(coordinate, end)`, at the configuration `q`.
fn each_end<P: Scalar, T: Over<P>>(
    simulator: &Simulator<P>,
    q: &[T],
    each: impl FnMut(usize, &End<'_, P, T>),
) {
    if let Some(actuation) = simulator.actuation() {
        actuation.each_end(simulator.model(), q, each);
    }
}

impl<T: Scalar> JointLimits<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let nv = simulator.model().nv();
        let zeros = || vec![T::zero(); nv];
        Self {
            ends: Vec::with_capacity(2 * nv),
            near: false,
            rows: Vec::with_capacity(2 * nv),
            tau: zeros(),
            resistance: zeros(),
        }
    }

    /// Ends of joints in the last step without rows.
    pub(crate) fn ends(&self) -> &[Stop<T>] {
        &self.ends
    }

    /// Whether a joint limit pushes in the last step without rows, which is decided in the first lane.
    pub(crate) fn any_pushes(&self) -> bool {
        self.ends.iter().any(Stop::is_pushing)
    }

    /// Resistance of coordinates in the last step without rows, active joint limits among it, without bounded forces.
    pub(crate) fn resistance(&self) -> &[T] {
        &self.resistance
    }

    /// Finds the v̇ of a step without rows, by forward dynamics, with bounded forces.
    pub(crate) fn accelerate<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        forces: &Forces<T>,
        bounded: &mut BoundedForces<T>,
        aba: &mut AbaScratch<T>,
        a: &mut [T],
    ) where
        T: Over<P>,
    {
        for round in 1.. {
            self.push(forces, at.dt());
            let given = Given {
                tau: &self.tau,
                resistance: &self.resistance,
                bodies: &forces.bodies,
            };
            bounded.accelerate(at, given, aba, a);
            if !self.near || !self.revise(at.dt(), a, round) {
                return;
            }
        }
    }

    /// Adds the active joint limits to joint forces and resistance.
    fn push<D: Scalar>(&mut self, forces: &Forces<T>, dt: D)
    where
        T: Over<D>,
    {
        self.tau.copy_from_slice(&forces.tau);
        self.resistance.copy_from_slice(&forces.resistance);
        for stop in self.ends.iter().filter(|_| self.near) {
            self.tau[stop.coordinate] += stop.force.push * stop.inward;
            self.resistance[stop.coordinate] += stop.force.resistance * dt;
        }
    }

    /// Lets joint limits that break their law at the acceleration `a` change, after so many rounds. Returns whether there are any: while a step is
    /// recorded, whether there may be.
    fn revise<D: Scalar>(&mut self, dt: D, a: &[T], round: usize) -> bool
    where
        T: Over<D>,
    {
        let (zero, mut changes) = (T::zero(), T::zero());
        for stop in &mut self.ends {
            let mut breaks = stop.breaks(dt, a, round == 1);
            if round > TOGETHER {
                breaks = zero.select_lt(changes, zero, breaks);
            }
            stop.change(breaks);
            changes += breaks;
        }
        let condition = "joint limits push or are released as found";
        goes_on(changes, round, RECORDED_ROUNDS, condition)
    }

    /// No ends in a step without rows.
    pub(crate) fn clear(&mut self) {
        self.ends.clear();
        self.near = false;
    }

    /// All ends in a step without rows, as if those within reach of the step pushed.
    pub(crate) fn detect<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>)
    where
        T: Over<P>,
    {
        let (v, dt, ends, any) = (at.v(), at.dt(), &mut self.ends, &mut self.near);
        each_end(at.simulator, at.q(), |coordinate, end| {
            let away = v[coordinate] * end.inward;
            // The logarithm of a depth takes longer than all else of an end.
            let near = may_push(end.depth, away, dt);
            *any |= near;
            let force = match near {
                true => end.stop.step_force(end.depth, away, dt),
                false => StepForce {
                    push: T::zero(),
                    resistance: T::zero(),
                },
            };
            ends.push(Stop {
                coordinate,
                inward: end.inward,
                force,
                whole: force,
            });
        });
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for JointLimits<T> {
    #[inline]
    fn add_forces(&mut self, at: &EvaluationPoint<'_, P, T>, forces: &mut Forces<T>) {
        self.clear();
        self.rows.clear();
        if at.is_explicit() {
            let (v, tau) = (at.v(), &mut forces.tau);
            each_end(at.simulator, at.q(), |k, end| tau[k] += end.force(v[k]));
        } else if !at.may_have_rows() {
            self.detect(at);
        }
    }

    /// A row for each joint beyond an end, or that would be after the step.
    fn add_rows(&mut self, at: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>) {
        self.rows.clear();
        if !at.at_end.has_joints() {
            return;
        }
        let (v, dt) = (at.v(), at.dt());
        let (rows, own) = (&mut balance.rows, &mut self.rows);
        each_end(at.simulator, at.q(), |k, end| {
            let away = v[k] * end.inward;
            if may_push(end.depth, away, dt) {
                let row = end.stop.row(end.depth, away, dt);
                own.push((k, end.inward));
                rows.push_unit(k, end.inward);
                rows.push_reference(row.reference, row.compliance);
                rows.push_block(Block::Ray, T::zero());
            }
        });
    }
}

/// Derivatives of the term; they need no memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointLimitDerivatives<T>(PhantomData<T>);

impl<T: Scalar> JointLimitDerivatives<T> {
    pub(super) fn new(_: &Simulator) -> Self {
        Self(PhantomData)
    }
}

/// An end of a joint over numbers with derivatives, with the velocity of its coordinate and the time step.
struct MovingEnd<'a, 'b, P, D, L> {
    k: usize,
    end: &'a End<'b, P, L>,
    v: L,
    dt: D,
}

impl<P: Scalar, D: Scalar, T: Scalar, const N: usize> MovingEnd<'_, '_, P, D, Dual<T, N>>
where
    Dual<T, N>: Over<P> + Over<D>,
{
    /// All that the end states, weighted.
    ///
    /// * `solved` – its row, where it has one
    fn weighted(
        &self,
        at: &DerivativePoint<'_, T>,
        stop: Option<&Stop<T>>,
        solved: Option<SolvedRow<T>>,
        out: &Numbers<'_, T>,
    ) -> Dual<T, N> {
        let mut sum = out.sum(None);
        self.emit_force(at, stop, &mut sum);
        if let Some(solved) = solved {
            self.emit_row(solved, &mut sum);
        }
        sum.value
    }

    /// States the force of an instant, or that of the end of the step where the joint limit pushes.
    fn emit_force(
        &self,
        at: &DerivativePoint<'_, T>,
        stop: Option<&Stop<T>>,
        out: &mut impl CoordinateSink<Dual<T, N>>,
    ) {
        let Self { k, end, v, dt } = *self;
        if at.point.is_explicit() {
            return out.coordinate(k, None, end.force(v));
        }
        let has_limits = matches!(at.acting, Acting::All(_));
        let Some(stop) = stop.filter(|stop| has_limits && stop.may_push()) else {
            return;
        };
        let force = end.stop.step_force(end.depth, v * end.inward, dt);
        out.coordinate(k, None, stop.where_pushing(force.push * end.inward));
        out.resistance(k, stop.where_pushing(force.resistance * dt));
    }

    /// States y of its row, R f − reference under the force f that a solver has found, unless its compliance is infinite.
    fn emit_row(&self, solved: SolvedRow<T>, out: &mut impl CoordinateSink<Dual<T, N>>) {
        let Self { k, end, v, dt } = *self;
        let row = (end.stop).row(end.depth, v * end.inward, dt);
        if let Some(y) = row.y_at_rest(solved.force) {
            out.coordinate_row(solved.row, k, None, y);
        }
    }
}

/// A row with the force that a solver has found.
#[derive(Clone, Copy)]
struct SolvedRow<T> {
    row: usize,
    force: T,
}

/// Passes each end that has a row, by its coordinate and direction, to the row.
fn solved_rows<'a, T: Scalar>(
    at: &DerivativePoint<'a, T>,
    term: &'a JointLimits<T>,
) -> impl FnMut(usize, f64) -> Option<SolvedRow<T>> + 'a {
    let balance = at.balance();
    let mut rows = (at.point.simulator.bilateral_rows()..)
        .zip(&term.rows)
        .peekable();
    move |k, inward| {
        let (row, _) = rows.next_if(|(_, stop)| **stop == (k, inward))?;
        let force = balance?.rows.forces()[row];
        Some(SolvedRow { row, force })
    }
}

impl<T: Scalar> TermDerivatives<T> for JointLimitDerivatives<T> {
    type Term = JointLimits<T>;

    fn emit_forces<S: Sink<T>>(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &JointLimits<T>,
        out: &mut S,
    ) {
        let (point, mut ends) = (at.point, term.ends.iter());
        let dt = point.dt();
        each_end(point.simulator, point.q(), |k, end| {
            let end = &moving(end);
            let v = OfCoordinate::variable(point.v()[k], RATE);
            MovingEnd { k, end, v, dt }.emit_force(at, ends.next(), out);
        });
    }

    fn emit_rows<S: Sink<T>>(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &JointLimits<T>,
        out: &mut S,
    ) {
        let (point, mut row_of) = (at.point, solved_rows(at, term));
        let dt = point.dt();
        each_end(point.simulator, point.q(), |k, end| {
            if let Some(solved) = row_of(k, end.inward) {
                let end = &moving(end);
                let v = OfCoordinate::variable(point.v()[k], RATE);
                MovingEnd { k, end, v, dt }.emit_row(solved, out);
            }
        });
    }

    fn emit_numbers(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &JointLimits<T>,
        out: &mut Numbers<'_, T>,
    ) {
        let (point, mut ends, mut row_of) = (at.point, term.ends.iter(), solved_rows(at, term));
        let actuation = point.simulator.actuation().filter(|_| out.has_parts());
        let Some(actuation) = actuation else { return };
        let dt = point.dt();
        actuation.each_seeded_end(point.model(), point.q(), |k, end| {
            let v = OfActuator::constant_of(point.v()[k]);
            let moving = MovingEnd { k, end, v, dt };
            let slopes = moving.weighted(at, ends.next(), row_of(k, end.inward), out);
            let part = out.slots().0.actuators[k].clone();
            out.add(&part, &slopes.eps);
        });
        if !point.is_instant {
            emit_time_step(at, term, out);
        }
    }
}

/// States all ends over the time step.
fn emit_time_step<T: Scalar>(
    at: &DerivativePoint<'_, T>,
    term: &JointLimits<T>,
    out: &mut Numbers<'_, T>,
) {
    let (point, mut ends, mut row_of) = (at.point, term.ends.iter(), solved_rows(at, term));
    let dt = OfCoordinate::variable(T::constant(point.dt()), TIME_STEP);
    each_end(point.simulator, point.q(), |k, end| {
        let v = OfCoordinate::constant_of(point.v()[k]);
        let end = &End {
            depth: OfCoordinate::constant_of(end.depth),
            inward: end.inward,
            stop: end.stop,
        };
        let moving = MovingEnd { k, end, v, dt };
        let slopes = moving.weighted(at, ends.next(), row_of(k, end.inward), out);
        out.add_time_step(slopes.eps[TIME_STEP]);
    });
}

/// An end whose depth has its derivative in the position of its coordinate.
fn moving<'a, T: Scalar>(end: &End<'a, f64, T>) -> End<'a, f64, OfCoordinate<T>> {
    let by_position = [-end.inward, 0.0, 0.0, 0.0].map_each(T::constant);
    End {
        depth: OfCoordinate::new(end.depth, by_position),
        inward: end.inward,
        stop: end.stop,
    }
}
