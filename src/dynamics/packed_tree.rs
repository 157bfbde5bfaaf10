//! Bodies of different branches side by side, so that what is done to one of them can be done to several at once.

use std::cmp::Reverse;
use std::collections::VecDeque;
use std::mem::discriminant;

use crate::joint::JointKind;
use crate::model::{Body, BodyId};
use crate::scalar::{Lanes, Scalar};
use crate::spatial::{Inertia, Transform};

/// Bodies that stand side by side.
pub(crate) const WIDTH: usize = 4;

/// The bodies of a robot in rows, one body in each lane: all of a row have joints of one kind and hang on one row before it, which
/// makes of the rows a tree of their own. What lanes are left over repeat others of their row.
///
/// Where a robot is one body after the other from the world on, before it branches, these stand alone: its trunk.
#[derive(Clone, Debug)]
pub(crate) struct PackedTree {
    /// Number of bodies in the trunk, the unbranched prefix of the tree.
    pub(crate) trunk: usize,
    /// Those nearer to the world come first. The first stands for the last body of the trunk, or for the world, in all lanes.
    pub(crate) rows: Vec<Level>,
    /// The rows as bodies of a tree, with the numbers of the bodies in their lanes.
    pub(crate) bodies: Vec<Body<Lanes<WIDTH>>>,
    /// Armature of the coordinates of the rows.
    pub(crate) armature: Vec<Lanes<WIDTH>>,
    /// Which entry of q each lane of each coordinate of the rows has.
    pub(crate) q: Vec<usize>,
    /// Gather map of v: its entry for each lane of each coordinate of the rows.
    pub(crate) v: Vec<usize>,
}

/// Bodies side by side.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Level {
    pub(crate) bodies: [usize; WIDTH],
    /// The lane of the row before that carries each lane; `None` if each is carried by its own.
    pub(crate) carriers: Option<[usize; WIDTH]>,
    /// Children that the lanes carry, in the order in which they are summed up: those of a body from the last to the first.
    pub(crate) loads: Vec<Gather>,
}

/// A child of each lane, in the lanes of another row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gather {
    pub(crate) row: usize,
    /// Whether a lane carries something of it.
    pub(crate) carries: [bool; WIDTH],
    /// The lane of that; any, if there is none.
    pub(crate) lanes: [usize; WIDTH],
    /// Whether each lane carries its own.
    pub(crate) straight: bool,
}

/// Each lane by itself.
const STRAIGHT: [usize; WIDTH] = [0, 1, 2, 3];

impl PackedTree {
    /// The rows of a robot, where they are so much fewer than its bodies that it pays to work on rows. Joints must not follow others.
    pub(super) fn worthwhile<P: Scalar>(bodies: &[Body<P>], armature: &[P]) -> Option<Self> {
        if bodies.iter().any(|body| body.coupling.is_some()) {
            return None;
        }
        let (tree, n) = (Branches::of(bodies), bodies.len());
        // There are at least as many rows as bodies on the longest branch.
        let longest = tree
            .height
            .iter()
            .max()
            .map_or(0, |height| height - tree.trunk());
        if !pays(tree.trunk(), longest, n) {
            return None;
        }
        let out = Self::of_tree(&tree, bodies, armature);
        pays(out.trunk, out.rows.len() - 1, n).then_some(out)
    }

    /// The rows of any robot whose joints do not follow others.
    #[cfg(test)]
    pub(crate) fn of<P: Scalar>(bodies: &[Body<P>], armature: &[P]) -> Self {
        Self::of_tree(&Branches::of(bodies), bodies, armature)
    }

    fn of_tree<P: Scalar>(tree: &Branches, bodies: &[Body<P>], armature: &[P]) -> Self {
        let trunk = tree.trunk();
        let tip = trunk.checked_sub(1);
        let mut out = Self {
            trunk,
            rows: Vec::new(),
            bodies: Vec::new(),
            armature: Vec::new(),
            q: Vec::new(),
            v: Vec::new(),
        };
        out.stand_for(tip);
        let start = tip.map_or(&tree.roots, |tip| &tree.children[tip]);
        let mut open = VecDeque::from([(tip.map(|_| BodyId(0)), start.clone())]);
        while let Some((parent, mut children)) = open.pop_front() {
            // The longest side by side, so that rows stay full for long.
            children.sort_by_key(|&i| (kind(&bodies[i]), Reverse(tree.height[i])));
            for same in children.chunk_by(|&i, &j| kind(&bodies[i]) == kind(&bodies[j])) {
                for abreast in same.chunks(WIDTH) {
                    let row = BodyId(out.rows.len());
                    out.add(bodies, parent, abreast);
                    let carried = abreast.iter().flat_map(|&i| &tree.children[i]);
                    open.push_back((Some(row), carried.copied().collect()));
                }
            }
        }
        out.load(tree);
        out.fill(bodies, armature);
        out
    }

    fn add<P>(&mut self, bodies: &[Body<P>], parent: Option<BodyId>, abreast: &[usize]) {
        let own: [usize; WIDTH] =
            std::array::from_fn(|lane| *abreast.get(lane).unwrap_or(&abreast[0]));
        let carriers = std::array::from_fn(|lane| {
            let carrier = bodies[own[lane]].parent;
            carrier
                .zip(parent)
                .map_or(lane, |(body, row)| self.rows[row.0].lane_of(body.0, lane))
        });
        let joint = bodies[abreast[0]].joint;
        let (q, v) = (self.q.len() / WIDTH, self.v.len() / WIDTH);
        for k in 0..joint.nq() {
            self.q.extend(own.map(|i| bodies[i].q + k));
        }
        for k in 0..joint.nv() {
            self.v.extend(own.map(|i| bodies[i].v + k));
        }
        self.push(own, carriers, (parent, joint), (q, v));
    }

    /// The row that stands for a body or for the world.
    fn stand_for(&mut self, body: Option<usize>) {
        let bodies = [body.unwrap_or(0); WIDTH];
        self.push(bodies, STRAIGHT, (None, JointKind::Fixed), (0, 0));
    }

    fn push(
        &mut self,
        bodies: [usize; WIDTH],
        carriers: [usize; WIDTH],
        (parent, joint): (Option<BodyId>, JointKind),
        (q, v): (usize, usize),
    ) {
        self.rows.push(Level {
            bodies,
            carriers: (carriers != STRAIGHT).then_some(carriers),
            loads: Vec::new(),
        });
        self.bodies.push(Body {
            parent,
            joint,
            placement: Transform::identity(),
            inertia: Inertia::zero(),
            q,
            v,
            coupling: None,
            subtree_end: 0,
        });
    }

    /// Takes the numbers of the bodies.
    fn fill<P: Scalar>(&mut self, bodies: &[Body<P>], armature: &[P]) {
        for (row, to) in self.rows.iter().zip(&mut self.bodies).skip(1) {
            let own = row.bodies.map(|i| &bodies[i]);
            to.placement =
                Transform::from_entries(lanes(own.map(|body| body.placement.to_entries())));
            to.inertia =
                Inertia::from_parameters(lanes(own.map(|body| body.inertia.to_parameters())));
        }
        let of = |v: &[usize]| Lanes(std::array::from_fn(|lane| armature[v[lane]].value(0)));
        self.armature = self.v.chunks(WIDTH).map(of).collect();
    }

    /// Notes what each row carries.
    fn load(&mut self, tree: &Branches) {
        let mut row_of = vec![0; tree.height.len()];
        for (k, row) in self.rows.iter().enumerate().skip(1) {
            row.bodies.iter().for_each(|&i| row_of[i] = k);
        }
        for k in usize::from(self.trunk == 0)..self.rows.len() {
            self.rows[k].loads = self.loads(k, tree, &row_of);
        }
    }

    fn loads(&self, k: usize, tree: &Branches, row_of: &[usize]) -> Vec<Gather> {
        let bodies = self.rows[k].bodies;
        let most = bodies.iter().map(|&i| tree.children[i].len()).max();
        let mut loads: Vec<Gather> = Vec::new();
        for nth in 0..most.unwrap_or(0) {
            let start = loads.len();
            for (lane, &i) in bodies.iter().enumerate() {
                let Some(&child) = tree.children[i].iter().rev().nth(nth) else {
                    continue;
                };
                let row = row_of[child];
                let from = self.rows[row].lane_of(child, lane);
                let known = loads[start..].iter().position(|load| load.row == row);
                let at = known.map_or(loads.len(), |k| start + k);
                if at == loads.len() {
                    loads.push(Gather::of(row));
                }
                (loads[at].carries[lane], loads[at].lanes[lane]) = (true, from);
            }
        }
        for load in &mut loads {
            load.straight = load.carries == [true; WIDTH] && load.lanes == STRAIGHT;
        }
        loads
    }
}

impl Gather {
    fn of(row: usize) -> Self {
        Self {
            row,
            carries: [false; WIDTH],
            lanes: STRAIGHT,
            straight: false,
        }
    }
}

impl Level {
    /// Where a body stands: in a lane rather than in another that repeats it.
    fn lane_of(&self, body: usize, lane: usize) -> usize {
        if self.bodies[lane] == body {
            return lane;
        }
        let place = self.bodies.iter().position(|&own| own == body);
        place.expect("the row holds the body")
    }
}

/// Which bodies each body carries.
struct Branches {
    roots: Vec<usize>,
    children: Vec<Vec<usize>>,
    /// Bodies on the longest way to a tip.
    height: Vec<usize>,
}

impl Branches {
    /// Bodies before the first branching.
    fn trunk(&self) -> usize {
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

/// Whether working on a trunk and rows takes less time than on all bodies alone.
fn pays(trunk: usize, rows: usize, bodies: usize) -> bool {
    // Measured: a row takes the time of so many bodies that are worked on alone.
    const ROW: f64 = 1.8;
    const WORTHWHILE: f64 = 0.9;
    trunk as f64 + ROW * (rows as f64) < WORTHWHILE * bodies as f64
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

/// Arrays side by side.
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

    fn assert_holds(model: &Model, rows: &PackedTree) {
        let bodies = model.bodies();
        let mut seen = vec![false; bodies.len()];
        seen[..rows.trunk].fill(true);
        for (k, row) in rows.rows.iter().enumerate() {
            if (k, rows.trunk) == (0, 0) {
                continue;
            }
            let parent = rows.bodies[k].parent;
            for (lane, &i) in row.bodies.iter().enumerate() {
                seen[i] = true;
                assert_eq!(kind(&bodies[i]), kind(&bodies[row.bodies[0]]));
                let carrier =
                    parent.map(|p| rows.rows[p.0].bodies[row.carriers.unwrap_or(STRAIGHT)[lane]]);
                assert!(k == 0 || carrier == bodies[i].parent.map(|p| p.0));
                assert!(parent.is_none_or(|p| p.0 < k));
                let loads = row
                    .loads
                    .iter()
                    .filter(|load| load.carries[lane])
                    .map(|load| (load.row, load.lanes[lane]));
                let carried: Vec<usize> = loads
                    .map(|(row, lane)| rows.rows[row].bodies[lane])
                    .collect();
                let children = (0..bodies.len())
                    .rev()
                    .filter(|&j| bodies[j].parent == Some(BodyId(i)));
                assert_eq!(
                    carried,
                    children.collect::<Vec<_>>(),
                    "what body {i} carries"
                );
            }
        }
        assert!(seen.iter().all(|&seen| seen));
    }

    #[test]
    fn rows_hold_every_body_with_its_parent_and_all_that_it_carries() {
        for seed in 0..200 {
            let model = samples::random_tree(1 + seed as usize % 23, seed);
            assert_holds(&model, &PackedTree::of(model.bodies(), model.armature()));
        }
    }

    #[test]
    fn legs_of_a_quadruped_stand_side_by_side() {
        let model = Model::from_urdf_file("assets/quadruped.urdf").unwrap();
        let rows = PackedTree::worthwhile(model.bodies(), model.armature()).unwrap();
        assert_eq!(rows.rows.len(), 4);
        assert_eq!(rows.rows[0].bodies, [0; WIDTH]);
        assert!(rows.rows.iter().all(|row| row.carriers.is_none()));
        assert_eq!((rows.trunk, rows.q.len(), rows.v.len()), (1, 12, 12));
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
