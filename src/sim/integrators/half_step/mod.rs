//! Coriolis and centrifugal forces of the middle of a step: when they are taken, and how.

mod pullback;
mod pushforward;

use nalgebra::DMatrix;

use crate::dynamics::{
    CrbaScratch, Gyroscopic, RneaScratch, bias_forces_into, mass_matrix_of_placed_into,
};
use crate::scalar::{Over, Scalar};
use crate::sim::forces::Forces;
use crate::sim::integrator::Integrator;
use crate::sim::moment::Moment;
use crate::sim::simulator::Simulator;
pub(super) use pullback::{Change, MidpointAdjoint};
pub(super) use pushforward::MidpointColumns;

/// Angle of a coordinate in a step up to which semi-implicit Euler takes these forces from the start of the step, rad. What turns faster gains
/// energy at a rate that matters within few steps.
const SLOW: f64 = 0.1;
/// Angle from which on they are wholly those of the middle, rad. With 0.2 to 0.4 instead light wrists still diverge.
const FAST: f64 = 0.2;
/// Speed up to which they are those of the start whatever the step is, rad/s: ordinary motion stays below it, and long steps of it stay what they
/// are. At steps of 1 ms that is [`SLOW`].
const ORDINARY: f64 = 100.0;

/// These forces in a step of a robot without rows.
#[derive(Clone, Debug)]
pub(in crate::sim::integrators) struct Midpoint<T> {
    pub(in crate::sim::integrators) gyroscopic: Gyroscopic<T>,
    crba: CrbaScratch<T>,
    rnea: RneaScratch<T>,
    mass: DMatrix<T>,
    forces: Vec<T>,
}

impl<T: Scalar> Midpoint<T> {
    /// Memory for a simulator.
    pub(in crate::sim::integrators) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let model = simulator.model();
        Self {
            gyroscopic: Gyroscopic::new(model, 0),
            crba: CrbaScratch::new(model),
            rnea: RneaScratch::new(model),
            mass: DMatrix::zeros(model.nv(), model.nv()),
            forces: vec![T::zero(); model.nv()],
        }
    }

    /// Takes from the joint forces what velocity forces change until the middle of a step, by `half_step` (s), for robots without rows.
    pub(in crate::sim::integrators) fn correct<P: Scalar>(
        &mut self,
        at: &Moment<'_, P, T>,
        half_step: T,
        forces: &mut Forces<T>,
    ) where
        T: Over<P>,
    {
        let (model, q, v) = (at.model(), at.q(), at.v());
        bias_forces_into(
            model,
            q,
            v,
            &forces.bodies,
            &mut self.rnea,
            &mut self.forces,
        );
        let balance = self.forces.iter_mut().zip(&forces.tau);
        balance.for_each(|(force, &tau)| *force = tau - *force);
        let placed = self.rnea.motions().0;
        mass_matrix_of_placed_into(model, placed, &mut self.crba, &mut self.mass);
        self.gyroscopic.differentiate(model, q, v, &self.mass);
        for (k, &resistance) in forces.resistance.iter().enumerate() {
            self.mass[(k, k)] += resistance;
        }
        let (mass, own, none) = (&self.mass, &self.forces, std::iter::empty());
        self.gyroscopic.solve(mass, half_step, own, &[], none);
        self.gyroscopic.correct(half_step, &mut forces.tau);
    }
}

impl<P: Scalar> Simulator<P> {
    /// By how much of the acceleration the velocity of velocity forces is that of the middle of a step, s: half of the step where it is implicit in
    /// velocity or there are kinematic constraints; otherwise, with semi-implicit Euler, where something whirls, growing from 0 between two speeds;
    /// `None` where nothing does.
    pub(crate) fn half_step<T: Over<P>>(&self, v: &[T]) -> Option<T> {
        self.half_of(self.time_step(), v)
    }

    /// [`half_step`](Self::half_step) of a time step that may have derivatives of its own, s.
    fn half_of<D: Scalar, T: Over<D>>(&self, dt: D, v: &[T]) -> Option<T> {
        let half = dt * 0.5;
        match self.integrator() {
            Integrator::RungeKutta4 => None,
            _ if self.always_in_the_middle() => Some(half.into()),
            _ if is_slow(slow(dt), v) => None,
            _ => Some(self.whirl(slow(dt), v) * half),
        }
    }

    /// Whether velocity forces are those of the middle of each step, whatever the speed.
    pub(crate) fn always_in_the_middle(&self) -> bool {
        match self.integrator() {
            Integrator::ImplicitVelocity => true,
            Integrator::SemiImplicitEuler => !self.constraints().is_empty(),
            Integrator::RungeKutta4 => false,
        }
    }

    /// The coordinates that are angles.
    pub(crate) fn turning(&self) -> impl Iterator<Item = usize> {
        let bodies = self.model().independent();
        let axes = bodies.flat_map(|body| body.axes());
        axes.filter(|(_, axis)| axis.is_angular()).map(|(k, _)| k)
    }

    /// From 0 to 1 as the fastest coordinate of all that turn goes from slow to fast, s = 3 x² − 2 x³.
    fn whirl<D: Scalar, T: Over<D>>(&self, slow: D, v: &[T]) -> T {
        let mut fastest = T::zero();
        for k in self.turning() {
            fastest = fastest.max(v[k].abs());
        }
        let x = (fastest - slow) / T::from(slow * (FAST / SLOW - 1.0));
        let x = x.clamp(0.0, 1.0);
        x * x * (-x * 2.0 + 3.0)
    }
}

/// Speed up to which nothing whirls in a step of `dt` (s), rad/s.
fn slow<D: Scalar>(dt: D) -> D {
    (D::constant(SLOW) / dt).max(D::constant(ORDINARY))
}

/// Whether certainly nothing is faster than a speed: a test that costs next to nothing.
#[inline(always)]
fn is_slow<D: Scalar, T: Over<D>>(slow: D, v: &[T]) -> bool {
    let square = v.iter().fold(T::zero(), |sum, &v| v.mul_add(v, sum));
    let (limit, condition) = (slow.powi(2), "no coordinate whirls in a step");
    if D::LANES == 1 && limit.has_value() {
        return square.is_at_most(limit.value(0), condition);
    }
    (square - limit).is_at_most(0.0, condition)
}
