//! The half step: Coriolis and centrifugal forces of the middle of an Euler step, their conditions and formulas.
//!
//! The whole scheme is here, with two exceptions: an [`EvaluationPoint`] contains the time by which these forces are ahead; constraints state their
//! rows along the velocity at the start and after the step, because they own the formula of their bias ([`Acting`](crate::sim::terms::Acting)). Joint
//! limits are not part of a₀.

mod ahead;
mod gyroscopic;
mod pullback;
mod pushforward;

use crate::dynamics::TreeMatrix;
use crate::nested::IntoNested;
use crate::scalar::{Dual, Over, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::forces::Forces;
use crate::sim::integrator::Integrator;
use crate::sim::placed::Placed;
use crate::sim::simulator::Simulator;
use gyroscopic::Gyroscopic;
pub(super) use pullback::{Adjoint, Change, Weights};
pub(super) use pushforward::Columns;

/// Angle of a coordinate in a step up to which semi-implicit Euler takes these forces from the start of the step, rad. Faster rotations gain energy
/// considerably within few steps.
const SLOW: f64 = 0.1;
/// Angle above which they are fully those of the middle, rad. With 0.2 to 0.4 light wrists still diverge.
const FAST: f64 = 0.2;
/// Speed up to which they are those of the start at any step length, rad/s: ordinary motion is slower, and long steps of it are unchanged. At steps
/// of 1 ms that is [`SLOW`].
const ORDINARY: f64 = 100.0;

/// These forces in a step, with the acceleration a₀ at which they are found.
#[derive(Clone, Debug)]
pub(crate) struct HalfStep<T: Scalar> {
    pub(super) gyroscopic: Gyroscopic<T>,
    /// For robots without rows; others have a balance.
    own: Option<Box<(Placed<T>, TreeMatrix<T>)>>,
}

impl<T: Scalar> HalfStep<T> {
    /// Makes memory for a simulator.
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Box<Self> {
        Box::new(Self {
            gyroscopic: Gyroscopic::new(simulator.model(), simulator.bilateral_rows()),
            own: (!simulator.needs_solver()).then(|| own(simulator)),
        })
    }

    /// [`Gyroscopic::correct`] of joint forces, for robots without rows.
    pub(super) fn correct<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        forces: &mut Forces<T>,
    ) where
        T: Over<P>,
    {
        let (placed, mass) = &mut **self.own.get_or_insert_with(|| own(at.simulator));
        placed.place(at);
        placed.load(at, forces);
        placed.mass_into(at.model(), mass);
        let (own, none) = (&mut placed.forces, (&[][..], std::iter::empty()));
        let gyroscopic = &mut self.gyroscopic;
        gyroscopic.correct(at, &forces.resistance, mass, own, none);
        gyroscopic.subtract(half_step(at), &mut forces.tau);
    }
}

/// Mass matrix and forces of a robot without rows.
fn own<P: Scalar, T: Scalar>(simulator: &Simulator<P>) -> Box<(Placed<T>, TreeMatrix<T>)> {
    let model = simulator.model();
    Box::new((Placed::new(model), TreeMatrix::zeros(model)))
}

/// Time by which the velocity is ahead along a₀, s.
fn half_step<P, T: Scalar>(at: &EvaluationPoint<'_, P, T>) -> T {
    at.half_step.unwrap_or(T::zero())
}

/// Passes each coordinate, with the derivative of the half step in its speed, to `each`; none where that is always the same.
///
/// * `v` – working memory
fn each_derivative<T: Scalar>(
    at: &EvaluationPoint<'_, f64, T>,
    v: &mut [Dual<T, 1>],
    mut each: impl FnMut(usize, T),
) {
    if at.simulator.always_in_the_middle() {
        return;
    }
    let lifted = v.iter_mut().zip(at.v());
    lifted.for_each(|(out, &v)| *out = Dual::constant_of(v));
    for k in at.simulator.turning() {
        // Lane by lane, because each lane has its own fastest coordinate.
        v[k].eps[0] = T::one();
        let half_step = at.simulator.half_step(v);
        v[k].eps[0] = T::zero();
        each(k, half_step.map_or(T::zero(), |s| s.eps[0]));
    }
}

/// The derivative of the half step in the time step.
///
/// * `v` – working memory
fn slope_in_time<T: Scalar>(at: &EvaluationPoint<'_, f64, T>, v: &mut [Dual<T, 1>]) -> T {
    let lifted = v.iter_mut().zip(at.v());
    lifted.for_each(|(out, &v)| *out = Dual::constant_of(v));
    let dt = Dual::variable(T::constant(at.dt()), 0);
    let half_step: Option<Dual<T, 1>> = at.simulator.half_of(dt, v);
    half_step.map_or(T::zero(), |s| s.eps[0])
}

impl<P: Scalar> Simulator<P> {
    /// Time by which the velocity of velocity forces is ahead along the acceleration, s: half of the step if it is implicit in velocity or there are
    /// kinematic constraints; otherwise, with semi-implicit Euler and fast rotation, growing from 0 between two speeds; `None` without fast rotation.
    pub(crate) fn half_step<T: Over<P>>(&self, v: &[T]) -> Option<T> {
        self.half_of(self.time_step(), v)
    }

    /// [`half_step`](Self::half_step) for a time step that may have derivatives, s.
    fn half_of<D: Scalar, T: Over<D>>(&self, dt: D, v: &[T]) -> Option<T> {
        let half = dt * 0.5;
        match self.integrator() {
            Integrator::RungeKutta4 | Integrator::ImplicitMidpoint => None,
            _ if self.always_in_the_middle() => Some(half.into()),
            _ if is_slow(slow(dt), v) => None,
            _ => Some(self.gyroscopic_share(slow(dt), v) * half),
        }
    }

    /// Whether velocity forces are those of the middle of each step, whatever the speed.
    pub(crate) fn always_in_the_middle(&self) -> bool {
        match self.integrator() {
            Integrator::ImplicitVelocity => true,
            Integrator::SemiImplicitEuler => !self.constraints().is_empty(),
            Integrator::RungeKutta4 | Integrator::ImplicitMidpoint => false,
        }
    }

    /// Whether velocity forces are wholly those of the middle of a step at a velocity.
    pub(crate) fn takes_middle_at(&self, v: &[P]) -> bool {
        let half = self.time_step() * 0.5;
        self.half_step(v)
            .is_some_and(|s| (0..P::LANES).all(|lane| s.value(lane) == half.value(lane)))
    }

    /// The coordinates that are angles.
    fn turning(&self) -> impl Iterator<Item = usize> {
        let bodies = self.model().independent();
        let axes = bodies.nested(|body| body.axes());
        axes.filter(|(_, axis)| axis.is_angular()).map(|(k, _)| k)
    }

    /// From 0 to 1 as the fastest rotating coordinate goes from slow to fast, s = 3 x² − 2 x³.
    fn gyroscopic_share<D: Scalar, T: Over<D>>(&self, slow: D, v: &[T]) -> T {
        let mut fastest = T::zero();
        for k in self.turning() {
            fastest = fastest.max(v[k].abs());
        }
        let x = (fastest - slow) / T::from(slow * (FAST / SLOW - 1.0));
        let x = x.clamp(0.0, 1.0);
        x * x * (-x * 2.0 + 3.0)
    }
}

/// Speed up to which there is no fast rotation in a step of `dt` (s), rad/s.
fn slow<D: Scalar>(dt: D) -> D {
    (D::constant(SLOW) / dt).max(D::constant(ORDINARY))
}

/// Whether certainly nothing is faster than a speed: a test that costs next to nothing.
#[inline(always)]
fn is_slow<D: Scalar, T: Over<D>>(slow: D, v: &[T]) -> bool {
    let square = v.iter().fold(T::zero(), |sum, &v| v.mul_add(v, sum));
    let (limit, condition) = (slow.powi(2), "no coordinate rotates fast in a step");
    if D::LANES == 1 && limit.has_value() {
        return square.is_at_most(limit.value(0), condition);
    }
    (square - limit).is_at_most(0.0, condition)
}
