//! Mass matrix and forces of a robot at a state, without constraint forces.

use super::evaluation_point::EvaluationPoint;
use super::forces::Forces;
use crate::dynamics::{
    CrbaScratch, RneaScratch, TreeMatrix, bias_forces_of_placed_into, mass_matrix_of_placed_into,
    place_bodies_into,
};
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::spatial::{Motion, Transform};

/// M and τ − h.
#[derive(Clone, Debug)]
pub(super) struct Placed<T: Scalar> {
    crba: CrbaScratch<T>,
    rnea: RneaScratch<T>,
    /// τ − h.
    pub(super) forces: Vec<T>,
}

impl<T: Scalar> Placed<T> {
    /// Makes memory for a model.
    pub(super) fn new<P: Scalar>(model: &Model<P>) -> Self {
        Self {
            crba: CrbaScratch::new(model),
            rnea: RneaScratch::new(model),
            forces: vec![T::zero(); model.nv()],
        }
    }

    /// Poses and velocities of all bodies.
    pub(super) fn place<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>)
    where
        T: Over<P>,
    {
        place_bodies_into(at.model(), at.q(), at.v(), &mut self.rnea);
    }

    /// τ − h of bodies that have been placed.
    pub(super) fn load<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>, forces: &Forces<T>)
    where
        T: Over<P>,
    {
        let (model, out) = (at.model(), &mut self.forces);
        bias_forces_of_placed_into(model, at.v(), &forces.bodies, &mut self.rnea, out);
        let balance = out.iter_mut().zip(&forces.tau);
        balance.for_each(|(force, &tau)| *force = tau - *force);
    }

    /// M, the upper triangle.
    pub(super) fn mass_into<P: Scalar>(&mut self, model: &Model<P>, mass: &mut TreeMatrix<T>)
    where
        T: Over<P>,
    {
        mass_matrix_of_placed_into(model, self.rnea.motions().0, &mut self.crba, mass);
    }

    /// Poses of the bodies in their parents, and their velocities and accelerations.
    pub(super) fn motions(&self) -> (&[Transform<T>], &[Motion<T>]) {
        self.rnea.motions()
    }
}

/// Adds to the diagonal of a matrix.
pub(super) fn add_diagonal<T: Scalar>(matrix: &mut TreeMatrix<T>, diagonal: &[T]) {
    for (k, &x) in diagonal.iter().enumerate() {
        matrix[(k, k)] += x;
    }
}
