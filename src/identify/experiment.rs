//! Experiments: what was logged, channel by channel.

use std::ops::Range;

use super::error::IdentifyError;
use super::unit::{Dimension, Quantity, Unit};
use crate::joint::{Coordinate, Joint};
use crate::model::manifold::{q_range, v_range};
use crate::model::{BodyId, Model};
use crate::sim::Rollout;

/// A logged motion: channels of numbers with names and units, over one clock.
///
/// A sample of a channel that is missing is NaN; whole stretches may be missing from the [times](Self::at_times). Both are gaps, over which nothing
/// is filtered or differentiated.
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
    /// Samples a second.
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
    /// An experiment of so many samples a second, without channels so far.
    pub fn at_rate(name: impl Into<String>, rate: f64) -> Self {
        Self::new(name.into(), Clock::Rate(rate))
    }

    /// An experiment whose samples were taken at these times, s, as even as a clock makes them; what is further apart than one and a half of the
    /// usual time is a gap.
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

    /// Adds the samples of one quantity of one joint. A joint with several numbers, as a spherical one, has them one after another in each sample; the
    /// joint of a floating base is called `floating base`.
    ///
    /// Names, units and lengths are checked when the data are [prepared](super::Preparation::prepare), where the robot is known.
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

    /// Says that nothing but the model's own springs, dampers and friction acts on a joint: its force is zero, and needs no channel.
    #[must_use]
    pub fn with_passive_joint(mut self, joint: impl Into<String>) -> Self {
        self.passive.push(joint.into());
        self
    }

    /// Makes an experiment of a rollout: positions, velocities and the inputs that acted at the joints, which are held from each sample to the next.
    ///
    /// Without inputs on frames, contact and external forces, which the joint forces do not contain. The last state, after which there is no input, is
    /// left out.
    ///
    /// * `actuated` – the velocity coordinate of each input, [`Simulator::actuated`](crate::Simulator::actuated)
    ///
    /// # Panics
    /// If the rollout is that of a robot with other coordinates.
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
                .flat_map(|state| state.q.as_slice()[q.clone()].iter().copied())
                .collect();
            let velocities: Vec<f64> = (states.iter())
                .flat_map(|state| state.v.as_slice()[v.clone()].iter().copied())
                .collect();
            let force = |k: usize, u: &nalgebra::DVector<f64>| {
                let inputs = actuated.iter().zip(u.iter());
                inputs.filter(|&(&at, _)| at == k).map(|(_, u)| u).sum()
            };
            let forces: Vec<f64> = (rollout.inputs.iter())
                .flat_map(|u| v.clone().map(move |k| force(k, u)))
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

/// Places of the numbers of a quantity of a body's joint in q, or in v.
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
