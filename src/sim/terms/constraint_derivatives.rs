//! Derivatives of rows of kinematic constraints.
//!
//! A row and its forces are small functions of the poses and motions of the two bodies of its attachment frames: evaluations over numbers of one body
//! give derivatives in its motion, which sinks propagate to the joints. The row of a coupler or a tendon is a function of the positions and rates of
//! its joints (`tied_derivatives.rs`).
//!
//! At an instant a spring is not a row, but a force that depends on error and rate.

use std::ops::Range;

use super::bilateral_row::BilateralRow;
use super::columns::turned_into;
use super::constraints::{Constraints, has_springs};
use super::local::{FURTHER, OfBody, OfCoordinate, TIME_STEP, in_directions_of, part};
use super::numbers::Numbers;
use super::sink::{Acting, ActingPlace, BodyRow, CoordinateSink, DerivativePoint, Own, Sink};
use super::term::TermDerivatives;
use crate::constraint::{
    CarriedRow, CarrierMotion, Constraint, ConstraintKind, ConstraintRow, Hold, Mounted,
};
use crate::scalar::{Dual, MapEach, Over, Scalar};
use crate::sim::parameter_slots::PartSlots;
use crate::sim::simulator::Simulator;
use crate::spatial::{Force, SPATIAL};

/// Direction of the bias of a row; those of numbers that are not of a place follow.
const BIAS: usize = FURTHER;

/// Numbers of a place: its origin, and its turn where it is welded.
const ORIGIN: usize = 3;

/// Derivatives of the term.
#[derive(Clone, Debug)]
pub(crate) struct ConstraintDerivatives<T> {
    slots: Vec<Slots>,
    /// ã, with the entries of these joints for rows that couple joints.
    seen: Vec<T>,
}

/// Parameters of a constraint.
#[derive(Clone, Debug)]
pub(super) struct Slots {
    /// Those of places of anchors, or coefficients of joints.
    pub(super) placed: Range<usize>,
    /// Those of its kind and of its force law.
    pub(super) own: Range<usize>,
    /// Those of its force law, the last of them.
    pub(super) law: Range<usize>,
    /// The largest force, if there is one.
    pub(super) bound: Range<usize>,
}

impl Slots {
    fn new(constraint: &Constraint, all: &Range<usize>) -> Self {
        let bounds = usize::from(constraint.largest_force().is_some());
        let bound = all.end - bounds;
        let own = bound - constraint.own_numbers();
        Self {
            placed: all.start..own,
            own: own..bound,
            law: bound - constraint.law_numbers()..bound,
            bound: bound..all.end,
        }
    }
}

impl<T: Scalar> ConstraintDerivatives<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let slots = PartSlots::of_placed_parts(simulator).constraints;
        let all = simulator.constraints().iter().zip(&slots);
        Self {
            slots: all.map(|(own, all)| Slots::new(own, all)).collect(),
            seen: vec![T::zero(); simulator.model().nv()],
        }
    }
}

/// A constraint with the forces of its rows.
#[derive(Clone, Copy)]
pub(super) struct BilateralConstraint<'a, T: Scalar> {
    pub(super) at: &'a DerivativePoint<'a, T>,
    pub(super) constraint: &'a Constraint,
    pub(super) slots: &'a Slots,
    pub(super) first_row: usize,
    pub(super) first_block: usize,
}

/// Rows between anchors over numbers of one body.
type CarriedRows<T> = [Option<CarriedRow<OfBody<T>>>; SPATIAL];

impl<T: Scalar> BilateralConstraint<'_, T> {
    /// States the rows between attachment frames and their forces on both bodies, with derivatives in one body after the other.
    fn emit_anchored(&self, out: &mut impl Sink<T>) {
        let [first, second] = self.constraint.kind().anchors() else {
            return;
        };
        let mounted = [first, second].map_each(|anchor| anchor.mounted(self.at.point.model()));
        let motions = mounted.map_each(|on| out.turn_to(self.at, on.body, None));
        for side in [1, 0] {
            let on = mounted[side].body;
            if on.is_none() && !out.wants_parameters() {
                continue;
            }
            out.turn_to(self.at, on, None);
            let rows = self.rows(&mounted, &in_directions_of(side, &motions));
            let own = if side == 0 {
                Own::Parameters(self.slots.own.clone())
            } else {
                Own::Nothing
            };
            if self.has_rows() {
                with_rows(
                    &rows,
                    |r, row| self.row(r, side, row),
                    |rows| out.rows(rows, own),
                );
            }
            if !self.is_ahead() {
                for (acting, mounted) in mounted.iter().enumerate() {
                    let force = self.force(&rows, acting, acting == side);
                    out.force(mounted.body, &force, Own::Nothing);
                }
            }
            out.place(&self.place(side, &mounted[side]));
        }
    }

    /// The rows, over numbers of one body and over the constraint's own after them.
    fn rows(
        &self,
        mounted: &[Mounted<f64>; 2],
        bodies: &[CarrierMotion<OfBody<T>>; 2],
    ) -> CarriedRows<T> {
        let constraint = self.constraint.seeded(BIAS + 1);
        let dt = Dual::from(self.at.point.dt());
        let mut rows = [None; SPATIAL];
        let mut next = rows.iter_mut();
        constraint.each_carried_row(mounted, bodies, dt, |mut row| {
            row.row.bias.eps[BIAS] = T::one();
            if let Some(own) = next.next() {
                *own = Some(row);
            }
        });
        rows
    }

    /// y = J ã + bias; over a step half of the bias is that at the velocity after it, a separate part: [`Acting::Ahead`].
    fn row(&self, r: usize, side: usize, own: &CarriedRow<OfBody<T>>) -> BodyRow<T> {
        let (rest, along_seen) = match self.is_ahead() {
            true => (own.row.bias * 0.5, Dual::from(0.0)),
            false => (self.rest(&own.row, self.forces()[r]), own.along_seen),
        };
        let unit = part(&own.unit_forces[side], |x| x.re);
        BodyRow {
            row: self.first_row + r,
            y: along_seen + rest,
            by_seen: if self.is_ahead() { Force::zero() } else { unit },
            by_bias: Some(unit.scaled(rest.eps[BIAS])),
        }
    }

    /// y − J ã of a row under its force, except for the half of the bias that is that at the velocity after a step.
    pub(super) fn rest<const N: usize>(
        &self,
        row: &ConstraintRow<Dual<T, N>>,
        force: T,
    ) -> Dual<T, N> {
        held_rest::<f64, T, N>(row, self.at, force, self.at.point.dt())
    }

    /// Whether it is a force that follows from error and rate, without rows.
    pub(super) fn is_spring_force(&self) -> bool {
        self.constraint.spring().is_some() && has_springs(self.at.point)
    }

    /// Whether it has rows: of a spring or a regularised constraint, without a part at the velocity after a step.
    pub(super) fn has_rows(&self) -> bool {
        let is_soft = self.constraint.regularisation().is_some();
        !(self.is_spring_force() || is_soft && self.is_ahead())
    }

    /// Whether the part of y at the velocity after a step is requested: rows that couple joints linearly have none.
    pub(super) fn is_ahead(&self) -> bool {
        matches!(self.at.acting, Acting::Ahead)
    }

    /// The force of all rows on a body; of another body than the one of the numbers the derivatives alone, since it counts there.
    fn force(&self, rows: &CarriedRows<T>, acting: usize, is_own: bool) -> Force<OfBody<T>> {
        let pushes = rows.iter().flatten().zip(self.forces());
        let springs = self.is_spring_force();
        let sum = pushes.fold(Force::zero(), |sum, (row, &push)| {
            let unit = row.unit_forces[acting].to_array();
            let spring = row.row.spring_force().filter(|_| springs);
            sum + Force::from_array(match spring {
                None => unit.map_each(|x| x.each(|x| x * push)),
                Some(force) => unit.map_each(|x| x * force),
            })
        });
        match is_own {
            true => sum,
            false => Force::from_array(sum.to_array().map_each(|x| Dual::new(T::zero(), x.eps))),
        }
    }

    /// Forces that a solver has found; zeros where a spring is not a row.
    pub(super) fn forces(&self) -> &[T] {
        &self.at.row_forces()[self.first_row..][..self.constraint.rows()]
    }

    fn place(&self, side: usize, mounted: &Mounted<f64>) -> ActingPlace {
        let placed = self.slots.placed.start;
        let first = placed + ORIGIN * side;
        let origin = first..first + ORIGIN;
        let is_weld = matches!(self.constraint.kind(), ConstraintKind::Weld(_));
        let turn = first + 2 * ORIGIN..first + 3 * ORIGIN;
        ActingPlace {
            frame: self.constraint.kind().anchors()[side].frame,
            X_BA: mounted.X_BA,
            origin,
            turn: if is_weld { turn } else { 0..0 },
        }
    }
}

/// Hands rows to `out`, as many as there are.
fn with_rows<T: Scalar>(
    rows: &CarriedRows<T>,
    of: impl Fn(usize, &CarriedRow<OfBody<T>>) -> BodyRow<T>,
    out: impl FnOnce(&[BodyRow<T>]),
) {
    let mut all = [BodyRow::zero(); SPATIAL];
    let mut count = 0;
    for (row, own) in all.iter_mut().zip(rows.iter().flatten()) {
        *row = of(count, own);
        count += 1;
    }
    out(&all[..count]);
}

/// States all rows over the time step, except for the velocity after the step.
fn emit_time_step<T: Scalar>(
    at: &DerivativePoint<'_, T>,
    term: &Constraints<T>,
    out: &mut Numbers<'_, T>,
) {
    let (point, forces) = (at.point, at.row_forces());
    let dt = OfCoordinate::variable(T::constant(point.dt()), TIME_STEP);
    let mut sum = out.sum(None);
    for (index, (row, &force)) in term.rows().iter().zip(forces).enumerate() {
        let row = row.map(OfCoordinate::constant_of);
        let y = held_rest(&row, at, force, dt);
        sum.coordinate_row(index, 0, None, y);
    }
    let slope = sum.value.eps[TIME_STEP];
    out.add_time_step(slope);
}

/// y − J ã of a row under its force, except for the half of the bias that is that at the velocity after a step; zero of a spring that is not a row.
fn held_rest<D: Scalar, T: Scalar, const N: usize>(
    row: &ConstraintRow<Dual<T, N>>,
    at: &DerivativePoint<'_, T>,
    force: T,
    dt: D,
) -> Dual<T, N>
where
    Dual<T, N>: Over<D>,
{
    let zero = Dual::from(0.0);
    let after = match at.acting {
        Acting::Start(_) => Some(row.bias),
        _ => at.point.half_step.map(|_| zero),
    };
    let held = BilateralRow::of(row, after, dt);
    match row.hold {
        Hold::Rigid { .. } => held.rest,
        _ if !held.takes_part() => zero,
        Hold::Spring { .. } | Hold::Soft { .. } => held.rest + held.compliance.each(|x| x * force),
    }
}

impl<T: Scalar> ConstraintDerivatives<T> {
    /// Passes each constraint whose rows have forces to `each`.
    fn each_held(
        &self,
        at: &DerivativePoint<'_, T>,
        mut each: impl FnMut(&BilateralConstraint<'_, T>),
    ) {
        let (mut first_row, mut first_block) = (0, 0);
        for (constraint, slots) in at.point.simulator.constraints().iter().zip(&self.slots) {
            each(&BilateralConstraint {
                at,
                constraint,
                slots,
                first_row,
                first_block,
            });
            first_row += constraint.rows();
            first_block += constraint.blocks();
        }
    }
}

impl<T: Scalar> TermDerivatives<T> for ConstraintDerivatives<T> {
    type Term = Constraints<T>;

    fn emit_forces<S: Sink<T>>(
        &mut self,
        _: &DerivativePoint<'_, T>,
        _: &Constraints<T>,
        _: &mut S,
    ) {
    }

    fn emit_rows<S: Sink<T>>(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &Constraints<T>,
        out: &mut S,
    ) {
        self.each_held(at, |held| {
            held.emit_anchored(out);
            held.emit_tied(term.rows(), out);
        });
    }

    fn emit_numbers(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &Constraints<T>,
        out: &mut Numbers<'_, T>,
    ) {
        // Where nothing holds the rows they take no part.
        if at.row_forces().is_empty() {
            return;
        }
        emit_time_step(at, term, out);
        turned_into(at.point.model(), at.point.v(), at.a, &mut self.seen);
        self.each_held(at, |held| {
            held.emit_own_numbers(term.rows(), out);
            held.emit_tied_numbers(&self.seen, term.rows(), out);
        });
    }
}
