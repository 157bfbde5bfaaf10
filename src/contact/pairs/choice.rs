//! Which shapes of a robot or a world can touch each other.

use std::sync::Arc;

use crate::collision::Surface;
use crate::contact::laws::ContactLaw;
use crate::contact::shape_pairs::ShapePairs;
use crate::contact::{Contacts, LinkShapes, Material};
use crate::error::UnknownName;
use crate::model::Model;
use crate::numbers::Numbers as _;

/// Which links collide with each other, and of which material they are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CollisionOptions {
    /// Whether links of one robot collide, too; those that a joint connects never do.
    pub self_collision: bool,
    /// Links that do not collide, by name.
    pub excluded: Vec<[String; 2]>,
    /// Materials of the shapes of links, by name of the link; those of other links are that of the contact law.
    pub materials: Vec<(String, Material)>,
    /// Meshes of triangles on links that are fixed to the world, by name of the link.
    pub surfaces: Vec<(String, Arc<Surface>)>,
    /// Whether relaxed rigid contact meets what would arrive within a step: see [`with_speculative_contact`](Self::with_speculative_contact).
    pub speculative: bool,
}

impl CollisionOptions {
    /// Lets links of one robot collide, too.
    #[must_use]
    pub fn with_self_collision(mut self) -> Self {
        self.self_collision = true;
        self
    }

    /// Excludes a pair of links.
    #[must_use]
    pub fn without(mut self, first: &str, second: &str) -> Self {
        self.excluded.push([first.to_owned(), second.to_owned()]);
        self
    }

    /// Adds a mesh of triangles to a link that is fixed to the world: ground of any shape, which bodies touch at all points of their shapes.
    #[must_use]
    pub fn with_surface(mut self, link: &str, surface: Surface) -> Self {
        self.surfaces.push((link.to_owned(), Arc::new(surface)));
        self
    }

    /// Lets relaxed rigid contact meet what would arrive within a step, so that nothing passes through a thin wall (speculative contact): a point may go deeper
    /// in a step by no more than the width of the impedance. Above the surface it has no friction.
    ///
    /// Without this, bodies pass through each other where the way in a step is longer than about half their thickness, since the least translation that
    /// separates them is then out of the other side:
    ///
    /// | contact model | what passes through |
    /// |---|---|
    /// | rigid | nothing: it always meets what would arrive |
    /// | relaxed rigid | what is fast and thin; with this option nothing thicker than four times the width of the impedance |
    /// | soft, in steps that are implicit in velocity | nothing in one step; in several, what the force does not stop within half the thickness |
    /// | soft, in other steps | what is fast and thin |
    ///
    /// The distance is that along the normal at the start of the step: what turns by more than about 1 rad in a step, or passes an edge sideways, may be met too
    /// early or not at all. All pairs that are near each other have rows, which costs time. [`Smoothing`](crate::contact::Smoothing) takes the place of this.
    #[must_use]
    pub fn with_speculative_contact(mut self) -> Self {
        self.speculative = true;
        self
    }

    /// Gives the shapes of a link a material. Between two links the friction is the harmonic mean 2 μ₁ μ₂ / (μ₁ + μ₂) of both, and so the restitution, as in
    /// [`Materials`](crate::contact::Materials). They are parameters of the simulator.
    ///
    /// # Examples
    /// ```
    /// use dualbody::contact::{CollisionOptions, Material};
    ///
    /// let ice = Material { friction: 0.05, restitution: 0.1 };
    /// let options = CollisionOptions::default().with_material("puck", ice);
    /// assert_eq!(options.materials.len(), 1);
    /// ```
    #[must_use]
    pub fn with_material(mut self, link: &str, material: Material) -> Self {
        self.materials.push((link.to_owned(), material));
        self
    }
}

impl Contacts<f64> {
    /// As [`with_collisions`](Self::with_collisions), with shapes from elsewhere than files, with groups and margins. A margin is a distance from which on
    /// features take part in a step, at the least. Allocates.
    ///
    /// # Errors
    /// If there is no link of a name in the options, or it has no shape.
    ///
    /// # Panics
    /// As [`with_collisions`](Self::with_collisions), if a link with a surface moves, and if the shapes are those of another robot.
    pub fn with_link_shapes(
        mut self,
        model: &Model,
        law: ContactLaw,
        mut shapes: LinkShapes,
        options: &CollisionOptions,
    ) -> Result<Self, UnknownName> {
        self.check(model);
        shapes.check(model);
        let excluded = options.excluded.iter();
        let excluded: Vec<[&str; 2]> = excluded.map(|[a, b]| [a.as_str(), b]).collect();
        shapes.exclude(model, &excluded)?;
        for (link, surface) in &options.surfaces {
            shapes.add_surface(model, link, surface)?;
        }
        for (link, material) in &options.materials {
            let link = shapes.find_link(model, link)?;
            let own = shapes.shapes_mut().iter_mut();
            own.filter(|shape| shape.link == link)
                .for_each(|shape| shape.material = Some(*material));
        }
        let materials = shapes.shapes().iter().filter_map(|shape| shape.material);
        materials.for_each(|material| material.check_numbers());
        self.add_shapes_without_points(shapes.missing().to_vec());
        let speculative = options.speculative && matches!(law, ContactLaw::RelaxedRigid(_));
        let pairs = ShapePairs::new(shapes, options.self_collision, speculative);
        self.set_shape_pairs(pairs, law);
        Ok(self)
    }
}
