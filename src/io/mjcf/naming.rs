//! Names of parts that are there several times, or come from another model.

use std::rc::Rc;

/// The prefix of attached models and the suffix of replicas.
#[derive(Clone, Debug)]
pub(super) struct Naming {
    prefix: Rc<str>,
    suffix: Rc<str>,
    is_attached: bool,
}

impl Naming {
    /// Names as the file has them.
    pub(super) fn plain() -> Self {
        Self {
            prefix: "".into(),
            suffix: "".into(),
            is_attached: false,
        }
    }

    /// Names in an attached model.
    pub(super) fn attached(&self, prefix: &str) -> Self {
        Self {
            prefix: format!("{}{prefix}", self.prefix).into(),
            suffix: self.suffix.clone(),
            is_attached: true,
        }
    }

    /// Names in a replica: its number comes before those of the replicas around it.
    pub(super) fn replica(&self, number: &str) -> Self {
        Self {
            prefix: self.prefix.clone(),
            suffix: format!("{number}{}", self.suffix).into(),
            is_attached: self.is_attached,
        }
    }

    /// `true` for parts of attached models.
    pub(super) fn is_attached(&self) -> bool {
        self.is_attached
    }

    /// Bytes that it adds to a name.
    pub(super) fn len(&self) -> usize {
        self.prefix.len() + self.suffix.len()
    }

    /// The name of a part.
    pub(super) fn of(&self, name: &str) -> String {
        format!("{}{name}{}", self.prefix, self.suffix)
    }
}
