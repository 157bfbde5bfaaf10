//! The joints between a body and the world: how they move it, and how that motion turns when they move on.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use crate::dynamics::{Kinematics, to_world};
use crate::model::{BodyId, Model};
use crate::scalar::Scalar;
use crate::spatial::Motion;

/// The coordinates that carry a body, from the body to the world.
#[derive(Clone, Debug)]
pub(super) struct Chain<T = f64> {
    /// A coordinate, and the motion that its unit rate gives to the body, in the body.
    pub(super) coordinates: Vec<(usize, Motion<T>)>,
    /// Number of coordinates of each body on the way.
    joints: Vec<usize>,
}

impl<T: Scalar> Chain<T> {
    /// Memory for a model.
    pub(super) fn new(model: &Model) -> Self {
        // A coordinate that others follow may occur several times.
        let most = model.bodies().iter().map(|body| body.joint.nv()).sum();
        Self {
            coordinates: Vec::with_capacity(most),
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
            self.joints.push(self.coordinates.len() - before);
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
        for &n in &self.joints {
            let (own, before) = rest.split_at(n);
            own.iter().for_each(|&(k, S)| V_P = V_P - S * rates[k]);
            out.extend(own.iter().map(|(_, S)| V_P.cross(S)));
            rest = before;
        }
    }
}
