//! The centre of mass of the moving bodies.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::kinematics::{Kinematics, forward_kinematics};
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{rotate_data, scale, scale_data};

/// Computes the position of the centre of mass of all moving bodies in the world, m.
///
/// Links fixed to the world are ignored; without moving bodies it is the origin. Allocates working memory.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::center_of_mass, model::samples};
///
/// assert!((center_of_mass(&samples::pendulum(), &[0.0]).z + 0.5).abs() < 1e-15);
/// ```
pub fn center_of_mass<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T]) -> Vector3<T> {
    let at_rest = vec![T::zero(); model.nv()];
    center_of_mass_at(model, &forward_kinematics(model, q, &at_rest))
}

/// [`center_of_mass`] from known poses, without allocation:  c = Σ (m p + R h) / Σ m.
pub(crate) fn center_of_mass_at<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
) -> Vector3<T> {
    if model.n_bodies() == 0 {
        return Vector3::zeros();
    }
    let total = <T as From<P>>::from(model.total_mass());
    scale(&first_moment(model, kinematics), T::one() / total)
}

/// Σ m c over all bodies, in the world, kg·m.
pub(super) fn first_moment<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
) -> Vector3<T> {
    kinematics.check(model);
    let of_body = |(body, X_WB): (&crate::model::Body<P>, &crate::spatial::Transform<T>)| {
        scale_data(&X_WB.translation, body.inertia.mass)
            + rotate_data(&X_WB.rotation, &body.inertia.first_moment)
    };
    model
        .bodies()
        .iter()
        .zip(&kinematics.X_WB)
        .map(of_body)
        .fold(Vector3::zeros(), |sum, moment| sum + moment)
}
