//! Positions, depths and velocities of the contact points.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, Vector3};

use super::contacts::Contacts;
use super::point::velocity_at;
use super::point_state::PointState;
use super::rolling::{BodyMotion, Foot, Rolling};
use crate::dynamics::{Kinematics, forward_kinematics_into, to_world};
use crate::model::{BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{cross, dot, rotate, rotate_back};
use crate::spatial::{Motion, Transform};

impl<P: Scalar> Contacts<P> {
    /// Computes the states of all points from the poses and velocities of the bodies. Does not allocate.
    ///
    /// The point of a sphere or capsule is the one nearest to the ground; its depth is measured along the normal there. On curved ground Newton's
    /// method finds it, starting below the centre, and also from positions one radius away along x and y if the slope jumps in between; shapes roll
    /// over outer edges. A unique nearest point exists if the shape is curved more than the ground. Otherwise the point is the lowest one along the
    /// normal below the centre, with the ground directly below it. In an inner edge the shape touches only the side in which it is deeper: the depth
    /// is continuous, the normal is not. Steps with a force solver take the side that is deeper at the end of the step. So a body in a groove
    /// trembles between both sides instead of resting on them: a ball of 0.1 m in a groove with slopes of ½ moves with 1 to 5 cm/s at steps of 1 ms.
    /// For a shape that is higher than its radius above the ground, the search assumes that height; the depth does not. The lowest point of a
    /// cylinder's rim is equally exact if its circle is steeper than 45° to the ground; for flatter circles the normal at its centre gets more and
    /// more weight. Capsules and cylinders touch with their ends only: they do not feel humps between the ends. A corner uses the ground directly
    /// above or below it.
    ///
    /// * `out` – output, one for each of [`points`](Self::points)
    ///
    /// # Panics
    /// If `out` has the wrong length, or the kinematics belong to another model.
    pub fn states_into<T: Over<P>>(&self, kinematics: &Kinematics<T>, out: &mut [PointState<T>]) {
        self.states_over_step_into(kinematics, T::zero(), out);
    }

    /// As [`states_into`](Self::states_into), for contact that acts for a `duration` from now on, s.
    pub(crate) fn states_over_step_into<T: Over<P>>(
        &self,
        kinematics: &Kinematics<T>,
        duration: T,
        out: &mut [PointState<T>],
    ) {
        assert_eq!(out.len(), self.points().len(), "a state for each point");
        for (i, out) in out.iter_mut().enumerate() {
            let body = self.points()[i].body;
            let moving = BodyMotion {
                X_WB: kinematics.pose_of(body),
                V_B: &kinematics.velocity(Some(body)),
                duration,
            };
            *out = self.state(i, &moving);
        }
    }

    /// Contact kinematics of one point of a body; the depth from its margin on.
    #[inline(always)]
    pub(crate) fn state<T: Over<P>>(
        &self,
        point: usize,
        body: &BodyMotion<'_, T>,
    ) -> PointState<T> {
        let mut state = self.state_on_ground(point, body);
        if let Some(margin) = self.point_laws().margin(point) {
            state.depth += T::from(margin);
        }
        state
    }

    /// [`state`](Self::state) with the depth in the ground itself.
    #[inline(always)]
    fn state_on_ground<T: Over<P>>(&self, point: usize, body: &BodyMotion<'_, T>) -> PointState<T> {
        let point = &self.points()[point];
        let BodyMotion { X_WB, V_B, .. } = *body;
        let center = X_WB.point(&point.center.map(Into::into));
        let above = self.terrain().surface(&center.x, &center.y).normal();
        let curved = Some(above).filter(|_| self.terrain().is_curved());
        if let Some(rolling) = curved.and_then(|above| Rolling::new(point, body, above)) {
            return rolling_state(rolling.foot(self.terrain()), X_WB, V_B);
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

    /// Computes the states of all points at a configuration and velocity. Allocates.
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
    /// This is the velocity of the body at the point; for a rolling point it is not the rate of the point's position. Allocates.
    ///
    /// # Panics
    /// If the slice has the wrong length, there is no such point, or the contacts belong to another robot.
    pub fn jacobian<T: Over<P>>(&self, model: &Model<P>, q: &[T], point: usize) -> DMatrix<T> {
        let n = self.points().len();
        assert!(
            point < n,
            "there is no contact point {point}: there are {n}"
        );
        let mut kinematics = Kinematics::new(model);
        let v = vec![T::zero(); model.nv()];
        forward_kinematics_into(model, q, &v, &mut kinematics);
        let state = self.states(model, q, &v)[point];
        let mut out = DMatrix::zeros(3, model.nv());
        let body = self.points()[point].body;
        let point = BodyPoint {
            body: Some(body),
            in_body: &state.in_body,
        };
        each_jacobian_column(model, &kinematics, point, |k, column| {
            for (row, x) in column.iter().enumerate() {
                out[(row, k)] += *x;
            }
        });
        out
    }
}

/// State of a rolling point with its foot on the ground.
fn rolling_state<T: Scalar>(foot: Foot<T>, X_WB: &Transform<T>, V_B: &Motion<T>) -> PointState<T> {
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

/// A point fixed to a body, or to the world.
#[derive(Clone, Copy)]
pub(crate) struct BodyPoint<'a, T> {
    pub(crate) body: Option<BodyId>,
    /// Position in the body, m.
    pub(crate) in_body: &'a Vector3<T>,
}

/// Passes the velocity that each coordinate's unit rate gives to a point of a body, in the world's axes, to `each(coordinate, v)`.
#[inline(always)]
pub(crate) fn each_jacobian_column<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
    point: BodyPoint<'_, T>,
    mut each: impl FnMut(usize, Vector3<T>),
) {
    let p_W = kinematics.pose(point.body).point(point.in_body);
    for (id, own) in to_world(model, point.body) {
        let X_WB = kinematics.pose_of(id);
        let arm = p_W - X_WB.translation;
        for (k, axis) in own.axes() {
            // S is a unit vector of the body: what it moves is along a column of R, or turns about one.
            let (R, i) = (&X_WB.rotation, axis.coordinate() % 3);
            let along = Vector3::new(R[(0, i)], R[(1, i)], R[(2, i)]);
            let velocity = match (axis.is_angular(), axis.pitch()) {
                (false, _) => along,
                (true, 0.0) => cross(&along, &arm),
                (true, pitch) => cross(&along, &arm) + along * T::constant(pitch),
            };
            each(k, velocity.map(|x| own.scaled(x)));
        }
    }
}

/// Passes the angular velocity that each coordinate's unit rate gives to a body, in the world's axes, to `each(coordinate, ω)`.
pub(crate) fn each_turning_column<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
    body: Option<BodyId>,
    mut each: impl FnMut(usize, Vector3<T>),
) {
    for (id, own) in to_world(model, body) {
        let R = &kinematics.pose_of(id).rotation;
        for (k, axis) in own.axes() {
            let i = axis.coordinate() % 3;
            let is_angular = if axis.is_angular() { 1.0 } else { 0.0 };
            let along = Vector3::new(R[(0, i)], R[(1, i)], R[(2, i)]);
            each(k, along.map(|x| own.scaled(x) * is_angular));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ContactLaw, Rigid, Terrain};

    fn contacts(robot: &str, terrain: Terrain) -> (Model, Contacts) {
        let path = format!("{}/assets/{robot}.urdf", env!("CARGO_MANIFEST_DIR"));
        let model = Model::from_urdf_file(&path).expect("an asset");
        let contacts = Contacts::new(&model, terrain, ContactLaw::Rigid(Rigid::default()));
        (model, contacts)
    }

    // A ball of 0.1 m above a slope of 30°: its nearest point is a radius along −n from its centre, n = (−½, 0, √¾).
    #[test]
    fn nearest_point_of_a_ball_over_a_slope_is_along_its_normal() {
        let (model, contacts) = contacts("sphere", Terrain::incline(30.0_f64.to_radians()));
        let q = [1.0, -2.0, 0.8, 1.0, 0.0, 0.0, 0.0];
        let (v, w) = (Vector3::new(0.3, -0.1, 0.2), Vector3::new(1.0, 2.0, -3.0));
        let rates = [v.x, v.y, v.z, w.x, w.y, w.z];
        let found = contacts.states(&model, &q, &rates)[0];
        let normal = Vector3::new(-0.5, 0.0, 0.75_f64.sqrt());
        let center = Vector3::new(1.0, -2.0, 0.8);
        assert!((found.normal - normal).norm() < 1e-15);
        assert!((found.position - (center - normal * 0.1)).norm() < 1e-15);
        assert!((found.depth - (0.1 - normal.dot(&center))).abs() < 1e-15);
        let velocity = v + w.cross(&(normal * -0.1));
        assert!((found.velocity - velocity).norm() < 1e-15);
    }

    #[test]
    fn velocity_of_each_corner_equals_its_jacobian_times_the_velocity() {
        let (model, contacts) = contacts("box", Terrain::incline(0.2));
        let q = [0.1, 0.2, 0.3, 0.5, 0.5, -0.5, 0.5];
        let v = [0.3, -0.1, 0.2, 1.0, 2.0, -3.0];
        for (i, state) in contacts.states(&model, &q, &v).iter().enumerate() {
            let by_jacobian =
                contacts.jacobian(&model, &q, i) * nalgebra::DVector::from(v.to_vec());
            assert!((by_jacobian - state.velocity).norm() < 1e-15, "{i}");
        }
    }

    #[test]
    fn axes_of_a_point_are_right_handed_and_orthonormal() {
        for slope in [[0.0, 0.0], [0.7, -0.2], [-3.0, 5.0]] {
            let normal = Vector3::new(-slope[0], -slope[1], 1.0_f64).normalize();
            let point = PointState {
                normal,
                ..PointState::zero()
            };
            let [n, t_1, t_2] = point.axes();
            assert!((t_1.cross(&t_2) - n).norm() < 1e-15, "{slope:?}");
            assert!((t_1.norm() - 1.0).abs() < 1e-15 && t_1.dot(&n).abs() < 1e-15);
        }
    }
}
