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

/// Structs as C has them.
macro_rules! structs {
    ($($(#[$doc:meta])* $name:ident { $($field:ident: $type:ty),* })*) => { $(
        $(#[$doc])*
        #[repr(C)]
        pub(super) struct $name {
            $(pub(super) $field: $type),*
        }
    )* };
}

structs! {
    Extension { struct_size: usize, kind: c_int, next: *mut Extension }
    ApiVersion { struct_size: usize, extension: *mut Extension, major: c_int, minor: c_int }
    Metadata { struct_size: usize, version: ApiVersion, traits: u32 }
    MetadataExtension { base: Extension, metadata: *mut Metadata }
    ErrorArguments { struct_size: usize, extension: *mut Extension, message: *const c_char, code: c_int }
    Api {
        struct_size: usize, extension: *mut Extension,
        version: ApiVersion, internal: *const c_void, create_error: unsafe extern "C" fn(*mut ErrorArguments) -> *mut c_void
    }
    Buffer { struct_size: usize, extension: *mut Extension, kind: c_int, data: *mut c_void, rank: i64, lengths: *const i64 }
    /// Arguments, or results.
    Buffers { struct_size: usize, extension: *mut Extension, count: i64, kinds: *const c_int, buffers: *const *const Buffer }
    Text { start: *const u8, length: usize }
    Attributes {
        struct_size: usize, extension: *mut Extension, count: i64,
        kinds: *const c_int, names: *const *const Text, values: *const *const c_void
    }
    CallFrame {
        struct_size: usize, extension: *mut Extension, api: *const Api, context: *mut c_void,
        stage: c_int, arguments: Buffers, results: Buffers, attributes: Attributes
    }
}
