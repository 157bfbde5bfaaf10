//! The articulated-body algorithm of a robot with dry friction: [which joints stick](super::joint_friction) is decided while they are eliminated.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::aba::Working;
use super::joint_friction::{Eliminated, Frictions};
use super::tree::Tree;
use crate::joint::{Axis, JointKind};
use crate::model::manifold::v_range;
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Motion};

impl<T: Scalar> Working<T> {
    /// Keeps what passes inward change, and finds accelerations of bodies whose joints do not accelerate: of robots with friction, after the pass outward.
    #[inline(always)]
    pub(super) fn start_friction<P: Scalar>(&mut self, tree: &impl Tree<P, T>, A_W: &Motion<T>)
    where
        T: Over<P>,
    {
        if !self.friction.act() {
            return;
        }
        let Self {
            friction,
            F,
            A,
            C,
            factor,
            ..
        } = self;
        friction.alone.clone_from(F);
        let still = Eliminated {
            U: Force::zero(),
            bias: T::zero(),
            inertia: T::zero(),
            resistance: T::zero(),
            a: T::zero(),
            next: T::zero(),
        };
        friction.eliminated.clear();
        friction.eliminated.resize(friction.all.len(), still);
        for i in tree.range() {
            let body = &tree.bodies()[i];
            A[i] = match (body.parent, body.joint) {
                (Some(p), _) => {
                    let A_P = tree.parent_motion(i, p, A);
                    factor.X_PB[i].motion_inverse_plus(&A_P, &C[i])
                }
                // Falls freely.
                (None, JointKind::Floating) => C[i],
                (None, _) => factor.X_PB[i].motion_inverse_plus(A_W, &C[i]),
            };
        }
    }

    /// Forgets the last pass inward, except for the pieces that it suggests.
    #[inline(always)]
    pub(super) fn restart<P: Scalar>(&mut self, tree: &impl Tree<P, T>)
    where
        T: Over<P>,
    {
        for i in tree.range() {
            self.F[i] = self.friction.alone[i];
            self.factor.I[i].set_rigid(&tree.bodies()[i].inertia);
        }
        let Frictions {
            all,
            eliminated,
            guess,
            ..
        } = &mut self.friction;
        *guess = false;
        for (friction, own) in all.iter_mut().zip(eliminated) {
            friction.piece = own.next;
        }
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
        let (F, A, I) = (&self.F[i], &self.A[i], &self.factor.I[i]);
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
            friction.piece = friction.next(own.needed(A, friction.stop));
        }
        let [force, resistance] = friction.parts();
        self.pushed[k] += force;
        self.resistance[k] += resistance;
    }

    /// Finds the pieces that the accelerations of the last pass outward suggest, and counts by how many they differ from those of this pass.
    #[inline(always)]
    pub(super) fn review<P: Scalar>(&mut self, tree: &impl Tree<P, T>, a: &[T])
    where
        T: Over<P>,
    {
        let (mut changes, guessed) = (T::zero(), self.friction.guess);
        for i in tree.range() {
            for k in v_range(&tree.bodies()[i]) {
                let (own, friction) = (&mut self.friction.eliminated[k], &self.friction.all[k]);
                own.a = a[k];
                let next = friction.next(own.needed(&self.A[i], friction.stop));
                own.next = if guessed {
                    next
                } else {
                    friction.neighbour(next)
                };
                changes += (own.next - friction.piece).abs();
            }
        }
        self.friction.changes = changes;
    }
}
