//! The structs of XLA's interface for foreign functions, version 0, as `xla/ffi/api/c_api.h` has them.
//!
//! XLA keeps the layout of version 0 and adds fields at the end only. Fields that are not read here are left out, or have no type.

use std::ffi::{c_char, c_int, c_void};

/// Version of the interface that is spoken: what is read here has been there since its first.
pub(super) const VERSION: (c_int, c_int) = (0, 1);

/// Kind of the extension by which XLA asks for the version.
pub(super) const METADATA: c_int = 1;

/// Stage in which the function is to run.
pub(super) const EXECUTE: c_int = 3;

/// Kind of an attribute that is a text.
pub(super) const STRING: c_int = 4;

/// Code of an error in an argument.
pub(super) const INVALID_ARGUMENT: c_int = 3;

/// Types of numbers.
pub(super) const F32: c_int = 11;
pub(super) const F64: c_int = 12;

#[repr(C)]
pub(super) struct Extension {
    pub(super) struct_size: usize,
    pub(super) kind: c_int,
    pub(super) next: *mut Extension,
}

#[repr(C)]
pub(super) struct ApiVersion {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) major: c_int,
    pub(super) minor: c_int,
}

#[repr(C)]
pub(super) struct Metadata {
    pub(super) struct_size: usize,
    pub(super) version: ApiVersion,
    pub(super) traits: u32,
}

#[repr(C)]
pub(super) struct MetadataExtension {
    pub(super) base: Extension,
    pub(super) metadata: *mut Metadata,
}

#[repr(C)]
pub(super) struct ErrorArguments {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) message: *const c_char,
    pub(super) code: c_int,
}

#[repr(C)]
pub(super) struct Api {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) version: ApiVersion,
    pub(super) internal: *const c_void,
    pub(super) create_error: unsafe extern "C" fn(*mut ErrorArguments) -> *mut c_void,
}

#[repr(C)]
pub(super) struct Buffer {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) kind: c_int,
    pub(super) data: *mut c_void,
    pub(super) rank: i64,
    pub(super) lengths: *const i64,
}

/// Arguments, or results.
#[repr(C)]
pub(super) struct Buffers {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) count: i64,
    pub(super) kinds: *const c_int,
    pub(super) buffers: *const *const Buffer,
}

#[repr(C)]
pub(super) struct Text {
    pub(super) start: *const u8,
    pub(super) length: usize,
}

#[repr(C)]
pub(super) struct Attributes {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) count: i64,
    pub(super) kinds: *const c_int,
    pub(super) names: *const *const Text,
    pub(super) values: *const *const c_void,
}

#[repr(C)]
pub(super) struct CallFrame {
    pub(super) struct_size: usize,
    pub(super) extension: *mut Extension,
    pub(super) api: *const Api,
    pub(super) context: *mut c_void,
    pub(super) stage: c_int,
    pub(super) arguments: Buffers,
    pub(super) results: Buffers,
    pub(super) attributes: Attributes,
}
