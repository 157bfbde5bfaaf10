//! Derivatives of frames and momentum, and second derivatives, in tangent space, by dual numbers through the whole robot.
//!
//! Functions of hyper-dual numbers are marked `#[inline]`: only programs that call them compile them.

use nalgebra::{DMatrix, DVector};
use num_dual::HyperDual64;
use num_traits::Zero;

use crate::autodiff::{CHUNK, TangentPoint};
use crate::dynamics::center_of_mass::center_of_mass;
use crate::dynamics::centroidal::{centroidal_momentum, centroidal_momentum_matrix};
use crate::dynamics::kinematics::{forward_kinematics, frame_pose_at, frame_velocity};
use crate::dynamics::rnea::inverse_dynamics;
use crate::model::{FrameId, Model};
use crate::scalar::{Differentiable, DualNumber, Scalar};
use crate::spatial::{Representation, SPATIAL};

/// Derivatives of a quantity in q and v.
#[derive(Clone, Debug, PartialEq)]
pub struct StateDerivatives<T = f64> {
    /// Derivative in tangent directions of q, rows × `nv`.
    pub dq: DMatrix<T>,
    /// Derivative in v, rows × `nv`.
    pub dv: DMatrix<T>,
}

type Chunk<T> = <T as Differentiable>::Dual<CHUNK>;

/// The Jacobian of a function of (q, x) at a point, the directions of q tangent: columns (δq, δx).
fn tangent_jacobian<T: Differentiable>(
    model: &Model<T>,
    q: &[T],
    x: &[T],
    rows: usize,
    mut f: impl FnMut(&[Chunk<T>], &[Chunk<T>], &mut [Chunk<T>]),
) -> DMatrix<T> {
    model.check_q(q);
    let (nv, n) = (model.nv(), model.nv() + x.len());
    let start: Vec<Chunk<T>> = q.iter().map(|&q| q.into()).collect();
    let value = |k: usize| k.checked_sub(nv).map_or(T::zero(), |k| x[k]);
    let mut y = vec![Chunk::<T>::zero(); rows];
    let mut out = DMatrix::zeros(rows, n);
    for first in (0..n).step_by(CHUNK) {
        let seeded = |k: usize| match k.checked_sub(first).filter(|&own| own < CHUNK) {
            Some(own) => Chunk::<T>::variable(value(k), own),
            None => value(k).into(),
        };
        let z: Vec<Chunk<T>> = (0..n).map(seeded).collect();
        f(
            model.integrate(&start, &z[..nv]).as_slice(),
            &z[nv..],
            &mut y,
        );
        for (row, y) in y.iter().enumerate() {
            for (column, &eps) in (first..n).zip(y.eps()) {
                out[(row, column)] = eps;
            }
        }
    }
    out
}

fn columns<T: Scalar>(m: &DMatrix<T>, first: usize, n: usize) -> DMatrix<T> {
    m.columns(first, n).into_owned()
}

/// Computes the derivative of the placement of a frame in q (tangent): rows are the entries of the rotation matrix, column by
/// column, then the translation; 12 × `nv`. Allocates.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If `q` has the wrong length.
pub fn frame_placement_derivatives<T: Differentiable>(
    model: &Model<T>,
    q: &[T],
    frame: FrameId,
) -> DMatrix<T> {
    let at_rest = vec![Chunk::<T>::zero(); model.nv()];
    tangent_jacobian(model, q, &[], 12, |q, _, y| {
        let pose = frame_pose_at(model, &forward_kinematics(model, q, &at_rest), frame);
        y[..9].copy_from_slice(pose.rotation.as_slice());
        y[9..].copy_from_slice(pose.translation.as_slice());
    })
}

/// Computes the derivatives of [`frame_velocity`] in q (tangent) and v (the frame's Jacobian), 6 × `nv` each. Allocates.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length.
pub fn frame_velocity_derivatives<T: Differentiable>(
    model: &Model<T>,
    q: &[T],
    v: &[T],
    frame: FrameId,
    representation: Representation,
) -> StateDerivatives<T> {
    model.check_v(v);
    let all = tangent_jacobian(model, q, v, SPATIAL, |q, v, y| {
        y.copy_from_slice(&frame_velocity(model, q, v, frame, representation).to_array());
    });
    split(&all, model.nv())
}

/// Computes the derivative of the centre of mass in q (tangent), 3 × `nv`. Allocates.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If `q` has the wrong length.
pub fn center_of_mass_derivatives<T: Differentiable>(model: &Model<T>, q: &[T]) -> DMatrix<T> {
    tangent_jacobian(model, q, &[], 3, |q, _, y| {
        y.copy_from_slice(center_of_mass(model, q).as_slice());
    })
}

/// Computes the derivatives of the centroidal momentum in q (tangent) and v (the centroidal momentum matrix), 6 × `nv` each.
/// Allocates.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length.
pub fn centroidal_momentum_derivatives<T: Differentiable>(
    model: &Model<T>,
    q: &[T],
    v: &[T],
) -> StateDerivatives<T> {
    model.check_v(v);
    let all = tangent_jacobian(model, q, v, SPATIAL, |q, v, y| {
        y.copy_from_slice(&centroidal_momentum(model, q, v).to_array());
    });
    split(&all, model.nv())
}

/// Computes the rate of the centroidal momentum matrix when the robot moves with `v`, 6 × `nv`:  ḣ = A v̇ + Ȧ v. Allocates.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length.
pub fn centroidal_momentum_matrix_derivative<T: Differentiable>(
    model: &Model<T>,
    q: &[T],
    v: &[T],
) -> DMatrix<T> {
    model.check_v(v);
    let start: Vec<T::Dual<1>> = q.iter().map(|&q| q.into()).collect();
    let moving: Vec<_> = (v.iter().map(|&v| T::Dual::new(T::zero(), [v]))).collect();
    let q = model.integrate(&start, &moving);
    centroidal_momentum_matrix(model, q.as_slice()).map(|entry| entry.eps()[0])
}

fn split<T: Scalar>(all: &DMatrix<T>, nv: usize) -> StateDerivatives<T> {
    StateDerivatives {
        dq: columns(all, 0, nv),
        dv: columns(all, nv, nv),
    }
}

/// Computes the second derivatives of τ = ID(q, v, a) in x = (δq, v, a): one symmetric 3 `nv` × 3 `nv` matrix for each entry of
/// τ. O(nv²) evaluations on hyper-dual numbers; allocates.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
/// * `a` – acceleration in tangent coordinates, length `nv` (rad/s² or m/s²)
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
pub fn inverse_dynamics_second_derivatives(
    model: &Model,
    q: &[f64],
    v: &[f64],
    a: &[f64],
) -> Vec<DMatrix<f64>> {
    let n = 3 * model.nv();
    let mut out = vec![DMatrix::zeros(n, n); model.nv()];
    let mut point = hyper_dual_point(model, q, v, a);
    let integrate = |q: &[_], dq: &[_], out: &mut [_]| model.integrate_into(q, dq, out);
    for i in 0..n {
        for k in 0..=i {
            let tau = point.in_pair([i, k], integrate, |q, va| dynamics_at(model, q, va));
            for (h, tau) in out.iter_mut().zip(&tau) {
                h[(i, k)] = tau.eps1eps2;
                h[(k, i)] = tau.eps1eps2;
            }
        }
    }
    out
}

/// (q ⊕ δq, (v, a)), to be seeded.
#[inline]
fn hyper_dual_point(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> TangentPoint<HyperDual64> {
    let mut out = TangentPoint::new(q.len(), model.nv(), v.len() + a.len());
    out.set(q, &[v, a].concat());
    out
}

#[inline]
fn dynamics_at(model: &Model, q: &[HyperDual64], va: &[HyperDual64]) -> DVector<HyperDual64> {
    let (v, a) = va.split_at(model.nv());
    inverse_dynamics(model, q, v, a)
}
