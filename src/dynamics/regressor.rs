//! Regressors: dynamics as linear functions of the standard inertial parameters.
//!
//! The ten parameters of a body are (m, `h_x`, `h_y`, `h_z`, `J_xx`, `J_xy`, `J_yy`, `J_xz`, `J_yz`, `J_zz`): mass,
//! first moment and rotational inertia about the origin of the body frame, in the body frame: π, the
//! [inertial](crate::model::ParameterLayout::inertial) part of [`Model::parameters`].

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, RowDVector, Vector3};

use super::kinematics::forward_kinematics;
use super::passes::carry_force;
use super::rnea::world_acceleration;
use super::weightless::spared_part;
use crate::model::{BodyId, Model};
use crate::nested::IntoNested;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{dot, lift_vector, rotate_data};
use crate::spatial::{INERTIAL_PARAMETERS, Inertia, Motion, Transform};

/// Computes the joint-torque regressor Y, `nv` × 10 `n_bodies`:  M a + h = Y π + armature · a.
///
/// Differentiable in q, v, a. Allocates.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
/// * `a` – acceleration in tangent coordinates, length `nv` (rad/s² or m/s²)
///
/// # Panics
/// If a slice has the wrong length.
///
/// # References
/// [Atkeson, An, Hollerbach 1986]; [Featherstone 2008, section 9.5].
pub fn joint_torque_regressor<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: &[T],
) -> DMatrix<T> {
    model.check_v(a);
    let kinematics = forward_kinematics(model, q, v);
    let mut out = DMatrix::zeros(model.nv(), INERTIAL_PARAMETERS * model.n_bodies());
    let X_PB: Vec<Transform<T>> = model.bodies().iter().map(|body| body.place(q)).collect();
    let mut A: Vec<Motion<T>> = Vec::with_capacity(model.n_bodies());
    let A_W = world_acceleration(model);
    for (i, body) in model.bodies().iter().enumerate() {
        let V = kinematics.velocity(Some(BodyId(i)));
        let from_parent = X_PB[i].motion_inverse(&body.parent.map_or(A_W, |p| A[p.0]));
        A.push(from_parent + body.velocity_product(&V, v) + body.motion(a));
        let own = model.weightless().iter().position(|own| own.body.0 == i);
        let spared = own.map(|k| {
            let (spared, _) = spared_part(model, k, |i| X_PB[i]);
            (spared, &model.weightless()[k])
        });
        for k in 0..INERTIAL_PARAMETERS {
            let unit = Inertia::unit(k);
            let mut F = unit.force(&V, &A[i]);
            if let Some((spared, own)) = &spared {
                F += spared.force_of(own, &Inertia::unit(k));
            }
            let mut column = out.column_mut(INERTIAL_PARAMETERS * i + k);
            carry_force(model, &X_PB, BodyId(i), F, |body, F| {
                body.add_projection(F, column.as_mut_slice());
            });
        }
    }
    out
}

/// Computes the regressor of the kinetic energy of the bodies, 1 × 10 `n_bodies`:  T = y π + ½ Σ armature v².
/// Allocates.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length.
pub fn kinetic_energy_regressor<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
) -> RowDVector<T> {
    let kinematics = forward_kinematics(model, q, v);
    row::<P, T>(model, |i, unit| {
        let V = kinematics.velocity(Some(BodyId(i)));
        V.power(&unit.times::<T>(&V)) * 0.5
    })
}

/// Computes the regressor of the potential energy, 1 × 10 `n_bodies`:  U = y π. Allocates.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length.
pub fn potential_energy_regressor<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
) -> RowDVector<T> {
    let kinematics = forward_kinematics(model, q, &vec![T::zero(); model.nv()]);
    let gravity = lift_vector::<P, T>(model.gravity());
    row::<P, T>(model, |i, unit| {
        let X_WB: Transform<T> = kinematics.pose(Some(BodyId(i)));
        let own = model.weightless().iter().find(|own| own.body.0 == i);
        let none = || (T::zero(), Vector3::zeros());
        let (m_0, h_0) = own.map_or_else(none, |own| own.of(unit.mass, &unit.first_moment));
        let moment = X_WB.translation * (unit.mass - m_0)
            + rotate_data::<T, T>(&X_WB.rotation, &(unit.first_moment - h_0));
        -dot(&moment, &gravity)
    })
}

fn row<P: Scalar, T: Scalar>(
    model: &Model<P>,
    entry: impl Fn(usize, &Inertia<T>) -> T,
) -> RowDVector<T> {
    let all = (0..model.n_bodies()).nested(|i| (0..INERTIAL_PARAMETERS).map(move |k| (i, k)));
    RowDVector::from_iterator(
        INERTIAL_PARAMETERS * model.n_bodies(),
        all.map(|(i, k)| entry(i, &Inertia::unit(k))),
    )
}
