//! The part of a body without gravity.

use nalgebra::Vector3;

use super::{BodyId, Model};
use crate::numbers::numbers;
use crate::scalar::{Over, Scalar};
use crate::spatial::Inertia;

/// Part of a body that gravity does not act on: of the mass m and the first moment h of the body, the mass ρ m and the first moment ρ h + m d.
///
/// It is linear in m and h, so that it follows when they change. Where gravity acts on no link of the body, ρ = 1 and d = 0.
#[derive(Clone, Debug)]
pub(crate) struct Weightless<P = f64> {
    pub(crate) body: BodyId,
    /// ρ.
    fraction: P,
    /// d in the body frame, m.
    offset: Vector3<P>,
}

numbers! { struct Weightless { body: kept(), fraction: hidden(), offset: hidden() } }

impl<P: Scalar> Weightless<P> {
    /// A body without gravity.
    pub(super) fn whole(body: BodyId) -> Self {
        Self {
            body,
            fraction: P::one(),
            offset: Vector3::zeros(),
        }
    }

    /// A body with links that gravity acts on, and others.
    ///
    /// * `all`, `part` – inertia of all links, and of those that gravity does not act on, in the body frame
    pub(super) fn part_of(body: BodyId, all: &Inertia<P>, part: &Inertia<P>) -> Self {
        let per_mass = P::one() / all.mass;
        let fraction = part.mass * per_mass;
        Self {
            body,
            fraction,
            offset: (part.first_moment - all.first_moment * fraction) * per_mass,
        }
    }

    /// Mass (kg) and first moment in the body frame (kg·m) that gravity does not act on, of those of the body.
    pub(crate) fn of<T: Over<P>>(&self, mass: T, first_moment: &Vector3<T>) -> (T, Vector3<T>) {
        let along = |k: usize| first_moment[k] * self.fraction + mass * self.offset[k];
        (
            mass * self.fraction,
            Vector3::new(along(0), along(1), along(2)),
        )
    }
}

impl Weightless<f64> {
    /// Whether gravity acts on nothing of the body.
    #[cfg(feature = "formats")]
    pub(crate) fn is_whole(&self) -> bool {
        self.fraction == 1.0 && self.offset == Vector3::zeros()
    }
}

impl<P: Scalar> Model<P> {
    /// The bodies that have a part which gravity does not act on.
    #[inline]
    pub(crate) fn weightless(&self) -> &[Weightless<P>] {
        &self.weightless
    }

    /// The part of a body on which gravity does not act: mass, kg, and first moment in the body frame, kg·m. Usually zero; see
    /// [`LinkSpec::without_gravity`](super::LinkSpec::without_gravity).
    ///
    /// # Panics
    /// If the id is not one of this model.
    pub fn weightless_part(&self, body: BodyId) -> (P, Vector3<P>) {
        let Inertia {
            mass, first_moment, ..
        } = self.body(body).inertia;
        let own = self.weightless.iter().find(|own| own.body == body);
        own.map_or((P::zero(), Vector3::zeros()), |own| {
            own.of(mass, &first_moment)
        })
    }
}
