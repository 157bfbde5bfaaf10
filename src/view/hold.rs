//! Servos that hold joints where they are asked to be: for simulations that a person starts without a controller.

use crate::model::BodyId;
use crate::sim::{Actuation, Actuator, Servo, Simulator, State};

/// Stiffness of a servo relative to the weight of the robot, rad⁻¹ for an arm of one metre, m⁻¹ for a slider: the whole robot at the end
/// of such an arm bends the joint by a fifth of a radian.
const STIFFNESS: f64 = 5.0;

/// Damping of a servo over its stiffness, s: the time in which a light joint comes to its target.
const TIME_CONSTANT: f64 = 0.05;

/// Weight of a mass, m/s², whatever gravity the model has.
const WEIGHT: f64 = 9.81;

impl Simulator<f64> {
    /// The simulator with a servo at each joint with an input of force: its input becomes a target, rad or m, or zero for a joint of
    /// several degrees of freedom, which a damper holds. Effort limits stay.
    pub(crate) fn with_holding_servos(self) -> Self {
        let kp = STIFFNESS * WEIGHT * self.model().total_mass();
        let actuation = match self.actuation() {
            Some(actuation) => actuation.clone(),
            None => Actuation::ideal(self.model()),
        };
        let mut actuators = actuation.actuators().to_vec();
        for &k in self.actuated() {
            let own: &mut Actuator = &mut actuators[k];
            own.servo = own.servo.or(Some(match self.coordinate(k) {
                Some(_) => Servo::position(kp, TIME_CONSTANT * kp),
                None => Servo::velocity(TIME_CONSTANT * kp),
            }));
        }
        self.with_actuation(actuation.with_actuators(&actuators))
    }

    /// The inputs at which holding servos keep the joints as a state has them.
    pub(crate) fn holding_targets(&self, state: &State) -> Vec<f64> {
        let target = |&k: &usize| self.coordinate(k).map_or(0.0, |q| state.q[q]);
        let mut u: Vec<f64> = self.actuated().iter().map(target).collect();
        u.resize(self.nu(), 0.0);
        u
    }

    /// The entry of q of a velocity coordinate, if its joint has one degree of freedom.
    pub(crate) fn coordinate(&self, v: usize) -> Option<usize> {
        let bodies = self.model().bodies().iter().enumerate();
        let mut own = bodies.filter(|(_, body)| body.coupling.is_none() && body.joint.nq() == 1);
        let (body, _) = own.find(|(_, body)| body.v == v)?;
        Some(self.model().body(BodyId(body)).q)
    }
}
