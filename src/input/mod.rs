//! Untrusted files and XML: the only module that opens files to read them.
//!
//! | quantity | bound | reason |
//! |---|---|---|
//! | kind of a file | regular | pipes and devices block, or never end |
//! | size of a description with included files, of a mesh | [`MAX_TEXT_BYTES`] | descriptions of robots have some megabytes |
//! | attributes of an element, name spaces of a file | 1000 | the parser's checks are quadratic in them |
//! | document types, entities | refused | their expansion can be arbitrarily long |
//!
//! Elements may nest to any depth: neither the parser nor the readers are recursive.

mod file;
pub(crate) mod xml;

pub(crate) use file::{MAX_TEXT_BYTES, read, read_start, reason};
