//! Which shapes of a robot or a world can touch each other.

use crate::contact::laws::ContactLaw;
use crate::contact::shape_pairs::ShapePairs;
use crate::contact::{Contacts, LinkShapes};
use crate::error::UnknownName;
use crate::model::Model;

/// Which links collide with each other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CollisionOptions {
    /// Whether links of one robot collide, too; those that a joint connects never do.
    pub self_collision: bool,
    /// Links that do not collide, by name.
    pub excluded: Vec<[String; 2]>,
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
}

impl Contacts<f64> {
    /// As [`with_collisions`](Self::with_collisions), with shapes from elsewhere than files, with groups and margins. A margin is a distance from which on
    /// features take part in a step, at the least. Allocates.
    ///
    /// # Errors
    /// If there is no link of an excluded name, or it has no shape.
    ///
    /// # Panics
    /// As [`with_collisions`](Self::with_collisions), and if the shapes are those of another robot.
    pub fn with_link_shapes(
        mut self,
        model: &Model,
        law: ContactLaw,
        mut shapes: LinkShapes,
        options: &CollisionOptions,
    ) -> Result<Self, UnknownName> {
        self.check(model);
        shapes.check(model);
        assert!(
            !matches!(law, ContactLaw::Soft(_)),
            "contact between bodies is rigid or relaxed rigid: a soft law has a state of its own for each point"
        );
        for [first, second] in &options.excluded {
            shapes.exclude(model, &[[first, second]])?;
        }
        self.add_shapes_without_points(shapes.missing().to_vec());
        self.set_shape_pairs(ShapePairs::new(shapes, options.self_collision), law);
        Ok(self)
    }
}
