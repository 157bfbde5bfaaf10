//! A step of a simulator whose resting islands sleep.

use super::record::Record;
use super::trees::Trees;
use super::wake::Waking;
use crate::scalar::MapEach;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::Contact;

/// Part of the time step by which a time at rest may fall short, by rounding of its sum.
const ROUNDING: f64 = 0.5;

/// Decides who sleeps in a step, and who does after it. Its memory is working memory only: what sleeps is in the states.
#[derive(Clone, Debug)]
pub(crate) struct Sleeper {
    trees: Trees,
    /// Whether each tree sleeps in the step, and each body.
    asleep: Vec<bool>,
    bodies: Vec<bool>,
    waking: Waking,
    /// Another tree with which each is connected, or itself; then whether what is connected may fall asleep.
    joined: Vec<usize>,
    ready: Vec<bool>,
}

impl Sleeper {
    pub(crate) fn new(simulator: &Simulator) -> Self {
        Self {
            trees: Trees::new(simulator),
            asleep: Vec::new(),
            bodies: Vec::new(),
            waking: Waking::new(simulator.model()),
            joined: Vec::new(),
            ready: Vec::new(),
        }
    }

    /// Finds who sleeps in the step from a state.
    pub(crate) fn find(&mut self, simulator: &Simulator, state: &State) {
        self.trees.asleep_into(state, &mut self.asleep);
        self.wake_tied(state);
        let mut first = true;
        while self.some_sleep() && !self.all_sleep() {
            (self.trees).spread_over_bodies(&self.asleep, &mut self.bodies);
            if std::mem::take(&mut first) {
                self.waking.place(simulator, state);
            }
            let mut any = false;
            let (trees, asleep) = (&self.trees, &mut self.asleep);
            self.waking.find(simulator, &self.bodies, |body| {
                if let Some(tree) = trees.of_body(body) {
                    any = true;
                    wake_island(asleep, state, tree);
                }
            });
            if !any {
                break;
            }
            self.wake_tied(state);
        }
        self.bodies.clear();
        if self.some_sleep() {
            (self.trees).spread_over_bodies(&self.asleep, &mut self.bodies);
        }
    }

    /// Wakes islands that are tied to something awake, by constraints that they did not have when they fell asleep.
    fn wake_tied(&mut self, state: &State) {
        let mut any = true;
        while any {
            any = false;
            for &[a, b] in &self.trees.ties {
                if self.asleep[a] != self.asleep[b] {
                    let sleeping = if self.asleep[a] { a } else { b };
                    wake_island(&mut self.asleep, state, sleeping);
                    any = true;
                }
            }
        }
    }

    pub(crate) fn some_sleep(&self) -> bool {
        self.asleep.contains(&true)
    }

    pub(crate) fn all_sleep(&self) -> bool {
        !self.asleep.is_empty() && !self.asleep.contains(&false)
    }

    /// Whether each body sleeps in the step; empty where none does.
    pub(crate) fn bodies(&self) -> &[bool] {
        &self.bodies
    }

    /// Leaves what sleeps where it is, and puts islands to sleep that have been at rest for long enough.
    ///
    /// * `contact` – the contacts of the step
    /// * `next` – the state after a step in which all move
    pub(crate) fn settle(
        &mut self,
        simulator: &Simulator,
        state: &State,
        contact: &Contact<f64>,
        next: &mut State,
    ) {
        let Some(rule) = simulator.sleeping() else {
            return;
        };
        let dt = simulator.time_step();
        self.ready.clear();
        for tree in 0..self.trees.len() {
            let (own, record) = (self.trees.tree(tree), Record::of(&state.sleep, tree));
            if self.asleep[tree] {
                own.copy(state, next);
                record.write(&mut next.sleep, tree);
                self.ready.push(false);
                continue;
            }
            let before = match record {
                Record::Awake(time) => time,
                Record::Asleep { .. } => 0.0,
            };
            // At the top of a throw a body is slow in one step, not at both ends of it.
            let rests = own.is_slower(state, rule.speed) && own.is_slower(next, rule.speed);
            let time = if rests { before + dt } else { 0.0 };
            Record::Awake(time).write(&mut next.sleep, tree);
            let is_ready = rests && own.may_sleep && time + ROUNDING * dt >= rule.time;
            self.ready.push(is_ready);
        }
        if self.ready.contains(&true) {
            self.put_to_sleep(simulator, contact, next);
        }
    }

    /// Puts the islands to sleep all of whose trees are ready.
    fn put_to_sleep(&mut self, simulator: &Simulator, contact: &Contact<f64>, next: &mut State) {
        self.join(simulator, contact);
        // Roots come before all others of their islands.
        for tree in (0..self.trees.len()).rev() {
            let root = self.joined[tree];
            self.ready[root] &= self.ready[tree];
        }
        for tree in 0..self.trees.len() {
            let island = self.joined[tree];
            if self.ready[island] {
                let own = self.trees.tree(tree);
                own.stop(next);
                let fingerprint = own.fingerprint(next);
                let record = Record::Asleep {
                    island,
                    fingerprint,
                };
                record.write(&mut next.sleep, tree);
            }
        }
    }

    /// Finds the first tree of the island of each: trees that touch or nearly do, and that are tied.
    fn join(&mut self, simulator: &Simulator, contact: &Contact<f64>) {
        self.joined.clear();
        self.joined.extend(0..self.trees.len());
        let (trees, joined) = (&self.trees, &mut self.joined);
        for &[a, b] in &trees.ties {
            join(joined, a, b);
        }
        self.waking.each_joined(simulator, contact, |bodies| {
            if let [Some(a), Some(b)] = bodies.map_each(|body| trees.of_body(body)) {
                join(joined, a, b);
            }
        });
        for tree in 0..self.trees.len() {
            self.joined[tree] = root(&mut self.joined, tree);
        }
    }
}

/// Wakes the island of a sleeping tree.
fn wake_island(asleep: &mut [bool], state: &State, tree: usize) {
    let island_of = |tree: usize| match Record::of(&state.sleep, tree) {
        Record::Asleep { island, .. } => Some(island),
        Record::Awake(_) => None,
    };
    let own = island_of(tree);
    for (other, asleep) in asleep.iter_mut().enumerate() {
        *asleep &= island_of(other) != own;
    }
}

/// Joins two trees, and all that is joined with them.
fn join(joined: &mut [usize], a: usize, b: usize) {
    let (a, b) = (root(joined, a), root(joined, b));
    joined[a.max(b)] = a.min(b);
}

fn root(joined: &mut [usize], mut tree: usize) -> usize {
    while joined[tree] != tree {
        // Half of the way is skipped the next time.
        joined[tree] = joined[joined[tree]];
        tree = joined[tree];
    }
    tree
}
