//! Contacts over the time step, for the gradient in it.
//!
//! The position of a point does not depend on the step, only its contact model does: the model is evaluated at the known point, over numbers with the
//! one direction of the time step.

use nalgebra::Vector3;

use super::rows::Contact;
use super::solved::{SolvedPoint, each_solved};
use crate::contact::{
    BristleLoad, BristleRate, ContactLaw, Contacts, PointKinematics, PointState, ROWS, Turning,
};
use crate::scalar::{MapEach, Scalar};
use crate::sim::terms::local::{COORDINATE_DIRECTIONS, OfCoordinate, TIME_STEP};
use crate::sim::terms::numbers::{Numbers, WeightedSum};
use crate::sim::terms::sink::{CoordinateSink, DerivativePoint};
use crate::spatial::linear::dot;

/// A value with its derivative in the time step.
type Timed<T> = OfCoordinate<T>;
type TimedSum<'a, T> = WeightedSum<'a, T, COORDINATE_DIRECTIONS>;

/// States all points over the time step.
pub(super) fn emit_time_step<T: Scalar>(
    at: &DerivativePoint<'_, T>,
    contacts: &Contacts,
    term: &Contact<T>,
    out: &mut Numbers<'_, T>,
) {
    let dt = Timed::variable(T::constant(at.point.dt()), TIME_STEP);
    let mut sum = out.sum(None);
    if at.point.explicit_contacts().is_some() && !at.point.is_instant {
        for (i, rate) in term.bristle_rates().iter().enumerate() {
            let rate = BristleRate {
                deflection: constant(&rate.deflection),
                relaxation: Timed::constant_of(rate.relaxation),
            };
            sum.add_rates(ROWS * i, rate.step(dt).as_slice());
        }
    }
    each_solved(at, term, |solved| {
        let point = TimedPoint::new(at, contacts, term, &solved, dt);
        point.emit_rows(&solved, &mut sum);
        point.emit_bristle(&solved, &mut sum);
    });
    let slope = sum.value.eps[TIME_STEP];
    out.add_time_step(slope);
}

/// A point whose forces a solver has found.
struct TimedPoint<'a, T: Scalar> {
    contacts: &'a Contacts,
    law: ContactLaw,
    state: PointState<Timed<T>>,
    axes: [Vector3<Timed<T>>; ROWS],
    /// Of its bristle, in the world; `None` for laws without.
    deflection: Option<Vector3<Timed<T>>>,
    /// Torsional and rolling friction; `None` without.
    turning: Option<Turning<f64, Timed<T>>>,
    dt: Timed<T>,
}

impl<'a, T: Scalar> TimedPoint<'a, T> {
    fn new(
        at: &DerivativePoint<'_, T>,
        contacts: &'a Contacts,
        term: &'a Contact<T>,
        solved: &SolvedPoint<'_, T>,
        dt: Timed<T>,
    ) -> Self {
        let state = &term.points[solved.index];
        let bristles = at.point.state.contact.as_slice().as_chunks::<ROWS>().0;
        let deflection = bristles.get(solved.index);
        let touching = term.touching_in(contacts);
        Self {
            contacts,
            law: touching.law(solved.index),
            axes: touching.axes(solved.index).map_each(|axis| constant(&axis)),
            state: PointState {
                position: constant(&state.position),
                velocity: constant(&state.velocity),
                normal: constant(&state.normal),
                depth: Timed::constant_of(state.depth),
                in_body: constant(&state.in_body),
            },
            deflection: deflection.map(|&m| constant(&m.into())),
            turning: touching.turning(solved.index).map(|own| Turning {
                friction: own.friction,
                rate: constant(&own.rate),
            }),
            dt,
        }
    }

    /// y of its rows, where it takes part.
    fn emit_rows(&self, solved: &SolvedPoint<'_, T>, sum: &mut TimedSum<'_, T>) {
        let Some(active) = &solved.active else { return };
        let kinematics = PointKinematics {
            state: &self.state,
            axes: &self.axes,
            deflection: self.deflection,
            delassus: Timed::constant_of(active.delassus),
            dt: self.dt,
            kappa: self.contacts.kappa_over_step(self.dt),
            speculative: solved.pair.is_some() && self.contacts.are_pairs_speculative(),
        };
        let rows = self.contacts.rows(&self.law, &kinematics).rows;
        for (k, (row, &force)) in rows.iter().zip(&active.forces).enumerate() {
            if let Some(y) = row.y_at_rest(force) {
                sum.coordinate_row(active.row + k, 0, None, y);
            }
        }
        if let Some((turning, own)) = self.turning.as_ref().zip(active.moments.as_ref()) {
            let rows = (self.contacts).turning_rows(&self.law, &kinematics, turning, &rows[1]);
            for (axis, row) in active.moment_rows() {
                if let Some(y) = rows[axis].y_at_rest(own.moments[axis]) {
                    sum.coordinate_row(row, 0, None, y);
                }
            }
        }
    }

    /// By how much its bristle moves over the step under its forces.
    fn emit_bristle(&self, solved: &SolvedPoint<'_, T>, sum: &mut TimedSum<'_, T>) {
        let Some(deflection) = &self.deflection else {
            return;
        };
        let mut friction = Vector3::zeros();
        if let Some(active) = &solved.active {
            for (axis, &force) in self.axes.iter().zip(&active.forces).skip(1) {
                friction += axis.map(|x| x.each(|x| x * force));
            }
        }
        let step = self.law.bristle_step(&BristleLoad {
            depth: self.state.depth,
            separation: dot(&self.state.normal, &self.state.velocity),
            friction: &friction,
            deflection,
            dt: self.dt,
        });
        sum.add_rates(ROWS * solved.index, step.as_slice());
    }
}

fn constant<T: Scalar>(x: &Vector3<T>) -> Vector3<Timed<T>> {
    x.map(Timed::constant_of)
}
