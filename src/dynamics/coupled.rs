//! Forward dynamics of robots whose joints follow one another.
//!
//! A follower ties bodies together that are not neighbours in the tree, so joints cannot be eliminated one after the other. The
//! mass matrix in the remaining coordinates is formed and factorised instead, in O(nv³).

use nalgebra::DMatrix;

use super::crba::{CrbaScratch, mass_matrix_into};
use super::mass_matrix_factor::MassMatrixFactor;
use super::rnea::{RneaScratch, bias_forces_into};
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::spatial::Force;

/// Working memory of the functions of this file.
#[derive(Clone, Debug)]
pub(super) struct CoupledScratch<T> {
    crba: CrbaScratch<T>,
    rnea: RneaScratch<T>,
    factor: MassMatrixFactor<T>,
}

impl<T: Scalar> CoupledScratch<T> {
    /// Memory for a model with followers; nothing for others, which do not need it.
    pub(super) fn new<P: Scalar>(model: &Model<P>) -> Option<Box<Self>> {
        model.has_coupling().then(|| {
            let identity = DMatrix::identity(model.nv(), model.nv());
            Box::new(Self {
                crba: CrbaScratch::new(model),
                rnea: RneaScratch::new(model),
                factor: MassMatrixFactor::new(model, &identity),
            })
        })
    }

    /// (M + R) v̇ = τ − h.
    pub(super) fn accelerations<P: Scalar>(
        &mut self,
        model: &Model<P>,
        (q, v): (&[T], &[T]),
        (tau, resistance): (&[T], &[T]),
        external: &[Force<T>],
        a: &mut [T],
    ) where
        T: Over<P>,
    {
        bias_forces_into(model, q, v, external, &mut self.rnea, a);
        a.iter_mut().zip(tau).for_each(|(a, &tau)| *a = tau - *a);
        self.factorize(model, q, resistance);
        self.factor.solve(a);
    }

    /// M⁻¹, column by column.
    pub(super) fn inverse<P: Scalar>(&mut self, model: &Model<P>, q: &[T], out: &mut DMatrix<T>)
    where
        T: Over<P>,
    {
        self.factorize(model, q, &[]);
        out.fill_with_identity();
        for mut column in out.column_iter_mut() {
            self.factor.solve(column.as_mut_slice());
        }
    }

    fn factorize<P: Scalar>(&mut self, model: &Model<P>, q: &[T], resistance: &[T])
    where
        T: Over<P>,
    {
        let crba = &mut self.crba;
        self.factor.refactor_filled(|mass| {
            mass_matrix_into(model, q, crba, mass);
            for (k, &resistance) in resistance.iter().enumerate() {
                mass[(k, k)] += resistance;
            }
        });
    }
}
