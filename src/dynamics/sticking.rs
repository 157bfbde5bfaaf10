//! The articulated-body algorithm of a robot with dry friction: [which joints stick](super::joint_friction) is decided while they are eliminated.
//!
//! A joint that changes leaves what its body feels of the bodies beyond it as it was, so that a further pass inward begins there.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::aba::{Working, alone};
use super::tree::Tree;
use crate::joint::{Axis, JointKind};
use crate::model::manifold::v_range;
use crate::scalar::{Over, Scalar};
use crate::spatial::Force;

impl<T: Scalar> Working<T> {
    /// Forgets what the last pass inward found of bodies before the `last` one whose joint changes, and takes over the pieces that the pass suggests.
    ///
    /// * `external` – force on each body, in the body; empty for none
    #[inline(always)]
    pub(super) fn restart<P: Scalar>(
        &mut self,
        tree: &impl Tree<P, T>,
        external: &[Force<T>],
        last: usize,
    ) where
        T: Over<P>,
    {
        for i in tree.range().take_while(|&i| tree.starts_anew(i, last)) {
            let inertia = &tree.bodies()[i].inertia;
            self.F[i] = alone(inertia, &self.V[i], external.get(i));
            self.factor.I[i].set_rigid(inertia);
        }
        self.friction.follow();
    }

    /// Guesses which coordinates of body i stick in the first pass, before its joint is eliminated, and adds their friction to joint forces and resistance.
    ///
    /// Once for all kinds of joints: compiled into each elimination it made those of robots without friction 3 % longer.
    #[inline(never)]
    pub(super) fn decide(&mut self, i: usize, joint: JointKind, v: usize) {
        T::vectorized(
            #[inline(always)]
            || {
                for k in 0..joint.nv() {
                    self.decide_one(i, joint.axis(k), v + k);
                }
            },
        );
    }

    /// The same of one coordinate.
    #[inline(always)]
    fn decide_one(&mut self, i: usize, axis: Axis, k: usize) {
        let (F, I) = (&self.F[i], &self.factor.I[i]);
        let own = &mut self.friction.eliminated[k];
        own.U = axis.column(
            #[inline(always)]
            |axis| I.column(axis),
        );
        own.bias = axis.project(F) - self.pushed[k];
        own.inertia = axis.project(&own.U);
        own.resistance = self.resistance[k];
        let friction = &mut self.friction.all[k];
        if self.friction.guess {
            friction.piece = friction.guess(own.inertia + own.resistance, own.bias);
        }
        let [force, resistance] = friction.parts();
        self.pushed[k] += force;
        self.resistance[k] += resistance;
    }

    /// Finds the pieces that the accelerations of the last pass outward suggest, and where they differ from those of this pass.
    #[inline(always)]
    pub(super) fn review<P: Scalar>(&mut self, tree: &impl Tree<P, T>, a: &[T])
    where
        T: Over<P>,
    {
        let (mut changes, guessed) = (T::zero(), self.friction.guess);
        self.friction.last = None;
        for i in tree.range() {
            let before = changes;
            for k in v_range(&tree.bodies()[i]) {
                let (own, friction) = (&mut self.friction.eliminated[k], &self.friction.all[k]);
                let next = friction.next(own.needed(&self.A[i], a[k], friction.stop));
                own.next = if guessed {
                    next
                } else {
                    friction.neighbour(next)
                };
                changes += (own.next - friction.piece).abs();
            }
            if (0..T::LANES).any(|lane| changes.value(lane) > before.value(lane)) {
                self.friction.last = Some(i);
            }
        }
        self.friction.changes = changes;
    }
}
