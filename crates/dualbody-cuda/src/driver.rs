//! Calls of the driver that Rust cannot check, except starts of kernels.

#![expect(
    unsafe_code,
    reason = "foreign functions can be called in no other way"
)]

use cudarc::driver::{CudaContext, CudaSlice, CudaStream, DriverError};
use std::sync::Arc;

/// Whether there is a driver.
pub(crate) fn has_driver() -> bool {
    // SAFETY: loads a library of the system by its name, whose start code is the driver's own.
    unsafe { cudarc::driver::sys::is_culib_present() }
}

/// Leaves the order of work to the stream of a device, instead of an event for each array of each kernel.
pub(crate) fn order_by_stream(context: &CudaContext) {
    // SAFETY: an array is used in the stream that it was allocated in and no other, which each call checks (`Device::owns`), and freed in that one.
    unsafe { context.disable_event_tracking() };
}

/// Memory that kernels write before they read it. It is free again when earlier work has been done.
pub(crate) fn uninitialized(
    stream: &Arc<CudaStream>,
    bytes: usize,
) -> Result<CudaSlice<u8>, DriverError> {
    // SAFETY: bytes may have any bits, and only kernels read them, after they have written them.
    unsafe { stream.alloc(bytes.max(1)) }
}
