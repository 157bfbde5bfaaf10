//! Motions and forces of the step just taken.

use crate::dynamics::{Kinematics, Motions};
use crate::scalar::Scalar;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::AccelerationScratch;
use crate::spatial::Force;

/// What sensors see of a step.
pub(crate) struct Moment<'a, P, T: Scalar> {
    pub(super) at: &'a EvaluationPoint<'a, P, T>,
    pub(super) found: &'a AccelerationScratch<T>,
    /// Poses in the world, of the bodies for which they are needed.
    pub(super) kinematics: &'a Kinematics<T>,
    pub(super) motions: Motions<'a, T>,
    /// The force that each joint transmits to its body, in the body, where it is needed.
    pub(super) forces: &'a [Force<T>],
}
