//! Forward dynamics with bodies of different branches side by side: the same algorithm over a tree of rows, in the lanes of the
//! vector units. Every lane goes through the operations that its body goes through alone, in their order, so the bits are the same.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::{Add, Range};

use super::aba::{Driven, Working, accelerations, inward, outward};
use super::packed_tree::{Gather, PackedTree, WIDTH, lanes};
use super::rnea::world_acceleration;
use super::tree::{Bodies, Tree};
use crate::model::{Body, BodyId, Model};
use crate::scalar::{Lanes, Over, Scalar};
use crate::spatial::{ArticulatedInertia, Force, Motion, SPATIAL};

type Lane = Lanes<WIDTH>;

/// Working memory for the rows of a model.
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
    pub(super) fn new(rows: &PackedTree) -> Self {
        let (n, nq, nv) = (rows.rows.len(), rows.q.len() / WIDTH, rows.v.len() / WIDTH);
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

    /// Accelerations of a model in whose rows this memory fits; the bodies of the trunk are worked on one by one.
    pub(super) fn accelerations<P: Scalar, T: Over<P>>(
        &mut self,
        (model, rows): (&Model<P>, &PackedTree),
        trunk: &mut Working<T>,
        driven: &Driven<'_, T>,
        a: &mut [T],
    ) {
        let Driven {
            q,
            v,
            tau,
            resistance,
            external,
        } = *driven;
        assert_eq!(
            self.working.V.len(),
            rows.rows.len(),
            "the scratch belongs to another model than \"{}\"",
            model.name()
        );
        let tree = Bodies::first(model, rows.trunk);
        let own = model.bodies()[..rows.trunk]
            .last()
            .map_or(0, |tip| tip.q + tip.joint.nq());
        outward(&tree, &q[..own], v, external, trunk);
        let A_W = world_acceleration(model);
        Lane::vectorized(
            #[inline(always)]
            || {
                self.spread(rows, (q, v, tau), (resistance, external));
                self.eliminate(rows, trunk, &A_W);
            },
        );
        self.load_trunk(rows, trunk);
        trunk.resist(model.armature(), resistance);
        inward(&tree, tau, &A_W, trunk);
        accelerations(&tree, &A_W, trunk, a);
        Lane::vectorized(
            #[inline(always)]
            || self.accelerate(rows, trunk, &A_W, a),
        );
    }

    /// Outward and inward along the rows.
    #[inline(always)]
    fn eliminate<T: Scalar>(&mut self, rows: &PackedTree, trunk: &Working<T>, A_W: &Motion<T>) {
        let working = &mut self.working;
        if let Some(tip) = rows.trunk.checked_sub(1) {
            working.V[0] = in_all_lanes(&trunk.V[tip]);
        }
        outward(rows, &self.q, &self.v, &self.external, working);
        working.resist(&rows.armature, &self.resistance);
        inward(rows, &self.tau, &in_all_lanes(A_W), working);
    }

    /// Accumulates the articulated forces and inertias of the packed levels into the tip of the unbranched prefix.
    fn load_trunk<T: Scalar>(&self, rows: &PackedTree, trunk: &mut Working<T>) {
        let Some(tip) = rows.trunk.checked_sub(1) else {
            return;
        };
        for load in &rows.rows[0].loads {
            if !load.carries[0] {
                continue;
            }
            let lane = load.lanes[0];
            let (F, I) = (&self.working.F[load.row], &self.working.factor.I[load.row]);
            trunk.F[tip] += Force::from_array(in_lane(F.entries(), lane));
            let I = ArticulatedInertia::from_entries(in_lane(I.entries(), lane));
            trunk.factor.I[tip] = trunk.factor.I[tip] + I;
        }
    }

    /// Outward, with the accelerations of the trunk or of the world.
    #[inline(always)]
    fn accelerate<T: Scalar>(
        &mut self,
        rows: &PackedTree,
        trunk: &Working<T>,
        A_W: &Motion<T>,
        a: &mut [T],
    ) {
        let working = &mut self.working;
        if let Some(tip) = rows.trunk.checked_sub(1) {
            working.A[0] = in_all_lanes(&trunk.A[tip]);
        }
        accelerations(rows, &in_all_lanes(A_W), working, &mut self.a);
        for (&place, x) in rows.v.iter().zip(self.a.iter().flat_map(|x| x.0)) {
            a[place] = T::from(x);
        }
    }

    /// Puts side by side what the rows need.
    #[inline(always)]
    fn spread<T: Scalar>(
        &mut self,
        rows: &PackedTree,
        (q, v, tau): (&[T], &[T], &[T]),
        (resistance, external): (&[T], &[Force<T>]),
    ) {
        spread(&rows.q, q, &mut self.q);
        spread(&rows.v, v, &mut self.v);
        spread(&rows.v, tau, &mut self.tau);
        self.resistance.clear();
        if !resistance.is_empty() {
            self.resistance.resize(self.tau.len(), Lane::constant(0.0));
            spread(&rows.v, resistance, &mut self.resistance);
        }
        self.spread_forces(rows, external);
    }

    #[inline(always)]
    fn spread_forces<T: Scalar>(&mut self, rows: &PackedTree, external: &[Force<T>]) {
        self.external.clear();
        if external.is_empty() {
            return;
        }
        for row in &rows.rows {
            let own = row.bodies.map(|i| external[i].to_array());
            self.external.push(Force::from_array(lanes(own)));
        }
    }
}

impl Tree<Lane, Lane> for PackedTree {
    #[inline(always)]
    fn range(&self) -> Range<usize> {
        1..self.rows.len()
    }

    #[inline(always)]
    fn bodies(&self) -> &[Body<Lane>] {
        &self.bodies
    }

    #[inline(always)]
    fn carrier(&self, i: usize, p: BodyId, motions: &[Motion<Lane>]) -> Motion<Lane> {
        let V = &motions[p.0];
        let Some(carriers) = self.rows[i].carriers else {
            return *V;
        };
        let mut V = V.to_array();
        for x in &mut V {
            *x = picked(x, carriers);
        }
        Motion::from_array(V)
    }

    #[inline(always)]
    fn hand_down<X: Copy + Add<Output = X>>(&self, i: usize, _: BodyId, x: X, all: &mut [X]) {
        // Kept, until the row that carries this one takes it up.
        all[i] = x;
    }

    #[inline(always)]
    fn take_up(
        &self,
        i: usize,
        forces: &mut [Force<Lane>],
        inertias: &mut [ArticulatedInertia<Lane>],
    ) {
        for load in &self.rows[i].loads {
            if load.straight {
                forces[i] += forces[load.row];
                inertias[i] = inertias[i] + inertias[load.row];
            } else {
                let (own, x) = own_and_other(forces, i, load.row);
                add_load(own.entries_mut(), x.entries(), load);
                let (own, x) = own_and_other(inertias, i, load.row);
                add_load(own.entries_mut(), x.entries(), load);
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

/// Adds what another row hands down, in the lanes that carry something of it; −0 leaves every number as it is. Whole vectors are written,
/// for the next to read them would wait for single lanes.
#[inline(always)]
fn add_load<const N: usize>(own: [&mut Lane; N], x: [&Lane; N], load: &Gather) {
    for (own, x) in own.into_iter().zip(x) {
        let mut sum = *own;
        for lane in 0..WIDTH {
            let carried = x.0[load.lanes[lane] % WIDTH];
            sum.0[lane] += if load.carries[lane] { carried } else { -0.0 };
        }
        *own = sum;
    }
}

/// The number of another lane in each lane.
#[inline(always)]
fn picked(x: &Lane, lanes: [usize; WIDTH]) -> Lane {
    let mut out = [0.0; WIDTH];
    for lane in 0..WIDTH {
        out[lane] = x.0[lanes[lane] % WIDTH];
    }
    Lanes(out)
}

/// Broadcasts a motion to all lanes.
#[inline(always)]
fn in_all_lanes<T: Scalar>(V: &Motion<T>) -> Motion<Lane> {
    let mut out = [Lanes([0.0; WIDTH]); SPATIAL];
    for (out, x) in out.iter_mut().zip(V.to_array()) {
        *out = Lanes([x.value(0); WIDTH]);
    }
    Motion::from_array(out)
}

/// The numbers in a lane.
#[inline(always)]
fn in_lane<T: Scalar, const N: usize>(x: [&Lane; N], lane: usize) -> [T; N] {
    let mut out = [T::zero(); N];
    for (out, x) in out.iter_mut().zip(x) {
        *out = T::from(x.0[lane % WIDTH]);
    }
    out
}

/// Puts numbers side by side, one by one: the instructions that gather several are slower.
#[inline(always)]
fn spread<T: Scalar>(places: &[usize], from: &[T], to: &mut [Lane]) {
    for (k, &place) in places.iter().enumerate() {
        to[k / WIDTH].0[k % WIDTH] = from[place].value(0);
    }
}

#[cfg(test)]
mod tests {
    use super::super::direct::DirectScratch;
    use super::*;
    use crate::model::samples;
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    // Also of rows that would not pay, with external forces and against resistance: the sum over what a body carries has the same order.
    #[test]
    fn rows_give_the_bits_of_bodies_one_by_one() {
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
            let mut scratch = DirectScratch::one_by_one(&model);
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
            let rows = PackedTree::of(model.bodies(), model.armature());
            PackedScratch::new(&rows).accelerations(
                (&model, &rows),
                &mut Working::new(model.n_bodies(), model.nq(), model.nv()),
                &driven,
                &mut actual,
            );
            let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&actual), bits(&expected), "tree {seed}");
        }
    }
}
