//! First-order motion and force of a body and its joint, by dual numbers: the pieces of derivatives along the tree.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use crate::dynamics::rnea::{Accelerated, joint_motion_over};
use crate::joint::{Joint, JointKind, MAX_NV};
use crate::model::Body;
use crate::scalar::{CHUNK, Differentiable, DualNumber, Over, Pack, Scalar};
use crate::spatial::linear::zero;
use crate::spatial::{Force, Motion};

/// Derivative of the motion of a body in the position and in the velocity of one degree of freedom (the two of a pack), seen from
/// the body.
///
/// A body whose parent changes by (δV, δA) changes by δV and δA + δV × (V − V of the parent). So the sum δÂ = δA − δV × V is carried
/// along the tree like a vector that stays the same, and δV as well; and of δV only the angular part δω makes a force, because
/// the force at a given δÂ does not depend on a uniform velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direction<T> {
    /// δω.
    pub(super) omega: Vector3<Pack<T, 2>>,
    /// δÂ.
    pub(super) A: Motion<Pack<T, 2>>,
}

impl<T: Scalar> Direction<T> {
    pub(super) fn zero() -> Self {
        Self {
            omega: zero(),
            A: Motion::zero(),
        }
    }
}

/// The velocities of a joint on dual numbers, one direction for each degree of freedom.
pub(super) struct Seeded<'a, D> {
    /// v without derivatives.
    pub(super) v: &'a [D],
    /// v + ε.
    pub(super) v_moved: &'a [D],
    /// a without derivatives.
    pub(super) a: &'a [D],
}

/// The motion of a body and how it changes, where it would move by `carried` if its joint stood still; `moved` is the joint 0 ⊕ ε.
///
/// The tangents of a joint are those of its body, so that its pose at q ⊕ ε is X(q) X(0 ⊕ ε).
#[inline(always)]
pub(super) fn place<P, T, D, J, const W: usize>(
    body: &Body<P>,
    joint: J,
    moved: &[D],
    at: &Seeded<'_, D>,
    carried: &Accelerated<T>,
    directions: &mut [Direction<T>],
) -> Accelerated<T>
where
    P: Scalar,
    T: Over<P>,
    D: Over<T> + DualNumber<T, W>,
    J: Joint,
{
    let turned = Accelerated {
        V: joint.motion_inverse(moved, &carried.V),
        A: joint.motion_inverse(moved, &carried.A),
    };
    let still = Accelerated::<D> {
        V: carried.V.lift(),
        A: carried.A.lift(),
    };
    let by_q = joint_motion_over::<P, T, D>(body, Some(at.v), Some(at.a), turned);
    let by_v = joint_motion_over::<P, T, D>(body, Some(at.v_moved), Some(at.a), still);
    let (V, A) = (value(&by_q.V), value(&by_q.A));
    for (w, direction) in directions.iter_mut().enumerate() {
        let (dV_q, dV_v) = (slope(&by_q.V, w), slope(&by_v.V, w));
        let dA_q = slope(&by_q.A, w) - dV_q.cross(&V);
        let dA_v = slope(&by_v.A, w) - dV_v.cross(&V);
        direction.omega = dV_q.angular.zip_map(&dV_v.angular, pair);
        direction.A = Motion::new(
            dA_q.linear.zip_map(&dA_v.linear, pair),
            dA_q.angular.zip_map(&dA_v.angular, pair),
        );
    }
    Accelerated { V, A }
}

/// 0 ⊕ ε for a joint with one axis, which may follow another.
#[inline(always)]
pub(super) fn moved<P: Scalar, T: Over<P>, D: DualNumber<T, 1>>(body: &Body<P>) -> D {
    D::new(T::zero(), [body.scaled(T::one())])
}

/// [`place`] for a joint of a rare kind, whose own coordinates are given: a few directions at a time, compiled for one width of all kinds.
#[inline(never)]
pub(super) fn place_rare<P: Scalar, T: Differentiable + Over<P>>(
    body: &Body<P>,
    v: &[T],
    a: &[T],
    carried: &Accelerated<T>,
    directions: &mut [Direction<T>],
) -> Accelerated<T> {
    let own = Body {
        q: 0,
        v: 0,
        ..body.clone()
    };
    let mut out = *carried;
    for (chunk, directions) in directions.chunks_mut(CHUNK).enumerate() {
        out = place_some(&own, v, a, carried, (chunk * CHUNK, directions));
    }
    out
}

/// [`place_rare`] in some directions, from the first one on.
fn place_some<P: Scalar, T: Differentiable + Over<P>>(
    body: &Body<P>,
    v: &[T],
    a: &[T],
    carried: &Accelerated<T>,
    (first, directions): (usize, &mut [Direction<T>]),
) -> Accelerated<T> {
    let (still, a) = (lifted(v), lifted::<T, T::Dual<CHUNK>, CHUNK>(a));
    let mut v_moved = still;
    for k in 0..directions.len() {
        v_moved[first + k] = DualNumber::variable(v[first + k], k);
    }
    let at = Seeded {
        v: &still,
        v_moved: &v_moved,
        a: &a,
    };
    let moved = moved_from_zero::<T, T::Dual<CHUNK>, CHUNK>(body.joint, first);
    place(body, body.joint, &moved, &at, carried, directions)
}

/// Derivative of a force on a body in the position of each degree of freedom of its joint, seen from where the body is; `moved` is the
/// joint 0 ⊕ ε.
#[inline(always)]
pub(super) fn turned_force<T: Scalar, D: Over<T> + DualNumber<T, W>, J: Joint, const W: usize>(
    joint: J,
    moved: &[D],
    F: &Force<T>,
) -> J::PerDof<Force<T>> {
    let F: Force<D> = joint.force(moved, F);
    joint.per_dof(
        #[inline(always)]
        |w| Force::new(F.linear.map(|x| x.eps()[w]), F.angular.map(|x| x.eps()[w])),
    )
}

/// [`turned_force`] for a joint of a rare kind, which is `kind`.
#[inline(never)]
pub(super) fn turned_by_rare<T: Differentiable, J: Joint>(
    kind: JointKind,
    joint: J,
    F: &Force<T>,
) -> J::PerDof<Force<T>> {
    let mut all = [Force::zero(); MAX_NV];
    for (chunk, all) in all[..kind.nv()].chunks_mut(CHUNK).enumerate() {
        let moved = moved_from_zero::<T, T::Dual<CHUNK>, CHUNK>(kind, chunk * CHUNK);
        let F: Force<T::Dual<CHUNK>> = kind.force(&moved, F);
        for (w, out) in all.iter_mut().enumerate() {
            *out = Force::new(F.linear.map(|x| x.eps()[w]), F.angular.map(|x| x.eps()[w]));
        }
    }
    joint.per_dof(
        #[inline(always)]
        |w| all[w],
    )
}

/// 0 ⊕ ε: the joint where its frames coincide, moved by directions of its degrees of freedom from the first one on.
fn moved_from_zero<T: Scalar, D: DualNumber<T, W>, const W: usize>(
    joint: JointKind,
    first: usize,
) -> JointCoordinates<D> {
    let mut zero = [T::zero(); MAX_NV + 1];
    let zero = &mut zero[..joint.nq()];
    joint.neutral(zero);
    moved_by_own_tangents(joint, zero, first)
}

/// The coordinates of a joint; it has at most one position more than velocities.
pub(crate) type JointCoordinates<D> = [D; MAX_NV + 1];

/// Numbers without derivatives, in the first places.
pub(crate) fn lifted<T: Scalar, D: DualNumber<T, W>, const W: usize>(
    x: &[T],
) -> JointCoordinates<D> {
    let mut out = [D::zero(); MAX_NV + 1];
    for k in 0..x.len() {
        out[k] = D::new(x[k], [T::zero(); W]);
    }
    out
}

/// q ⊕ ε: moved by one direction for each degree of freedom from the first one on, as many as there are directions.
pub(crate) fn moved_by_own_tangents<T: Scalar, D: DualNumber<T, W>, const W: usize>(
    joint: JointKind,
    q: &[T],
    first: usize,
) -> JointCoordinates<D> {
    let start = lifted(q);
    let (mut tangent, mut moved) = ([D::zero(); MAX_NV + 1], start);
    for k in first..joint.nv().min(first + W) {
        tangent[k] = D::variable(T::zero(), k - first);
    }
    let nq = q.len();
    joint.integrate(&start[..nq], &tangent[..joint.nv()], &mut moved[..nq]);
    moved
}

#[inline(always)]
fn value<T: Scalar, D: DualNumber<T, W>, const W: usize>(V: &Motion<D>) -> Motion<T> {
    Motion::new(V.linear.map(|x| x.re()), V.angular.map(|x| x.re()))
}

/// The derivative of a motion in direction `w`.
#[inline(always)]
fn slope<T: Scalar, D: DualNumber<T, W>, const W: usize>(V: &Motion<D>, w: usize) -> Motion<T> {
    Motion::new(V.linear.map(|x| x.eps()[w]), V.angular.map(|x| x.eps()[w]))
}

#[inline(always)]
fn pair<T: Scalar>(by_q: T, by_v: T) -> Pack<T, 2> {
    Pack([by_q, by_v])
}
