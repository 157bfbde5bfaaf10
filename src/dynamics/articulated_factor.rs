//! Articulated inertias: the part of the articulated-body algorithm that depends on the configuration alone.
//!
//! Going from the tips to the world, each joint is eliminated from the inertia that its parent feels. What is kept of every joint
//! is a factorisation of the mass matrix in O(n), which then serves any right-hand side.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::small_matrix::inverse;
use crate::joint::MAX_NV;
use crate::model::manifold::v_range;
use crate::model::{Body, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{ArticulatedInertia, Force, Inertia, Transform};

/// The factors, per body and per degree of freedom.
#[derive(Clone, Debug)]
pub(super) struct ArticulatedFactor<T> {
    sin_cos: Vec<(T, T)>,
    /// Joint transforms.
    pub(super) X_PB: Vec<Transform<T>>,
    /// What is felt of each body through its joint:  `I_a` = I − U D⁻¹ Uᵀ.
    pub(super) I: Vec<ArticulatedInertia<T>>,
    /// Per degree of freedom: the column of W = U D⁻¹ with U = I S.
    pub(super) W: Vec<Force<T>>,
    /// Per degree of freedom: the row of D⁻¹ with D = Sᵀ I S.
    D_inverse: Vec<[T; MAX_NV]>,
}

impl<T: Scalar> ArticulatedFactor<T> {
    pub(super) fn new<P: Scalar>(model: &Model<P>) -> Self {
        let (n, nv) = (model.n_bodies(), model.nv());
        Self {
            sin_cos: vec![(T::zero(), T::one()); model.nq()],
            X_PB: vec![Transform::identity(); n],
            I: vec![ArticulatedInertia::rigid(&Inertia::zero()); n],
            W: vec![Force::zero(); nv],
            D_inverse: vec![[T::zero(); MAX_NV]; nv],
        }
    }

    /// Outward: joint transforms, and each articulated body starts as its own rigid body.
    pub(super) fn place<P: Scalar>(&mut self, model: &Model<P>, q: &[T])
    where
        T: Over<P>,
    {
        T::sin_cos_each(q, &mut self.sin_cos);
        for (i, body) in model.bodies().iter().enumerate() {
            self.X_PB[i] = body.place_turned(q, &self.sin_cos);
            self.I[i] = ArticulatedInertia::rigid(&body.inertia.lift());
        }
    }

    /// Inward: eliminates one joint after the other.
    pub(super) fn eliminate<P: Scalar>(&mut self, model: &Model<P>)
    where
        T: Over<P>,
    {
        for (i, body) in model.bodies().iter().enumerate().rev() {
            match *body.joint.axes() {
                [] => {}
                [5] => self.eliminate_one::<P, 5>(model, i),
                [2] => self.eliminate_one::<P, 2>(model, i),
                _ => self.eliminate_all(model, i),
            }
            if let Some(p) = body.parent {
                self.I[p.0] = self.I[p.0] + self.I[i].moved(&self.X_PB[i]);
            }
        }
    }

    /// A joint with one axis:  D = Sᵀ U + armature,  W = U D⁻¹,  `I_a` = I − U Wᵀ.
    #[inline(always)]
    fn eliminate_one<P: Scalar, const AXIS: usize>(&mut self, model: &Model<P>, i: usize)
    where
        T: Over<P>,
    {
        let v = model.bodies()[i].v;
        let U = self.I[i].column(AXIS);
        let reciprocal = T::one() / (U.coordinate(AXIS) + model.armature()[v]);
        let W = U.scaled(reciprocal);
        self.I[i] = self.I[i].minus_outer(&U, &W);
        self.W[v] = W;
        self.D_inverse[v][0] = reciprocal;
    }

    /// A joint with several axes, all at once; D is a matrix.
    #[inline(never)]
    fn eliminate_all<P: Scalar>(&mut self, model: &Model<P>, i: usize)
    where
        T: Over<P>,
    {
        let body = &model.bodies()[i];
        let axes = body.joint.axes();
        let mut U = [Force::zero(); MAX_NV];
        let U = &mut U[..axes.len()];
        for (U, &axis) in U.iter_mut().zip(axes) {
            *U = self.I[i].column(axis);
        }
        let mut D = [[T::zero(); MAX_NV]; MAX_NV];
        for (i, &axis) in axes.iter().enumerate() {
            D[i].iter_mut()
                .zip(&*U)
                .for_each(|(D, U)| *D = U.coordinate(axis));
            D[i][i] = D[i][i] + model.armature()[body.v + i];
        }
        let D_inverse = inverse(&D, axes.len());
        for (row, k) in v_range(body).enumerate() {
            let columns = U.iter().zip(&D_inverse[row]);
            self.W[k] = columns.fold(Force::zero(), |sum, (U, &d)| sum + U.scaled(d));
            self.D_inverse[k] = D_inverse[row];
        }
        for (U, k) in U.iter().zip(v_range(body)) {
            self.I[i] = self.I[i].minus_outer(U, &self.W[k]);
        }
    }

    /// D⁻¹ u, the acceleration of a joint whose parent stands still.
    #[inline]
    pub(super) fn free_acceleration<P>(&self, body: &Body<P>, u: &[T], out: &mut [T]) {
        let u = &u[v_range(body)];
        for k in v_range(body) {
            let row = u.iter().zip(&self.D_inverse[k]);
            out[k] = row.fold(T::zero(), |sum, (&u, &d)| sum + d * u);
        }
    }
}
