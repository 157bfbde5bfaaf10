//! Jacobians of a step with an isolated impact: its gradients row by row.
//!
//! Such steps are rare, and the length of their parts depends on the state; `impact/pullback.rs` already implements this.

use super::Adjoint;
use crate::dynamics::Calls;
use crate::scalar::Scalar;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::method::{Pullback, StepColumns};
use crate::sim::simulator::Simulator;
use crate::sim::terms::StepGradientSum;

/// Gradients of a step, and memory for one of them.
#[derive(Clone, Debug)]
pub(super) struct ImpactRows<T: Scalar> {
    step: Adjoint<T>,
    /// Unit weights.
    lambda: Vec<T>,
    /// A row of A and one of B.
    row: Vec<T>,
}

impl<T: Scalar> ImpactRows<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let n = simulator.n_tangent();
        Self {
            step: Adjoint::new(simulator, Calls::Many),
            lambda: vec![T::zero(); n],
            row: vec![T::zero(); n + simulator.nu()],
        }
    }

    /// Writes A and B if the step has an isolated impact. Returns whether it has.
    pub(super) fn linearize(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        out: &mut StepColumns<'_, T>,
    ) -> bool {
        if !self.step.find(at, None) {
            return false;
        }
        for i in 0..self.lambda.len() {
            self.lambda[i] = T::one();
            self.find_row(at);
            self.lambda[i] = T::zero();
            let (of_a, of_b) = self.row.split_at(self.lambda.len());
            let a = out.a.row_mut(i).into_iter().zip(of_a);
            let all = a.chain(out.b.row_mut(i).into_iter().zip(of_b));
            all.for_each(|(out, &x)| *out = x);
        }
        true
    }

    fn find_row(&mut self, at: &EvaluationPoint<'_, f64, T>) {
        self.row.fill(T::zero());
        let nv = at.model().nv();
        let (state, u) = self.row.split_at_mut(self.lambda.len());
        let (q, rest) = state.split_at_mut(nv);
        let (v, contact) = rest.split_at_mut(nv);
        let mut slopes = StepGradientSum {
            q,
            v,
            contact,
            u,
            parameters: &mut [],
            has_parts: false,
        };
        self.step.add(at, &self.lambda, &mut slopes);
    }
}
