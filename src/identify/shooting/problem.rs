//! The problem: shots, the numbers that are adjusted, and where they go.

use nalgebra::DMatrix;

use super::{Adjustable, ShootingOptions, Starts};
use crate::identify::consistent::possible;
use crate::identify::dataset::{Dataset, Segment};
use crate::identify::error::IdentifyError;
use crate::identify::estimate::Interval;
use crate::least_squares::Residuals;
use crate::model::ParameterGroup;
use crate::scalar::Dual;
use crate::sim::{Simulator, SimulatorParameterGroup, State};
use crate::spatial::{INERTIAL_PARAMETERS, Inertia};

/// Variables that belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Block {
    /// Ten log-Cholesky parameters.
    Inertia,
    Number,
}

/// Places of a number in the vector of [parameters](Simulator::parameters): several where it is shared.
pub(super) type Target = Vec<usize>;

/// Numbers of the robot, and their slopes in the variables.
pub(super) struct Numbers {
    pub(super) values: Vec<f64>,
    pub(super) slopes: DMatrix<f64>,
}

/// A piece of the log.
pub(super) struct Shot<'a> {
    pub(super) segment: &'a Segment,
    pub(super) first: usize,
    pub(super) samples: usize,
}

/// The problem as residuals of states.
pub(super) struct Shooting<'a> {
    pub(super) simulator: &'a Simulator,
    pub(super) options: &'a ShootingOptions,
    pub(super) shots: Vec<Shot<'a>>,
    /// Steps from sample to sample.
    pub(super) steps: usize,
    pub(super) blocks: Vec<Block>,
    pub(super) targets: Vec<Target>,
    pub(super) names: Vec<String>,
    /// Variables of the nominal robot.
    pub(super) nominal: Vec<f64>,
    pub(super) is_bounded: Vec<bool>,
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
            blocks: Vec::new(),
            targets: Vec::new(),
            names: Vec::new(),
            nominal: Vec::new(),
            is_bounded: Vec::new(),
        };
        for own in adjustable {
            out.add(own)?;
        }
        for segment in &data.segments {
            // A shot ends with the sample with which the next begins.
            for first in (0..segment.len().saturating_sub(1)).step_by(options.samples) {
                let samples = options.samples.min(segment.len() - 1 - first);
                out.shots.push(Shot {
                    segment,
                    first,
                    samples,
                });
            }
        }
        let rows = out.n_residuals();
        if out.shots.is_empty() || rows <= out.nominal.len() {
            return Err(IdentifyError::TooFewData {
                rows,
                unknowns: out.nominal.len(),
            });
        }
        Ok(out)
    }

    pub(super) fn add(&mut self, adjustable: &Adjustable) -> Result<(), IdentifyError> {
        let model = self.simulator.model();
        let (layout, parameters) = (
            self.simulator.parameter_layout(),
            self.simulator.parameters(),
        );
        match adjustable {
            Adjustable::Inertia(link) => {
                let frame = model.find_frame(link)?;
                let body = model.frames()[frame.0]
                    .body
                    .ok_or_else(|| option(link, "it does not move"))?;
                let range = layout
                    .range(SimulatorParameterGroup::Model(ParameterGroup::Inertia(
                        body,
                    )))
                    .unwrap_or_default();
                self.names.extend_from_slice(&layout.names()[range.clone()]);
                self.targets.extend(range.map(|index| vec![index]));
                self.nominal.extend(possible(model, body).to_log_cholesky());
                self.is_bounded.extend([false; INERTIAL_PARAMETERS]);
                self.blocks.push(Block::Inertia);
            }
            Adjustable::Parameter(name) => {
                let index = layout.find(name)?;
                let not_negative = [
                    "damping",
                    "armature",
                    "stiffness",
                    "friction",
                    "Coulomb friction",
                ];
                let quantity = name.rsplit(": ").next().unwrap_or_default();
                let is_bounded = not_negative.iter().any(|own| quantity.starts_with(own))
                    && !quantity.ends_with("exponent");
                let group = layout.groups().iter().find(|(_, own)| own.contains(&index));
                let is_free = match group.map(|(group, _)| *group) {
                    Some(SimulatorParameterGroup::Model(_) | SimulatorParameterGroup::Terrain) => {
                        true
                    }
                    Some(SimulatorParameterGroup::ContactPoint(_)) => quantity != "radius",
                    _ => false,
                };
                if !(is_bounded || is_free) {
                    return Err(option(
                        name,
                        "a descent could take it where it makes no sense",
                    ));
                }
                self.push(vec![index], name.clone(), parameters[index], is_bounded);
            }
            Adjustable::Friction(points) => {
                let of = |&k: &usize| {
                    let law = layout.range(SimulatorParameterGroup::ContactLaw(k))?;
                    law.clone()
                        .find(|&index| layout.names()[index].ends_with(": friction"))
                };
                let target: Option<Target> = points.iter().map(of).collect();
                let target = target.filter(|target| !target.is_empty());
                let Some(target) = target else {
                    return Err(option("friction", "there are no such points of contact"));
                };
                if target.iter().any(|&index| !parameters[index].is_finite()) {
                    return Err(option("friction", "that of a point is infinite"));
                }
                let (name, first) = (
                    format!("friction of points {points:?}"),
                    parameters[target[0]],
                );
                self.push(target, name, first, true);
            }
        }
        Ok(())
    }

    pub(super) fn push(&mut self, target: Target, name: String, value: f64, is_bounded: bool) {
        self.targets.push(target);
        self.names.push(name);
        self.nominal.push(value);
        self.is_bounded.push(is_bounded);
        self.blocks.push(Block::Number);
    }

    pub(super) fn n_variables(&self) -> usize {
        self.nominal.len()
    }

    /// Variables of the nominal robot, then the starts.
    pub(super) fn start(&self) -> Vec<f64> {
        let mut out = self.nominal.clone();
        if self.options.starts == Starts::Free {
            for shot in &self.shots {
                out.extend(shot.segment.q.column(shot.first).iter());
                out.extend(shot.segment.v.column(shot.first).iter());
            }
        }
        out
    }

    pub(super) fn lower(&self, n: usize) -> Vec<f64> {
        let bound = |k: usize| match self.is_bounded.get(k) {
            Some(true) => 0.0,
            _ => f64::NEG_INFINITY,
        };
        (0..n).map(bound).collect()
    }

    /// Numbers of the robot at variables.
    pub(super) fn numbers(&self, x: &[f64]) -> Numbers {
        let p = self.n_variables();
        let (mut values, mut slopes) = (Vec::with_capacity(p), DMatrix::zeros(p, p));
        for block in &self.blocks {
            let first = values.len();
            match block {
                Block::Number => {
                    values.push(x[first]);
                    slopes[(first, first)] = 1.0;
                }
                Block::Inertia => {
                    let theta = std::array::from_fn(|i| {
                        let mut seeded = Dual::<f64, INERTIAL_PARAMETERS>::from(x[first + i]);
                        seeded.eps[i] = 1.0;
                        seeded
                    });
                    let own = Inertia::from_log_cholesky(theta).to_parameters();
                    for (i, number) in own.iter().enumerate() {
                        values.push(number.re);
                        let mut row = slopes.view_mut((first + i, first), (1, INERTIAL_PARAMETERS));
                        row.iter_mut()
                            .zip(number.eps)
                            .for_each(|(to, slope)| *to = slope);
                    }
                }
            }
        }
        Numbers { values, slopes }
    }

    /// The simulator with numbers of the robot; `None` where these are not finite.
    pub(super) fn simulator_with(&self, values: &[f64]) -> Option<Simulator> {
        if values.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let mut parameters = self.simulator.parameters();
        for (target, &value) in self.targets.iter().zip(values) {
            target.iter().for_each(|&index| parameters[index] = value);
        }
        Some(self.simulator.with_parameters(parameters.as_slice()))
    }

    /// Start of a shot.
    pub(super) fn start_of(&self, simulator: &Simulator, shot: usize, x: &[f64]) -> State {
        let (nq, nv) = (simulator.model().nq(), simulator.model().nv());
        match self.options.starts {
            Starts::Free => {
                let own = &x[self.n_variables() + shot * (nq + nv)..][..nq + nv];
                simulator.state(&own[..nq], &own[nq..])
            }
            Starts::Measured => {
                let Shot { segment, first, .. } = &self.shots[shot];
                simulator.state(
                    segment.q.column(*first).as_slice(),
                    segment.v.column(*first).as_slice(),
                )
            }
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

    pub(super) fn n_penalties(&self) -> usize {
        let inertias = self.blocks.iter().filter(|block| **block == Block::Inertia);
        INERTIAL_PARAMETERS * inertias.count()
    }

    /// First variable of each inertia.
    pub(super) fn inertias(&self) -> Vec<usize> {
        let (mut out, mut first) = (Vec::new(), 0);
        for block in &self.blocks {
            match block {
                Block::Number => first += 1,
                Block::Inertia => {
                    out.push(first);
                    first += INERTIAL_PARAMETERS;
                }
            }
        }
        out
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

impl Shooting<'_> {
    pub(super) fn intervals(
        &self,
        values: &[f64],
        covariance: &DMatrix<f64>,
        factor: f64,
    ) -> Vec<Interval> {
        let interval = |k: usize| {
            let (value, deviation) = (values[k], covariance[(k, k)].max(0.0).sqrt());
            Interval {
                name: self.names[k].clone(),
                value,
                deviation,
                lower: value - factor * deviation,
                upper: value + factor * deviation,
            }
        };
        (0..values.len()).map(interval).collect()
    }
}

pub(super) fn option(option: &str, reason: &str) -> IdentifyError {
    IdentifyError::Option {
        option: option.into(),
        reason: reason.into(),
    }
}

pub(super) fn check(simulator: &Simulator, options: &ShootingOptions) -> Result<(), IdentifyError> {
    let positive = [
        ("position deviation", options.position_deviation),
        ("velocity deviation", options.velocity_deviation),
        ("regularization", options.regularization),
        ("samples", options.samples as f64),
    ];
    for (name, value) in positive {
        if !(value > 0.0 && value.is_finite()) {
            return Err(option(name, &format!("{value} is not positive and finite")));
        }
    }
    if !simulator.constraints().is_empty() {
        return Err(option(
            "simulator",
            "kinematic constraints are not supported",
        ));
    }
    match simulator.nu() == simulator.actuated().len() {
        true => Ok(()),
        false => Err(option(
            "simulator",
            "the log has no inputs for actuators on frames",
        )),
    }
}

/// Number of steps from sample to sample.
pub(super) fn steps(simulator: &Simulator, data: &Dataset) -> Result<usize, IdentifyError> {
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
                    "{exact} time steps of the simulator from sample to sample; it is to be the same whole number for all data",
                ),
            });
        }
        out = Some(steps);
    }
    Ok(out.unwrap_or(1.0) as usize)
}
