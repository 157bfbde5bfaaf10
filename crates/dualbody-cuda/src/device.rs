//! A GPU.

use std::fmt;
use std::sync::Arc;

use cudarc::driver::{
    CudaContext, CudaSlice, CudaStream, DeviceRepr, DriverError, ValidAsZeroBits, sys,
};

use crate::architecture::Architecture;
use crate::driver;
use crate::error::{CudaError, searched, too_many};
use crate::workspace::{Room, Workspace};

/// A GPU, with the stream that runs its work in sequence. Clones refer to the same GPU.
#[derive(Clone)]
pub struct Device {
    pub(crate) context: Arc<CudaContext>,
    pub(crate) stream: Arc<CudaStream>,
    workspace: Arc<Workspace>,
}

impl Device {
    /// Opens a GPU.
    ///
    /// * `ordinal` – index of the GPU, from 0
    ///
    /// # Errors
    /// If there is no driver or no such device, or the driver fails.
    pub fn new(ordinal: usize) -> Result<Self, CudaError> {
        if !driver::has_driver() {
            return Err(CudaError::NoDriver {
                searched: searched(&["cuda", "nvcuda"]),
            });
        }
        let count = CudaContext::device_count().map_err(failure("count the devices"))?;
        let count = usize::try_from(count).unwrap_or(0);
        if ordinal >= count {
            return Err(CudaError::NoDevice { ordinal, count });
        }
        let context = CudaContext::new(ordinal).map_err(failure("open a device"))?;
        driver::order_by_stream(&context);
        let stream = context.new_stream().map_err(failure("make a stream"))?;
        Ok(Self {
            context,
            stream,
            workspace: Arc::default(),
        })
    }

    /// Its name.
    ///
    /// # Errors
    /// If the driver fails.
    pub fn name(&self) -> Result<String, CudaError> {
        self.context.name().map_err(self.failure("name a device"))
    }

    /// Architecture of its machine code.
    ///
    /// # Errors
    /// If the driver fails.
    pub fn architecture(&self) -> Result<Architecture, CudaError> {
        let found = self.context.compute_capability();
        let (major, minor) = found.map_err(self.failure("name an architecture"))?;
        Ok(Architecture::new(
            major.unsigned_abs(),
            minor.unsigned_abs(),
        ))
    }

    /// Index of the GPU for other libraries.
    ///
    /// # Errors
    /// If it exceeds their integer type.
    #[cfg(feature = "dlpack")]
    pub fn number(&self) -> Result<i32, CudaError> {
        i32::try_from(self.context.ordinal()).map_err(|_| too_many("a device"))
    }

    /// The address of its stream (a `CUstream`), for producers of tensors to wait for.
    #[cfg(feature = "dlpack")]
    pub fn stream_address(&self) -> usize {
        self.stream.cu_stream() as usize
    }

    /// Limits the workspace in which the kernels of long functions exchange values, 1 GiB by default. The device and its clones share it and keep it from
    /// call to call. Batches that need more are computed in pieces, each large enough to fill the device.
    pub fn limit_workspace(&self, bytes: usize) {
        self.workspace.set_limit(bytes);
    }

    /// Room in the workspace for states that need so many bytes each: for all of them, or for as many as fit below the limit and keep the device busy.
    pub(crate) fn room(&self, bytes: usize, count: usize) -> Result<Room<'_>, CudaError> {
        let allocate = |bytes| {
            let allocated = driver::uninitialized(&self.stream, bytes);
            allocated.map_err(|error| self.no_memory::<u8>(bytes, error))
        };
        let multiprocessors = || self.multiprocessors();
        self.workspace.room(bytes, count, multiprocessors, allocate)
    }

    /// Number of multiprocessors.
    fn multiprocessors(&self) -> Result<usize, CudaError> {
        let asked = sys::CUdevice_attribute::CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT;
        let found = self.context.attribute(asked);
        let found = found.map_err(self.failure("count multiprocessors"))?;
        Ok(usize::try_from(found).unwrap_or(0))
    }

    /// Waits until all work is done.
    ///
    /// # Errors
    /// If a part of it has failed.
    pub fn synchronize(&self) -> Result<(), CudaError> {
        let done = self.stream.synchronize();
        done.map_err(self.failure("run a kernel"))
    }

    /// Numbers of zero; there is memory behind them even if they are none.
    pub(crate) fn zeros<N: DeviceRepr + ValidAsZeroBits>(
        &self,
        len: usize,
    ) -> Result<CudaSlice<N>, CudaError> {
        let len = len.max(1);
        if len.checked_mul(size_of::<N>()).is_none() {
            return Err(too_many("an array"));
        }
        let allocated = self.stream.alloc_zeros(len);
        allocated.map_err(|error| self.no_memory::<N>(len, error))
    }

    /// The driver's error for a failed allocation of so many numbers.
    fn no_memory<N>(&self, len: usize, error: DriverError) -> CudaError {
        let bytes = len.saturating_mul(size_of::<N>());
        match (error.0, self.context.mem_get_info()) {
            (sys::CUresult::CUDA_ERROR_OUT_OF_MEMORY, Ok((free, total))) => {
                CudaError::NoMemory { bytes, free, total }
            }
            _ => failure("allocate memory")(error),
        }
    }

    /// All values of an array, after the earlier kernels have run.
    pub(crate) fn copy_back<N: DeviceRepr>(
        &self,
        numbers: &CudaSlice<N>,
    ) -> Result<Vec<N>, CudaError> {
        let copied = self.stream.clone_dtoh(numbers);
        let copied = copied.map_err(self.failure("copy numbers from the device"))?;
        self.synchronize()?;
        Ok(copied)
    }

    /// Checks that arrays are on this device.
    pub(crate) fn owns<'a>(
        &self,
        others: impl IntoIterator<Item = &'a Self>,
    ) -> Result<(), CudaError> {
        let same = |other: &Self| Arc::ptr_eq(&self.stream, &other.stream);
        if others.into_iter().all(same) {
            return Ok(());
        }
        Err(CudaError::Mismatch {
            what: "an array is on another device, or in another stream of it: clone the device, do not open it twice".to_owned(),
        })
    }

    pub(crate) fn failure(&self, what: &'static str) -> impl FnOnce(DriverError) -> CudaError {
        failure(what)
    }
}

fn failure(what: &'static str) -> impl FnOnce(DriverError) -> CudaError {
    move |error| CudaError::Driver {
        what,
        reason: format!("{error:?}"),
    }
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Device({})", self.context.ordinal())
    }
}
