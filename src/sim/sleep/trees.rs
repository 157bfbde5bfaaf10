//! The trees of joints of a simulator.

use std::ops::Range;

use super::record::{Record, fingerprint};
use crate::contact::{Contacts, ROWS};
use crate::dynamics::trees;
use crate::model::BodyId;
use crate::model::manifold::{q_range, v_range};
use crate::nested::IntoNested;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// A tree: all that joints connect.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    q: Range<usize>,
    v: Range<usize>,
    /// Its bristles in the contact state.
    bristles: Vec<Range<usize>>,
    /// Whether nothing else than contact and constraints acts on it.
    pub(super) may_sleep: bool,
}

/// All trees.
#[derive(Clone, Debug)]
pub(super) struct Trees {
    all: Vec<Tree>,
    /// `None` for what does not move.
    of_bodies: Vec<Option<usize>>,
    /// Pairs that constraints connect.
    pub(super) ties: Vec<[usize; 2]>,
}

impl Trees {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let model = simulator.model();
        let first = trees(model);
        let mut of_coordinates = Vec::with_capacity(first.len());
        let mut all: Vec<Tree> = Vec::new();
        for own in first.chunk_by(|a, b| a == b) {
            of_coordinates.extend(own.iter().map(|_| all.len()));
            all.push(Tree {
                q: model.nq()..0,
                v: own[0]..own[0] + own.len(),
                bristles: Vec::new(),
                may_sleep: true,
            });
        }
        for body in model.independent().filter(|body| body.joint.nv() > 0) {
            let (own, q) = (
                &mut all[of_coordinates[v_range(body).start]].q,
                q_range(body),
            );
            *own = own.start.min(q.start)..own.end.max(q.end);
        }
        let mut of_bodies: Vec<Option<usize>> = Vec::with_capacity(model.n_bodies());
        for body in model.bodies() {
            let of_parent = body.parent.and_then(|parent| of_bodies[parent.0]);
            let moves = body.joint.nv() > 0;
            of_bodies.push(moves.then(|| of_coordinates[body.v]).or(of_parent));
        }
        let mut out = Self {
            all,
            of_bodies,
            ties: Vec::new(),
        };
        out.add_bristles(simulator);
        out.keep_awake(simulator, &of_coordinates);
        out.tie(simulator);
        out
    }

    fn add_bristles(&mut self, simulator: &Simulator) {
        let contacts = simulator.contacts().filter(|_| simulator.n_contact() > 0);
        let points = contacts.map_or(&[][..], Contacts::points);
        for (k, point) in points.iter().enumerate() {
            if let Some(tree) = self.of_body(point.body) {
                (self.all[tree].bristles).push(ROWS * k..ROWS * (k + 1));
            }
        }
    }

    /// Keeps trees awake on which something acts.
    fn keep_awake(&mut self, simulator: &Simulator, of_coordinates: &[usize]) {
        let servos = simulator.tendon_servos().iter();
        let pulled = servos.nested(|servo| servo.coordinates());
        for k in simulator.actuated().iter().copied().chain(pulled) {
            self.all[of_coordinates[k]].may_sleep = false;
        }
        for term in simulator.frame_terms().iter() {
            let frame = term.place().frame;
            let body = frame.and_then(|frame| simulator.model().frame_of(frame).body);
            if let Some(tree) = body.and_then(|body| self.of_body(body)) {
                self.all[tree].may_sleep = false;
            }
        }
    }

    /// Connects the trees of each constraint.
    fn tie(&mut self, simulator: &Simulator) {
        for constraint in simulator.constraints() {
            let kind = constraint.kind();
            let frames = kind.anchors().iter().filter_map(|anchor| anchor.frame);
            let on_frames = frames.filter_map(|frame| simulator.model().frame_of(frame).body);
            let bodies = on_frames.chain(kind.joints().map(|joint| joint.body));
            let mut own = bodies.filter_map(|body| self.of_bodies[body.0]);
            if let Some(first) = own.next() {
                let others = own.filter(|&other| other != first);
                (self.ties).extend(others.map(|other| [first, other]));
            }
        }
    }

    pub(super) fn len(&self) -> usize {
        self.all.len()
    }

    pub(super) fn tree(&self, tree: usize) -> &Tree {
        &self.all[tree]
    }

    /// The tree of a body; `None` if it does not move.
    pub(super) fn of_body(&self, body: BodyId) -> Option<usize> {
        self.of_bodies[body.0]
    }

    /// Writes for each body whether its tree sleeps.
    pub(super) fn spread_over_bodies(&self, asleep: &[bool], out: &mut Vec<bool>) {
        out.clear();
        let trees = self.of_bodies.iter();
        out.extend(trees.map(|tree| tree.is_some_and(|tree| asleep[tree])));
    }

    /// Writes for each tree whether it sleeps in a state: all trees of its island are as they were when they fell asleep.
    pub(super) fn asleep_into(&self, state: &State, asleep: &mut Vec<bool>) {
        asleep.clear();
        asleep.resize(self.len(), false);
        // First whether an island is undisturbed, by its first tree.
        for tree in 0..self.len() {
            if let Record::Asleep { island, .. } = Record::of(&state.sleep, tree) {
                asleep[island] = true;
            }
        }
        for (tree, own) in self.all.iter().enumerate() {
            if let Record::Asleep {
                island,
                fingerprint,
            } = Record::of(&state.sleep, tree)
            {
                asleep[island] &= own.may_sleep && own.is_at_rest(state, fingerprint);
            }
        }
        // The first tree of an island has the smallest index.
        for tree in (0..self.len()).rev() {
            asleep[tree] = match Record::of(&state.sleep, tree) {
                Record::Asleep { island, .. } if island <= tree => asleep[island],
                _ => false,
            };
        }
    }
}

impl Tree {
    /// Its numbers that do not change in sleep beside v.
    pub(super) fn fingerprint(&self, state: &State) -> f64 {
        let bristles = self.bristles.iter().cloned();
        let contact = state.contact.as_slice();
        let bristles = bristles.nested(|range| contact[range].iter());
        fingerprint(state.q.as_slice()[self.q.clone()].iter().chain(bristles))
    }

    /// Whether it is as it was when it fell asleep.
    fn is_at_rest(&self, state: &State, fingerprint: f64) -> bool {
        self.is_slower(state, 0.0) && self.fingerprint(state) == fingerprint
    }

    /// Whether no coordinate is faster than a speed, m/s or rad/s.
    pub(super) fn is_slower(&self, state: &State, speed: f64) -> bool {
        let v = &state.v.as_slice()[self.v.clone()];
        v.iter().all(|v| v.abs() <= speed)
    }

    /// Copies its numbers to another state.
    pub(super) fn copy(&self, from: &State, to: &mut State) {
        let copy = |from: &[f64], to: &mut [f64], range: &Range<usize>| {
            to[range.clone()].copy_from_slice(&from[range.clone()]);
        };
        copy(from.q.as_slice(), to.q.as_mut_slice(), &self.q);
        copy(from.v.as_slice(), to.v.as_mut_slice(), &self.v);
        let (from, to) = (from.contact.as_slice(), to.contact.as_mut_slice());
        for range in &self.bristles {
            copy(from, to, range);
        }
    }

    /// Stops it.
    pub(super) fn stop(&self, state: &mut State) {
        state.v.as_mut_slice()[self.v.clone()].fill(0.0);
    }
}
