//! Planes and height fields: the ground, and the scenery beside it.

use super::body::Bodies;
use super::geom::{Geom, Shape};
use super::height_field::{HeightAsset, is_level};
use super::scene::MjcfGeom;
use super::scenery::{MOST_TRIANGLES, Scenery};
use super::touching::terrain;
use crate::io::context::Context;
use crate::io::place::SourcePlace;
use crate::spatial::Transform;

impl Bodies {
    /// Planes and height fields of the world are its ground and scenery; other shapes are not supported.
    pub(super) fn scene_shape(
        &mut self,
        geom: &Geom,
        placement: Transform<f64>,
        index: usize,
        place: &SourcePlace,
        context: &mut Context<'_>,
    ) {
        match &geom.shape {
            Shape::Plane | Shape::Heights(_) if index > 0 => {
                let reason = "planes and height fields touch on the world only, and not on a body";
                context.ignore(place, reason);
            }
            Shape::Plane => {
                let faces_up = terrain(&placement).is_some();
                if self.lacks_ground() && faces_up {
                    self.ground = Some((placement, geom.contact.clone()));
                    self.heights = None;
                } else if geom.touches() {
                    let plane = Scenery::Plane(placement);
                    self.scenery.push((plane, geom.contact.clone()));
                }
            }
            Shape::Heights(heights) => {
                if let Err(reason) = self.heights(heights, placement, geom) {
                    context.ignore(place, reason);
                }
            }
            Shape::None(reason) => context.ignore(place, reason),
            Shape::Simple(_) | Shape::Mesh(_) => {}
        }
    }

    /// Whether the file has no ground that touches geoms, by its own flags or as part of a pair.
    fn lacks_ground(&self) -> bool {
        let is_idle = |own: &MjcfGeom| (own.contype, own.conaffinity) == (0, 0);
        let ground = self.ground.as_ref();
        ground.is_none_or(|(_, own)| is_idle(own) && own.name.is_none())
    }

    /// A height field is the ground if it is the first and level.
    fn heights(
        &mut self,
        heights: &HeightAsset,
        placement: Transform<f64>,
        geom: &Geom,
    ) -> Result<(), String> {
        if self.lacks_ground() && is_level(&placement) {
            self.heights = Some(heights.at(&placement)?);
            self.ground = Some((placement, geom.contact.clone()));
        } else if geom.touches() {
            let own = Scenery::Heights(heights.surface(&placement)?);
            let all = self.scenery.iter().map(|(own, _)| own.shapes());
            if all.sum::<usize>() + own.shapes() > MOST_TRIANGLES {
                return Err(format!(
                    "height fields beside the ground have more than {MOST_TRIANGLES} triangles"
                ));
            }
            self.scenery.push((own, geom.contact.clone()));
        }
        Ok(())
    }

    /// Remarks on what no contact here has.
    pub(super) fn note_unmodelled(&self, context: &mut Context<'_>) {
        let reason = "friction, margin, solref, solimp: all geoms of a link touch the ground as its first one, with the largest friction and margin";
        if let Some((place, times)) = &self.unmodelled {
            let reason = match times {
                1 => reason.to_owned(),
                _ => format!("{reason}; {times} geoms, first here"),
            };
            context.ignore(place, reason);
        }
    }
}
