//! Comparison of predicted and measured forces.

use nalgebra::DMatrix;

use super::dataset::{Dataset, Segment};
use super::error::IdentifyError;
use super::robot::Robot;

/// Errors of the forces that an identified robot predicts.
#[derive(Clone, Debug, PartialEq)]
pub struct Validation {
    /// Along each velocity coordinate.
    pub coordinates: Vec<ForceError>,
    /// Predicted forces of each segment, `nv` × samples.
    pub predicted: Vec<DMatrix<f64>>,
}

/// Errors of the predicted force along a velocity coordinate: measured minus predicted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForceError {
    /// Root mean square, N·m or N.
    pub rms: f64,
    /// Mean, N·m or N.
    pub mean: f64,
    /// Largest absolute value, N·m or N.
    pub largest: f64,
    /// Root mean square of the measured force, N·m or N.
    pub measured: f64,
}

impl Robot {
    /// Compares predicted with measured forces of data. Use other data than for the identification.
    ///
    /// # Errors
    /// If the data are those of another robot.
    pub fn validate(&self, data: &Dataset) -> Result<Validation, IdentifyError> {
        Validation::new(self, data)
    }
}

impl Validation {
    fn new(robot: &Robot, data: &Dataset) -> Result<Self, IdentifyError> {
        data.check(&robot.model)?;
        let predicted: Vec<_> = data
            .segments
            .iter()
            .map(|s| robot.predict_segment(s))
            .collect();
        let coordinate = |k| ForceError::of(k, &data.segments, &predicted);
        Ok(Self {
            coordinates: (0..robot.model.nv()).map(coordinate).collect(),
            predicted,
        })
    }
}

impl ForceError {
    fn of(k: usize, segments: &[Segment], predicted: &[DMatrix<f64>]) -> Self {
        let (mut out, mut n) = (Self::default(), 0.0);
        for (segment, predicted) in segments.iter().zip(predicted) {
            for (measured, predicted) in segment.tau.row(k).iter().zip(predicted.row(k).iter()) {
                let error = measured - predicted;
                out.rms += error * error;
                out.mean += error;
                out.largest = out.largest.max(error.abs());
                out.measured += measured * measured;
                n += 1.0;
            }
        }
        if n > 0.0 {
            out.rms = (out.rms / n).sqrt();
            out.measured = (out.measured / n).sqrt();
            out.mean /= n;
        }
        out
    }
}
