//! A step as a kernel that takes many.

use std::marker::PhantomData;

use dualbody::Model;
use dualbody::codegen::{CudaSizes, RolloutInputs};
use dualbody::scalar::traced::Graph;

use crate::compiler::Compiler;
use crate::device::Device;
use crate::error::CudaError;
use crate::kernel::Kernel;
use crate::launcher::Steps;
use crate::numbers::{Numbers, Status};
use crate::real::Real;

/// A step as a kernel over `f64` or `f32` that contains the loop over time. The step is any graph whose outputs are the next values of its first inputs.
#[derive(Debug)]
pub struct CudaStepper<R = f64> {
    kernel: Kernel,
    real: PhantomData<R>,
}

/// Arrays that a rollout reads, on the device.
#[derive(Clone, Copy, Debug)]
pub struct StepInputs<'a, R> {
    /// Inputs of each state that are constant.
    pub constants: &'a Numbers<R>,
    /// Inputs of each state that change in every step: a block of rows for each step.
    pub each_step: &'a Numbers<R>,
    /// Inputs that are equal for all states.
    pub shared: &'a Numbers<R>,
}

/// Number of steps, and choice of the states that are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    /// Number of steps.
    pub steps: usize,
    /// Number of steps from one stored state to the next; 0 stores none.
    pub every: usize,
    /// Speed (rad/s, m/s) above which a motion has diverged.
    pub fastest: f64,
}

impl Schedule {
    /// Number of stored states.
    pub fn kept(&self) -> usize {
        self.steps.checked_div(self.every).unwrap_or(0)
    }
}

impl<R: Real> CudaStepper<R> {
    /// Compiles and loads a step, or finds it compiled.
    ///
    /// * `name` – of the function, an identifier of C
    ///
    /// # Errors
    /// If the graph is not a step, a name is not an identifier, an input does not exist, NVRTC is missing or refuses the text or its flags, the file
    /// cannot be stored, or the driver fails.
    pub fn new(
        graph: &Graph,
        name: &str,
        inputs: &RolloutInputs,
        device: &Device,
        compiler: &Compiler,
    ) -> Result<Self, CudaError> {
        let source = graph.to_cuda_rollout(name, R::PRECISION, inputs)?;
        Ok(Self {
            kernel: Kernel::load(graph, &source, device, compiler)?,
            real: PhantomData,
        })
    }

    /// Compiles and loads a step as [`new`](Self::new) does, cut into parts of another length, or finds it compiled.
    ///
    /// * `length` – maximum number of operations of a part
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn in_parts(
        graph: &Graph,
        name: &str,
        inputs: &RolloutInputs,
        length: usize,
        device: &Device,
        compiler: &Compiler,
    ) -> Result<Self, CudaError> {
        let source = graph.to_cuda_rollout_in_parts(name, R::PRECISION, inputs, length)?;
        Ok(Self {
            kernel: Kernel::load(graph, &source, device, compiler)?,
            real: PhantomData,
        })
    }

    /// Numbers of values that it reads and writes for each state.
    pub fn sizes(&self) -> CudaSizes {
        self.kernel.sizes
    }

    /// Takes steps from many states on the device. Returns before the work is done; a download waits for it.
    ///
    /// A state stops at its last valid value if a condition is violated, an input is not finite or the motion diverges. Its status reports this, and
    /// later steps do not change it.
    ///
    /// * `state` – on entry the first state, on return the last one
    /// * `kept` – output, a block of rows for each stored state; rows after the end of a stopped motion are unspecified
    ///
    /// # Errors
    /// If an array has the wrong length or is on another device, or the driver fails.
    pub fn run(
        &self,
        schedule: Schedule,
        state: &mut Numbers<R>,
        inputs: StepInputs<'_, R>,
        kept: &mut Numbers<R>,
        status: &mut Status,
    ) -> Result<(), CudaError> {
        let steps = Steps {
            steps: schedule.steps,
            every: schedule.every,
            fastest: R::from_f64(schedule.fastest),
            state,
            inputs: inputs.constants,
            each_step: inputs.each_step,
            shared: inputs.shared,
            kept,
            status,
        };
        steps.launch(&self.kernel)
    }

    /// The condition of a status, in words; empty if the status belongs to no condition.
    pub fn condition(&self, status: i32) -> &str {
        self.kernel.condition(status)
    }

    /// Checks that the step was recorded from a robot, and that the robot has not changed since.
    ///
    /// # Errors
    /// If it is of another robot, or a parameter of the robot has changed.
    pub fn check_robot(&self, model: &Model) -> Result<(), CudaError> {
        self.kernel.check_robot(model)
    }
}
