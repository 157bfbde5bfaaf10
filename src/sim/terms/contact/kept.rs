//! Forces of the last solution, from which the next one starts: by what touches, since points come and go.

use crate::collision::FeatureId;
use crate::contact::ROWS;

/// Identity of a point of contact from solution to solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Key {
    /// A point with the ground.
    Ground(usize),
    /// Features of two shapes.
    Pair([usize; 2], FeatureId),
}

/// Forces of points, sorted by their keys.
#[derive(Clone, Debug)]
pub(super) struct KeptForces<T> {
    forces: Vec<(Key, [T; ROWS])>,
    /// Whether they stay for the next step.
    pub(super) stay: bool,
}

impl<T: Copy> KeptForces<T> {
    pub(super) fn new() -> Self {
        Self {
            forces: Vec::new(),
            stay: false,
        }
    }

    /// Replaces them.
    pub(super) fn keep(&mut self, forces: impl Iterator<Item = (Key, [T; ROWS])>) {
        self.forces.clear();
        self.forces.extend(forces);
        self.forces.sort_unstable_by_key(|(key, _)| *key);
    }

    /// The force of a point.
    pub(super) fn find(&self, key: Key) -> Option<[T; ROWS]> {
        let found = self.forces.binary_search_by_key(&key, |(key, _)| *key);
        found.ok().map(|at| self.forces[at].1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_are_found_by_their_keys_in_whatever_order_they_came() {
        let mut kept = KeptForces::new();
        let all = [7, 2, 5].map(|k| (Key::Ground(k), [k as f64, 0.0, 1.0]));
        kept.keep(all.into_iter());
        assert_eq!(kept.find(Key::Ground(2)), Some([2.0, 0.0, 1.0]));
        assert_eq!(kept.find(Key::Ground(3)), None);
        kept.keep(std::iter::empty());
        assert_eq!(kept.find(Key::Ground(2)), None);
    }
}
