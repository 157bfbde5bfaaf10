//! Stops at the ends of joints.
//!
//! At a moment a stop pushes with the force of its law. Over a step whose joint forces are those of its end, a stop with the spring s and the
//! damper c pushes with f = s (δ − Δt w⁺) − c w⁺ at the depth δ, where w is the velocity out of it: one more entry of a damper and a spring
//! while f > 0. Without a solver, those that would pull are let go, and the acceleration is found again without them, until none pulls; beside
//! other forces that a solver finds, each is a row that gives way.

use std::marker::PhantomData;

use super::adjoint::{AdjointPoint, StepSlopes, TermAdjoint};
use super::columns::RowColumns;
use super::linear_point::{ForceColumns, LinearPoint, OfCoordinate};
use super::term::{Term, TermDerivatives};
use crate::contact::StepForce;
use crate::contact::cone::Block;
use crate::dynamics::{AbaScratch, Sweep, resisted_forward_dynamics_into};
use crate::scalar::{Differentiable, Dual, Over, Scalar};
use crate::sim::actuation::{End, OfActuator};
use crate::sim::balance::Balance;
use crate::sim::forces::Forces;
use crate::sim::moment::Moment;
use crate::sim::parameter_slots::{PartSlots, add_to_part};
use crate::sim::simulator::Simulator;

/// Stops of a step.
#[derive(Clone, Debug)]
pub(crate) struct Stops<T> {
    /// All ends of joints in the order of [`each_end`], as if those within reach of the step pushed; none where all forces are explicit or a
    /// solver finds them.
    ends: Vec<Stop<T>>,
    /// The rows of a solver, and in which direction each pushes.
    rows: Vec<(usize, f64)>,
    /// Joint forces at a = 0 and resistance, with the stops that push.
    tau: Vec<T>,
    resistance: Vec<T>,
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

impl<T: Scalar> Stop<T> {
    /// `true` if the stop pushes in some lane, or if nobody knows.
    fn may_push(&self) -> bool {
        let resistance = self.force.resistance;
        !resistance.has_value() || (0..T::LANES).any(|lane| resistance.value(lane) > 0.0)
    }

    /// A number in the lanes in which the stop pushes, zero in others.
    fn where_pushing<const N: usize>(&self, x: Dual<T, N>) -> Dual<T, N> {
        let zero = T::zero();
        x.each(|x| zero.select_lt(self.force.resistance, x, zero))
    }

    /// `true` if the stop pushes, which is decided in the first lane.
    pub(crate) fn is_pushing(&self) -> bool {
        self.force.resistance.value(0) > 0.0
    }

    /// Lets the stop go in the lanes where it pulls at the acceleration `a`. Returns its force until then, negative there.
    fn let_go(&mut self, dt: f64, a: &[T]) -> T {
        let zero = T::zero();
        let StepForce { push, resistance } = self.force;
        let force = push - resistance * a[self.coordinate] * (dt * self.inward);
        self.force = StepForce {
            push: force.select_lt(zero, zero, push),
            resistance: force.select_lt(zero, zero, resistance),
        };
        force
    }
}

/// Rounds in which stops that pull are let go while the step is recorded: in the first all within reach push, in the second those that are left
/// mostly do.
const RECORDED_ROUNDS: usize = 2;

/// Hands every end of every joint that has a stop to `each(coordinate, end)`, at the configuration `q`.
fn each_end<P: Scalar, T: Over<P>>(
    simulator: &Simulator<P>,
    q: &[T],
    each: impl FnMut(usize, &End<'_, P, T>),
) {
    if let Some(actuation) = simulator.actuation() {
        actuation.each_end(simulator.model(), q, each);
    }
}

impl<T: Scalar> Stops<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let nv = simulator.model().nv();
        let zeros = || vec![T::zero(); nv];
        Self {
            ends: Vec::with_capacity(2 * nv),
            rows: Vec::with_capacity(2 * nv),
            tau: zeros(),
            resistance: zeros(),
        }
    }

    /// Ends of joints in the last step without rows.
    pub(crate) fn ends(&self) -> &[Stop<T>] {
        &self.ends
    }

    /// Whether a stop pushes in the last step without rows, which is decided in the first lane.
    pub(crate) fn any_pushes(&self) -> bool {
        self.ends.iter().any(Stop::is_pushing)
    }

    /// Resistance of coordinates in the last step without rows, stops that push among it.
    pub(crate) fn resistance(&self) -> &[T] {
        &self.resistance
    }

    /// Finds the v̇ of a step without rows, by forward dynamics.
    pub(crate) fn accelerate<P: Scalar>(
        &mut self,
        at: &Moment<'_, P, T>,
        forces: &Forces<T>,
        aba: &mut AbaScratch<T>,
        a: &mut [T],
    ) where
        T: Over<P>,
    {
        for round in 1.. {
            self.push(forces, at.dt());
            resisted_forward_dynamics_into(
                at.model(),
                at.q(),
                at.v(),
                &self.tau,
                &self.resistance,
                &forces.bodies,
                aba,
                a,
            );
            if !self.let_go(at.dt(), a, round) {
                return;
            }
        }
    }

    /// Adds the stops that push to joint forces and resistance.
    fn push(&mut self, forces: &Forces<T>, dt: f64) {
        self.tau.copy_from_slice(&forces.tau);
        self.resistance.copy_from_slice(&forces.resistance);
        for stop in &self.ends {
            self.tau[stop.coordinate] += stop.force.push * stop.inward;
            self.resistance[stop.coordinate] += stop.force.resistance * dt;
        }
    }

    /// Lets go the stops that pull at the acceleration `a`, after so many rounds. Returns whether there are any: while a step is recorded, whether
    /// there may be.
    fn let_go(&mut self, dt: f64, a: &[T], round: usize) -> bool {
        let mut any = false;
        for stop in &mut self.ends {
            let pull = -stop.let_go(dt, a);
            let may = !pull.has_value() && round < RECORDED_ROUNDS;
            any |= may || !pull.is_at_most(0.0, "no stop pulls when those that did are let go");
        }
        any
    }

    /// All ends, as if those within reach of the step pushed.
    fn meet<P: Scalar>(&mut self, at: &Moment<'_, P, T>)
    where
        T: Over<P>,
    {
        let (v, dt, ends) = (at.v(), at.dt(), &mut self.ends);
        each_end(at.simulator, at.q(), |coordinate, end| {
            let away = v[coordinate] * end.inward;
            ends.push(Stop {
                coordinate,
                inward: end.inward,
                force: end.stop.step_force(end.depth, away, dt),
            });
        });
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for Stops<T> {
    #[inline]
    fn add_forces(&mut self, at: &Moment<'_, P, T>, forces: &mut Forces<T>) {
        self.ends.clear();
        self.rows.clear();
        if at.is_explicit() {
            let (v, tau) = (at.v(), &mut forces.tau);
            each_end(at.simulator, at.q(), |k, end| tau[k] += end.force(v[k]));
        } else if !at.has_rows() {
            self.meet(at);
        }
    }

    /// A row for each joint beyond an end, or that would be after the step.
    fn add_rows(&mut self, at: &Moment<'_, P, T>, balance: &mut Balance<T>) {
        if !at.at_end.has_joints() {
            return;
        }
        let (v, dt) = (at.v(), at.dt());
        let (rows, own) = (&mut balance.rows, &mut self.rows);
        each_end(at.simulator, at.q(), |k, end| {
            let away = v[k] * end.inward;
            let near = |lane| end.depth.value(lane) + (-dt * away.value(lane)).max(0.0) > 0.0;
            // While a step is recorded, each end may be.
            let unknown = !end.depth.has_value() || !away.has_value();
            if unknown || (0..T::LANES).any(near) {
                let row = end.stop.row(end.depth, away, dt);
                own.push((k, end.inward));
                rows.push_unit(k, end.inward);
                rows.push_reference(row.reference, row.compliance);
                rows.push_block(Block::Ray, T::zero());
            }
        });
    }
}

/// Derivatives of the term; it needs no memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StopColumns<T>(PhantomData<T>);

impl<T: Scalar> StopColumns<T> {
    pub(super) fn new(_: &Simulator) -> Self {
        Self(PhantomData)
    }
}

impl<T: Differentiable> StopColumns<T> {
    /// Stops that push over a step:  f = push − Δt r · (acceleration inward).
    fn add_pushing(at: &LinearPoint<'_, T>, term: &Stops<T>, forces: &mut ForceColumns<T>) {
        let (x, dt) = (at.coordinates, at.moment.dt());
        let mut ends = term.ends.iter();
        each_end(at.moment.simulator, &x.q, |k, end| {
            let Some(stop) = ends.next().filter(|stop| stop.may_push()) else {
                return;
            };
            let force = end.stop.step_force(end.depth, x.v[k] * end.inward, dt);
            let own = force.resistance * dt;
            let push = force.push * end.inward - own.each(|x| x * at.a[k]);
            forces.subtract_of_coordinate(k, &stop.where_pushing(push));
            forces.resistance[k] += stop.where_pushing(own);
        });
    }
}

impl<T: Differentiable> TermDerivatives<T> for StopColumns<T> {
    type Term = Stops<T>;

    fn add_forces(
        &mut self,
        at: &LinearPoint<'_, T>,
        term: &Stops<T>,
        forces: &mut ForceColumns<T>,
    ) {
        if !at.moment.is_explicit() {
            if !at.is_free {
                Self::add_pushing(at, term, forces);
            }
            return;
        }
        let x = at.coordinates;
        each_end(at.moment.simulator, &x.q, |k, end| {
            forces.subtract_of_coordinate(k, &end.force(x.v[k]));
        });
    }

    fn add_rows(
        &mut self,
        at: &LinearPoint<'_, T>,
        term: &Stops<T>,
        rows: &mut RowColumns<T>,
        _: &mut ForceColumns<T>,
    ) {
        let Some(balance) = at.balance else { return };
        let (x, dt, nv) = (at.coordinates, at.moment.dt(), at.a.len());
        let first = at.moment.simulator.held_rows();
        let mut stops = (first..).zip(&term.rows).peekable();
        each_end(at.moment.simulator, &x.q, |k, end| {
            let takes_part = stops.next_if(|(_, stop)| **stop == (k, end.inward));
            let Some((row, _)) = takes_part else { return };
            if let Some(y) = row_of(end, x.v[k], dt, balance.rows.forces()[row]) {
                *rows.columns.at(row, k) += y.eps[0];
                *rows.columns.at(row, nv + k) += y.eps[1];
            }
        });
    }
}

/// The gradient of the term.
#[derive(Clone, Debug)]
pub(crate) struct StopAdjoint<T> {
    slots: PartSlots,
    of: PhantomData<T>,
}

impl<T: Scalar> StopAdjoint<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            slots: PartSlots::new(simulator),
            of: PhantomData,
        }
    }
}

/// A stop at the acceleration that has been found.
struct FoundStop<'a, I: Scalar> {
    at: &'a AdjointPoint<'a, I>,
    coordinate: usize,
    /// In the step, if that takes the forces of its end.
    is_pushing: bool,
}

impl<I: Scalar> FoundStop<'_, I> {
    /// Force of an end along its coordinate, which moves with `v`; `None` where it does not push over the step.
    fn force<P: Scalar, const N: usize>(
        &self,
        end: &End<'_, P, Dual<I, N>>,
        v: Dual<I, N>,
    ) -> Option<Dual<I, N>>
    where
        Dual<I, N>: Over<P>,
    {
        if self.at.moment.is_explicit() {
            return Some(end.force(v));
        }
        let (a, dt) = (self.at.a[self.coordinate], self.at.moment.dt());
        (self.is_pushing && !self.at.is_free).then(|| {
            let force = end.stop.step_force(end.depth, v * end.inward, dt);
            force.push * end.inward - force.resistance.each(|x| x * (a * dt))
        })
    }
}

/// R f − reference of the row of an end, under the force that a solver has found; `None` where it gives way to any.
fn row_of<P: Scalar, I: Scalar, const N: usize>(
    end: &End<'_, P, Dual<I, N>>,
    v: Dual<I, N>,
    dt: f64,
    force: I,
) -> Option<Dual<I, N>>
where
    Dual<I, N>: Over<P>,
{
    let row = end.stop.row(end.depth, v * end.inward, dt);
    let gives_way = row.compliance.value(0) == f64::INFINITY;
    (!gives_way).then(|| row.compliance.each(|x| x * force) - row.reference)
}

impl<T: Scalar> TermAdjoint<T> for StopAdjoint<T> {
    type Term = Stops<T>;

    fn add_forces(
        &mut self,
        at: &AdjointPoint<'_, T>,
        term: &Stops<T>,
        _: &mut Sweep<T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        let Some(actuation) = at.moment.simulator.actuation() else {
            return;
        };
        let (model, q, v) = (at.moment.model(), at.moment.q(), at.moment.v());
        let found = |coordinate, stop: Option<&Stop<T>>| FoundStop {
            at,
            coordinate,
            is_pushing: stop.is_some_and(Stop::is_pushing),
        };
        let mut ends = term.ends.iter();
        actuation.each_end(model, q, |k, end| {
            let stop = found(k, ends.next());
            if let Some(tau) = stop.force(&moving(end), Dual::variable(v[k], 1)) {
                out.q[k] -= at.mu[k] * tau.eps[0];
                out.v[k] -= at.mu[k] * tau.eps[1];
            }
        });
        if !out.has_parts {
            return;
        }
        let mut ends = term.ends.iter();
        actuation.each_seeded_end(model, q, |k, end| {
            let stop = found(k, ends.next());
            if let Some(tau) = stop.force(end, OfActuator::constant_of(v[k])) {
                let own = &self.slots.actuators[k];
                add_to_part(out.parameters, own, &tau.eps, -at.mu[k]);
            }
        });
    }

    fn add_rows(
        &mut self,
        at: &AdjointPoint<'_, T>,
        term: &Stops<T>,
        _: &mut Sweep<T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        let (moment, dt) = (at.moment, at.moment.dt());
        let Some((rows, actuation)) = at.rows.zip(moment.simulator.actuation()) else {
            return;
        };
        let (model, q, v) = (moment.model(), moment.q(), moment.v());
        let (forces, first) = (rows.balance.rows.forces(), moment.simulator.held_rows());
        let mut stops = (first..).zip(&term.rows).peekable();
        actuation.each_end(model, q, |k, end| {
            let takes_part = stops.next_if(|(_, stop)| **stop == (k, end.inward));
            let Some((row, _)) = takes_part else { return };
            let v = OfCoordinate::variable(v[k], 1);
            if let Some(y) = row_of(&moving(end), v, dt, forces[row]) {
                out.q[k] += rows.y[row] * y.eps[0];
                out.v[k] += rows.y[row] * y.eps[1];
            }
        });
        if !out.has_parts {
            return;
        }
        let mut stops = (first..).zip(&term.rows).peekable();
        actuation.each_seeded_end(model, q, |k, end| {
            let takes_part = stops.next_if(|(_, stop)| **stop == (k, end.inward));
            let Some((row, _)) = takes_part else { return };
            let v = OfActuator::constant_of(v[k]);
            if let Some(y) = row_of(end, v, dt, forces[row]) {
                let own = &self.slots.actuators[k];
                add_to_part(out.parameters, own, &y.eps, rows.y[row]);
            }
        });
    }
}

/// An end whose depth has its derivative in the position of its coordinate.
fn moving<'a, T: Scalar>(end: &End<'a, f64, T>) -> End<'a, f64, OfCoordinate<T>> {
    End {
        depth: OfCoordinate::new(end.depth, [-end.inward, 0.0, 0.0].map(T::constant)),
        inward: end.inward,
        stop: end.stop,
    }
}
