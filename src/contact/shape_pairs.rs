//! The shapes of a robot or a world that can touch each other, over the scalar of contacts.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::sync::Arc;

use super::link_shapes::LinkShapes;
use super::material::Material;
use super::part::ContactPart;
use super::turning::TurningFriction;
use crate::collision::{Bounds, BroadPhase, Shape};
use crate::model::BodyId;
use crate::numbers::{EachIn, Numbers, of};
use crate::scalar::{Over, Scalar};
use crate::spatial::Transform;

/// The most sizes that a shape has.
pub(crate) const SHAPE_NUMBERS: usize = <Shape as Numbers<f64>>::COUNT;

/// Numbers of a material but torsional and rolling friction, which are the last.
pub(crate) const MATERIAL_NUMBERS: usize = <Material as Numbers<f64>>::COUNT - TURNING_NUMBERS;

/// Numbers of torsional and rolling friction.
pub(crate) const TURNING_NUMBERS: usize = <TurningFriction as Numbers<f64>>::COUNT;

/// A convex shape on a body.
#[derive(Clone, Debug)]
pub(super) struct BodyShape<P> {
    /// Its pose in the body.
    pub(super) X_BS: Transform<P>,
    pub(super) shape: Shape<P>,
    /// `None` for the value of the contact model.
    pub(super) material: Option<Material<P>>,
}

impl<P> BodyShape<P> {
    /// Whether its sizes are parameters; triangles have too many.
    pub(super) fn has_parameters(&self) -> bool {
        !matches!(self.shape, Shape::Triangle { .. })
    }
}

/// The shapes of a robot or a world that can touch each other.
#[derive(Clone, Debug)]
pub(super) struct ShapePairs<P> {
    /// Shapes over the scalar of the contacts, in the order of those that are plain.
    pub(super) shapes: Vec<BodyShape<P>>,
    /// `None` where bodies do not collide.
    pub(super) plain: Option<Arc<LinkShapes>>,
    /// The triangles of surfaces among the shapes, which do not move.
    pub(super) surfaces: Arc<SurfaceTree>,
    pub(super) self_collision: bool,
    /// Whether features that would arrive within a step are met, by a law that else meets overlap only.
    pub(super) speculative: bool,
    /// Whether some pairs may have torsional or rolling friction.
    pub(super) has_turning: bool,
}

/// The triangles of surfaces, the last of all shapes, in a tree of boxes.
#[derive(Clone, Debug, Default)]
pub(super) struct SurfaceTree {
    /// The first triangle among the shapes.
    pub(super) first: usize,
    /// The boxes about the triangles, with their own margins.
    pub(super) tree: BroadPhase,
}

impl SurfaceTree {
    fn new(plain: &LinkShapes) -> Self {
        let shapes = plain.shapes();
        let first = shapes.iter().position(|own| own.sides.is_some());
        let first = first.unwrap_or(shapes.len());
        let triangles = shapes[first..].iter();
        let bounds = triangles.map(|own| Bounds::of(&own.shape, &own.placement, own.margin));
        Self {
            first,
            tree: BroadPhase::of_fixed(&bounds.collect::<Vec<_>>()),
        }
    }
}

impl ShapePairs<f64> {
    /// Those of link shapes.
    ///
    /// * `turning` – torsional and rolling friction of shapes without materials
    pub(super) fn new(
        plain: LinkShapes,
        self_collision: bool,
        speculative: bool,
        turning: &TurningFriction,
    ) -> Self {
        let mut materials = plain.shapes().iter().filter_map(|own| own.material);
        let has_turning = turning.acts() || materials.any(|own| own.turning.acts());
        let shapes = plain.shapes().iter().map(|own| BodyShape {
            X_BS: own.placement,
            shape: own.shape.clone(),
            material: own.material,
        });
        Self {
            shapes: shapes.collect(),
            surfaces: Arc::new(SurfaceTree::new(&plain)),
            plain: Some(Arc::new(plain)),
            self_collision,
            speculative,
            has_turning,
        }
    }
}

impl<P: Scalar> ShapePairs<P> {
    /// None.
    pub(super) fn none() -> Self {
        Self {
            shapes: Vec::new(),
            plain: None,
            surfaces: Arc::default(),
            self_collision: false,
            speculative: false,
            has_turning: false,
        }
    }

    pub(super) fn cast<Q: Over<P>>(&self) -> ShapePairs<Q> {
        let cast = |own: &BodyShape<P>| BodyShape {
            X_BS: own.X_BS.lift(),
            shape: own.shape.lift(),
            material: own.material.lift(),
        };
        ShapePairs {
            shapes: self.shapes.iter().map(cast).collect(),
            plain: self.plain.clone(),
            surfaces: self.surfaces.clone(),
            self_collision: self.self_collision,
            speculative: self.speculative,
            has_turning: self.has_turning,
        }
    }

    /// Passes each parameter of shapes and their materials to `each`.
    pub(super) fn each_number(&mut self, each: &mut EachIn<'_, ContactPart, P>) {
        for (k, own) in self.shapes.iter_mut().enumerate() {
            (own.shape).each_number(&mut of(ContactPart::Shape(k), each));
            if !own.has_parameters() {
                continue;
            }
            let mut place = 0;
            own.material.each_number(&mut |number, x| {
                let is_turning = place >= MATERIAL_NUMBERS;
                place += 1;
                match is_turning {
                    false => each(ContactPart::ShapeMaterial(k), number, x),
                    true if self.has_turning => each(ContactPart::ShapeTurning(k), number, x),
                    true => {}
                }
            });
        }
    }

    /// The body of a shape; `None` is the world.
    pub(super) fn body(&self, shape: usize) -> Option<BodyId> {
        let plain = self.plain.as_ref()?;
        plain.shapes()[shape].body
    }
}
