//! The writer of C.

mod body;
mod expression;
mod header;
mod names;
mod parts;
mod precision;
mod source;

pub use names::CodeError;
pub use precision::Precision;
pub use source::Source;
