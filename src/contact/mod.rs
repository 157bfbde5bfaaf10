//! Contact: laws that know no model.

pub mod cone;
