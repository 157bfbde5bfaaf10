//! SIMD-packed tree of a robot: bodies of different branches in the lanes of one vector, so that one instruction works on all of them.

use std::cmp::Reverse;
use std::collections::VecDeque;
use std::mem::discriminant;

use crate::joint::JointKind;
use crate::model::{Body, BodyId};
use crate::scalar::{Lanes, MapEach, Scalar, from_each};
use crate::sorting::sort_indices;
use crate::spatial::{Inertia, Transform};

pub(crate) use crate::scalar::LEVEL as WIDTH;

/// Bodies of a robot in packed levels, one body a lane: all of a level have joints of one kind, and their parents are in one level before
/// it, so that the levels are a tree of their own. Lanes that are left over repeat the first body of their level.
///
/// The unbranched prefix of a robot, one body after the other from the world to the first branching, is not packed.
#[derive(Clone, Debug)]
pub(crate) struct PackedTree {
    /// Number of bodies in the unbranched prefix.
    pub(crate) prefix: usize,
    /// Levels, those nearer to the world first. The first one repeats the last body of the prefix, or represents the world, in all lanes.
    pub(crate) levels: Vec<Level>,
    /// Levels as bodies of a tree, with the numbers of the bodies in their lanes.
    pub(crate) bodies: Vec<Body<Lanes<WIDTH>>>,
    /// Armature of the coordinates of the levels.
    pub(crate) armature: Vec<Lanes<WIDTH>>,
    /// Gather map of q: its entry for each lane of each coordinate of the levels.
    pub(crate) q: Vec<usize>,
    /// Gather map of v: its entry for each lane of each coordinate of the levels.
    pub(crate) v: Vec<usize>,
    /// Level and lane of each body; `None` in the prefix.
    pub(crate) places: Vec<Option<[usize; 2]>>,
}

/// A packed level: bodies side by side.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Level {
    /// Index of the body in each lane.
    pub(crate) bodies: [usize; WIDTH],
    /// Lane of each lane's parent in the level before; `None` if it is the same lane for all.
    pub(crate) parent_lanes: Option<[usize; WIDTH]>,
    /// Children of the lanes, in the order in which they are summed up: those of a body from the last to the first.
    pub(crate) children: Vec<Gather>,
}

/// Gather map of one child of each lane, from the lanes of another level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gather {
    /// Index of the level of the children.
    pub(crate) level: usize,
    /// Whether a lane has such a child.
    pub(crate) present: [bool; WIDTH],
    /// Lane of the child; any, if there is none.
    pub(crate) lanes: [usize; WIDTH],
    /// Whether every lane has a child, in the same lane.
    pub(crate) aligned: bool,
}

/// Parent lanes where each lane's parent is in the same lane.
const SAME_LANES: [usize; WIDTH] = [0, 1, 2, 3];

impl PackedTree {
    /// Packs a robot whose levels are so much fewer than its bodies that it pays; `None` for others, and where joints follow others.
    pub(super) fn worthwhile<P: Scalar>(bodies: &[Body<P>], armature: &[P]) -> Option<Self> {
        if bodies.iter().any(|body| body.coupling.is_some()) {
            return None;
        }
        let (tree, n) = (Branches::of(bodies), bodies.len());
        // There are at least as many levels as bodies on the longest branch.
        let longest = tree
            .height
            .iter()
            .max()
            .map_or(0, |height| height - tree.prefix());
        if !pays(tree.prefix(), longest, n) {
            return None;
        }
        let out = Self::of_tree(&tree, bodies, armature);
        pays(out.prefix, out.levels.len() - 1, n).then_some(out)
    }

    /// Packs any robot whose joints do not follow others.
    #[cfg(test)]
    pub(crate) fn of<P: Scalar>(bodies: &[Body<P>], armature: &[P]) -> Self {
        Self::of_tree(&Branches::of(bodies), bodies, armature)
    }

    fn of_tree<P: Scalar>(tree: &Branches, bodies: &[Body<P>], armature: &[P]) -> Self {
        let prefix = tree.prefix();
        let tip = prefix.checked_sub(1);
        let mut out = Self {
            prefix,
            levels: Vec::new(),
            bodies: Vec::new(),
            armature: Vec::new(),
            q: Vec::new(),
            v: Vec::new(),
            places: vec![None; bodies.len()],
        };
        out.push_root(tip);
        let start = tip.map_or(&tree.roots, |tip| &tree.children[tip]);
        let mut open = VecDeque::from([(tip.map(|_| BodyId(0)), start.clone())]);
        while let Some((parent, mut children)) = open.pop_front() {
            // The longest side by side, so that levels stay full for long.
            let key = |i: usize| (kind(&bodies[i]), Reverse(tree.height[i]));
            sort_indices(&mut children, &|i, j| key(i).cmp(&key(j)));
            for same in children.chunk_by(|&i, &j| kind(&bodies[i]) == kind(&bodies[j])) {
                for packed in same.chunks(WIDTH) {
                    let level = BodyId(out.levels.len());
                    out.push_level(bodies, parent, packed);
                    let children = packed.iter().flat_map(|&i| &tree.children[i]);
                    open.push_back((Some(level), children.copied().collect()));
                }
            }
        }
        out.gather_children(tree);
        out.fill(bodies, armature);
        out.find_places();
        out
    }

    /// Adds a level of up to [`WIDTH`] bodies with joints of one kind, whose parents are in the level `parent`.
    fn push_level<P>(&mut self, bodies: &[Body<P>], parent: Option<BodyId>, packed: &[usize]) {
        let own: [usize; WIDTH] = from_each(|lane| *packed.get(lane).unwrap_or(&packed[0]));
        let parent_lanes = from_each(|lane| {
            let parent_body = bodies[own[lane]].parent;
            parent_body.zip(parent).map_or(lane, |(body, level)| {
                self.levels[level.0].lane_of(body.0, lane)
            })
        });
        let joint = bodies[packed[0]].joint;
        self.push(own, parent_lanes, parent, joint);
        for k in 0..joint.nq() {
            self.q.extend(own.map(|i| bodies[i].q + k));
        }
        for k in 0..joint.nv() {
            self.v.extend(own.map(|i| bodies[i].v + k));
        }
    }

    /// Adds the level that repeats the last body of the prefix, or represents the world.
    fn push_root(&mut self, tip: Option<usize>) {
        self.push(
            [tip.unwrap_or(0); WIDTH],
            SAME_LANES,
            None,
            JointKind::Fixed,
        );
    }

    /// Adds a level, and the body that it is in the packed tree, with coordinates after those of the levels before.
    fn push(
        &mut self,
        bodies: [usize; WIDTH],
        parent_lanes: [usize; WIDTH],
        parent: Option<BodyId>,
        joint: JointKind,
    ) {
        self.levels.push(Level {
            bodies,
            parent_lanes: (parent_lanes != SAME_LANES).then_some(parent_lanes),
            children: Vec::new(),
        });
        self.bodies.push(Body {
            parent,
            joint,
            placement: Transform::identity(),
            inertia: Inertia::zero(),
            q: self.q.len() / WIDTH,
            v: self.v.len() / WIDTH,
            coupling: None,
            subtree_end: 0,
        });
    }

    /// Packs placements, inertias and armatures of the bodies into the levels.
    fn fill<P: Scalar>(&mut self, bodies: &[Body<P>], armature: &[P]) {
        for (level, to) in self.levels.iter().zip(&mut self.bodies).skip(1) {
            let own = level.bodies.map_each(|i| &bodies[i]);
            to.placement =
                Transform::from_entries(lanes(own.map_each(|body| body.placement.to_entries())));
            to.inertia =
                Inertia::from_parameters(lanes(own.map_each(|body| body.inertia.to_parameters())));
        }
        let of = |v: &[usize]| Lanes(from_each(|lane| armature[v[lane]].value(0)));
        self.armature = self.v.chunks(WIDTH).map(of).collect();
    }

    fn find_places(&mut self) {
        for (k, level) in self.levels.iter().enumerate().skip(1) {
            for (lane, &i) in level.bodies.iter().enumerate() {
                self.places[i].get_or_insert([k, lane]);
            }
        }
    }

    /// Finds the gather maps of the children of each level.
    fn gather_children(&mut self, tree: &Branches) {
        let mut level_of = vec![0; tree.height.len()];
        for (k, level) in self.levels.iter().enumerate().skip(1) {
            level.bodies.iter().for_each(|&i| level_of[i] = k);
        }
        for k in usize::from(self.prefix == 0)..self.levels.len() {
            self.levels[k].children = self.children(k, tree, &level_of);
        }
    }

    /// Returns the gather maps of the children of level `k`.
    fn children(&self, k: usize, tree: &Branches, level_of: &[usize]) -> Vec<Gather> {
        let bodies = self.levels[k].bodies;
        let most = bodies.iter().map(|&i| tree.children[i].len()).max();
        let mut maps: Vec<Gather> = Vec::new();
        for nth in 0..most.unwrap_or(0) {
            let start = maps.len();
            for (lane, &i) in bodies.iter().enumerate() {
                let Some(&child) = tree.children[i].iter().rev().nth(nth) else {
                    continue;
                };
                let level = level_of[child];
                let from = self.levels[level].lane_of(child, lane);
                let known = maps[start..].iter().position(|map| map.level == level);
                let at = known.map_or(maps.len(), |k| start + k);
                if at == maps.len() {
                    maps.push(Gather::of(level));
                }
                (maps[at].present[lane], maps[at].lanes[lane]) = (true, from);
            }
        }
        for map in &mut maps {
            map.aligned = map.present == [true; WIDTH] && map.lanes == SAME_LANES;
        }
        maps
    }
}

impl Gather {
    fn of(level: usize) -> Self {
        Self {
            level,
            present: [false; WIDTH],
            lanes: SAME_LANES,
            aligned: false,
        }
    }
}

impl Level {
    /// Lane of a body: `lane` if it is there, rather than another that repeats it.
    fn lane_of(&self, body: usize, lane: usize) -> usize {
        if self.bodies[lane] == body {
            return lane;
        }
        let place = self.bodies.iter().position(|&own| own == body);
        place.expect("the level holds the body")
    }
}

/// Children and heights of all bodies.
struct Branches {
    /// Bodies on the world.
    roots: Vec<usize>,
    /// Children of each body.
    children: Vec<Vec<usize>>,
    /// Number of bodies on the longest way from each body to a leaf, itself included.
    height: Vec<usize>,
}

impl Branches {
    /// Number of bodies before the first branching.
    fn prefix(&self) -> usize {
        let mut siblings = &self.roots;
        let mut bodies = 0;
        while let [only] = siblings[..] {
            siblings = &self.children[only];
            bodies += 1;
        }
        bodies
    }

    fn of<P>(bodies: &[Body<P>]) -> Self {
        let mut out = Self {
            roots: Vec::new(),
            children: vec![Vec::new(); bodies.len()],
            height: vec![1; bodies.len()],
        };
        for (i, body) in bodies.iter().enumerate() {
            let siblings = body
                .parent
                .map_or(&mut out.roots, |p| &mut out.children[p.0]);
            siblings.push(i);
        }
        for (i, body) in bodies.iter().enumerate().rev() {
            if let Some(BodyId(p)) = body.parent {
                out.height[p] = out.height[p].max(out.height[i] + 1);
            }
        }
        out
    }
}

/// Whether working on a prefix and packed levels takes less time than on all bodies one by one.
fn pays(prefix: usize, levels: usize, bodies: usize) -> bool {
    // Measured: a level takes the time of so many bodies that are worked on one by one.
    const LEVEL: f64 = 1.8;
    // So much less time must it take that the memory of the levels is worth it.
    const WORTHWHILE: f64 = 0.9;
    prefix as f64 + LEVEL * (levels as f64) < WORTHWHILE * bodies as f64
}

/// A number for joints that move alike: that of the kind, and of a screw also the pitch.
fn kind<P>(body: &Body<P>) -> (usize, u64) {
    let alike = |other: &JointKind| match (other, body.joint) {
        (JointKind::Revolute, JointKind::Continuous) => true,
        (other, own) => discriminant(other) == discriminant(&own),
    };
    let place = JointKind::ALL.iter().position(alike);
    let pitch = match body.joint {
        JointKind::Screw(pitch) => pitch.metres_per_radian().to_bits(),
        _ => 0,
    };
    (place.unwrap_or(JointKind::ALL.len()), pitch)
}

/// Packs arrays into lanes.
#[inline(always)]
pub(crate) fn lanes<T: Scalar, const N: usize>(own: [[T; N]; WIDTH]) -> [Lanes<WIDTH>; N] {
    let mut out = [Lanes([0.0; WIDTH]); N];
    for (k, out) in out.iter_mut().enumerate() {
        for lane in 0..WIDTH {
            out.0[lane] = own[lane][k].value(0);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Model, samples};

    fn assert_holds(model: &Model, packed: &PackedTree) {
        let bodies = model.bodies();
        let mut seen = vec![false; bodies.len()];
        seen[..packed.prefix].fill(true);
        for (k, level) in packed.levels.iter().enumerate() {
            if (k, packed.prefix) == (0, 0) {
                continue;
            }
            let parent = packed.bodies[k].parent;
            for (lane, &i) in level.bodies.iter().enumerate() {
                seen[i] = true;
                assert_eq!(kind(&bodies[i]), kind(&bodies[level.bodies[0]]));
                let packed_parent = parent.map(|p| {
                    packed.levels[p.0].bodies[level.parent_lanes.unwrap_or(SAME_LANES)[lane]]
                });
                assert!(k == 0 || packed_parent == bodies[i].parent.map(|p| p.0));
                assert!(parent.is_none_or(|p| p.0 < k));
                let maps = level.children.iter().filter(|map| map.present[lane]);
                let packed_children: Vec<usize> = maps
                    .map(|map| packed.levels[map.level].bodies[map.lanes[lane]])
                    .collect();
                let children = (0..bodies.len())
                    .rev()
                    .filter(|&j| bodies[j].parent == Some(BodyId(i)));
                assert_eq!(
                    packed_children,
                    children.collect::<Vec<_>>(),
                    "children of body {i}"
                );
            }
        }
        assert!(seen.iter().all(|&seen| seen));
    }

    #[test]
    fn levels_hold_every_body_with_its_parent_and_all_its_children() {
        for seed in 0..200 {
            let model = samples::random_tree(1 + seed as usize % 23, seed);
            assert_holds(&model, &PackedTree::of(model.bodies(), model.armature()));
        }
    }

    #[test]
    fn legs_of_a_quadruped_stand_side_by_side() {
        let model = Model::from_urdf_file("assets/quadruped.urdf").unwrap();
        let packed = PackedTree::worthwhile(model.bodies(), model.armature()).unwrap();
        assert_eq!(packed.levels.len(), 4);
        assert_eq!(packed.levels[0].bodies, [0; WIDTH]);
        assert!(
            packed
                .levels
                .iter()
                .all(|level| level.parent_lanes.is_none())
        );
        assert_eq!((packed.prefix, packed.q.len(), packed.v.len()), (1, 12, 12));
    }

    #[test]
    fn chains_and_robots_with_followers_stay_as_they_are() {
        let arm = samples::arm();
        assert!(PackedTree::worthwhile(arm.bodies(), arm.armature()).is_none());
        let panda = Model::from_urdf_file("assets/panda.urdf").unwrap();
        assert!(PackedTree::worthwhile(panda.bodies(), panda.armature()).is_none());
        assert!(PackedTree::worthwhile::<f64>(&[], &[]).is_none());
    }
}
