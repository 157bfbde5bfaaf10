//! Contact models: one file each, with the list of functions that [`law`] documents.

mod hunt_crossley;
mod impact;
mod law;
mod relaxed_rigid;
mod rigid;
mod soft;

pub use hunt_crossley::HuntCrossley;
pub(crate) use hunt_crossley::{SpringDamper, StepForce};
pub(crate) use law::{
    BristleLoad, BristleRate, ContactRow, ExplicitForce, LawKind, PointKinematics, ROWS,
};
pub use relaxed_rigid::RelaxedRigid;
pub use rigid::Rigid;
pub(crate) use soft::STANDARD_GRAVITY;
pub use soft::{SoftContact, SoftForce};

use law::{PointLaw, bounded_friction};
use nalgebra::Vector3;

use super::activation::ActivationMargin;
use super::compliance::Compliance;
use super::material::Material;
use super::point_state::PointState;
use super::reason::{ContactReason, PointOutcome};
use crate::numbers::{Numbers, numbers};
use crate::scalar::{Over, Scalar};

/// Contact model of a point: its force law. All points of a robot have the same kind of contact model; parameters may differ between links.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ContactLaw<P = f64> {
    /// Springs, dampers and bristles.
    Soft(SoftContact<P>),
    /// Regularised contact: a convex problem with small penetration, as in `MuJoCo`.
    RelaxedRigid(RelaxedRigid<P>),
    /// Rigid contact: no penetration, Coulomb friction, impacts with restitution.
    Rigid(Rigid<P>),
}

numbers! { pub enum ContactLaw {
    Soft(law: part(SoftContact)),
    RelaxedRigid(law: part(RelaxedRigid)),
    Rigid(law: part(Rigid)),
} }

/// Maximum number of parameters of a contact model.
pub(crate) const LAW_NUMBERS: usize = <ContactLaw as Numbers<f64>>::COUNT;

/// Evaluates an expression for the law of a point, whichever it is. A new law has a line here.
macro_rules! with_law {
    ($self:expr, $law:ident => $result:expr) => {
        match $self {
            ContactLaw::Soft($law) => $result,
            ContactLaw::RelaxedRigid($law) => $result,
            ContactLaw::Rigid($law) => $result,
        }
    };
}

/// The functions of [`PointLaw`], of whichever law it is.
impl<P: Scalar> ContactLaw<P> {
    pub(crate) fn kind(&self) -> &'static LawKind {
        fn kind<P: Scalar, L: PointLaw<P>>(_: &L) -> &'static LawKind {
            const { &L::KIND }
        }
        with_law!(self, law => kind(law))
    }

    /// # Panics
    /// If a parameter is out of range; the message names it.
    pub(crate) fn check(&self) {
        self.check_numbers();
        if let Self::Soft(law) = self {
            law.check_force();
        }
    }

    /// μ as solvers can work with it, finite.
    pub(crate) fn bounded_friction<T: Over<P>>(&self) -> T {
        bounded_friction(self.material().friction)
    }

    /// Restitution of a law by which impacts act at once; `None` without, or if it is zero.
    pub(crate) fn restitution(&self) -> Option<P> {
        match self {
            Self::Rigid(law) => {
                Some(law.restitution).filter(|e| !e.has_value() || e.value(0) > 0.0)
            }
            Self::Soft(_) | Self::RelaxedRigid(_) => None,
        }
    }

    /// [`bounded_friction`](Self::bounded_friction) of a point at a depth (m): none of one that is met before it arrives.
    pub(crate) fn friction_at<T: Over<P>>(&self, depth: T, speculative: bool) -> T {
        let friction = self.bounded_friction();
        if speculative {
            return depth.select_lt(T::zero(), T::zero(), friction);
        }
        friction
    }

    /// See [`PointLaw::turning`].
    pub(crate) fn turning<T: Over<P>>(&self, dt: T, across: T) -> [T; 2] {
        with_law!(self, law => law.turning(dt, across))
    }

    /// Friction and restitution.
    pub(crate) fn material(&self) -> Material<P> {
        with_law!(self, law => law.material())
    }

    /// Sets friction, restitution and compliance, as far as the law has them.
    pub(crate) fn set_material(&mut self, pair: Material<P>) {
        with_law!(self, law => law.set_material(pair));
        if let Some(own) = pair.compliance {
            with_law!(self, law => law.set_compliance(own));
        }
    }

    /// # Panics
    /// If the compliance of a material is for another contact model.
    pub(crate) fn check_compliance(&self, material: &Material<P>) {
        let mut own = *self;
        let fits = |x: Compliance<P>| with_law!(&mut own, law => law.set_compliance(x));
        assert!(
            material.compliance.is_none_or(fits),
            "a material has a compliance, which {} contact does not have: give it that of this model or none",
            self.kind().name
        );
    }

    pub(crate) fn activation_margin<D: Scalar>(&self, dt: D) -> ActivationMargin<D> {
        with_law!(self, law => law.activation_margin(dt))
    }

    pub(crate) fn rows<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        at: &PointKinematics<'_, D, T>,
    ) -> [ContactRow<T>; ROWS] {
        with_law!(self, law => law.rows(at))
    }

    pub(crate) fn least_velocity<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        depth: T,
        v: T,
        dt: D,
    ) -> Option<T> {
        with_law!(self, law => law.least_velocity(depth, v, dt))
    }

    pub(crate) fn explicit_force<T: Over<P>>(
        &self,
        at: &PointState<T>,
        deflection: &Vector3<T>,
    ) -> Option<ExplicitForce<T>> {
        with_law!(self, law => law.explicit_force(at, deflection))
    }

    pub(crate) fn bristle_step<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        at: &BristleLoad<'_, D, T>,
    ) -> Vector3<T> {
        with_law!(self, law => law.bristle_step(at))
    }

    pub(crate) fn reason<T: Scalar>(&self, at: &PointOutcome<'_, T>) -> ContactReason {
        with_law!(self, law => law.reason(at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Cast;

    fn all() -> [ContactLaw; 3] {
        [
            ContactLaw::Soft(SoftContact::estimate(1.0, 1, 1e-3)),
            ContactLaw::RelaxedRigid(RelaxedRigid::default()),
            ContactLaw::Rigid(Rigid::default()),
        ]
    }

    // The declared properties of a kind against the results of its functions.
    #[test]
    fn kinds_say_what_their_functions_give() {
        for law in all() {
            let (kind, at) = (law.kind(), PointState::<f64>::zero());
            let explicit = law.explicit_force(&at, &Vector3::zeros());
            assert_eq!(explicit.is_none(), kind.solved_explicitly, "{}", kind.name);
            let least = law.least_velocity(0.0, 0.0, 0.01);
            assert_eq!(least.is_some(), kind.working_set, "{}", kind.name);
            let moved = law.bristle_step(&BristleLoad {
                depth: 0.01,
                separation: 0.0,
                friction: &Vector3::x(),
                deflection: &Vector3::zeros(),
                dt: 0.01,
            });
            assert_eq!(moved != Vector3::zeros(), kind.bristle, "{}", kind.name);
        }
    }

    #[test]
    fn only_laws_that_read_the_delassus_diagonal_depend_on_it() {
        for law in all() {
            let state = PointState {
                depth: 0.01,
                ..PointState::zero()
            };
            let compliance = |delassus: f64| {
                let rows = law.rows(&PointKinematics {
                    state: &state,
                    axes: &state.axes(),
                    deflection: None,
                    delassus,
                    dt: 0.01,
                    kappa: None,
                    speculative: false,
                });
                rows.map(|row| row.compliance)
            };
            let depends = compliance(1.0) != compliance(2.0);
            assert_eq!(depends, law.kind().reads_delassus, "{}", law.kind().name);
        }
    }

    #[test]
    fn laws_over_another_scalar_are_of_the_same_kind_and_have_the_same_numbers() {
        for law in all() {
            let cast: ContactLaw<crate::scalar::Lanes<2>> = law.cast();
            assert_eq!(cast.kind().name, law.kind().name);
            let friction: f64 = law.bounded_friction();
            let lanes: crate::scalar::Lanes<2> = cast.bounded_friction();
            assert_eq!(lanes.0, [friction; 2]);
        }
    }
}
