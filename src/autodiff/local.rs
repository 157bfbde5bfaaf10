//! First-order motion and force of a body and its joint, by dual numbers: the pieces of derivatives along the tree.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::Dual;
use crate::dynamics::joint_motion;
use crate::joint::{JointKind, MAX_NV};
use crate::model::Body;
use crate::scalar::Lanes;
use crate::spatial::{Force, Motion};

/// Derivative of the motion of a body in the position and in the velocity of one degree of freedom (the two lanes), seen from
/// the body.
///
/// A body whose parent changes by (δV, δA) changes by δV and δA + δV × (V − V of the parent). So the sum δÂ = δA − δV × V is carried
/// along the tree like a vector that stays the same, and δV as well; and of δV only the angular part δω makes a force, because
/// the force at a given δÂ does not depend on a uniform velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direction {
    /// δω.
    pub(super) omega: Vector3<Lanes<2>>,
    /// δÂ.
    pub(super) A: Motion<Lanes<2>>,
}

impl Direction {
    pub(super) fn zero() -> Self {
        Self {
            omega: Vector3::zeros(),
            A: Motion::zero(),
        }
    }
}

/// The velocities of a joint on dual numbers, one direction for each degree of freedom.
pub(super) struct Seeded<'a, const W: usize> {
    /// v without derivatives.
    pub(super) v: &'a [Dual<f64, W>],
    /// v + ε.
    pub(super) v_moved: &'a [Dual<f64, W>],
    /// a without derivatives.
    pub(super) a: &'a [Dual<f64, W>],
}

/// The motion of a body and how it changes, where it would move by `carried` if its joint stood still; `moved` is the joint 0 ⊕ ε.
///
/// The tangents of a joint are those of its body, so that its pose at q ⊕ ε is X(q) X(0 ⊕ ε).
#[inline(always)]
pub(super) fn place<const W: usize>(
    body: &Body<f64>,
    (joint, moved): (JointKind, &[Dual<f64, W>]),
    at: &Seeded<'_, W>,
    carried: (&Motion<f64>, &Motion<f64>),
    directions: &mut [Direction],
) -> (Motion<f64>, Motion<f64>) {
    let turned = (
        joint.motion_inverse(moved, carried.0),
        joint.motion_inverse(moved, carried.1),
    );
    let still = (carried.0.lift(), carried.1.lift());
    let by_q = joint_motion(body, Some(at.v), Some(at.a), turned);
    let by_v = joint_motion(body, Some(at.v_moved), Some(at.a), still);
    let (V, A) = (value(&by_q.0), value(&by_q.1));
    for (w, direction) in directions.iter_mut().enumerate() {
        let dV = derivatives(&by_q.0, &by_v.0, w);
        let dA = derivatives(&by_q.1, &by_v.1, w);
        direction.omega = dV.angular;
        direction.A = dA - dV.cross_data(&V);
    }
    (V, A)
}

/// 0 ⊕ ε for a joint with one axis, which may follow another.
#[inline(always)]
pub(super) fn moved(body: &Body<f64>) -> Dual<f64, 1> {
    Dual::new(0.0, [body.scaled(1.0)])
}

/// [`place`] for a joint of several degrees of freedom, whose own coordinates are given.
#[inline(never)]
pub(super) fn place_several<const W: usize>(
    body: &Body<f64>,
    (v, a): (&[f64], &[f64]),
    carried: (&Motion<f64>, &Motion<f64>),
    directions: &mut [Direction],
) -> (Motion<f64>, Motion<f64>) {
    let (still, a) = (lifted::<W>(v), lifted(a));
    let mut v_moved = still;
    for k in 0..v.len() {
        v_moved[k] = Dual::variable(v[k], k);
    }
    let own = Body {
        q: 0,
        v: 0,
        ..body.clone()
    };
    let at = Seeded {
        v: &still,
        v_moved: &v_moved,
        a: &a,
    };
    let moved = moved_from_zero(body.joint);
    place(&own, (body.joint, &moved), &at, carried, directions)
}

/// Derivative of a force on a body in the position of each degree of freedom of its joint, seen from where the body is; `moved` is the
/// joint 0 ⊕ ε.
#[inline(always)]
pub(super) fn turned_force<const W: usize>(
    joint: JointKind,
    moved: &[Dual<f64, W>],
    F: &Force<f64>,
) -> [Force<f64>; W] {
    let F = joint.force(moved, F);
    let mut out = [Force::zero(); W];
    for (w, out) in out.iter_mut().enumerate() {
        *out = Force::new(F.linear.map(|x| x.eps[w]), F.angular.map(|x| x.eps[w]));
    }
    out
}

/// [`turned_force`] for a joint of several degrees of freedom.
#[inline(never)]
pub(super) fn turned_by_several(joint: JointKind, F: &Force<f64>) -> [Force<f64>; MAX_NV] {
    turned_force(joint, &moved_from_zero(joint), F)
}

/// 0 ⊕ ε: the joint where its frames coincide, moved by one direction for each degree of freedom.
fn moved_from_zero<const W: usize>(joint: JointKind) -> JointCoordinates<W> {
    let mut zero = [0.0; MAX_NV + 1];
    let zero = &mut zero[..joint.nq()];
    joint.neutral(zero);
    moved_by_own_tangents(joint, zero)
}

/// The coordinates of a joint on dual numbers; a joint has at most one position more than velocities.
pub(crate) type JointCoordinates<const W: usize> = [Dual<f64, W>; MAX_NV + 1];

/// Numbers without derivatives, in the first places.
pub(crate) fn lifted<const W: usize>(x: &[f64]) -> JointCoordinates<W> {
    let mut out = [Dual::from(0.0); MAX_NV + 1];
    out.iter_mut().zip(x).for_each(|(out, &x)| *out = x.into());
    out
}

/// q ⊕ ε: moved by one direction for each degree of freedom, the first directions of all.
pub(crate) fn moved_by_own_tangents<const W: usize>(
    joint: JointKind,
    q: &[f64],
) -> JointCoordinates<W> {
    let start = lifted(q);
    let (mut tangent, mut moved) = (lifted(&[]), start);
    for k in 0..joint.nv() {
        tangent[k] = Dual::variable(0.0, k);
    }
    let nq = q.len();
    joint.integrate(&start[..nq], &tangent[..joint.nv()], &mut moved[..nq]);
    moved
}

#[inline(always)]
fn value<const W: usize>(V: &Motion<Dual<f64, W>>) -> Motion<f64> {
    Motion::new(V.linear.map(|x| x.re), V.angular.map(|x| x.re))
}

/// The derivatives of two motions in direction `w`, side by side.
#[inline(always)]
fn derivatives<const W: usize>(
    by_q: &Motion<Dual<f64, W>>,
    by_v: &Motion<Dual<f64, W>>,
    w: usize,
) -> Motion<Lanes<2>> {
    let pair = |a: Dual<f64, W>, b: Dual<f64, W>| Lanes([a.eps[w], b.eps[w]]);
    Motion::new(
        by_q.linear.zip_map(&by_v.linear, pair),
        by_q.angular.zip_map(&by_v.angular, pair),
    )
}
