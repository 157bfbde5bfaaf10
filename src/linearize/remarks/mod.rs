//! Remarks on the time step, by Jacobians of the step and of the rate.

mod modes;

use crate::sim::{Simulator, SimulatorRemark};

impl Simulator<f64> {
    /// Remarks on a time step that is too long, for the robot in poses like one; empty where there are none. Allocates.
    ///
    /// | question | found by |
    /// |---|---|
    /// | is the step stable for springs, dampers and dry friction of joints, springs of [constraints](crate::constraint::Constraint::with_spring), external forces, gravity? | the eigenvalues of the step, at rest without input and without ground, against those of the rate |
    /// | does it resolve each vibration by ten steps a period? | the eigenvalues of the rate |
    /// | is it stable for limits of position and speed? | each joint by itself, in an impact at 1 rad/s or m/s |
    /// | is it short enough for soft contact? | each point by itself, with the effective mass that the robot has there along the normal, in an impact at 1 m/s |
    ///
    /// Whether a step that is found too long does harm depends on the motion. Controllers in callbacks are not seen.
    ///
    /// * `q` – configuration, length `nq`
    ///
    /// # Panics
    /// If the slice has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Integrator, Simulator, model::samples};
    ///
    /// // A damper of 2 N·m·s on J = 1/3 kg·m²: Runge and Kutta's method is stable up to 2.785 J / d = 0.46 s.
    /// let pendulum = samples::pendulum().with_damping(0, 200.0);
    /// let simulator = Simulator::new(pendulum).with_time_step(0.01);
    /// assert!(simulator.remarks(&[0.0]).is_empty());
    /// let explicit = simulator.with_integrator(Integrator::RungeKutta4);
    /// let said = explicit.remarks(&[0.0])[0].to_string();
    /// assert!(said.contains("use steps of at most 4.6e-3 s"), "{said}");
    /// ```
    pub fn remarks(&self, q: &[f64]) -> Vec<SimulatorRemark> {
        self.model().check_q(q);
        let found = [
            self.remark_on_modes(q),
            self.remark_on_limits(q),
            self.remark_on_soft_contact(q),
        ];
        found.into_iter().flatten().collect()
    }
}
