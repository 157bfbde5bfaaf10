//! Files and XML that others wrote: the one place where the library opens something to read it.
//!
//! | what | bound | why |
//! |---|---|---|
//! | kind of a file | regular, not under a name that says it is empty | pipes and devices block, or never end |
//! | size of a description, of all that it includes, of a mesh | [`MAX_TEXT_BYTES`] | those of robots have some megabytes |
//! | attributes of an element, name spaces of a file | 1000 | the parser's checks are quadratic in them |
//! | document types, entities | refused | their expansion can be arbitrarily long |
//!
//! Elements may nest to any depth: the parser is not recursive, and neither are the readers behind it.

mod file;
pub(crate) mod xml;

pub(crate) use file::{MAX_TEXT_BYTES, read, read_start, reason};
