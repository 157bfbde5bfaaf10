//! Velocities, forces, Jacobians and mass matrices of a floating robot with its base velocity in another
//! representation.
//!
//! The crate's own tangent vectors hold the base velocity in the base frame. With T(q) the 6 × 6 map from it to another
//! representation, v' = T v for velocities, τ' = T⁻ᵀ τ for forces, J' = J T⁻¹ for the columns of Jacobians and M' = T⁻ᵀ
//! M T⁻¹ for the mass matrix. All of it leaves a robot with a fixed base as it is.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, DVector};

use crate::model::{BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Motion, Representation, SPATIAL, Transform};

/// A velocity (length `nv`) with its base part in another representation.
pub fn velocity_to_representation<P: Scalar, T: Over<P>>(
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
pub fn velocity_from_representation<P: Scalar, T: Over<P>>(
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
pub fn force_to_representation<P: Scalar, T: Over<P>>(
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
pub fn force_from_representation<P: Scalar, T: Over<P>>(
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
pub fn acceleration_to_representation<P: Scalar, T: Over<P>>(
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
pub fn acceleration_from_representation<P: Scalar, T: Over<P>>(
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

/// A Jacobian (any rows × `nv`) for velocities whose base part is in another representation: J T⁻¹.
///
/// # Panics
/// If `jacobian` has not `nv` columns.
pub fn jacobian_to_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    jacobian: &DMatrix<T>,
    to: Representation,
) -> DMatrix<T> {
    let mut out = jacobian.clone();
    for (row, mut out) in jacobian.row_iter().zip(out.row_iter_mut()) {
        // A row of J maps velocities to a number, so it transforms as a force does.
        let row: Vec<T> = row.iter().copied().collect();
        out.iter_mut()
            .zip(&force_to_representation(model, q, &row, to))
            .for_each(|(out, &x)| *out = x);
    }
    out
}

/// A mass matrix (`nv` × `nv`) for velocities whose base part is in another representation: T⁻ᵀ M T⁻¹.
///
/// # Panics
/// If `mass_matrix` is not `nv` × `nv`.
pub fn mass_matrix_to_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    mass_matrix: &DMatrix<T>,
    to: Representation,
) -> DMatrix<T> {
    let half = jacobian_to_representation(model, q, mass_matrix, to);
    jacobian_to_representation(model, q, &half.transpose(), to)
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
        let mapped = map(&X_WB, std::array::from_fn(|k| x[k]));
        out.as_mut_slice()[..SPATIAL].copy_from_slice(&mapped);
    }
    out
}

fn base_velocity<T: Scalar>(v: &[T]) -> Motion<T> {
    Motion::from_array(std::array::from_fn(|k| v[k]))
}
