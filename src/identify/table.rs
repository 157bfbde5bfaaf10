//! The channels of an experiment as rows of a robot's coordinates, checked.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use nalgebra::DMatrix;

use super::error::IdentifyError;
use super::experiment::{Channel, Clock, Experiment, channel_name, dimension, range_of};
use super::unit::Quantity;
use crate::error::UnknownName;
use crate::joint::JointKind;
use crate::model::{BodyId, Model};

/// Samples in SI units; what is missing is NaN, and what is not measured zero.
pub(super) struct Table {
    pub(super) rate: f64,
    times: Vec<f64>,
    pub(super) q: DMatrix<f64>,
    pub(super) v: DMatrix<f64>,
    pub(super) a: DMatrix<f64>,
    pub(super) tau: DMatrix<f64>,
    /// Measured quantities of each body, in the order of [`Quantity::ALL`].
    measured: Vec<[bool; 4]>,
}

impl Table {
    /// # Errors
    /// If something is missing or invalid.
    pub(super) fn read(model: &Model, experiment: &Experiment) -> Result<Self, IdentifyError> {
        check_names(model, experiment)?;
        let n = n_samples(model, experiment)?;
        let (rate, times) = clock(experiment, n)?;
        let zeros = |rows: usize| DMatrix::zeros(rows, n);
        let mut out = Self {
            rate,
            times,
            q: zeros(model.nq()),
            v: zeros(model.nv()),
            a: zeros(model.nv()),
            tau: zeros(model.nv()),
            measured: vec![[false; 4]; model.n_bodies()],
        };
        for (id, _) in model.independent_with_ids() {
            let name = model.joint_name(id);
            for quantity in Quantity::ALL {
                out.take(model, experiment, id, &name, quantity)?;
            }
        }
        Ok(out)
    }

    /// Takes the channel of a quantity of a joint, if there is one.
    fn take(
        &mut self,
        model: &Model,
        experiment: &Experiment,
        body: BodyId,
        name: &str,
        quantity: Quantity,
    ) -> Result<(), IdentifyError> {
        let Some(channel) = find(experiment, name, quantity)? else {
            return Ok(());
        };
        let error = |reason: String| channel.error(experiment, reason);
        let factor = (channel.unit).factor(quantity, dimension(model, body, quantity));
        let factor = factor.map_err(error)?;
        if let Some(k) = channel.values.iter().position(|x| x.is_infinite()) {
            return Err(error(format!("number {k} is {}", channel.values[k])));
        }
        let rows = range_of(model, body, quantity);
        let to = match quantity {
            Quantity::Position => &mut self.q,
            Quantity::Velocity => &mut self.v,
            Quantity::Acceleration => &mut self.a,
            Quantity::Force => &mut self.tau,
        };
        for (k, sample) in channel.values.chunks_exact(rows.len()).enumerate() {
            for (row, x) in rows.clone().zip(sample) {
                to[(row, k)] = x * factor;
            }
        }
        self.measured[body.0][quantity as usize] = true;
        if quantity == Quantity::Position {
            self.smooth(model.body(body).joint, rows.start)
                .map_err(error)?;
        }
        Ok(())
    }

    /// Makes positions of a joint continuous, from their first row on.
    fn smooth(&mut self, joint: JointKind, row: usize) -> Result<(), String> {
        if joint == JointKind::Continuous {
            unwrap_angles(&mut self.q, row);
        }
        match joint.quaternion() {
            Some(first) => normalize(&mut self.q, row + first),
            None => Ok(()),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.times.len()
    }

    pub(super) fn time(&self, sample: usize) -> f64 {
        self.times[sample]
    }

    /// Whether a quantity of a body's joint is measured.
    pub(super) fn has(&self, body: BodyId, quantity: Quantity) -> bool {
        self.measured[body.0][quantity as usize]
    }

    /// Ranges of samples without gaps.
    pub(super) fn stretches(&self) -> Vec<Range<usize>> {
        let tables = [&self.q, &self.v, &self.a, &self.tau];
        let is_whole = |k: usize| {
            tables
                .iter()
                .all(|m| m.column(k).iter().all(|x| x.is_finite()))
        };
        let (mut out, mut start) = (Vec::new(), 0);
        for k in 0..self.len() {
            let is_late = k > 0 && self.times[k] - self.times[k - 1] > GAP / self.rate;
            if is_late || !is_whole(k) {
                out.push(start..k);
                start = if is_whole(k) { k } else { k + 1 };
            }
        }
        out.push(start..self.len());
        out.retain(|stretch| !stretch.is_empty());
        out
    }

    /// The samples of a range.
    pub(super) fn part(&self, samples: Range<usize>) -> Self {
        let of = |m: &DMatrix<f64>| m.columns(samples.start, samples.len()).into_owned();
        Self {
            rate: self.rate,
            times: self.times[samples.clone()].to_vec(),
            q: of(&self.q),
            v: of(&self.v),
            a: of(&self.a),
            tau: of(&self.tau),
            measured: self.measured.clone(),
        }
    }

    /// Passes every row of numbers to a filter.
    pub(super) fn each_row(&mut self, filter: impl Fn(&mut [f64])) {
        let mut row = Vec::new();
        for m in [&mut self.q, &mut self.v, &mut self.a, &mut self.tau] {
            for mut own in m.row_iter_mut() {
                row.clear();
                row.extend(own.iter());
                filter(&mut row);
                own.iter_mut().zip(&row).for_each(|(to, x)| *to = *x);
            }
        }
    }
}

/// Time between two samples, in usual intervals, above which samples are missing between them.
const GAP: f64 = 1.5;
/// Largest error of the time between two samples, in usual ones, that counts as none.
const JITTER: f64 = 0.1;

/// # Errors
/// If a channel or a passive joint has an unknown name, or that of a mimic joint.
fn check_names(model: &Model, experiment: &Experiment) -> Result<(), IdentifyError> {
    let known: Vec<String> = (model.independent_with_ids())
        .map(|(id, _)| model.joint_name(id))
        .collect();
    let channels = experiment.channels.iter().map(|channel| &channel.joint);
    for name in channels.chain(&experiment.passive) {
        if !known.contains(name) {
            return Err(IdentifyError::UnknownName(UnknownName {
                model: model.name().into(),
                element: "joint with coordinates of its own".into(),
                name: name.clone(),
                known,
            }));
        }
    }
    Ok(())
}

/// The channel of a quantity of a joint; `None` where there is none and none is needed.
///
/// # Errors
/// If there are two, none where one is needed, or the force of a passive joint.
fn find<'a>(
    experiment: &'a Experiment,
    joint: &str,
    quantity: Quantity,
) -> Result<Option<&'a Channel>, IdentifyError> {
    let is_own = |c: &&Channel| c.joint == joint && c.quantity == quantity;
    let mut channels = experiment.channels.iter().filter(is_own);
    let is_passive = experiment.passive.iter().any(|own| own == joint);
    let is_needed = match quantity {
        Quantity::Position => true,
        Quantity::Force => !is_passive,
        Quantity::Velocity | Quantity::Acceleration => false,
    };
    match channels.next() {
        None if is_needed => Err(IdentifyError::MissingChannel {
            experiment: experiment.name.clone(),
            channel: channel_name(quantity, joint),
        }),
        Some(own) if channels.next().is_some() => {
            Err(own.error(experiment, "there are two of them".into()))
        }
        Some(own) if is_passive && quantity == Quantity::Force => {
            Err(own.error(experiment, "nothing acts on a passive joint".into()))
        }
        found => Ok(found),
    }
}

/// # Errors
/// If channels have different lengths, or are shorter than the clock.
fn n_samples(model: &Model, experiment: &Experiment) -> Result<usize, IdentifyError> {
    let mut found = match &experiment.clock {
        Clock::Times(times) => Some((times.len(), "times".to_owned())),
        Clock::Rate(_) => None,
    };
    for (id, _) in model.independent_with_ids() {
        let name = model.joint_name(id);
        for channel in experiment.channels.iter().filter(|own| own.joint == name) {
            let width = range_of(model, id, channel.quantity).len();
            let len = channel.values.len();
            let (n, of) = found.get_or_insert_with(|| (len / width, channel.name()));
            if len != *n * width {
                let reason =
                    format!("{len} numbers, {width} a sample, and {n} samples of the {of}");
                return Err(channel.error(experiment, reason));
            }
        }
    }
    Ok(found.map_or(0, |(n, _)| n))
}

/// Rate, and the time of each sample.
///
/// # Errors
/// If time does not go on evenly.
fn clock(experiment: &Experiment, n: usize) -> Result<(f64, Vec<f64>), IdentifyError> {
    let error = |reason: String| IdentifyError::Clock {
        experiment: experiment.name.clone(),
        reason,
    };
    let times = match &experiment.clock {
        Clock::Rate(rate) if *rate > 0.0 && rate.is_finite() => {
            return Ok((*rate, (0..n).map(|k| k as f64 / rate).collect()));
        }
        Clock::Rate(rate) => return Err(error(format!("{rate} samples a second"))),
        Clock::Times(times) => times,
    };
    if let Some(k) = times.iter().position(|t| !t.is_finite()) {
        return Err(error(format!("time {k} is {}", times[k])));
    }
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_unstable_by(f64::total_cmp);
    let Some(&usual) = steps.get(steps.len() / 2) else {
        return Err(error("less than two times".into()));
    };
    for (k, pair) in times.windows(2).enumerate() {
        let step = pair[1] - pair[0];
        // Not true of a usual step that is not positive.
        let is_even = usual > 0.0 && (step - usual).abs() <= JITTER * usual;
        if !(is_even || step > GAP * usual && usual > 0.0) {
            return Err(error(format!(
                "sample {} comes {step} s after the one before it, and the usual time is {usual} s: resample the log evenly",
                k + 1
            )));
        }
    }
    Ok((usual.recip(), times.clone()))
}

/// Makes angles continuous that were wrapped to one turn.
fn unwrap_angles(q: &mut DMatrix<f64>, row: usize) {
    let mut last = f64::NAN;
    for k in 0..q.ncols() {
        let angle = q[(row, k)];
        if !angle.is_finite() {
            continue;
        }
        if (angle - last).abs() > PI {
            q[(row, k)] = angle - TAU * ((angle - last) / TAU).round();
        }
        last = q[(row, k)];
    }
}

/// Normalises the quaternions in four rows from one on.
///
/// # Errors
/// If one is none.
fn normalize(q: &mut DMatrix<f64>, row: usize) -> Result<(), String> {
    /// Largest error of a norm that rounding in a log makes.
    const ROUNDING: f64 = 0.01;
    for k in 0..q.ncols() {
        let mut quaternion = q.view_mut((row, k), (4, 1));
        let norm = quaternion.norm();
        if (norm - 1.0).abs() > ROUNDING {
            return Err(format!("the quaternion of sample {k} has the norm {norm}"));
        }
        quaternion /= norm;
    }
    Ok(())
}
