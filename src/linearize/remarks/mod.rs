//! Remarks on the time step, by Jacobians of the step and of the rate.

mod frozen;
mod modes;
mod rotation;

use crate::sim::{Simulator, SimulatorRemark};

impl Simulator<f64> {
    /// Returns remarks on a time step that is too long, and on friction that does not hold, for poses near `q`; empty if there are none. Allocates.
    ///
    /// | question | method |
    /// |---|---|
    /// | is the step stable for springs, dampers and dry friction of joints, springs of [constraints](crate::constraint::Constraint::with_spring), external forces, gravity? | the eigenvalues of the step, at rest without input and without ground, compared with those of the rate |
    /// | does each vibration have at least ten steps per period? | the eigenvalues of the rate |
    /// | is it stable for joint and speed limits? | each joint separately, in an impact at 1 rad/s or m/s |
    /// | does dry friction hold? | the integrator: the Runge–Kutta method and the implicit midpoint rule smooth it |
    /// | is it short enough for soft contact? | each point separately, with the effective mass of the robot there along the normal, in an impact at 1 m/s |
    ///
    /// Whether a too long step causes errors depends on the motion. Controllers in callbacks are not taken into account.
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
    /// // A damper d of 200 N·m·s on J = 1/3 kg·m²: The Runge–Kutta method is stable up to 2.785 J / d = 4.64 ms.
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
            self.remark_on_friction(),
        ];
        found.into_iter().flatten().collect()
    }

    /// [`remarks`](Self::remarks), and remarks on rotations: whether the step is short enough for velocities like `v`. Allocates.
    ///
    /// The velocity is an argument, because a robot has no typical velocity: joint speed limits describe the motors, and a free body has none. The
    /// criterion is the rate at which Coriolis and centrifugal forces rotate the motion, for example by nutation; so a symmetric wheel, or a single
    /// joint, may rotate at any speed.
    ///
    /// * `q` – configuration, length `nq`
    /// * `v` – velocity, length `nv`
    ///
    /// # Panics
    /// If a slice has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Integrator, Simulator, model::{LinkSpec, ModelBuilder}};
    ///
    /// let mut builder = ModelBuilder::new("body").with_gravity([0.0; 3]);
    /// builder.add_link(LinkSpec::new("body").with_mass(1.0, [0.0; 3], [0.1, 0.2, 0.25]));
    /// let simulator = Simulator::new(builder.build()?).with_time_step(0.01);
    /// let (q, tumbling) = (simulator.neutral_state::<f64>().q, [0.0, 0.0, 0.0, 2.0, 20.0, 10.0]);
    /// let said = simulator.remarks_at(q.as_slice(), &tumbling)[0].to_string();
    /// assert!(said.ends_with("or Integrator::ImplicitVelocity"), "{said}");
    /// let implicit = simulator.with_integrator(Integrator::ImplicitVelocity);
    /// assert!(implicit.remarks_at(q.as_slice(), &tumbling).is_empty());
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn remarks_at(&self, q: &[f64], v: &[f64]) -> Vec<SimulatorRemark> {
        self.model().check_v(v);
        let mut found = self.remarks(q);
        found.extend(self.remark_on_rotation(q, v));
        found
    }
}
