//! The shapes of a robot or a world that can touch each other, over the scalar of contacts.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::sync::Arc;

use super::compliance::COMPLIANCE_NUMBERS;
use super::link_shapes::LinkShapes;
use super::material::Material;
use super::part::{ContactPart, MaterialOf, MaterialPart};
use super::turning::TurningFriction;
use crate::collision::{Bounds, BroadPhase, Shape};
use crate::model::BodyId;
use crate::numbers::{EachIn, Numbers, of};
use crate::scalar::{Over, Scalar};
use crate::spatial::Transform;

/// The most sizes that a shape has.
pub(crate) const SHAPE_NUMBERS: usize = <Shape as Numbers<f64>>::COUNT;

/// Numbers of a material before torsional and rolling friction, of which the last is the margin; after them come those of its compliance.
pub(crate) const MATERIAL_NUMBERS: usize =
    <Material as Numbers<f64>>::COUNT - TURNING_NUMBERS - COMPLIANCE_NUMBERS;

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
    /// Materials of pairs that are given, in the order of those of the plain shapes.
    pub(super) given: Vec<Material<P>>,
    /// `None` where bodies do not collide.
    pub(super) plain: Option<Arc<LinkShapes>>,
    /// The triangles of surfaces among the shapes, which do not move.
    pub(super) surfaces: Arc<SurfaceTree>,
    pub(super) self_collision: bool,
    /// Of each shape the shapes before it that may touch it, bit by bit; empty where there are more shapes than bits.
    touchable: Arc<[u32]>,
    /// Whether features that would arrive within a step are met, by a law that else meets overlap only.
    pub(super) speculative: bool,
    /// Properties that some materials have.
    pub(super) has: MaterialParts,
}

/// Properties that only some materials have. Materials without them have no parameters for them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MaterialParts {
    /// Torsional or rolling friction.
    pub(super) turning: bool,
    pub(super) margin: bool,
}

/// The triangles of surfaces, the last of all shapes, in a tree of boxes.
#[derive(Clone, Debug, Default)]
pub(super) struct SurfaceTree {
    /// The first triangle among the shapes.
    pub(super) first: usize,
    /// The boxes about the triangles, with their own margins.
    pub(super) tree: BroadPhase,
    /// The largest margin of their materials, m.
    margin: f64,
}

impl SurfaceTree {
    fn new(plain: &LinkShapes) -> Self {
        let shapes = plain.shapes();
        let first = shapes.iter().position(|own| own.sides.is_some());
        let first = first.unwrap_or(shapes.len());
        let triangles = shapes[first..].iter();
        let bounds = triangles.map(|own| Bounds::of(&own.shape, &own.placement, own.margin));
        let materials = shapes[first..].iter().filter_map(|own| own.material);
        Self {
            first,
            tree: BroadPhase::of_fixed(&bounds.collect::<Vec<_>>()),
            margin: materials.map(|own| own.margin).fold(0.0, f64::max),
        }
    }
}

/// Of each shape the shapes before it that may touch it, bit by bit; none where there are more shapes than bits.
fn touchable(plain: &LinkShapes, self_collision: bool) -> Arc<[u32]> {
    let n = plain.shapes().len();
    if n > u32::BITS as usize {
        return Arc::default();
    }
    let before = |j: usize| {
        let may = |i: usize| plain.may_collide(i, j, self_collision);
        (0..j).fold(0, |all, i| all | u32::from(may(i)) << i)
    };
    (0..n).map(before).collect()
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
        let given: Vec<Material> = plain.pair_materials().map(|(_, own)| *own).collect();
        let materials = plain.shapes().iter().filter_map(|own| own.material);
        let materials = materials.chain(given.iter().copied());
        let has = MaterialParts {
            turning: turning.acts() || materials.clone().any(|own| own.turning.acts()),
            margin: materials.clone().any(|own| own.margin > 0.0),
        };
        let shapes = plain.shapes().iter().map(|own| BodyShape {
            X_BS: own.placement,
            shape: own.shape.clone(),
            material: own.material,
        });
        Self {
            shapes: shapes.collect(),
            given,
            surfaces: Arc::new(SurfaceTree::new(&plain)),
            touchable: touchable(&plain, self_collision),
            plain: Some(Arc::new(plain)),
            self_collision,
            speculative,
            has,
        }
    }
}

impl<P: Scalar> ShapePairs<P> {
    /// None.
    pub(super) fn none() -> Self {
        Self {
            shapes: Vec::new(),
            given: Vec::new(),
            plain: None,
            surfaces: Arc::default(),
            self_collision: false,
            touchable: Arc::default(),
            speculative: false,
            has: MaterialParts::default(),
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
            given: self.given.lift(),
            plain: self.plain.clone(),
            surfaces: self.surfaces.clone(),
            self_collision: self.self_collision,
            touchable: self.touchable.clone(),
            speculative: self.speculative,
            has: self.has,
        }
    }

    /// Passes each parameter of shapes and their materials to `each`.
    pub(super) fn each_number(&mut self, each: &mut EachIn<'_, ContactPart, P>) {
        for (k, own) in self.shapes.iter_mut().enumerate() {
            (own.shape).each_number(&mut of(ContactPart::Shape(k), each));
            if !own.has_parameters() {
                continue;
            }
            if let Some(own) = &mut own.material {
                each_of_material(own, MaterialOf::Shape(k), self.has, each);
            }
        }
    }

    /// Passes each parameter of the materials of pairs to `each`.
    pub(super) fn each_given_number(&mut self, each: &mut EachIn<'_, ContactPart, P>) {
        for (k, own) in self.given.iter_mut().enumerate() {
            each_of_material(own, MaterialOf::Pair(k), self.has, each);
        }
    }

    /// Part of the margin of a pair that a shape has, or more, m: its own, and half the largest of pairs whose material is given.
    ///
    /// * `value` – the value of a number in a lane
    pub(super) fn margin_of(&self, shape: usize, value: impl Fn(P) -> f64) -> f64 {
        if !self.has.margin {
            return 0.0;
        }
        let own = self.shapes[shape].material;
        let own = own.map_or(0.0, |own| value(own.margin));
        own.max(self.half_of_given(value))
    }

    /// The largest [`margin_of`](Self::margin_of) a triangle.
    pub(super) fn margin_of_triangles(&self, value: impl Fn(P) -> f64) -> f64 {
        self.surfaces.margin.max(self.half_of_given(value))
    }

    /// Half the largest margin of pairs whose material is given, m.
    fn half_of_given(&self, value: impl Fn(P) -> f64) -> f64 {
        if !self.has.margin {
            return 0.0;
        }
        let given = self.given.iter().map(|own| 0.5 * value(own.margin));
        given.fold(0.0, f64::max)
    }

    /// The place of the given material of a pair of shapes; `None` where theirs are mixed.
    pub(super) fn given_place(&self, shapes: [usize; 2]) -> Option<usize> {
        if self.given.is_empty() {
            return None;
        }
        self.plain.as_ref()?.pair_place(shapes)
    }

    /// Whether two shapes may touch, i < j.
    pub(super) fn may_touch(&self, plain: &LinkShapes, i: usize, j: usize) -> bool {
        match self.touchable.get(j) {
            Some(before) => before >> i & 1 == 1,
            None => plain.may_collide(i, j, self.self_collision),
        }
    }

    /// The body of a shape; `None` is the world.
    pub(super) fn body(&self, shape: usize) -> Option<BodyId> {
        let plain = self.plain.as_ref()?;
        plain.shapes()[shape].body
    }
}

/// Passes each parameter of a material to `each`; margin, torsional and rolling friction only where some materials have them.
fn each_of_material<P: Scalar>(
    material: &mut Material<P>,
    of: MaterialOf,
    has: MaterialParts,
    each: &mut EachIn<'_, ContactPart, P>,
) {
    let mut place = 0_usize;
    material.each_number(&mut |number, x| {
        let part = match place.checked_sub(MATERIAL_NUMBERS) {
            None => MaterialPart::Friction,
            Some(rest) if rest < TURNING_NUMBERS => MaterialPart::Turning,
            Some(_) => MaterialPart::Compliance,
        };
        place += 1;
        let is_some = match part {
            MaterialPart::Turning => has.turning,
            _ => has.margin || place != MATERIAL_NUMBERS,
        };
        if is_some {
            each(ContactPart::Material(of, part), number, x);
        }
    });
}
