//! The traits of a term: values, and derivatives.

use super::columns::RowColumns;
use super::linear_point::{ForceColumns, LinearPoint};
use crate::scalar::{Differentiable, Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::forces::Forces;
use crate::sim::moment::Moment;

/// A term of the balance of forces. Its working memory is the implementor.
pub(crate) trait Term<P: Scalar, T: Over<P>> {
    /// Adds the forces that follow from the state, and the part of them that is linear in the acceleration.
    fn add_forces(&mut self, at: &Moment<'_, P, T>, forces: &mut Forces<T>);

    /// Adds the Jacobians of the rows whose forces a solver finds, with their reference accelerations and regularisation where these do not depend
    /// on M.
    fn add_rows(&mut self, _at: &Moment<'_, P, T>, _balance: &mut Balance<T>) {}

    /// Adds reference accelerations and regularisation that depend on the diagonal of J M⁻¹ Jᵀ, which is known now.
    fn add_references(&mut self, _at: &Moment<'_, P, T>, _balance: &mut Balance<T>) {}

    /// Replaces the rows of the term by more of them where the acceleration `a` breaks its law. Returns whether there are any.
    fn add_violated(
        &mut self,
        _at: &Moment<'_, P, T>,
        _balance: &mut Balance<T>,
        _a: &[T],
    ) -> bool {
        false
    }

    /// Takes the forces of its rows.
    fn accept(&mut self, _at: &Moment<'_, P, T>, _balance: &mut Balance<T>) {}
}

/// Derivatives of a term, for the Jacobians of a step. Its working memory is the implementor.
pub(crate) trait TermDerivatives<T: Differentiable> {
    /// The term at the acceleration that has been found.
    type Term;

    /// Adds −∂τ and −∂(Jᵀ f) of the forces that follow from the state, at the acceleration that has been found.
    fn add_forces(
        &mut self,
        at: &LinearPoint<'_, T>,
        term: &Self::Term,
        forces: &mut ForceColumns<T>,
    );

    /// Adds ∂y of its rows at fixed forces and accelerations, and −∂(Jᵀ f).
    fn add_rows(
        &mut self,
        _at: &LinearPoint<'_, T>,
        _term: &Self::Term,
        _rows: &mut RowColumns<T>,
        _forces: &mut ForceColumns<T>,
    ) {
    }

    /// Takes the derivatives of the forces of its rows.
    fn accept(&mut self, _rows: &RowColumns<T>) {}
}
