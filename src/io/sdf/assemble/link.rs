//! Links with their inertia and shapes.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::Assembly;
use crate::error::LoadError;
use crate::io::place::SourcePlace;
use crate::io::sdf::scene::{Inertial, MassEntry, Pose, Shape};
use crate::model::{Collision, LinkSpec, Mass, Visual, inertia_flaw};
use crate::spatial::{Inertia, Transform};

impl Assembly<'_, '_> {
    /// Adds a link.
    pub(super) fn link(&mut self, index: usize) -> Result<(), LoadError> {
        let link = &self.scene.links[index];
        let inertia = self.inertia(index)?;
        if let Some(flaw) = inertia_flaw(&inertia) {
            self.context.warn(&link.inertial.place, flaw.to_string());
        }
        let mut spec = LinkSpec::new(self.link_name(Some(index))).with_inertia(inertia);
        if !link.has_gravity {
            spec = spec.without_gravity();
        }
        for shape in &link.visuals {
            spec = spec.with_visual(Visual {
                name: shape.name.clone(),
                placement: self.shape_placement(index, shape)?,
                geometry: shape.geometry.clone(),
                color: shape.color,
            });
        }
        for shape in &link.collisions {
            spec = spec.with_collision(Collision {
                name: shape.name.clone(),
                placement: self.shape_placement(index, shape)?,
                geometry: shape.geometry.clone(),
            });
        }
        let bitmasks = link.collisions.iter().map(|shape| shape.bitmask);
        if bitmasks.clone().any(|own| own.is_some()) {
            spec.collide_bitmasks = bitmasks.map(|own| own.unwrap_or(u16::MAX)).collect();
        }
        let at = self.scene.frames[link.frame].place.position.clone();
        self.builder.set_position(false, &spec.name, at);
        self.builder.add_link(spec);
        Ok(())
    }

    fn shape_placement(&self, link: usize, shape: &Shape) -> Result<Transform<f64>, LoadError> {
        let place = &self.scene.frames[self.scene.links[link].frame].place;
        self.in_link(link, &shape.pose, place)
    }

    /// The inertia of a link in its own frame.
    fn inertia(&mut self, index: usize) -> Result<Inertia<f64>, LoadError> {
        let link = &self.scene.links[index];
        let Inertial { mass, place } = &link.inertial;
        let default = match mass {
            MassEntry::Given { pose, inertia } => {
                return Ok(self.in_link(index, pose, place)?.inertia(inertia));
            }
            MassEntry::Solid { density } => *density,
        };
        let mut sum = Inertia::zero();
        for shape in &link.collisions {
            let density = Mass::Density(shape.density.unwrap_or(default));
            let X_LS = self.in_link(index, &shape.pose, place)?;
            match shape.geometry.inertia(density) {
                Some(inertia) => sum = sum + X_LS.inertia(&inertia),
                None => {
                    let reason = "auto: meshes are not read and add no mass";
                    self.context.warn(place, reason);
                }
            }
        }
        if sum == Inertia::zero() {
            let reason = "auto: the link has no solid collision, so no mass";
            self.context.warn(place, reason);
        }
        Ok(sum)
    }

    fn in_link(
        &self,
        link: usize,
        pose: &Pose,
        place: &SourcePlace,
    ) -> Result<Transform<f64>, LoadError> {
        self.placements.in_link(self.scene, link, pose, place)
    }
}
