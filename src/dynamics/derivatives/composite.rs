//! A body with what it carries.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use crate::dynamics::rnea::Accelerated;
use crate::model::Body;
use crate::scalar::{Differentiable, Over, Scalar};
use crate::spatial::{
    Force, Inertia, Motion, Transform, UnitVelocityProducts, VelocityProductMatrix,
};

/// A body with what it carries.
#[derive(Clone, Copy, Debug)]
pub(super) struct Composite<T> {
    pub(super) X_PB: Transform<T>,
    pub(super) V: Motion<T>,
    pub(super) A: Motion<T>,
    /// Of the whole subtree after the inward pass: force, inertia, velocity-product matrix.
    pub(super) F: Force<T>,
    pub(super) I: Inertia<T>,
    pub(super) B: VelocityProductMatrix<T>,
}

impl<T: Differentiable> Composite<T> {
    /// Field by field: a whole struct would be put together in memory and read again before it has arrived there.
    #[inline(always)]
    pub(super) fn move_to<P: Scalar>(
        &mut self,
        body: &Body<P>,
        units: Option<&UnitVelocityProducts<T>>,
        X_PB: Transform<T>,
        motion: &Accelerated<T>,
    ) where
        T: Over<P>,
    {
        let Accelerated { V, A } = *motion;
        let F = body.inertia.force(&V, &A);
        let B = match units {
            Some(units) => units.at(&V),
            None => VelocityProductMatrix::new(&body.inertia.lift(), &V),
        };
        self.X_PB = X_PB;
        self.V = V;
        self.A = A;
        self.F = F;
        self.I = body.inertia.lift();
        self.B = B;
    }

    pub(super) fn at_rest() -> Self {
        Self {
            X_PB: Transform::identity(),
            V: Motion::zero(),
            A: Motion::zero(),
            F: Force::zero(),
            I: Inertia::zero(),
            B: VelocityProductMatrix::zero(),
        }
    }
}
