//! Poses and velocities of bodies and frames.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::passes::from_frame;
use crate::model::{BodyId, FrameId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Motion, Representation, Transform};

/// Poses and velocities of all bodies at one state; filled by [`forward_kinematics_into`].
#[derive(Clone, Debug)]
pub struct Kinematics<T> {
    pub(super) X_WB: Vec<Transform<T>>,
    pub(super) V_WB_B: Vec<Motion<T>>,
}

impl<T: Scalar> Kinematics<T> {
    /// Makes memory for a model, with all bodies at the origin and at rest.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        let n = model.n_bodies();
        Self {
            X_WB: vec![Transform::identity(); n],
            V_WB_B: vec![Motion::zero(); n],
        }
    }

    /// Pose `X_WB` of a body in the world; the world itself for `None`.
    ///
    /// # Panics
    /// If the id is not one of the model.
    pub fn pose(&self, body: Option<BodyId>) -> Transform<T> {
        body.map_or_else(Transform::identity, |body| *self.pose_of(body))
    }

    /// [`pose`](Self::pose) of a body, where it is kept.
    #[inline]
    pub(crate) fn pose_of(&self, body: BodyId) -> &Transform<T> {
        &self.X_WB[body.0]
    }

    /// Velocity of a body in its own frame; zero for the world.
    ///
    /// # Panics
    /// If the id is not one of the model.
    pub fn velocity(&self, body: Option<BodyId>) -> Motion<T> {
        match body {
            Some(body) => self.V_WB_B[body.0],
            None => Motion::zero(),
        }
    }

    /// Takes over motions that are known: the pose of each body in its parent, and its velocity in its own frame.
    pub(crate) fn place<P: Scalar>(
        &mut self,
        model: &Model<P>,
        X_PB: &[Transform<T>],
        V: &[Motion<T>],
    ) {
        T::vectorized(
            #[inline(always)]
            || {
                for (i, (body, X)) in model.bodies().iter().zip(X_PB).enumerate() {
                    self.X_WB[i] = match body.parent {
                        Some(p) => self.X_WB[p.0] * *X,
                        None => *X,
                    };
                }
            },
        );
        self.V_WB_B.copy_from_slice(V);
    }

    /// [`place`](Self::place) for some bodies, ascending, each with all of its ancestors.
    pub(crate) fn place_some<P: Scalar>(
        &mut self,
        model: &Model<P>,
        bodies: &[usize],
        (X_PB, V): (&[Transform<T>], &[Motion<T>]),
    ) {
        for &i in bodies {
            let parent = model.bodies()[i].parent;
            self.X_WB[i] = parent.map_or(X_PB[i], |p| self.X_WB[p.0] * X_PB[i]);
            self.V_WB_B[i] = V[i];
        }
    }

    pub(crate) fn check<P: Scalar>(&self, model: &Model<P>) {
        assert_eq!(
            self.X_WB.len(),
            model.n_bodies(),
            "the kinematics belong to another model than \"{}\"",
            model.name()
        );
    }
}

/// Computes poses and velocities of all bodies:  `X_WB = X_WP X_PB(q)`,  `V_B = X_BP V_P + S v`.
///
/// Allocates its result.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length.
pub fn forward_kinematics<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
) -> Kinematics<T> {
    let mut out = Kinematics::new(model);
    forward_kinematics_into(model, q, v, &mut out);
    out
}

/// [`forward_kinematics`] without allocation.
///
/// # Panics
/// If an argument has the wrong size for the model.
pub fn forward_kinematics_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    out: &mut Kinematics<T>,
) {
    model.check_q(q);
    model.check_v(v);
    out.check(model);
    for (i, body) in model.bodies().iter().enumerate() {
        let X_PB = body.place(q);
        let (X_WP, V_P) = (out.pose(body.parent), out.velocity(body.parent));
        out.X_WB[i] = X_WP * X_PB;
        out.V_WB_B[i] = X_PB.motion_inverse(&V_P);
        body.add_motion(v, &mut out.V_WB_B[i]);
    }
}

/// Computes the pose `X_WF` of a frame in the world. O(depth of the frame), does not allocate.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length, or the id is not one of the model.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::frame_pose, model::samples};
///
/// let model = samples::arm();
/// let tool = model.frame("tool").unwrap();
/// let pose = frame_pose(&model, &[0.0; 7], tool);
/// assert!((pose.translation.z - 1.3).abs() < 1e-12);
/// ```
pub fn frame_pose<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    frame: FrameId,
) -> Transform<T> {
    model.check_q(q);
    from_frame(model, q, frame, |_, _| {})
}

/// [`frame_pose`] from known poses of the bodies.
///
/// # Panics
/// If the id is not one of the model.
pub fn frame_pose_at<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
    frame: FrameId,
) -> Transform<T> {
    let frame = model.frame_of(frame);
    frame.placement.after(&kinematics.pose(frame.body))
}

/// Computes the velocity of a frame in the world, in a chosen representation. O(depth of the frame), does not allocate.
///
/// Equals the frame Jacobian in that representation times `v`.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length, or the id is not one of the model.
pub fn frame_velocity<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    frame: FrameId,
    representation: Representation,
) -> Motion<T> {
    model.check_q(q);
    model.check_v(v);
    let mut V_F = Motion::zero();
    let X_WF = from_frame(model, q, frame, |body, X_BF| {
        V_F += X_BF.motion_inverse(&body.motion(v));
    });
    representation.velocity_from_body(&X_WF, &V_F)
}
