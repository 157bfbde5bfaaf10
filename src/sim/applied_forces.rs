//! Forces that external forces and frame actuators apply, for display.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::force::FrameTerm;
use super::simulator::Simulator;
use super::state::State;
use crate::dynamics::{Kinematics, forward_kinematics_into};
use crate::model::FrameId;
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Representation, Transform};

/// A force at an attachment frame of a robot at an instant.
#[derive(Clone, Debug, PartialEq)]
pub struct AppliedForce<T = f64> {
    /// The frame that carries the attachment frame.
    pub frame: FrameId,
    /// Pose of the attachment frame in the world, m.
    pub pose: Transform<T>,
    /// Force and moment in world axes, about the origin of the attachment frame (*mixed*; N, N·m).
    pub force: Force<T>,
}

impl<P: Scalar> Simulator<P> {
    /// The forces on places at a state under the input `u` (length `nu`): external ones in their order, then those of frame actuators
    /// in the order of their inputs. Allocates.
    ///
    /// # Panics
    /// If state or input have the wrong length.
    pub(crate) fn applied_forces<T: Over<P>>(
        &self,
        state: &State<T>,
        u: &[T],
    ) -> Vec<AppliedForce<T>> {
        self.check_input(u);
        self.check(state);
        let model = self.model();
        let mut kinematics = Kinematics::new(model);
        forward_kinematics_into(
            model,
            state.q.as_slice(),
            state.v.as_slice(),
            &mut kinematics,
        );
        let u = self.frame_inputs(u);
        let apply = |term: FrameTerm<'_, P>| {
            let (frame, mounted) = (term.place().frame?, term.place().mounted(model));
            let X_WB = kinematics.pose(mounted.body);
            let V_B = kinematics.velocity(mounted.body);
            let u = term.input().map_or(T::zero(), |input| u[input]);
            let F_B = term.body_force(&mounted.X_BA, &X_WB, &V_B, u, None);
            let pose = mounted.X_BA.after(&X_WB);
            let F_A = mounted.X_BA.force_inverse(&F_B);
            Some(AppliedForce {
                frame,
                pose,
                force: Representation::Mixed.force_from_body(&pose, &F_A),
            })
        };
        self.frame_terms().iter().filter_map(apply).collect()
    }
}
