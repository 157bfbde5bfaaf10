//! Calls of the driver and of NVRTC that Rust cannot check: all unsafe code of this crate.
//!
//! Memory of the device, streams and modules are those of `cudarc`, which are safe. What is left is to ask whether the libraries are there,
//! to compile, to start kernels, and to hand arrays on.

#![expect(
    unsafe_code,
    reason = "foreign functions and kernels can be called in no other way"
)]

#[cfg(feature = "dlpack")]
pub(crate) mod dlpack;

use std::ffi::{CStr, CString, c_char};

use cudarc::driver::{CudaContext, CudaSlice, LaunchConfig, PushKernelArg};
use cudarc::nvrtc::{result, sys};

use crate::device::Device;
use crate::error::{CudaError, check_length, too_many};
use crate::kernel::Kernel;
use crate::numbers::{Numbers, Status};
use crate::ranges::ranges;
use crate::real::Real;

/// Threads of a block. Kernels take up to 255 registers of the 65,536 of a multiprocessor, so that two blocks of 128 fit at least.
pub(crate) const THREADS: u32 = 128;

/// Whether there is a driver.
pub(crate) fn has_driver() -> bool {
    // SAFETY: loads a library of the system by its name, whose start code is the driver's own.
    unsafe { cudarc::driver::sys::is_culib_present() }
}

/// Whether there is an NVRTC.
pub(crate) fn has_nvrtc() -> bool {
    // SAFETY: loads a library of the system by its name, whose start code is NVRTC's own.
    unsafe { sys::is_culib_present() }
}

/// Leaves the order of work to the stream of a device, instead of an event for each array of each kernel.
pub(crate) fn order_by_stream(context: &CudaContext) {
    // SAFETY: an array is used in the stream that it was allocated in and no other, which each call checks (`Device::owns`), and freed in that one.
    unsafe { context.disable_event_tracking() };
}

/// Version of NVRTC, which must be there.
pub(crate) fn nvrtc_version() -> Result<String, String> {
    let (mut major, mut minor) = (0, 0);
    // SAFETY: writes to two numbers, which live.
    let result = unsafe { sys::nvrtcVersion(&raw mut major, &raw mut minor) };
    checked(result)?;
    Ok(format!("{major}.{minor}"))
}

/// A text in NVRTC.
pub(crate) struct Program(sys::nvrtcProgram);

impl Program {
    /// Hands a text to NVRTC, which must be there.
    pub(crate) fn new(text: &str) -> Result<Self, String> {
        let text = CString::new(text).map_err(|_| "a zero in the text".to_owned())?;
        let program = result::create_program(&text, None);
        Ok(Self(program.map_err(|error| error.to_string())?))
    }

    /// Compiles it, for what the flags name.
    pub(crate) fn compile(&self, flags: &[String]) -> Result<(), String> {
        // SAFETY: the program is one that NVRTC has made, and lives until it is dropped.
        let compiled = unsafe { result::compile_program(self.0, flags) };
        compiled.map_err(|error| error.to_string())
    }

    /// Messages of the compiler.
    pub(crate) fn log(&self) -> String {
        // SAFETY: as in `compile`.
        let log = unsafe { result::get_program_log(self.0) }.unwrap_or_default();
        let bytes: Vec<u8> = log.into_iter().map(|c| c.cast_unsigned()).collect();
        let text = CStr::from_bytes_until_nul(&bytes).unwrap_or_default();
        text.to_string_lossy().trim().to_owned()
    }

    /// The machine code.
    pub(crate) fn image(&self) -> Result<Vec<u8>, String> {
        let mut size = 0;
        // SAFETY: as in `compile`; writes to a number, which lives.
        checked(unsafe { sys::nvrtcGetCUBINSize(self.0, &raw mut size) })?;
        let mut image = vec![0_u8; size];
        // SAFETY: as in `compile`; writes as many bytes as it has just said, and there are as many.
        checked(unsafe { sys::nvrtcGetCUBIN(self.0, image.as_mut_ptr().cast::<c_char>()) })?;
        Ok(image)
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // SAFETY: the program is one that NVRTC has made, and nobody uses it any more. There is nothing to do if that fails.
        let _ = unsafe { result::destroy_program(self.0) };
    }
}

fn checked(result: sys::nvrtcResult) -> Result<(), String> {
    result.result().map_err(|error| error.to_string())
}

/// Arrays of a kernel that computes a function of many states.
pub(crate) struct Batch<'a, R> {
    pub(crate) inputs: &'a Numbers<R>,
    pub(crate) shared: &'a Numbers<R>,
    pub(crate) outputs: &'a mut Numbers<R>,
    pub(crate) status: &'a mut Status,
}

impl<R: Real> Batch<'_, R> {
    /// Starts the kernels that were compiled from [`Graph::to_cuda`](dualbody::scalar::Graph::to_cuda) in the precision of `R`.
    pub(crate) fn launch(self, kernel: &Kernel) -> Result<(), CudaError> {
        let (device, sizes, count) = (&kernel.device, kernel.sizes, self.status.count());
        let of = |rows: usize| rows.checked_mul(count);
        check_length("inputs", self.inputs.len(), of(sizes.inputs))?;
        check_length("shared inputs", self.shared.len(), Some(sizes.shared))?;
        check_length("outputs", self.outputs.len(), of(sizes.outputs))?;
        let all = [self.inputs, self.shared, &*self.outputs];
        device.owns(all.into_iter().map(Numbers::device))?;
        device.owns([self.status.device()])?;
        let number = counted(count)?;
        let each = sizes.work.saturating_mul(size_of::<R>());
        let (mut memory, most) = device.workspace.room(device, each, count)?;
        let memory = memory.as_mut().ok_or_else(|| too_many("a workspace"))?;
        for range in ranges(count, most) {
            // Arrays without numbers have one of their own.
            let from = |len: usize| if len == 0 { 0 } else { range.start };
            let inputs = self.inputs.data.slice(from(self.inputs.len())..);
            let (outputs, status) = (&mut *self.outputs, &mut *self.status);
            let first = from(outputs.len());
            let mut out = outputs.data.slice_mut(first..);
            let mut found = status.found.slice_mut(range.start..);
            for function in &kernel.functions {
                let mut launch = device.stream.launch_builder(function);
                launch.arg(&number).arg(&inputs).arg(&self.shared.data);
                launch.arg(&mut *memory).arg(&mut out).arg(&mut found);
                // SAFETY: the text of the kernel declares these arguments in this order; it reads and writes below the lengths that were just
                // checked or allocated: of the blocks of a range none goes beyond the room, nor the last one beyond the last state. It writes to the mutable arrays only, which cannot
                // be the same.
                unsafe { launch.launch(grid(range.len())?) }
                    .map_err(device.failure("start a kernel"))?;
            }
        }
        Ok(())
    }
}

/// Arrays and numbers of a kernel that takes many steps.
pub(crate) struct Steps<'a, R> {
    pub(crate) steps: usize,
    /// Steps between two states that are kept; 0 keeps none.
    pub(crate) every: usize,
    pub(crate) fastest: R,
    pub(crate) state: &'a mut Numbers<R>,
    pub(crate) inputs: &'a Numbers<R>,
    pub(crate) each_step: &'a Numbers<R>,
    pub(crate) shared: &'a Numbers<R>,
    pub(crate) kept: &'a mut Numbers<R>,
    pub(crate) status: &'a mut Status,
}

impl<R: Real> Steps<'_, R> {
    /// Starts the kernel that was compiled from [`Graph::to_cuda_rollout`](dualbody::scalar::Graph::to_cuda_rollout) in the precision of `R`.
    pub(crate) fn launch(self, kernel: &Kernel) -> Result<(), CudaError> {
        let (device, sizes, count) = (&kernel.device, kernel.sizes, self.status.count());
        let of = |rows: usize| rows.checked_mul(count);
        let kept = self.steps.checked_div(self.every).unwrap_or(0);
        let each = |n: usize, rows: usize| n.checked_mul(rows).and_then(of);
        check_length("state", self.state.len(), of(sizes.outputs))?;
        check_length("parameters", self.inputs.len(), of(sizes.inputs))?;
        check_length(
            "inputs of the steps",
            self.each_step.len(),
            each(self.steps, sizes.each_step),
        )?;
        check_length("shared inputs", self.shared.len(), Some(sizes.shared))?;
        check_length(
            "states that are kept",
            self.kept.len(),
            each(kept, sizes.outputs),
        )?;
        let all = [
            &*self.state,
            self.inputs,
            self.each_step,
            self.shared,
            &*self.kept,
        ];
        device.owns(all.into_iter().map(Numbers::device))?;
        device.owns([self.status.device()])?;
        let (number, steps) = (counted(count)?, counted(self.steps)?);
        // A rollout is never as long as the longest distance of two kept states.
        let every = u32::try_from(self.every).unwrap_or(u32::MAX);
        let mut launch = device.stream.launch_builder(&kernel.functions[0]);
        launch
            .arg(&number)
            .arg(&steps)
            .arg(&every)
            .arg(&self.fastest)
            .arg(&mut self.state.data)
            .arg(&self.inputs.data)
            .arg(&self.each_step.data)
            .arg(&self.shared.data)
            .arg(&mut self.kept.data)
            .arg(&mut self.status.found)
            .arg(&mut self.status.taken);
        // SAFETY: the text of the kernel declares these arguments in this order; it reads and writes below the lengths that were just
        // checked, and writes to the mutable arrays only, which cannot be the same.
        unsafe { launch.launch(grid(count)?) }.map_err(device.failure("start a kernel"))?;
        Ok(())
    }
}

/// Memory for what kernels write before they read it. It is free again when the work that was handed on before has been done.
pub(crate) fn uninitialized(device: &Device, bytes: usize) -> Result<CudaSlice<u8>, CudaError> {
    // SAFETY: bytes may have any bits, and nothing but kernels reads them, after they have written them.
    let allocated = unsafe { device.stream.alloc(bytes.max(1)) };
    allocated.map_err(|error| device.no_memory::<u8>(bytes, error))
}

/// A number that kernels can count.
fn counted(number: usize) -> Result<u32, CudaError> {
    u32::try_from(number)
        .ok()
        .filter(|n| i32::try_from(*n).is_ok())
        .ok_or_else(|| CudaError::TooMany {
            what: format!("{number} states or steps"),
            most: i32::MAX as usize,
        })
}

fn grid(count: usize) -> Result<LaunchConfig, CudaError> {
    Ok(LaunchConfig {
        grid_dim: (counted(count)?.div_ceil(THREADS), 1, 1),
        block_dim: (THREADS, 1, 1),
        shared_mem_bytes: 0,
    })
}
