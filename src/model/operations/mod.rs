//! Operations on a description: lock joints, attach robots, add parts, change masses, scale.
//!
//! Each operation changes a [`ModelBuilder`] in place; a corresponding function of [`Model`](super::Model) builds a new model. Operations remove
//! nothing except degrees of freedom.

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
