//! Starts of kernels, which Rust cannot check. Memory of the device, streams and modules are those of `cudarc`, which are safe.

#![expect(unsafe_code, reason = "kernels can be started in no other way")]

use cudarc::driver::{LaunchConfig, PushKernelArg};

use crate::error::{CudaError, check_length, too_many};
use crate::kernel::Kernel;
use crate::numbers::{Numbers, Status};
use crate::ranges::ranges;
use crate::real::Real;
use crate::workspace::THREADS;

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
        let (mut memory, most) = device.room(each, count)?;
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

/// Arrays and scalar arguments of a kernel that takes many steps.
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
