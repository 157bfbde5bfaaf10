//! Motions and forces of the step just taken.

use crate::dynamics::{Kinematics, RneaScratch};
use crate::scalar::Scalar;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::AccelerationScratch;

/// What sensors see of a step.
pub(crate) struct Moment<'a, P, T: Scalar> {
    pub(super) at: &'a EvaluationPoint<'a, P, T>,
    pub(super) found: &'a AccelerationScratch<T>,
    pub(super) kinematics: &'a Kinematics<T>,
    pub(super) rnea: &'a RneaScratch<T>,
}
