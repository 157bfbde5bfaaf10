//! Pairs of shapes in graphs, which have no values to decide on: all points of all pairs take part.

use crate::collision::{PairFeature, Shape, recorded_feature, recorded_points};
use crate::contact::shape_pairs::ShapePairs;
use crate::contact::{Contacts, LinkShapes};
use crate::model::Model;
use crate::scalar::Scalar;

impl<P: Scalar> ShapePairs<P> {
    /// The pairs of shapes that may touch, of which one moves, the one that moves first.
    fn each_pair(&self, plain: &LinkShapes, mut each: impl FnMut([usize; 2])) {
        let solids = self.surfaces.first.min(self.shapes.len());
        for i in 0..solids {
            for j in i + 1..self.shapes.len() {
                let moves = [i, j].map(|k| self.body(k).is_some());
                let may_touch = || plain.may_collide(i, j, self.self_collision);
                match moves {
                    [false, false] => {}
                    [false, true] if may_touch() => each([j, i]),
                    [true, _] if may_touch() => each([i, j]),
                    _ => {}
                }
            }
        }
    }

    /// Passes each point of each pair to `each`.
    pub(super) fn each_recorded(
        &self,
        plain: &LinkShapes,
        mut each: impl FnMut([usize; 2], PairFeature),
    ) {
        self.each_pair(plain, |shapes| {
            let [a, b] = shapes.map(|k| &self.shapes[k].shape);
            let count = recorded_points(a, b).unwrap_or(0);
            (0..count).for_each(|number| each(shapes, recorded_feature(number)));
        });
    }
}

impl<P: Scalar> Contacts<P> {
    /// Checks that all pairs of shapes that may touch can be recorded in a graph.
    ///
    /// # Panics
    /// If a pair cannot; the message names shapes and links.
    pub(crate) fn check_recordable<Q: Scalar>(&self, model: &Model<Q>) {
        let pairs = self.shape_pairs();
        let Some(plain) = &pairs.plain else { return };
        let is_wide = pairs.speculative || self.smoothing().is_some();
        pairs.each_pair(plain, |shapes| {
            let [a, b] = shapes.map(|k| &pairs.shapes[k].shape);
            let describe = |k: usize| {
                let link = &model.frames()[plain.shapes()[k].link.0].name;
                format!("{} of link \"{link}\"", kind(&pairs.shapes[k].shape))
            };
            let [first, second] = shapes.map(describe);
            assert!(
                recorded_points(a, b).is_some(),
                "contact between the {first} and the {second} cannot be recorded in a graph, because their features are selected on values; \
                 exclude this pair of links, or use spheres, capsules, boxes and half-spaces"
            );
            assert!(
                !is_wide,
                "contact between the {first} and the {second} cannot be recorded in a graph with smoothing or speculative contact, \
                 because a graph has only points that touch"
            );
        });
    }
}

/// The name of the kind of a shape.
fn kind<P>(shape: &Shape<P>) -> &'static str {
    match shape {
        Shape::Sphere { .. } => "sphere",
        Shape::Capsule { .. } => "capsule",
        Shape::Box { .. } => "box",
        Shape::Cylinder { .. } => "cylinder",
        Shape::Ellipsoid { .. } => "ellipsoid",
        Shape::Hull { .. } => "mesh or hull",
        Shape::Triangle { .. } => "triangle of a surface",
        Shape::HalfSpace => "half-space",
        Shape::Field { .. } => "distance field",
    }
}
