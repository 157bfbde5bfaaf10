//! Forces of the frame terms of a simulator on its bodies, at a state under an input.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::FrameTerms;
use crate::dynamics::{Kinematics, forward_kinematics_into};
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::sim::State;
use crate::spatial::{Force, Motion, Transform};

/// Working memory for the forces of frame terms on bodies: empty where there are none.
#[derive(Clone, Debug)]
pub(crate) struct BodyForces<T> {
    /// `None` where no force asks how its body moves.
    kinematics: Option<Box<Kinematics<T>>>,
    /// On each body, in the body.
    forces: Vec<Force<T>>,
}

impl<T: Scalar> BodyForces<T> {
    pub(crate) fn new<P: Scalar>(model: &Model<P>, terms: &FrameTerms<P>) -> Self {
        let follows = terms.iter().any(|term| !term.is_fixed_to_body());
        let bodies = if terms.is_empty() {
            0
        } else {
            model.n_bodies()
        };
        Self {
            kinematics: follows.then(|| Box::new(Kinematics::new(model))),
            forces: vec![Force::zero(); bodies],
        }
    }

    /// Finds the forces at a state; `u` is what is left of the input for frame actuators.
    pub(crate) fn find<P: Scalar>(
        &mut self,
        model: &Model<P>,
        terms: &FrameTerms<P>,
        state: &State<T>,
        u: &[T],
    ) where
        T: Over<P>,
    {
        if let Some(kinematics) = &mut self.kinematics {
            forward_kinematics_into(model, state.q.as_slice(), state.v.as_slice(), kinematics);
        }
        assert_eq!(
            self.forces.is_empty(),
            terms.is_empty(),
            "the scratch is of a simulator without these forces"
        );
        self.forces.fill(Force::zero());
        for term in terms.iter() {
            let Some(mount) = term.mount(model) else {
                continue;
            };
            let u = term.input().map_or(T::zero(), |input| u[input]);
            let (mut X_WB, mut V_B) = (Transform::identity(), Motion::zero());
            if let Some(kinematics) = &self.kinematics {
                X_WB = kinematics.pose(Some(mount.body));
                V_B = kinematics.velocity(Some(mount.body));
            }
            self.forces[mount.body.0] += term.body_force(&mount.X_BA, &X_WB, &V_B, u);
        }
    }

    /// On each body, in the body; empty without terms.
    pub(crate) fn as_slice(&self) -> &[Force<T>] {
        &self.forces
    }
}
