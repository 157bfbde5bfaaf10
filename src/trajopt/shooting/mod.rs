//! Single shooting: the whole rollout as one function of the inputs, minimised by argmin.
//!
//! The variables are one number for each input of each stage, squashed smoothly into its bounds (`squash.rs`), after those of the
//! first state if it is free. The gradient is exact, by one sweep backward over the step Jacobians (`sweep.rs`); constraints are
//! penalties of an augmented Lagrangian. `minimize.rs` runs argmin; `traits.rs` lets others run it.
//!
//! [Betts 2010, section 3.3; Griewank, Walther 2008, chapter 3].

mod minimize;
mod options;
mod solution;
mod squash;
mod sweep;
mod traits;

use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};

use nalgebra::{DMatrix, DVector};

use super::dynamics::Dynamics;
use super::lagrangian::no_multipliers;
use super::problem::{InitialState, Problem};
use super::trajectory::Trajectory;
pub use options::ShootingOptions;
pub use solution::{ShootingProgress, ShootingSolution};
use squash::{Squash, Squashed};
use sweep::{Direction, Slopes, Sweep, start_jacobian};

/// The cost of a rollout as a function of variables `z`, and its minimisation.
///
/// `z` holds, if the first state is free, δx₀ of  x₀ = start ⊕ δx₀,  then one variable for each input of each stage. Where an input
/// is bounded, its variable is squashed:  u = m + h sin(z / h)  between two bounds (m their middle, h half their distance),
/// u = lower − 1 + √(z² + 1)  above one,  u = upper + 1 − √(z² + 1)  below one. So bounds hold for every z. Constraints count by
/// their augmented Lagrangian: [`solve`](Self::solve) finds the multipliers; before, they are zero, and constraints plain
/// quadratic penalties.
///
/// It implements argmin's `CostFunction`, `Gradient` and `Hessian` on `Vec<f64>` and `Vec<Vec<f64>>`, itself and by reference, for
/// those who run argmin themselves, with observers, checkpoints and methods of their choice. The Hessian is that of Gauss and
/// Newton along the rollout, exact in the squash; with [`Curvature::Exact`](crate::trajopt::Curvature::Exact) all second derivatives count (but for those of ⊕ where
/// a free first state is on a manifold).
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples};
/// use dualbody::trajopt::{Activation, Cost, InputError, Minimizer, Problem, SingleShooting, StateError, Trajectory};
///
/// let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.05);
/// let effort = Cost::new().with(1e-2, Activation::Quadratic, InputError::to_zero(&pendulum));
/// let arrive = Cost::new().with(1e1, Activation::Quadratic, StateError::to(&[1.0, 0.0]));
/// let problem = Problem::new(pendulum, 40, &[0.0, 0.0]).with_stage_cost(effort).with_final_cost(arrive);
/// let swing = SingleShooting::new(&problem).solve(Minimizer::Lbfgs, &Trajectory::resting(&problem));
/// assert!(swing.is_converged() && (swing.trajectory.states[40][0] - 1.0).abs() < 0.05);
/// ```
pub struct SingleShooting<'p, D: Dynamics> {
    problem: &'p Problem<D>,
    options: ShootingOptions,
    multiplied: Multiplied,
    /// Working memory, and what it holds: argmin asks for values and derivatives at one point after the other, behind `&self`.
    work: Mutex<Work<D>>,
}

/// The multipliers of constraints: of each stage the λ of its constraints, one after the other.
struct Multiplied {
    lambda: Vec<Vec<f64>>,
    mu: f64,
}

/// The last point, and what is known there.
struct Work<D> {
    sweep: Sweep<D>,
    z: Vec<f64>,
    /// Each input with its derivatives in its variable.
    squashed: Vec<Squashed>,
    /// ∂x₀/∂δx₀, `ndx` × `ndx`; `ndx` × 0 where the first state is given.
    start_map: DMatrix<f64>,
    known: Known,
    price: f64,
}

/// Extent to which the working memory is valid at its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Known {
    Nothing,
    Price,
    Expansion,
}

impl<'p, D: Dynamics> SingleShooting<'p, D> {
    /// The function of a problem, with default options.
    pub fn new(problem: &'p Problem<D>) -> Self {
        Self::with_options(problem, ShootingOptions::default())
    }

    /// The function of a problem.
    ///
    /// # Panics
    /// If an option is out of its range.
    pub fn with_options(problem: &'p Problem<D>, options: ShootingOptions) -> Self {
        options.check();
        let work = Work {
            sweep: Sweep::new(problem),
            z: Vec::new(),
            squashed: Vec::new(),
            start_map: DMatrix::zeros(0, 0),
            known: Known::Nothing,
            price: f64::INFINITY,
        };
        Self {
            problem,
            multiplied: Multiplied::new(problem, options.constraints.penalty),
            options,
            work: Mutex::new(work),
        }
    }

    /// The problem.
    pub fn problem(&self) -> &'p Problem<D> {
        self.problem
    }

    /// The options.
    pub fn options(&self) -> &ShootingOptions {
        &self.options
    }

    /// Number of variables.
    pub fn dim(&self) -> usize {
        self.start_dim() + self.problem.horizon() * self.problem.dynamics().nu()
    }

    /// The variables of a guess: of its inputs, taken a thousandth of their range inside their bounds, and of its first state if
    /// that is free. Its other states do not matter. Allocates.
    ///
    /// # Panics
    /// If the guess has not the shape of the problem.
    pub fn variables(&self, guess: &Trajectory) -> Vec<f64> {
        guess.check(self.problem);
        let mut z = vec![0.0; self.start_dim()];
        if !z.is_empty() {
            let (start, first) = (self.problem.start(), &guess.states[0]);
            let dynamics = self.problem.dynamics();
            dynamics.difference(start.as_slice(), first.as_slice(), &mut z);
        }
        for u in &guess.inputs {
            let squashes = self.squashes();
            z.extend(squashes.zip(u).map(|(squash, &u)| squash.invert(u)));
        }
        z
    }

    /// The trajectory of variables: it obeys the dynamics, and its inputs are within their bounds. Allocates.
    ///
    /// # Panics
    /// If there are not [`dim`](Self::dim) variables.
    pub fn trajectory(&self, z: &[f64]) -> Trajectory {
        self.at(z, Known::Price).sweep.trajectory.clone()
    }

    /// The cost, with the penalties of constraints; infinite where it, or the rollout, is not finite. One rollout.
    ///
    /// # Panics
    /// If there are not [`dim`](Self::dim) variables.
    pub fn value(&self, z: &[f64]) -> f64 {
        self.at(z, Known::Price).price
    }

    /// The exact gradient of [`value`](Self::value), by the adjoint sweep: about as much as the step Jacobians of one rollout.
    ///
    /// # Panics
    /// If there are not [`dim`](Self::dim) variables.
    pub fn gradient(&self, z: &[f64]) -> DVector<f64> {
        let mut work = self.at(z, Known::Expansion);
        let slopes = work.sweep.gradient();
        work.in_variables(&slopes)
    }

    /// The Hessian, dense, [`dim`](Self::dim) × [`dim`](Self::dim): for each column a sweep forward and one backward through the
    /// step Jacobians, so O(N²) in the horizon. Gauss–Newton or exact as [`ShootingOptions::curvature`] says, and the curvature of
    /// the squash.
    ///
    /// # Panics
    /// If there are not [`dim`](Self::dim) variables.
    pub fn hessian(&self, z: &[f64]) -> DMatrix<f64> {
        let mut work = self.at(z, Known::Expansion);
        let slopes = work.sweep.gradient();
        // Afterwards the expansion is no longer that of the costs alone.
        work.known = Known::Price;
        let curvature = self.options.curvature;
        work.sweep.complete_hessians(self.problem, curvature);
        let mut out = DMatrix::zeros(z.len(), z.len());
        for (j, mut column) in out.column_iter_mut().enumerate() {
            let moved = work.sweep.hessian_column(work.direction(j));
            column.copy_from(&work.in_variables(&moved));
        }
        let slopes = slopes.inputs.iter().flatten();
        let first = work.start_map.ncols();
        for (j, (u, slope)) in work.squashed.iter().zip(slopes).enumerate() {
            out[(first + j, first + j)] += slope * u.curvature;
        }
        out
    }

    /// Number of variables of the first state.
    fn start_dim(&self) -> usize {
        match self.problem.initial() {
            InitialState::Fixed => 0,
            InitialState::Free => self.problem.dynamics().ndx(),
        }
    }

    /// The bounds of the inputs of a stage.
    fn squashes(&self) -> impl Iterator<Item = Squash> {
        let (lower, upper) = (self.problem.input_lower(), self.problem.input_upper());
        let both = lower.iter().zip(upper);
        both.map(|(&lower, &upper)| Squash { lower, upper })
    }

    fn lock(&self) -> MutexGuard<'_, Work<D>> {
        // What a panic in a user's function left is recomputed.
        self.work.lock().unwrap_or_else(|poisoned| {
            let mut work = PoisonError::into_inner(poisoned);
            work.known = Known::Nothing;
            work
        })
    }

    /// Working memory that knows at least so much of this point.
    fn at(&self, z: &[f64], wanted: Known) -> MutexGuard<'_, Work<D>> {
        assert_eq!(z.len(), self.dim(), "as many variables as the problem has");
        let mut work = self.lock();
        if work.z != z || work.known == Known::Nothing {
            work.known = Known::Nothing;
            self.roll(z, &mut work);
            work.known = Known::Price;
        }
        if work.known < wanted {
            let curvature = self.options.curvature;
            let (delta, start) = (&z[..self.start_dim()], self.problem.start());
            work.start_map = start_jacobian(self.problem.dynamics(), start.as_slice(), delta);
            work.sweep.expand(self.problem, &self.multiplied, curvature);
            work.known = Known::Expansion;
        }
        work
    }

    /// The rollout of variables, and its price.
    fn roll(&self, z: &[f64], work: &mut Work<D>) {
        work.z.clear();
        work.z.extend_from_slice(z);
        let (delta, inputs) = z.split_at(self.start_dim());
        let dynamics = self.problem.dynamics();
        let Trajectory { states, inputs: u } = &mut work.sweep.trajectory;
        if !delta.is_empty() {
            let start = self.problem.start().as_slice();
            dynamics.integrate(start, delta, states[0].as_mut_slice());
        }
        work.squashed.clear();
        for (u, z) in u.iter_mut().zip(inputs.chunks_exact(dynamics.nu().max(1))) {
            let squashes = self.squashes().zip(z);
            let squashed = squashes.map(|(squash, &z)| squash.apply(z));
            work.squashed.extend(squashed);
            let own = &work.squashed[work.squashed.len() - u.len()..];
            u.iter_mut().zip(own).for_each(|(u, own)| *u = own.value);
        }
        work.sweep.roll(dynamics);
        let price = work.sweep.price(self.problem, &self.multiplied);
        work.price = if price.is_finite() {
            price
        } else {
            f64::INFINITY
        };
    }
}

impl Multiplied {
    fn new<D: Dynamics>(problem: &Problem<D>, mu: f64) -> Self {
        let stages = 0..=problem.horizon();
        let lambda = stages.map(|stage| no_multipliers(problem, stage));
        Self {
            lambda: lambda.collect(),
            mu,
        }
    }
}

impl<D: Dynamics> Work<D> {
    /// The chain rule from x₀ and inputs to the variables.
    fn in_variables(&self, slopes: &Slopes) -> DVector<f64> {
        let start = self.start_map.tr_mul(&slopes.start);
        let inputs = slopes.inputs.iter().flatten().zip(&self.squashed);
        let inputs = inputs.map(|(slope, u)| slope * u.slope);
        let all = start.iter().copied().chain(inputs);
        DVector::from_vec(all.collect())
    }

    /// Direction in which x₀ and the inputs move with variable `j`.
    fn direction(&self, j: usize) -> Direction<'_> {
        let (ndx, first) = self.start_map.shape();
        if j < first {
            return Direction::Start(&self.start_map.as_slice()[j * ndx..][..ndx]);
        }
        let (of, nu) = (j - first, self.sweep.trajectory.inputs[0].len());
        Direction::Input(of / nu, of % nu, self.squashed[of].slope)
    }
}

impl<D: Dynamics> fmt::Debug for SingleShooting<'_, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SingleShooting")
            .field("options", &self.options)
            .field("dim", &self.dim())
            .finish_non_exhaustive()
    }
}
