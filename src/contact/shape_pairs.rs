//! The shapes of a robot or a world that can touch each other, over the scalar of contacts.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::sync::Arc;

use super::link_shapes::LinkShapes;
use super::material::Material;
use crate::collision::Shape;
use crate::model::BodyId;
use crate::numbers::Numbers;
use crate::scalar::{Over, Scalar};
use crate::spatial::Transform;

/// The most sizes that a shape has.
pub(crate) const SHAPE_NUMBERS: usize = <Shape as Numbers<f64>>::COUNT;

/// Numbers of a material.
pub(crate) const MATERIAL_NUMBERS: usize = <Material as Numbers<f64>>::COUNT;

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
    pub(super) self_collision: bool,
    /// Whether features that would arrive within a step are met, by a law that else meets overlap only.
    pub(super) speculative: bool,
}

impl ShapePairs<f64> {
    pub(super) fn new(plain: LinkShapes, self_collision: bool, speculative: bool) -> Self {
        let shapes = plain.shapes().iter().map(|own| BodyShape {
            X_BS: own.placement,
            shape: own.shape.clone(),
            material: own.material,
        });
        Self {
            shapes: shapes.collect(),
            plain: Some(Arc::new(plain)),
            self_collision,
            speculative,
        }
    }
}

impl<P: Scalar> ShapePairs<P> {
    /// None.
    pub(super) fn none() -> Self {
        Self {
            shapes: Vec::new(),
            plain: None,
            self_collision: false,
            speculative: false,
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
            self_collision: self.self_collision,
            speculative: self.speculative,
        }
    }

    /// The body of a shape; `None` is the world.
    pub(super) fn body(&self, shape: usize) -> Option<BodyId> {
        let plain = self.plain.as_ref()?;
        plain.shapes()[shape].body
    }
}
