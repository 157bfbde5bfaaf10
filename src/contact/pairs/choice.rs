//! Selection of the shapes of a robot or a world that can touch each other.

use std::sync::Arc;

use crate::collision::Surface;
use crate::contact::laws::ContactLaw;
use crate::contact::shape_pairs::ShapePairs;
use crate::contact::{Contacts, LinkShapes, Material, TurningFriction};
use crate::error::UnknownName;
use crate::model::{FrameId, Model};
use crate::numbers::Numbers as _;

/// Options of contact between bodies: pairs of links, materials, surfaces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CollisionOptions {
    /// Whether links of one robot collide with each other; links connected by a joint never do.
    pub self_collision: bool,
    /// Links that do not collide, by name.
    pub excluded: Vec<[String; 2]>,
    /// Materials of the shapes of links, by link name; other links use the values of the contact model.
    pub materials: Vec<(String, Material)>,
    /// Materials of pairs of links, by name, in place of those that follow from the materials of both.
    pub pairs: Vec<([String; 2], Material)>,
    /// Triangle meshes on links that are fixed to the world, by link name.
    pub surfaces: Vec<(String, Arc<Surface>)>,
    /// Torsional and rolling friction between shapes without a material; none by default.
    pub turning: TurningFriction,
    /// Whether regularised rigid contact is speculative: see [`with_speculative_contact`](Self::with_speculative_contact).
    pub speculative: bool,
}

impl CollisionOptions {
    /// Enables contact between links of one robot.
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

    /// Adds a triangle mesh to a link that is fixed to the world: ground of arbitrary shape, which bodies can touch with all points of their shapes.
    #[must_use]
    pub fn with_surface(mut self, link: &str, surface: Surface) -> Self {
        self.surfaces.push((link.to_owned(), Arc::new(surface)));
        self
    }

    /// Enables speculative contact for regularised rigid contact: a point that would arrive within a step already has a row, so bodies do not pass
    /// through thin walls. The depth of a point increases in a step by at most the width of the impedance. Above the surface a point has no friction.
    ///
    /// Without this option, bodies can pass through each other if they move by more than about half their thickness in a step, because the shortest
    /// separating translation is then towards the other side:
    ///
    /// | contact model | bodies that pass through |
    /// |---|---|
    /// | rigid | none: it is always speculative |
    /// | regularised rigid | fast and thin ones; with this option none that is thicker than four times the width of the impedance |
    /// | soft, in linearly implicit steps | none in one step; in several steps, those that the force does not stop within half the thickness |
    /// | soft, in other steps | fast and thin ones |
    ///
    /// The distance is measured along the normal at the start of the step. So contact may come too early or not at all for bodies that rotate by more
    /// than about 1 rad in a step, or that pass an edge sideways. All near pairs have rows, which costs time.
    /// [`Smoothing`](crate::contact::Smoothing) replaces this option.
    #[must_use]
    pub fn with_speculative_contact(mut self) -> Self {
        self.speculative = true;
        self
    }

    /// Sets the material of the shapes of a link. Friction and restitution between two links are harmonic means, 2 μ₁ μ₂ / (μ₁ + μ₂), as in
    /// [`Materials`](crate::contact::Materials); torsional and rolling friction are the larger ones of both; margins are summed; [`Compliance`](crate::contact::Compliance) has its own
    /// rule. They are parameters of the simulator.
    ///
    /// # Examples
    /// ```
    /// use dualbody::contact::{CollisionOptions, Material};
    ///
    /// let ice = Material { friction: 0.05, restitution: 0.1, ..Material::default() };
    /// let options = CollisionOptions::default().with_material("puck", ice);
    /// assert_eq!(options.materials.len(), 1);
    /// ```
    #[must_use]
    pub fn with_material(mut self, link: &str, material: Material) -> Self {
        self.materials.push((link.to_owned(), material));
        self
    }

    /// Sets the material between two links, in place of that which follows from the materials of both. Its values are parameters of the simulator.
    ///
    /// # Examples
    /// ```
    /// use dualbody::contact::{CollisionOptions, Material};
    ///
    /// let glue = Material { friction: f64::INFINITY, ..Material::default() };
    /// let options = CollisionOptions::default().with_pair("stamp", "letter", glue);
    /// assert_eq!(options.pairs.len(), 1);
    /// ```
    #[must_use]
    pub fn with_pair(mut self, first: &str, second: &str, material: Material) -> Self {
        (self.pairs).push(([first.to_owned(), second.to_owned()], material));
        self
    }
}

impl Contacts<f64> {
    /// As [`with_collisions`](Self::with_collisions), with given shapes, groups and margins. Features within the margin always take part in a step. Allocates.
    ///
    /// # Errors
    /// If a link in the options does not exist or has no shape.
    ///
    /// # Panics
    /// As [`with_collisions`](Self::with_collisions), if a link with a surface moves, if a material has a compliance for another contact model, and if the shapes
    /// belong to another robot.
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
        set_pairs(&mut shapes, model, &options.pairs)?;
        let given = shapes.pair_materials().map(|(_, own)| *own);
        let materials = shapes.shapes().iter().filter_map(|shape| shape.material);
        for material in materials.chain(given) {
            material.check_numbers();
            law.check_compliance(&material);
        }
        self.add_shapes_without_points(shapes.missing().to_vec());
        let speculative = options.speculative && matches!(law, ContactLaw::RelaxedRigid(_));
        let turning = options.turning;
        turning.check_numbers();
        let pairs = ShapePairs::new(shapes, options.self_collision, speculative, &turning);
        self.set_shape_pairs(pairs, law, turning);
        Ok(self)
    }
}

/// Gives kinds of surfaces to the links of pairs, and materials to these.
fn set_pairs(
    shapes: &mut LinkShapes,
    model: &Model,
    pairs: &[([String; 2], Material)],
) -> Result<(), UnknownName> {
    let mut links = Vec::new();
    for ([first, second], material) in pairs {
        let kinds = [
            kind_of(shapes.find_link(model, first)?, &mut links),
            kind_of(shapes.find_link(model, second)?, &mut links),
        ];
        shapes.set_pair_material(kinds, *material);
    }
    for k in 0..shapes.shapes().len() {
        let link = shapes.shapes()[k].link;
        if let Some(kind) = links.iter().position(|own| *own == link) {
            shapes.set_kind(k, number(kind));
        }
    }
    Ok(())
}

/// The kind of surface of a link, which is a new one if the link has none.
fn kind_of(link: FrameId, links: &mut Vec<FrameId>) -> u32 {
    let found = links.iter().position(|own| *own == link);
    number(found.unwrap_or_else(|| {
        links.push(link);
        links.len() - 1
    }))
}

fn number(kind: usize) -> u32 {
    u32::try_from(kind + 1).unwrap_or(u32::MAX)
}
