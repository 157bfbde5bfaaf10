//! Arrays of other packages on the GPU, by the protocol of `DLPack`.

use dlpark::DlpackFlags;
use dlpark::ffi::DLDevice;
use dlpark::python::{DlpackStream, ExportRequest, ImportRequest, ImportedDlpack, StreamArg};
use dualbody_cuda::{Device, Dlpack};
use pyo3::exceptions::{PyBufferError, PyTypeError};

use crate::prelude::*;

/// The stream of a device, whose work waits for a producer's.
struct Stream<'a>(&'a Device);

// SAFETY: the address is that of the device's own stream, which lives as long as the device.
#[allow(unsafe_code)]
unsafe impl DlpackStream for Stream<'_> {
    fn as_python_arg(&self, py: Python<'_>, _: DLDevice) -> PyResult<StreamArg> {
        let address = self.0.stream_address().into_pyobject(py)?;
        Ok(StreamArg::from_python_object(address.into_any().unbind()))
    }
}

/// The device as DLPack counts.
pub(super) fn place(device: &Device) -> PyResult<DLDevice> {
    device.number().map(DLDevice::cuda).or_raise()
}

/// The tensor of an argument, which work of the device after this call may read.
pub(super) fn read(name: &str, array: &Bound<'_, PyAny>, device: &Device) -> PyResult<Dlpack> {
    if !array.hasattr("__dlpack__")? {
        return Err(PyTypeError::new_err(format!(
            "{name} is no array that other packages can read: it has no __dlpack__"
        )));
    }
    let request = ImportRequest::new(array.as_borrowed())?;
    // What is not on a GPU knows no streams, and would say only that.
    let here = place(device)?.device_type;
    if request
        .device()
        .is_ok_and(|found| found.device_type != here)
    {
        refuse!("{name} is not on a GPU; step and rollout take arrays of NumPy");
    }
    match request.import(Some(&Stream(device)), None)? {
        ImportedDlpack::Versioned(tensor) => Ok(tensor),
        ImportedDlpack::Legacy(_) => Err(PyTypeError::new_err(format!(
            "{name} is from a package with DLPack before version 1.0; a later version of the package is needed"
        ))),
    }
}

/// A capsule with a tensor made for it.
pub(super) fn write(
    py: Python<'_>,
    request: &ExportRequest<'_>,
    device: &Device,
    make: impl FnOnce() -> PyResult<Dlpack>,
) -> PyResult<Py<PyAny>> {
    let older = || {
        Err(PyBufferError::new_err(
            "states are passed on by DLPack 1.0 or later: max_version is older or missing",
        ))
    };
    request.export_zero_copy(py, place(device)?, DlpackFlags::empty(), older, make)
}
