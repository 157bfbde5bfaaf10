//! Rows of a constraint from the motions of the two bodies of its attachment frames.
//!
//! In any joint tree, a row depends only on poses, velocities and accelerations of its two bodies; sweeps along the tree give their derivatives.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::Constraint;
use super::anchor::{AnchorMotion, Carrier, Mounted};
use super::rows::ConstraintRow;
use crate::scalar::{MapEach, Over, Scalar};
use crate::spatial::{Force, Motion, Transform};

/// Motion of a body that carries an anchor; all but the pose are seen from the body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CarrierMotion<T> {
    pub(crate) X_WB: Transform<T>,
    pub(crate) V: Motion<T>,
    /// Spatial acceleration while ã = 0; that of the world may be added, for all bodies.
    pub(crate) bias: Motion<T>,
    /// The motion that the accelerations ã of joints give it.
    pub(crate) U: Motion<T>,
}

impl<T: Scalar> CarrierMotion<T> {
    /// That of the world.
    pub(crate) fn at_rest() -> Self {
        Self {
            X_WB: Transform::identity(),
            V: Motion::zero(),
            bias: Motion::zero(),
            U: Motion::zero(),
        }
    }

    pub(super) fn biased(&self) -> Carrier<T> {
        Carrier {
            X: self.X_WB,
            V: self.V,
            A: self.bias,
        }
    }
}

/// A row, and J times the motion of the joints by ã.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CarriedRow<T> {
    pub(crate) row: ConstraintRow<T>,
    /// J ã.
    pub(crate) along_seen: T,
    /// The unit force of the row on each body, in it: J of its motion.
    pub(crate) unit_forces: [Force<T>; 2],
}

impl<P: Scalar> Constraint<P> {
    /// Passes each row between anchors that bodies carry to `each`; constraints that tie joints have none.
    ///
    /// * `mounted` – poses of the anchors in the bodies
    /// * `dt` – the step, s, which regularised rows depend on
    #[inline(always)]
    pub(crate) fn each_carried_row<Q: Scalar, T: Over<P> + Over<Q>>(
        &self,
        mounted: &[Mounted<Q>; 2],
        bodies: &[CarrierMotion<T>; 2],
        dt: T,
        mut each: impl FnMut(CarriedRow<T>),
    ) {
        let motion = |i: usize| AnchorMotion::on(&mounted[i].X_BA, &bodies[i].biased());
        let motions = [motion(0), motion(1)];
        let [from, to] =
            [0, 1].map_each(|i| motions[i].velocity_under(&bodies[i].X_WB, &bodies[i].U));
        let U = to - from;
        self.each_row_of_anchors(&motions, dt, |row, axis| {
            let unit = axis.unit_force();
            let on = |i: usize| motions[i].force_on(&bodies[i].X_WB, &unit);
            each(CarriedRow {
                row,
                along_seen: axis.of(&U),
                unit_forces: [-on(0), on(1)],
            });
        });
    }
}
