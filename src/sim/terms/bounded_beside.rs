//! Data beside bounded forces while a solver finds other forces: mass matrix and forces of the first round.

use crate::dynamics::TreeMatrix;
use crate::model::Model;
use crate::scalar::Scalar;
use crate::sim::balance::Balance;

/// Mass matrix and forces without those that are bounded.
#[derive(Clone, Debug)]
pub(super) struct Beside<T> {
    /// Of which the upper triangle is read.
    pub(super) mass: TreeMatrix<T>,
    /// τ − h.
    pub(super) forces: Vec<T>,
}

impl<T: Scalar> Beside<T> {
    /// Memory for the coordinates of a model.
    pub(super) fn new<P: Scalar>(model: &Model<P>) -> Box<Self> {
        Box::new(Self {
            mass: TreeMatrix::zeros(model),
            forces: vec![T::zero(); model.nv()],
        })
    }

    /// The force for an acceleration of a coordinate, without those of rows.
    pub(super) fn needed(&self, k: usize, a: &[T], balance: &Balance<T>) -> T {
        let entries = a.iter().enumerate();
        let inertial = entries.fold(-self.forces[k], |sum, (j, &a)| {
            self.mass.entry(k.min(j), k.max(j)).mul_add(a, sum)
        });
        let pairs = balance.rows().force_along(k);
        pairs.fold(inertial, |sum, (j, f)| (-j).mul_add(f, sum))
    }
}
