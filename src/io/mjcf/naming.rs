//! Names of parts that are there several times, or come from another model.

use std::rc::Rc;

/// The prefix of attached models and the suffix of replicas.
#[derive(Clone, Debug)]
pub(super) struct Naming {
    prefix: Rc<str>,
    suffix: Rc<str>,
    /// The replicas that it is in, from the outermost on: element and number of each. Empty outside of replicas.
    replicas: Rc<[[usize; 2]]>,
    /// References to parts outside of the replicas.
    outside: Rc<[Box<str>]>,
    is_attached: bool,
}

impl Naming {
    /// Names as the file has them.
    pub(super) fn plain() -> Self {
        Self {
            prefix: "".into(),
            suffix: "".into(),
            replicas: Rc::default(),
            outside: Rc::default(),
            is_attached: false,
        }
    }

    /// Names in an attached model.
    pub(super) fn attached(&self, prefix: &str) -> Self {
        Self {
            prefix: format!("{}{prefix}", self.prefix).into(),
            suffix: self.suffix.clone(),
            replicas: self.replicas.clone(),
            outside: Rc::default(),
            is_attached: true,
        }
    }

    /// Names in a replica: its number comes before those of the replicas around it.
    ///
    /// * `at` – index of the element and number of the replica
    pub(super) fn replica(&self, number: &str, at: [usize; 2]) -> Self {
        Self {
            prefix: self.prefix.clone(),
            suffix: format!("{number}{}", self.suffix).into(),
            replicas: self.replicas.iter().copied().chain([at]).collect(),
            outside: Rc::default(),
            is_attached: self.is_attached,
        }
    }

    /// The replicas that it is in: their order is that of the parts in them.
    pub(super) fn replicas(&self) -> &[[usize; 2]] {
        &self.replicas
    }

    /// Whether it is that of a replica inside of another one, or of the description.
    pub(super) fn is_within(&self, other: &Self) -> bool {
        self.prefix == other.prefix && self.replicas.starts_with(&other.replicas)
    }

    /// The name of a part without the numbers of replicas.
    pub(super) fn common(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }

    /// `true` for parts of attached models.
    pub(super) fn is_attached(&self) -> bool {
        self.is_attached
    }

    /// Bytes that it adds to a name, and those that it takes itself.
    pub(super) fn len(&self) -> usize {
        self.prefix.len() + self.suffix.len() + size_of_val(&*self.replicas)
    }

    /// The same, where these references are to parts outside of the replicas.
    pub(super) fn with_outside(&self, outside: impl Iterator<Item = Box<str>>) -> Self {
        Self {
            outside: outside.collect(),
            ..self.clone()
        }
    }

    /// The name of a part.
    pub(super) fn own(&self, name: &str) -> String {
        format!("{}{name}{}", self.prefix, self.suffix)
    }

    /// The name of a part that an element refers to.
    pub(super) fn of(&self, name: &str) -> String {
        match self.outside.iter().any(|own| **own == *name) {
            true => self.common(name),
            false => self.own(name),
        }
    }
}
