//! Bodies that others reach within a step.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use crate::contact::{Contacts, FoundPairs, PairFinder, PairPoint, PairState, PointState};
use crate::dynamics::{Kinematics, forward_kinematics_into};
use crate::model::{BodyId, Model};
use crate::scalar::MapEach;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::Contact;
use crate::spatial::linear::dot;

/// Multiple of the gap across which a body wakes another one, below which two bodies fall asleep together. With one gap for both, two that are just as
/// far from each other would wake each other in turn.
const APART: f64 = 2.0;

/// Finds sleeping bodies that something awake reaches.
#[derive(Clone, Debug)]
pub(super) struct Waking {
    kinematics: Kinematics<f64>,
    finder: PairFinder,
    points: Vec<PairPoint>,
}

impl Waking {
    pub(super) fn new(model: &Model) -> Self {
        Self {
            kinematics: Kinematics::new(model),
            finder: PairFinder::default(),
            points: Vec::new(),
        }
    }

    /// Places all bodies in a state.
    pub(super) fn place(&mut self, simulator: &Simulator, state: &State) {
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        forward_kinematics_into(simulator.model(), q, v, &mut self.kinematics);
    }

    /// Passes the sleeping bodies that something awake reaches within a step to `each`.
    ///
    /// * `asleep` – whether each body sleeps
    pub(super) fn find(
        &mut self,
        simulator: &Simulator,
        asleep: &[bool],
        mut each: impl FnMut(BodyId),
    ) {
        let Some(contacts) = simulator.contacts().filter(|c| c.have_pairs()) else {
            return;
        };
        let (dt, kinematics) = (simulator.time_step(), &self.kinematics);
        self.points.clear();
        let among = FoundPairs::Waking(asleep);
        let fits = self
            .finder
            .find(contacts, kinematics, dt, among, &mut self.points);
        if !fits {
            // Too many to tell.
            let sleeping = asleep.iter().enumerate().filter(|(_, own)| **own);
            return sleeping.for_each(|(k, _)| each(BodyId(k)));
        }
        for point in &self.points {
            let bodies = contacts.pair_bodies(point.shapes);
            let X = bodies.map_each(|body| kinematics.pose(body));
            let V = bodies.map_each(|body| kinematics.velocity(body));
            let PairState { point, .. } = contacts.pair_state(point, &X, &V);
            if reaches(simulator, contacts, &point, 1.0) {
                let sleeping = bodies.into_iter().flatten();
                sleeping.filter(|body| asleep[body.0]).for_each(&mut each);
            }
        }
    }

    /// Passes the bodies that touch each other in a step, or are so near that one would wake the other, to `each`.
    pub(super) fn each_joined(
        &self,
        simulator: &Simulator,
        contact: &Contact<f64>,
        mut each: impl FnMut([BodyId; 2]),
    ) {
        let Some(contacts) = simulator.contacts() else {
            return;
        };
        contact.each_pair(contacts, |shapes, point| {
            let near = || reaches(simulator, contacts, point, APART);
            if let [Some(a), Some(b)] = contacts.pair_bodies(shapes)
                && near()
            {
                each([a, b]);
            }
        });
    }
}

/// Whether the sides of a point could touch within a step, by their velocities and gravity; under a smoothed contact model, whether there is a force.
///
/// * `slack` – multiple of the way
fn reaches(
    simulator: &Simulator,
    contacts: &Contacts,
    point: &PointState<f64>,
    slack: f64,
) -> bool {
    let dt = simulator.time_step();
    if !contacts.pair_margin(dt).contains(point) {
        return false;
    }
    let closing = (-dot(&point.normal, &point.velocity)).max(0.0);
    let way = (closing + simulator.model().gravity().norm() * dt) * dt;
    contacts.smoothing().is_some() || point.depth + slack * way > 0.0
}
