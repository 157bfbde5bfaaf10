//! From channels to segments: gaps, filters, derivatives.

#[cfg(test)]
mod tests;

use std::ops::Range;

use nalgebra::DMatrix;

use super::butterworth::Butterworth;
use super::dataset::{Dataset, LeftOut, Segment};
use super::error::IdentifyError;
use super::experiment::Experiment;
use super::savitzky_golay::SavitzkyGolay;
use super::table::Table;
use super::unit::Quantity;
use crate::model::Model;
use crate::model::manifold::{q_range, v_range};

/// Low-pass filter of all channels, applied before all other steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass {
    /// Order of each of the two runs.
    pub order: usize,
    /// Frequency at which both runs together leave half of an amplitude, Hz.
    pub cutoff: f64,
}

/// Options of the preparation of experiments to [data](Dataset).
///
/// Positions are smoothed by the local polynomial. Measured velocities are smoothed; other velocities are derivatives of positions. Accelerations
/// likewise, from velocities if these are measured. Forces are not smoothed, so their errors stay independent and
/// [intervals](super::Estimate::intervals) are correct. A [low-pass](Self::with_low_pass) makes neighbouring samples dependent: then
/// [keep fewer samples](Self::with_decimation) in proportion. No channel is delayed. Samples at both ends of each gap-free segment that lack
/// neighbours for the polynomial are dropped.
///
/// # Examples
/// ```
/// use dualbody::identify::{Experiment, Preparation, Quantity, SavitzkyGolay, Unit};
/// use dualbody::model::samples;
///
/// // A pendulum swings as sin(2 t), with 20 missing samples in the middle.
/// let mut angles: Vec<f64> = (0..500).map(|k| (0.02 * f64::from(k)).sin()).collect();
/// angles[240..260].fill(f64::NAN);
/// let swing = Experiment::at_rate("swing", 100.0)
///     .with_channel("pivot", Quantity::Position, Unit::Si, &angles)
///     .with_passive_joint("pivot");
/// let data = Preparation::new(SavitzkyGolay::new(8, 4)?).prepare(&samples::pendulum(), &[swing])?;
/// assert_eq!(data.segments.len(), 2);
/// let first = &data.segments[0]; // begins 8 samples later
/// assert!((first.a[(0, 0)] + 4.0 * (0.02 * 8.0_f64).sin()).abs() < 1e-6);
/// # Ok::<(), dualbody::identify::IdentifyError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Preparation {
    polynomial: SavitzkyGolay,
    low_pass: Option<LowPass>,
    decimation: usize,
}

impl Preparation {
    /// Smoothing and derivatives by a local polynomial; no low-pass, every sample is kept.
    pub fn new(polynomial: SavitzkyGolay) -> Self {
        Self {
            polynomial,
            low_pass: None,
            decimation: 1,
        }
    }

    /// Filters all channels, forces included, by a Butterworth filter first, forwards and backwards. Not for positions of spherical, planar and floating
    /// joints, whose values are not in a vector space.
    #[must_use]
    pub fn with_low_pass(mut self, low_pass: LowPass) -> Self {
        self.low_pass = Some(low_pass);
        self
    }

    /// Keeps one sample in `every` (0 counts as 1), after all filters.
    #[must_use]
    pub fn with_decimation(mut self, every: usize) -> Self {
        self.decimation = every.max(1);
        self
    }

    /// Prepares experiments for a robot.
    ///
    /// Quaternions are normalised, and angles of continuous joints unwrapped.
    ///
    /// # Errors
    /// If a joint with coordinates has no position, or no force and is not [passive](Experiment::with_passive_joint); if a name, a unit, a length, a
    /// time or a number is invalid; if a filter does not suit the rate; if no stretch is long enough. The error says which.
    pub fn prepare(
        &self,
        model: &Model,
        experiments: &[Experiment],
    ) -> Result<Dataset, IdentifyError> {
        let mut out = Dataset::default();
        for experiment in experiments {
            self.add(model, experiment, &mut out)?;
        }
        Ok(out)
    }

    fn add(
        &self,
        model: &Model,
        experiment: &Experiment,
        out: &mut Dataset,
    ) -> Result<(), IdentifyError> {
        let table = Table::read(model, experiment)?;
        let filter = self.filter(model, &table, experiment)?;
        let needed = 2 * self.polynomial.half_width() + 1;
        let (mut longest, before) = (0, out.segments.len());
        for stretch in table.stretches() {
            longest = longest.max(stretch.len());
            if stretch.len() < needed {
                out.left_out.push(LeftOut {
                    experiment: experiment.name.clone(),
                    start: table.time(stretch.start),
                    samples: stretch.len(),
                });
                continue;
            }
            let mut part = table.part(stretch.clone());
            if let Some(filter) = &filter {
                part.each_row(|row| filter.filter(row));
            }
            let segment = self.segment(model, experiment, &part, table.time(stretch.start));
            out.segments.push(segment.thinned(self.decimation));
        }
        if out.segments.len() > before {
            return Ok(());
        }
        Err(IdentifyError::TooShort {
            experiment: experiment.name.clone(),
            samples: table.len(),
            longest,
            needed,
        })
    }

    /// The low-pass at the rate of an experiment.
    fn filter(
        &self,
        model: &Model,
        table: &Table,
        experiment: &Experiment,
    ) -> Result<Option<Butterworth>, IdentifyError> {
        let Some(LowPass { order, cutoff }) = self.low_pass else {
            return Ok(None);
        };
        let mut joints = model.independent_with_ids();
        if let Some((id, _)) = joints.find(|(_, body)| body.joint.nq() > 1) {
            return Err(IdentifyError::Channel {
                experiment: experiment.name.clone(),
                channel: format!("position of \"{}\"", model.joint_name(id)),
                reason: "a low-pass filter works on single coordinates only; leave it out, and smooth by a wider polynomial".into(),
            });
        }
        Butterworth::new(order, cutoff, table.rate).map(Some)
    }

    /// Smooths and differentiates a stretch.
    fn segment(
        &self,
        model: &Model,
        experiment: &Experiment,
        table: &Table,
        start: f64,
    ) -> Segment {
        let (m, rate) = (self.polynomial.half_width(), table.rate);
        let inner = m..table.len() - m;
        let zeros = |rows: usize| DMatrix::zeros(rows, inner.len());
        let mut out = Segment {
            experiment: experiment.name.clone(),
            start: start + m as f64 / rate,
            rate,
            q: zeros(model.nq()),
            v: zeros(model.nv()),
            a: zeros(model.nv()),
            tau: table.tau.columns(m, inner.len()).into_owned(),
        };
        for (id, body) in model.independent_with_ids() {
            let (q, v) = (q_range(body), v_range(body));
            let has = |quantity| table.has(id, quantity);
            match body.joint.nq() {
                1 => self.along_line(table, q.start, v.start, &mut out, &has),
                _ => self.along_curve(model, table, id.0, &mut out, &has),
            }
            if has(Quantity::Velocity) {
                self.rows(0, rate, &table.v, v.clone(), &mut out.v);
            }
            if has(Quantity::Acceleration) {
                self.rows(0, rate, &table.a, v, &mut out.a);
            } else if has(Quantity::Velocity) {
                self.rows(1, rate, &table.v, v, &mut out.a);
            }
        }
        out
    }

    /// Position, and its derivatives where nothing better is measured, of a coordinate.
    fn along_line(
        &self,
        table: &Table,
        q: usize,
        v: usize,
        out: &mut Segment,
        has: &dyn Fn(Quantity) -> bool,
    ) {
        let mut filtered = Vec::new();
        let row: Vec<f64> = table.q.row(q).iter().copied().collect();
        let mut filter = |derivative: usize, to: &mut DMatrix<f64>, k: usize| {
            self.polynomial
                .apply(derivative, table.rate, &row, &mut filtered);
            set_row(to, k, &filtered);
        };
        filter(0, &mut out.q, q);
        if !has(Quantity::Velocity) {
            filter(1, &mut out.v, v);
            if !has(Quantity::Acceleration) {
                filter(2, &mut out.a, v);
            }
        }
    }

    /// Position and its derivatives of a curved joint, along the tangent at each sample.
    fn along_curve(
        &self,
        model: &Model,
        table: &Table,
        body: usize,
        out: &mut Segment,
        has: &dyn Fn(Quantity) -> bool,
    ) {
        let body = &model.bodies()[body];
        let (q, v) = (q_range(body), v_range(body));
        let m = self.polynomial.half_width();
        let at = |k: usize| &table.q.as_slice()[k * model.nq()..][q.clone()];
        let mut moved = vec![0.0; v.len()];
        for k in 0..out.q.ncols() {
            let mut sums = [vec![0.0; v.len()], vec![0.0; v.len()], vec![0.0; v.len()]];
            for i in 0..=2 * m {
                body.joint.difference(at(k + m), at(k + i), &mut moved);
                for (derivative, sum) in sums.iter_mut().enumerate() {
                    let weight = self.polynomial.weights(derivative)[i];
                    sum.iter_mut()
                        .zip(&moved)
                        .for_each(|(sum, x)| *sum += weight * x);
                }
            }
            let [shift, slope, curvature] = sums;
            let column = &mut out.q.as_mut_slice()[k * model.nq()..][q.clone()];
            body.joint.integrate(at(k + m), &shift, column);
            for (j, coordinate) in v.clone().enumerate() {
                if !has(Quantity::Velocity) {
                    out.v[(coordinate, k)] = slope[j] * table.rate;
                }
                if !has(Quantity::Velocity) && !has(Quantity::Acceleration) {
                    out.a[(coordinate, k)] = curvature[j] * table.rate.powi(2);
                }
            }
        }
    }

    /// Filters rows of measured numbers.
    fn rows(
        &self,
        derivative: usize,
        rate: f64,
        from: &DMatrix<f64>,
        rows: Range<usize>,
        to: &mut DMatrix<f64>,
    ) {
        let mut filtered = Vec::new();
        for k in rows {
            let row: Vec<f64> = from.row(k).iter().copied().collect();
            self.polynomial.apply(derivative, rate, &row, &mut filtered);
            set_row(to, k, &filtered);
        }
    }
}

fn set_row(to: &mut DMatrix<f64>, row: usize, numbers: &[f64]) {
    to.row_mut(row)
        .iter_mut()
        .zip(numbers)
        .for_each(|(to, x)| *to = *x);
}
