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
        for (i, body) in model.bodies().iter().enumerate() {
            self.X_PB[i] = body.place(q);
            self.I[i] = ArticulatedInertia::rigid(&body.inertia.lift());
        }
    }

    /// Inward: eliminates one joint after the other.
    pub(super) fn eliminate<P: Scalar>(&mut self, model: &Model<P>)
    where
        T: Over<P>,
    {
        for (i, body) in model.bodies().iter().enumerate().rev() {
            let mut U = [Force::zero(); MAX_NV];
            let U = &mut U[..body.joint.nv()];
            for (U, &axis) in U.iter_mut().zip(body.joint.axes()) {
                *U = self.I[i].column(axis);
            }
            self.divide(model, body, U);
            let Some(p) = body.parent else { continue };
            for (U, k) in U.iter().zip(v_range(body)) {
                self.I[i] = self.I[i].minus_outer(U, &self.W[k]);
            }
            self.I[p.0] = self.I[p.0] + self.I[i].moved(&self.X_PB[i]);
        }
    }

    /// D = Sᵀ U + armature,  W = U D⁻¹.
    #[inline]
    fn divide<P: Scalar>(&mut self, model: &Model<P>, body: &Body<P>, U: &[Force<T>])
    where
        T: Over<P>,
    {
        let axes = body.joint.axes();
        if let ([U], [axis]) = (U, axes) {
            let reciprocal = T::one() / (U.coordinate(*axis) + model.armature()[body.v]);
            self.W[body.v] = U.scaled(reciprocal);
            self.D_inverse[body.v][0] = reciprocal;
            return;
        }
        let mut D = [[T::zero(); MAX_NV]; MAX_NV];
        for (i, &axis) in axes.iter().enumerate() {
            D[i].iter_mut()
                .zip(U)
                .for_each(|(D, U)| *D = U.coordinate(axis));
            D[i][i] = D[i][i] + model.armature()[body.v + i];
        }
        let D_inverse = inverse(&D, axes.len());
        for (row, k) in v_range(body).enumerate() {
            let columns = U.iter().zip(&D_inverse[row]);
            self.W[k] = columns.fold(Force::zero(), |sum, (U, &d)| sum + U.scaled(d));
            self.D_inverse[k] = D_inverse[row];
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
