//! Remarks on limits of position and speed of joints in the Runge–Kutta method, joint by joint.
//!
//! The other integrators take them at the end or in the middle of the step, where they are stable at any step.

use super::remark::SimulatorRemark;
use super::spring_damper::SpringDamper;
use crate::dynamics::mass_matrix_inverse;
use crate::nested::IntoNested;
use crate::sim::actuation::Actuator;
use crate::sim::integrator::Integrator;
use crate::sim::simulator::Simulator;

impl Simulator<f64> {
    /// The remark on the joint whose limit is worst, met at 1 rad/s or m/s in poses like `q` while the other joints are free.
    pub(crate) fn remark_on_limits(&self, q: &[f64]) -> Option<SimulatorRemark> {
        let actuation = self.actuation()?;
        if self.integrator() != Integrator::RungeKutta4 {
            return None;
        }
        let mobility = mass_matrix_inverse(self.model(), q).diagonal();
        let each = actuation.actuators().iter().enumerate();
        let longest = each.nested(|(k, actuator)| {
            let springs = limits(actuator, 1.0 / mobility[k]).into_iter().flatten();
            springs.map(move |spring| (k, spring.longest_of_runge_kutta()))
        });
        let (k, longest) = longest.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let time_step = self.time_step();
        (time_step > longest).then(|| SimulatorRemark::UnstableLimit {
            joint: self.tangent_name(k),
            longest,
            time_step,
        })
    }
}

/// Slopes of the limits of position and speed of a coordinate.
///
/// * `mass` – kg or kg·m²
fn limits(actuator: &Actuator, mass: f64) -> [Option<SpringDamper>; 2] {
    let stop = actuator.position.map(|limits| limits.stop);
    let stop = stop.filter(|stop| stop.stiffness > 0.0);
    let speed = actuator.velocity.filter(|limit| limit.damping > 0.0);
    [
        stop.map(|stop| SpringDamper::in_impact(&stop, mass)),
        speed.map(|limit| SpringDamper {
            spring: 0.0,
            damper: limit.damping,
            mass,
        }),
    ]
}
