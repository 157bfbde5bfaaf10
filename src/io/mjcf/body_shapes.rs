//! Shapes of bodies: shown, and in contact.

use super::body::Bodies;
use super::geom::Geom;
use super::scene::MjcfGeom;
use super::walk::Part;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::io::place::SourcePlace;
use crate::model::{Collision, Visual};
use crate::spatial::Transform;

impl Bodies {
    /// Reads a geom and adds its shape to a body.
    pub(super) fn geom(
        &mut self,
        part: &Part<'_, '_>,
        index: usize,
        context: &mut Context<'_>,
    ) -> Result<Geom, LoadError> {
        let source = part.source;
        let entry = part.entry(&["geom"])?;
        let mut geom = Geom::read(&entry, &source.compiler, &source.assets)?;
        geom.contact.name = part.name();
        let contact = &geom.contact;
        let differs = |first: Option<&MjcfGeom>| first.is_some_and(|own| !own.is_like(contact));
        if differs(self.entries[index].contacts.first()) && geom.touches() {
            let first = || (part.node.place(), 0);
            self.unmodelled.get_or_insert_with(first).1 += 1;
        }
        self.shape(&geom, part.X * geom.X, index, &part.node.place(), context);
        Ok(geom)
    }

    /// Adds a shape to a body.
    fn shape(
        &mut self,
        geom: &Geom,
        placement: Transform<f64>,
        index: usize,
        place: &SourcePlace,
        context: &mut Context<'_>,
    ) {
        let Some(geometry) = geom.geometry().cloned() else {
            self.scene_shape(geom, placement, index, place, context);
            return;
        };
        let name = geom.contact.name.clone();
        let body = &mut self.entries[index];
        if geom.is_shown() {
            body.visuals.push(Visual {
                name: name.clone(),
                placement,
                geometry: geometry.clone(),
                color: geom.color,
            });
        }
        let collision = Collision {
            name,
            placement,
            geometry,
        };
        if geom.touches() {
            body.collisions.push(collision);
            body.contacts.push(geom.contact.clone());
        } else if collision.name.is_some() {
            body.idle.push((collision, geom.contact.clone()));
        }
    }
}
