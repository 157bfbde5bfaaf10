//! Residuals of a frame: its position, orientation, pose, velocity and distance.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Vector3};

use super::away_from;
use crate::dynamics::{frame_jacobian_into, frame_pose, frame_velocity};
use crate::model::FrameId;
use crate::scalar::Scalar;
use crate::spatial::linear::{dot, rotate_back};
use crate::spatial::{Representation, SPATIAL, Transform, rotation_vector};
use crate::trajopt::residual::{Node, Residual, ResidualJacobian, fixed_size};

/// p − target, m: position error of the origin of a frame in the world, 3 entries.
#[derive(Clone, Debug, PartialEq)]
pub struct FramePosition {
    /// The frame.
    pub frame: FrameId,
    /// Target of the origin of the frame in the world, m.
    pub target: Vector3<f64>,
}

impl FramePosition {
    /// Makes the residual of the origin of `frame` from `target` (m, in the world).
    pub fn new(frame: FrameId, target: [f64; 3]) -> Self {
        Self {
            frame,
            target: target.into(),
        }
    }
}

impl Residual for FramePosition {
    fixed_size!(3, Configuration);

    fn eval<T: Scalar>(&self, node: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        let p_WF = pose(node, x, self.frame).translation;
        away_from(self.target.as_slice(), p_WF.as_slice(), r);
    }

    /// The linear rows of the frame's Jacobian in mixed representation.
    fn linearize(&self, node: &Node<'_>, x: &[f64], u: &[f64], out: &mut ResidualJacobian) {
        self.value(node, x, u, &mut out.values);
        let (q, mixed) = (&x[..node.model().nq()], Representation::Mixed);
        frame_jacobian_into(node.model(), q, self.frame, mixed, &mut out.spatial);
        out.copy_spatial_rows();
    }
}

/// log(targetᵀ R), rad: the rotation vector from the target to the frame, in the axes of the target, 3 entries. Not differentiable at a rotation by π.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameOrientation {
    /// The frame.
    pub frame: FrameId,
    /// Target of `R_WF`.
    pub target: Matrix3<f64>,
}

impl Residual for FrameOrientation {
    fixed_size!(3, Configuration);

    fn eval<T: Scalar>(&self, node: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        let R_WF = pose(node, x, self.frame).rotation;
        r.copy_from_slice(rotation_vector(&self.target, &R_WF).as_slice());
    }
}

/// Position (m, in the axes of the target), then rotation vector (rad) from the target to the frame, 6 entries.
#[derive(Clone, Debug, PartialEq)]
pub struct FramePose {
    /// The frame.
    pub frame: FrameId,
    /// Target of `X_WF`.
    pub target: Transform<f64>,
}

impl Residual for FramePose {
    fixed_size!(SPATIAL, Configuration);

    fn eval<T: Scalar>(&self, node: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        let X_WF = pose(node, x, self.frame);
        let mut away = X_WF.translation;
        for k in 0..3 {
            away[k] = away[k] - self.target.translation[k];
        }
        let p = rotate_back(&self.target.rotation, &away);
        let turn = rotation_vector(&self.target.rotation, &X_WF.rotation);
        r[..3].copy_from_slice(p.as_slice());
        r[3..].copy_from_slice(turn.as_slice());
    }
}

/// V − target: velocity error of a frame, `[linear; angular]`, m/s and rad/s, 6 entries.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameVelocity {
    /// The frame.
    pub frame: FrameId,
    /// Representation of the velocity.
    pub representation: Representation,
    /// Target velocity.
    pub target: [f64; SPATIAL],
}

impl Residual for FrameVelocity {
    fixed_size!(SPATIAL, State);

    fn eval<T: Scalar>(&self, node: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        let model = node.model();
        let (q, v) = (&x[..model.nq()], &x[model.nq()..][..model.nv()]);
        let V = frame_velocity(model, q, v, self.frame, self.representation);
        away_from(&self.target, &V.to_array(), r);
    }
}

/// Point or frame from which a distance is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstacle {
    /// A point of the world, m.
    Point(Vector3<f64>),
    /// The origin of another frame.
    Frame(FrameId),
}

/// Distance of the origin of a frame from a point, or from the origin of another frame, m, 1 entry. To keep clear of spheres, bound it from below.
/// Its derivative at distance zero is zero.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameDistance {
    /// The frame.
    pub frame: FrameId,
    /// Obstacle to keep away from.
    pub from: Obstacle,
}

impl Residual for FrameDistance {
    fixed_size!(1, Configuration);

    fn eval<T: Scalar>(&self, node: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
        let other = match self.from {
            Obstacle::Point(p) => p.map(T::constant),
            Obstacle::Frame(frame) => pose(node, x, frame).translation,
        };
        let away = pose(node, x, self.frame).translation - other;
        let squared = dot(&away, &away);
        // The root has no derivative at zero: the argument is guarded, then the result.
        let tiny = T::constant(f64::MIN_POSITIVE);
        let safe = squared.select_lt(tiny, T::one(), squared).sqrt();
        r[0] = squared.select_lt(tiny, T::zero(), safe);
    }
}

fn pose<T: Scalar>(node: &Node<'_, T>, x: &[T], frame: FrameId) -> Transform<T> {
    let model = node.model();
    frame_pose(model, &x[..model.nq()], frame)
}
