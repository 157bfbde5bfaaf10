//! Anchors: attachment frames of constraints and forces.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::fmt::Display;

use nalgebra::{DMatrix, Matrix3, Vector3};

use crate::dynamics::{frame_bias_acceleration, frame_jacobian_into, frame_pose, frame_velocity};
use crate::error::UnknownName;
use crate::model::{BodyId, FrameId, Model, Structure};
use crate::numbers::{Domain, Each, Number, numbers};
use crate::scalar::{MapEach, Over, Scalar, from_each};
use crate::spatial::linear::{cross, lift_vector, rotate, rotate_back};
use crate::spatial::{Force, Motion, Quaternion, Representation, Transform, rotation_vector};

/// An attachment frame: a frame on a robot or in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor<P = f64> {
    /// The frame that carries it; `None` is the world.
    pub frame: Option<FrameId>,
    /// Pose of the anchor in that frame.
    pub placement: Transform<P>,
    /// Structure of the robot whose frame it was looked up in, if it was.
    structure: Option<Structure>,
}

numbers! { pub struct Anchor { frame: kept(), placement: part(Transform), structure: kept() } }

/// Names of the axes of an attachment frame.
const AXES: [&str; 3] = ["x", "y", "z"];

/// A parameter of an attachment frame.
fn number(name: &dyn Display) -> Number<'_> {
    Number::new(name, &"pose of an attachment frame", Domain::Finite)
}

impl<P> Anchor<P> {
    /// Makes an attachment frame in a frame of a robot, or in the world.
    ///
    /// It carries no model identity: a constraint or a force uses the frame of this index. [`frame`](Anchor::frame) makes an attachment frame that
    /// other robots refuse.
    ///
    /// * `frame` – the frame that carries it; `None` is the world
    /// * `placement` – its pose in that frame
    pub fn new(frame: Option<FrameId>, placement: Transform<P>) -> Self {
        Self {
            frame,
            placement,
            structure: None,
        }
    }
}

impl Anchor<f64> {
    /// Makes an anchor at the origin of the world, with its axes.
    pub fn world() -> Self {
        Self::new(None, Transform::identity())
    }

    /// Makes an attachment frame at a frame or link of a robot. Its constraints and forces belong to that robot and to variants of equal structure;
    /// other robots refuse them.
    ///
    /// # Errors
    /// If the model has no frame of that name.
    pub fn frame(model: &Model, name: &str) -> Result<Self, UnknownName> {
        Ok(Self {
            frame: Some(model.find_frame(name)?),
            structure: Some(model.structure()),
            ..Self::world()
        })
    }

    /// Returns the attachment frame moved along its own axes (m).
    #[must_use]
    pub fn moved(mut self, by: [f64; 3]) -> Self {
        self.placement = self.placement * Transform::from_translation(by.into());
        self
    }

    /// Returns the attachment frame moved to the pose of another one at a configuration `q` (length `nq`), so that a weld of both keeps their
    /// relative pose at `q`.
    ///
    /// # Panics
    /// If `q` has the wrong length.
    #[must_use]
    pub fn brought_to(self, other: &Self, model: &Model, q: &[f64]) -> Self {
        let pose = self.pose_in_world(model, q).inverse() * other.pose_in_world(model, q);
        let placement = self.placement * pose;
        Self { placement, ..self }
    }
}

/// Place of an anchor on a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mounted<P> {
    /// `None` is the world.
    pub(crate) body: Option<BodyId>,
    /// Pose in the body.
    pub(crate) X_BA: Transform<P>,
}

/// An anchor in motion, in mixed representation: point velocities and world axes.
pub(super) struct AnchorMotion<T> {
    pub(super) X: Transform<T>,
    pub(super) V: Motion<T>,
    /// Acceleration while v̇ = 0.
    pub(super) A: Motion<T>,
    /// Vector from the origin of its frame or body to the attachment frame, in the world.
    arm: Vector3<T>,
}

/// Motion of the frame or body of an attachment frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carrier<T> {
    /// Pose in the world.
    pub(crate) X: Transform<T>,
    /// Velocity, in itself.
    pub(crate) V: Motion<T>,
    /// Spatial acceleration, in itself.
    pub(crate) A: Motion<T>,
}

impl<T: Scalar> AnchorMotion<T> {
    /// Motion of an attachment frame from that of its frame or body.
    ///
    /// * `placement` – pose of the anchor on its carrier
    pub(super) fn on<P: Scalar>(placement: &Transform<P>, carrier: &Carrier<T>) -> Self
    where
        T: Over<P>,
    {
        let Carrier { X, V, A } = carrier;
        let r = lift_vector::<P, T>(&placement.translation);
        let [velocity, mut acceleration] = [V, A].map_each(|M| shifted(M, &r));
        // That of the point, from that of the body as it passes there.
        acceleration.linear += cross(&V.angular, &velocity.linear);
        Self {
            X: placement.after(X),
            V: rotated(&X.rotation, &velocity),
            A: rotated(&X.rotation, &acceleration),
            arm: rotate(&X.rotation, &r),
        }
    }

    /// A force on the anchor, in mixed representation, as one on its carrier, in that.
    pub(super) fn force_on(&self, X: &Transform<T>, F: &Force<T>) -> Force<T> {
        let angular = F.angular + cross(&self.arm, &F.linear);
        let [linear, angular] = [F.linear, angular].map_each(|f| rotate_back(&X.rotation, &f));
        Force::new(linear, angular)
    }

    /// Velocity of the anchor while its carrier moves with `V`, seen from itself.
    pub(super) fn velocity_under(&self, X: &Transform<T>, V: &Motion<T>) -> Motion<T> {
        shifted(&rotated(&X.rotation, V), &self.arm)
    }

    /// Motion of an anchor on the world.
    pub(super) fn at_rest(X: Transform<T>) -> Self {
        Self {
            X,
            V: Motion::zero(),
            A: Motion::zero(),
            arm: Vector3::zeros(),
        }
    }
}

impl<P: Scalar> Anchor<P> {
    /// Passes each coordinate of its origin in its frame to `each`, with a name that begins with its own.
    pub(crate) fn each_position(&mut self, name: &str, each: &mut Each<'_, P>) {
        for (axis, x) in AXES.iter().zip(&mut self.placement.translation) {
            each(number(&format_args!("{name}{axis}")), x);
        }
    }

    /// Passes each component of a rotation about its own axes, initially zero, to `each`, and applies it.
    pub(crate) fn each_turn(&mut self, name: &str, each: &mut Each<'_, P>) {
        let mut turn = Vector3::zeros();
        for (axis, x) in AXES.iter().zip(&mut turn) {
            each(number(&format_args!("{name}turn {axis}")), x);
        }
        let own = Transform::new(Quaternion::exp(&turn).to_matrix(), Vector3::zeros());
        self.placement = self.placement * own;
    }

    /// # Panics
    /// If it belongs to a robot of another structure, or its frame is not one of this robot's.
    pub(super) fn check(&self, model: &Model<P>) {
        if let Some(structure) = self.structure {
            structure.check(model, "the anchors of a constraint");
        }
        if let Some(frame) = self.frame {
            model.frame_of(frame);
        }
    }

    /// Whether it was looked up in a robot of this structure, as far as it knows.
    pub(crate) fn is_of(&self, model: &Model<P>) -> bool {
        let own = model.structure();
        self.structure.is_none_or(|structure| structure == own)
    }

    /// Finds its pose on its body.
    pub(crate) fn mounted(&self, model: &Model<P>) -> Mounted<P> {
        let frame = self.frame.map(|frame| model.frame_of(frame));
        Mounted {
            body: frame.and_then(|frame| frame.body),
            X_BA: frame.map_or(self.placement, |frame| frame.placement * self.placement),
        }
    }

    /// Computes the pose of the attachment frame in the world at a configuration `q` (length `nq`).
    ///
    /// # Panics
    /// If the slice has the wrong length.
    pub fn pose_in_world<T: Over<P>>(&self, model: &Model<P>, q: &[T]) -> Transform<T> {
        let X_WF = self.frame.map(|frame| frame_pose(model, q, frame));
        self.placement
            .after(&X_WF.unwrap_or_else(Transform::identity))
    }

    /// Computes the motion of the anchor at (q, v), slices of length `nq` and `nv`.
    pub(super) fn motion<T: Over<P>>(&self, model: &Model<P>, q: &[T], v: &[T]) -> AnchorMotion<T> {
        let Some(frame) = self.frame else {
            return AnchorMotion::at_rest(self.placement.lift());
        };
        let carrier = Carrier {
            X: frame_pose(model, q, frame),
            V: frame_velocity(model, q, v, frame, Representation::Body),
            A: frame_bias_acceleration(model, q, v, frame, Representation::Body),
        };
        AnchorMotion::on(&self.placement, &carrier)
    }

    /// Adds the Jacobian of the anchor in mixed representation, times a sign, to `out` (6 × `nv`).
    ///
    /// * `at` – motion of the anchor at `q`
    /// * `own` – working memory, 6 × `nv`
    pub(super) fn add_jacobian<T: Over<P>>(
        &self,
        model: &Model<P>,
        q: &[T],
        at: &AnchorMotion<T>,
        sign: f64,
        own: &mut DMatrix<T>,
        out: &mut DMatrix<T>,
    ) {
        let Some(frame) = self.frame else {
            return;
        };
        frame_jacobian_into(model, q, frame, Representation::Mixed, own);
        for (column, mut out) in own.column_iter().zip(out.column_iter_mut()) {
            let V = Motion::from_array(from_each(|k| column[k]));
            let moved = shifted(&V, &at.arm).to_array();
            out.iter_mut()
                .zip(moved)
                .for_each(|(out, x)| *out += x * sign);
        }
    }
}

/// A motion along other axes.
fn rotated<T: Scalar>(R: &Matrix3<T>, V: &Motion<T>) -> Motion<T> {
    Motion::new(rotate(R, &V.linear), rotate(R, &V.angular))
}

/// Moves the reference point of a motion along an arm: ṗ + ω × r.
fn shifted<T: Scalar>(V: &Motion<T>, arm: &Vector3<T>) -> Motion<T> {
    Motion::new(V.linear + cross(&V.angular, arm), V.angular)
}

/// Computes the rotation vector from one anchor to another, in the world's axes.
pub(super) fn turn_between<T: Scalar>(from: &Transform<T>, to: &Transform<T>) -> Vector3<T> {
    let turn = rotation_vector(&from.rotation, &to.rotation);
    rotate(&from.rotation, &turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::samples;
    use crate::spatial::Quaternion;
    use crate::tests::{ROUNDING, SAME_ALGEBRA};
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    // The pivot turns about x:  p = (0, sin q, −cos q),  ṗ = q̇ (0, cos q, sin q),  p̈ = q̇² (0, −sin q, cos q)  while
    // q̈ = 0.
    #[test]
    fn motion_of_the_tip_of_a_pendulum_equals_the_closed_form() {
        let model = samples::pendulum();
        let tip = Anchor::frame(&model, "rod").unwrap();
        let (q, v) = (0.7_f64, 1.3);
        let (sin, cos) = q.sin_cos();
        let at = tip.moved([0.0, 0.0, -1.0]).motion(&model, &[q], &[v]);
        let same = |a: &Vector3<f64>, b: [f64; 3]| (a - Vector3::from(b)).amax() < ROUNDING;
        assert!(same(&at.X.translation, [0.0, sin, -cos]));
        assert!(same(&at.V.linear, [0.0, v * cos, v * sin]));
        assert!(same(&at.V.angular, [v, 0.0, 0.0]));
        assert!(same(&at.A.linear, [0.0, -v * v * sin, v * v * cos]));
        assert!(same(&at.A.angular, [0.0; 3]));
    }

    #[test]
    fn jacobian_columns_equal_the_velocities_of_unit_rates() {
        for seed in 0..8 {
            let model = samples::random_tree(7, seed);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let (q, nv) = (model.random_configuration(&mut rng), model.nv());
            let anchor = Anchor::frame(&model, "link6").unwrap();
            let anchor = anchor.moved([0.3, -0.2, 0.5]);
            let (mut own, mut out) = (DMatrix::zeros(6, nv), DMatrix::zeros(6, nv));
            let still = anchor.motion(&model, q.as_slice(), &vec![0.0; nv]);
            anchor.add_jacobian(&model, q.as_slice(), &still, -1.0, &mut own, &mut out);
            for k in 0..nv {
                let mut unit = vec![0.0; nv];
                unit[k] = 1.0;
                let V = anchor.motion(&model, q.as_slice(), &unit).V.to_array();
                for (row, V) in V.into_iter().enumerate() {
                    let error = (out[(row, k)] + V).abs();
                    assert!(error < SAME_ALGEBRA, "tree {seed}, ({row}, {k}): {error:e}");
                }
            }
        }
    }

    #[test]
    fn anchor_that_is_brought_to_another_has_its_pose() {
        let model = samples::random_tree(6, 4);
        let q = model.random_configuration(&mut Xoshiro256PlusPlus::seed_from_u64(4));
        let [a, b] = ["link2", "link5"].map(|link| Anchor::frame(&model, link).unwrap());
        let b = b.moved([0.1, 0.2, 0.3]);
        let pose = |anchor: Anchor| anchor.pose_in_world(&model, q.as_slice()).to_entries();
        let brought = a.brought_to(&b, &model, q.as_slice());
        assert_eq!(brought.frame, a.frame);
        for (x, y) in pose(brought).into_iter().zip(pose(b)) {
            assert!((x - y).abs() < SAME_ALGEBRA, "{x} {y}");
        }
    }

    // R₁ = exp(θ) R₀ with θ in the world's axes.
    #[test]
    fn turn_between_two_anchors_equals_the_rotation_vector_in_the_world() {
        let start = Quaternion::exp(&Vector3::new(0.4, -1.1, 0.3)).to_matrix();
        for turn in [[0.0; 3], [0.0, 0.3, 0.0], [-0.5, 1.0, 2.0]].map(Vector3::from) {
            let end = Quaternion::exp(&turn).to_matrix() * start;
            let [from, to] = [start, end].map(|r| Transform::new(r, Vector3::zeros()));
            let error = (turn_between(&from, &to) - turn).amax();
            assert!(error < SAME_ALGEBRA, "{turn}: {error:e}");
        }
    }
}
