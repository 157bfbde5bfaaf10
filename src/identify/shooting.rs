//! Multiple shooting: a robot's numbers from how it moves in simulation, contact included.
//!
//! The log is cut into short shots. Each is simulated from its own start under the measured forces, and all simulated states are compared with measured ones, so that
//! accelerations are never needed, and what is not linear in its numbers, as placements, springs and friction on the ground, can be found too. Shots are short
//! for two reasons: errors of the start grow along them, and a long simulation of an unstable or touching robot has a landscape in which no descent finds its way.
//!
//! States' derivatives go along with the simulation. Each step gives a vector-Jacobian product for every number of the state, which costs 2 `nv` times three to six
//! steps, however many numbers of the robot are wanted; dual numbers would cost as much for every eight of these, and know no friction of points.

use nalgebra::{DMatrix, DVector};

use super::consistent::possible;
use super::dataset::{Dataset, Segment};
use super::error::IdentifyError;
use super::estimate::Interval;
use super::student::quantile;
use crate::contact::ContactLaw;
use crate::least_squares::{Options, Residuals, Status, solve};
use crate::linearize::{StepGradient, VjpScratch};
use crate::model::ParameterGroup;
use crate::scalar::Dual;
use crate::sim::{Simulator, State, StepScratch};
use crate::spatial::{INERTIAL_PARAMETERS, Inertia};

/// Numbers of a robot that [`shoot`] adjusts.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Adjustable {
    /// The inertia of the body that a link is on, by log-Cholesky parameters: it stays that of a body.
    Inertia(String),
    /// The parameter of the model with this name, as in [`ParameterLayout`](crate::model::ParameterLayout): `elbow: damping`, `elbow: shift x`, `door:
    /// stiffness`. Damping, rotors and stiffness stay not negative.
    Parameter(String),
    /// One coefficient of friction for these points of contact, by their index in [`Contacts::points`](crate::contact::Contacts::points). It stays not
    /// negative.
    Friction(Vec<usize>),
}

/// Starts of shots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Starts {
    /// The measured states. The number of variables does not grow with the log; errors of the start bias what is found.
    #[default]
    Measured,
    /// Variables, near the measured states as these are certain. Memory grows with the square of their number: for tens of shots.
    Free,
}

/// Options of [`shoot`].
#[derive(Clone, Debug, PartialEq)]
pub struct ShootingOptions {
    /// Number of samples of a shot; 30 by default. Longer ones tell small forces better, until errors of the start outgrow what they tell.
    pub samples: usize,
    /// Starts of shots; the measured states by default.
    pub starts: Starts,
    /// Standard deviation of measured positions, rad or m; 1e-3 by default. Only its ratio to that of velocities counts.
    pub position_deviation: f64,
    /// Standard deviation of measured velocities, rad/s or m/s; 1e-2 by default.
    pub velocity_deviation: f64,
    /// Weight of the distance of log-Cholesky parameters from the nominal ones, for what the motion leaves open; 1e-6 by default.
    pub regularization: f64,
    /// Largest number of iterations; 50 by default.
    pub max_iterations: usize,
}

impl Default for ShootingOptions {
    fn default() -> Self {
        Self {
            samples: 30,
            starts: Starts::Measured,
            position_deviation: 1e-3,
            velocity_deviation: 1e-2,
            regularization: 1e-6,
            max_iterations: 50,
        }
    }
}

/// Result of [`shoot`].
#[derive(Clone, Debug)]
pub struct ShootingEstimate {
    /// The simulator with the numbers that were found.
    pub simulator: Simulator,
    /// Numbers with their intervals, in the order of what was asked for: ten for an inertia. Without intervals, `None`, if some number changes no state.
    pub intervals: Option<Vec<Interval>>,
    /// Values of these numbers.
    pub values: Vec<f64>,
    /// Standard deviation of the residuals, in units of the deviations that were given.
    pub deviation: f64,
    /// Status of the solver.
    pub status: Status,
    /// Number of its iterations.
    pub iterations: usize,
}

/// Adjusts numbers of a simulator until its motion is that of the log, by Levenberg and Marquardt's method.
///
/// Each input of the simulator is the measured force along its coordinate, held from sample to sample. Bristles of contact are straight at the start of each
/// segment, and go on from shot to shot.
///
/// * `level` – probability that an interval holds the true value, 0.95 say
///
/// # Limitations
/// Not through kinematic constraints. What starts of earlier shots, where they are variables, do to bristles is left out of the Jacobian. That of residuals of spherical, planar and floating joints is exact to first order in these residuals. Where a shot
/// begins in flight and ends on the ground, or the other way round, the landscape has kinks; and that of a rigid body on several points of relaxed contact that
/// rocks is rough at time steps of some milliseconds, so that descents end in holes: fit friction with soft contact, or
/// [smoothed](crate::contact::Smoothing), and from data in which the robot has settled.
///
/// # Errors
/// If data belong to another robot or another rate, a name is unknown, an option is out of its range, or the simulator has constraints or inputs that no
/// force of the log is for.
///
/// # Panics
/// If the level is not between 0 and 1.
///
/// # References
/// [Bock 1987].
pub fn shoot(
    simulator: &Simulator,
    data: &Dataset,
    adjustable: &[Adjustable],
    level: f64,
    options: &ShootingOptions,
) -> Result<ShootingEstimate, IdentifyError> {
    assert!(
        level > 0.0 && level < 1.0,
        "the level {level} is not between 0 and 1"
    );
    data.check(simulator.model())?;
    let mut problem = Shooting::new(simulator, data, adjustable, options)?;
    let start = problem.start();
    let mut solver = Options::default().with_max_iterations(options.max_iterations);
    if problem.n_directions(&start) == start.len() {
        let lower = problem.lower(start.len());
        solver = solver.with_bounds(&lower, &vec![f64::INFINITY; start.len()]);
    }
    let found = solve(&mut problem, &start, &solver);
    let numbers = problem.numbers(&found.x);
    let deviation = found.variance().unwrap_or(0.0).sqrt();
    let freedom = problem
        .n_residuals()
        .saturating_sub(problem.n_directions(&start))
        .max(1) as f64;
    let factor = quantile(0.5 + 0.5 * level, freedom);
    let p = problem.n_variables();
    let intervals = found.covariance().map(|covariance| {
        let own = covariance.view((0, 0), (p, p));
        let of_numbers = &numbers.slopes * own * numbers.slopes.transpose();
        problem.intervals(&numbers.values, &of_numbers, factor)
    });
    let simulator = problem
        .simulator_with(&numbers.values)
        .unwrap_or_else(|| simulator.clone());
    Ok(ShootingEstimate {
        simulator,
        intervals,
        values: numbers.values,
        deviation,
        status: found.status,
        iterations: found.iterations,
    })
}

/// Variables that belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Block {
    /// Ten log-Cholesky parameters.
    Inertia,
    Number,
}

/// Where a number of the robot goes.
#[derive(Clone, Debug, PartialEq)]
enum Target {
    /// Into the vector of the model's parameters.
    Parameter(usize),
    Friction(Vec<usize>),
}

/// Numbers of the robot, and their slopes in the variables.
struct Numbers {
    values: Vec<f64>,
    slopes: DMatrix<f64>,
}

/// A piece of the log.
struct Shot<'a> {
    segment: &'a Segment,
    first: usize,
    samples: usize,
}

/// The problem as residuals of states.
struct Shooting<'a> {
    simulator: &'a Simulator,
    options: &'a ShootingOptions,
    shots: Vec<Shot<'a>>,
    /// Steps from sample to sample.
    steps: usize,
    blocks: Vec<Block>,
    targets: Vec<Target>,
    names: Vec<String>,
    /// Variables of the nominal robot.
    nominal: Vec<f64>,
    is_bounded: Vec<bool>,
}

impl<'a> Shooting<'a> {
    fn new(
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

    fn add(&mut self, adjustable: &Adjustable) -> Result<(), IdentifyError> {
        let model = self.simulator.model();
        let layout = model.parameter_layout();
        match adjustable {
            Adjustable::Inertia(link) => {
                let frame = model.find_frame(link)?;
                let body = model.frames()[frame.0]
                    .body
                    .ok_or_else(|| option(link, "it does not move"))?;
                let range = layout
                    .range(ParameterGroup::Inertia(body))
                    .unwrap_or_default();
                self.names.extend_from_slice(&layout.names()[range.clone()]);
                self.targets.extend(range.map(Target::Parameter));
                self.nominal.extend(possible(model, body).to_log_cholesky());
                self.is_bounded.extend([false; INERTIAL_PARAMETERS]);
                self.blocks.push(Block::Inertia);
            }
            Adjustable::Parameter(name) => {
                let index = layout.find(name)?;
                self.push(
                    Target::Parameter(index),
                    name.clone(),
                    model.parameters()[index],
                );
                let not_negative = ["damping", "armature", "stiffness"];
                let quantity = name.rsplit(": ").next().unwrap_or_default();
                let last = self.is_bounded.len() - 1;
                self.is_bounded[last] = not_negative.iter().any(|own| quantity.starts_with(own));
            }
            Adjustable::Friction(points) => {
                let laws = self
                    .simulator
                    .contacts()
                    .map_or(&[][..], |contacts| contacts.laws());
                let of = |k: usize| laws.get(k).map(friction);
                let Some(first) = points.first().and_then(|&k| of(k)) else {
                    return Err(option("friction", "there are no such points of contact"));
                };
                if points
                    .iter()
                    .any(|&k| of(k).is_none_or(|own| !own.is_finite()))
                {
                    return Err(option(
                        "friction",
                        "a point is not there, or its friction is infinite",
                    ));
                }
                let name = format!("friction of points {points:?}");
                self.push(Target::Friction(points.clone()), name, first);
            }
        }
        Ok(())
    }

    fn push(&mut self, target: Target, name: String, value: f64) {
        self.targets.push(target);
        self.names.push(name);
        self.nominal.push(value);
        self.is_bounded.push(true);
        self.blocks.push(Block::Number);
    }

    fn n_variables(&self) -> usize {
        self.nominal.len()
    }

    /// Variables of the nominal robot, then the starts.
    fn start(&self) -> Vec<f64> {
        let mut out = self.nominal.clone();
        if self.options.starts == Starts::Free {
            for shot in &self.shots {
                out.extend(shot.segment.q.column(shot.first).iter());
                out.extend(shot.segment.v.column(shot.first).iter());
            }
        }
        out
    }

    fn lower(&self, n: usize) -> Vec<f64> {
        let bound = |k: usize| match self.is_bounded.get(k) {
            Some(true) => 0.0,
            _ => f64::NEG_INFINITY,
        };
        (0..n).map(bound).collect()
    }

    /// Numbers of the robot at variables.
    fn numbers(&self, x: &[f64]) -> Numbers {
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
    fn simulator_with(&self, values: &[f64]) -> Option<Simulator> {
        if values.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let (mut indices, mut numbers) = (Vec::new(), Vec::new());
        let mut laws = self
            .simulator
            .contacts()
            .map_or_else(Vec::new, |contacts| contacts.laws().to_vec());
        for (target, &value) in self.targets.iter().zip(values) {
            match target {
                Target::Parameter(index) => {
                    indices.push(*index);
                    numbers.push(value);
                }
                Target::Friction(points) => points
                    .iter()
                    .for_each(|&k| set_friction(&mut laws[k], value)),
            }
        }
        let model = self
            .simulator
            .model()
            .with_some_parameters(&indices, &numbers);
        let out = self.simulator.with_model(model).ok()?;
        Some(match self.simulator.contacts() {
            Some(contacts) => out.with_contacts(contacts.with_laws(&laws)),
            None => out,
        })
    }

    /// Start of a shot.
    fn start_of(&self, simulator: &Simulator, shot: usize, x: &[f64]) -> State {
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
    fn continues(&self, shot: usize) -> bool {
        let Some(before) = shot.checked_sub(1).map(|k| &self.shots[k]) else {
            return false;
        };
        let own = &self.shots[shot];
        std::ptr::eq(before.segment, own.segment) && before.first + before.samples == own.first
    }

    /// Whether the first sample of a shot is compared too.
    fn has_first(&self) -> bool {
        self.options.starts == Starts::Free
    }

    fn rows_of(&self, shot: &Shot<'_>) -> usize {
        2 * self.simulator.model().nv() * (shot.samples + usize::from(self.has_first()))
    }

    fn n_penalties(&self) -> usize {
        let inertias = self.blocks.iter().filter(|block| **block == Block::Inertia);
        INERTIAL_PARAMETERS * inertias.count()
    }

    /// First variable of each inertia.
    fn inertias(&self) -> Vec<usize> {
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
    fn compare(&self, shot: &Shot<'_>, sample: usize, state: &State, out: &mut [f64]) {
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

    fn input(&self, shot: &Shot<'_>, sample: usize, u: &mut [f64]) {
        for (u, &k) in u.iter_mut().zip(self.simulator.actuated()) {
            *u = shot.segment.tau[(k, shot.first + sample)];
        }
    }

    /// Simulates a shot with the derivatives of its states in numbers and start, and fills its rows of the Jacobian.
    fn differentiate(&self, run: &mut Run<'_>, shot: usize, state: State, rows: &mut Rows<'_>) {
        let (own, nv) = (&self.shots[shot], self.simulator.model().nv());
        let n = run.simulator.n_tangent();
        let mut by_number = DMatrix::zeros(n, self.targets.len());
        let mut state = state;
        if self.continues(shot) {
            state.contact.copy_from(&run.bristles);
            by_number
                .rows_mut(2 * nv, n - 2 * nv)
                .copy_from(&run.bristles_by_number);
        }
        let mut by_start = DMatrix::zeros(n, 2 * nv);
        by_start.fill_with_identity();
        let mut u = vec![0.0; run.simulator.nu()];
        let mut next = state.clone();
        for sample in 0..=own.samples {
            if sample > 0 || self.has_first() {
                rows.push(&by_number, &by_start);
            }
            if sample == own.samples {
                break;
            }
            self.input(own, sample, &mut u);
            for _ in 0..self.steps {
                run.linearize(&state, &u, &self.targets);
                by_number = &run.by_state * by_number + &run.by_number;
                by_start = &run.by_state * by_start;
                run.simulator
                    .step_into(&state, &u, &mut run.step, &mut next);
                std::mem::swap(&mut state, &mut next);
            }
        }
        run.bristles.copy_from(&state.contact);
        run.bristles_by_number
            .copy_from(&by_number.rows(2 * nv, n - 2 * nv));
    }
}

/// Working memory of derivatives of steps.
struct Run<'a> {
    simulator: &'a Simulator,
    step: StepScratch<f64>,
    vjp: VjpScratch,
    gradient: StepGradient,
    adjoint: Vec<f64>,
    by_state: DMatrix<f64>,
    by_number: DMatrix<f64>,
    /// State of contact at the end of the shot before, and its derivatives in numbers.
    bristles: DVector<f64>,
    bristles_by_number: DMatrix<f64>,
}

impl<'a> Run<'a> {
    fn new(simulator: &'a Simulator, numbers: usize) -> Self {
        let n = simulator.n_tangent();
        Self {
            step: StepScratch::new(simulator),
            vjp: VjpScratch::new(simulator),
            gradient: StepGradient::zeros(simulator),
            adjoint: vec![0.0; n],
            by_state: DMatrix::zeros(n, n),
            by_number: DMatrix::zeros(n, numbers),
            bristles: DVector::zeros(simulator.n_contact()),
            bristles_by_number: DMatrix::zeros(simulator.n_contact(), numbers),
            simulator,
        }
    }

    /// Derivatives of the next state in this one and in numbers, row by row.
    fn linearize(&mut self, state: &State, u: &[f64], targets: &[Target]) {
        for row in 0..self.adjoint.len() {
            self.adjoint[row] = 1.0;
            self.simulator
                .vjp_into(state, u, &self.adjoint, &mut self.vjp, &mut self.gradient);
            self.adjoint[row] = 0.0;
            self.by_state
                .row_mut(row)
                .copy_from(&self.gradient.state.transpose());
            for (k, target) in targets.iter().enumerate() {
                self.by_number[(row, k)] = match target {
                    Target::Parameter(index) => self.gradient.parameters[*index],
                    Target::Friction(points) => {
                        points.iter().map(|&k| self.gradient.friction[k]).sum()
                    }
                };
            }
        }
    }
}

/// Rows of the Jacobian that are filled one sample after another.
struct Rows<'a> {
    jacobian: &'a mut DMatrix<f64>,
    next: usize,
    /// Slopes of numbers in the variables.
    slopes: &'a DMatrix<f64>,
    /// −1 / deviation of each row of a sample.
    scales: &'a [f64],
    /// First column of the start, where it is a variable.
    start: Option<usize>,
}

impl Rows<'_> {
    fn push(&mut self, by_number: &DMatrix<f64>, by_start: &DMatrix<f64>) {
        let by_variable = by_number.rows(0, self.scales.len()) * self.slopes;
        for (i, scale) in self.scales.iter().enumerate() {
            let row = self.next + i;
            for k in 0..by_variable.ncols() {
                self.jacobian[(row, k)] = scale * by_variable[(i, k)];
            }
            if let Some(first) = self.start {
                for k in 0..by_start.ncols() {
                    self.jacobian[(row, first + k)] = scale * by_start[(i, k)];
                }
            }
        }
        self.next += self.scales.len();
    }
}

impl Residuals for Shooting<'_> {
    fn n_residuals(&self) -> usize {
        self.shots
            .iter()
            .map(|shot| self.rows_of(shot))
            .sum::<usize>()
            + self.n_penalties()
    }

    fn residuals(&mut self, x: &[f64], out: &mut [f64]) {
        let Some(simulator) = self.simulator_with(&self.numbers(x).values) else {
            out.fill(f64::NAN);
            return;
        };
        let mut scratch = StepScratch::new(&simulator);
        let width = 2 * simulator.model().nv();
        let (mut u, mut rows) = (
            vec![0.0; simulator.nu()],
            out.chunks_exact_mut(width.max(1)),
        );
        let mut bristles = DVector::zeros(simulator.n_contact());
        for (k, shot) in self.shots.iter().enumerate() {
            let mut state = self.start_of(&simulator, k, x);
            if self.continues(k) {
                state.contact.copy_from(&bristles);
            }
            let mut next = state.clone();
            for sample in 0..=shot.samples {
                if sample > 0 {
                    self.input(shot, sample - 1, &mut u);
                    for _ in 0..self.steps {
                        simulator.step_into(&state, &u, &mut scratch, &mut next);
                        std::mem::swap(&mut state, &mut next);
                    }
                }
                if (sample > 0 || self.has_first())
                    && let Some(row) = rows.next()
                {
                    self.compare(shot, sample, &state, row);
                }
            }
            bristles.copy_from(&state.contact);
        }
        let root = self.options.regularization.sqrt();
        let penalties = self
            .inertias()
            .into_iter()
            .flat_map(|k| k..k + INERTIAL_PARAMETERS);
        let first = out.len() - self.n_penalties();
        for (out, k) in out[first..].iter_mut().zip(penalties) {
            *out = root * (x[k] - self.nominal[k]);
        }
    }

    fn jacobian(&mut self, x: &[f64], out: &mut DMatrix<f64>) {
        out.fill(0.0);
        let numbers = self.numbers(x);
        let Some(simulator) = self.simulator_with(&numbers.values) else {
            out.fill(f64::NAN);
            return;
        };
        let nv = simulator.model().nv();
        let deviation = |k: usize| match k < nv {
            true => self.options.position_deviation,
            false => self.options.velocity_deviation,
        };
        let scales: Vec<f64> = (0..2 * nv).map(|k| -deviation(k).recip()).collect();
        let mut run = Run::new(&simulator, self.targets.len());
        let mut next = 0;
        for shot in 0..self.shots.len() {
            let start = self
                .has_first()
                .then_some(self.n_variables() + shot * 2 * nv);
            let mut rows = Rows {
                jacobian: out,
                next,
                slopes: &numbers.slopes,
                scales: &scales,
                start,
            };
            let state = self.start_of(&simulator, shot, x);
            self.differentiate(&mut run, shot, state, &mut rows);
            next = rows.next;
        }
        let root = self.options.regularization.sqrt();
        let penalties = self
            .inertias()
            .into_iter()
            .flat_map(|k| k..k + INERTIAL_PARAMETERS);
        for (row, k) in (next..).zip(penalties) {
            out[(row, k)] = root;
        }
    }

    fn n_directions(&self, _: &[f64]) -> usize {
        let starts = if self.has_first() {
            self.shots.len()
        } else {
            0
        };
        self.n_variables() + starts * 2 * self.simulator.model().nv()
    }

    fn retract(&self, x: &[f64], d: &[f64], out: &mut [f64]) {
        let (p, model) = (self.n_variables(), self.simulator.model());
        let (nq, nv) = (model.nq(), model.nv());
        for k in 0..p {
            out[k] = x[k] + d[k];
        }
        let starts = x[p..]
            .chunks_exact((nq + nv).max(1))
            .zip(d[p..].chunks_exact((2 * nv).max(1)));
        for ((x, d), out) in starts.zip(out[p..].chunks_exact_mut((nq + nv).max(1))) {
            model.integrate_into(&x[..nq], &d[..nv], &mut out[..nq]);
            for k in 0..nv {
                out[nq + k] = x[nq + k] + d[nv + k];
            }
        }
    }
}

impl Shooting<'_> {
    fn intervals(&self, values: &[f64], covariance: &DMatrix<f64>, factor: f64) -> Vec<Interval> {
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

fn option(option: &str, reason: &str) -> IdentifyError {
    IdentifyError::Option {
        option: option.into(),
        reason: reason.into(),
    }
}

fn check(simulator: &Simulator, options: &ShootingOptions) -> Result<(), IdentifyError> {
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
            "there are no gradients in numbers of the robot through kinematic constraints",
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
                    "{exact} time steps of the simulator from sample to sample; it is to be the same whole number for all data",
                ),
            });
        }
        out = Some(steps);
    }
    Ok(out.unwrap_or(1.0) as usize)
}

fn friction(law: &ContactLaw) -> f64 {
    match law {
        ContactLaw::Soft(law) => law.friction,
        ContactLaw::RelaxedRigid(law) => law.friction,
        ContactLaw::Rigid(law) => law.friction,
    }
}

fn set_friction(law: &mut ContactLaw, friction: f64) {
    match law {
        ContactLaw::Soft(law) => law.friction = friction,
        ContactLaw::RelaxedRigid(law) => law.friction = friction,
        ContactLaw::Rigid(law) => law.friction = friction,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Contacts, SoftContact, Terrain};
    use crate::identify::tests::{normal, rng};
    use crate::model::{BodyId, Model, samples};

    /// A rollout as data, with errors of these deviations.
    fn logged(simulator: &Simulator, start: &State, steps: usize, deviations: [f64; 2]) -> Dataset {
        let push = |t: f64, _: &State, u: &mut [f64]| {
            u.iter_mut()
                .enumerate()
                .for_each(|(k, u)| *u = ((3.0 + k as f64) * t).sin());
        };
        let (model, rollout) = (simulator.model(), simulator.rollout(start, steps, push));
        let mut rng = rng(5);
        let mut segment = Segment {
            experiment: "log".into(),
            start: 0.0,
            rate: simulator.time_step().recip(),
            q: DMatrix::zeros(model.nq(), steps),
            v: DMatrix::zeros(model.nv(), steps),
            a: DMatrix::zeros(model.nv(), steps),
            tau: DMatrix::zeros(model.nv(), steps),
        };
        for k in 0..steps {
            let error = DVector::from_fn(model.nv(), |_, _| deviations[0] * normal(&mut rng));
            let q = model.integrate(rollout.states[k].q.as_slice(), error.as_slice());
            segment.q.set_column(k, &q);
            let error = DVector::from_fn(model.nv(), |_, _| deviations[1] * normal(&mut rng));
            segment.v.set_column(k, &(&rollout.states[k].v + error));
            for (u, &row) in rollout.inputs[k].iter().zip(simulator.actuated()) {
                segment.tau[(row, k)] = *u;
            }
        }
        Dataset::new(vec![segment])
    }

    fn cartpole() -> Simulator {
        let model = samples::cartpole()
            .with_damping(0, 0.7)
            .with_damping(1, 0.1);
        Simulator::new(model).with_time_step(5e-3)
    }

    fn adjustable() -> Vec<Adjustable> {
        vec![
            Adjustable::Parameter("linear: damping".into()),
            Adjustable::Inertia("pole".into()),
            Adjustable::Parameter("pivot: damping".into()),
        ]
    }

    /// A nominal robot that is wrong in what is asked for.
    fn wrong() -> Simulator {
        let model = samples::cartpole().with_link_mass("pole", 0.8).unwrap();
        Simulator::new(model).with_time_step(5e-3)
    }

    #[test]
    fn jacobian_equals_differences_with_starts_as_variables() {
        let data = logged(
            &cartpole(),
            &State::new(&[0.0, 2.0], &[0.0; 2]),
            12,
            [0.0; 2],
        );
        let nominal = wrong();
        let options = ShootingOptions {
            samples: 5,
            starts: Starts::Free,
            ..Default::default()
        };
        let mut problem = Shooting::new(&nominal, &data, &adjustable(), &options).unwrap();
        let x = problem.start();
        let (m, n) = (problem.n_residuals(), problem.n_directions(&x));
        let mut jacobian = DMatrix::zeros(m, n);
        problem.jacobian(&x, &mut jacobian);
        for k in 0..n {
            const STEP: f64 = 1e-5;
            let mut at = |by: f64| {
                let (mut d, mut moved) = (vec![0.0; n], x.clone());
                d[k] = by;
                problem.retract(&x, &d, &mut moved);
                let mut out = DVector::zeros(m);
                problem.residuals(&moved, out.as_mut_slice());
                out
            };
            let difference = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            let error =
                (difference - jacobian.column(k)).amax() / (1.0 + jacobian.column(k).amax());
            assert!(error < 1e-6, "{k}: {error}");
        }
    }

    // Of the pole the motion tells its moment about the pivot, m l and, through the cart, its mass.
    #[test]
    fn numbers_of_a_simulated_cart_pole_are_found_again() {
        let truth = cartpole();
        let data = logged(&truth, &State::new(&[0.0, 2.0], &[0.0; 2]), 400, [0.0; 2]);
        let found = shoot(
            &wrong(),
            &data,
            &adjustable(),
            0.95,
            &ShootingOptions::default(),
        )
        .unwrap();
        let model = found.simulator.model();
        assert!(
            (model.damping()[0] - 0.7).abs() < 1e-5,
            "{:?}",
            found.values
        );
        assert!(
            (model.damping()[1] - 0.1).abs() < 1e-5,
            "{:?}",
            found.values
        );
        let of = |model: &Model| {
            let own = model.body(BodyId(1)).inertia;
            [own.mass, own.first_moment.norm(), own.rotational.zz]
        };
        for (own, expected) in of(model).iter().zip(of(truth.model())) {
            assert!((own - expected).abs() < 1e-4, "{own} {expected}");
        }
        assert_eq!(model.inertia_flaws(), []);
    }

    #[test]
    fn intervals_of_a_noisy_log_hold_the_dampings() {
        let truth = cartpole();
        let data = logged(
            &truth,
            &State::new(&[0.0, 2.0], &[0.0; 2]),
            400,
            [1e-4, 1e-3],
        );
        let options = ShootingOptions {
            samples: 50,
            starts: Starts::Free,
            position_deviation: 1e-4,
            velocity_deviation: 1e-3,
            ..Default::default()
        };
        let found = shoot(&wrong(), &data, &adjustable(), 0.99, &options).unwrap();
        assert!((found.deviation - 1.0).abs() < 0.1, "{}", found.deviation);
        let intervals = found.intervals.unwrap();
        for (name, expected) in [
            ("linear: damping", 0.7),
            ("pivot: damping", 0.1),
            ("pole: mass", 0.5),
        ] {
            let own = intervals.iter().find(|own| own.name == name).unwrap();
            assert!(own.contains(expected), "{own:?}");
            assert!(own.deviation < 0.05 * expected, "{own:?}");
        }
    }

    // A box that slides on the ground, on bristles that are bent where shots begin.
    #[test]
    fn friction_of_a_sliding_box_is_found_again() {
        let urdf = r#"<robot name="box"><link name="box">
            <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
            <collision><geometry><box size="0.4 0.4 0.1"/></geometry></collision></link></robot>"#;
        let model = Model::from_urdf_str(urdf).unwrap();
        let simulator = |friction: f64| {
            let law = SoftContact {
                friction,
                ..SoftContact::estimate(1.0, 4, 1e-3)
            };
            let law = ContactLaw::Soft(law);
            let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
            Simulator::new(model.clone())
                .with_time_step(2e-3)
                .with_contacts(contacts)
        };
        let truth = simulator(0.4);
        let mut start = truth.neutral_state();
        start.q[2] = 0.049;
        start.v.copy_from_slice(&[1.5, 0.3, 0.0, 0.0, 0.0, 0.5]);
        assert!(truth.n_contact() > 0);
        let data = logged(&truth, &start, 70, [0.0; 2]);
        let all = (0..truth.contacts().unwrap().points().len()).collect();
        let found = shoot(
            &simulator(0.7),
            &data,
            &[Adjustable::Friction(all)],
            0.95,
            &ShootingOptions::default(),
        );
        let found = found.unwrap();
        assert!(
            (found.values[0] - 0.4).abs() < 1e-4,
            "{:?} {:?}",
            found.values,
            found.status
        );
    }

    #[test]
    fn what_cannot_be_adjusted_is_refused_by_name() {
        let data = logged(
            &cartpole(),
            &State::new(&[0.0, 2.0], &[0.0; 2]),
            50,
            [0.0; 2],
        );
        let says =
            |simulator: &Simulator, own: Adjustable, options: ShootingOptions, expected: &str| {
                let text = shoot(simulator, &data, &[own], 0.95, &options)
                    .unwrap_err()
                    .to_string();
                assert!(text.contains(expected), "{text}\ndoes not say: {expected}");
            };
        let mass = || Adjustable::Parameter("pole: mass".into());
        let options = ShootingOptions::default;
        says(
            &wrong(),
            Adjustable::Parameter("pole: weight".into()),
            options(),
            "pole: weight",
        );
        says(
            &wrong(),
            Adjustable::Inertia("world".into()),
            options(),
            "it does not move",
        );
        says(
            &wrong(),
            Adjustable::Friction(vec![0]),
            options(),
            "no such points",
        );
        says(
            &wrong().with_time_step(3e-3),
            mass(),
            options(),
            "time steps of the simulator",
        );
        says(
            &wrong(),
            mass(),
            ShootingOptions {
                samples: 0,
                ..options()
            },
            "samples: 0",
        );
        says(
            &Simulator::new(samples::arm()),
            Adjustable::Inertia("link1".into()),
            options(),
            "\"arm\" has 7",
        );
    }
}
