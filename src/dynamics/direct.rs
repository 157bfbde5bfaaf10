//! Forward dynamics on a scalar without splitting it into values and derivatives: body by body, level by level of a packed tree, or by the mass matrix.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::aba::{ALL, Driven, Working, accelerations, inward, outward};
use super::calls::Calls;
use super::coupled::CoupledScratch;
use super::joint_friction::{Decision, JointFriction};
use super::packed::PackedScratch;
use super::packed_tree::PackedTree;
use super::rnea::{Motions, RneaScratch, world_acceleration};
use super::tree::Bodies;
use super::weightless::add_spared;
use crate::model::{Generation, Model};
use crate::scalar::{Over, Scalar, has_lanes, is_f64, may_be_f64};

/// Working memory of [`accelerations`](Self::accelerations).
#[derive(Clone, Debug)]
pub(super) struct DirectScratch<T> {
    working: Working<T>,
    /// Where the motions of all bodies at the last accelerations are.
    motions: Left,
    /// Memory for robots whose joints follow one another.
    coupled: Option<Box<CoupledScratch<T>>>,
    /// Memory for robots whose branches are packed.
    packed: Option<Box<Packed>>,
}

/// Where motions of bodies have been left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Left {
    Nowhere,
    /// In the working memory.
    OneByOne,
    /// In that of the packed tree.
    Packed,
}

/// Packed tree of a robot in plain numbers, with its working memory and the model that it was made from.
#[derive(Clone, Debug)]
struct Packed {
    generation: Generation,
    tree: PackedTree,
    scratch: PackedScratch,
}

impl Packed {
    /// Packs a robot with model data and states in plain numbers, where that pays; `None` otherwise.
    fn new<P: Scalar, T: Scalar>(model: &Model<P>) -> Option<Box<Self>> {
        let is_plain = is_f64::<P>() && is_f64::<T>() && model.weightless().is_empty();
        if !(is_plain && has_lanes()) {
            return None;
        }
        let tree = PackedTree::worthwhile(model.bodies(), model.armature())?;
        Some(Box::new(Self {
            generation: model.generation(),
            scratch: PackedScratch::new(&tree),
            tree,
        }))
    }
}

impl<T: Scalar> DirectScratch<T> {
    /// Makes memory for a model. Packing its tree takes as long as some calls.
    pub(super) fn new<P: Scalar>(model: &Model<P>, calls: Calls) -> Self {
        Self {
            working: Working::new(model.n_bodies(), model.nq(), model.nv()),
            motions: Left::Nowhere,
            coupled: CoupledScratch::new(model),
            packed: match calls {
                Calls::One => None,
                Calls::Many => Packed::new::<P, T>(model),
            },
        }
    }

    /// The motions of all bodies at the last accelerations, where they have been found one by one since [`forget`](Self::forget).
    pub(super) fn motions(&self) -> Option<Motions<'_, T>> {
        (self.motions == Left::OneByOne).then(|| self.working.motions())
    }

    /// Whether the motions of all bodies at the last accelerations are in the lanes of a packed tree.
    pub(super) fn has_packed_motions(&self) -> bool {
        self.motions == Left::Packed
    }

    /// Hands the motions of some bodies of a packed robot to the working memory of inverse dynamics.
    pub(super) fn copy_packed_motions(&self, bodies: &[usize], out: &mut RneaScratch<T>) {
        if let Some(packed) = &self.packed {
            let Packed { tree, scratch, .. } = &**packed;
            scratch.copy_motions(tree, &self.working, bodies, out);
        }
    }

    /// Drops the motions of the bodies.
    pub(super) fn forget(&mut self) {
        self.motions = Left::Nowhere;
    }

    /// Computes v̇ = (M + R)⁻¹ (τ − h + Σᵢ Jᵢᵀ Fᵢ).
    pub(super) fn accelerations<P: Scalar>(
        &mut self,
        model: &Model<P>,
        driven: &Driven<'_, T>,
        a: &mut [T],
    ) where
        T: Over<P>,
    {
        if let Some(coupled) = &mut self.coupled {
            return coupled.accelerations(model, driven, a);
        }
        self.working.friction.all.clear();
        self.solve(model, driven, a);
    }

    /// [`accelerations`](Self::accelerations) with dry friction, of which the pieces that hold are found too. Returns by how many these differ from those that
    /// the solution suggests, or nothing where joints follow others.
    pub(super) fn frictional_accelerations<P: Scalar>(
        &mut self,
        model: &Model<P>,
        driven: &Driven<'_, T>,
        friction: &mut Vec<JointFriction<T>>,
        decision: Decision,
        a: &mut [T],
    ) -> Option<T>
    where
        T: Over<P>,
    {
        if self.coupled.is_some() {
            return None;
        }
        self.working.friction.take(friction, decision);
        self.solve(model, driven, a);
        std::mem::swap(&mut self.working.friction.all, friction);
        Some(self.working.friction.changes)
    }

    /// Along the tree, body by body or packed.
    fn solve<P: Scalar>(&mut self, model: &Model<P>, driven: &Driven<'_, T>, a: &mut [T])
    where
        T: Over<P>,
    {
        let working = &mut self.working;
        if const { may_be_f64::<T>() }
            && let Some(packed) = &mut self.packed
        {
            model.assert_generation(packed.generation);
            self.motions = Left::Packed;
            let Packed { tree, scratch, .. } = &mut **packed;
            return scratch.accelerations(model, tree, working, driven, a);
        }
        self.motions = Left::OneByOne;
        T::vectorized(
            #[inline(always)]
            || {
                let tree = Bodies::all(model);
                outward(&tree, driven.q, driven.v, driven.external, working);
                let spares = !model.weightless().is_empty();
                if spares {
                    add_spared(model, &working.factor.X_PB, &mut working.F);
                }
                let (A_W, mut last) = (world_acceleration(model), ALL);
                for passes in 1.. {
                    working.resist(model.armature(), driven.resistance);
                    inward(&tree, driven.tau, &A_W, last, working);
                    accelerations(&tree, &A_W, working, a);
                    if !working.friction.act() {
                        break;
                    }
                    working.review(&tree, a);
                    let changed = working.friction.last;
                    let Some(changed) = changed.filter(|_| working.friction.may_go_on(passes))
                    else {
                        break;
                    };
                    last = if spares { ALL } else { changed };
                    working.restart(&tree, driven.external, last);
                    if spares {
                        add_spared(model, &working.factor.X_PB, &mut working.F);
                    }
                }
            },
        );
    }
}
