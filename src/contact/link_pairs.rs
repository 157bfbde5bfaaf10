//! Pairs of link shapes that may touch: groups, excluded pairs, neighbours in the tree, and a broad phase.

use std::collections::HashMap;

use super::link_shapes::{LinkShape, LinkShapes};
use super::nearest::{nearest_of_shapes, pose};
use crate::collision::{Bounds, BroadPhase, TooManyPairs};
use crate::dynamics::{Kinematics, forward_kinematics};
use crate::error::UnknownName;
use crate::model::{FrameId, Model};
use crate::scalar::MapEach;

/// Pairs of shapes that may touch, with memory that is reused from step to step.
#[derive(Clone, Debug, Default)]
pub struct LinkPairs {
    bounds: Vec<Bounds>,
    broad_phase: BroadPhase,
}

impl LinkShapes {
    /// Excludes pairs of links: they never touch. Links without collision shapes are allowed.
    ///
    /// # Errors
    /// If the model has no such link.
    ///
    /// # Panics
    /// If the shapes are those of another robot.
    pub fn exclude(&mut self, model: &Model, pairs: &[[&str; 2]]) -> Result<(), UnknownName> {
        self.check(model);
        let links = model.links().iter().map(|link| link.frame);
        let by_name: HashMap<&str, FrameId> = links
            .map(|frame| (model.frames()[frame.0].name.as_str(), frame))
            .collect();
        let find = |name: &str| match by_name.get(name) {
            Some(frame) => Ok(*frame),
            None => self.find_link(model, name),
        };
        let found = pairs
            .iter()
            .map(|[a, b]| Ok(in_order([find(a)?, find(b)?])));
        let found = found.collect::<Result<Vec<_>, UnknownName>>()?;
        self.excluded.extend(found);
        self.excluded.sort_unstable();
        self.excluded.dedup();
        Ok(())
    }

    /// Whether two shapes, by index, may touch: their links are neither rigidly joined nor connected by a joint, their groups may touch, and their
    /// links are not [excluded](Self::exclude). Joints on a root link `world`, and floating joints, do not count as connections.
    ///
    /// # Panics
    /// If an index is out of range.
    pub fn may_touch(&self, first: usize, second: usize) -> bool {
        let (a, b) = (&self.shapes()[first], &self.shapes()[second]);
        let is_excluded = || {
            self.excluded
                .binary_search(&in_order([a.link, b.link]))
                .is_ok()
        };
        a.body != b.body
            && a.groups.may_touch(&b.groups)
            && !self.relations().are_joined(a.number, b.number)
            && !is_excluded()
    }

    /// Whether two shapes may touch, those of one robot only where that is requested.
    pub(super) fn may_collide(&self, first: usize, second: usize, self_collision: bool) -> bool {
        let [a, b] = [first, second].map_each(|k| self.shapes()[k].number);
        let is_asked_for = self_collision || !self.relations().are_of_one_robot(a, b);
        is_asked_for && self.may_touch(first, second)
    }

    /// Returns the pairs of shapes that [may touch](Self::may_touch) and whose bounding boxes, widened by their margins, overlap. O(n log n) in the
    /// number of shapes; allocates only for more shapes or pairs than before.
    ///
    /// # Errors
    /// If too many pairs overlap.
    ///
    /// # Panics
    /// If the kinematics or the shapes are those of another robot.
    pub fn pairs<'a>(
        &self,
        model: &Model,
        kinematics: &Kinematics<f64>,
        memory: &'a mut LinkPairs,
    ) -> Result<&'a [[usize; 2]], TooManyPairs> {
        self.check(model);
        kinematics.check(model);
        memory.bounds.clear();
        let bounds =
            |shape: &LinkShape| Bounds::of(&shape.shape, &pose(kinematics, shape), shape.margin);
        memory.bounds.extend(self.shapes().iter().map(bounds));
        memory
            .broad_phase
            .pairs(&memory.bounds, |i, j| self.may_touch(i, j))
    }

    /// Returns the pairs of links that touch at a configuration. At the neutral configuration these are often neighbours of neighbours, which can be
    /// [excluded](Self::exclude). Allocates.
    ///
    /// # Errors
    /// If too many pairs overlap.
    ///
    /// # Panics
    /// If `q` has the wrong length, or the shapes are those of another robot.
    pub fn touching<'a>(
        &self,
        model: &'a Model,
        q: &[f64],
    ) -> Result<Vec<[&'a str; 2]>, TooManyPairs> {
        let kinematics = forward_kinematics(model, q, &vec![0.0; model.nv()]);
        let mut memory = LinkPairs::default();
        let mut found = Vec::new();
        for [i, j] in self.pairs(model, &kinematics, &mut memory)? {
            let (a, b) = (&self.shapes()[*i], &self.shapes()[*j]);
            let near = nearest_of_shapes(a, &pose(&kinematics, a), b, &pose(&kinematics, b));
            let touches = near.is_some_and(|(_, near)| near.distance <= a.margin + b.margin);
            let pair = in_order([a.link, b.link]);
            if touches && !found.contains(&pair) {
                found.push(pair);
            }
        }
        let name = |link: FrameId| model.frames()[link.0].name.as_str();
        Ok(found.into_iter().map(|pair| pair.map(name)).collect())
    }
}

fn in_order([a, b]: [FrameId; 2]) -> [FrameId; 2] {
    [a.min(b), a.max(b)]
}
