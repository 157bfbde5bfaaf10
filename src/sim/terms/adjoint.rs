//! Gradients of a term: the functions that its file gives.

use crate::dynamics::Sweep;
use crate::scalar::Scalar;
use crate::sim::balance::Balance;
use crate::sim::moment::Moment;

/// Point at which the gradient of the weighted balance of forces is taken:  μᵀ (ID(q, v, a) − τ − Σ Jᵀ F)  at a fixed acceleration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AdjointPoint<'a, T: Scalar> {
    pub(crate) moment: &'a Moment<'a, f64, T>,
    /// a.
    pub(crate) a: &'a [T],
    /// μ.
    pub(crate) mu: &'a [T],
    /// `true` for the acceleration that there would be without stops and rows.
    pub(crate) is_free: bool,
    /// Weights of what the step, or the rate at a moment, adds to each number of the state of contact; empty for none.
    pub(crate) by_contact: &'a [T],
    /// Rows and their weights; `None` where there are none.
    pub(crate) rows: Option<RowWeights<'a, T>>,
}

/// Rows of a solution, y = J ã − w + R f, with weights.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowWeights<'a, T: Scalar> {
    pub(crate) balance: &'a Balance<T>,
    /// Of y, at fixed forces and accelerations.
    pub(crate) y: &'a [T],
    /// ã.
    pub(crate) seen: &'a [T],
    /// Effect of the friction of each block on all that is weighted; empty if it is not wanted.
    pub(crate) friction: &'a [T],
}

/// Sums of the gradient of a step.
#[derive(Debug)]
pub(crate) struct StepSlopes<'a, T = f64> {
    /// In tangent directions of q.
    pub(crate) q: &'a mut [T],
    pub(crate) v: &'a mut [T],
    /// In the state of contact.
    pub(crate) contact: &'a mut [T],
    pub(crate) u: &'a mut [T],
    /// In all parameters of the simulator, or in those of the model, which are the first; empty if they are not wanted.
    pub(crate) parameters: &'a mut [T],
    /// Whether those are wanted that are not the model's.
    pub(crate) has_parts: bool,
}

/// Gradient of a term, as it is added to that of a step. Its working memory is the implementor.
pub(crate) trait TermAdjoint<T: Scalar> {
    /// The term at the acceleration that has been found.
    type Term;

    /// Adds the gradient of −μᵀ τ − Σ W · F of the forces that follow from the state, and of the weighted changes of the state of contact.
    ///
    /// * `sweep` – between its passes, with the motion W that the rates μ give to each body; derivatives in pose and velocity of a body are
    ///   added there
    fn add_forces(
        &mut self,
        at: &AdjointPoint<'_, T>,
        term: &Self::Term,
        sweep: &mut Sweep<T>,
        out: &mut StepSlopes<'_, T>,
    );

    /// Adds the gradient of the weighted rows of the term and of −μᵀ Jᵀ f, at fixed forces f and accelerations.
    ///
    /// * `sweep` – as before; it looks along ã
    fn add_rows(
        &mut self,
        _at: &AdjointPoint<'_, T>,
        _term: &Self::Term,
        _sweep: &mut Sweep<T>,
        _out: &mut StepSlopes<'_, T>,
    ) {
    }
}
