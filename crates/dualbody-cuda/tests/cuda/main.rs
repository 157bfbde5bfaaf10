//! Kernels beside the library.
//!
//! Their text is compiled as C and run on the CPU, where a compiler `cc` is there; it is compiled to machine code of GPUs, where NVRTC is there; and
//! run on a GPU, where there is a driver. A part that is missing is reported, and its tests are skipped.

mod checks;
#[path = "../../../../tests/it/common/mod.rs"]
#[allow(dead_code, unused_imports, reason = "most of it serves other tests")]
mod common;
mod errors;
mod gpu;
mod host;
mod machine;
mod machine_code;
mod ranges;
mod text;
