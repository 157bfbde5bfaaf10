//! Derivatives of contact points.
//!
//! Rows and force of a point depend on pose and velocity of its body, its bristle and its Delassus diagonal: one evaluation over numbers with
//! derivatives in these is sufficient, and one over the parameters of point, contact model and ground.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::numbers::{OverNumbers, PairPlace, PointPlace};
use super::point::LinearizedPoint;
use super::rows::Contact;
use super::solved::{ActiveRows, SolvedPoint, each_solved};
use super::time_step::emit_time_step;
use crate::contact::{BristleLoad, Contacts, PairPoint, ROWS};
use crate::model::BodyId;
use crate::scalar::{MapEach, Over, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::simulator::Simulator;
use crate::sim::terms::local::OfBody;
use crate::sim::terms::numbers::Numbers;
use crate::sim::terms::sink::{BodyRow, BodySink, DerivativePoint, Normal, Own, Sink};
use crate::sim::terms::term::TermDerivatives;
use crate::spatial::linear::dot;
use crate::spatial::{Force, Motion};

/// Derivatives of the term.
#[derive(Clone, Debug)]
pub(crate) struct ContactDerivatives<T: Scalar> {
    /// Workspace of gradients in parameters of contacts.
    numbers: Option<Box<OverNumbers<T>>>,
}

impl<T: Scalar> ContactDerivatives<T> {
    pub(crate) fn new(_: &Simulator) -> Self {
        Self { numbers: None }
    }
}

impl<T: Scalar> ActiveRows<T> {
    /// Rows of a point, those of its moments last, and how many there are.
    fn body_rows<P: Scalar>(
        &self,
        point: &LinearizedPoint<'_, P, T>,
        side: usize,
        seen: &[Motion<T>; 2],
    ) -> ([BodyRow<T>; 2 * ROWS], usize)
    where
        OfBody<T>: Over<P>,
    {
        let y = point.rows(seen, self.delassus, &self.forces);
        let mut rows = [BodyRow::zero(); 2 * ROWS];
        for (k, &y) in y.iter().enumerate() {
            rows[k] = body_row(self.row + k, y, self.axes[side][k]);
        }
        let Some(own) = &self.moments else {
            return (rows, ROWS);
        };
        let y = point.moment_rows(seen, self.delassus, &own.moments);
        for ((axis, row), y) in self.moment_rows().zip(y.iter().cycle()) {
            rows[row - self.row] = body_row(row, y[axis], own.couples[side][axis]);
        }
        (rows, ROWS + own.axes.len())
    }

    /// States friction, and the coefficients of moments.
    fn emit_friction<P: Scalar>(
        &self,
        point: &LinearizedPoint<'_, P, T>,
        out: &mut impl BodySink<T>,
    ) where
        OfBody<T>: Over<P>,
    {
        out.friction(self.block, point.friction());
        if let Some(bounds) = point.moment_bounds() {
            let blocks = self.moment_blocks();
            blocks.for_each(|(k, block)| out.friction(block, bounds[k]));
        }
    }
}

/// A row without an acceleration of its own.
fn body_row<T: Scalar>(row: usize, y: OfBody<T>, by_seen: Force<T>) -> BodyRow<T> {
    BodyRow {
        row,
        y,
        by_seen,
        by_bias: None,
    }
}

impl<T: Scalar> SolvedPoint<'_, T> {
    /// States rows, forces and change of the bristle, over numbers of one of the bodies.
    ///
    /// * `seen` – the motions that ã gives to both
    fn emit<P: Scalar>(
        &self,
        point: &LinearizedPoint<'_, P, T>,
        side: usize,
        seen: &[Motion<T>; 2],
        out: &mut impl BodySink<T>,
    ) where
        OfBody<T>: Over<P>,
    {
        if self.states_gap {
            return self.emit_gap(point, out);
        }
        let mut forces = [T::zero(); ROWS];
        if let Some(active) = &self.active {
            forces = active.forces;
            let (all, count) = active.body_rows(point, side, seen);
            let rows = &all[..count];
            out.rows(rows, self.own());
            self.emit_forces(point, side, &forces, out);
            if let Some(own) = &active.moments {
                let couples = point.couples(&own.moments);
                state_forces(couples, self.bodies, side, &self.own(), out);
            }
            if side == 0 {
                active.emit_friction(point, out);
            }
            if self.contacts.read_delassus() {
                let normal = Normal {
                    on: self.bodies,
                    side,
                    force: active.axes[side][0],
                    along: &|motions: &[Motion<T>; 2]| point.along_normal(motions),
                    with_mass: side == 0,
                };
                out.delassus(rows, &normal);
            }
        }
        if self.contacts.has_bristle(self.index) {
            out.rates(ROWS * self.index, &point.bristle_step(&forces));
        }
    }

    /// States the gap in place of y of the normal.
    fn emit_gap<P: Scalar>(&self, point: &LinearizedPoint<'_, P, T>, out: &mut impl BodySink<T>)
    where
        OfBody<T>: Over<P>,
    {
        if let Some(active) = &self.active {
            let row = BodyRow {
                row: active.row,
                y: point.gap(),
                ..BodyRow::zero()
            };
            out.rows(&[row], Own::Nothing);
        }
    }

    /// The force on the body of the numbers, and the derivatives alone of that on the other one, since that force counts there.
    fn emit_forces<P: Scalar>(
        &self,
        point: &LinearizedPoint<'_, P, T>,
        side: usize,
        forces: &[T],
        out: &mut impl BodySink<T>,
    ) where
        OfBody<T>: Over<P>,
    {
        state_forces(point.forces(forces), self.bodies, side, &self.own(), out);
    }

    /// States a point between bodies in derivatives of one body after the other.
    fn emit_between(
        &self,
        at: &DerivativePoint<'_, T>,
        term: &Contact<T>,
        pair: &PairPoint,
        out: &mut impl Sink<T>,
    ) {
        let kinematics = Some(&term.kinematics);
        let motions = (self.bodies).map_each(|on| out.turn_to(at, on, kinematics));
        let seen = motions.map_each(|motion| motion.U);
        for side in [1, 0] {
            let on = self.bodies[side];
            if on.is_some() {
                out.turn_to(at, on, kinematics);
                let point = LinearizedPoint::between(at.point, pair, side, &motions);
                self.emit(&point, side, &seen, out);
            }
        }
    }

    fn own(&self) -> Own {
        own_of(self.contacts, self.index)
    }
}

/// States a point between bodies whose law gives the force by itself, in derivatives of one body after the other.
fn emit_explicit_between<T: Scalar>(
    at: &DerivativePoint<'_, T>,
    term: &Contact<T>,
    (pair, index): (&PairPoint, usize),
    contacts: &Contacts,
    out: &mut impl Sink<T>,
) {
    let bodies = contacts.pair_bodies(pair.shapes);
    let kinematics = Some(&term.kinematics);
    let motions = bodies.map_each(|on| out.turn_to(at, on, kinematics));
    for side in [1, 0] {
        let on = bodies[side];
        if on.is_some() {
            out.turn_to(at, on, kinematics);
            let point = LinearizedPoint::between(at.point, pair, side, &motions);
            emit_explicit(&point, at.point, contacts, index, (bodies, side), out);
        }
    }
}

/// States the force on the body of the numbers, and the derivatives alone of that on the other one.
fn state_forces<T: Scalar>(
    forces: [Option<Force<OfBody<T>>>; 2],
    bodies: [Option<BodyId>; 2],
    side: usize,
    own: &Own,
    out: &mut impl BodySink<T>,
) {
    for (acting, force) in forces.into_iter().enumerate() {
        let Some(force) = force else { continue };
        let force = match acting == side {
            true => force,
            false => slopes_alone(&force),
        };
        out.force(bodies[acting], &force, own.clone());
    }
}

/// A force without its value.
fn slopes_alone<T: Scalar>(force: &Force<OfBody<T>>) -> Force<OfBody<T>> {
    Force::from_array(force.to_array().map_each(|x| OfBody::new(T::zero(), x.eps)))
}

/// The bristle of a point: none between bodies.
fn own_of(contacts: &Contacts, index: usize) -> Own {
    match contacts.has_bristle(index) {
        true => Own::Contact(ROWS * index),
        false => Own::Nothing,
    }
}

/// States forces and change of the bristle of a point, as its law gives them by itself; nothing where only a solver finds them.
///
/// * `on` – the bodies, and the side of that one of them over whose numbers the point is
fn emit_explicit<P: Scalar, T: Scalar>(
    point: &LinearizedPoint<'_, P, T>,
    at: &EvaluationPoint<'_, f64, T>,
    contacts: &Contacts,
    index: usize,
    (bodies, side): ([Option<BodyId>; 2], usize),
    out: &mut impl BodySink<T>,
) where
    OfBody<T>: Over<P>,
{
    let Some(own) = point.explicit_force(at.is_instant) else {
        return;
    };
    state_forces(own.forces, bodies, side, &own_of(contacts, index), out);
    if contacts.has_bristle(index) {
        out.rates(ROWS * index, &own.bristle_step);
    }
}

/// A point with the ground over numbers of its body, to which the sink is turned; and the motion that ã gives to the body.
fn turned_point<'a, T: Scalar>(
    at: &DerivativePoint<'a, T>,
    term: &Contact<T>,
    body: Option<BodyId>,
    index: usize,
    out: &mut impl Sink<T>,
) -> (LinearizedPoint<'a, f64, T>, Motion<T>) {
    let motion = out.turn_to(at, body, Some(&term.kinematics));
    let point = LinearizedPoint::new(at.point, index, &motion.X_WB, &motion.V);
    (point, motion.U)
}

impl<T: Scalar> TermDerivatives<T> for ContactDerivatives<T> {
    type Term = Contact<T>;

    fn reserve_numbers(&mut self, simulator: &Simulator) {
        self.numbers = simulator.contacts().map(OverNumbers::new);
    }

    fn emit_forces<S: Sink<T>>(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &Contact<T>,
        out: &mut S,
    ) {
        if let Some(contacts) = at.point.explicit_contacts() {
            for (index, place) in contacts.points().iter().enumerate() {
                let body = Some(place.body);
                let (point, _) = turned_point(at, term, body, index, out);
                emit_explicit(&point, at.point, contacts, index, ([body, None], 0), out);
            }
            for pair in term.pair_points(contacts) {
                emit_explicit_between(at, term, pair, contacts, out);
            }
        }
    }

    fn emit_rows<S: Sink<T>>(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &Contact<T>,
        out: &mut S,
    ) {
        each_solved(at, term, |solved| {
            if let Some(pair) = solved.pair {
                return solved.emit_between(at, term, pair, out);
            }
            let (point, U) = turned_point(at, term, solved.bodies[0], solved.index, out);
            solved.emit(&point, 0, &[U, Motion::zero()], out);
        });
    }

    fn emit_numbers(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &Contact<T>,
        out: &mut Numbers<'_, T>,
    ) {
        let contacts = at.point.simulator.contacts().filter(|_| out.has_parts());
        let Some(contacts) = contacts else { return };
        let own = self.numbers.take();
        let own = own.filter(|own| own.are_of(contacts));
        let mut numbers = own.unwrap_or_else(|| OverNumbers::new(contacts));
        if at.point.explicit_contacts().is_some() {
            for (index, point) in contacts.points().iter().enumerate() {
                let place = PointPlace { at, term, index };
                let on = ([Some(point.body), None], 0);
                numbers.add(&place, out, &|point, out| {
                    emit_explicit(point, at.point, contacts, index, on, out);
                });
            }
            for (point, index) in term.pair_points(contacts) {
                let bodies = contacts.pair_bodies(point.shapes);
                let place = PairPlace {
                    at,
                    term,
                    point,
                    bodies,
                };
                numbers.add_pair(&place, out, &|point, out| {
                    emit_explicit(point, at.point, contacts, index, (bodies, 0), out);
                });
            }
        }
        each_solved(at, term, |solved| {
            let seen = solved.bodies.map_each(|on| out.seen(on));
            if let Some(point) = solved.pair {
                let bodies = solved.bodies;
                let place = PairPlace {
                    at,
                    term,
                    point,
                    bodies,
                };
                return numbers.add_pair(&place, out, &|point, out| {
                    solved.emit(point, 0, &seen, out);
                });
            }
            let index = solved.index;
            let place = PointPlace { at, term, index };
            numbers.add(&place, out, &|point, out| solved.emit(point, 0, &seen, out));
        });
        numbers.finish(out);
        self.numbers = Some(numbers);
        if !at.states_gaps() {
            emit_time_step(at, contacts, term, out);
        }
    }

    /// The change of a bristle is linear in the forces across.
    fn each_rate_by_force(
        at: &DerivativePoint<'_, T>,
        term: &Contact<T>,
        each: &mut dyn FnMut(usize, usize, T),
    ) {
        let bristles = at.point.solved_contacts().filter(|c| c.have_bristles());
        let Some((contacts, balance)) = bristles.zip(at.balance()) else {
            return;
        };
        let touching = term.touching().iter().enumerate();
        for (of, &index) in touching.filter(|(_, index)| contacts.has_bristle(**index)) {
            let first = term.place_of(balance, of).row;
            for across in 1..ROWS {
                let step = term.bristle_by_force(contacts, of, across, at.point.dt());
                for (k, &slope) in step.iter().enumerate() {
                    each(ROWS * index + k, first + across, slope);
                }
            }
        }
    }
}

impl<T: Scalar> Contact<T> {
    /// Derivatives of the step of the bristle of a point that takes part in the force along one of its axes across.
    fn bristle_by_force(&self, contacts: &Contacts, of: usize, axis: usize, dt: f64) -> Vector3<T> {
        let index = self.touching()[of];
        let point = &self.points[index];
        contacts.laws()[index].bristle_step(&BristleLoad {
            depth: point.depth,
            separation: dot(&point.normal, &point.velocity),
            friction: &self.axes_of(of)[axis],
            deflection: &Vector3::zeros(),
            dt,
        })
    }
}
