//! Momentum of the whole robot, about its centre of mass and in its base frame.
//!
//! The centroidal frame G has its origin in the centre of mass and the axes of the world: h = `A_G` v with h =
//! `[linear; angular]` momentum. The same sums in another frame give total momentum and locked inertia in that frame.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, Vector3};

use super::center_of_mass::center_of_mass_at;
use super::jacobian::{add_to_column, spatial_columns};
use super::kinematics::{Kinematics, forward_kinematics};
use crate::model::{BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Inertia, Motion, SPATIAL, Transform};

/// Frame in which momentum and locked inertia are expressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MomentumFrame {
    /// Origin in the centre of mass, axes of the world.
    Centroidal,
    /// The world frame.
    World,
    /// The frame of the first body: the base of a floating robot.
    Base,
}

/// Computes the momentum h = `[linear; angular]` of all bodies (kg·m/s, kg·m²/s), in a chosen frame. Allocates working
/// memory.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length.
pub fn momentum<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    frame: MomentumFrame,
) -> Force<T> {
    momentum_at(model, &forward_kinematics(model, q, v), frame)
}

/// [`momentum`] from known poses and velocities, without allocation.
///
/// # Panics
/// If the kinematics are those of another robot.
pub(crate) fn momentum_at<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
    frame: MomentumFrame,
) -> Force<T> {
    kinematics.check(model);
    let total = bodies(model).fold(Force::zero(), |sum, id| {
        let h_B = model.body(id).inertia.times(&kinematics.velocity(Some(id)));
        sum + kinematics.pose(Some(id)).force(&h_B)
    });
    pose_of(model, kinematics, frame).force_inverse(&total)
}

/// [`momentum`] about the centre of mass.
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::centroidal_momentum, model::samples};
///
/// // A rod of 1 kg and 1 m about its end at 6 rad/s: m ω l / 2 and m l² ω / 12
/// let h = centroidal_momentum(&samples::pendulum(), &[0.4], &[6.0]);
/// assert!((h.linear.norm() - 3.0).abs() < 1e-14 && (h.angular.norm() - 0.5).abs() < 1e-14);
/// ```
pub fn centroidal_momentum<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T], v: &[T]) -> Force<T> {
    momentum(model, q, v, MomentumFrame::Centroidal)
}

/// Computes the momentum matrix A, 6 × `nv`:  h = A v, in a chosen frame. Allocates.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length.
///
/// # References
/// [Orin, Goswami, Lee 2013].
pub fn momentum_matrix<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    frame: MomentumFrame,
) -> DMatrix<T> {
    let kinematics = at_rest(model, q);
    let X_WE = pose_of(model, &kinematics, frame);
    let composite = composites(model, &kinematics);
    let mut out = DMatrix::zeros(SPATIAL, model.nv());
    for id in bodies(model) {
        let (body, X_WB) = (model.body(id), kinematics.pose(Some(id)));
        for (k, S) in body.columns() {
            // The whole subtree moves with the joint: I_c S.
            let S_W = X_WB.motion(&S);
            let h = X_WE.force_inverse(&composite[id.0].times::<T>(&S_W));
            add_to_column(&mut out, k, h.to_array());
        }
    }
    out
}

/// [`momentum_matrix`] about the centre of mass: the centroidal momentum matrix.
///
/// # Panics
/// If a slice has the wrong length.
pub fn centroidal_momentum_matrix<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T]) -> DMatrix<T> {
    momentum_matrix(model, q, MomentumFrame::Centroidal)
}

/// Computes the rate of the centroidal momentum, ḣ = A v̇ + Ȧ v, with axes of the world; for a free robot the sum of
/// the external forces about the centre of mass. Allocates working memory.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
/// * `a` – acceleration in tangent coordinates, length `nv` (rad/s² or m/s²)
///
/// # Panics
/// If a slice has the wrong length.
pub fn centroidal_momentum_rate<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: &[T],
) -> Force<T> {
    model.check_v(a);
    let kinematics = forward_kinematics(model, q, v);
    let accelerations = spatial_accelerations(model, &kinematics, v, a);
    let total = bodies(model).fold(Force::zero(), |sum, id| {
        let (I, V) = (&model.body(id).inertia, kinematics.velocity(Some(id)));
        let X_WB = kinematics.pose(Some(id));
        let A_B = X_WB.motion_inverse(&accelerations[id.0]);
        // Newton–Euler: I A + V ×* I V
        sum + X_WB.force(&(I.times(&A_B) + V.cross_force(&I.times(&V))))
    });
    // About the moving centre of mass: its velocity is parallel to the linear momentum, so no term is added.
    pose_of(model, &kinematics, MomentumFrame::Centroidal).force_inverse(&total)
}

/// Computes the locked inertia in a chosen frame: that of the robot as one rigid body. Allocates working memory.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length.
pub fn locked_inertia<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    frame: MomentumFrame,
) -> Inertia<T> {
    locked_inertia_at(model, &at_rest(model, q), frame)
}

/// [`locked_inertia`] from known poses, without allocation.
///
/// # Panics
/// If the kinematics are those of another robot.
pub(crate) fn locked_inertia_at<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
    frame: MomentumFrame,
) -> Inertia<T> {
    kinematics.check(model);
    let total = bodies(model).fold(Inertia::zero(), |sum, id| {
        sum + kinematics
            .pose(Some(id))
            .inertia(&model.body(id).inertia.lift())
    });
    pose_of(model, kinematics, frame).inverse().inertia(&total)
}

/// Computes the average velocity in a chosen frame: that of the locked robot with the same momentum, I⁻¹ h. Allocates.
///
/// Not finite for a robot without mass or with all mass on a line.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length.
pub fn average_velocity<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    frame: MomentumFrame,
) -> Motion<T> {
    solve(
        &locked_inertia(model, q, frame),
        &momentum(model, q, v, frame),
    )
}

/// Computes the Jacobian of the [`average_velocity`], 6 × `nv`. Allocates.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length.
pub fn average_velocity_jacobian<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    frame: MomentumFrame,
) -> DMatrix<T> {
    let inertia = locked_inertia(model, q, frame);
    let mut out = momentum_matrix(model, q, frame);
    for column in spatial_columns(&mut out) {
        *column = solve(&inertia, &Force::from_array(*column)).to_array();
    }
    out
}

/// Computes the velocity ċ of the centre of mass in the world, m/s. Allocates working memory.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::center_of_mass_velocity, model::samples};
///
/// let velocity = center_of_mass_velocity(&samples::pendulum(), &[0.4], &[6.0]);
/// assert!((velocity.norm() - 3.0).abs() < 1e-14); // ω l / 2
/// ```
pub fn center_of_mass_velocity<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
) -> Vector3<T> {
    per_mass(model, &centroidal_momentum(model, q, v).linear)
}

/// Computes the Jacobian of the centre of mass, 3 × `nv`:  ċ = J v. Allocates.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length.
pub fn center_of_mass_jacobian<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T]) -> DMatrix<T> {
    let total = <T as From<P>>::from(model.total_mass());
    let linear = centroidal_momentum_matrix(model, q).rows(0, 3).into_owned();
    if model.n_bodies() == 0 {
        linear
    } else {
        linear.map(|x| x / total)
    }
}

/// Computes the acceleration c̈ of the centre of mass in the world, m/s²; with `a` of zeros it is the bias J̇ v.
/// Allocates.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
/// * `a` – acceleration in tangent coordinates, length `nv` (rad/s² or m/s²)
///
/// # Panics
/// If a slice has the wrong length.
pub fn center_of_mass_acceleration<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: &[T],
) -> Vector3<T> {
    per_mass(model, &centroidal_momentum_rate(model, q, v, a).linear)
}

fn bodies<P: Scalar>(model: &Model<P>) -> impl DoubleEndedIterator<Item = BodyId> + use<P> {
    (0..model.n_bodies()).map(BodyId)
}

fn at_rest<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T]) -> Kinematics<T> {
    forward_kinematics(model, q, &vec![T::zero(); model.nv()])
}

fn per_mass<P: Scalar, T: Over<P>>(model: &Model<P>, momentum: &Vector3<T>) -> Vector3<T> {
    let total = <T as From<P>>::from(model.total_mass());
    if model.n_bodies() == 0 {
        Vector3::zeros()
    } else {
        momentum.map(|x| x / total)
    }
}

fn pose_of<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
    frame: MomentumFrame,
) -> Transform<T> {
    match frame {
        MomentumFrame::Centroidal => {
            Transform::from_translation(center_of_mass_at(model, kinematics))
        }
        MomentumFrame::World => Transform::identity(),
        MomentumFrame::Base => kinematics.pose((model.n_bodies() > 0).then_some(BodyId(0))),
    }
}

/// Inertia of each body with all that it carries, in the world.
fn composites<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
) -> Vec<Inertia<T>> {
    let mut out: Vec<_> = bodies(model)
        .map(|id| {
            kinematics
                .pose(Some(id))
                .inertia(&model.body(id).inertia.lift())
        })
        .collect();
    for id in bodies(model).rev() {
        if let Some(p) = model.body(id).parent {
            out[p.0] = out[p.0] + out[id.0];
        }
    }
    out
}

/// Spatial acceleration of each body, in the world: each joint adds S v̇ + V × S v.
fn spatial_accelerations<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
    v: &[T],
    a: &[T],
) -> Vec<Motion<T>> {
    let mut out: Vec<Motion<T>> = Vec::with_capacity(model.n_bodies());
    for id in bodies(model) {
        let (body, X_WB) = (model.body(id), kinematics.pose(Some(id)));
        let joint = body.motion(a) + body.velocity_product(&kinematics.velocity(Some(id)), v);
        let A_P = body.parent.map_or_else(Motion::zero, |p| out[p.0]);
        out.push(A_P + X_WB.motion(&joint));
    }
    out
}

/// I⁻¹ h. About the centre of mass the equations separate: v = p / m, ω = J⁻¹ L.
fn solve<T: Scalar>(inertia: &Inertia<T>, h: &Force<T>) -> Motion<T> {
    let to_com = Transform::from_translation(inertia.com());
    let at_com = to_com.force_inverse(h);
    let j = inertia.about_com();
    // ω by the cofactors of the symmetric matrix J
    let (xx, yy, zz) = (
        j.yy * j.zz - j.yz * j.yz,
        j.xx * j.zz - j.xz * j.xz,
        j.xx * j.yy - j.xy * j.xy,
    );
    let (xy, xz, yz) = (
        j.xz * j.yz - j.xy * j.zz,
        j.xy * j.yz - j.xz * j.yy,
        j.xy * j.xz - j.xx * j.yz,
    );
    let determinant = j.xx * xx + j.xy * xy + j.xz * xz;
    let cofactors = crate::spatial::Symmetric3::new(xx, xy, xz, yy, yz, zz);
    let omega = cofactors.times::<T>(&at_com.angular) * (T::one() / determinant);
    to_com.motion(&Motion::new(at_com.linear.map(|x| x / inertia.mass), omega))
}
