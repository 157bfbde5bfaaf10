//! Forward dynamics of robots whose joints follow one another.
//!
//! A mimic joint ties bodies together that are not neighbours in the tree, so joints cannot be eliminated one after the
//! other. The mass matrix in the remaining coordinates is formed and factorised instead, in O(nv³).

use nalgebra::DMatrix;

use super::aba::Driven;
use super::crba::{CrbaScratch, mass_matrix_of_trees_into};
use super::mass_matrix_factor::MassMatrixFactor;
use super::rnea::{RneaScratch, bias_forces_into};
use crate::model::Model;
use crate::scalar::{Over, Scalar};

/// Working memory of the functions of this file.
#[derive(Clone, Debug)]
pub(super) struct CoupledScratch<T> {
    crba: CrbaScratch<T>,
    rnea: RneaScratch<T>,
    factor: MassMatrixFactor<T>,
}

impl<T: Scalar> CoupledScratch<T> {
    /// Memory for a model with mimic joints; nothing for others, which do not need it.
    pub(super) fn new<P: Scalar>(model: &Model<P>) -> Option<Box<Self>> {
        model.has_coupling().then(|| {
            Box::new(Self {
                crba: CrbaScratch::new(model),
                rnea: RneaScratch::new(model),
                factor: MassMatrixFactor::unfilled(model),
            })
        })
    }

    /// Computes v̇ from (M + R) v̇ = τ − h.
    pub(super) fn accelerations<P: Scalar>(
        &mut self,
        model: &Model<P>,
        driven: &Driven<'_, T>,
        a: &mut [T],
    ) where
        T: Over<P>,
    {
        let Driven { q, v, external, .. } = *driven;
        bias_forces_into(model, q, v, external, &mut self.rnea, a);
        let forces = a.iter_mut().zip(driven.tau);
        forces.for_each(|(a, &tau)| *a = tau - *a);
        factorize(
            model,
            q,
            driven.resistance,
            &mut self.crba,
            &mut self.factor,
        );
        self.factor.solve(a);
    }

    /// Computes M⁻¹, column by column.
    pub(super) fn inverse<P: Scalar>(&mut self, model: &Model<P>, q: &[T], out: &mut DMatrix<T>)
    where
        T: Over<P>,
    {
        factorize(model, q, &[], &mut self.crba, &mut self.factor);
        out.fill_with_identity();
        for mut column in out.column_iter_mut() {
            self.factor.solve(column.as_mut_slice());
        }
    }
}

/// Factorises M + R.
///
/// * `resistance` – diagonal of R, length `nv`; empty for none
pub(super) fn factorize<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    resistance: &[T],
    crba: &mut CrbaScratch<T>,
    factor: &mut MassMatrixFactor<T>,
) {
    factor.refactor_filled(|mass| {
        mass_matrix_of_trees_into(model, q, crba, mass);
        for (k, &resistance) in resistance.iter().enumerate() {
            mass[(k, k)] += resistance;
        }
    });
}
