//! Contact points between bodies, found anew in each step from the near features of shapes.
//!
//! They follow the points with the ground and have the same data: normal, depth, velocity, contact model. The difference is that both sides move.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use crate::contact::{Contacts, FoundPairs, PairFinder, PairPoint, PairState, PointState};
use crate::dynamics::Kinematics;
use crate::scalar::{MapEach, Over, Scalar};

/// Points between bodies at an instant, with the memory to find them.
#[derive(Clone, Debug)]
pub(super) struct PairPoints<T> {
    finder: PairFinder,
    points: Vec<PairPoint>,
    /// Position of each in its second body, m.
    in_second: Vec<Vector3<T>>,
    /// Whether there were more pairs than memory.
    full: bool,
}

impl<T: Scalar> PairPoints<T> {
    pub(super) fn new() -> Self {
        Self {
            finder: PairFinder::default(),
            points: Vec::new(),
            in_second: Vec::new(),
            full: false,
        }
    }

    fn clear(&mut self) {
        self.points.clear();
        self.in_second.clear();
    }

    pub(super) fn get(&self, k: usize) -> &PairPoint {
        &self.points[k]
    }

    /// Whether pairs were left out because there were too many.
    pub(super) fn is_full(&self) -> bool {
        self.full
    }

    /// Position of a point in its second body, m.
    pub(super) fn in_second(&self, k: usize) -> &Vector3<T> {
        &self.in_second[k]
    }

    /// Finds the points that could touch within a step, and appends where they are to `out`.
    ///
    /// * `asleep` – whether each body sleeps; empty where none does
    pub(super) fn find<P: Scalar>(
        &mut self,
        contacts: &Contacts<P>,
        kinematics: &Kinematics<T>,
        dt: P,
        asleep: &[bool],
        out: &mut Vec<PointState<T>>,
    ) where
        T: Over<P>,
    {
        self.clear();
        let (among, points) = (FoundPairs::Awake(asleep), &mut self.points);
        let fits = (self.finder).find(contacts, kinematics, dt, among, points);
        self.full = !fits;
        for point in &self.points {
            let bodies = contacts.pair_bodies(point.shapes);
            let X = bodies.map_each(|body| kinematics.pose(body));
            let V = bodies.map_each(|body| kinematics.velocity(body));
            let PairState { point, in_second } = contacts.pair_state(point, &X, &V);
            out.push(point);
            self.in_second.push(in_second);
        }
    }
}
