//! Names that are made up so that none is there twice.

use std::collections::HashSet;

/// Names that are taken, and new ones.
#[derive(Debug)]
pub(super) struct Names(HashSet<String>);

impl Names {
    /// Names that are taken.
    pub(super) fn of<'a>(names: impl Iterator<Item = &'a str>) -> Self {
        Self(names.map(Into::into).collect())
    }

    /// Takes a name, if it is new.
    pub(super) fn take_new(&mut self, name: &str) -> bool {
        self.0.insert(name.to_owned())
    }

    /// The name, or the name with as many underscores as it takes to be new.
    pub(super) fn fresh(&mut self, name: impl Into<String>) -> String {
        let mut name = name.into();
        while !self.0.insert(name.clone()) {
            name.push('_');
        }
        name
    }
}
