//! Servos on tendons: forces on several joints, which over a step are rows if they follow the motion.
//!
//! A tendon of length L = Σ cᵢ qᵢ pulls with F, cᵢ F on each joint. Over a step F = p − r L̈ within bounds, as of a servo on one joint
//! (`bounded_law.rs`), but r is added to M with the matrix c cᵀ: a row with Jacobian cᵀ, reference p / r and compliance 1 / r.

use std::marker::PhantomData;

use super::bounded_law::servo_line;
use super::drives::Driven;
use super::local::{INPUT, OfCoordinate, POSITION, RATE, TIME_STEP};
use super::numbers::Numbers;
use super::sink::{Acting, DerivativePoint, Sink};
use super::term::{Term, TermDerivatives};
use crate::cone::Block;
use crate::scalar::{Dual, Over, Scalar};
use crate::sim::actuation::{Actuator, OfActuator, Pulled, TendonServo};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::forces::Forces;
use crate::sim::parameter_slots::PartSlots;
use crate::sim::simulator::Simulator;

/// The term: where its rows are.
#[derive(Clone, Debug)]
pub(crate) struct TendonServos<T> {
    /// Indices of the first row and the first block.
    first: [usize; 2],
    of: PhantomData<T>,
}

impl<T: Scalar> TendonServos<T> {
    pub(super) fn new<P: Scalar>(_: &Simulator<P>) -> Self {
        Self {
            first: [0; 2],
            of: PhantomData,
        }
    }
}

/// Length, rate and input of a tendon, as of a coordinate.
fn driven<P: Scalar, T: Over<P>>(
    at: &EvaluationPoint<'_, P, T>,
    own: &TendonServo<P>,
    k: usize,
) -> Driven<T> {
    let motion = own.motion(at.q(), at.v());
    Driven {
        q: Some(motion.length),
        v: motion.rate,
        u: at.u[at.simulator.tendon_input(k)],
    }
}

/// Whether the force of a servo is a row.
fn is_row<P: Scalar, T: Over<P>>(at: &EvaluationPoint<'_, P, T>, own: &TendonServo<P>) -> bool {
    !at.is_explicit() && own.follows()
}

impl<P: Scalar, T: Over<P>> Term<P, T> for TendonServos<T> {
    /// Adds forces that follow from the state, and the middle of those that rows find.
    #[inline]
    fn add_forces(&mut self, at: &EvaluationPoint<'_, P, T>, forces: &mut Forces<T>) {
        for (k, own) in at.simulator.tendon_servos().iter().enumerate() {
            let force = match is_row(at, own) {
                true => own.actuator().band::<T>().0,
                false => {
                    let x = driven(at, own, k);
                    own.actuator().motor(x.q, x.v, x.u)
                }
            };
            for joint in own.joints() {
                forces.tau[joint.v] += force * joint.coefficient;
            }
        }
    }

    fn add_rows(&mut self, at: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>) {
        let rows = &mut balance.rows;
        self.first = [rows.count(), rows.blocks()];
        let all = at.simulator.tendon_servos().iter().enumerate();
        for (k, own) in all.filter(|(_, own)| is_row(at, own)) {
            let line = servo_line(own.actuator(), driven(at, own, k), at.dt().into());
            let (reference, compliance) = line.row();
            let mut row = rows.grow(1);
            for joint in own.joints() {
                row.add(joint.v, T::from(joint.coefficient));
            }
            rows.push_reference(reference, compliance);
            rows.push_block(Block::Interval, line.bound);
        }
    }
}

/// Derivatives of the term.
#[derive(Clone, Debug)]
pub(crate) struct TendonDerivatives<T> {
    slots: PartSlots,
    of: PhantomData<T>,
}

impl<T: Scalar> TendonDerivatives<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            slots: PartSlots::of_placed_parts(simulator),
            of: PhantomData,
        }
    }
}

/// A servo at a point of differentiation.
struct Found<'a, T> {
    index: usize,
    own: &'a TendonServo,
    driven: Driven<T>,
    /// Whether a row finds its force, except for the middle of its limits.
    is_row: bool,
    /// Row, block and force, where rows act.
    row: Option<(usize, usize, T)>,
}

/// All servos, with the forces of their rows where these act.
fn found<'a, T: Scalar>(
    at: &DerivativePoint<'a, T>,
    term: &TendonServos<T>,
) -> impl Iterator<Item = Found<'a, T>> {
    let (point, [first_row, first_block], mut count) = (at.point, term.first, 0);
    let (balance, acts) = (at.balance(), matches!(at.acting, Acting::All(_)));
    let all = point.simulator.tendon_servos().iter().enumerate();
    all.map(move |(index, own)| {
        let is_row = is_row(point, own);
        let row = balance.filter(|_| is_row && acts).map(|balance| {
            let row = first_row + count;
            (row, first_block + count, balance.rows.forces()[row])
        });
        count += usize::from(is_row);
        Found {
            index,
            own,
            driven: driven(point, own, index),
            is_row,
            row,
        }
    })
}

impl<'a, T: Scalar> Found<'a, T> {
    fn entries(&self) -> impl Iterator<Item = &'a Pulled<f64>> + use<'a, T> {
        self.own.joints().iter()
    }

    /// Length, rate, and input with derivatives.
    fn moving(&self) -> Driven<OfCoordinate<T>> {
        Driven {
            q: self.driven.q.map(|q| Dual::variable(q, POSITION)),
            v: Dual::variable(self.driven.v, RATE),
            u: Dual::variable(self.driven.u, INPUT),
        }
    }

    /// Force of the state, over length, rate and input.
    fn force(&self) -> OfCoordinate<T> {
        let x = self.moving();
        self.own.actuator().motor(x.q, x.v, x.u)
    }

    /// y of the row at its force, without L̈, over length, rate, input and the time step.
    fn row_slopes(&self, at: &DerivativePoint<'_, T>, force: T) -> OfCoordinate<T> {
        let dt = Dual::variable(T::constant(at.point.dt()), TIME_STEP);
        servo_line(self.own.actuator(), self.moving(), dt).at_force(force)
    }
}

/// The part of the derivatives in the input.
fn in_input<T: Scalar>(x: &OfCoordinate<T>) -> OfCoordinate<T> {
    let mut out = *x;
    (out.eps[POSITION], out.eps[RATE]) = (T::zero(), T::zero());
    out
}

impl<T: Scalar> TermDerivatives<T> for TendonDerivatives<T> {
    type Term = TendonServos<T>;

    fn emit_forces<S: Sink<T>>(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &TendonServos<T>,
        out: &mut S,
    ) {
        for found in found(at, term).filter(|found| !found.is_row) {
            let (force, input) = (found.force(), at.point.simulator.tendon_input(found.index));
            for k in found.entries() {
                let own = force.each(|x| x * k.coefficient);
                out.coordinate(k.v, Some(input), in_input(&own));
                for l in found.entries() {
                    out.coupled(k.v, l.v, own.each(|x| x * l.coefficient));
                }
            }
        }
    }

    fn emit_rows<S: Sink<T>>(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &TendonServos<T>,
        out: &mut S,
    ) {
        for found in found(at, term) {
            let Some((row, _, force)) = found.row else {
                continue;
            };
            let y = found.row_slopes(at, force);
            for k in found.entries() {
                out.coordinate_row(row, k.v, None, y.each(|x| x * k.coefficient));
            }
            let input = at.point.simulator.tendon_input(found.index);
            out.coordinate_row(row, found.own.joints()[0].v, Some(input), in_input(&y));
        }
    }

    fn emit_numbers(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &TendonServos<T>,
        out: &mut Numbers<'_, T>,
    ) {
        if !out.has_parts() {
            return;
        }
        for found in found(at, term) {
            self.emit_numbers_of(&found, at, out);
        }
    }
}

/// Weighted derivatives of a servo.
struct Weighted<T: Scalar> {
    /// In its numbers.
    own: OfActuator<T>,
    /// In length and rate of its tendon, in L̈, and less that in the weight of each coordinate.
    length: T,
    rate: T,
    acceleration: T,
    force: T,
}

impl<T: Scalar> TendonDerivatives<T> {
    /// Derivatives in the coefficients, in the parameters of the servo and in the time step, weighted.
    fn emit_numbers_of(
        &self,
        found: &Found<'_, T>,
        at: &DerivativePoint<'_, T>,
        out: &mut Numbers<'_, T>,
    ) {
        let weighted = match found.is_row {
            true => found.weighted_row(at, out),
            false => found.weighted_force(at, out),
        };
        let slots = self.slots.tendons[found.index].clone();
        for (i, k) in found.entries().enumerate() {
            let (q, v) = (at.point.q()[k.q], at.point.v()[k.v]);
            let by_motion = weighted.length * q + weighted.rate * v;
            let by_ends = weighted.acceleration * at.a[k.v] - weighted.force * out.mu()[k.v];
            out.add(
                &(slots.start + i..slots.start + i + 1),
                &[by_motion + by_ends],
            );
        }
        let first = slots.start + found.own.joints().len();
        out.add(&(first..slots.end), &weighted.own.eps);
    }
}

impl<T: Scalar> Found<'_, T> {
    /// Σ cᵢ xᵢ.
    fn along(&self, x: &[T]) -> T {
        let entries = self.entries();
        entries.fold(T::zero(), |sum, k| sum + x[k.v] * k.coefficient)
    }

    /// The servo over its numbers, and where it is.
    fn seeded(&self) -> (Actuator<OfActuator<T>>, Driven<OfActuator<T>>) {
        let fixed = self.driven.map(OfActuator::constant_of);
        (self.own.actuator().seeded(), fixed)
    }

    /// Those of a force that follows from the state. Without gains it is as well that of the step's end, which derivatives in gains are those of.
    fn weighted_force(&self, at: &DerivativePoint<'_, T>, out: &Numbers<'_, T>) -> Weighted<T> {
        let (seeded, x) = self.seeded();
        let along = self.along(out.mu());
        let force = match at.point.is_explicit() {
            true => seeded.motor(x.q, x.v, x.u),
            false => {
                let (push, resistance) = {
                    let dt = OfActuator::from(at.point.dt());
                    seeded.motor_over_step(x.q, x.v, x.u, dt)
                };
                let a = self.along(at.a);
                seeded.limited(push - resistance.each(|x| x * a))
            }
        };
        let moving = self.force();
        Weighted {
            own: force.each(|x| -(x * along)),
            length: -(along * moving.eps[POSITION]),
            rate: -(along * moving.eps[RATE]),
            acceleration: T::zero(),
            force: force.re,
        }
    }

    /// Those of a row, where it acts, and of the middle of its limits.
    fn weighted_row(&self, at: &DerivativePoint<'_, T>, out: &mut Numbers<'_, T>) -> Weighted<T> {
        let (seeded, x) = self.seeded();
        let along = self.along(out.mu());
        let middle = seeded.band::<OfActuator<T>>().0;
        let mut weighted = Weighted {
            own: middle.each(|x| -(x * along)),
            length: T::zero(),
            rate: T::zero(),
            acceleration: T::zero(),
            force: middle.re,
        };
        let Some((row, block, force)) = self.row else {
            return weighted;
        };
        let (weight, by_bound) = (out.row_weight(row), out.block_weight(block));
        let line = servo_line(&seeded, x, OfActuator::from(at.point.dt()));
        weighted.own += line.at_force(force).each(|x| x * weight);
        weighted.own += line.bound.each(|x| x * by_bound);
        let moving = self.row_slopes(at, force);
        out.add_time_step(moving.eps[TIME_STEP] * weight);
        weighted.length = moving.eps[POSITION] * weight;
        weighted.rate = moving.eps[RATE] * weight;
        weighted.acceleration = weight;
        weighted.force += force;
        weighted
    }
}
