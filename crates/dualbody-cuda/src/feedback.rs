//! Rollouts under linear feedback.

use dualbody::State;
use nalgebra::{DMatrix, DVector};

use crate::error::{CudaError, check_length};
use crate::numbers::Numbers;
use crate::real::Real;
use crate::rollout::CudaRollout;
use crate::simulator::CudaSimulator;
use crate::stepper::StepInputs;

/// Linear feedback, u = u₀ − K (x ⊖ x₀), with the deviation in tangent coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearFeedback {
    /// The reference state x₀.
    pub reference: State,
    /// The input u₀ there, length `nu`.
    pub input: DVector<f64>,
    /// The gain K, `nu` × `n_tangent`.
    pub gain: DMatrix<f64>,
}

impl LinearFeedback {
    /// Its numbers in the order of the inputs of [`graphs::feedback_step`](crate::graphs::feedback_step).
    pub fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let reference = self.reference.numbers();
        reference.chain(&self.input).chain(&self.gain).copied()
    }
}

impl<R: Real> CudaSimulator<R> {
    /// Takes `steps` steps from each of the initial states under linear feedback, and stores each `every`-th state (none for 0).
    ///
    /// # Errors
    /// If [feedback](Self::with_feedback) was not compiled, the number of states or a size is wrong, the device has too little memory, or the driver fails.
    pub fn rollout_feedback(
        &self,
        initial: &[State],
        steps: usize,
        every: usize,
        feedback: &LinearFeedback,
    ) -> Result<CudaRollout, CudaError> {
        let stepper = self.feedback.as_ref().ok_or_else(|| CudaError::Mismatch {
            what: "no feedback was compiled: CudaSimulator::with_feedback".to_owned(),
        })?;
        let (nu, n) = (self.nu(), self.own.n_tangent());
        check_length("the input at the reference", feedback.input.len(), Some(nu))?;
        check_length("a row of the gain", feedback.gain.ncols(), Some(n))?;
        check_length("a column of the gain", feedback.gain.nrows(), Some(nu))?;
        let shared: Vec<R> = feedback.numbers().map(R::from_f64).collect();
        let shared = Numbers::from_states(&self.device, stepper.sizes().shared, 1, &shared)?;
        let (schedule, mut states) = (self.schedule(steps, every), self.states(initial)?);
        let mut kept = self.room(schedule)?;
        let inputs = StepInputs {
            constants: &self.parameters,
            each_step: &self.none,
            shared: &shared,
        };
        stepper.run(
            schedule,
            &mut states.numbers,
            inputs,
            &mut kept,
            &mut states.status,
        )?;
        self.fetch(initial, schedule, &states, &kept)
    }
}
