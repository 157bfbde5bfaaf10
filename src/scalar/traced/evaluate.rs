//! Interpretation of a graph over any scalar.

use super::graph::Graph;
use crate::scalar::Scalar;

/// Working memory of [`Graph::evaluate_into`].
#[derive(Clone, Debug)]
pub struct EvaluationScratch<T> {
    slots: Vec<T>,
}

/// Error for inputs at which a condition does not hold that a graph takes for granted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the graph takes for granted that {condition}, which does not hold at these inputs")]
pub struct BrokenCondition {
    /// Its place among the conditions of the graph, from 0.
    pub index: usize,
    /// The condition in words.
    pub condition: String,
}

impl Graph {
    /// Memory to evaluate the graph over a scalar.
    pub fn scratch<T: Scalar>(&self) -> EvaluationScratch<T> {
        EvaluationScratch {
            slots: vec![T::zero(); self.program.slots],
        }
    }

    /// Computes the outputs, one after the other. Allocates.
    ///
    /// * `inputs` – the numbers of all inputs, one input after the other
    ///
    /// # Errors
    /// If a condition does not hold that the graph takes for granted.
    ///
    /// # Panics
    /// If there is another number of inputs.
    pub fn evaluate<T: Scalar>(&self, inputs: &[T]) -> Result<Vec<T>, BrokenCondition> {
        let mut out = vec![T::zero(); self.n_outputs()];
        self.evaluate_into(inputs, &mut self.scratch(), &mut out)?;
        Ok(out)
    }

    /// [`evaluate`](Self::evaluate) without allocation, except for an error.
    ///
    /// * `outputs` – output, the numbers of all outputs; also where a condition does not hold
    ///
    /// # Errors
    /// If a condition does not hold that the graph takes for granted, in any lane.
    ///
    /// # Panics
    /// If an argument has another size than the graph gives it.
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
