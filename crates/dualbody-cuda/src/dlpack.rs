//! Arrays as tensors of `DLPack`, which other libraries take, and give, without a way over the host.

use dlpark::ffi::DLDevice;
use dlpark::{DlpackElement, TensorRef};

use crate::error::CudaError;
use crate::numbers::{Numbers, Status};
use crate::real::Real;
use crate::states::CudaStates;
use crate::tensor::{self, Dlpack};

impl<R: Real + DlpackElement> Numbers<R> {
    /// Converts the array, without a copy, to a tensor of `rows` × `count` numbers on its device: a row for each entry of a state. Waits for earlier
    /// kernels, so that any stream may read it.
    ///
    /// # Errors
    /// If an earlier kernel, or the driver, has failed.
    pub fn into_dlpack(self) -> Result<Dlpack, CudaError> {
        self.device().synchronize()?;
        tensor::export(self)
    }

    /// Copies the entries of a tensor on the same device, of `rows` × `count` numbers, row by row. The computation of the tensor must have ended; the copy has ended when this
    /// returns.
    ///
    /// # Errors
    /// If it is on another device, has another shape, another element type, or gaps, or the driver fails.
    pub fn copy_from_dlpack(&mut self, tensor: &Dlpack) -> Result<(), CudaError> {
        let device = self.device().number()?;
        let shape = [self.rows(), self.count()];
        check_dlpack::<R>(tensor, shape, device)?;
        tensor::import(self, tensor)
    }
}

impl<R: Real + DlpackElement> CudaStates<R> {
    /// A copy of all states as a tensor on the device: a row for each entry of a state (q, v, contact state), a column for each state.
    ///
    /// # Errors
    /// If an earlier kernel, or the driver, has failed.
    pub fn to_dlpack(&self) -> Result<Dlpack, CudaError> {
        let own = &self.numbers;
        let mut copy = Numbers::zeros(own.device(), own.rows(), own.count())?;
        copy.copy_from(own)?;
        copy.into_dlpack()
    }

    /// Replaces all states by those of a tensor in the format of [`to_dlpack`](Self::to_dlpack). Their endings are cleared: all states continue.
    ///
    /// # Errors
    /// As [`Numbers::copy_from_dlpack`].
    pub fn copy_from_dlpack(&mut self, tensor: &Dlpack) -> Result<(), CudaError> {
        self.numbers.copy_from_dlpack(tensor)?;
        self.status = Status::new(self.numbers.device(), self.len())?;
        Ok(())
    }
}

/// Checks that a tensor is on a device of CUDA, and has the shape `shape` and the given element type, row by row. It needs no GPU.
///
/// * `device` – index of the device, from 0
///
/// # Errors
/// If not, with its actual type.
pub fn check_dlpack<R: DlpackElement>(
    tensor: &Dlpack,
    shape: [usize; 2],
    device: i32,
) -> Result<(), CudaError> {
    let found: TensorRef<'_> = match tensor.validate() {
        Ok(found) => found,
        Err(error) => return Err(mismatch(&format!("is not a DLPack array: {error}"))),
    };
    if found.device() != DLDevice::cuda(device) {
        let (kind, number) = found.device().into();
        return Err(mismatch(&format!(
            "is on device {number} of kind {kind}, not on device {device} of CUDA"
        )));
    }
    if found.dtype() != R::DTYPE {
        let (found, own) = (found.dtype(), R::DTYPE);
        return Err(mismatch(&format!("has numbers {found:?}, not {own:?}")));
    }
    let sizes = found.shape().iter().map(|&n| usize::try_from(n).ok());
    if !sizes.eq(shape.map(Some)) {
        let what = format!("has the shape {:?}, not {shape:?}", found.shape());
        return Err(mismatch(&what));
    }
    match found.is_compact() {
        Ok(true) => Ok(()),
        _ => Err(mismatch("has gaps, or is stored column by column")),
    }
}

fn mismatch(what: &str) -> CudaError {
    CudaError::Mismatch {
        what: format!("the tensor {what}"),
    }
}
