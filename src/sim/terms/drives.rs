//! Joint drives: inputs through motors, springs, dampers, dry friction and speed limits.
//!
//! Over a step whose joint forces are those of its end, each is linear in the velocity v⁺ = v + Δt a after the step, with the coefficients of
//! its start. With dampers C and springs K that is
//!
//! > (M + Δt C + Δt² K) a = τ − h − Δt K v,
//!
//! a diagonal beside the mass matrix, which forward dynamics takes as it takes armature.

use std::marker::PhantomData;

use super::linear_point::{ForceColumns, LinearPoint, OfCoordinate};
use super::term::{Term, TermDerivatives};
use crate::dynamics::{add_passive_forces, each_resistance};
use crate::scalar::{Over, Scalar};
use crate::sim::forces::Forces;
use crate::sim::moment::Moment;
use crate::sim::simulator::Simulator;

/// The term; it needs no memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drives<T>(PhantomData<T>);

impl<T: Scalar> Drives<T> {
    pub(super) fn new<P: Scalar>(_: &Simulator<P>) -> Self {
        Self(PhantomData)
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for Drives<T> {
    #[inline]
    fn add_forces(&mut self, at: &Moment<'_, P, T>, forces: &mut Forces<T>) {
        let (simulator, v, tau) = (at.simulator, at.v(), &mut forces.tau);
        drive(
            simulator,
            &Driven {
                q: at.q(),
                v,
                u: at.u,
            },
            tau,
        );
        if at.is_explicit() {
            return;
        }
        let (dt, resistance) = (at.dt(), &mut forces.resistance);
        each_resistance_of(simulator, v, |k, damping, stiffness| {
            let spring = stiffness * dt;
            resistance[k] = (damping + spring) * dt;
            tau[k] -= spring * v[k];
        });
    }
}

/// State and input of drives.
struct Driven<'a, T> {
    q: &'a [T],
    v: &'a [T],
    u: &'a [T],
}

/// τ = A(v, S u) − k (q − rest) − d v with the actuators A, without stops; `tau` is zero before.
fn drive<P: Scalar, T: Over<P>>(simulator: &Simulator<P>, at: &Driven<'_, T>, tau: &mut [T]) {
    for (&k, &u) in simulator.actuated().iter().zip(at.u) {
        tau[k] = u;
    }
    if let Some(actuation) = simulator.actuation() {
        actuation.drive(at.v, tau);
    }
    add_passive_forces(simulator.model(), at.q, at.v, tau);
}

/// Hands what every coordinate loses of its force by a velocity and by a displacement that grow to `each(coordinate, c, k)`, at the
/// velocity `v`.
fn each_resistance_of<P: Scalar, T: Over<P>>(
    simulator: &Simulator<P>,
    v: &[T],
    mut each: impl FnMut(usize, T, T),
) {
    each_resistance(simulator.model(), |k, damping, stiffness| {
        let own = simulator.actuation();
        let own = own.map_or(T::zero(), |actuation| actuation.damping(k, v[k]));
        each(k, own + damping, stiffness.into());
    });
}

/// Derivatives of the term: each force depends on its own coordinate and input only.
#[derive(Clone, Debug)]
pub(crate) struct DriveColumns {
    tau: Vec<OfCoordinate>,
}

impl DriveColumns {
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            tau: vec![OfCoordinate::from(0.0); simulator.model().nv()],
        }
    }
}

impl TermDerivatives for DriveColumns {
    type Term = Drives<f64>;

    fn add_forces(&mut self, at: &LinearPoint<'_>, _: &Drives<f64>, forces: &mut ForceColumns) {
        let (simulator, x, tau) = (at.moment.simulator, at.coordinates, &mut self.tau);
        tau.fill(OfCoordinate::from(0.0));
        let (q, v, u) = (&x.q[..], &x.v[..], &x.u[..]);
        drive(simulator, &Driven { q, v, u }, tau);
        if !at.moment.is_explicit() {
            let (dt, resistance) = (at.moment.dt(), &mut forces.resistance);
            each_resistance_of(simulator, v, |k, damping, stiffness: OfCoordinate| {
                let spring = stiffness * dt;
                resistance[k] = (damping + spring) * dt;
                tau[k] -= resistance[k] * at.a[k] + spring * v[k];
            });
        }
        for (k, tau) in tau.iter().enumerate() {
            forces.subtract_of_coordinate(k, tau);
        }
        let first = simulator.n_tangent();
        for (column, &row) in simulator.actuated().iter().enumerate() {
            *forces.columns().at(row, first + column) -= tau[row].eps[2];
        }
    }
}
