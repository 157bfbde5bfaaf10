//! The mass matrix without bounded joint forces.
//!
//! Contact models that read the Delassus diagonal n M⁻¹ nᵀ of a normal n use the inertia of the robot with its dampers and springs, whichever piece of their
//! law bounded forces are on. While forces on their line are added to the mass matrix of a step, that inertia has factors of its own.

use super::rows::Rows;
use crate::dynamics::{MassMatrixFactor, TreeMatrix};
use crate::model::Model;
use crate::scalar::Scalar;

/// The factors of that matrix.
#[derive(Clone, Debug)]
pub(super) struct BareMass<T: Scalar> {
    factor: MassMatrixFactor<T>,
    /// Whether they are those of the last step.
    is_valid: bool,
    memory: Vec<T>,
}

impl<T: Scalar> BareMass<T> {
    /// Makes memory for a model.
    pub(super) fn new<P: Scalar>(model: &Model<P>) -> Box<Self> {
        Box::new(Self {
            factor: MassMatrixFactor::unfilled(model),
            is_valid: false,
            memory: Vec::with_capacity(model.nv()),
        })
    }

    /// Factorises the matrix of a step; `None` in steps without bounded forces.
    pub(super) fn find(&mut self, mass: Option<&TreeMatrix<T>>) {
        self.is_valid = mass.is_some();
        if let Some(mass) = mass {
            self.factor.refactor_filled(|own| own.copy_from_own(mass));
        }
    }

    /// The factors, in steps with bounded forces.
    pub(super) fn factor(&self) -> Option<&MassMatrixFactor<T>> {
        self.is_valid.then_some(&self.factor)
    }

    /// The Delassus diagonal of a row, in steps with bounded forces.
    pub(super) fn delassus(&mut self, rows: &Rows<T>, row: usize) -> Option<T> {
        (self.is_valid).then(|| rows.delassus_of(&self.factor, row, &mut self.memory))
    }
}
