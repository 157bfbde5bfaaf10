//! Data for identification: segments of motion without gaps.

use nalgebra::DMatrix;

use super::error::IdentifyError;
use crate::model::Model;

/// A segment of motion without gaps, in the coordinates of a robot; each column is a sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Name of its experiment.
    pub experiment: String,
    /// Time of its first sample, s.
    pub start: f64,
    /// Samples per second.
    pub rate: f64,
    /// Configurations, `nq` × samples.
    pub q: DMatrix<f64>,
    /// Velocities, `nv` × samples (rad/s or m/s).
    pub v: DMatrix<f64>,
    /// Accelerations, `nv` × samples (rad/s² or m/s²).
    pub a: DMatrix<f64>,
    /// Joint forces, `nv` × samples (N·m or N).
    pub tau: DMatrix<f64>,
}

impl Segment {
    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.q.ncols()
    }

    /// Time of a sample, s.
    pub(crate) fn time(&self, sample: usize) -> f64 {
        self.start + sample as f64 / self.rate
    }

    /// The part from one sample to before another.
    fn part(&self, samples: std::ops::Range<usize>) -> Self {
        let of = |m: &DMatrix<f64>| m.columns(samples.start, samples.len()).into_owned();
        Self {
            experiment: self.experiment.clone(),
            start: self.time(samples.start),
            rate: self.rate,
            q: of(&self.q),
            v: of(&self.v),
            a: of(&self.a),
            tau: of(&self.tau),
        }
    }

    /// One sample in so many.
    pub(super) fn thinned(&self, every: usize) -> Self {
        let of = |m: &DMatrix<f64>| {
            let kept = m.ncols().div_ceil(every);
            DMatrix::from_fn(m.nrows(), kept, |i, k| m[(i, k * every)])
        };
        Self {
            experiment: self.experiment.clone(),
            start: self.start,
            rate: self.rate / every as f64,
            q: of(&self.q),
            v: of(&self.v),
            a: of(&self.a),
            tau: of(&self.tau),
        }
    }
}

/// A segment that was too short for the filters.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Name of the experiment.
    pub experiment: String,
    /// Time of its first sample, s.
    pub start: f64,
    /// Number of its samples.
    pub samples: usize,
}

/// Prepared data of experiments, made by [`Preparation::prepare`](super::Preparation::prepare) or from given [segments](Segment).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dataset {
    /// Segments without gaps.
    pub segments: Vec<Segment>,
    /// Segments that were too short.
    pub left_out: Vec<LeftOut>,
}

impl Dataset {
    /// Makes a dataset of these segments.
    pub fn new(segments: Vec<Segment>) -> Self {
        Self {
            segments,
            left_out: Vec::new(),
        }
    }

    /// Splits each segment in two: a training part, and a last part, the given share, for [validation](super::Robot::validate).
    ///
    /// Another motion is better for validation than a part of the same motion.
    ///
    /// # Panics
    /// If the share is not between 0 and 1.
    pub fn hold_back(&self, share: f64) -> (Self, Self) {
        assert!(
            share > 0.0 && share < 1.0,
            "the share {share} that is held back is not between 0 and 1"
        );
        let split = |segment: &Segment| {
            let n = segment.len();
            let first = n - (share * n as f64).round() as usize;
            (segment.part(0..first), segment.part(first..n))
        };
        let (kept, held): (Vec<_>, Vec<_>) = self.segments.iter().map(split).unzip();
        let not_empty =
            |segments: Vec<Segment>| segments.into_iter().filter(|segment| segment.len() > 0);
        (
            Self::new(not_empty(kept).collect()),
            Self::new(not_empty(held).collect()),
        )
    }

    /// # Errors
    /// If a segment has the size of another robot's, a number that is not finite, or no rate.
    pub(super) fn check(&self, model: &Model) -> Result<(), IdentifyError> {
        for segment in &self.segments {
            let sizes = [
                ("configurations", segment.q.nrows(), model.nq()),
                ("velocities", segment.v.nrows(), model.nv()),
                ("accelerations", segment.a.nrows(), model.nv()),
                ("forces", segment.tau.nrows(), model.nv()),
            ];
            for (what, found, expected) in sizes {
                if found != expected {
                    return Err(IdentifyError::OtherRobot {
                        model: model.name().into(),
                        what: format!("\"{}\": {what}", segment.experiment),
                        found,
                        expected,
                    });
                }
            }
            segment.check_numbers()?;
        }
        Ok(())
    }
}

impl Segment {
    fn check_numbers(&self) -> Result<(), IdentifyError> {
        let n = self.len();
        let rows = [
            ("configuration", &self.q),
            ("velocity", &self.v),
            ("acceleration", &self.a),
            ("force", &self.tau),
        ];
        let channel = |channel: &str, reason: String| IdentifyError::Channel {
            experiment: self.experiment.clone(),
            channel: channel.into(),
            reason,
        };
        if !(self.rate > 0.0 && self.rate.is_finite() && self.start.is_finite()) {
            return Err(IdentifyError::Clock {
                experiment: self.experiment.clone(),
                reason: format!("{} samples a second from {} s on", self.rate, self.start),
            });
        }
        for (name, m) in rows {
            if m.ncols() != n {
                let reason = format!("{} samples, and {n} configurations", m.ncols());
                return Err(channel(name, reason));
            }
            if let Some(at) = m.iter().position(|x| !x.is_finite()) {
                let (row, k) = (at % m.nrows(), at / m.nrows());
                let reason = format!("number {row} of sample {k} is {}", m[(row, k)]);
                return Err(channel(name, reason));
            }
        }
        Ok(())
    }
}
