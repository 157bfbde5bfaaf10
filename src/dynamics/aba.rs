//! Articulated-body algorithm: which accelerations follow from given forces; three passes along the tree.
//!
//! # References
//! [Featherstone 2008, table 7.1].

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::articulated_factor::{ArticulatedFactor, SLIDE, TURN};
use super::tree::Tree;
use crate::joint::JointKind;
use crate::model::Body;
use crate::model::manifold::v_range;
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Motion};

/// A state and the forces under which it accelerates, (M + R) v̇ = τ − h + Σᵢ Jᵢᵀ Fᵢ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Driven<'a, T: Scalar> {
    pub(super) q: &'a [T],
    pub(super) v: &'a [T],
    pub(super) tau: &'a [T],
    /// R; empty for none.
    pub(super) resistance: &'a [T],
    /// On each body, in the body; empty for none.
    pub(super) external: &'a [Force<T>],
}

/// Working memory of the algorithm, body by body.
#[derive(Clone, Debug)]
pub(super) struct Working<T> {
    pub(super) V: Vec<Motion<T>>,
    /// Velocity-product accelerations.
    C: Vec<Motion<T>>,
    /// Articulated bias forces.
    pub(super) F: Vec<Force<T>>,
    pub(super) A: Vec<Motion<T>>,
    /// Per degree of freedom: the joint force u that is left to accelerate it; for a single axis D⁻¹ u.
    pub(super) u: Vec<T>,
    /// Inertia of each coordinate by itself, added to D: armature and what stands beside it, kg·m² or kg.
    resistance: Vec<T>,
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
            u: vec![T::zero(); nv],
            resistance: vec![T::zero(); nv],
            factor: ArticulatedFactor::new(n, nq, nv),
        }
    }

    /// Sets what coordinates resist with: their armature, and `beside` it a number each, or none.
    #[inline(always)]
    pub(super) fn resist<P: Scalar>(&mut self, armature: &[P], beside: &[T])
    where
        T: Over<P>,
    {
        for (resistance, &armature) in self.resistance.iter_mut().zip(armature) {
            *resistance = T::from(armature);
        }
        for (resistance, &beside) in self.resistance.iter_mut().zip(beside) {
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
        match tree.bodies()[i].joint {
            JointKind::Revolute | JointKind::Continuous => {
                move_one(tree, (i, JointKind::Revolute), (q, v), external, s);
            }
            JointKind::Prismatic => move_one(tree, (i, JointKind::Prismatic), (q, v), external, s),
            several => move_several(tree, (i, several), (q, v), external, s),
        }
    }
}

/// A body and its joint, whose kind is known where this is compiled for the frequent ones; none follows another.
#[inline(always)]
fn move_one<P: Scalar, T: Over<P>>(
    tree: &impl Tree<P, T>,
    (i, joint): (usize, JointKind),
    (q, v): (&[T], &[T]),
    external: &[Force<T>],
    s: &mut Working<T>,
) {
    let body = &tree.bodies()[i];
    let (q, v) = (
        &q[body.q..body.q + joint.nq()],
        &v[body.v..body.v + joint.nv()],
    );
    let X = s.factor.place(i, body, joint, q);
    // V = X⁻¹ V_P + S v,  C = V × S v
    let mut V = match body.parent {
        Some(p) => X.motion_inverse(&tree.carrier(i, p, &s.V)),
        None => Motion::zero(),
    };
    joint.add_motion(v, &mut V);
    s.C[i] = joint.velocity_product(&V, v);
    // F = V ×* I V − F_ext
    let F = V.cross_force(&body.inertia.times(&V));
    s.F[i] = match external.get(i) {
        Some(&F_ext) => F - F_ext,
        None => F,
    };
    s.V[i] = V;
}

#[inline(never)]
fn move_several<P: Scalar, T: Over<P>>(
    tree: &impl Tree<P, T>,
    at: (usize, JointKind),
    state: (&[T], &[T]),
    external: &[Force<T>],
    s: &mut Working<T>,
) {
    T::vectorized(
        #[inline(always)]
        || move_one(tree, at, state, external, s),
    );
}

/// Inward: eliminates one joint after the other, against the resistance that has been [set](Working::resist).
#[inline(always)]
pub(super) fn inward<P: Scalar, T: Over<P>>(tree: &impl Tree<P, T>, tau: &[T], s: &mut Working<T>) {
    for i in tree.range().rev() {
        let body = &tree.bodies()[i];
        tree.take_up(i, &mut s.F, &mut s.factor.I);
        match body.joint {
            JointKind::Revolute | JointKind::Continuous => {
                one::<P, T, TURN>(tree, (i, body), tau, s);
            }
            JointKind::Prismatic => {
                one::<P, T, SLIDE>(tree, (i, body), tau, s);
            }
            _ => several(tree, (i, body), tau, s),
        }
    }
}

/// A joint with one axis:  u = τ − Sᵀ F − Uᵀ C, and the parent feels  `F_P += X* (F + I C) + W u`  with W = X* U D⁻¹.
#[inline(always)]
fn one<P: Scalar, T: Over<P>, const AXIS: usize>(
    tree: &impl Tree<P, T>,
    (i, body): (usize, &Body<P>),
    tau: &[T],
    s: &mut Working<T>,
) {
    let resistance = s.resistance[body.v];
    let ([U, U_P, W], reciprocal) = s.factor.eliminate_one::<AXIS>(i, body.v, resistance);
    let (F, C, I) = (s.F[i], &s.C[i], &s.factor.I[i]);
    let u = tau[body.v] - F.coordinate(AXIS) - C.power(&U);
    s.u[body.v] = u * reciprocal;
    if let Some(p) = body.parent {
        // C has no components along and about z, the axis of the joint.
        let F_P = s.factor.X_PB[i].force(&(F + I.times_in_plane(C))) + W.scaled(u);
        tree.hand_down(i, p, F_P, &mut s.F);
        tree.hand_down(
            i,
            p,
            s.factor.felt_through_one(i, &U_P, &W),
            &mut s.factor.I,
        );
    }
}

/// Eliminates a joint with none or several axes, and accumulates its articulated force and inertia into the parent.
#[inline(never)]
fn several<P: Scalar, T: Over<P>>(
    tree: &impl Tree<P, T>,
    (i, body): (usize, &Body<P>),
    tau: &[T],
    s: &mut Working<T>,
) {
    T::vectorized(
        #[inline(always)]
        || eliminate_several(tree, (i, body), tau, s),
    );
}

#[inline(always)]
fn eliminate_several<P: Scalar, T: Over<P>>(
    tree: &impl Tree<P, T>,
    (i, body): (usize, &Body<P>),
    tau: &[T],
    s: &mut Working<T>,
) {
    let F = s.F[i];
    body.project(&F, |k, x| s.u[k] = tau[k] - x);
    s.factor.eliminate_several(i, body, &s.resistance);
    if let Some(p) = body.parent {
        let I_a = s.factor.felt_through_several(i, body);
        let (u, F_a) = (&s.u[v_range(body)], F + I_a.times(&s.C[i]));
        let F_P = s.factor.handed_on_by_several(i, body, u, F_a);
        tree.hand_down(i, p, F_P, &mut s.F);
        tree.hand_down(i, p, I_a.moved(&s.factor.X_PB[i]), &mut s.factor.I);
    }
}

/// Outward, with the acceleration of the world: `A' = X⁻¹ A_P + C`,  v̇ = D⁻¹ (u − Uᵀ A'),  A = A' + S v̇;
/// a joint with one axis need not wait for A':  v̇ = D⁻¹ u − Wᵀ `A_P`.
#[inline(always)]
pub(super) fn accelerations<P: Scalar, T: Over<P>>(
    tree: &impl Tree<P, T>,
    A_W: &Motion<T>,
    s: &mut Working<T>,
    a: &mut [T],
) {
    // Slices, whose places the loop need not look up again after each write.
    let (X_PB, C, A, u) = (&s.factor.X_PB[..], &s.C[..], &mut s.A[..], &s.u[..]);
    let joints = s.factor.joints();
    for i in tree.range() {
        let body = &tree.bodies()[i];
        let A_P = match body.parent {
            Some(p) => tree.carrier(i, p, A),
            None => *A_W,
        };
        let A_i = X_PB[i].motion_inverse_plus(&A_P, &C[i]);
        let (v, w) = (A_i.linear, A_i.angular);
        match body.joint {
            JointKind::Revolute | JointKind::Continuous => {
                let turn = joints.acceleration(body.v, u, &A_P);
                a[body.v] = turn;
                A[i] = Motion::new(v, Vector3::new(w.x, w.y, w.z + turn));
            }
            JointKind::Prismatic => {
                let slide = joints.acceleration(body.v, u, &A_P);
                a[body.v] = slide;
                A[i] = Motion::new(Vector3::new(v.x, v.y, v.z + slide), w);
            }
            _ => A[i] = joints.accelerate(body, u, A_i, a),
        }
    }
}
