//! Expression graphs and generated C of every robot beside the library. They are here, where the functions that trace robots are compiled anyway.

mod codegen;
#[path = "../../../../tests/it/common/mod.rs"]
#[allow(dead_code, unused_imports, reason = "most of it serves other tests")]
mod common;
mod contact;
mod functions;
mod traced;
