//! A graph as a function of many states on a GPU.

use std::marker::PhantomData;

use dualbody::Model;
use dualbody::codegen::CudaSizes;
use dualbody::scalar::traced::Graph;

use crate::compiler::Compiler;
use crate::device::Device;
use crate::error::CudaError;
use crate::kernel::Kernel;
use crate::launcher::Batch;
use crate::numbers::{Numbers, Status};
use crate::real::Real;

/// A graph as kernels over `f64` or `f32` that evaluate it for many states, one state per thread.
///
/// The kernels of a long function exchange values in memory of the device: [`work`](CudaSizes::work) numbers for each state. Results are the same in
/// every run, and equal those of the graph to rounding.
#[derive(Debug)]
pub struct CudaFunction<R = f64> {
    kernel: Kernel,
    real: PhantomData<R>,
}

/// Outputs of a function on the host.
#[derive(Clone, Debug, PartialEq)]
pub struct Outputs<R> {
    /// Outputs of one state after the other; invalid where the status is not 0.
    pub numbers: Vec<R>,
    /// Status of each state: 0, the index k, from 1, of the first violated condition, or −1 if an output is not finite.
    pub status: Vec<i32>,
}

impl<R: Real> CudaFunction<R> {
    /// Compiles and loads a graph, or finds it compiled.
    ///
    /// * `name` – of the function, an identifier of C
    /// * `shared` – names of inputs that are equal for all states
    ///
    /// # Errors
    /// If a name is not an identifier, an input does not exist, NVRTC is missing or refuses the text or its flags, the file cannot be stored, or the
    /// driver fails.
    pub fn new(
        graph: &Graph,
        name: &str,
        shared: &[&str],
        device: &Device,
        compiler: &Compiler,
    ) -> Result<Self, CudaError> {
        let source = graph.to_cuda(name, R::PRECISION, shared)?;
        Ok(Self {
            kernel: Kernel::load(graph, &source, device, compiler)?,
            real: PhantomData,
        })
    }

    /// Compiles and loads a graph as [`new`](Self::new) does, cut into parts of another length, or finds it compiled.
    ///
    /// * `length` – maximum number of operations of a part
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn in_parts(
        graph: &Graph,
        name: &str,
        shared: &[&str],
        length: usize,
        device: &Device,
        compiler: &Compiler,
    ) -> Result<Self, CudaError> {
        let source = graph.to_cuda_in_parts(name, R::PRECISION, shared, length)?;
        Ok(Self {
            kernel: Kernel::load(graph, &source, device, compiler)?,
            real: PhantomData,
        })
    }

    /// Numbers of values that it reads and writes for each state.
    pub fn sizes(&self) -> CudaSizes {
        self.kernel.sizes
    }

    /// Computes the outputs of many states on the device. Returns before the work is done; a download waits for it.
    ///
    /// * `inputs` – those of each state that are not shared, in the order of the graph
    /// * `outputs` – output; invalid where the status is not 0
    /// * `status` – output; its length is the number of states
    ///
    /// # Errors
    /// If an array has the wrong length or is on another device, the device has too little memory for the workspace, or the driver fails.
    pub fn call(
        &self,
        inputs: &Numbers<R>,
        shared: &Numbers<R>,
        outputs: &mut Numbers<R>,
        status: &mut Status,
    ) -> Result<(), CudaError> {
        let batch = Batch {
            inputs,
            shared,
            outputs,
            status,
        };
        batch.launch(&self.kernel)
    }

    /// Computes the outputs of `count` states with inputs and outputs on the host.
    ///
    /// * `inputs` – those of one state after the other
    ///
    /// # Errors
    /// If there are no states, a slice has the wrong length, the device has too little memory, or the driver fails.
    pub fn call_states(
        &self,
        count: usize,
        inputs: &[R],
        shared: &[R],
    ) -> Result<Outputs<R>, CudaError> {
        let (device, sizes) = (&self.kernel.device, self.kernel.sizes);
        let mut status = Status::new(device, count)?;
        let inputs = Numbers::from_states(device, sizes.inputs, count, inputs)?;
        let shared = Numbers::from_states(device, sizes.shared, 1, shared)?;
        let mut outputs = Numbers::zeros(device, sizes.outputs, count)?;
        self.call(&inputs, &shared, &mut outputs, &mut status)?;
        Ok(Outputs {
            numbers: outputs.download_states()?,
            status: status.found()?,
        })
    }

    /// The condition of a status, in words; empty if the status belongs to no condition.
    pub fn condition(&self, status: i32) -> &str {
        self.kernel.condition(status)
    }

    /// Checks that the function was recorded from a robot, and that the robot has not changed since.
    ///
    /// # Errors
    /// If it is of another robot, or a parameter of the robot has changed.
    pub fn check_robot(&self, model: &Model) -> Result<(), CudaError> {
        self.kernel.check_robot(model)
    }
}
