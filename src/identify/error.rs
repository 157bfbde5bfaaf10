//! Error for data or options with which identification is impossible.

use crate::error::UnknownName;
use crate::numbers::Domain;
use crate::sim::AssemblyError;

/// Error for an impossible identification, with its cause.
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// A name does not exist in the model.
    #[error("{0}")]
    UnknownName(#[from] UnknownName),
    /// Sample times or a rate that are not valid.
    #[error("experiment \"{experiment}\": {reason}")]
    Clock {
        /// Name of the experiment.
        experiment: String,
        /// Name of the wrong value, and the reason.
        reason: String,
    },
    /// A channel that cannot be used.
    #[error("experiment \"{experiment}\": {channel}: {reason}")]
    Channel {
        /// Name of the experiment.
        experiment: String,
        /// Quantity and joint of the channel.
        channel: String,
        /// The reason.
        reason: String,
    },
    /// A channel that is not there.
    #[error(
        "experiment \"{experiment}\" has no {channel}; it is needed for every joint that has coordinates of its own"
    )]
    MissingChannel {
        /// Name of the experiment.
        experiment: String,
        /// Quantity and joint of the channel.
        channel: String,
    },
    /// A parameter of a filter is out of its range.
    #[error("filter: {reason}")]
    Filter {
        /// The number, and its range.
        reason: String,
    },
    /// No stretch of the data without gaps is long enough.
    #[error(
        "experiment \"{experiment}\": of its {samples} samples at most {longest} follow each other without a gap, and the filters need {needed}"
    )]
    TooShort {
        /// Name of the experiment.
        experiment: String,
        /// Number of samples.
        samples: usize,
        /// Samples in the longest stretch without a gap.
        longest: usize,
        /// Samples that are needed.
        needed: usize,
    },
    /// No data, or fewer equations than unknowns.
    #[error("{rows} equations for {unknowns} unknowns: more data are needed")]
    TooFewData {
        /// Number of equations.
        rows: usize,
        /// Number of unknowns.
        unknowns: usize,
    },
    /// The motion contains no information on some unknowns that another motion would determine.
    #[error("the motion does not excite {}", unknowns.join("; "))]
    NotExcited {
        /// The base parameters that it leaves open.
        unknowns: Vec<String>,
    },
    /// A kinematic constraint that is not closed at the logged configurations.
    #[error("experiment \"{experiment}\", {time} s: {source}")]
    Open {
        /// Name of the experiment.
        experiment: String,
        /// Time of the sample, s.
        time: f64,
        /// The loop.
        source: AssemblyError,
    },
    /// An option is out of its range.
    #[error("{option}: {reason}")]
    Option {
        /// Name of the option.
        option: String,
        /// Its value, and its range.
        reason: String,
    },
    /// Data or a start belong to another robot.
    #[error("{what} of {found} numbers, and \"{model}\" has {expected}")]
    OtherRobot {
        /// Name of the model.
        model: String,
        /// Kind of the vector.
        what: String,
        /// Its length.
        found: usize,
        /// Length that it should have.
        expected: usize,
    },
}

impl IdentifyError {
    pub(super) fn option(option: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Option {
            option: option.into(),
            reason: reason.into(),
        }
    }
}

/// Refuses options that are not positive and finite.
pub(super) fn check_positive(
    options: impl IntoIterator<Item = (&'static str, f64)>,
) -> Result<(), IdentifyError> {
    match options
        .into_iter()
        .find(|(_, value)| !Domain::Positive.contains(*value))
    {
        None => Ok(()),
        Some((option, value)) => {
            let reason = format!("{value} is not positive and finite");
            Err(IdentifyError::option(option, reason))
        }
    }
}

crate::error::debug_by_message! { IdentifyError }
