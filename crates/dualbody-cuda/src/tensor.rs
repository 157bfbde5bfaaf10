//! Memory handed on as tensors of `DLPack`, and copied from such, which Rust cannot check.

#![expect(unsafe_code, reason = "tensors are pointers")]

use std::ffi::c_void;

use cudarc::driver::result::memcpy_dtod_async;
use cudarc::driver::{DevicePtr, DevicePtrMut};
use dlpark::DlpackElement;
use dlpark::ffi::DLDevice;
use dlpark::metadata::Fixed;

use crate::error::CudaError;
use crate::numbers::Numbers;
use crate::real::Real;

/// A tensor of `DLPack`, version 1: the content of a capsule `dltensor_versioned` of Python, as a pointer ([`into_raw`](dlpark::Managed::into_raw)).
///
/// Dropping it, or a call of its deleter, frees its memory.
pub type Dlpack = dlpark::versioned::Dlpack;

/// Makes a tensor of `DLPack` from memory on a GPU, with the given shape, row by row. The owner is dropped with it, on any thread.
///
/// [`Numbers::into_dlpack`](crate::Numbers::into_dlpack) makes a tensor from an array of this crate.
///
/// * `address` – address of the first number, on the device
/// * `device` – index of the device, from 0
///
/// # Errors
/// If a size is too large for `DLPack`.
///
/// # Safety
/// The memory at the address must contain all numbers of the shape until the owner is dropped.
pub unsafe fn dlpack_of<R: DlpackElement, O: Send>(
    owner: O,
    address: u64,
    shape: [usize; 2],
    device: i32,
) -> Result<Dlpack, CudaError> {
    let sizes = Fixed::new(shape, [shape[1], 1]).initialize(Box::new(owner));
    let mut tensor = sizes.map_err(|error| CudaError::Mismatch {
        what: format!("an array is too large for DLPack: {error}"),
    })?;
    tensor
        .set_data(address as *mut c_void)
        .set_device(DLDevice::cuda(device))
        .set_dtype(R::DTYPE);
    // SAFETY: the caller guarantees that the numbers are there; sizes and strides are a matrix's, row by row.
    Ok(unsafe { tensor.finish() })
}

/// Hands an array on; kernels before must have run.
pub(crate) fn export<R: Real + DlpackElement>(numbers: Numbers<R>) -> Result<Dlpack, CudaError> {
    let shape = [numbers.rows(), numbers.count()];
    let device = numbers.device().number()?;
    let address = match numbers.is_empty() {
        true => 0,
        false => numbers.data.device_ptr(&numbers.device().stream).0,
    };
    // SAFETY: the array has as many numbers, and is the owner itself.
    unsafe { dlpack_of::<R, _>(numbers, address, shape, device) }
}

/// Copies a tensor, which was checked to be on the same device and to have as many numbers of this kind, without gaps, and waits for the copy.
pub(crate) fn import<R: Real>(numbers: &mut Numbers<R>, tensor: &Dlpack) -> Result<(), CudaError> {
    let (device, bytes) = (numbers.device().clone(), numbers.len() * size_of::<R>());
    if bytes == 0 {
        return Ok(());
    }
    // SAFETY: nothing writes to its fields while it is borrowed.
    let described = unsafe { tensor.tensor() };
    let from = described.data as u64 + described.byte_offset;
    let bound = device.context.bind_to_thread();
    bound.map_err(device.failure("copy a tensor"))?;
    let (to, _until_copied) = numbers.data.device_ptr_mut(&device.stream);
    // SAFETY: both have as many bytes on this device: the array its own, and the tensor those that its fields say, which are there until its deleter is called.
    let copied = unsafe { memcpy_dtod_async(to, from, bytes, device.stream.cu_stream()) };
    copied.map_err(device.failure("copy a tensor"))?;
    device.synchronize()
}
