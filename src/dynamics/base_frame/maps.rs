//! Jacobians, mass matrices and Coriolis matrices for velocities whose base part is in another representation.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DMatrix;

use super::base_velocity;
use crate::model::{BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Motion, Representation, SPATIAL, Transform};

/// A Jacobian (any rows × `nv`) for velocities whose base part is in another representation: J T⁻¹.
///
/// # Panics
/// If `q` has the wrong length, or `jacobian` has not `nv` columns.
pub(super) fn jacobian_to_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    jacobian: &DMatrix<T>,
    to: Representation,
) -> DMatrix<T> {
    check_columns(model, "a Jacobian", jacobian);
    let mut out = jacobian.clone();
    if let Some(X_WB) = base_pose(model, q) {
        map_rows(&mut out, |_, row| to.force_from_body(&X_WB, &row));
    }
    out
}

/// The rate of a Jacobian (any rows × `nv`) for velocities whose base part is in another representation:
/// J̇' = (J̇ − J T⁻¹ Ṫ) T⁻¹. For the rate of a momentum matrix as well.
///
/// * `v` – velocity, in the crate's own representation
/// * `jacobian`, `derivative` – J and J̇, for velocities in the crate's own representation
///
/// # Panics
/// If a slice has the wrong length, or the matrices have not the same rows and `nv` columns.
pub(super) fn jacobian_derivative_to_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    jacobian: &DMatrix<T>,
    derivative: &DMatrix<T>,
    to: Representation,
) -> DMatrix<T> {
    model.check_v(v);
    check_columns(model, "a Jacobian", jacobian);
    let (given, expected) = (derivative.shape(), jacobian.shape());
    assert_eq!(given, expected, "J and its rate have the same shape");
    let mut out = derivative.clone();
    if let Some(X_WB) = base_pose(model, q) {
        let turning = to.turning(&base_velocity(v));
        // A row f of J changes as a force does: −f (Ω ×) = Ω ×* f.
        map_rows(&mut out, |i, row| {
            let rate = row + turning.cross_force(&base_part(jacobian, i));
            to.force_from_body(&X_WB, &rate)
        });
    }
    out
}

/// A mass matrix (`nv` × `nv`) for velocities whose base part is in another representation: T⁻ᵀ M T⁻¹.
///
/// # Panics
/// If `q` has the wrong length, or `mass_matrix` is not `nv` × `nv`.
pub(super) fn mass_matrix_to_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    mass_matrix: &DMatrix<T>,
    to: Representation,
) -> DMatrix<T> {
    check_square(model, "a mass matrix", mass_matrix);
    let half = jacobian_to_representation(model, q, mass_matrix, to);
    jacobian_to_representation(model, q, &half.transpose(), to)
}

/// The inverse of a mass matrix (`nv` × `nv`) for velocities whose base part is in another representation: T M⁻¹ Tᵀ.
/// For every other symmetric map from forces to accelerations as well.
///
/// # Panics
/// If `q` has the wrong length, or `inverse` is not `nv` × `nv`.
pub(super) fn mass_matrix_inverse_to_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    inverse: &DMatrix<T>,
    to: Representation,
) -> DMatrix<T> {
    check_square(model, "an inverse mass matrix", inverse);
    let Some(X_WB) = base_pose(model, q) else {
        return inverse.clone();
    };
    let to_velocity = |_: usize, row: Force<T>| {
        let V = Motion::new(row.linear, row.angular);
        let V = to.velocity_from_body(&X_WB, &V);
        Force::new(V.linear, V.angular)
    };
    let mut out = inverse.clone();
    map_rows(&mut out, to_velocity);
    out.transpose_mut();
    map_rows(&mut out, to_velocity);
    out
}

/// A Coriolis matrix (`nv` × `nv`) for velocities whose base part is in another representation:
/// C' = T⁻ᵀ (C − M T⁻¹ Ṫ) T⁻¹, with  h' = C' v' + g'.
///
/// Ṁ' − 2 C' is skew-symmetric if Ṁ − 2 C is.
///
/// * `v` – velocity, in the crate's own representation
/// * `coriolis`, `mass_matrix` – C(q, v) and M(q), in the crate's own representation
///
/// # Panics
/// If a slice has the wrong length, or a matrix is not `nv` × `nv`.
pub(super) fn coriolis_matrix_to_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    coriolis: &DMatrix<T>,
    mass_matrix: &DMatrix<T>,
    to: Representation,
) -> DMatrix<T> {
    check_square(model, "a Coriolis matrix", coriolis);
    check_square(model, "a mass matrix", mass_matrix);
    // M is a Jacobian of momentum, and C takes the place of its rate.
    let half = jacobian_derivative_to_representation(model, q, v, mass_matrix, coriolis, to);
    jacobian_to_representation(model, q, &half.transpose(), to).transpose()
}

/// Pose of a floating base.
fn base_pose<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T]) -> Option<Transform<T>> {
    model.check_q(q);
    let floats = model.has_floating_base();
    floats.then(|| model.body(BodyId(0)).place(q))
}

/// Maps the first six entries of each row, which map velocities of the base to a number and so transform as a force.
fn map_rows<T: Scalar>(matrix: &mut DMatrix<T>, map: impl Fn(usize, Force<T>) -> Force<T>) {
    for i in 0..matrix.nrows() {
        let mapped = map(i, base_part(matrix, i)).to_array();
        for (k, x) in mapped.into_iter().enumerate() {
            matrix[(i, k)] = x;
        }
    }
}

fn base_part<T: Scalar>(matrix: &DMatrix<T>, row: usize) -> Force<T> {
    Force::from_array(std::array::from_fn::<T, SPATIAL, _>(|k| matrix[(row, k)]))
}

fn check_columns<P: Scalar, T: Scalar>(model: &Model<P>, what: &str, matrix: &DMatrix<T>) {
    let (given, nv) = (matrix.ncols(), model.nv());
    assert_eq!(given, nv, "{what} of \"{}\" has {nv} columns", model.name());
}

fn check_square<P: Scalar, T: Scalar>(model: &Model<P>, what: &str, matrix: &DMatrix<T>) {
    let (given, nv) = (matrix.shape(), model.nv());
    assert_eq!(
        given,
        (nv, nv),
        "{what} of \"{}\" is {nv} × {nv}",
        model.name()
    );
}
