//! Operations on a description: lock joints, join robots, add parts, change masses, scale.
//!
//! Each works on a [`ModelBuilder`] in place; each has a twin on [`Model`](super::Model) that builds a new one. Nothing
//! is removed but the freedom of joints.

mod attach;
mod edit;
mod lock;
mod scale;

pub(super) use attach::ATTACHMENT;
pub(super) use edit::positive;

use super::ModelBuilder;
use crate::error::UnknownName;

impl ModelBuilder {
    pub(super) fn unknown<'a>(
        &self,
        element: &str,
        name: &str,
        known: impl Iterator<Item = &'a str>,
    ) -> UnknownName {
        UnknownName {
            model: self.name.clone(),
            element: element.into(),
            name: name.into(),
            known: known.map(Into::into).collect(),
        }
    }

    fn joint_index(&self, name: &str) -> Result<usize, UnknownName> {
        let found = self.joints.iter().position(|joint| joint.name == name);
        found.ok_or_else(|| {
            let names = self.joints.iter().map(|joint| joint.name.as_str());
            self.unknown("joint", name, names)
        })
    }

    pub(super) fn link_index(&self, name: &str) -> Result<usize, UnknownName> {
        let found = self.links.iter().position(|link| link.name == name);
        found.ok_or_else(|| {
            let names = self.links.iter().map(|link| link.name.as_str());
            self.unknown("link", name, names)
        })
    }
}
