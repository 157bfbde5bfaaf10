//! Reasons why a kernel is not compiled, loaded or run.

use dualbody::UnknownName;
use dualbody::codegen::{CodeError, OtherRobot};
use dualbody_cache::FileError;

/// Error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CudaError {
    /// There is no driver.
    #[error("there is no CUDA driver: none of {} was found on the library path of the system; install the driver of an NVIDIA GPU", .searched.join(", "))]
    NoDriver {
        /// Names of libraries that were looked for.
        searched: Vec<String>,
    },
    /// There is no compiler.
    #[error(
        "there is no NVRTC, which compiles kernels: none of {} was found on the library path of the system; install the CUDA toolkit, or the PyPI package nvidia-cuda-nvrtc-cu12",
        .searched.join(", ")
    )]
    NoNvrtc {
        /// Names of libraries that were looked for.
        searched: Vec<String>,
    },
    /// There is no device with this index.
    #[error("there is no device {ordinal}: the driver has {count}, counted from 0")]
    NoDevice {
        /// Number of the device, from 0.
        ordinal: usize,
        /// How many there are.
        count: usize,
    },
    /// Memory of the device does not suffice.
    #[error(
        "{bytes} bytes of memory were requested, and {free} of {total} are free on the device: use fewer states, or single precision"
    )]
    NoMemory {
        /// How much was requested.
        bytes: usize,
        /// How much is free.
        free: usize,
        /// How much there is.
        total: usize,
    },
    /// The driver fails at something else.
    #[error("the CUDA driver failed to {what}: {reason}")]
    Driver {
        /// The operation.
        what: &'static str,
        /// Reason of the driver.
        reason: String,
    },
    /// The compiler refuses a kernel or its flags.
    #[error("NVRTC refuses the kernel {kernel} with the flags {flags:?} ({reason}): {log}")]
    Refused {
        /// Name of the kernel.
        kernel: String,
        /// Flags.
        flags: Vec<String>,
        /// Name of the error.
        reason: String,
        /// Its messages.
        log: String,
    },
    /// A [`StopSignal`](dualbody::StopSignal) was set before the kernel was begun.
    #[error("a stop signal was set before the kernel {kernel} was compiled")]
    Stopped {
        /// Name of the kernel.
        kernel: String,
    },
    /// The user has no cache folder for compiled kernels.
    #[error(
        "there is no folder to keep compiled kernels in, for neither XDG_CACHE_HOME nor HOME is set: choose one by `Compiler::with_cache`"
    )]
    NoCache,
    /// A file or folder cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// An array has another length than it needs.
    #[error("{array} has {given} numbers, expected {expected}")]
    Length {
        /// The array.
        array: &'static str,
        /// Its length.
        given: usize,
        /// The length that it needs.
        expected: usize,
    },
    /// A batch has no states.
    #[error("the batch has 0 states, expected at least 1")]
    EmptyBatch,
    /// A batch, or an array for it, is larger than kernels can count.
    #[error("{what} are more than a kernel can count ({most})")]
    TooMany {
        /// The quantity that is too large.
        what: String,
        /// The most that there may be.
        most: usize,
    },
    /// A kernel, or an array, is of another kind or on another device than it must be.
    #[error("{what}")]
    Mismatch {
        /// The argument that does not fit.
        what: String,
    },
    /// The graph cannot be written as code.
    #[error(transparent)]
    Code(#[from] CodeError),
    /// The graph was made of another robot, or of one that has changed since.
    #[error(transparent)]
    OtherRobot(#[from] OtherRobot),
    /// There is no parameter with this name.
    #[error(transparent)]
    UnknownName(#[from] UnknownName),
}

/// Names under which libraries are looked for, each once.
pub(crate) fn searched(libraries: &[&str]) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for name in libraries
        .iter()
        .flat_map(|name| cudarc::get_lib_name_candidates(name))
    {
        if !out.contains(&name) {
            out.push(name);
        }
    }
    out
}

/// Checks the length of an array.
pub(crate) fn check_length(
    array: &'static str,
    given: usize,
    expected: Option<usize>,
) -> Result<(), CudaError> {
    match expected {
        Some(expected) if expected == given => Ok(()),
        Some(expected) => Err(CudaError::Length {
            array,
            given,
            expected,
        }),
        None => Err(too_many(array)),
    }
}

/// Error for sizes beyond those of memory.
pub(crate) fn too_many(what: &str) -> CudaError {
    CudaError::TooMany {
        what: format!("the numbers of {what}"),
        most: usize::MAX,
    }
}
