//! Relations of links: rigidly joined, connected by a joint, of one robot.

use std::collections::HashMap;

use crate::joint::JointKind;
use crate::model::{JointSpec, Model, WORLD};

/// Relations of the links of a model by joints. Floating joints, and joints on the root link `world`, do not connect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Relations {
    /// Of each link, which are numbered as in [`Model::links`]: the rigid part that it belongs to, and the robot.
    parts: Vec<usize>,
    robots: Vec<usize>,
    /// Rigid parts that a joint connects, the smaller first, in order.
    joined: Vec<[usize; 2]>,
}

impl Relations {
    pub(super) fn new(model: &Model) -> Self {
        let builder = model.to_builder();
        let names = model.link_names();
        let numbers: HashMap<&str, usize> = names
            .iter()
            .enumerate()
            .map(|(k, name)| (&**name, k))
            .collect();
        let number = |name: &str| numbers.get(name).copied();
        let ends = |joint: &JointSpec| {
            let both = number(&joint.parent).zip(number(&joint.child));
            both.filter(|&(parent, _)| names[parent] != WORLD || parent != 0)
        };
        let joints = builder.joints.iter();
        let all: Vec<_> = joints
            .filter(|joint| joint.kind != JointKind::Floating)
            .filter_map(|joint| ends(joint).map(|ends| (joint.kind == JointKind::Fixed, ends)))
            .collect();
        let of = |is_taken: &dyn Fn(bool) -> bool| {
            let taken = all.iter().filter(|(is_fixed, _)| is_taken(*is_fixed));
            components(names.len(), taken.map(|(_, ends)| *ends))
        };
        let (parts, robots) = (of(&|is_fixed| is_fixed), of(&|_| true));
        let mut joined: Vec<_> = all
            .iter()
            .map(|(_, (a, b))| in_order([parts[*a], parts[*b]]))
            .collect();
        joined.sort_unstable();
        joined.dedup();
        Self {
            parts,
            robots,
            joined,
        }
    }

    /// Whether two links are one rigid part, or a joint connects their parts.
    pub(super) fn are_joined(&self, a: usize, b: usize) -> bool {
        let parts = in_order([self.parts[a], self.parts[b]]);
        parts[0] == parts[1] || self.joined.binary_search(&parts).is_ok()
    }

    /// Removes connections by joints, chosen by a link of each of both parts.
    pub(super) fn separate(&mut self, is_removed: impl Fn([usize; 2]) -> bool) {
        self.joined.retain(|parts| !is_removed(*parts));
    }

    /// Whether two links belong to one robot.
    pub(super) fn are_of_one_robot(&self, a: usize, b: usize) -> bool {
        self.robots[a] == self.robots[b]
    }
}

fn in_order([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// The connected component of each of `n` nodes, by its smallest node.
fn components(n: usize, edges: impl Iterator<Item = (usize, usize)>) -> Vec<usize> {
    fn root(parents: &[usize], mut k: usize) -> usize {
        while parents[k] != k {
            k = parents[k];
        }
        k
    }
    let mut parents: Vec<usize> = (0..n).collect();
    for (a, b) in edges {
        let [first, second] = in_order([root(&parents, a), root(&parents, b)]);
        parents[second] = first;
    }
    (0..n).map(|k| root(&parents, k)).collect()
}

#[cfg(test)]
mod tests {
    use super::components;

    #[test]
    fn components_are_named_by_their_smallest_node() {
        let edges = [(4, 2), (1, 3), (3, 4)];
        assert_eq!(components(6, edges.into_iter()), [0, 1, 1, 1, 1, 5]);
    }
}
