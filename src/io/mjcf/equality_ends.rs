//! Bodies and sites that equalities join.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::entry::Entry;
use super::equality::Reference;
use super::walk::Part;
use crate::constraint::Anchor;
use crate::dynamics::frame_pose;
use crate::error::LoadError;
use crate::spatial::Transform;

impl Reference<'_> {
    /// The two sites that an equality names, if it names sites.
    pub(super) fn sites(
        &self,
        part: &Part<'_, '_>,
        entry: &Entry<'_, '_>,
    ) -> Result<Option<[Anchor; 2]>, LoadError> {
        if entry.text("site1").is_none() && entry.text("site2").is_none() {
            return Ok(None);
        }
        let anchor = |name| {
            let text = entry.text(name).ok_or_else(|| entry.missing(name))?;
            let site = part.naming.of(text);
            let frame = self.names.sites.get(&site);
            let found = frame.and_then(|frame| Anchor::frame(self.model, frame).ok());
            // A robot with a floating base has no link for sites of the world.
            let on_world = || Some(Placed::world().anchor(*self.names.on_world.get(&site)?));
            let found = found.or_else(on_world);
            found.ok_or_else(|| entry.malformed(name, "there is no site of that name"))
        };
        Ok(Some([anchor("site1")?, anchor("site2")?]))
    }

    /// The two bodies of an equality; the second is the world where none is named.
    pub(super) fn bodies(
        &self,
        part: &Part<'_, '_>,
        entry: &Entry<'_, '_>,
    ) -> Result<[Placed; 2], LoadError> {
        let place = |name: &'static str| match entry.text(name) {
            None | Some("world") => Ok(Placed::world()),
            Some(text) => {
                let anchor = Anchor::frame(self.model, &part.naming.of(text));
                let unknown = |_| entry.malformed(name, "there is no body of that name");
                let anchor = anchor.map_err(unknown)?;
                let pose = |frame| frame_pose(self.model, self.q, frame);
                let X_WB = anchor.frame.map_or_else(Transform::identity, pose);
                Ok(Placed { anchor, X_WB })
            }
        };
        if entry.text("body1").is_none() {
            return Err(entry.missing("body1"));
        }
        Ok([place("body1")?, place("body2")?])
    }
}

/// A body with its pose in the configuration of the file.
pub(super) struct Placed {
    anchor: Anchor,
    pub(super) X_WB: Transform<f64>,
}

impl Placed {
    fn world() -> Self {
        Self {
            anchor: Anchor::world(),
            X_WB: Transform::identity(),
        }
    }

    pub(super) fn anchor(&self, X_BA: Transform<f64>) -> Anchor {
        let mut anchor = self.anchor;
        anchor.placement = X_BA;
        anchor
    }
}
