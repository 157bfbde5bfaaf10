//! What the law of an actuator becomes: a servo, and an activation before it.

use super::actuator_law::{Common, Dynamics, Function, Law};
use crate::sim::{Activation, Servo};

/// The most steps of a delay that is read.
const MOST_STEPS: usize = 10_000;

/// By how much more than a whole number of steps a delay may be, as part of a step: rounding of decimal numbers.
const ROUNDING: f64 = 1e-9;

/// The least time constant, s, as in `MuJoCo`.
const LEAST_TIME: f64 = 1e-15;

impl Law {
    /// Why there is no such servo; `None` if there is one.
    ///
    /// * `time_step` – s
    pub(super) fn lack(&self, time_step: f64) -> Option<&'static str> {
        match self {
            own if own.gain_is == Function::Other || own.bias_is == Function::Other => {
                Some("is of a kind that is not modelled")
            }
            own if own.gain_is == Function::Affine && own.gain[1..] != [0.0; 2] => {
                Some("has a gain that depends on the motion, which is not modelled")
            }
            own if own.dynamics == Dynamics::Other => {
                Some("has dynamics of a kind that is not modelled")
            }
            own if own.common.is_interpolated => {
                Some("has a delay that is interpolated, which is not modelled")
            }
            own if own.common.steps(time_step) > MOST_STEPS => {
                Some("has a delay of more than 10 000 time steps")
            }
            _ => None,
        }
    }

    /// A time constant of a filter that is negative, which counts as none.
    pub(super) fn negative_time(&self) -> Option<f64> {
        let filters = matches!(self.dynamics, Dynamics::Filter | Dynamics::ExactFilter);
        Some(self.time_constant).filter(|&time| filters && time < 0.0)
    }

    /// Whether its activation is the integral of the control.
    pub(super) fn integrates(&self) -> bool {
        self.dynamics == Dynamics::Integrator
    }

    /// Delay and dynamics of the control, without ranges, if it has any.
    ///
    /// * `time_step` – s
    pub(super) fn activation(&self, time_step: f64) -> Option<Activation> {
        let steps = self.common.steps(time_step);
        let time = self.time_constant.max(LEAST_TIME);
        let own = match self.dynamics {
            Dynamics::None | Dynamics::Other => {
                return (steps > 0).then(|| Activation::delay(steps));
            }
            Dynamics::Integrator => Activation::integrator(),
            Dynamics::Filter => Activation::explicit_filter(time),
            Dynamics::ExactFilter => Activation::filter(time),
        };
        let own = own.with_delay(steps);
        Some(if self.common.is_early {
            own.early()
        } else {
            own
        })
    }

    /// Whether the activation has a state beside delayed inputs.
    pub(super) fn has_dynamics(&self) -> bool {
        !matches!(self.dynamics, Dynamics::None)
    }

    /// The servo behind a gear, without ranges, and its damping ratio, where that is to be made a gain.
    pub(super) fn servo(&self, gear: f64) -> (Servo, Option<f64>) {
        let bias = match self.bias_is {
            Function::Affine => self.bias,
            _ => [0.0; 3],
        };
        let holds_position = self.gain[0] == -bias[1] && bias[2] > 0.0;
        let mut servo = Servo::torque(gear);
        servo.gain = self.gain[0];
        servo.bias = bias[0];
        servo.position_gain = 0.0 - bias[1];
        servo.velocity_gain = if holds_position { 0.0 } else { 0.0 - bias[2] };
        (servo, holds_position.then_some(bias[2]))
    }
}

impl Common {
    /// Whole steps of the delay, up to those whose inputs are kept.
    fn steps(&self, time_step: f64) -> usize {
        let steps = (self.delay / time_step - ROUNDING).ceil();
        let kept = if self.samples > 0.0 {
            self.samples
        } else {
            steps
        };
        // Saturating
        steps.min(kept).max(0.0) as usize
    }
}
