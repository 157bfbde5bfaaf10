//! Interpretation of a graph over any scalar.

use super::graph::Graph;
use crate::scalar::Scalar;

/// Working memory of [`Graph::evaluate_into`].
#[derive(Clone, Debug)]
pub struct EvaluationScratch<T> {
    slots: Vec<T>,
}

/// Error for inputs that violate a condition of a graph.
#[derive(Clone, PartialEq, thiserror::Error)]
#[error("the graph assumes that {condition}, which does not hold at these inputs")]
pub struct BrokenCondition {
    /// Its index among the conditions of the graph, from 0.
    pub index: usize,
    /// The condition in words.
    pub condition: String,
}

impl Graph {
    /// Makes memory to evaluate the graph over a scalar.
    pub fn scratch<T: Scalar>(&self) -> EvaluationScratch<T> {
        EvaluationScratch {
            slots: vec![T::zero(); self.program.slots],
        }
    }

    /// Computes all outputs in sequence. Allocates.
    ///
    /// * `inputs` – entries of all inputs in sequence
    ///
    /// # Errors
    /// If the inputs violate a condition of the graph.
    ///
    /// # Panics
    /// If the number of entries is wrong.
    pub fn evaluate<T: Scalar>(&self, inputs: &[T]) -> Result<Vec<T>, BrokenCondition> {
        let mut out = vec![T::zero(); self.n_outputs()];
        self.evaluate_into(inputs, &mut self.scratch(), &mut out)?;
        Ok(out)
    }

    /// [`evaluate`](Self::evaluate) without allocation, except for an error.
    ///
    /// * `outputs` – output, entries of all outputs; also filled if a condition is violated
    ///
    /// # Errors
    /// If the inputs violate a condition of the graph, in any lane.
    ///
    /// # Panics
    /// If an argument has the wrong size.
    pub fn evaluate_into<T: Scalar>(
        &self,
        inputs: &[T],
        scratch: &mut EvaluationScratch<T>,
        outputs: &mut [T],
    ) -> Result<(), BrokenCondition> {
        assert_eq!(inputs.len(), self.n_inputs(), "the inputs of the graph");
        assert_eq!(outputs.len(), self.n_outputs(), "the outputs of the graph");
        let slots = &mut scratch.slots[..];
        let expected = self.program.slots;
        assert_eq!(slots.len(), expected, "the scratch is of another graph");
        T::vectorized(
            #[inline(always)]
            || self.program.run(inputs, slots),
        );
        let (results, conditions) = self.program.kept.split_at(outputs.len());
        for (out, &slot) in outputs.iter_mut().zip(results) {
            *out = slots[slot as usize];
        }
        for (index, (own, &slot)) in self.conditions().iter().zip(conditions).enumerate() {
            if !slots[slot as usize].is_at_most(own.limit, &own.condition) {
                return Err(BrokenCondition {
                    index,
                    condition: own.condition.clone(),
                });
            }
        }
        Ok(())
    }
}

crate::error::debug_by_message! { BrokenCondition }
