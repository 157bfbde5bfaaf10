//! Derivatives of bounded forces: p − r a on the line, the bound at a bound, over numbers with derivatives.

use std::marker::PhantomData;

use super::bounded_forces::BoundedForces;
use super::bounded_law::{Bounded, Line, Site};
use super::drives::Driven;
use super::local::{INPUT, OfCoordinate, POSITION, RATE, TIME_STEP};
use super::numbers::Numbers;
use super::sink::{Acting, CoordinateSink, DerivativePoint, Sink};
use super::term::TermDerivatives;
use crate::scalar::{Dual, Over, Scalar};
use crate::sim::actuation::{Actuator, OfActuator};
use crate::sim::simulator::Simulator;

/// Derivatives of the term; they need no memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundedDerivatives<T>(PhantomData<T>);

impl<T: Scalar> BoundedDerivatives<T> {
    pub(super) fn new(_: &Simulator) -> Self {
        Self(PhantomData)
    }
}

/// A row with the force that a solver has found, and the index of its block.
#[derive(Clone, Copy)]
struct SolvedRow<T> {
    row: usize,
    block: usize,
    force: T,
}

/// A bounded force at a point of differentiation.
struct Found<'a, T> {
    site: &'a Site,
    own: &'a Bounded<T>,
    solved: Option<SolvedRow<T>>,
}

/// All bounded forces; none where they do not act.
fn found<'a, T: Scalar>(
    at: &DerivativePoint<'a, T>,
    term: &'a BoundedForces<T>,
) -> impl Iterator<Item = Found<'a, T>> {
    let acts = matches!(at.acting, Acting::All(_));
    let balance = at.balance().filter(|_| term.are_rows());
    let [first_row, first_block] = term.first;
    let all = term.all().filter(move |_| acts).enumerate();
    all.map(move |(k, (site, own))| Found {
        site,
        own,
        solved: balance.map(|balance| SolvedRow {
            row: first_row + k,
            block: first_block + k,
            force: balance.rows.forces()[first_row + k],
        }),
    })
}

impl<T: Scalar> Found<'_, T> {
    /// The law over other numbers.
    ///
    /// * `to` – of position, velocity and input
    fn line<A: Scalar, L: Over<A>>(
        &self,
        at: &DerivativePoint<'_, T>,
        actuator: impl Fn(&Actuator) -> Actuator<A>,
        to: impl Fn(Driven<T>) -> Driven<L>,
        dt: L,
    ) -> Option<Line<L>> {
        let actuation = at.point.simulator.actuation()?;
        let actuator = actuator(&actuation.actuators()[self.site.coordinate]);
        Some(
            self.site
                .line(&actuator, to(self.site.driven(at.point)), dt),
        )
    }

    /// The law over numbers with derivatives in position, velocity, input and the time step.
    fn moving(&self, at: &DerivativePoint<'_, T>) -> Option<Line<OfCoordinate<T>>> {
        let seeded = |x: Driven<T>| Driven {
            q: x.q.map(|q| OfCoordinate::variable(q, POSITION)),
            v: Dual::variable(x.v, RATE),
            u: Dual::variable(x.u, INPUT),
        };
        let dt = Dual::variable(T::constant(at.point.dt()), TIME_STEP);
        self.line(at, |own| *own, seeded, dt)
    }

    /// States the force and its resistance on the piece that holds; of a row y at a fixed force, R f − reference.
    fn emit<const N: usize>(
        &self,
        at: &DerivativePoint<'_, T>,
        line: &Line<Dual<T, N>>,
        out: &mut impl CoordinateSink<Dual<T, N>>,
    ) {
        let (
            Site {
                coordinate, input, ..
            },
            own,
            zero,
        ) = (*self.site, self.own, T::zero());
        if let Some(SolvedRow { row, force, .. }) = self.solved {
            return out.coordinate_row(row, coordinate, input, line.at_force(force));
        }
        let at_bound = line.bound.each(|x| own.select(zero, x * own.piece));
        let push = line.push.each(|x| own.select(x, zero)) + at_bound;
        let resistance = line.resistance.each(|x| own.select(x, zero));
        if at.balance().is_some() {
            // The Delassus diagonal that contact models read is without it.
            let a = at.a[coordinate];
            return out.coordinate(coordinate, input, push - resistance.each(|x| x * a));
        }
        out.coordinate(coordinate, input, push);
        out.resistance(coordinate, resistance);
    }
}

impl<T: Scalar> TermDerivatives<T> for BoundedDerivatives<T> {
    type Term = BoundedForces<T>;

    fn emit_forces<S: Sink<T>>(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &BoundedForces<T>,
        out: &mut S,
    ) {
        for found in found(at, term).filter(|found| found.solved.is_none()) {
            if let Some(line) = found.moving(at) {
                found.emit(at, &line, out);
            }
        }
    }

    fn emit_rows<S: Sink<T>>(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &BoundedForces<T>,
        out: &mut S,
    ) {
        for found in found(at, term).filter(|found| found.solved.is_some()) {
            if let Some(line) = found.moving(at) {
                found.emit(at, &line, out);
            }
        }
    }

    fn emit_numbers(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &BoundedForces<T>,
        out: &mut Numbers<'_, T>,
    ) {
        if !out.has_parts() {
            return;
        }
        let dt = OfActuator::from(at.point.dt());
        for found in found(at, term) {
            let fixed = |x: Driven<T>| x.map(OfActuator::constant_of);
            let own = found.line(at, |own| own.seeded::<T>(), fixed, dt);
            let Some((moving, own)) = found.moving(at).zip(own) else {
                continue;
            };
            let mut sum = out.sum(None);
            found.emit(at, &moving, &mut sum);
            let by_time_step = sum.value.eps[TIME_STEP];
            let mut sum = out.sum(None);
            found.emit(at, &own, &mut sum);
            let mut slopes = sum.value.eps;
            if let Some(solved) = found.solved {
                let weight = out.block_weight(solved.block);
                let bound = slopes.iter_mut().zip(own.bound.eps);
                bound.for_each(|(slope, eps)| *slope += eps * weight);
            }
            out.add_time_step(by_time_step);
            let part = out.slots().0.actuators[found.site.coordinate].clone();
            out.add(&part, &slopes);
        }
    }
}
