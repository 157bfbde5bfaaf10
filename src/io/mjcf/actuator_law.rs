//! From the attributes of an actuator to its force: gain, bias and dynamics of its activation.
//!
//! Each element of an actuator, and each default of one, changes the same record: `position` and the others are short forms of `general`. They are applied from
//! the outermost class on, the element itself last, as in `MuJoCo`.

use super::entry::Entry;
use crate::error::LoadError;

/// Force of the motor: (gain · control or activation) + bias, where both may be affine in length and velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Law {
    /// The element that stated it last.
    form: Form,
    pub(super) dynamics: Dynamics,
    pub(super) gain: [f64; 3],
    pub(super) bias: [f64; 3],
    pub(super) gain_is: Function,
    pub(super) bias_is: Function,
    /// The first parameter of the dynamics: a time constant, s.
    pub(super) time_constant: f64,
    pub(super) common: Common,
}

/// Attributes of all elements of actuators.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Common {
    /// Part of the range of the joint that is that of the target; 0 for none.
    pub(super) inherited: f64,
    /// s.
    pub(super) delay: f64,
    /// Inputs that are kept; 0 for as many as there are steps.
    pub(super) samples: f64,
    pub(super) is_interpolated: bool,
    /// Whether the force is that of the activation after the step.
    pub(super) is_early: bool,
}

/// Elements by what their short form sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    General,
    Motor,
    Position,
    IntegratedVelocity,
    Velocity,
    Damper,
    Cylinder,
    Other,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dynamics {
    None,
    Integrator,
    Filter,
    ExactFilter,
    Other,
}

/// A gain or a bias.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    /// Of a bias: 0.
    Constant,
    Affine,
    Other,
}

/// Functions by their MJCF keywords, of gains and of biases.
const GAINS: [(&str, Function); 4] = [
    ("fixed", Function::Constant),
    ("affine", Function::Affine),
    ("muscle", Function::Other),
    ("user", Function::Other),
];
const BIASES: [(&str, Function); 4] = [
    ("none", Function::Constant),
    ("affine", Function::Affine),
    ("muscle", Function::Other),
    ("user", Function::Other),
];
const DYNAMICS: [(&str, Dynamics); 6] = [
    ("none", Dynamics::None),
    ("integrator", Dynamics::Integrator),
    ("filter", Dynamics::Filter),
    ("filterexact", Dynamics::ExactFilter),
    ("muscle", Dynamics::Other),
    ("user", Dynamics::Other),
];

impl Default for Law {
    fn default() -> Self {
        Self {
            form: Form::General,
            dynamics: Dynamics::None,
            gain: [1.0, 0.0, 0.0],
            bias: [0.0; 3],
            gain_is: Function::Constant,
            bias_is: Function::Constant,
            time_constant: 1.0,
            common: Common::default(),
        }
    }
}

impl Law {
    /// The law of the elements of an actuator, the defaults first.
    pub(super) fn read<'t: 'c, 'c>(
        elements: impl Iterator<Item = Entry<'t, 'c>>,
    ) -> Result<Self, LoadError> {
        let mut law = Self::default();
        for element in elements {
            law.apply(&element)?;
        }
        Ok(law)
    }

    fn apply(&mut self, entry: &Entry<'_, '_>) -> Result<(), LoadError> {
        self.common.apply(entry)?;
        let form = match entry.node.tag() {
            "general" => return self.general(entry),
            "motor" => Form::Motor,
            "position" => Form::Position,
            "intvelocity" => Form::IntegratedVelocity,
            "velocity" => Form::Velocity,
            "damper" => Form::Damper,
            "cylinder" => Form::Cylinder,
            _ => Form::Other,
        };
        let before = match self.form {
            own if own == form || own == Form::General => *self,
            _ => Self::default(),
        };
        let common = self.common;
        *self = Self {
            form,
            common,
            ..before.short(form, entry)?
        };
        Ok(())
    }

    fn general(&mut self, entry: &Entry<'_, '_>) -> Result<(), LoadError> {
        self.form = Form::General;
        self.dynamics = entry.word("dyntype", &DYNAMICS)?.unwrap_or(self.dynamics);
        self.gain_is = entry.word("gaintype", &GAINS)?.unwrap_or(self.gain_is);
        self.bias_is = entry.word("biastype", &BIASES)?.unwrap_or(self.bias_is);
        let [time] = entry.some_numbers_of_many("dynprm", [self.time_constant])?;
        self.time_constant = time;
        self.gain = entry.some_numbers_of_many("gainprm", self.gain)?;
        self.bias = entry.some_numbers_of_many("biasprm", self.bias)?;
        Ok(())
    }

    /// The law of a short form, over one of the same form or a general one.
    fn short(self, form: Form, entry: &Entry<'_, '_>) -> Result<Self, LoadError> {
        let fixed = Self {
            dynamics: Dynamics::None,
            gain_is: Function::Constant,
            bias_is: Function::Constant,
            ..self
        };
        let kv = match form {
            Form::Velocity | Form::Damper => not_negative(entry, "kv")?.unwrap_or(self.slope()),
            _ => 0.0,
        };
        Ok(match form {
            Form::Motor => Self {
                gain: [1.0, 0.0, 0.0],
                bias: [0.0; 3],
                ..fixed
            },
            Form::Position | Form::IntegratedVelocity => {
                let dynamics = self.dynamics;
                Self { dynamics, ..fixed }.position(form, entry)?
            }
            Form::Velocity => Self {
                gain: [kv, 0.0, 0.0],
                bias: [0.0, 0.0, -kv],
                bias_is: Function::Affine,
                ..fixed
            },
            Form::Damper => Self {
                gain: [0.0, 0.0, -kv],
                gain_is: Function::Affine,
                ..fixed
            },
            Form::Cylinder => fixed.cylinder(entry)?,
            Form::Other | Form::General => Self {
                gain_is: Function::Other,
                ..fixed
            },
        })
    }

    /// The gain of a velocity servo or damper that has been stated before.
    fn slope(&self) -> f64 {
        match self.form {
            Form::Damper => -self.gain[2],
            _ => self.gain[0],
        }
    }

    /// A cylinder with its area; the bias is affine.
    fn cylinder(self, entry: &Entry<'_, '_>) -> Result<Self, LoadError> {
        let area = match (entry.number("area")?, entry.number("diameter")?) {
            (_, Some(d)) => std::f64::consts::FRAC_PI_4 * d * d,
            (area, None) => area.unwrap_or(self.gain[0]),
        };
        let time = not_negative(entry, "timeconst")?;
        Ok(Self {
            dynamics: Dynamics::Filter,
            time_constant: time.unwrap_or(self.time_constant),
            gain: [area, 0.0, 0.0],
            bias: entry.some_numbers_of_many("bias", self.bias)?,
            bias_is: Function::Affine,
            ..self
        })
    }

    fn position(self, form: Form, entry: &Entry<'_, '_>) -> Result<Self, LoadError> {
        let kp = not_negative(entry, "kp")?.unwrap_or(self.gain[0]);
        let kv = not_negative(entry, "kv")?;
        let ratio = not_negative(entry, "dampratio")?;
        if kv.is_some() && ratio.is_some() {
            return Err(entry.malformed(
                "dampratio",
                "is given together with kv: give one of the two",
            ));
        }
        let time = not_negative(entry, "timeconst")?;
        let by_velocity = kv.map(|kv| -kv).or(ratio).unwrap_or(self.bias[2]);
        let filtered = match (time, self.dynamics) {
            (Some(time), _) if time > 0.0 => Dynamics::ExactFilter,
            (None, Dynamics::ExactFilter) => Dynamics::ExactFilter,
            _ => Dynamics::None,
        };
        Ok(Self {
            time_constant: time.unwrap_or(self.time_constant),
            gain: [kp, 0.0, 0.0],
            bias: [self.bias[0], -kp, by_velocity],
            bias_is: Function::Affine,
            dynamics: match form {
                Form::IntegratedVelocity => Dynamics::Integrator,
                _ => filtered,
            },
            ..self
        })
    }
}

impl Common {
    fn apply(&mut self, entry: &Entry<'_, '_>) -> Result<(), LoadError> {
        self.inherited = entry.number("inheritrange")?.unwrap_or(self.inherited);
        self.delay = not_negative(entry, "delay")?.unwrap_or(self.delay);
        self.samples = not_negative(entry, "nsample")?.unwrap_or(self.samples);
        let words = [("zoh", false), ("linear", true), ("cubic", true)];
        self.is_interpolated = entry
            .word("interp", &words)?
            .unwrap_or(self.is_interpolated);
        let words = [("true", true), ("false", false)];
        self.is_early = entry.word("actearly", &words)?.unwrap_or(self.is_early);
        Ok(())
    }
}

fn not_negative(entry: &Entry<'_, '_>, name: &'static str) -> Result<Option<f64>, LoadError> {
    match entry.number(name)? {
        Some(x) if x < 0.0 => Err(entry.malformed(name, "is negative")),
        x => Ok(x),
    }
}
