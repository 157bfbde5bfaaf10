//! Articulated-body algorithm over a SIMD-packed tree: bodies of different branches in the lanes of the vector units. Every lane goes
//! through the operations that its body goes through alone, in their order, so the bits are the same.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::{Add, Range};

use super::aba::{ALL, Driven, Working, accelerations, inward, outward};
use super::packed_tree::{Gather, PackedTree, WIDTH, lanes};
use super::rnea::{RneaScratch, world_acceleration};
use super::tree::{Bodies, Tree};
use crate::model::{Body, BodyId, Model};
use crate::nested::IntoNested;
use crate::scalar::{Lanes, MapEach, Over, Scalar, pairs};
use crate::spatial::{ArticulatedInertia, Force, Motion, Transform};

type Lane = Lanes<WIDTH>;

/// Index of the first level, of which nothing is eliminated.
const NOTHING: usize = 0;

/// Working memory for the levels of a packed tree.
#[derive(Clone, Debug)]
pub(super) struct PackedScratch {
    q: Vec<Lane>,
    v: Vec<Lane>,
    tau: Vec<Lane>,
    /// Empty if there is none.
    resistance: Vec<Lane>,
    a: Vec<Lane>,
    /// Empty if there are none.
    external: Vec<Force<Lane>>,
    working: Working<Lane>,
}

impl PackedScratch {
    /// Memory for the levels of a robot.
    pub(super) fn new(packed: &PackedTree) -> Self {
        let (nq, nv) = (packed.q.len() / WIDTH, packed.v.len() / WIDTH);
        let n = packed.levels.len();
        let zeros = |n| vec![Lane::constant(0.0); n];
        Self {
            q: zeros(nq),
            v: zeros(nv),
            tau: zeros(nv),
            resistance: Vec::with_capacity(nv),
            a: zeros(nv),
            external: Vec::with_capacity(n),
            working: Working::new(n, nq, nv),
        }
    }

    /// Computes the accelerations of a model that `packed` was made from: the prefix body by body, the rest level by level.
    ///
    /// * `prefix` – working memory for the bodies of the unbranched prefix, at least
    /// * `a` – output, length `nv`
    pub(super) fn accelerations<P: Scalar, T: Over<P>>(
        &mut self,
        model: &Model<P>,
        packed: &PackedTree,
        prefix: &mut Working<T>,
        driven: &Driven<'_, T>,
        a: &mut [T],
    ) {
        assert_eq!(
            self.working.V.len(),
            packed.levels.len(),
            "the scratch belongs to another model than \"{}\"",
            model.name()
        );
        let bodies = Bodies::first(model, packed.prefix);
        let nq = model.bodies()[..packed.prefix]
            .last()
            .map_or(0, |tip| tip.q + tip.joint.nq());
        outward(&bodies, &driven.q[..nq], driven.v, driven.external, prefix);
        let A_W = world_acceleration(model);
        Lane::vectorized(
            #[inline(always)]
            || {
                self.gather(packed, driven);
                self.start(packed, prefix);
            },
        );
        let (mut level, mut last) = (Some(ALL), ALL);
        for passes in 1.. {
            if let Some(level) = level {
                Lane::vectorized(
                    #[inline(always)]
                    || self.eliminate(packed, &A_W, level),
                );
                self.accumulate_into_prefix(packed, prefix);
            }
            prefix.resist(model.armature(), driven.resistance);
            inward(&bodies, driven.tau, &A_W, last, prefix);
            accelerations(&bodies, &A_W, prefix, a);
            Lane::vectorized(
                #[inline(always)]
                || self.accelerate(packed, prefix, &A_W, a),
            );
            if !prefix.friction.act() {
                return;
            }
            self.review(packed, &bodies, prefix, a);
            level = self.working.friction.last;
            let changed = level.map_or(prefix.friction.last, |_| Some(ALL));
            match changed.filter(|_| prefix.friction.may_go_on(passes)) {
                Some(changed) => last = changed,
                None => break,
            }
            prefix.restart(&bodies, driven.external, last);
            let of_levels = level.unwrap_or(NOTHING);
            self.working.restart(packed, &self.external, of_levels);
        }
        let pieces = self.working.friction.all.iter();
        let pieces = pieces.nested(|own| own.piece.0);
        for (&index, piece) in pairs(&packed.v, pieces) {
            prefix.friction.all[index].piece = T::from(piece);
        }
    }

    /// Hands the motions of some bodies at the last accelerations to the working memory of inverse dynamics.
    pub(super) fn copy_motions<T: Scalar>(
        &self,
        packed: &PackedTree,
        prefix: &Working<T>,
        bodies: &[usize],
        out: &mut RneaScratch<T>,
    ) {
        let working = &self.working;
        for &i in bodies {
            let Some([level, lane]) = packed.places[i] else {
                out.set_motion(i, prefix.factor.X_PB[i], prefix.V[i], prefix.A[i]);
                continue;
            };
            // Where they lie: copies of all lanes would be most of the work.
            let Transform {
                rotation: R,
                translation: p,
            } = &working.factor.X_PB[level];
            let [V, A] = [&working.V, &working.A]
                .map_each(|own| Motion::from_array(in_lane(own[level].entries(), lane)));
            let rows = [
                &R.m11, &R.m12, &R.m13, &R.m21, &R.m22, &R.m23, &R.m31, &R.m32, &R.m33, &p.x, &p.y,
                &p.z,
            ];
            let X_PB = Transform::from_entries(in_lane(rows, lane));
            out.set_motion(i, X_PB, V, A);
        }
    }

    /// Pass outward along the levels: velocities.
    #[inline(always)]
    fn start<T: Scalar>(&mut self, packed: &PackedTree, prefix: &Working<T>) {
        let working = &mut self.working;
        if let Some(tip) = packed.prefix.checked_sub(1) {
            working.V[0] = broadcast(&prefix.V[tip]);
        }
        outward(packed, &self.q, &self.v, &self.external, working);
        working.friction.gather(&packed.v, &prefix.friction);
    }

    /// Pass inward along the levels, up to the last one that is eliminated otherwise than before: articulated inertias and bias forces.
    #[inline(always)]
    fn eliminate<T: Scalar>(&mut self, packed: &PackedTree, A_W: &Motion<T>, last: usize) {
        let working = &mut self.working;
        working.resist(&packed.armature, &self.resistance);
        inward(packed, &self.tau, &broadcast(A_W), last, working);
    }

    /// Counts by how many pieces decisions about friction differ from those that the accelerations suggest.
    fn review<P: Scalar, T: Over<P>>(
        &mut self,
        packed: &PackedTree,
        bodies: &Bodies<'_, P>,
        prefix: &mut Working<T>,
        a: &[T],
    ) {
        prefix.review(bodies, a);
        Lane::vectorized(
            #[inline(always)]
            || self.working.review(packed, &self.a),
        );
        let packed: f64 = self.working.friction.changes.0.iter().sum();
        prefix.friction.changes += T::from(packed);
    }

    /// Accumulates the articulated forces and inertias of the packed levels into the tip of the unbranched prefix.
    fn accumulate_into_prefix<T: Scalar>(&self, packed: &PackedTree, prefix: &mut Working<T>) {
        let Some(tip) = packed.prefix.checked_sub(1) else {
            return;
        };
        for map in &packed.levels[0].children {
            if !map.present[0] {
                continue;
            }
            let lane = map.lanes[0];
            let (F, I) = (
                &self.working.F[map.level],
                &self.working.factor.I[map.level],
            );
            prefix.F[tip] += Force::from_array(in_lane(F.entries(), lane));
            let I = ArticulatedInertia::from_entries(in_lane(I.entries(), lane));
            prefix.factor.I[tip] = prefix.factor.I[tip] + I;
        }
    }

    /// Pass outward along the levels: accelerations, from those of the prefix or of the world, scattered to `a`.
    #[inline(always)]
    fn accelerate<T: Scalar>(
        &mut self,
        packed: &PackedTree,
        prefix: &Working<T>,
        A_W: &Motion<T>,
        a: &mut [T],
    ) {
        let working = &mut self.working;
        if let Some(tip) = packed.prefix.checked_sub(1) {
            working.A[0] = broadcast(&prefix.A[tip]);
        }
        accelerations(packed, &broadcast(A_W), working, &mut self.a);
        for (&index, x) in pairs(&packed.v, self.a.iter().nested(|x| x.0)) {
            a[index] = T::from(x);
        }
    }

    /// Gathers state and forces of the packed bodies into lanes.
    #[inline(always)]
    fn gather<T: Scalar>(&mut self, packed: &PackedTree, driven: &Driven<'_, T>) {
        gather(&packed.q, driven.q, &mut self.q);
        gather(&packed.v, driven.v, &mut self.v);
        gather(&packed.v, driven.tau, &mut self.tau);
        self.resistance.clear();
        if !driven.resistance.is_empty() {
            self.resistance.resize(self.tau.len(), Lane::constant(0.0));
            gather(&packed.v, driven.resistance, &mut self.resistance);
        }
        self.gather_forces(packed, driven.external);
    }

    #[inline(always)]
    fn gather_forces<T: Scalar>(&mut self, packed: &PackedTree, external: &[Force<T>]) {
        self.external.clear();
        if external.is_empty() {
            return;
        }
        for level in &packed.levels {
            let own = level.bodies.map_each(|i| external[i].to_array());
            self.external.push(Force::from_array(lanes(own)));
        }
    }
}

impl Tree<Lane, Lane> for PackedTree {
    #[inline(always)]
    fn range(&self) -> Range<usize> {
        1..self.levels.len()
    }

    #[inline(always)]
    fn bodies(&self) -> &[Body<Lane>] {
        &self.bodies
    }

    #[inline(always)]
    fn parent_motion(&self, i: usize, p: BodyId, motions: &[Motion<Lane>]) -> Motion<Lane> {
        let V = &motions[p.0];
        let Some(parent_lanes) = self.levels[i].parent_lanes else {
            return *V;
        };
        // Written in place: numbers by themselves would be combined one by one, not four at once.
        let mut V = V.to_array();
        for x in &mut V {
            *x = permuted(x, parent_lanes);
        }
        Motion::from_array(V)
    }

    /// What they hand down is kept.
    #[inline(always)]
    fn repeats(&self, _: usize, _: usize) -> bool {
        false
    }

    #[inline(always)]
    fn starts_anew(&self, i: usize, last: usize) -> bool {
        i <= last
    }

    #[inline(always)]
    fn add_to_parent<X: Copy + Add<Output = X>>(&self, i: usize, _: BodyId, x: X, all: &mut [X]) {
        // Kept, until the level of the parents gathers it.
        all[i] = x;
    }

    #[inline(always)]
    fn add_children(
        &self,
        i: usize,
        forces: &mut [Force<Lane>],
        inertias: &mut [ArticulatedInertia<Lane>],
    ) {
        for map in &self.levels[i].children {
            if map.aligned {
                forces[i] += forces[map.level];
                inertias[i] = inertias[i] + inertias[map.level];
            } else {
                let (own, x) = own_and_other(forces, i, map.level);
                add_gathered(own.entries_mut(), x.entries(), map);
                let (own, x) = own_and_other(inertias, i, map.level);
                add_gathered(own.entries_mut(), x.entries(), map);
            }
        }
    }
}

/// Entry of a packed level, to be changed, and that of a level after it, to be accumulated into it.
#[inline(always)]
fn own_and_other<X>(all: &mut [X], own: usize, other: usize) -> (&mut X, &X) {
    let (before, after) = all.split_at_mut(other);
    (&mut before[own], &after[0])
}

/// Adds the values of the children in another level to the lanes of their parents; adding −0 changes no number. Whole vectors are
/// written, for the next to read them would wait for single lanes.
#[inline(always)]
fn add_gathered<const N: usize>(own: [&mut Lane; N], x: [&Lane; N], map: &Gather) {
    for k in 0..N {
        let mut sum = *own[k];
        for lane in 0..WIDTH {
            let child = x[k].0[map.lanes[lane] % WIDTH];
            sum.0[lane] += if map.present[lane] { child } else { -0.0 };
        }
        *own[k] = sum;
    }
}

/// Permutes lanes: that of index `lanes[k]` comes to lane `k`.
#[inline(always)]
fn permuted(x: &Lane, lanes: [usize; WIDTH]) -> Lane {
    let mut out = [0.0; WIDTH];
    for lane in 0..WIDTH {
        out[lane] = x.0[lanes[lane] % WIDTH];
    }
    Lanes(out)
}

/// Broadcasts a motion to all lanes.
#[inline(always)]
fn broadcast<T: Scalar>(V: &Motion<T>) -> Motion<Lane> {
    Motion::from_array(V.to_array().map_each(|x| Lanes([x.value(0); WIDTH])))
}

/// Extracts the numbers of one lane.
#[inline(always)]
fn in_lane<T: Scalar, const N: usize>(x: [&Lane; N], lane: usize) -> [T; N] {
    x.map_each(|x| T::from(x.0[lane % WIDTH]))
}

/// Gathers numbers into lanes, one by one: the instructions that gather several are slower.
#[inline(always)]
fn gather<T: Scalar>(map: &[usize], from: &[T], to: &mut [Lane]) {
    for (k, &index) in map.iter().enumerate() {
        to[k / WIDTH].0[k % WIDTH] = from[index].value(0);
    }
}

#[cfg(test)]
mod tests {
    use super::super::direct::DirectScratch;
    use super::*;
    use crate::dynamics::calls::Calls;
    use crate::model::samples;
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    // Also of levels that would not pay, with external forces and against resistance: the sum over the children of a body has the same order.
    #[test]
    fn packed_levels_give_the_bits_of_bodies_one_by_one() {
        for seed in 0..150 {
            let model = samples::random_tree(1 + seed as usize % 29, seed);
            let rng = &mut Xoshiro256PlusPlus::seed_from_u64(seed);
            let q = model.random_configuration(rng);
            let mut numbers =
                |n: usize| -> Vec<f64> { (0..n).map(|_| rng.random_range(-2.0..2.0)).collect() };
            let (v, tau) = (numbers(model.nv()), numbers(model.nv()));
            let forces = numbers(6 * model.n_bodies());
            let forces: Vec<_> = forces
                .chunks(6)
                .map(|F| Force::from_array(F.try_into().unwrap()))
                .collect();
            let external = if seed % 3 == 0 { &[][..] } else { &forces[..] };
            let given: Vec<f64> = numbers(model.nv()).iter().map(|x| x.abs()).collect();
            let resistance = if seed % 2 == 0 { &[][..] } else { &given[..] };
            let (mut expected, mut actual) = (v.clone(), v.clone());
            let mut scratch = DirectScratch::new(&model, Calls::One);
            let q = q.as_slice();
            let out = &mut expected[..];
            let driven = Driven {
                q,
                v: &v,
                tau: &tau,
                resistance,
                external,
            };
            scratch.accelerations(&model, &driven, out);
            let packed = PackedTree::of(model.bodies(), model.armature());
            PackedScratch::new(&packed).accelerations(
                &model,
                &packed,
                &mut Working::new(model.n_bodies(), model.nq(), model.nv()),
                &driven,
                &mut actual,
            );
            let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&actual), bits(&expected), "tree {seed}");
        }
    }
}
