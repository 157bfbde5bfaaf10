//! The problem: shots of the log, and where they begin.

use super::variables::{Variables, bounds};
use super::{Adjustable, ShootingOptions, Starts};
use crate::identify::dataset::{Dataset, Segment};
use crate::identify::error::{IdentifyError, check_positive};
use crate::least_squares::Residuals;
use crate::sim::{Simulator, State};

/// A piece of the log.
pub(super) struct Shot<'a> {
    pub(super) segment: &'a Segment,
    pub(super) first: usize,
    pub(super) samples: usize,
    /// The measured state at its start; with kinematic constraints, that nearby which obeys them.
    start: State,
}

/// The problem as residuals of states.
pub(super) struct Shooting<'a> {
    pub(super) simulator: &'a Simulator,
    pub(super) options: &'a ShootingOptions,
    pub(super) shots: Vec<Shot<'a>>,
    /// Steps from sample to sample.
    pub(super) steps: usize,
    pub(super) variables: Variables,
}

impl<'a> Shooting<'a> {
    pub(super) fn new(
        simulator: &'a Simulator,
        data: &'a Dataset,
        adjustable: &[Adjustable],
        options: &'a ShootingOptions,
    ) -> Result<Self, IdentifyError> {
        check(simulator, options)?;
        let mut out = Self {
            simulator,
            options,
            shots: Vec::new(),
            steps: steps(simulator, data)?,
            variables: Variables::new(simulator, adjustable)?,
        };
        for segment in &data.segments {
            // A shot ends with the sample with which the next begins.
            for first in (0..segment.len().saturating_sub(1)).step_by(options.samples) {
                out.shots.push(Shot {
                    segment,
                    first,
                    samples: options.samples.min(segment.len() - 1 - first),
                    start: start(simulator, segment, first)?,
                });
            }
        }
        let rows = out.n_residuals();
        let unknowns = out.variables.len();
        if out.shots.is_empty() || rows <= unknowns {
            return Err(IdentifyError::TooFewData { rows, unknowns });
        }
        Ok(out)
    }

    /// Variables of the nominal robot, then the starts.
    pub(super) fn start(&self) -> Vec<f64> {
        let mut out = self.variables.nominal.clone();
        if self.options.starts == Starts::Free {
            for shot in &self.shots {
                out.extend(shot.start.q.iter().chain(&shot.start.v));
            }
        }
        out
    }

    /// Least and largest values of the variables; of those of the robot, where starts are points of a curved space.
    pub(super) fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        let start = self.start();
        let n = match self.n_directions(&start) == start.len() {
            true => start.len(),
            false => self.variables.len(),
        };
        let domains = self.variables.domains.iter().copied().filter_map(bounds);
        let free = std::iter::repeat([f64::NEG_INFINITY, f64::INFINITY]);
        domains.chain(free).take(n).map(Into::into).unzip()
    }

    /// The simulator with parameters of the robot; `None` if these are not a robot: a parameter is out of its domain, or a joint moves without inertia.
    pub(super) fn simulator_with(&self, values: &[f64]) -> Option<Simulator> {
        if !self.variables.make_sense(values) {
            return None;
        }
        let mut parameters = self.simulator.parameters();
        for (target, &value) in self.variables.targets.iter().zip(values) {
            (target.iter()).for_each(|&(index, factor)| parameters[index] = factor * value);
        }
        let of_model = &parameters.as_slice()[..self.simulator.model().parameters().len()];
        let model = self.simulator.model().with_parameters(of_model);
        model.check_mass_matrix().ok()?;
        Some(self.simulator.with_parameters(parameters.as_slice()))
    }

    /// Start of a shot.
    pub(super) fn start_of(&self, simulator: &Simulator, shot: usize, x: &[f64]) -> State {
        let (nq, nv) = (simulator.model().nq(), simulator.model().nv());
        match self.options.starts {
            Starts::Free => {
                let own = &x[self.variables.len() + shot * (nq + nv)..][..nq + nv];
                simulator.state(&own[..nq], &own[nq..])
            }
            Starts::Measured => self.shots[shot].start.clone(),
        }
    }

    /// Whether a shot begins where the one before it ends, so that its bristles are bent as they are there.
    pub(super) fn continues(&self, shot: usize) -> bool {
        let Some(before) = shot.checked_sub(1).map(|k| &self.shots[k]) else {
            return false;
        };
        let own = &self.shots[shot];
        std::ptr::eq(before.segment, own.segment) && before.first + before.samples == own.first
    }

    /// Whether the first sample of a shot is compared too.
    pub(super) fn has_first(&self) -> bool {
        self.options.starts == Starts::Free
    }

    pub(super) fn rows_of(&self, shot: &Shot<'_>) -> usize {
        2 * self.simulator.model().nv() * (shot.samples + usize::from(self.has_first()))
    }

    /// (measured ⊖ simulated) / deviation.
    pub(super) fn compare(&self, shot: &Shot<'_>, sample: usize, state: &State, out: &mut [f64]) {
        let (model, at) = (self.simulator.model(), shot.first + sample);
        let (by_q, by_v) = out.split_at_mut(model.nv());
        let measured = shot.segment.q.column(at);
        model.difference_into(state.q.as_slice(), measured.as_slice(), by_q);
        by_q.iter_mut()
            .for_each(|r| *r /= self.options.position_deviation);
        for (k, r) in by_v.iter_mut().enumerate() {
            *r = (shot.segment.v[(k, at)] - state.v[k]) / self.options.velocity_deviation;
        }
    }

    pub(super) fn input(&self, shot: &Shot<'_>, sample: usize, u: &mut [f64]) {
        for (u, &k) in u.iter_mut().zip(self.simulator.actuated()) {
            *u = shot.segment.tau[(k, shot.first + sample)];
        }
    }
}

fn check(simulator: &Simulator, options: &ShootingOptions) -> Result<(), IdentifyError> {
    let positive = [
        ("position deviation", options.position_deviation),
        ("velocity deviation", options.velocity_deviation),
        ("regularization", options.regularization),
        ("samples", options.samples as f64),
    ];
    check_positive(positive)?;
    match simulator.nu() == simulator.actuated().len() {
        true => Ok(()),
        false => Err(IdentifyError::option(
            "simulator",
            "the log has no inputs for actuators on frames",
        )),
    }
}

/// The state of a sample, on the kinematic constraints, off which errors of the log have it.
///
/// # Errors
/// If the loops do not close from there.
fn start(simulator: &Simulator, segment: &Segment, sample: usize) -> Result<State, IdentifyError> {
    let (q, v) = (segment.q.column(sample), segment.v.column(sample));
    let state = simulator.state(q.as_slice(), v.as_slice());
    if simulator.constraints().is_empty() {
        return Ok(state);
    }
    let assembly = simulator.assemble(&state);
    let error = |source| IdentifyError::Open {
        experiment: segment.experiment.clone(),
        time: segment.start + sample as f64 / segment.rate,
        source,
    };
    Ok(assembly.map_err(error)?.state)
}

/// Number of steps from sample to sample.
fn steps(simulator: &Simulator, data: &Dataset) -> Result<usize, IdentifyError> {
    /// Relative error of a clock that is none.
    const CLOCK: f64 = 1e-3;
    let mut out = None;
    for segment in &data.segments {
        let exact = (segment.rate * simulator.time_step()).recip();
        let steps = exact.round();
        let is_whole = steps >= 1.0 && (exact - steps).abs() < CLOCK * steps;
        if !is_whole || out.is_some_and(|own| own != steps) {
            return Err(IdentifyError::Clock {
                experiment: segment.experiment.clone(),
                reason: format!(
                    "{exact} time steps of the simulator per sample; expected the same whole number for all data",
                ),
            });
        }
        out = Some(steps);
    }
    Ok(out.unwrap_or(1.0) as usize)
}
