//! Experiments: logged channels.

use std::ops::Range;

use super::error::IdentifyError;
use super::unit::{Dimension, Quantity, Unit};
use crate::joint::{Coordinate, Joint};
use crate::model::manifold::{q_range, v_range};
use crate::model::{BodyId, Model};
use crate::nested::IntoNested;
use crate::sim::Rollout;

/// A logged motion: channels with names and units on a common clock.
///
/// A missing sample of a channel is NaN; whole intervals may be missing from the [times](Self::at_times). Both are gaps; filters and derivatives do
/// not cross gaps.
///
/// # Examples
/// ```
/// use dualbody::identify::{Experiment, Quantity, Unit};
///
/// let degrees: Vec<f64> = (0..200).map(|k| 30.0 * (0.05 * f64::from(k)).sin()).collect();
/// let amperes = vec![0.2; 200];
/// let sweep = Experiment::at_rate("sweep", 100.0)
///     .with_channel("pivot", Quantity::Position, Unit::Degree, &degrees)
///     .with_channel("pivot", Quantity::Force, Unit::Scale(0.05 * 100.0), &amperes);
/// assert_eq!(sweep.name(), "sweep");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    pub(super) name: String,
    pub(super) clock: Clock,
    pub(super) channels: Vec<Channel>,
    /// Joints on which nothing acts.
    pub(super) passive: Vec<String>,
}

/// When samples were taken.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Clock {
    /// Samples per second.
    Rate(f64),
    /// Time of each, s.
    Times(Vec<f64>),
}

/// Numbers of one quantity of one joint.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Channel {
    pub(super) joint: String,
    pub(super) quantity: Quantity,
    pub(super) unit: Unit,
    /// Sample after sample.
    pub(super) values: Vec<f64>,
}

impl Channel {
    pub(super) fn name(&self) -> String {
        channel_name(self.quantity, &self.joint)
    }

    /// Error for a channel that cannot be used.
    pub(super) fn error(&self, experiment: &Experiment, reason: String) -> IdentifyError {
        IdentifyError::Channel {
            experiment: experiment.name.clone(),
            channel: self.name(),
            reason,
        }
    }
}

pub(super) fn channel_name(quantity: Quantity, joint: &str) -> String {
    format!("{} of \"{joint}\"", quantity.name())
}

impl Experiment {
    /// Makes an experiment with a sample rate (samples per second), without channels.
    pub fn at_rate(name: impl Into<String>, rate: f64) -> Self {
        Self::new(name.into(), Clock::Rate(rate))
    }

    /// Makes an experiment with sample times, s, evenly spaced within the accuracy of a clock; an interval of more than one and a half sample times is a gap.
    pub fn at_times(name: impl Into<String>, times: &[f64]) -> Self {
        Self::new(name.into(), Clock::Times(times.to_vec()))
    }

    fn new(name: String, clock: Clock) -> Self {
        Self {
            name,
            clock,
            channels: Vec::new(),
            passive: Vec::new(),
        }
    }

    /// Adds the samples of one quantity of one joint. A joint with several coordinates, for example a spherical joint, has them in sequence in each
    /// sample; the joint of a floating base is called `floating base`.
    ///
    /// [`Preparation::prepare`](super::Preparation::prepare) checks names, units and lengths against the robot.
    #[must_use]
    pub fn with_channel(
        mut self,
        joint: impl Into<String>,
        quantity: Quantity,
        unit: Unit,
        values: &[f64],
    ) -> Self {
        self.channels.push(Channel {
            joint: joint.into(),
            quantity,
            unit,
            values: values.to_vec(),
        });
        self
    }

    /// Declares a joint as passive: only springs, dampers and friction of the model act on it. Its force is zero and needs no channel.
    #[must_use]
    pub fn with_passive_joint(mut self, joint: impl Into<String>) -> Self {
        self.passive.push(joint.into());
        self
    }

    /// Makes an experiment of a rollout: positions, velocities and joint inputs, which are constant from each sample to the next.
    ///
    /// Inputs on frames, contact and external forces are not included, since joint forces do not contain them. The last state, which has no input, is omitted.
    ///
    /// * `actuated` – the velocity coordinate of each input, [`Simulator::actuated`](crate::Simulator::actuated)
    ///
    /// # Panics
    /// If the rollout is of a robot with other coordinates.
    pub fn from_rollout(
        name: impl Into<String>,
        model: &Model,
        rollout: &Rollout,
        actuated: &[usize],
    ) -> Self {
        let mut out = Self::at_rate(name, rollout.time_step.recip());
        let n = rollout.inputs.len();
        for (id, body) in model.independent_with_ids() {
            let (joint, q, v) = (model.joint_name(id), q_range(body), v_range(body));
            let states = &rollout.states[..n];
            let positions: Vec<f64> = (states.iter())
                .nested(|state| state.q.as_slice()[q.clone()].iter().copied())
                .collect();
            let velocities: Vec<f64> = (states.iter())
                .nested(|state| state.v.as_slice()[v.clone()].iter().copied())
                .collect();
            let force = |k: usize, u: &nalgebra::DVector<f64>| {
                let inputs = actuated.iter().zip(u.iter());
                inputs.filter(|&(&at, _)| at == k).map(|(_, u)| u).sum()
            };
            let forces: Vec<f64> = (rollout.inputs.iter())
                .nested(|u| v.clone().map(move |k| force(k, u)))
                .collect();
            out = out
                .with_channel(&joint, Quantity::Position, Unit::Si, &positions)
                .with_channel(&joint, Quantity::Velocity, Unit::Si, &velocities)
                .with_channel(&joint, Quantity::Force, Unit::Si, &forces);
        }
        out
    }

    /// Name of the experiment.
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// Indices of the coordinates of a body's joint in q, or in v.
pub(super) fn range_of(model: &Model, body: BodyId, quantity: Quantity) -> Range<usize> {
    match quantity {
        Quantity::Position => q_range(model.body(body)),
        _ => v_range(model.body(body)),
    }
}

/// Dimension of a quantity of a body's joint.
pub(super) fn dimension(model: &Model, body: BodyId, quantity: Quantity) -> Dimension {
    let joint = model.body(body).joint;
    let coordinates: Vec<Coordinate> = match quantity {
        Quantity::Position => (0..joint.nq()).map(|k| joint.measures(k)).collect(),
        _ => joint.axes().map(|axis| axis.displacement()).collect(),
    };
    let all = |kind| coordinates.iter().all(|&own| own == kind);
    if all(Coordinate::Length) {
        Dimension::Length
    } else if all(Coordinate::Angle) {
        Dimension::Angle
    } else {
        Dimension::Mixed
    }
}
