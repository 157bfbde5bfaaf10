//! Derivatives of rows of kinematic constraints.
//!
//! Seen from the two bodies that carry its anchors, a row is a small function of their poses and motions, and so are the forces of it on both: evaluations
//! over numbers of one body give derivatives in its motion, which sinks take to the joints. Rows that look ahead contain half of the bias at the velocity
//! after the step. The row of a coupler is a function of the positions and rates of two joints.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::Range;

use super::columns::turned_into;
use super::constraints::Constraints;
use super::local::{
    FURTHER, OfBody, OfCoordinate, POSITION, RATE, TIME_STEP, constant_motion, constant_pose, part,
    seeded_pose, seeded_velocity,
};
use super::numbers::Numbers;
use super::sink::{ActingPlace, Bias, BodyRow, CoordinateSink, Held, Own, Sink, SlopePoint};
use super::term::TermSlopes;
use crate::constraint::{
    CarriedRow, CarrierMotion, Constraint, ConstraintKind, ConstraintRow, CoupledJoint, Mounted,
};
use crate::model::Body;
use crate::scalar::{Dual, Over, Scalar, vectorized};
use crate::sim::parameter_slots::PartSlots;
use crate::sim::simulator::Simulator;
use crate::spatial::{Force, SPATIAL};

/// Direction of the bias of a row; those of numbers that are not of a place follow.
const BIAS: usize = FURTHER;

/// Numbers of a place: its origin, and its turn where it is welded.
const ORIGIN: usize = 3;

/// Derivatives of the term.
#[derive(Clone, Debug)]
pub(crate) struct ConstraintSlopes<T> {
    /// Parameters of each constraint.
    slots: Vec<Range<usize>>,
    /// ã, of which the rows of couplers know the two entries of their joints.
    seen: Vec<T>,
}

impl<T: Scalar> ConstraintSlopes<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            slots: PartSlots::new(simulator).constraints,
            seen: vec![T::zero(); simulator.model().nv()],
        }
    }
}

/// A constraint with the forces of its rows.
struct HeldConstraint<'a, T: Scalar> {
    at: &'a SlopePoint<'a, T>,
    held: Held<'a, T>,
    constraint: &'a Constraint,
    /// Its own parameters.
    slots: &'a Range<usize>,
    first_row: usize,
}

/// Rows between anchors over numbers of one body.
type CarriedRows<T> = [Option<CarriedRow<OfBody<T>>>; SPATIAL];

impl<T: Scalar> HeldConstraint<'_, T> {
    /// States the rows between anchors and what they do to both bodies, in derivatives of one body after the other.
    fn emit_anchored(&self, out: &mut impl Sink<T>) {
        let [first, second] = self.constraint.kind().anchors() else {
            return;
        };
        let mounted = [first, second].map(|anchor| anchor.mounted(self.at.moment.model()));
        let motions = mounted.map(|on| {
            let now = out.turn_to(self.at, on.body, None);
            let after = out.motion_after();
            [now, after]
        });
        let [now, after] = [0, 1].map(|when| motions.map(|motion| motion[when]));
        for side in [1, 0] {
            let on = mounted[side].body;
            if on.is_none() && !out.wants_parameters() {
                continue;
            }
            out.turn_to(self.at, on, None);
            let rows = self.rows(&mounted, &in_directions_of(side, &now));
            let own = self.slots.end - self.constraint.own_numbers()..self.slots.end;
            let own = if side == 0 {
                Own::Parameters(own)
            } else {
                Own::Nothing
            };
            with_rows(
                &rows,
                |r, row| self.row(r, side, row),
                |rows| out.rows(rows, own),
            );
            for (acting, mounted) in mounted.iter().enumerate() {
                let force = self.force(&rows, acting, acting == side);
                out.force(mounted.body, &force, Own::Nothing);
            }
            if let Bias::Ahead(_) = self.held.bias {
                out.motion_after();
                let rows = self.rows(&mounted, &in_directions_of(side, &after));
                with_rows(
                    &rows,
                    |r, row| self.row_after(r, side, row),
                    |rows| {
                        out.rows_after(rows);
                    },
                );
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
        let mut rows = [None; SPATIAL];
        vectorized(
            #[inline(always)]
            || {
                let mut next = rows.iter_mut();
                constraint.each_carried_row(mounted, bodies, |mut row| {
                    row.row.bias.eps[BIAS] = T::one();
                    if let Some(own) = next.next() {
                        *own = Some(row);
                    }
                });
            },
        );
        rows
    }

    /// y = J ã + bias.
    fn row(&self, r: usize, side: usize, own: &CarriedRow<OfBody<T>>) -> BodyRow<T> {
        let stabilized = stabilized(&own.row, &self.held.bias, self.at.moment.dt());
        let unit = part(&own.unit_forces[side], |x| x.re);
        BodyRow {
            row: self.first_row + r,
            y: own.along_seen + stabilized,
            by_seen: unit,
            by_bias: Some(unit.scaled(stabilized.eps[BIAS])),
        }
    }

    /// The half of the bias that is that at the velocity after the step.
    fn row_after(&self, r: usize, side: usize, own: &CarriedRow<OfBody<T>>) -> BodyRow<T> {
        let unit = part(&own.unit_forces[side], |x| x.re);
        BodyRow {
            row: self.first_row + r,
            y: own.row.bias * 0.5,
            by_seen: Force::zero(),
            by_bias: Some(unit.scaled(T::constant(0.5))),
        }
    }

    /// The force of all rows on a body; of another body than the one of the numbers the derivatives alone, since it counts there.
    fn force(&self, rows: &CarriedRows<T>, acting: usize, is_own: bool) -> Force<OfBody<T>> {
        let pushes = rows.iter().flatten().zip(self.forces());
        let sum = pushes.fold(Force::zero(), |sum, (row, &push)| {
            let unit = row.unit_forces[acting].to_array();
            sum + Force::from_array(unit.map(|x| x.each(|x| x * push)))
        });
        match is_own {
            true => sum,
            false => Force::from_array(sum.to_array().map(|x| Dual::new(T::zero(), x.eps))),
        }
    }

    fn forces(&self) -> &[T] {
        &self.held.forces[self.first_row..][..self.constraint.rows()]
    }

    fn place(&self, side: usize, mounted: &Mounted<f64>) -> ActingPlace {
        let first = self.slots.start + ORIGIN * side;
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

/// The bias of a row, but for the half of it that is that at the velocity after a step.
fn stabilized<D: Scalar, N: Over<D>, T>(row: &ConstraintRow<N>, bias: &Bias<'_, T>, dt: D) -> N {
    match bias {
        Bias::Moment => row.at_moment(dt),
        Bias::Start => row.over_step(row.bias, dt),
        Bias::Ahead(_) => row.over_step(N::zero(), dt),
    }
}

/// States all rows over the time step, but for the velocity after the step.
fn emit_time_step<T: Scalar>(
    at: &SlopePoint<'_, T>,
    term: &Constraints<T>,
    out: &mut Numbers<'_, T>,
) {
    let Some(held) = at.held else { return };
    let dt = OfCoordinate::variable(T::constant(at.moment.dt()), TIME_STEP);
    let mut sum = out.sum(None);
    term.each_constant_row(|index, row| {
        sum.coordinate_row(index, 0, stabilized(row, &held.bias, dt));
    });
    let slope = sum.value.eps[TIME_STEP];
    out.add_time_step(slope);
}

/// Motions of both bodies with derivatives in pose and velocity of one.
fn in_directions_of<T: Scalar>(
    side: usize,
    motions: &[CarrierMotion<T>; 2],
) -> [CarrierMotion<OfBody<T>>; 2] {
    std::array::from_fn(|i| {
        let at = &motions[i];
        let (X_WB, V) = match i == side {
            true => (seeded_pose(&at.X_WB), seeded_velocity(&at.V)),
            false => (constant_pose(&at.X_WB), constant_motion(&at.V)),
        };
        CarrierMotion {
            X_WB,
            V,
            bias: constant_motion(&at.bias),
            U: constant_motion(&at.U),
        }
    })
}

/// A joint of a coupler over numbers: its own position and rate, and its rate by ã.
#[derive(Clone, Copy)]
struct CoupledMotion<L> {
    joint: CoupledJoint<L>,
    seen: L,
}

impl<T: Scalar> CoupledMotion<T> {
    fn of(body: &Body<f64>, at: &SlopePoint<'_, T>, seen: &[T]) -> Self {
        Self {
            joint: CoupledJoint::of(body, at.moment.q(), at.moment.v()),
            seen: body.scaled(seen[body.v]),
        }
    }

    fn map<L>(self, to: impl Fn(T) -> L) -> CoupledMotion<L> {
        CoupledMotion {
            joint: CoupledJoint {
                position: to(self.joint.position),
                rate: to(self.joint.rate),
            },
            seen: to(self.seen),
        }
    }
}

impl<T: Scalar> HeldConstraint<'_, T> {
    /// y = J ã + bias of a coupler.
    fn coupled_row<P: Scalar, const N: usize>(
        &self,
        constraint: &Constraint<P>,
        motions: &[CoupledMotion<Dual<T, N>>; 2],
    ) -> Option<Dual<T, N>>
    where
        Dual<T, N>: Over<P>,
    {
        let row = constraint.row_of_joints(&motions.map(|at| at.joint))?;
        let seen = constraint.rate_of_joints(motions.map(|at| at.seen))?;
        let dt: f64 = self.at.moment.dt();
        Some(seen + stabilized::<f64, _, _>(&row, &self.held.bias, dt))
    }

    /// States the row of a coupler in derivatives of one joint after the other; its forces on them are constant.
    fn emit_coupler(&self, bodies: [&Body<f64>; 2], seen: &[T], out: &mut impl Sink<T>) {
        let all = bodies.map(|body| CoupledMotion::of(body, self.at, seen));
        for (i, body) in bodies.into_iter().enumerate() {
            let mut motions = all.map(|at| at.map(OfCoordinate::constant_of));
            let CoupledJoint { position, rate } = &mut motions[i].joint;
            position.eps[POSITION] = body.scaled(T::one());
            rate.eps[RATE] = body.scaled(T::one());
            if let Some(y) = self.coupled_row(self.constraint, &motions) {
                out.coordinate_row(self.first_row, body.v, y);
            }
        }
    }

    /// In the numbers of a coupler, and in ratio and offset of joints of it that follow another one.
    fn emit_coupler_numbers(&self, indices: [usize; 2], seen: &[T], out: &mut Numbers<'_, T>) {
        let (moment, y, force) = (self.at.moment, self.first_row, self.forces()[0]);
        let bodies = indices.map(|i| &moment.model().bodies()[i]);
        let all = bodies.map(|body| CoupledMotion::of(body, self.at, seen));
        let weights = bodies.map(|body| body.scaled(out.mu()[body.v]));
        let seeded: Constraint<OfCoordinate<T>> = self.constraint.seeded(0);
        let fixed = all.map(|at| at.map(OfCoordinate::constant_of));
        let along = seeded.rate_of_joints(weights.map(OfCoordinate::constant_of));
        if let Some((row, along)) = self.coupled_row(&seeded, &fixed).zip(along) {
            let mut sum = out.sum(None);
            sum.coordinate_row(y, 0, row);
            let slopes = (sum.value - along.each(|x| x * force)).eps;
            out.add(self.slots, &slopes);
        }
        for (i, body) in bodies.into_iter().enumerate() {
            let Some(first) = out.slots().1.coupling[indices[i]] else {
                continue;
            };
            // The position of a follower is r q + o, and each of its rates r times that of its leader.
            let by_ratio = |own: &mut OfCoordinate<T>, of_leader: T| own.eps[0] = of_leader;
            let (mut motions, k) = (fixed, body.v);
            let moving = &mut motions[i];
            by_ratio(&mut moving.joint.position, moment.q()[body.q]);
            moving.joint.position.eps[1] = T::one();
            by_ratio(&mut moving.joint.rate, moment.v()[k]);
            by_ratio(&mut moving.seen, seen[k]);
            let mut weights = weights.map(OfCoordinate::constant_of);
            by_ratio(&mut weights[i], out.mu()[k]);
            let along = self.constraint.rate_of_joints(weights);
            if let Some((row, along)) = self.coupled_row(self.constraint, &motions).zip(along) {
                let mut sum = out.sum(None);
                sum.coordinate_row(y, 0, row);
                let slopes = (sum.value - along.each(|x| x * force)).eps;
                out.add(&(first..first + 2), &slopes);
            }
        }
    }
}

impl<T: Scalar> ConstraintSlopes<T> {
    /// Hands each constraint whose rows have forces, and the bodies of a coupler, to `each`.
    fn each_held(
        &self,
        at: &SlopePoint<'_, T>,
        mut each: impl FnMut(&HeldConstraint<'_, T>, Option<[usize; 2]>),
    ) {
        let Some(held) = at.held else { return };
        let mut first_row = 0;
        for (constraint, slots) in at.moment.simulator.constraints().iter().zip(&self.slots) {
            let own = HeldConstraint {
                at,
                held,
                constraint,
                slots,
                first_row,
            };
            let coupled = match constraint.kind() {
                ConstraintKind::Coupler { bodies, .. } => Some(bodies.map(|body| body.0)),
                _ => None,
            };
            each(&own, coupled);
            first_row += constraint.rows();
        }
    }
}

impl<T: Scalar> TermSlopes<T> for ConstraintSlopes<T> {
    type Term = Constraints<T>;

    fn emit_forces<S: Sink<T>>(&mut self, _: &SlopePoint<'_, T>, _: &Constraints<T>, _: &mut S) {}

    fn emit_rows<S: Sink<T>>(&mut self, at: &SlopePoint<'_, T>, _: &Constraints<T>, out: &mut S) {
        turned_into(at.moment.model(), at.moment.v(), at.a, &mut self.seen);
        self.each_held(at, |held, coupled| match coupled {
            None => held.emit_anchored(out),
            Some(bodies) => {
                let bodies = bodies.map(|i| &at.moment.model().bodies()[i]);
                held.emit_coupler(bodies, &self.seen, out);
            }
        });
    }

    fn emit_numbers(
        &mut self,
        at: &SlopePoint<'_, T>,
        term: &Constraints<T>,
        out: &mut Numbers<'_, T>,
    ) {
        emit_time_step(at, term, out);
        self.each_held(at, |held, coupled| {
            if let Some(bodies) = coupled {
                held.emit_coupler_numbers(bodies, &self.seen, out);
            }
        });
    }
}
