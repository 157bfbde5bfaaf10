//! The articulated-body algorithm of a robot with dry friction: [which joints stick](super::joint_friction) is decided while they are eliminated.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::aba::Working;
use super::joint_friction::{Eliminated, Frictions};
use super::tree::Tree;
use crate::joint::{Joint, JointKind};
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

    /// Guesses which coordinates of body i stick in the first pass, before its joint is eliminated, and adds the resistance of those that stick.
    #[inline(always)]
    pub(super) fn decide<J: Joint>(
        &mut self,
        i: usize,
        joint: J,
        v: usize,
        U: &J::PerDof<Force<T>>,
        tau: &[T],
    ) {
        let (F, A) = (&self.F[i], &self.A[i]);
        for k in 0..joint.nv() {
            let (own, axis) = (&mut self.friction.eliminated[v + k], joint.axis(k));
            own.U = U.as_ref()[k];
            own.bias = axis.project(F) - tau[v + k];
            own.inertia = axis.project(&own.U);
            own.resistance = self.resistance[v + k];
            let friction = &mut self.friction.all[v + k];
            if self.friction.guess {
                friction.piece = friction.next(own.needed(A, friction.stop));
            }
            self.resistance[v + k] += friction.parts()[1];
        }
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
