//! Parts of bodies without gravity.
//!
//! In the dynamics gravity is an acceleration of the world the other way, which acts on all there is. With the mass m₀ and the first moment h₀ of the
//! part of a body that it shall not act on, and gravity g in the body, inverse dynamics lacks the force
//!
//! > F₀ = (m₀ g, h₀ × g),
//!
//! which is added to the force that the body needs. When the body turns by δθ, g changes by g × δθ. Robots without such parts take none of these
//! ways.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::kinematics::Kinematics;
use super::passes::to_world;
use crate::model::{BodyId, Model, Weightless};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{cross, lift_vector, rotate, rotate_back, scale};
use crate::spatial::{Force, Inertia, Motion, Transform};

/// A part of a body that gravity does not act on, at a configuration.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spared<T> {
    pub(super) body: BodyId,
    /// m₀, kg.
    mass: T,
    /// h₀ in the body, kg·m.
    first_moment: Vector3<T>,
    pub(super) X_WB: Transform<T>,
    /// Gravity in the body, m/s².
    pub(super) gravity: Vector3<T>,
}

impl<T: Scalar> Spared<T> {
    fn new<P: Scalar>(model: &Model<P>, own: &Weightless<P>, X_WB: Transform<T>) -> Self
    where
        T: Over<P>,
    {
        let inertia = &model.body(own.body).inertia;
        let moment = lift_vector::<P, T>(&inertia.first_moment);
        let (mass, first_moment) = own.of(T::from(inertia.mass), &moment);
        let gravity = lift_vector::<P, T>(model.gravity());
        Self {
            body: own.body,
            mass,
            first_moment,
            X_WB,
            gravity: rotate_back(&X_WB.rotation, &gravity),
        }
    }

    /// F₀ under a gravity in the body.
    pub(super) fn under(&self, gravity: &Vector3<T>) -> Force<T> {
        Force::new(
            scale(gravity, self.mass),
            cross(&self.first_moment, gravity),
        )
    }

    /// F₀ if the body had another inertia.
    pub(super) fn force_of<P: Scalar>(&self, own: &Weightless<P>, inertia: &Inertia<T>) -> Force<T>
    where
        T: Over<P>,
    {
        let (mass, first_moment) = own.of(inertia.mass, &inertia.first_moment);
        let other = Self {
            mass,
            first_moment,
            ..*self
        };
        other.under(&other.gravity)
    }

    /// L with  W · F₀ = g · L.
    pub(super) fn momentum(&self, W: &Motion<T>) -> Vector3<T> {
        scale(&W.linear, self.mass) + cross(&W.angular, &self.first_moment)
    }
}

/// One of the parts, with F₀ on its body.
///
/// * `X_PB` – pose of each body in its parent, by index
pub(super) fn spared_part<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    index: usize,
    X_PB: impl Fn(usize) -> Transform<T>,
) -> (Spared<T>, Force<T>) {
    let own = &model.weightless()[index];
    let way = to_world(model, Some(own.body));
    let X_WB = way.fold(Transform::identity(), |X, (id, _)| X_PB(id.0) * X);
    let spared = Spared::new(model, own, X_WB);
    (spared, spared.under(&spared.gravity))
}

/// Adds F₀ to the force that each body needs.
///
/// * `X_PB` – pose of each body in its parent
#[inline(never)]
pub(super) fn add_spared<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    X_PB: &[Transform<T>],
    forces: &mut [Force<T>],
) {
    for k in 0..model.weightless().len() {
        let (spared, F) = spared_part(model, k, |i| X_PB[i]);
        forces[spared.body.0] += F;
    }
}

/// First moment in the world of all that gravity does not act on, kg·m.
pub(super) fn spared_moment<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
) -> Vector3<T> {
    let moment = |own: &Weightless<P>| {
        let X_WB = kinematics.X_WB[own.body.0];
        let spared = Spared::new(model, own, X_WB);
        rotate(&X_WB.rotation, &spared.first_moment) + scale(&X_WB.translation, spared.mass)
    };
    let all = model.weightless().iter().map(moment);
    all.fold(Vector3::zeros(), |sum, moment| sum + moment)
}
