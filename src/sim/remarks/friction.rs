//! Remark on dry friction that an integrator smooths.

use super::remark::SimulatorRemark;
use crate::sim::integrator::Integrator;
use crate::sim::simulator::Simulator;

impl Simulator<f64> {
    /// The remark on the joint that creeps fastest of those whose friction is to hold and does not.
    pub(crate) fn remark_on_friction(&self) -> Option<SimulatorRemark> {
        let integrator = self.integrator();
        if matches!(
            integrator,
            Integrator::SemiImplicitEuler | Integrator::ImplicitVelocity
        ) {
            return None;
        }
        let frictions = self.actuation()?.exact_frictions();
        let held = frictions.filter(|(_, friction)| friction.force > 0.0);
        let (k, friction) =
            held.max_by(|(_, a), (_, b)| a.slip_velocity.total_cmp(&b.slip_velocity))?;
        Some(SimulatorRemark::SmoothedFriction {
            joint: self.tangent_name(k),
            slip_velocity: friction.slip_velocity,
            integrator,
        })
    }
}
