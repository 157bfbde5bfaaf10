//! Times on the device.

use std::fmt;

use cudarc::driver::CudaEvent;
use cudarc::driver::sys::CUevent_flags::CU_EVENT_DEFAULT;

use crate::device::Device;
use crate::error::CudaError;

/// A point in the sequence of work of a device: all earlier work is done, and no later work has begun ([`Device::moment`]).
pub struct Moment {
    event: CudaEvent,
    device: Device,
}

impl Device {
    /// Marks a point in the sequence of work of the device, to measure times on the device itself.
    ///
    /// # Errors
    /// If the driver fails.
    pub fn moment(&self) -> Result<Moment, CudaError> {
        let event = self.stream.record_event(Some(CU_EVENT_DEFAULT));
        Ok(Moment {
            event: event.map_err(self.failure("mark a moment"))?,
            device: self.clone(),
        })
    }
}

impl Moment {
    /// The time from an earlier moment of the same device to this one, s. Waits for both.
    ///
    /// # Errors
    /// If earlier work has failed.
    pub fn since(&self, earlier: &Self) -> Result<f64, CudaError> {
        let milliseconds = earlier.event.elapsed_ms(&self.event);
        let milliseconds = milliseconds.map_err(self.device.failure("measure a time"))?;
        Ok(f64::from(milliseconds) * 1e-3)
    }
}

impl fmt::Debug for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Moment({:?})", self.device)
    }
}
