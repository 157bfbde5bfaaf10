//! A batch simulator whose states are on a GPU.

use dualbody::codegen::RolloutInputs;
use dualbody::{Model, Simulator, State};

use crate::compiler::Compiler;
use crate::device::Device;
use crate::error::{CudaError, check_length};
use crate::function::CudaFunction;
use crate::graphs;
use crate::numbers::{Numbers, Status};
use crate::real::Real;
use crate::rollout::{CudaRollout, Left};
use crate::states::{CudaStates, numbers};
use crate::stepper::{CudaStepper, Schedule, StepInputs};

/// Steps many states of one robot, or of variants of it, on a GPU in `f64` or `f32`, with the interface of
/// [`BatchSimulator`](dualbody::sim::BatchSimulator).
///
/// The step is traced and compiled when the simulator is made, other functions on request: [`with_feedback`](Self::with_feedback),
/// [`with_jacobians`](Self::with_jacobians), [`with_gradients`](Self::with_gradients). [`dualbody::scalar::traced`] lists what can be traced.
#[derive(Debug)]
pub struct CudaSimulator<R = f64> {
    pub(crate) own: Simulator,
    pub(crate) device: Device,
    len: usize,
    names: Vec<String>,
    /// Parameters of each state.
    pub(crate) parameters: Numbers<R>,
    /// An array without numbers.
    pub(crate) none: Numbers<R>,
    step: CudaStepper<R>,
    pub(crate) feedback: Option<CudaStepper<R>>,
    pub(crate) jacobians: Option<CudaFunction<R>>,
    pub(crate) gradients: Option<CudaFunction<R>>,
}

impl<R: Real> CudaSimulator<R> {
    /// A simulator of `len` states of one robot.
    ///
    /// # Errors
    /// If there are no states, NVRTC is missing or refuses the step, or the driver fails.
    ///
    /// # Panics
    /// If the step decides on values: see [what can be traced](dualbody::scalar::traced).
    pub fn new(
        simulator: Simulator,
        len: usize,
        device: &Device,
        compiler: &Compiler,
    ) -> Result<Self, CudaError> {
        Self::of_variants(simulator, &[], &[], len, device, compiler)
    }

    /// A simulator of `len` variants of a robot, which differ in some parameters (domain randomisation).
    ///
    /// * `names` – names of these parameters, as in [`Simulator::parameter_layout`]
    /// * `parameters` – their values, one state after the other
    ///
    /// # Errors
    /// If there are no states, a parameter does not exist, NVRTC is missing or refuses the step, or the driver fails.
    ///
    /// # Panics
    /// If the step decides on values: see [what can be traced](dualbody::scalar::traced).
    pub fn of_variants(
        simulator: Simulator,
        names: &[&str],
        parameters: &[f64],
        len: usize,
        device: &Device,
        compiler: &Compiler,
    ) -> Result<Self, CudaError> {
        if len == 0 {
            return Err(CudaError::EmptyBatch);
        }
        let graph = graphs::step(&simulator, names)?;
        let inputs = RolloutInputs::default();
        let given: Vec<R> = parameters.iter().map(|&p| R::from_f64(p)).collect();
        Ok(Self {
            own: simulator,
            device: device.clone(),
            len,
            names: names.iter().map(|&name| name.to_owned()).collect(),
            parameters: Numbers::from_states(device, names.len(), len, &given)?,
            none: Numbers::zeros(device, 0, 1)?,
            step: CudaStepper::new(&graph, "dualbody_step", &inputs, device, compiler)?,
            feedback: None,
            jacobians: None,
            gradients: None,
        })
    }

    /// Compiles the step under linear feedback, for [`rollout_feedback`](Self::rollout_feedback).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_feedback(mut self, compiler: &Compiler) -> Result<Self, CudaError> {
        let graph = graphs::feedback_step(&self.own, &self.parameter_names())?;
        let inputs = RolloutInputs::of_feedback();
        let step = CudaStepper::new(&graph, "dualbody_feedback", &inputs, &self.device, compiler)?;
        self.feedback = Some(step);
        Ok(self)
    }

    /// Compiles A and B of the step, separate for each variant, for [`linearize`](Self::linearize).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_jacobians(mut self, compiler: &Compiler) -> Result<Self, CudaError> {
        let graph = graphs::linearization_of_variants(&self.own, &self.parameter_names())?;
        let function =
            CudaFunction::new(&graph, "dualbody_jacobians", &[], &self.device, compiler)?;
        self.jacobians = Some(function);
        Ok(self)
    }

    /// Compiles the gradient of the step in state, input and the parameters of the variants, for [`gradients`](Self::gradients).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_gradients(mut self, compiler: &Compiler) -> Result<Self, CudaError> {
        let graph = graphs::step_adjoint(&self.own, &self.parameter_names())?;
        let function =
            CudaFunction::new(&graph, "dualbody_gradients", &[], &self.device, compiler)?;
        self.gradients = Some(function);
        Ok(self)
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.len
    }

    /// `false`, as a batch has at least one state.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number of inputs of one state.
    pub fn nu(&self) -> usize {
        self.own.nu()
    }

    /// The simulator from which it was made.
    pub fn simulator(&self) -> &Simulator {
        &self.own
    }

    /// Names of the parameters in which variants differ.
    pub fn parameter_names(&self) -> Vec<&str> {
        self.names.iter().map(String::as_str).collect()
    }

    /// Replaces the parameters, one variant after the other.
    ///
    /// # Errors
    /// If the length is wrong, or the driver fails.
    pub fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), CudaError> {
        let given: Vec<R> = parameters.iter().map(|&p| R::from_f64(p)).collect();
        self.parameters.upload_states(&given)
    }

    /// Checks that the kernels were recorded from a robot, and that the robot has not changed since.
    ///
    /// # Errors
    /// If they are of another robot, or a parameter of the robot has changed.
    pub fn check_robot(&self, model: &Model) -> Result<(), CudaError> {
        self.step.check_robot(model)
    }

    /// The condition of an [ending](crate::Ending), in words.
    pub fn condition(&self, index: usize) -> &str {
        let number = i32::try_from(index + 1);
        number.map_or("", |number| self.step.condition(number))
    }

    /// Copies states to the device.
    ///
    /// # Errors
    /// If their number differs from that of the simulator, one has the wrong length, or the device has too little memory.
    pub fn states(&self, states: &[State]) -> Result<CudaStates<R>, CudaError> {
        let neutral = self.own.neutral_state::<f64>();
        check_length("the batch of states", states.len(), Some(self.len))?;
        for state in states {
            check_length("q of a state", state.q.len(), Some(neutral.q.len()))?;
            check_length("v of a state", state.v.len(), Some(neutral.v.len()))?;
            check_length(
                "the contact state",
                state.contact.len(),
                Some(neutral.contact.len()),
            )?;
            check_length(
                "the activations of a state",
                state.activation.len(),
                Some(neutral.activation.len()),
            )?;
        }
        let all = numbers::<R>(states);
        Ok(CudaStates {
            numbers: Numbers::from_states(&self.device, neutral.len(), self.len, &all)?,
            status: Status::new(&self.device, self.len)?,
            like: neutral,
        })
    }

    /// Takes one step of each state; the states stay on the device.
    ///
    /// * `inputs` – the input of one state after the other (N·m or N)
    ///
    /// # Errors
    /// If the number of inputs is wrong, or the driver fails.
    pub fn step(&self, states: &mut CudaStates<R>, inputs: &[f64]) -> Result<(), CudaError> {
        let inputs = self.inputs(1, inputs)?;
        let mut kept = Numbers::zeros(&self.device, 0, self.len)?;
        self.run(self.schedule(1, 0), states, &inputs, &mut kept)
    }

    /// Takes steps of each state with inputs on the device.
    ///
    /// * `inputs` – rows of the `nu` inputs of one step after the other
    /// * `kept` – output, the stored states: a block of rows for each
    ///
    /// # Errors
    /// If an array has the wrong length or is on another device, or the driver fails.
    pub fn run(
        &self,
        schedule: Schedule,
        states: &mut CudaStates<R>,
        inputs: &Numbers<R>,
        kept: &mut Numbers<R>,
    ) -> Result<(), CudaError> {
        let inputs = StepInputs {
            constants: &self.parameters,
            each_step: inputs,
            shared: &self.none,
        };
        let CudaStates {
            numbers, status, ..
        } = states;
        self.step.run(schedule, numbers, inputs, kept, status)
    }

    /// Takes `steps` steps from each of the initial states with given inputs, and stores each `every`-th state (none for 0).
    ///
    /// * `inputs` – inputs of all steps of the first state, then of the next state, and so on, length `len` × `steps` × `nu` (N·m or N)
    ///
    /// # Errors
    /// If the number of states or inputs is wrong, the device has too little memory, or the driver fails.
    pub fn rollout_inputs(
        &self,
        initial: &[State],
        steps: usize,
        every: usize,
        inputs: &[f64],
    ) -> Result<CudaRollout, CudaError> {
        let (schedule, mut states) = (self.schedule(steps, every), self.states(initial)?);
        let inputs = self.inputs(steps, inputs)?;
        let mut kept = self.room(schedule)?;
        self.run(schedule, &mut states, &inputs, &mut kept)?;
        self.fetch(initial, schedule, &states, &kept)
    }

    /// The schedule of so many steps, with the simulator's own bound of speed.
    pub fn schedule(&self, steps: usize, every: usize) -> Schedule {
        Schedule {
            steps,
            every,
            fastest: self.own.divergence_bound(),
        }
    }

    /// Memory for the stored states.
    ///
    /// # Errors
    /// If the device has too little memory.
    pub fn room(&self, schedule: Schedule) -> Result<Numbers<R>, CudaError> {
        let rows = schedule
            .kept()
            .checked_mul(self.own.neutral_state::<f64>().len());
        let rows = rows.ok_or_else(|| crate::error::too_many("the states that are kept"))?;
        Numbers::zeros(&self.device, rows, self.len)
    }

    pub(crate) fn fetch(
        &self,
        initial: &[State],
        schedule: Schedule,
        states: &CudaStates<R>,
        kept: &Numbers<R>,
    ) -> Result<CudaRollout, CudaError> {
        let left = Left {
            states,
            kept,
            n_kept: schedule.kept(),
            every: schedule.every,
            interval: self.own.time_step() * schedule.every as f64,
        };
        CudaRollout::fetch(initial, &left)
    }

    /// Puts inputs of some steps on the device.
    pub(crate) fn inputs(&self, steps: usize, inputs: &[f64]) -> Result<Numbers<R>, CudaError> {
        let rows = steps.checked_mul(self.nu());
        let rows = rows.ok_or_else(|| crate::error::too_many("the inputs"))?;
        check_length("inputs", inputs.len(), rows.checked_mul(self.len))?;
        let given: Vec<R> = inputs.iter().map(|&u| R::from_f64(u)).collect();
        Numbers::from_states(&self.device, rows, self.len, &given)
    }
}
