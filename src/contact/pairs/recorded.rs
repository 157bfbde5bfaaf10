//! Pairs of shapes in graphs, which have no values to decide on: all points of all pairs take part.

use crate::collision::{PairFeature, Shape, recorded_feature, recorded_points};
use crate::contact::shape_pairs::ShapePairs;
use crate::contact::{ContactLaw, Contacts, LinkShapes};
use crate::model::Model;
use crate::scalar::{MapEach, Scalar};

/// Most points between bodies in a graph whose forces follow from the state: some five million operations.
const MOST_POINTS: usize = 4096;

/// Most points between bodies in a graph whose forces a solver finds: some ten million operations, which grow with the cube.
const MOST_SOLVED: usize = 32;

impl<P: Scalar> ShapePairs<P> {
    /// The pairs of shapes that may touch, of which one moves, the one that moves first.
    fn each_pair(&self, plain: &LinkShapes, mut each: impl FnMut([usize; 2])) {
        let solids = self.surfaces.first.min(self.shapes.len());
        for i in 0..solids {
            for j in i + 1..self.shapes.len() {
                let moves = [i, j].map_each(|k| self.body(k).is_some());
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
            let [a, b] = shapes.map_each(|k| &self.shapes[k].shape);
            let count = recorded_points(a, b).unwrap_or(0);
            (0..count).for_each(|number| each(shapes, recorded_feature(number)));
        });
    }
}

impl<P: Scalar> Contacts<P> {
    /// Checks that all pairs of shapes that may touch can be recorded in a graph.
    ///
    /// # Panics
    /// If a pair cannot; the message names shapes and links. If there are too many points.
    pub(crate) fn check_recordable<Q: Scalar>(&self, model: &Model<Q>) {
        let pairs = self.shape_pairs();
        let Some(plain) = &pairs.plain else { return };
        let (most, mut count) = match self.law_of_pairs() {
            ContactLaw::Soft(_) => (MOST_POINTS, 0),
            _ => (MOST_SOLVED, 0),
        };
        let is_wide = pairs.speculative || self.smoothing().is_some();
        pairs.each_pair(plain, |shapes| {
            let [a, b] = shapes.map_each(|k| &pairs.shapes[k].shape);
            let describe = |k: usize| {
                let link = &model.frames()[plain.shapes()[k].link.0].name;
                format!("{} of link \"{link}\"", kind(&pairs.shapes[k].shape))
            };
            let [first, second] = shapes.map(describe);
            let points = recorded_points(a, b);
            count += points.unwrap_or(0);
            assert!(
                points.is_some(),
                "contact between the {first} and the {second} cannot be recorded in a graph, because their features are selected on values; \
                 exclude this pair of links, or use spheres, capsules, boxes and half-spaces"
            );
            assert!(
                !is_wide,
                "contact between the {first} and the {second} cannot be recorded in a graph with smoothing or speculative contact, \
                 because a graph has only points that touch"
            );
        });
        assert!(
            count <= most,
            "contact between bodies cannot be recorded in a graph: all pairs of shapes together have {count} points, but a graph has at most {most}; \
             exclude pairs of links that never meet"
        );
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
