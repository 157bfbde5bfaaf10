//! Articulated-body algorithm: accelerations from forces, in three passes along the tree.
//!
//! # References
//! [Featherstone 2008, table 7.1].

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::articulated_factor::{ArticulatedFactor, Felt};
use super::joint_friction::Frictions;
use super::rnea::Motions;
use super::tree::Tree;
use crate::joint::{Floating, Joint, JointKind, with_joint};
use crate::linalg::small_matrix::solve;
use crate::model::BodyId;
use crate::model::manifold::v_range;
use crate::scalar::{Over, Scalar, pairs};
use crate::spatial::{Force, Inertia, Motion};

/// In place of the last body that is eliminated otherwise than before, where all are.
pub(super) const ALL: usize = usize::MAX;

/// A state and the forces under which it accelerates, (M + R) v̇ = τ − h + Σᵢ Jᵢᵀ Fᵢ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Driven<'a, T: Scalar> {
    pub(crate) q: &'a [T],
    pub(crate) v: &'a [T],
    pub(crate) tau: &'a [T],
    /// R; empty for none.
    pub(crate) resistance: &'a [T],
    /// On each body, in the body; empty for none.
    pub(crate) external: &'a [Force<T>],
}

/// Working memory of the algorithm, body by body.
#[derive(Clone, Debug)]
pub(super) struct Working<T> {
    pub(super) V: Vec<Motion<T>>,
    /// Velocity-product accelerations.
    pub(super) C: Vec<Motion<T>>,
    /// Articulated bias forces.
    pub(super) F: Vec<Force<T>>,
    pub(super) A: Vec<Motion<T>>,
    /// Per degree of freedom: τ until its joint is eliminated, then D⁻¹ u, the acceleration of the joint for a parent without acceleration; for a body on
    /// the world the actual one.
    pub(super) pushed: Vec<T>,
    /// Inertia of each coordinate, added to D: armature and implicit damping diagonal, kg·m² or kg.
    pub(super) resistance: Vec<T>,
    pub(super) friction: Frictions<T>,
    pub(super) factor: ArticulatedFactor<T>,
}

impl<T: Scalar> Working<T> {
    /// Memory for `n` bodies.
    pub(super) fn new(n: usize, nq: usize, nv: usize) -> Self {
        Self {
            V: vec![Motion::zero(); n],
            C: vec![Motion::zero(); n],
            F: vec![Force::zero(); n],
            A: vec![Motion::zero(); n],
            pushed: vec![T::zero(); nv],
            resistance: vec![T::zero(); nv],
            friction: Frictions::none(),
            factor: ArticulatedFactor::new(n, nq, nv),
        }
    }

    /// The motions of all bodies that the three passes have left.
    pub(super) fn motions(&self) -> Motions<'_, T> {
        Motions {
            X_PB: &self.factor.X_PB,
            V: &self.V,
            A: &self.A,
        }
    }

    /// Sets what coordinates resist with: their armature, and `beside` it a number each, or none.
    #[inline(always)]
    pub(super) fn resist<P: Scalar>(&mut self, armature: &[P], beside: &[T])
    where
        T: Over<P>,
    {
        for (resistance, &armature) in pairs(&mut self.resistance, armature) {
            *resistance = T::from(armature);
        }
        for (resistance, &beside) in pairs(&mut self.resistance, beside) {
            *resistance += beside;
        }
    }
}

/// Outward: joint transforms, velocities, and the inertia and the force of each body alone.
#[inline(always)]
pub(super) fn outward<P: Scalar, T: Over<P>>(
    tree: &impl Tree<P, T>,
    q: &[T],
    v: &[T],
    external: &[Force<T>],
    s: &mut Working<T>,
) {
    s.factor.turn(q);
    for i in tree.range() {
        let joint = tree.bodies()[i].joint;
        with_joint!(joint, joint => move_body(tree, i, joint, q, v, external, s),
            else move_rare(tree, i, joint, q, v, external, s));
    }
}

#[inline(never)]
fn move_rare<P: Scalar, T: Over<P>>(
    tree: &impl Tree<P, T>,
    i: usize,
    joint: JointKind,
    q: &[T],
    v: &[T],
    external: &[Force<T>],
    s: &mut Working<T>,
) {
    T::vectorized(
        #[inline(always)]
        || with_joint!(rare joint, joint => move_body(tree, i, joint, q, v, external, s)),
    );
}

/// V = X⁻¹ `V_P` + S v,  C = V × S v,  F = V ×* I V − `F_ext`.
#[inline(always)]
fn move_body<P: Scalar, T: Over<P>, J: Joint>(
    tree: &impl Tree<P, T>,
    i: usize,
    joint: J,
    q: &[T],
    v: &[T],
    external: &[Force<T>],
    s: &mut Working<T>,
) {
    let body = &tree.bodies()[i];
    let (q, v) = (
        &q[body.q..body.q + joint.nq()],
        &v[body.v..body.v + joint.nv()],
    );
    let X = s.factor.place(i, body, joint, q);
    let mut V = match body.parent {
        Some(p) => X.motion_inverse(&tree.parent_motion(i, p, &s.V)),
        None => Motion::zero(),
    };
    joint.add_motion(v, &mut V);
    s.C[i] = joint.velocity_product(&V, v);
    s.F[i] = alone(&body.inertia, &V, external.get(i));
    s.V[i] = V;
}

/// The bias force of a body alone, V ×* I V − `F_ext`.
#[inline(always)]
pub(super) fn alone<P: Scalar, T: Over<P>>(
    inertia: &Inertia<P>,
    V: &Motion<T>,
    external: Option<&Force<T>>,
) -> Force<T> {
    let F = V.cross_force(&inertia.times(V));
    match external {
        Some(&F_ext) => F - F_ext,
        None => F,
    }
}

/// Inward, with the acceleration of the world: eliminates one joint after the other, against the resistance that has been
/// [set](Working::resist).
///
/// * `last` – the last body that is eliminated otherwise than before, after a [restart](Working::restart); [`ALL`] for all
#[inline(always)]
pub(super) fn inward<P: Scalar, T: Over<P>>(
    tree: &impl Tree<P, T>,
    tau: &[T],
    A_W: &Motion<T>,
    last: usize,
    s: &mut Working<T>,
) {
    let (rubs, again) = (s.friction.act(), last != ALL);
    if !again {
        s.pushed.copy_from_slice(tau);
    }
    for i in tree.range().rev() {
        if i > last && !tree.repeats(i, last) {
            continue;
        }
        tree.add_children(i, &mut s.F, &mut s.factor.I);
        let body = &tree.bodies()[i];
        let (joint, parent) = (body.joint, body.parent);
        if again {
            v_range(body).for_each(|k| s.pushed[k] = tau[k]);
        }
        // A constant first: for other numbers this is not compiled.
        if Frictions::<T>::MAY_ACT && rubs {
            s.decide(i, joint, body.v);
        }
        with_joint!(joint, joint => eliminate(tree, i, joint, parent, A_W, s),
            else eliminate_rare(tree, i, joint, parent, A_W, s));
    }
}

/// Two functions, as without optimisation each needs much of the stack.
fn eliminate_rare<P: Scalar, T: Over<P>>(
    tree: &impl Tree<P, T>,
    i: usize,
    joint: JointKind,
    parent: Option<BodyId>,
    A_W: &Motion<T>,
    s: &mut Working<T>,
) {
    match (joint, parent) {
        // The base of most robots that have none on the world. Below another body, free motion is as rare as the other kinds.
        (JointKind::Floating, None) => eliminate_base(tree, i, A_W, s),
        _ => eliminate_any(tree, i, joint, parent, A_W, s),
    }
}

#[inline(never)]
fn eliminate_base<P: Scalar, T: Over<P>>(
    tree: &impl Tree<P, T>,
    i: usize,
    A_W: &Motion<T>,
    s: &mut Working<T>,
) {
    T::vectorized(
        #[inline(always)]
        || eliminate(tree, i, Floating, None, A_W, s),
    );
}

#[inline(never)]
fn eliminate_any<P: Scalar, T: Over<P>>(
    tree: &impl Tree<P, T>,
    i: usize,
    joint: JointKind,
    parent: Option<BodyId>,
    A_W: &Motion<T>,
    s: &mut Working<T>,
) {
    T::vectorized(
        #[inline(always)]
        || eliminate(tree, i, joint, parent, A_W, s),
    );
}

/// U = I S,  D = Sᵀ U + R,  u = τ − Sᵀ F − Uᵀ C,  W = X* U D⁻¹; the parent feels  X* (F + I C) + W u  and  X* I X⁻¹ − X* U Wᵀ.
///
/// The inertia is moved before the joint is taken out of it, so that nothing waits for the division. A body on the world accelerates at
/// once:  v̇ = D⁻¹ (u − Uᵀ X⁻¹ `A_W`).
#[inline(always)]
fn eliminate<P: Scalar, T: Over<P>, J: Joint>(
    tree: &impl Tree<P, T>,
    i: usize,
    joint: J,
    parent: Option<BodyId>,
    A_W: &Motion<T>,
    s: &mut Working<T>,
) {
    let v = tree.bodies()[i].v;
    let U = s.factor.columns(i, joint);
    let (F, C) = (s.F[i], &s.C[i]);
    let D = s.factor.factorize(joint, &U, v, &s.resistance);
    let mut u = joint.per_dof(
        #[inline(always)]
        |k| s.pushed[v + k] - joint.axis(k).project(&F) - C.power(&U.as_ref()[k]),
    );
    match parent {
        Some(p) => {
            let felt: Felt<J, T> = s.factor.felt(i, joint, v, &U, &D);
            let (X, I) = (&s.factor.X_PB[i], &s.factor.I[i]);
            let mut F_P = X.force(&(F + joint.times_velocity_product(I, C)));
            let mut I_P = I.moved(X);
            for k in 0..joint.nv() {
                let (U_P, W) = (&felt.U_P.as_ref()[k], &felt.W.as_ref()[k]);
                F_P += W.scaled(u.as_ref()[k]);
                I_P = I_P.minus_outer(U_P, W);
            }
            tree.add_to_parent(i, p, F_P, &mut s.F);
            tree.add_to_parent(i, p, I_P, &mut s.factor.I);
        }
        None => {
            let A = s.factor.X_PB[i].motion_inverse(A_W);
            for k in 0..joint.nv() {
                u.as_mut()[k] -= A.power(&U.as_ref()[k]);
            }
        }
    }
    solve(D.as_ref(), u.as_mut());
    for k in 0..joint.nv() {
        s.pushed[v + k] = u.as_ref()[k];
    }
}

/// Outward, with the acceleration of the world:  v̇ = D⁻¹ u − Wᵀ `A_P`,  A = X⁻¹ `A_P` + C + S v̇.
#[inline(always)]
pub(super) fn accelerations<P: Scalar, T: Over<P>>(
    tree: &impl Tree<P, T>,
    A_W: &Motion<T>,
    s: &mut Working<T>,
    a: &mut [T],
) {
    // Slices, whose places the loop need not look up again after each write.
    let (X_PB, C, A) = (&s.factor.X_PB[..], &s.C[..], &mut s.A[..]);
    let (W, pushed) = (s.factor.W(), &s.pushed[..]);
    for i in tree.range() {
        let body = &tree.bodies()[i];
        let A_P = match body.parent {
            Some(p) => tree.parent_motion(i, p, A),
            None => *A_W,
        };
        let W = body.parent.map(|_| W);
        let still = X_PB[i].motion_inverse_plus(&A_P, &C[i]);
        let at = Joining {
            v: body.v,
            pushed,
            W,
            A_P: &A_P,
        };
        // Each arm writes its own result, so that those of frequent joints stay in registers.
        with_joint!(body.joint, joint => A[i] = accelerate(joint, at, still, a),
            else A[i] = accelerate_rare(body.joint, at, still, a));
    }
}

/// The coordinates of a joint with their accelerations.
#[derive(Clone, Copy)]
struct Joining<'a, T> {
    /// Index of the first.
    v: usize,
    pushed: &'a [T],
    /// `None` for a body on the world.
    W: Option<&'a [Force<T>]>,
    A_P: &'a Motion<T>,
}

#[inline(never)]
fn accelerate_rare<T: Scalar>(
    joint: JointKind,
    at: Joining<'_, T>,
    still: Motion<T>,
    a: &mut [T],
) -> Motion<T> {
    let mut out = still;
    T::vectorized(
        #[inline(always)]
        || out = with_joint!(rare joint, joint => accelerate(joint, at, still, a)),
    );
    out
}

/// Writes the acceleration of a joint; returns that of its body, which would be `A` if the joint stood still.
#[inline(always)]
fn accelerate<T: Scalar, J: Joint>(
    joint: J,
    Joining { v, pushed, W, A_P }: Joining<'_, T>,
    mut A: Motion<T>,
    a: &mut [T],
) -> Motion<T> {
    let own = joint.per_dof(
        #[inline(always)]
        |k| match W {
            Some(W) => pushed[v + k] - A_P.power(&W[v + k]),
            None => pushed[v + k],
        },
    );
    joint.add_motion(own.as_ref(), &mut A);
    for k in 0..joint.nv() {
        a[v + k] = own.as_ref()[k];
    }
    A
}
