//! Where the points of contact are, how deep and how fast.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, Vector3};

use super::Contacts;
use super::point::velocity_at;
use super::rolling::{Foot, Moving, Rolling};
use crate::dynamics::{Kinematics, forward_kinematics_into, to_world};
use crate::model::{BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{cross, dot, rotate, rotate_back};
use crate::spatial::{Motion, Transform};

/// A point of contact in motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointState<T> {
    /// Where it is in the world, m.
    pub position: Vector3<T>,
    /// Velocity of the body there, in the world, m/s.
    pub velocity: Vector3<T>,
    /// Outward unit normal of the ground there, in the world.
    pub normal: Vector3<T>,
    /// Depth of the point below the ground, along the normal, m; negative above.
    pub depth: T,
    /// Where it is in its body, m.
    pub in_body: Vector3<T>,
}

impl<T: Scalar> PointState<T> {
    /// At the world's origin, at rest.
    pub fn zero() -> Self {
        Self {
            position: Vector3::zeros(),
            velocity: Vector3::zeros(),
            normal: Vector3::z(),
            depth: T::zero(),
            in_body: Vector3::zeros(),
        }
    }

    /// Two unit vectors across the normal that make a right-handed frame (t₁, t₂, n) with it, in the world.
    ///
    /// They turn smoothly with the normal as long as it points upwards [Duff et al. 2017].
    pub fn tangents(&self) -> [Vector3<T>; 2] {
        let n = &self.normal;
        let a = -(T::one() / (n.z + 1.0));
        let b = n.x * n.y * a;
        [
            Vector3::new(n.x * n.x * a + 1.0, b, -n.x),
            Vector3::new(b, n.y * n.y * a + 1.0, -n.y),
        ]
    }

    /// The axes in which laws see the point: normal, tangent, tangent, in the world.
    pub(crate) fn axes(&self) -> [Vector3<T>; 3] {
        let [t_1, t_2] = self.tangents();
        [self.normal, t_1, t_2]
    }

    /// The velocity of the body at the point, in the world, when it moves with `V_B` (in the body, whose axes are `R_WB`).
    #[inline(always)]
    pub(crate) fn velocity_of(&self, R_WB: &nalgebra::Matrix3<T>, V_B: &Motion<T>) -> Vector3<T> {
        rotate(R_WB, &velocity_at(V_B, &self.in_body))
    }
}

impl<P: Scalar> Contacts<P> {
    /// Computes where all points are, from the poses and velocities of the bodies; does not allocate.
    ///
    /// A point of a sphere or capsule is the nearest to the ground, and its depth is that along the normal there. On curved ground the nearest
    /// point is found by Newton's method from the point below the centre on, and from places a radius away along x and y if the slope has jumped
    /// on the way there; an outer edge is rolled over. There is one where the shape is curved more than the ground; where it is not, the
    /// point that is lowest along the normal below the centre is taken, with the ground right under it. In an inner edge it touches the
    /// side only in which it is deeper, so that the depth is continuous and the normal is not; steps in which a solver finds the forces take the
    /// side that is deeper at the end. What lies in a fold trembles between its sides instead of resting on both, at steps of 1 ms
    /// a ball of 0.1 m in a groove of slopes of ½ with 1 to 5 cm/s. What is higher above the ground than its radius counts as that
    /// high where the place is sought, not in the depth. The lowest point of the rim of a cylinder is as exact where the circle is steeper
    /// than 45° to the ground; where it lies flatter, the normal at its centre counts more and more. Capsules and cylinders touch with
    /// their ends, not with what is between: humps that are shorter than they are not felt. A corner sees the ground right above or below it.
    ///
    /// * `out` – output, one for each of [`points`](Self::points)
    ///
    /// # Panics
    /// If `out` has the wrong length, or the kinematics belong to another model.
    pub fn states_into<T: Over<P>>(&self, kinematics: &Kinematics<T>, out: &mut [PointState<T>]) {
        self.states_ahead_into(kinematics, 0.0, out);
    }

    /// As [`states_into`](Self::states_into), for contact that acts for a time from now on, s.
    pub(crate) fn states_ahead_into<T: Over<P>>(
        &self,
        kinematics: &Kinematics<T>,
        ahead: f64,
        out: &mut [PointState<T>],
    ) {
        assert_eq!(out.len(), self.points().len(), "a state for each point");
        for (i, out) in out.iter_mut().enumerate() {
            let body = self.points()[i].body;
            let moving = Moving {
                X_WB: kinematics.pose_of(body),
                V_B: &kinematics.velocity(Some(body)),
                ahead,
            };
            *out = self.state(i, &moving);
        }
    }

    /// Where one point of a body is.
    #[inline(always)]
    pub(crate) fn state<T: Over<P>>(&self, point: usize, body: &Moving<'_, T>) -> PointState<T> {
        let point = &self.points()[point];
        let Moving { X_WB, V_B, .. } = *body;
        let center = X_WB.point(&point.center.map(Into::into));
        let above = self.terrain().surface(&center.x, &center.y).normal();
        let curved = Some(above).filter(|_| self.terrain().is_curved());
        if let Some(rolling) = curved.and_then(|above| Rolling::new(point, body, above)) {
            return touching(rolling.foot(self.terrain()), X_WB, V_B);
        }
        let in_body = point.locate(&rotate_back(&X_WB.rotation, &above));
        let position = X_WB.point(&in_body);
        let ground = self.terrain().surface(&position.x, &position.y);
        let normal = ground.normal();
        PointState {
            position,
            velocity: rotate(&X_WB.rotation, &velocity_at(V_B, &in_body)),
            normal,
            depth: (ground.height - position.z) * normal.z,
            in_body,
        }
    }

    /// Where all points are at a configuration and velocity. Allocates.
    ///
    /// # Panics
    /// If a slice has the wrong length, or the contacts are those of another robot.
    pub fn states<T: Over<P>>(&self, model: &Model<P>, q: &[T], v: &[T]) -> Vec<PointState<T>> {
        self.check(model);
        let mut kinematics = Kinematics::new(model);
        forward_kinematics_into(model, q, v, &mut kinematics);
        let mut out = vec![PointState::zero(); self.points().len()];
        self.states_into(&kinematics, &mut out);
        out
    }

    /// Computes the Jacobian of the velocity of a point, 3 × `nv`, in the world's axes:  v = J q̇.
    ///
    /// That of the body at the point, which for a rolling point is not the rate of its position. Allocates.
    ///
    /// # Panics
    /// If the slice has the wrong length, there is no such point, or the contacts are those of another robot.
    pub fn jacobian<T: Over<P>>(&self, model: &Model<P>, q: &[T], point: usize) -> DMatrix<T> {
        let n = self.points().len();
        assert!(point < n, "there is no point {point} of contact, but {n}");
        let mut kinematics = Kinematics::new(model);
        let v = vec![T::zero(); model.nv()];
        forward_kinematics_into(model, q, &v, &mut kinematics);
        let state = self.states(model, q, &v)[point];
        let mut out = DMatrix::zeros(3, model.nv());
        let body = self.points()[point].body;
        each_column(
            model,
            &kinematics,
            (Some(body), &state.in_body),
            |k, column| {
                for (row, x) in column.iter().enumerate() {
                    out[(row, k)] += *x;
                }
            },
        );
        out
    }
}

/// A rolling point with its foot on the ground.
fn touching<T: Scalar>(foot: Foot<T>, X_WB: &Transform<T>, V_B: &Motion<T>) -> PointState<T> {
    let (position, normal) = (X_WB.point(&foot.in_body), foot.ground.normal());
    let y = Vector3::new(foot.at[0], foot.at[1], foot.ground.height);
    PointState {
        position,
        velocity: rotate(&X_WB.rotation, &velocity_at(V_B, &foot.in_body)),
        normal,
        depth: dot(&(y - position), &normal),
        in_body: foot.in_body,
    }
}

/// Hands the velocity that each coordinate's unit rate gives to a point of a body, in the world's axes, to `each(coordinate, v)`.
pub(crate) fn each_column<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
    (body, in_body): (Option<BodyId>, &Vector3<T>),
    mut each: impl FnMut(usize, Vector3<T>),
) {
    let p_W = kinematics.pose(body).point(in_body);
    for (id, own) in to_world(model, body) {
        let X_WB = kinematics.pose_of(id);
        let arm = p_W - X_WB.translation;
        for (k, axis) in own.axes() {
            // S is a unit vector of the body: what it moves is along a column of R, or turns about one.
            let along = X_WB.rotation.column(axis.coordinate() % 3).into_owned();
            let velocity = match (axis.is_angular(), axis.pitch()) {
                (false, _) => along,
                (true, 0.0) => cross(&along, &arm),
                (true, pitch) => cross(&along, &arm) + along * T::constant(pitch),
            };
            each(k, velocity.map(|x| own.scaled(x)));
        }
    }
}
