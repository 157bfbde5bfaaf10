//! Weights of a gradient, and its sums.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::local::OfBody;
use super::sink::BodyRow;
use crate::scalar::{Dual, Scalar};
use crate::sim::parameter_slots::add_to_last;
use crate::spatial::{Force, Motion};

/// Weights of the contributions of terms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TermWeights<'a, T> {
    /// μ.
    pub(crate) mu: &'a [T],
    /// λ, of y of each row.
    pub(crate) y: &'a [T],
    /// ν, of what the step, or the rate at an instant, adds to each entry of the contact state; empty for none.
    pub(crate) by_contact: &'a [T],
    /// Effect of the friction of each block on all that is weighted; empty if it is not wanted.
    pub(crate) friction: &'a [T],
}

impl<T: Scalar> TermWeights<'_, T> {
    /// −W · F
    pub(super) fn force<const N: usize>(F: &Force<Dual<T, N>>, W: &Motion<T>) -> Dual<T, N> {
        let both = F.to_array().into_iter().zip(W.to_array());
        both.fold(Dual::from(0.0), |sum, (F, W)| sum - F.each(|x| x * W))
    }

    /// λᵀ y
    pub(super) fn rows(&self, rows: &[BodyRow<T>]) -> OfBody<T> {
        let weighted = rows.iter().map(|row| row.y.each(|x| x * self.y[row.row]));
        weighted.fold(OfBody::from(0.0), |sum, x| sum + x)
    }

    /// νᵀ Δm
    pub(super) fn rates<const N: usize>(&self, first: usize, rates: &[Dual<T, N>]) -> Dual<T, N> {
        let weights = self.by_contact.get(first..).unwrap_or(&[]);
        let weighted = rates.iter().zip(weights);
        weighted.fold(Dual::from(0.0), |sum, (x, &weight)| {
            sum + x.each(|x| x * weight)
        })
    }
}

/// Sums of the gradient of a step.
#[derive(Debug)]
pub(crate) struct StepGradientSum<'a, T = f64> {
    /// In tangent directions of q.
    pub(crate) q: &'a mut [T],
    pub(crate) v: &'a mut [T],
    /// In the contact state.
    pub(crate) contact: &'a mut [T],
    pub(crate) u: &'a mut [T],
    /// In the activations of inputs; empty where these are given as signals.
    pub(crate) activation: &'a mut [T],
    /// In all parameters of the simulator, or in those of the model, which are the first; empty if they are not wanted.
    pub(crate) parameters: &'a mut [T],
    /// Whether those are requested that are not the model's.
    pub(crate) has_parts: bool,
}

impl<T: Scalar> StepGradientSum<'_, T> {
    /// Adds a derivative in the time step, the last of all parameters, where it is requested.
    pub(crate) fn add_time_step(&mut self, slope: T) {
        if self.has_parts {
            add_to_last(self.parameters, slope);
        }
    }
}
