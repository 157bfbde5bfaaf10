//! Arrays on the device.

use cudarc::driver::CudaSlice;

use crate::device::Device;
use crate::error::{CudaError, check_length, too_many};
use crate::real::Real;

/// Numbers on a device: one row for each entry of a state, so that neighbouring threads read neighbouring memory.
///
/// They stay on the device between calls. Slices are copied in the order of the device ([`upload`](Self::upload), [`download`](Self::download)), or one
/// state after the other ([`upload_states`](Self::upload_states), [`download_states`](Self::download_states)), which are transposed.
#[derive(Debug)]
pub struct Numbers<R> {
    pub(crate) data: CudaSlice<R>,
    device: Device,
    rows: usize,
    count: usize,
}

impl<R: Real> Numbers<R> {
    /// Zeros.
    ///
    /// * `rows` – number of entries of a state
    /// * `count` – number of states; 1 for values that all states share
    ///
    /// # Errors
    /// If the device has no memory for them.
    pub fn zeros(device: &Device, rows: usize, count: usize) -> Result<Self, CudaError> {
        let len = rows
            .checked_mul(count)
            .ok_or_else(|| too_many("an array"))?;
        Ok(Self {
            data: device.zeros(len)?,
            device: device.clone(),
            rows,
            count,
        })
    }

    /// Numbers of one state after the other.
    ///
    /// # Errors
    /// If there are not `rows` × `count`, or the device has no memory for them.
    pub fn from_states(
        device: &Device,
        rows: usize,
        count: usize,
        numbers: &[R],
    ) -> Result<Self, CudaError> {
        let mut out = Self::zeros(device, rows, count)?;
        out.upload_states(numbers)?;
        Ok(out)
    }

    /// Number of entries of a state.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of states.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Number of all entries.
    pub fn len(&self) -> usize {
        self.rows * self.count
    }

    /// `true` if there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The device that they are on.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Copies numbers to the device in its order: entry k of state i at k × `count` + i.
    ///
    /// # Errors
    /// If the length is wrong, or the driver fails.
    pub fn upload(&mut self, numbers: &[R]) -> Result<(), CudaError> {
        check_length("the array to upload", numbers.len(), Some(self.len()))?;
        if numbers.is_empty() {
            return Ok(());
        }
        let copied = self.device.stream.memcpy_htod(numbers, &mut self.data);
        copied.map_err(self.device.failure("copy numbers to the device"))
    }

    /// Copies numbers of one state after the other to the device.
    ///
    /// # Errors
    /// If the length is wrong, or the driver fails.
    pub fn upload_states(&mut self, numbers: &[R]) -> Result<(), CudaError> {
        check_length("the array to upload", numbers.len(), Some(self.len()))?;
        self.upload(&turned(numbers, self.count, self.rows))
    }

    /// Copies all numbers back in the order of the device, after earlier kernels have run.
    ///
    /// # Errors
    /// If an earlier kernel, or the driver, has failed.
    pub fn download(&self) -> Result<Vec<R>, CudaError> {
        let mut out = vec![R::default(); self.len()];
        if !out.is_empty() {
            let view = self.data.slice(0..self.len());
            let copied = self.device.stream.memcpy_dtoh(&view, &mut out);
            copied.map_err(self.device.failure("copy numbers from the device"))?;
        }
        self.device.synchronize()?;
        Ok(out)
    }

    /// Copies all numbers back, one state after the other, after earlier kernels have run.
    ///
    /// # Errors
    /// If an earlier kernel, or the driver, has failed.
    pub fn download_states(&self) -> Result<Vec<R>, CudaError> {
        Ok(turned(&self.download()?, self.rows, self.count))
    }

    /// Copies another array of the same shape on the device.
    ///
    /// # Errors
    /// If it has another shape or is on another device, or the driver fails.
    pub fn copy_from(&mut self, other: &Self) -> Result<(), CudaError> {
        check_length("the array to copy", other.len(), Some(self.len()))?;
        self.device.owns([other.device()])?;
        let copied = self.device.stream.memcpy_dtod(&other.data, &mut self.data);
        copied.map_err(self.device.failure("copy numbers on the device"))
    }
}

/// A matrix of so many rows, row by row, as its columns in sequence.
fn turned<R: Real>(numbers: &[R], rows: usize, columns: usize) -> Vec<R> {
    let column = |j: usize| (0..rows).map(move |i| numbers[i * columns + j]);
    (0..columns).flat_map(column).collect()
}

/// Status of each state on a device, and the steps that it has taken.
#[derive(Debug)]
pub struct Status {
    pub(crate) found: CudaSlice<i32>,
    pub(crate) taken: CudaSlice<u32>,
    device: Device,
    count: usize,
}

impl Status {
    /// Status of so many states that have taken no step yet.
    ///
    /// # Errors
    /// If there are none, or the device has no memory for them.
    pub fn new(device: &Device, count: usize) -> Result<Self, CudaError> {
        if count == 0 {
            return Err(CudaError::EmptyBatch);
        }
        Ok(Self {
            found: device.zeros(count)?,
            taken: device.zeros(count)?,
            device: device.clone(),
            count,
        })
    }

    /// Number of states.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The device that they are on.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Status of each state, after earlier kernels have run: 0, the index k, from 1, of the first violated
    /// [condition](dualbody::scalar::Graph::conditions), −1 if a number is not finite or the motion has diverged, or −2 at an input that is not finite.
    ///
    /// # Errors
    /// If an earlier kernel, or the driver, has failed.
    pub fn found(&self) -> Result<Vec<i32>, CudaError> {
        self.device.copy_back(&self.found)
    }

    /// Steps that each state has taken.
    ///
    /// # Errors
    /// If an earlier kernel, or the driver, has failed.
    pub fn taken(&self) -> Result<Vec<u32>, CudaError> {
        self.device.copy_back(&self.taken)
    }
}
