//! The joints between a body and the world: their motion of the body, and its derivatives.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::columns::each_turning;
use crate::dynamics::{Kinematics, to_world};
use crate::joint::MAX_NV;
use crate::model::{BodyId, Model};
use crate::scalar::{Dual, Scalar};
use crate::spatial::Motion;

/// The coordinates that carry a body, from the body to the world.
#[derive(Clone, Debug)]
pub(super) struct Chain<T = f64> {
    /// A coordinate, and the motion that its unit rate gives to the body, in the body.
    pub(super) coordinates: Vec<(usize, Motion<T>)>,
    /// Number of coordinates of each body on the way.
    joints: Vec<(BodyId, usize)>,
}

/// Derivatives of a motion in position and rate of each coordinate of a chain.
#[derive(Clone, Debug)]
pub(super) struct Turns<T> {
    pub(super) by_position: Vec<Motion<T>>,
    pub(super) by_rate: Vec<Motion<T>>,
}

impl<T: Scalar> Turns<T> {
    /// Makes memory for a model.
    pub(super) fn new(model: &Model) -> Self {
        let most = most_coordinates(model);
        Self {
            by_position: Vec::with_capacity(most),
            by_rate: Vec::with_capacity(most),
        }
    }
}

/// A coordinate that others follow may occur several times.
pub(super) fn most_coordinates(model: &Model) -> usize {
    model.bodies().iter().map(|body| body.joint.nv()).sum()
}

impl<T: Scalar> Chain<T> {
    /// Makes memory for a model.
    pub(super) fn new(model: &Model) -> Self {
        Self {
            coordinates: Vec::with_capacity(most_coordinates(model)),
            joints: Vec::with_capacity(model.n_bodies()),
        }
    }

    /// Starts anew from a body.
    pub(super) fn follow(&mut self, model: &Model, kinematics: &Kinematics<T>, body: BodyId) {
        self.coordinates.clear();
        self.joints.clear();
        let X_WB = kinematics.pose(Some(body));
        for (id, body) in to_world(model, Some(body)) {
            let X_AB = kinematics.pose(Some(id)).inverse() * X_WB;
            let own = body.columns();
            let before = self.coordinates.len();
            self.coordinates
                .extend(own.map(|(k, S)| (k, X_AB.motion_inverse(&S))));
            self.joints.push((id, self.coordinates.len() - before));
        }
    }

    /// The motion of the body at rates of the coordinates, in the body.
    pub(super) fn motion(&self, rates: &[T]) -> Motion<T> {
        let moved = self.coordinates.iter();
        moved.fold(Motion::zero(), |V, &(k, S)| V + S * rates[k])
    }

    /// Derivative of [`motion`](Self::motion) in the position of each coordinate, at given rates.
    ///
    /// When a joint moves on by δq, the motion `V_P` that the body has from before the joint turns, seen from the body: δV = `V_P` × S δq.
    pub(super) fn turns(&self, rates: &[T], out: &mut Vec<Motion<T>>) {
        out.clear();
        let mut V_P = self.motion(rates);
        let mut rest = &self.coordinates[..];
        for &(_, n) in &self.joints {
            let (own, before) = rest.split_at(n);
            own.iter().for_each(|&(k, S)| V_P = V_P - S * rates[k]);
            out.extend(own.iter().map(|(_, S)| V_P.cross(S)));
            rest = before;
        }
    }

    /// The acceleration of the body while ã = 0, in the body, with its derivatives.
    ///
    /// A joint whose own motion is W adds  c = `V_P` × W − S t  with the turning t of its axes. When it moves on, `V_P` and what the joints before it have
    /// added turn:  δ = (`B_P` × S + (`V_P` × S) × W⁺) δq  with the motion W⁺ of it and of all joints after it. With its rate,
    /// δ = (`V_P` × S + S × (W⁺ − W) − S ∂t/∂v) δv.
    pub(super) fn bias(&self, model: &Model, v: &[T], out: &mut Turns<T>) -> Motion<T> {
        out.by_position.clear();
        out.by_rate.clear();
        let V = self.motion(v);
        let (mut bias, mut after) = (Motion::zero(), Motion::zero());
        self.each_joint(model, v, &mut |joint| {
            bias = bias + (V - after - joint.W).cross(&joint.W) - joint.turning;
            after += joint.W;
        });
        let (mut B_P, mut after) = (bias, Motion::zero());
        self.each_joint(model, v, &mut |joint| {
            let V_P = V - after - joint.W;
            B_P = B_P - (V_P.cross(&joint.W) - joint.turning);
            let with_own = after + joint.W;
            for (l, &(_, S)) in joint.own.iter().enumerate() {
                let turned = V_P.cross(&S);
                out.by_position
                    .push(B_P.cross(&S) + turned.cross(&with_own));
                let turning = joint.turning_by_rate(model, v, l);
                out.by_rate.push(turned + S.cross(&after) - turning);
            }
            after = with_own;
        });
        bias
    }

    /// Passes the joints from the body to the world to `each`.
    fn each_joint(&self, model: &Model, v: &[T], each: &mut dyn FnMut(ChainJoint<'_, T>)) {
        let mut rest = &self.coordinates[..];
        for &(body, n) in &self.joints {
            let (own, before) = rest.split_at(n);
            let mut joint = ChainJoint {
                body,
                own,
                W: own.iter().fold(Motion::zero(), |W, &(k, S)| W + S * v[k]),
                turning: Motion::zero(),
            };
            let mut turning = Motion::zero();
            joint.each_turning(model, v, |S, x| turning += S * x.re);
            joint.turning = turning;
            each(joint);
            rest = before;
        }
    }
}

/// A joint of a chain.
struct ChainJoint<'a, T> {
    body: BodyId,
    own: &'a [(usize, Motion<T>)],
    /// Its own motion.
    W: Motion<T>,
    /// Part that the turning of its axes takes from the acceleration.
    turning: Motion<T>,
}

impl<T: Scalar> ChainJoint<'_, T> {
    /// Passes each motion along which axes turn, and by how much with its derivatives in the rates of the joint, to `each`.
    fn each_turning(
        &self,
        model: &Model,
        v: &[T],
        mut each: impl FnMut(Motion<T>, Dual<T, MAX_NV>),
    ) {
        let body = model.body(self.body);
        if body.coupling.is_none() {
            each_turning(body, v, |k, x| {
                each(self.own[k - body.v].1, x);
            });
        }
    }

    /// Derivative of the rotation term in one rate of the joint.
    fn turning_by_rate(&self, model: &Model, v: &[T], l: usize) -> Motion<T> {
        let mut sum = Motion::zero();
        self.each_turning(model, v, |S, x| sum += S * x.eps[l]);
        sum
    }
}
