//! Servos on frames: over a step rows along their wrenches, as of tendons (`tendon_servos.rs`).
//!
//! A servo pulls its frame with f along the wrench w, whose power is f ℓ̇. Over a step  f = p − r ℓ̈  within bounds, as of a servo on one joint
//! (`bounded_law.rs`), with  ℓ̈ = J ã + b:  a row with the reference p / r − b and the compliance 1 / r. At an instant, and for the middle of its limits, it is
//! one of the forces of `frame_forces.rs`.

use std::marker::PhantomData;

use super::bounded_law::servo_line;
use super::drives::Driven;
use super::local::{
    FURTHER, INPUT, OfBody, OfCoordinate, POSITION, RATE, TIME_STEP, constant_motion,
    constant_pose, part, seeded_pose, seeded_velocity,
};
use super::numbers::Numbers;
use super::sink::{Acting, ActingPlace, BodyRow, DerivativePoint, Own, Sink};
use super::term::{Term, TermDerivatives};
use crate::cone::Block;
use crate::constraint::{CarriedRow, CarrierMotion, ConstraintRows, Mounted};
use crate::nested::IntoNested;
use crate::scalar::{Dual, MapEach, Over, Scalar};
use crate::sim::actuation::OfActuator;
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::force::{FrameActuator, FrameTerm, PLACE_NUMBERS};
use crate::sim::forces::Forces;
use crate::sim::parameter_slots::PartSlots;
use crate::sim::rows::Rows;
use crate::sim::simulator::Simulator;
use crate::spatial::{Force, Motion, SPATIAL};

/// The term, with its rows and where they are.
#[derive(Clone, Debug)]
pub(crate) struct FrameServos<T> {
    /// `None` without servos on frames.
    rows: Option<Box<ConstraintRows<T>>>,
    /// Indices of the first row and the first block.
    first: [usize; 2],
}

impl<T: Scalar> FrameServos<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let count = simulator.frame_servos().count();
        let nv = simulator.model().nv();
        Self {
            rows: (count > 0).then(|| Box::new(ConstraintRows::new(count, nv))),
            first: [0; 2],
        }
    }

    /// Has its rows where they are of the same robot over other numbers.
    pub(in crate::sim) fn follow<S>(&mut self, other: &FrameServos<S>) {
        self.first = other.first;
    }

    /// The force of a servo along its wrench, where that is not the one of the state: of its row, and the middle of its limits.
    pub(in crate::sim) fn force<P: Scalar>(
        &self,
        at: &EvaluationPoint<'_, P, T>,
        term: &FrameTerm<'_, P>,
        rows: Option<&Rows<T>>,
    ) -> Option<T>
    where
        T: Over<P>,
    {
        let middle = middle(at, term)?;
        let input = term.input()?;
        let mut servos = at.simulator.frame_servos();
        let k = servos.position(|(own, _)| own == input)?;
        let found = rows.and_then(|rows| rows.forces().get(self.first[0] + k));
        Some(middle + found.copied().unwrap_or_else(T::zero))
    }
}

/// The middle of the limits of a servo whose force is a row, which acts beside that; `None` for all else.
pub(super) fn middle<P: Scalar, T: Over<P>>(
    at: &EvaluationPoint<'_, P, T>,
    term: &FrameTerm<'_, P>,
) -> Option<T> {
    let servo = term.actuator().filter(|own| own.servo().is_some())?;
    (!at.is_explicit()).then(|| servo.actuator().band().0)
}

/// Length, rate and input of a servo, as of a coordinate.
fn driven<P: Scalar, L: Over<P>>(own: &FrameActuator<P>, length: L, rate: L, u: L) -> Driven<L> {
    let has_length = own.axis::<L>().has_length();
    Driven {
        q: has_length.then_some(length),
        v: rate,
        u: own.bounded(u),
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for FrameServos<T> {
    fn add_forces(&mut self, _: &EvaluationPoint<'_, P, T>, _: &mut Forces<T>) {}

    fn add_rows(&mut self, at: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>) {
        let rows = &mut balance.rows;
        self.first = [rows.count(), rows.blocks()];
        let Some(own_rows) = self.rows.as_deref_mut().filter(|_| !at.is_explicit()) else {
            return;
        };
        let simulator = at.simulator;
        let axes = simulator.frame_servos();
        let axes = axes.map(|(_, own)| (own.place(), own.axis()));
        own_rows.evaluate_axes(at.model(), axes, at.q(), at.v());
        rows.push_dense(own_rows.rows.len(), &own_rows.jacobian);
        let inputs = simulator.frame_inputs(at.u);
        for ((input, own), row) in simulator.frame_servos().zip(&own_rows.rows) {
            let x = driven(own, row.error, row.rate, inputs[input]);
            let line = servo_line(&own.actuator(), x, at.dt().into());
            let (reference, compliance) = line.row();
            rows.push_reference(reference - row.bias, compliance);
            rows.push_block(Block::Interval, line.bound);
        }
    }
}

/// Derivatives of the term.
#[derive(Clone, Debug)]
pub(crate) struct FrameServoDerivatives<T> {
    slots: PartSlots,
    of: PhantomData<T>,
}

/// A servo whose row acts.
struct Found<'a, T> {
    own: &'a FrameActuator,
    /// Index among frame actuators, of its row and block, and of its row among those of the term.
    input: usize,
    row: usize,
    block: usize,
    k: usize,
    /// Force of the row.
    force: T,
    u: T,
}

/// The direction of the bias of a row, after that of the input; the first of parameters.
const BIAS: usize = FURTHER + 1;

/// Coordinates of the wrench whose derivatives one evaluation has.
const TOGETHER: usize = 3;

fn found<'a, T: Scalar>(
    at: &DerivativePoint<'a, T>,
    term: &FrameServos<T>,
) -> impl Iterator<Item = Found<'a, T>> {
    let (simulator, [row, block]) = (at.point.simulator, term.first);
    let acts = matches!(at.acting, Acting::All(_)) && !at.point.is_explicit();
    let balance = at.balance().filter(|_| acts && term.rows.is_some());
    let inputs = simulator.frame_inputs(at.point.u);
    balance.into_iter().nested(move |balance| {
        let servos = simulator.frame_servos().enumerate();
        servos.map(move |(k, (input, own))| Found {
            own,
            input,
            row: row + k,
            block: block + k,
            k,
            force: balance.rows.forces()[row + k],
            u: inputs[input],
        })
    })
}

impl<T: Scalar> Found<'_, T> {
    /// The row on its body and y, over numbers of that.
    fn y(
        &self,
        mounted: &Mounted<f64>,
        body: &CarrierMotion<OfBody<T>>,
        world: &Motion<OfBody<T>>,
        dt: f64,
    ) -> (CarriedRow<OfBody<T>>, OfBody<T>, OfBody<T>) {
        let mut carried = self.own.axis().carried(&mounted.X_BA, body, world);
        carried.row.bias.eps[BIAS] += T::one();
        let u = Dual::variable(self.u, FURTHER);
        let x = driven(self.own, carried.row.error, carried.row.rate, u);
        let line = servo_line(&self.own.actuator(), x, OfBody::from(dt));
        let without_seen = carried.row.bias + line.at_force(self.force);
        (carried, carried.along_seen + without_seen, without_seen)
    }

    /// States the row and its force on the body, with derivatives in that and in the input.
    fn emit(&self, at: &DerivativePoint<'_, T>, slots: &PartSlots, out: &mut impl Sink<T>) {
        let simulator = at.point.simulator;
        let mounted = self.own.place().mounted(at.point.model());
        let on = mounted.body;
        let world = constant_motion(&out.turn_to(at, None, None).bias);
        let motion = out.turn_to(at, on, None);
        let body = CarrierMotion {
            X_WB: seeded_pose(&motion.X_WB),
            V: seeded_velocity(&motion.V),
            bias: constant_motion(&motion.bias),
            U: constant_motion(&motion.U),
        };
        let (carried, y, without_seen) = self.y(&mounted, &body, &world, at.point.dt());
        let [on_world, unit] = carried.unit_forces.map_each(|unit| part(&unit, |x| x.re));
        let input = simulator.actuated().len() + self.input;
        let row = BodyRow {
            row: self.row,
            y,
            by_seen: unit,
            by_bias: Some(unit.scaled(without_seen.eps[BIAS])),
        };
        out.rows(&[row], Own::Input(input));
        out.force(on, &self.pull(&carried), Own::Nothing);
        let first = slots.frame_terms[self.term(simulator)].start;
        out.place(&ActingPlace {
            frame: self.own.place().frame,
            X_BA: mounted.X_BA,
            origin: first..first + PLACE_NUMBERS / 2,
            turn: first + PLACE_NUMBERS / 2..first + PLACE_NUMBERS,
        });
        if out.wants_parameters() {
            let still = CarrierMotion {
                X_WB: constant_pose(&motion.X_WB),
                V: constant_motion(&motion.V),
                bias: constant_motion(&motion.bias),
                U: constant_motion(&motion.U),
            };
            self.emit_wrench(at, &mounted, &still, &world, first + PLACE_NUMBERS, out);
            out.turn_to(at, None, None);
            let row = BodyRow {
                row: self.row,
                by_bias: Some(on_world.scaled(without_seen.eps[BIAS])),
                ..BodyRow::zero()
            };
            out.rows(&[row], Own::Nothing);
        }
    }

    /// Index among all forces on frames.
    fn term(&self, simulator: &Simulator) -> usize {
        simulator.external_forces().len() + self.input
    }

    /// The force of the row on the body.
    fn pull(&self, carried: &CarriedRow<OfBody<T>>) -> Force<OfBody<T>> {
        let unit = carried.unit_forces[1].to_array();
        Force::from_array(unit.map_each(|x| x.each(|x| x * self.force)))
    }

    /// States derivatives in the coordinates of the wrench, some at a time.
    fn emit_wrench(
        &self,
        at: &DerivativePoint<'_, T>,
        mounted: &Mounted<f64>,
        body: &CarrierMotion<OfBody<T>>,
        world: &Motion<OfBody<T>>,
        slot: usize,
        out: &mut impl Sink<T>,
    ) {
        for first in (0..SPATIAL).step_by(TOGETHER) {
            let mut axis = self.own.axis::<OfBody<T>>();
            let mut wrench = axis.wrench.to_array();
            for k in 0..TOGETHER {
                wrench[first + k].eps[BIAS + k] = T::one();
            }
            axis.wrench = Force::from_array(wrench);
            let mut carried = axis.carried(&mounted.X_BA, body, world);
            let dt = OfBody::from(at.point.dt());
            let u = OfBody::constant_of(self.u);
            let x = driven(self.own, carried.row.error, carried.row.rate, u);
            let line = servo_line(&self.own.actuator(), x, dt);
            carried.row.bias += line.at_force(self.force);
            let row = BodyRow {
                row: self.row,
                y: carried.along_seen + carried.row.bias,
                ..BodyRow::zero()
            };
            let own = Own::Parameters(slot + first..slot + first + TOGETHER);
            out.rows(&[row], own.clone());
            // Its value is stated once.
            let pull = self.pull(&carried).to_array();
            let slopes = Force::from_array(pull.map_each(|x| Dual::new(T::zero(), x.eps)));
            out.force(mounted.body, &slopes, own);
        }
    }

    /// Adds derivatives in limits, numbers of the servo and the time step.
    fn emit_numbers(
        &self,
        rows: &ConstraintRows<T>,
        at: &DerivativePoint<'_, T>,
        slots: &PartSlots,
        out: &mut Numbers<'_, T>,
    ) {
        let row = &rows.rows[self.k];
        let (weight, by_bound) = (out.row_weight(self.row), out.block_weight(self.block));
        let mut slot =
            slots.frame_terms[self.term(at.point.simulator)].start + PLACE_NUMBERS + SPATIAL;
        let dt = Dual::variable(T::constant(at.point.dt()), TIME_STEP);
        let moving = Driven {
            q: self
                .own
                .axis::<T>()
                .has_length()
                .then(|| OfCoordinate::variable(row.error, POSITION)),
            v: Dual::variable(row.rate, RATE),
            u: Dual::variable(self.own.bounded(self.u), INPUT),
        };
        let y = servo_line(&self.own.actuator(), moving, dt).at_force(self.force);
        out.add_time_step(y.eps[TIME_STEP] * weight);
        for share in self.own.limit_shares(self.u) {
            out.add(&(slot..slot + 1), &[y.eps[INPUT] * share * weight]);
            slot += 1;
        }
        let fixed = moving.map(|x| OfActuator::constant_of(x.re));
        let seeded = self.own.actuator().seeded::<T>();
        let line = servo_line(&seeded, fixed, OfActuator::from(at.point.dt()));
        let mut own = line.at_force(self.force).each(|x| x * weight);
        own += line.bound.each(|x| x * by_bound);
        let count = self.own.servo_numbers();
        out.add(&(slot..slot + count), &own.eps[..count]);
    }
}

impl<T: Scalar> FrameServoDerivatives<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            slots: PartSlots::of_placed_parts(simulator),
            of: PhantomData,
        }
    }
}

impl<T: Scalar> TermDerivatives<T> for FrameServoDerivatives<T> {
    type Term = FrameServos<T>;

    fn emit_forces<S: Sink<T>>(
        &mut self,
        _: &DerivativePoint<'_, T>,
        _: &FrameServos<T>,
        _: &mut S,
    ) {
    }

    fn emit_rows<S: Sink<T>>(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &FrameServos<T>,
        out: &mut S,
    ) {
        for found in found(at, term) {
            found.emit(at, &self.slots, out);
        }
    }

    fn emit_numbers(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &FrameServos<T>,
        out: &mut Numbers<'_, T>,
    ) {
        let Some(rows) = term.rows.as_deref().filter(|_| out.has_parts()) else {
            return;
        };
        for found in found(at, term) {
            found.emit_numbers(rows, at, &self.slots, out);
        }
    }
}
