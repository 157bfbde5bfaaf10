//! Accelerations of frames, and the rate of their Jacobians.
//!
//! A column of a frame's Jacobian is a joint's motion subspace S seen from the frame F. It is fixed in its body B, so in axes E that move with `V_E`
//! it changes at the rate (`V_B` − `V_E`) × S. Body: `V_E = V_F`; mixed: the velocity ṗ without rotation; inertial: zero.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DMatrix;

use super::jacobian::add_to_column;
use super::passes::from_frame;
use crate::model::{Body, FrameId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Motion, Representation, SPATIAL, Transform};

/// Computes the rate J̇ of a frame's Jacobian, 6 × `nv`, in a chosen representation: d(J v)/dt = J v̇ + J̇ v.
///
/// O(depth of the frame). Allocates its result.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length, or the id is not one of the model.
pub fn frame_jacobian_derivative<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    frame: FrameId,
    representation: Representation,
) -> DMatrix<T> {
    let mut out = DMatrix::zeros(SPATIAL, model.nv());
    frame_jacobian_derivative_into(model, q, v, frame, representation, &mut out);
    out
}

/// [`frame_jacobian_derivative`] without allocation.
///
/// * `out` – output, 6 × `nv`
///
/// # Panics
/// If an argument has the wrong size for the model.
pub fn frame_jacobian_derivative_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    frame: FrameId,
    representation: Representation,
    out: &mut DMatrix<T>,
) {
    model.check_q(q);
    model.check_v(v);
    assert_eq!(
        out.shape(),
        (SPATIAL, model.nv()),
        "a frame Jacobian of \"{}\" is 6 × nv",
        model.name()
    );
    out.fill(T::zero());
    let axes = Axes::of(model, q, v, frame, representation);
    walk(model, q, v, frame, |body, X_BF, V_BF| {
        for (k, S) in body.columns() {
            let S_F = X_BF.motion_inverse(&S);
            let rate = axes.express(&(axes.turning - *V_BF).cross(&S_F));
            add_to_column(out, k, rate.to_array());
        }
    });
}

/// Computes the acceleration of a frame, d(J v)/dt = J v̇ + J̇ v, in a chosen representation. Does not allocate.
///
/// * `a` – v̇, length `nv`
///
/// In the mixed representation the linear part is p̈, the acceleration of the frame's origin. Gravity is not included.
///
/// # Panics
/// If a slice has the wrong length, or the id is not one of the model.
pub fn frame_acceleration<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: &[T],
    frame: FrameId,
    representation: Representation,
) -> Motion<T> {
    model.check_v(a);
    acceleration(model, q, v, Some(a), frame, representation)
}

/// Computes the bias acceleration J̇ v of a frame: its acceleration when v̇ = 0. Does not allocate.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length, or the id is not one of the model.
pub fn frame_bias_acceleration<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    frame: FrameId,
    representation: Representation,
) -> Motion<T> {
    acceleration(model, q, v, None, frame, representation)
}

fn acceleration<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: Option<&[T]>,
    frame: FrameId,
    representation: Representation,
) -> Motion<T> {
    model.check_q(q);
    model.check_v(v);
    let axes = Axes::of(model, q, v, frame, representation);
    let mut A = Motion::zero();
    walk(model, q, v, frame, |body, X_BF, V_BF| {
        let joint_velocity = X_BF.motion_inverse(&body.motion(v));
        A += (axes.turning - *V_BF).cross(&joint_velocity);
        if let Some(a) = a {
            A += X_BF.motion_inverse(&body.motion(a));
        }
    });
    axes.express(&A)
}

/// The axes of expression, seen from the frame.
struct Axes<T> {
    X_WF: Transform<T>,
    /// Velocity of the frame with respect to the axes, in the frame.
    turning: Motion<T>,
    representation: Representation,
}

impl<T: Scalar> Axes<T> {
    fn of<P: Scalar>(
        model: &Model<P>,
        q: &[T],
        v: &[T],
        frame: FrameId,
        representation: Representation,
    ) -> Self
    where
        T: Over<P>,
    {
        let (X_WF, V_F) = walk(model, q, v, frame, |_, _, _| {});
        let turning = representation.turning(&V_F);
        Self {
            X_WF,
            turning,
            representation,
        }
    }

    fn express(&self, in_frame: &Motion<T>) -> Motion<T> {
        self.representation.velocity_from_body(&self.X_WF, in_frame)
    }
}

/// Visits the bodies from the one that carries the frame to the world with `X_BF` and the velocity of F with respect to
/// B, in F. Returns `X_WF` and the velocity of F in the world, in F.
fn walk<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    frame: FrameId,
    mut visit: impl FnMut(&Body<P>, &Transform<T>, &Motion<T>),
) -> (Transform<T>, Motion<T>) {
    let mut V_BF = Motion::zero();
    let X_WF = from_frame(model, q, frame, |body, X_BF| {
        visit(body, X_BF, &V_BF);
        V_BF += X_BF.motion_inverse(&body.motion(v));
    });
    (X_WF, V_BF)
}
