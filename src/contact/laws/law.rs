//! The interface of contact models.
//!
//! Each contact model is one file with these items, in this order:
//!
//! | item | question |
//! |---|---|
//! | [`numbers!`](crate::numbers) | parameters and their ranges? |
//! | [`KIND`](PointLaw::KIND) | kind of solution, cone, state? |
//! | [`material`](PointLaw::material), [`set_material`](PointLaw::set_material), [`set_compliance`](PointLaw::set_compliance) | parameters that depend on both surfaces? |
//! | [`activation_margin`](PointLaw::activation_margin) | height below which a point takes part in a step? |
//! | [`rows`](PointLaw::rows) | reference accelerations and compliance? |
//! | [`turning`](PointLaw::turning) | rate at which torsional and rolling friction stop a rotation, and compliance? |
//! | [`least_velocity`](PointLaw::least_velocity) | least velocity of a point without force? |
//! | [`explicit_force`](PointLaw::explicit_force) | force from position and velocity alone? |
//! | [`bristle_step`](PointLaw::bristle_step) | bristle under the friction of the solver? |
//! | [`reason`](PointLaw::reason) | mode of the point and reason of zero derivatives? |
//!
//! A contact model does not depend on robot and terrain: its input is one point with its normal and two tangents. A new model is a file with these
//! items, and its name in the list of [`ContactLaw`](super::ContactLaw).

use nalgebra::Vector3;

use crate::cone::Law;
use crate::contact::activation::ActivationMargin;
use crate::contact::compliance::Compliance;
use crate::contact::material::Material;
use crate::contact::point_state::PointState;
use crate::contact::reason::{ContactReason, PointOutcome};
use crate::scalar::{Dual, Over, Scalar, each};
use crate::spatial::linear::{dot, scale};

/// Rows of a point: along its normal, and two across.
pub(crate) const ROWS: usize = 3;

/// Largest friction coefficient in the solver: with it a point practically sticks.
const STICKING: f64 = 1e4;

/// Properties of a kind of law, the same for all points of a robot whatever their parameters are.
#[derive(Debug)]
pub(crate) struct LawKind {
    /// Name in messages: "… contact".
    pub(crate) name: &'static str,
    /// Whether the solver finds its forces in a step whose contact forces are those of its start; where not, the law itself gives them.
    pub(crate) solved_explicitly: bool,
    /// Whether the solver finds its forces in a step whose contact forces are those of its end.
    pub(crate) solved_implicitly: bool,
    /// Friction law of the solver's cones.
    pub(crate) cone: Law,
    /// Whether each point has a bristle: a deflection in the world, three entries of the contact state.
    pub(crate) bristle: bool,
    /// Whether its forces act over a step and are none of an instant, so that the Runge–Kutta method cannot integrate them.
    pub(crate) acts_over_step: bool,
    /// Whether [`Smoothing`](crate::contact::Smoothing) applies.
    pub(crate) can_be_smoothed: bool,
    /// Whether a point that is [fast enough](PointLaw::least_velocity) needs no force, so that a working set of points can represent all points.
    pub(crate) working_set: bool,
    /// Whether its rows depend on the Delassus diagonal.
    pub(crate) reads_delassus: bool,
}

/// One row of the solver's problem:  y = (G + R) f + a − reference, with the law between f and y, and a the acceleration without contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactRow<T> {
    /// Reference acceleration, m/s² (rad/s² at a joint).
    pub(crate) reference: T,
    /// Compliance R, the regularisation of the row, 1/kg (1/(kg·m²)); infinite where there is no force.
    pub(crate) compliance: T,
}

/// A contact point at the start of a step, as its law sees it.
///
/// The time step may be of another type than what else the point has: a plain number, or one with derivatives.
pub(crate) struct PointKinematics<'a, D, T> {
    pub(crate) state: &'a PointState<T>,
    /// Normal, tangent, tangent, in the world.
    pub(crate) axes: &'a [Vector3<T>; ROWS],
    /// Deflection of the bristle, in the world, m; `None` for laws without.
    pub(crate) deflection: Option<Vector3<T>>,
    /// Entry of the Delassus matrix J M⁻¹ Jᵀ on the diagonal of the normal: acceleration by a unit force there, 1/kg.
    pub(crate) delassus: T,
    /// Δt, s.
    pub(crate) dt: D,
    /// κ over the step, N·m/s²; `None` for the exact law.
    pub(crate) kappa: Option<D>,
    /// Whether a law that meets points in the ground only meets those that would arrive within the step, too.
    pub(crate) speculative: bool,
}

/// Explicit force of a contact model, and the rate of its bristle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExplicitForce<T> {
    /// Force on the body, in the world, N.
    pub(crate) force: Vector3<T>,
    pub(crate) bristle: BristleRate<T>,
}

/// Rate of a bristle's deflection at a given force.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BristleRate<T> {
    /// ṁ, in the world, m/s.
    pub(crate) deflection: Vector3<T>,
    /// Relaxation rate −∂ṁ/∂m, 1/s.
    pub(crate) relaxation: T,
}

impl<T: Scalar> BristleRate<T> {
    /// That of a bristle at rest.
    pub(crate) fn zero() -> Self {
        Self {
            deflection: Vector3::zeros(),
            relaxation: T::zero(),
        }
    }

    /// Change of the deflection over a step of `dt` (s), Δt ṁ / (1 + Δt r): implicit in the relaxation of the bristle, at the rate r, so only the
    /// motion of the robot needs short steps.
    pub(crate) fn step<D: Scalar>(&self, dt: D) -> Vector3<T>
    where
        T: Over<D>,
    {
        scale(&self.deflection, T::from(dt) / (self.relaxation * dt + 1.0))
    }
}

/// A bristle at the start of a step at whose end the solver's friction acts.
pub(crate) struct BristleLoad<'a, D, T> {
    /// Depth of the point, m.
    pub(crate) depth: T,
    /// Velocity of the point out of the ground, m/s.
    pub(crate) separation: T,
    /// Friction on the body, in the world, N.
    pub(crate) friction: &'a Vector3<T>,
    /// Deflection m, in the world, m.
    pub(crate) deflection: &'a Vector3<T>,
    /// Δt, s.
    pub(crate) dt: D,
}

/// A law of the contact force at a point; see the list above.
pub(crate) trait PointLaw<P: Scalar>: Copy {
    /// Properties of the law whatever its parameters are.
    const KIND: LawKind;

    /// Friction μ, which may be infinite, and restitution: none where it follows from other numbers.
    fn material(&self) -> Material<P>;

    /// Sets friction and restitution, as far as the law has them, from a pair of materials.
    fn set_material(&mut self, pair: Material<P>);

    /// Sets the parameters of a compliance; whether it is one of this law, which by default has none.
    fn set_compliance(&mut self, _: Compliance<P>) -> bool {
        false
    }

    /// Region about the ground in which points take part in a step of `dt` (s). A region that is too large only costs time.
    fn activation_margin<D: Scalar>(&self, dt: D) -> ActivationMargin<D>;

    /// Reference acceleration and compliance along each axis of the point; by default those of a point that takes no part, for laws whose
    /// forces no solver finds.
    fn rows<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        _: &PointKinematics<'_, D, T>,
    ) -> [ContactRow<T>; ROWS] {
        [ContactRow::inactive(); ROWS]
    }

    /// Part of a rate of rotation that rows of moments take back in a unit of time in a step of `dt` (s), 1/s, and their compliance times the square of the
    /// coefficient, 1/kg; by default they stop a rotation within the step.
    ///
    /// * `across` – compliance of the point across its normal, infinite where it takes no part
    fn turning<T: Over<P>>(&self, dt: T, across: T) -> [T; 2] {
        let absent = T::constant(f64::INFINITY);
        [T::one() / dt, across.select_lt(absent, T::zero(), absent)]
    }

    /// The least velocity along the normal after a step of `dt` (s) that the law allows a point at a depth (m) with a velocity `v` along the
    /// normal (m/s) before the step; `None` for models without such a bound.
    fn least_velocity<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        _depth: T,
        _v: T,
        _dt: D,
    ) -> Option<T> {
        None
    }

    /// Force on a point, and the rate of its bristle, from a deflection (in the world, m); `None` for laws whose forces only a solver can find.
    fn explicit_force<T: Over<P>>(
        &self,
        _: &PointState<T>,
        _deflection: &Vector3<T>,
    ) -> Option<ExplicitForce<T>> {
        None
    }

    /// Change of the bristle's deflection over a step whose friction the solver has found, in the world, m; linear in the friction.
    fn bristle_step<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        _: &BristleLoad<'_, D, T>,
    ) -> Vector3<T> {
        Vector3::zeros()
    }

    /// Explains the derivatives of a point.
    fn reason<T: Scalar>(&self, at: &PointOutcome<'_, T>) -> ContactReason;
}

/// A friction coefficient that may be infinite as one that solvers can work with.
pub(super) fn bounded_friction<P: Scalar, T: Over<P>>(friction: P) -> T {
    T::from(friction).min(T::constant(STICKING))
}

impl<T: Scalar> ContactRow<T> {
    /// A row without a force.
    pub(crate) fn inactive() -> Self {
        Self {
            reference: T::zero(),
            compliance: T::constant(f64::INFINITY),
        }
    }

    /// Returns this row where a margin is positive, elsewhere that of a point that takes no part.
    pub(crate) fn within(self, margin: T) -> Self {
        let out = T::constant(f64::INFINITY);
        Self {
            compliance: T::zero().select_lt(margin, self.compliance, out),
            ..self
        }
    }
}

impl<T: Scalar, const N: usize> ContactRow<Dual<T, N>> {
    /// y at a fixed force f less the acceleration along the row, R f − reference; `None` for a row without a force, whatever its reference is.
    pub(crate) fn y_at_rest(&self, force: T) -> Option<Dual<T, N>> {
        let has_force = self.compliance.value(0) != f64::INFINITY;
        has_force.then(|| self.compliance.each(|x| x * force) - self.reference)
    }
}

impl<D, T: Scalar> PointKinematics<'_, D, T> {
    /// Velocity of the body at the point along the axes, m/s.
    pub(super) fn velocity(&self) -> [T; ROWS] {
        self.along_axes(&self.state.velocity)
    }

    /// Deflection of the bristle along the axes, m; zero for laws without.
    pub(super) fn deflection(&self) -> [T; ROWS] {
        let deflection = self.deflection.map(|m| self.along_axes(&m));
        deflection.unwrap_or([T::zero(); ROWS])
    }

    fn along_axes(&self, x: &Vector3<T>) -> [T; ROWS] {
        each(|k| dot(&self.axes[k], x))
    }
}

/// A point of flat ground for the tests of laws: the normal is z, the tangents are x and y.
#[cfg(test)]
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SamplePoint {
    pub(super) depth: f64,
    /// Normal, tangent, tangent.
    pub(super) velocity: [f64; ROWS],
    /// Along the tangents.
    pub(super) deflection: [f64; 2],
    pub(super) delassus: f64,
    pub(super) dt: f64,
    pub(super) kappa: f64,
    pub(super) speculative: bool,
}

#[cfg(test)]
impl SamplePoint {
    pub(super) fn state(&self) -> PointState<f64> {
        let [n, x, y] = self.velocity;
        PointState {
            depth: self.depth,
            velocity: Vector3::new(x, y, n),
            ..PointState::zero()
        }
    }

    pub(super) fn rows(&self, law: &impl PointLaw<f64>) -> [ContactRow<f64>; ROWS] {
        let state = self.state();
        law.rows(&PointKinematics {
            state: &state,
            axes: &state.axes(),
            deflection: Some(Vector3::new(self.deflection[0], self.deflection[1], 0.0)),
            delassus: self.delassus,
            dt: self.dt,
            kappa: Some(self.kappa).filter(|kappa| *kappa > 0.0),
            speculative: self.speculative,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Δt ṁ / (1 + Δt r): exact for r = 0, and never past the end for any r.
    #[test]
    fn step_of_a_bristle_is_implicit_in_its_relaxation() {
        let rate = |relaxation| BristleRate {
            deflection: Vector3::new(3.0, 0.0, -6.0),
            relaxation,
        };
        assert_eq!(rate(0.0).step(0.5), Vector3::new(1.5, 0.0, -3.0));
        assert_eq!(rate(4.0).step(0.5), Vector3::new(0.5, 0.0, -1.0));
        // ṁ = −r m straightens, and no more than that.
        let (r, m) = (1e9, Vector3::new(0.1, -0.2, 0.0));
        let falling = BristleRate {
            deflection: m * -r,
            relaxation: r,
        };
        assert!((m + falling.step(0.01)).norm() < 1e-7);
    }

    #[test]
    fn friction_that_is_infinite_is_bounded_and_other_friction_is_not_changed() {
        assert_eq!(bounded_friction::<f64, f64>(f64::INFINITY), STICKING);
        assert_eq!(bounded_friction::<f64, f64>(0.7), 0.7);
    }

    #[test]
    fn rows_outside_of_a_margin_are_inactive() {
        let row = ContactRow {
            reference: 3.0,
            compliance: 0.25,
        };
        assert_eq!(row.within(1e-9).compliance, 0.25);
        for margin in [0.0, -1.0] {
            assert_eq!(row.within(margin).compliance, f64::INFINITY);
        }
        assert_eq!(ContactRow::<f64>::inactive().compliance, f64::INFINITY);
    }
}
