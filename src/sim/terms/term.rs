//! The traits of a term: values, and derivatives.

use super::numbers::Numbers;
use super::sink::{DerivativePoint, Sink};
use crate::scalar::{Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::forces::Forces;
use crate::sim::simulator::Simulator;

/// A term of the balance of forces. Its working memory is the implementor.
pub(crate) trait Term<P: Scalar, T: Over<P>> {
    /// Adds the forces that follow from the state, and the part of them that is linear in the acceleration.
    fn add_forces(&mut self, at: &EvaluationPoint<'_, P, T>, forces: &mut Forces<T>);

    /// Adds the Jacobians of the rows whose forces a solver finds, with their reference accelerations and regularisation where these do not depend
    /// on M.
    fn add_rows(&mut self, _at: &EvaluationPoint<'_, P, T>, _balance: &mut Balance<T>) {}

    /// Adds reference accelerations and regularisation that depend on the diagonal of J M⁻¹ Jᵀ, which is known now.
    fn add_references(&mut self, _at: &EvaluationPoint<'_, P, T>, _balance: &mut Balance<T>) {}

    /// Replaces the rows of the term by more of them where the acceleration `a` breaks its law. Returns whether there are any.
    fn add_violated(
        &mut self,
        _at: &EvaluationPoint<'_, P, T>,
        _balance: &mut Balance<T>,
        _a: &[T],
    ) -> bool {
        false
    }

    /// Takes the forces of its rows.
    fn accept(&mut self, _at: &EvaluationPoint<'_, P, T>, _balance: &mut Balance<T>) {}
}

/// Derivatives of a term at the computed acceleration, passed to a sink. The implementor is its working memory.
pub(crate) trait TermDerivatives<T: Scalar> {
    /// The term as it has been evaluated.
    type Term;

    /// Gets the memory of [`emit_numbers`](Self::emit_numbers).
    fn reserve_numbers(&mut self, _simulator: &Simulator) {}

    /// States the forces that follow from the state, and changes of the contact state that do.
    fn emit_forces<S: Sink<T>>(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &Self::Term,
        out: &mut S,
    );

    /// States the rows, with their forces, and changes of the contact state under these.
    fn emit_rows<S: Sink<T>>(
        &mut self,
        _at: &DerivativePoint<'_, T>,
        _term: &Self::Term,
        _out: &mut S,
    ) {
    }

    /// States all of that again over its own numbers.
    fn emit_numbers(
        &mut self,
        _at: &DerivativePoint<'_, T>,
        _term: &Self::Term,
        _out: &mut Numbers<'_, T>,
    ) {
    }

    /// Passes derivatives of changes of the contact state in the forces of rows to `each(state index, row, derivative)`.
    fn each_rate_by_force(
        _at: &DerivativePoint<'_, T>,
        _term: &Self::Term,
        _each: &mut dyn FnMut(usize, usize, T),
    ) {
    }
}
