//! Quantities of a floating robot with its base velocity in another representation.
//!
//! Tangent vectors of this crate contain the base velocity in the base frame. With the map T(q) to another representation, v' = T v, all other
//! quantities follow from v̇' = T v̇ + Ṫ v and from the invariance of power:
//!
//! | quantity | in the other representation |
//! |---|---|
//! | force | τ' = T⁻ᵀ τ |
//! | Jacobian, momentum matrix | J' = J T⁻¹ |
//! | their rate | J̇' = (J̇ − J W) T⁻¹ |
//! | bias acceleration | J̇' v' = J̇ v − J W v |
//! | mass matrix, its inverse | M' = T⁻ᵀ M T⁻¹, M'⁻¹ = T M⁻¹ Tᵀ |
//! | Coriolis matrix | C' = T⁻ᵀ (C − M W) T⁻¹, so that h' = C' v' + g' and Ṁ' − 2 C' is skew |
//! | gravity force | g' = T⁻ᵀ g |
//! | bias force | h' = T⁻ᵀ (h − M W v) |
//! | Jacobians of a step | A' = S(x⁺) A S(x)⁻¹, B' = S(x⁺) B, see [`BaseQuantity::Deviation`] |
//!
//! with W = T⁻¹ Ṫ, which is Ω × on the base velocity and zero elsewhere. Ω is the velocity of the base relative to the axes of the representation: 0
//! for *body*, the angular velocity for *mixed*, the velocity for *inertial*. Quantities of a robot with a fixed base do not change. [`BaseFrame`]
//! converts results of other functions, and contains the equation of motion in one representation.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

mod given;
mod maps;
mod state;

pub use given::{BaseFrame, BaseQuantity};
use maps::{
    coriolis_matrix_to_representation, jacobian_derivative_to_representation,
    jacobian_to_representation, mass_matrix_inverse_to_representation,
    mass_matrix_to_representation,
};
use state::{deviation_from_representation, gradient_from_representation};
pub(crate) use state::{deviation_to_representation, gradient_to_representation};

use nalgebra::DVector;

use crate::model::{BodyId, Model};
use crate::scalar::{Over, Scalar, from_each};
use crate::spatial::{Force, Motion, Representation, SPATIAL, Transform};

/// A velocity (length `nv`) with its base part in another representation.
pub(crate) fn velocity_to_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    to: Representation,
) -> DVector<T> {
    map_base(model, q, v, |X_WB, x| {
        to.velocity_from_body(X_WB, &Motion::from_array(x))
            .to_array()
    })
}

/// A velocity (length `nv`) whose base part is in another representation, in the crate's own.
pub(crate) fn velocity_from_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    from: Representation,
) -> DVector<T> {
    map_base(model, q, v, |X_WB, x| {
        from.velocity_to_body(X_WB, &Motion::from_array(x))
            .to_array()
    })
}

/// Joint forces (length `nv`) with the force on the base in another representation.
pub(crate) fn force_to_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    tau: &[T],
    to: Representation,
) -> DVector<T> {
    map_base(model, q, tau, |X_WB, x| {
        to.force_from_body(X_WB, &Force::from_array(x)).to_array()
    })
}

/// Joint forces (length `nv`) whose force on the base is in another representation, in the crate's own.
pub(crate) fn force_from_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    tau: &[T],
    from: Representation,
) -> DVector<T> {
    map_base(model, q, tau, |X_WB, x| {
        from.force_to_body(X_WB, &Force::from_array(x)).to_array()
    })
}

/// Accelerations (length `nv`) with the base part as the rate of its velocity in another representation.
///
/// * `v` – velocity, in the crate's own representation
pub(crate) fn acceleration_to_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: &[T],
    to: Representation,
) -> DVector<T> {
    model.check_v(v);
    map_base(model, q, a, |X_WB, x| {
        to.acceleration_from_body(X_WB, &base_velocity(v), &Motion::from_array(x))
            .to_array()
    })
}

/// Accelerations (length `nv`) whose base part is the rate of its velocity in another representation, in the crate's
/// own.
///
/// * `v` – velocity, in the crate's own representation
pub(crate) fn acceleration_from_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: &[T],
    from: Representation,
) -> DVector<T> {
    model.check_v(v);
    map_base(model, q, a, |X_WB, x| {
        from.acceleration_to_body(X_WB, &base_velocity(v), &Motion::from_array(x))
            .to_array()
    })
}

/// Applies a map to the first six entries of a tangent vector if they are those of a floating base.
fn map_base<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    x: &[T],
    map: impl Fn(&Transform<T>, [T; SPATIAL]) -> [T; SPATIAL],
) -> DVector<T> {
    model.check_q(q);
    model.check_v(x);
    let mut out = DVector::from_column_slice(x);
    if model.has_floating_base() {
        let X_WB = model.body(BodyId(0)).place(q);
        let mapped = map(&X_WB, from_each(|k| x[k]));
        out.as_mut_slice()[..SPATIAL].copy_from_slice(&mapped);
    }
    out
}

fn base_velocity<T: Scalar>(v: &[T]) -> Motion<T> {
    Motion::from_array(from_each(|k| v[k]))
}
