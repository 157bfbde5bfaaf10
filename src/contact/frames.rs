//! Frames at the contact points: poses, Jacobians and their rates, and the links in contact.
//!
//! The frame C of a point has its origin at the current position of the point, and the axes of its link. It is fixed to the body and does not move
//! with a rolling point: its Jacobian is that of the body material at the point.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DMatrix;

use super::contacts::Contacts;
use super::point_state::PointState;
use crate::dynamics::{Kinematics, to_world};
use crate::model::{BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::lift_matrix;
use crate::spatial::{Motion, Representation, SPATIAL, Transform};

impl<P: Scalar> Contacts<P> {
    /// Computes the pose `X_WC` of each point's frame, with the origin at the point and the axes of its link. Allocates.
    ///
    /// * `q` – configuration, length `nq`
    ///
    /// # Panics
    /// If `q` has the wrong length, or the contacts are those of another robot.
    pub fn frames<T: Over<P>>(&self, model: &Model<P>, q: &[T]) -> Vec<Transform<T>> {
        let (kinematics, points) = self.at_rest(model, q);
        let points = points.iter().enumerate();
        points
            .map(|(k, point)| self.frame(model, &kinematics, k, point))
            .collect()
    }

    /// Computes the Jacobian of each point's frame, 6 × `nv`, rows `[linear; angular]`. In the mixed representation the
    /// first three are that of [`jacobian`](Self::jacobian): the velocity of the body at the point, in the world's axes. Allocates.
    ///
    /// * `q` – configuration, length `nq`
    ///
    /// # Panics
    /// If `q` has the wrong length, or the contacts are those of another robot.
    pub fn frame_jacobians<T: Over<P>>(
        &self,
        model: &Model<P>,
        q: &[T],
        representation: Representation,
    ) -> Vec<DMatrix<T>> {
        let (kinematics, points) = self.at_rest(model, q);
        let mut out = matrices(model, points.len());
        for (k, (point, out)) in points.iter().zip(&mut out).enumerate() {
            let frame = self.attached(model, &kinematics, k, point);
            frame.jacobian_into(model, &kinematics, representation, out);
        }
        out
    }

    /// Computes the rate of the Jacobian of each point's frame, 6 × `nv`:  d(J v)/dt = J v̇ + J̇ v is the acceleration of the
    /// frame, which is fixed to its body. Allocates.
    ///
    /// * `q` – configuration, length `nq`
    /// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
    ///
    /// # Panics
    /// If a slice has the wrong length, or the contacts are those of another robot.
    pub fn frame_jacobian_derivatives<T: Over<P>>(
        &self,
        model: &Model<P>,
        q: &[T],
        v: &[T],
        representation: Representation,
    ) -> Vec<DMatrix<T>> {
        let (kinematics, points) = self.moving(model, q, v);
        let mut out = matrices(model, points.len());
        for (k, (point, out)) in points.iter().zip(&mut out).enumerate() {
            let frame = self.attached(model, &kinematics, k, point);
            frame.jacobian_derivative_into(model, &kinematics, representation, out);
        }
        out
    }

    fn attached<T: Over<P>>(
        &self,
        model: &Model<P>,
        kinematics: &Kinematics<T>,
        point: usize,
        state: &PointState<T>,
    ) -> AttachedFrame<T> {
        AttachedFrame {
            body: Some(self.points()[point].body),
            X_WC: self.frame(model, kinematics, point, state),
        }
    }

    /// The pose of a point's frame in the world.
    fn frame<T: Over<P>>(
        &self,
        model: &Model<P>,
        kinematics: &Kinematics<T>,
        point: usize,
        state: &PointState<T>,
    ) -> Transform<T> {
        let point = &self.points()[point];
        let R_WB = &kinematics.pose_of(point.body).rotation;
        let R_BL = lift_matrix::<P, T>(&model.frames()[point.link.0].placement.rotation);
        Transform::new(R_WB * R_BL, state.position)
    }

    fn at_rest<T: Over<P>>(
        &self,
        model: &Model<P>,
        q: &[T],
    ) -> (Kinematics<T>, Vec<PointState<T>>) {
        self.moving(model, q, &vec![T::zero(); model.nv()])
    }

    fn moving<T: Over<P>>(
        &self,
        model: &Model<P>,
        q: &[T],
        v: &[T],
    ) -> (Kinematics<T>, Vec<PointState<T>>) {
        self.check(model);
        let kinematics = crate::dynamics::forward_kinematics(model, q, v);
        let mut points = vec![PointState::zero(); self.points().len()];
        self.states_into(&kinematics, &mut points);
        (kinematics, points)
    }
}

impl Contacts<f64> {
    /// Returns for each link whether one of its points is below the ground, in the order of [`Model::links`]. Allocates.
    ///
    /// This is a geometric test; a [contact report](crate::sim::Simulator::contact_report) shows whether forces act.
    ///
    /// * `q` – configuration, length `nq`
    ///
    /// # Panics
    /// If `q` has the wrong length, or the contacts are those of another robot.
    pub fn links_in_contact(&self, model: &Model, q: &[f64]) -> Vec<bool> {
        let (_, points) = self.at_rest(model, q);
        let touches = |frame| {
            let mut own = self.points().iter().zip(&points);
            own.any(|(point, state)| point.link == frame && state.depth > 0.0)
        };
        let links = model.links().iter();
        links.map(|link| touches(link.frame)).collect()
    }
}

/// A frame C that is fixed to a body, or to the world.
pub(crate) struct AttachedFrame<T> {
    pub(crate) body: Option<BodyId>,
    pub(crate) X_WC: Transform<T>,
}

impl<T: Scalar> AttachedFrame<T> {
    /// Writes the Jacobian of the frame, 6 × `nv`.
    pub(crate) fn jacobian_into<P: Scalar>(
        &self,
        model: &Model<P>,
        kinematics: &Kinematics<T>,
        representation: Representation,
        out: &mut DMatrix<T>,
    ) where
        T: Over<P>,
    {
        let X_WC = &self.X_WC;
        let express =
            |V_W: &Motion<T>| representation.velocity_from_body(X_WC, &X_WC.motion_inverse(V_W));
        self.each_column(model, kinematics, out, |V_W, _| express(V_W));
    }

    /// Writes the rate of the Jacobian of the frame, 6 × `nv`.
    pub(crate) fn jacobian_derivative_into<P: Scalar>(
        &self,
        model: &Model<P>,
        kinematics: &Kinematics<T>,
        representation: Representation,
        out: &mut DMatrix<T>,
    ) where
        T: Over<P>,
    {
        let X_WC = &self.X_WC;
        let V_C = X_WC.motion_inverse(
            &kinematics
                .pose(self.body)
                .motion(&kinematics.velocity(self.body)),
        );
        // The axes E of expression move with V_E, a subspace S with its body B: it changes at the rate (V_B − V_E) × S.
        let V_E = V_C - representation.turning(&V_C);
        self.each_column(model, kinematics, out, |V_W, V_WB| {
            let (S, V_B) = (X_WC.motion_inverse(V_W), X_WC.motion_inverse(V_WB));
            representation.velocity_from_body(X_WC, &(V_B - V_E).cross(&S))
        });
    }

    /// Hands the motion of each coordinate's unit rate and the velocity of the body that it moves, both in the world, to
    /// `column`, and writes the result to the columns of `out`.
    fn each_column<P: Scalar>(
        &self,
        model: &Model<P>,
        kinematics: &Kinematics<T>,
        out: &mut DMatrix<T>,
        column: impl Fn(&Motion<T>, &Motion<T>) -> Motion<T>,
    ) where
        T: Over<P>,
    {
        assert_eq!(
            out.shape(),
            (SPATIAL, model.nv()),
            "the Jacobian of a point of \"{}\" is 6 × nv",
            model.name()
        );
        out.fill(T::zero());
        for (id, body) in to_world(model, self.body) {
            let X_WB = kinematics.pose_of(id);
            let V_WB = X_WB.motion(&kinematics.velocity(Some(id)));
            for (k, S) in body.columns() {
                let entries = column(&X_WB.motion(&S), &V_WB).to_array();
                for (row, x) in entries.into_iter().enumerate() {
                    out[(row, k)] += x;
                }
            }
        }
    }
}

fn matrices<P: Scalar, T: Scalar>(model: &Model<P>, count: usize) -> Vec<DMatrix<T>> {
    vec![DMatrix::zeros(SPATIAL, model.nv()); count]
}
