//! A pose in which a robot stays, with the input and the deflections of contact that hold it there.

mod regulator;
mod stance;

use std::fmt;

use nalgebra::{DMatrix, DVector};

use crate::dynamics::mass_matrix;
use crate::least_squares::{self, Options, Residuals, Status};
use crate::linearize::{Linearization, LinearizeScratch};
use crate::sim::{Simulator, State, StepScratch};

pub use regulator::{Dropped, EquilibriumLqr};

/// A fixed point of a simulator's step: x⁺ = x with v = 0 and a constant input.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, State, control::Equilibrium, model::samples};
///
/// // A pendulum, let down from 0.3 rad, hangs; held near 0.3 rad it needs ½ m g l sin q.
/// let simulator = Simulator::new(samples::pendulum());
/// let held = Equilibrium::find(&simulator, &State::new(&[0.3], &[0.0]), &[0.0]);
/// assert!(held.is_found());
/// assert!((held.input[0] - 0.5 * 9.81 * held.state.q[0].sin()).abs() < 1e-8);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibrium {
    /// Pose, at rest, with the state of contact.
    pub state: State,
    /// Input that holds it.
    pub input: DVector<f64>,
    /// Largest acceleration that is left, rad/s² or m/s²; next to zero if it is found.
    pub acceleration: f64,
    /// Termination status.
    pub status: EquilibriumStatus,
    /// Iterations of the search.
    pub iterations: usize,
}

/// Termination status of the search for an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EquilibriumStatus {
    /// Nothing moves.
    Found,
    /// Near the guess nothing that holds the robot was found: inputs are too weak or too few, nothing carries it, or the guess is too far away.
    NotHeld,
    /// A number is not finite.
    Diverged,
    /// A [`StopSignal`](crate::StopSignal) was set.
    Stopped,
}

/// Force that counts as none, beside the weight.
const NEGLIGIBLE: f64 = 1e-8;
/// Rounds, each of which begins where the one before ended.
const ROUNDS: usize = 4;
/// Iterations of a round.
const MOST_ITERATIONS: usize = 40;
/// What a way of a metre or a radian weighs beside an acceleration of g.
const PULL: f64 = 1e-3;
/// Arm at which the weight makes the torque that counts as a way of one, m.
const ARM: f64 = 0.1;

impl Equilibrium {
    /// Finds an equilibrium near a guess: pose, input and bristles of soft contact, all at once.
    ///
    /// A floating robot with contacts is first moved along gravity to where it touches the ground, with what statics says of inputs and forces there: points within a centimetre of the ground carry it, by
    /// the least torques. Then accelerations, weighted by the roots of the inertias, are
    /// made zero by Levenberg and Marquardt's method on the Jacobians of the step. As a rule many poses and inputs are equilibria; the one that is found is
    /// near the guess, where stiff directions move least. Allocates.
    ///
    /// * `guess` – pose of the start; its velocity is not used
    /// * `u` – input of the start
    ///
    /// # Panics
    /// If state or input have the wrong length.
    ///
    /// # References
    /// [Levenberg 1944; Marquardt 1963; Moré 1978].
    pub fn find(simulator: &Simulator, guess: &State, u: &[f64]) -> Self {
        let mut start = simulator.state(guess.q.as_slice(), &vec![0.0; simulator.model().nv()]);
        if start.contact.len() == guess.contact.len() {
            start.contact.copy_from(&guess.contact);
        }
        let mut input = DVector::from_column_slice(u);
        stance::begin(simulator, &mut start, &mut input);
        let mut rest = Rest::new(simulator, start, input);
        let options = Options::default().with_max_iterations(MOST_ITERATIONS);
        let mut iterations = 0;
        let mut status = EquilibriumStatus::NotHeld;
        for _ in 0..ROUNDS {
            let from = rest.from.clone();
            let found = least_squares::solve(&mut rest, &from, &options);
            iterations += found.iterations;
            rest.move_to(&found.x);
            rest.from = found.x;
            let accelerations = &found.residuals[..rest.scale.len()];
            let largest = accelerations.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
            status = match found.status {
                Status::Diverged => EquilibriumStatus::Diverged,
                Status::Stopped => EquilibriumStatus::Stopped,
                _ if largest < NEGLIGIBLE * rest.weight => EquilibriumStatus::Found,
                _ => EquilibriumStatus::NotHeld,
            };
            if status != EquilibriumStatus::NotHeld {
                break;
            }
        }
        Self {
            acceleration: rest.acceleration(),
            status,
            iterations,
            state: rest.state,
            input: rest.input,
        }
    }

    /// Whether the status is [`EquilibriumStatus::Found`].
    pub fn is_found(&self) -> bool {
        self.status == EquilibriumStatus::Found
    }
}

impl fmt::Display for EquilibriumStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Found => "found",
            Self::NotHeld => "not held: nothing near the guess carries the robot, the inputs are too weak or too few, or the guess is too far away",
            Self::Diverged => "a number is not finite",
            Self::Stopped => "stopped by a signal",
        })
    }
}

/// Residuals √Mᵢᵢ v̇ᵢ of a robot that shall rest, √m times the acceleration at which bristles slip, and, weakly, how far the variables (u, m, q) are from those
/// that a round began with: there are more variables than accelerations.
struct Rest<'a> {
    simulator: &'a Simulator,
    /// √Mᵢᵢ of each coordinate, then √m of each number of contact.
    scale: Vec<f64>,
    /// √m g, for what counts as a small residual.
    weight: f64,
    /// Variables that a round began with.
    from: Vec<f64>,
    /// Weight on the way from there: of an input, and of a number of a pose or of contact.
    pull: [f64; 2],
    state: State,
    input: DVector<f64>,
    next: State,
    step: StepScratch<f64>,
    linearize: LinearizeScratch,
    jacobian: Linearization,
}

/// m/s², for the scale of forces; of a robot without gravity too.
const STANDARD_GRAVITY: f64 = 9.806_65;

impl<'a> Rest<'a> {
    fn new(simulator: &'a Simulator, state: State, input: DVector<f64>) -> Self {
        let model = simulator.model();
        let inertia = mass_matrix(model, state.q.as_slice()).diagonal();
        let mass = model.total_mass();
        let bristles = std::iter::repeat_n(&mass, simulator.n_contact());
        Self {
            simulator,
            scale: inertia.iter().chain(bristles).map(|x| x.sqrt()).collect(),
            weight: mass.sqrt() * STANDARD_GRAVITY,
            from: input
                .iter()
                .chain(&state.contact)
                .chain(&state.q)
                .copied()
                .collect(),
            pull: [
                PULL / mass.sqrt() / ARM,
                PULL * mass.sqrt() * STANDARD_GRAVITY,
            ],
            input,
            next: state.clone(),
            state,
            step: StepScratch::new(simulator),
            linearize: LinearizeScratch::new(simulator),
            jacobian: Linearization::zeros(simulator),
        }
    }

    fn move_to(&mut self, x: &[f64]) {
        let (u, rest) = x.split_at(self.input.len());
        let (m, q) = rest.split_at(self.state.contact.len());
        self.input.copy_from_slice(u);
        self.state.contact.copy_from_slice(m);
        self.state.q.copy_from_slice(q);
    }

    /// Number of inputs, numbers of contact, and directions of the pose.
    fn sizes(&self) -> [usize; 3] {
        let simulator = self.simulator;
        [
            simulator.nu(),
            simulator.n_contact(),
            simulator.model().nv(),
        ]
    }

    /// Weight on the way of a direction.
    fn pull(&self, direction: usize) -> f64 {
        self.pull[usize::from(direction >= self.input.len())]
    }

    fn take_step(&mut self) {
        let (input, scratch) = (self.input.as_slice(), &mut self.step);
        self.simulator
            .step_into(&self.state, input, scratch, &mut self.next);
    }

    fn acceleration(&mut self) -> f64 {
        self.take_step();
        self.next.v.amax() / self.simulator.time_step()
    }
}

impl Residuals for Rest<'_> {
    fn n_residuals(&self) -> usize {
        self.scale.len() + self.sizes().iter().sum::<usize>()
    }

    fn residuals(&mut self, x: &[f64], out: &mut [f64]) {
        self.move_to(x);
        self.take_step();
        let dt = self.simulator.time_step();
        let bristles = self.next.contact.iter().zip(&self.state.contact);
        let slips = bristles.map(|(next, now)| (next - now) / (dt * dt));
        let accelerations = self.next.v.iter().map(|v| v / dt).chain(slips);
        let (out, way) = out.split_at_mut(self.scale.len());
        for ((out, a), scale) in out.iter_mut().zip(accelerations).zip(&self.scale) {
            *out = a * scale;
        }
        let (model, plain) = (self.simulator.model(), x.len() - self.state.q.len());
        for (k, way) in way[..plain].iter_mut().enumerate() {
            *way = x[k] - self.from[k];
        }
        model.difference_into(&self.from[plain..], &x[plain..], &mut way[plain..]);
        for (k, way) in way.iter_mut().enumerate() {
            *way *= self.pull(k);
        }
    }

    fn jacobian(&mut self, x: &[f64], out: &mut DMatrix<f64>) {
        self.move_to(x);
        let (simulator, input) = (self.simulator, self.input.as_slice());
        simulator.linearize_into(&self.state, input, &mut self.linearize, &mut self.jacobian);
        let (nv, nu, dt) = (
            simulator.model().nv(),
            simulator.nu(),
            simulator.time_step(),
        );
        let nm = simulator.n_contact();
        let Linearization { a, b } = &self.jacobian;
        for (row, scale) in self.scale.iter().enumerate() {
            let factor = if row < nv {
                scale / dt
            } else {
                scale / (dt * dt)
            };
            let mut put = |column, slope: f64| out[(row, column)] = factor * slope;
            (0..nu).for_each(|k| put(k, b[(nv + row, k)]));
            for k in 0..nm {
                let own = if row == nv + k { 1.0 } else { 0.0 };
                put(nu + k, a[(nv + row, 2 * nv + k)] - own);
            }
            (0..nv).for_each(|k| put(nu + nm + k, a[(nv + row, k)]));
        }
        // That of a turn only next to where it began, which is where the rounds end.
        let mut way = out.rows_mut(self.scale.len(), nu + nm + nv);
        way.fill(0.0);
        (0..way.nrows()).for_each(|k| way[(k, k)] = self.pull(k));
    }

    fn n_directions(&self, x: &[f64]) -> usize {
        let model = self.simulator.model();
        x.len() - model.nq() + model.nv()
    }

    fn retract(&self, x: &[f64], d: &[f64], out: &mut [f64]) {
        let model = self.simulator.model();
        let plain = x.len() - model.nq();
        for k in 0..plain {
            out[k] = x[k] + d[k];
        }
        model.integrate_into(&x[plain..], &d[plain..], &mut out[plain..]);
    }
}
