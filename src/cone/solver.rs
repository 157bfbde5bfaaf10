//! The solver: lane by lane in plain numbers, then derivatives.

use super::certificate::{Certificate, Mode, Status, mode};
use super::lane::LaneProblem;
use super::newton::Newton;
use super::problem::{BlockProblem, ConeProblem};
use super::recorded::Recorded;
use super::search::Search;
use super::smoothed::Smoothed;
use super::sticking::{Guess, MOST_TOGETHER};
use super::transposed::Transposed;
use crate::scalar::{Scalar, is_more_than_values};

/// Tikhonov regularisation of a problem without solution, relative to its diagonal. Bilateral rows that contradict each other then share the error,
/// and the inverse of this value bounds the ratio of their forces to consistent ones.
pub const REGULARIZATION: f64 = 1e-4;

/// Tolerance that a first guess meets: its error is rounding.
const ROUNDING: f64 = 1e-12;
/// Of a first guess that is the solution.
const GUESSED: Certificate = Certificate {
    status: Status::Converged,
    iterations: 1,
    residual: 0.0,
    cone_violation: 0.0,
    complementarity: 0.0,
    dual_violation: 0.0,
};

/// Options of a [`ConeSolver`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConeOptions {
    /// Largest residual, scaled as in [`Certificate`]; default 1e-12. A larger tolerance saves at most one step, because each of the last steps gains
    /// many digits.
    pub tolerance: f64,
    /// Maximum number of matrix factorisations for one lane; default 200. With fewer, a hard problem may end with the best forces so far and
    /// [`Status::IterationLimit`].
    pub iterations: usize,
    /// Residual at which a long search ends, with [`Status::Acceptable`]; default 0 (never). If many contacts press against each other, for example
    /// those of a robot that lies on the ground, the last digits of the forces converge slowly when the motion has already converged. A larger value
    /// ends more of these searches early. It has no effect on problems with bilateral rows.
    pub acceptable: f64,
    /// κ of the smoothed law, in units of force times velocity; default 0, the exact law. With a larger κ, forces begin earlier before contact and
    /// friction sets in more smoothly. Smoothed forces exist only if some velocity opens all contacts at once, or R > 0: a body squeezed between two
    /// others needs R > 0.
    pub smoothing: f64,
    /// Laws that κ smooths; by default all (bilateral rows need no smoothing).
    pub smoothed: Smoothed,
    /// Whether modes, and the certificate beyond status and iterations, are computed.
    pub(crate) measured: bool,
}

impl Default for ConeOptions {
    fn default() -> Self {
        Self {
            tolerance: 1e-12,
            iterations: 200,
            acceptable: 0.0,
            smoothing: 0.0,
            smoothed: Smoothed::All,
            measured: true,
        }
    }
}

impl ConeOptions {
    /// Returns the options with smoothing κ.
    ///
    /// # Panics
    /// If it is negative or not finite.
    #[must_use]
    pub fn with_smoothing(mut self, kappa: f64) -> Self {
        assert!(
            kappa >= 0.0 && kappa.is_finite(),
            "the smoothing κ is {kappa}: negative or not finite"
        );
        self.smoothing = kappa;
        self
    }
}

/// Solves [`ConeProblem`]s. Its working memory grows to the size of the largest problem and is reused.
///
/// # Examples
/// ```
/// use dualbody::cone::{Block, ConeProblem, ConeSolver, Law, Mode};
///
/// // A particle of 1 kg, μ = 0.5, slides over ground at 3 m/s while it lands at 1 m/s.
/// let problem = ConeProblem {
///     law: Law::Coulomb,
///     blocks: &[Block::Cone],
///     friction: &[0.5],
///     matrix: &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
///     regularization: &[0.0; 3],
///     free_velocity: &[-1.0, 3.0, 0.0],
/// };
/// let (mut solver, mut f) = (ConeSolver::new(3, 1), [0.0; 3]);
/// assert!(solver.solve(&problem, &mut f).is_converged());
/// assert_eq!((f, solver.modes()), ([1.0, -0.5, 0.0], &[Mode::Sliding][..]));
/// ```
#[derive(Clone, Debug)]
pub struct ConeSolver<T: Scalar = f64> {
    /// Options of the solver.
    pub options: ConeOptions,
    pub(super) search: Search,
    /// Of several lanes, the one at hand.
    lane: LaneProblem,
    guess: Guess<f64>,
    /// Of several lanes, all at once.
    guesses: Guess<T>,
    /// For numbers without values.
    recorded: Recorded<T>,
    pub(super) blocks: usize,
    modes: Vec<Mode>,
    /// Status of the last solution in each lane.
    statuses: Vec<Status>,
    pub(super) y: Vec<T>,
    pub(super) e: Vec<T>,
    /// Working memory of [`respond_transposed`](Self::respond_transposed).
    pub(super) transposed: Transposed<T>,
}

impl<T: Scalar> ConeSolver<T> {
    /// Makes a solver with memory for the given numbers of rows and blocks; larger problems allocate once.
    pub fn new(rows: usize, blocks: usize) -> Self {
        let mut solver = Self {
            options: ConeOptions::default(),
            search: Search::default(),
            lane: LaneProblem::default(),
            guess: Guess::new(),
            guesses: Guess::new(),
            recorded: Recorded::default(),
            blocks: 0,
            modes: Vec::with_capacity(blocks * T::LANES),
            statuses: Vec::with_capacity(T::LANES),
            y: vec![T::zero(); rows],
            e: vec![T::zero(); rows],
            transposed: Transposed::new(rows),
        };
        solver.search.reserve(rows);
        solver.guess.reserve(rows);
        if T::LANES > 1 {
            solver.lane.reserve(rows);
            solver.guesses.reserve(rows);
        }
        solver
    }

    /// Returns the solver with other options.
    #[must_use]
    pub fn with_options(mut self, options: ConeOptions) -> Self {
        self.options = options;
        self
    }

    /// Solves a problem in `f64`, lane by lane, and differentiates the solution.
    ///
    /// Costs O(n³) per step, without allocation. It takes no step from the solution itself, one where contacts that approach stick, a few from forces nearby, a few tens by proximal steps or
    /// the path, and hundreds for the rare Coulomb problem that is solved as a sequence of convex ones.
    ///
    /// * `f` – on entry the initial values, such as the forces of the last time step, or zeros; on return the forces, length n
    ///
    /// Differentiable in G, R, g, μ and bounds on each piece of the laws; between pieces, derivatives are those of one side, and finite. If rows are
    /// redundant, the forces are one of many solutions, near the one with the least change from the start, and derivatives are those of least norm.
    /// The values of `f` are bit-identical for all scalars that can represent them. For other scalar types, everything except the value passes only
    /// through the last step of the solution, which is linear in it.
    ///
    /// For [traced](crate::scalar::traced) numbers a fixed number of steps along the path is recorded; convergence is a condition of the graph.
    ///
    /// # Panics
    /// If a length is wrong, friction or a bound is negative, or a scalar has both lanes and derivatives. For traced numbers also if cones have
    /// Coulomb's law, or are smoothed while rays or intervals are not.
    pub fn solve(&mut self, problem: &ConeProblem<'_, T>, f: &mut [T]) -> Certificate {
        assert!(
            T::LANES == 1 || T::ORDER == 0,
            "lanes or derivatives, not both"
        );
        problem.check(f);
        self.blocks = problem.blocks.len();
        self.modes.clear();
        self.statuses.clear();
        self.y.resize(f.len(), T::zero());
        self.e.resize(f.len(), T::zero());
        let mut certificate = Certificate::default();
        // A constant, so that code that is not called is not compiled.
        if const { !T::HAS_VALUES } {
            self.statuses.push(certificate.status);
            self.recorded.solve(problem, self.options.smoothing, f);
            return certificate;
        }
        let guessed = self.guess_together(problem, f);
        for lane in 0..T::LANES {
            let own = match guessed {
                Some(found) if found.value(lane) > 0.0 => GUESSED,
                _ => self.solve_lane(problem, f, lane, guessed.is_none()),
            };
            self.statuses.push(own.status);
            certificate = certificate.worse(own);
        }
        if is_more_than_values::<T>() && certificate.status != Status::NotFinite {
            self.differentiate(problem, f);
        }
        certificate
    }

    /// The mode of each block in the last solution, lane by lane.
    pub fn modes(&self) -> &[Mode] {
        &self.modes
    }

    /// Status of the last solution in each lane.
    pub(crate) fn statuses(&self) -> &[Status] {
        &self.statuses
    }

    /// Whether a first guess counts as a solution: it is exact but for rounding.
    fn may_guess(&self) -> bool {
        let ConeOptions {
            smoothing,
            tolerance,
            iterations,
            ..
        } = self.options;
        smoothing == 0.0 && tolerance >= ROUNDING && iterations > 0
    }

    /// Makes a first guess in all lanes at once, and takes over what it has found. Returns 1 in lanes in which that is the solution, 0 in others; `None` if
    /// each lane makes its own guess.
    fn guess_together(&mut self, problem: &ConeProblem<'_, T>, f: &mut [T]) -> Option<T> {
        if const { T::LANES == 1 } {
            return None;
        }
        let is_exact = T::constant(1.0 + f64::EPSILON).value(0) > 1.0;
        let may = f.len() <= MOST_TOGETHER && is_exact && self.may_guess();
        if !may || self.options.measured {
            return None;
        }
        let found = self.guesses.solve(problem, f, |x| *x);
        for (f, &own) in f.iter_mut().zip(&self.guesses.f) {
            *f = T::zero().select_lt(found, own, *f);
        }
        Some(found)
    }

    fn solve_lane(
        &mut self,
        problem: &ConeProblem<'_, T>,
        f: &mut [T],
        lane: usize,
        guesses: bool,
    ) -> Certificate {
        if const { T::LANES > 1 } {
            self.lane.read(problem, f, lane);
        }
        let (certificate, is_found) = match guesses && self.guess_lane(problem, f) {
            true => (self.accept_guess(problem, f), true),
            false => (self.search_lane(problem, f), false),
        };
        if T::LANES > 1 {
            f.iter_mut().for_each(|f| set_lane(f, lane, 0.0));
        }
        let Newton {
            f: forces, system, ..
        } = &self.search.newton;
        for k in 0..forces.len() {
            let row = if T::LANES > 1 { self.lane.rows[k] } else { k };
            let force = if is_found {
                self.guess.f[k]
            } else {
                forces[k] * system.scale[k]
            };
            set_lane(&mut f[row], lane, force);
        }
        if self.options.measured {
            self.find_modes();
        }
        certificate
    }

    /// Makes a first guess. Returns whether it is the solution.
    fn guess_lane(&mut self, problem: &ConeProblem<'_, T>, f: &[T]) -> bool {
        let found = match const { T::LANES > 1 } {
            _ if !self.may_guess() => 0.0,
            true => (self.guess).solve(&self.lane.problem(), &self.lane.forces, |x| *x),
            false => self.guess.solve(problem, f, |x| x.value(0)),
        };
        found > 0.0
    }

    /// Reads the problem that has been guessed, for derivatives and modes.
    fn accept_guess(&mut self, problem: &ConeProblem<'_, T>, f: &[T]) -> Certificate {
        self.read_problem(problem, f);
        let Newton { f, system, .. } = &mut self.search.newton;
        for k in 0..f.len() {
            f[k] = self.guess.f[k] / system.scale[k];
        }
        self.search.adopt(&self.options, 0.0);
        let measured = self.options.measured;
        let measured = measured.then(|| self.search.measure_unregularized());
        Certificate {
            iterations: GUESSED.iterations,
            ..measured.unwrap_or(GUESSED)
        }
    }

    /// Reads the lane at hand into the solver. `false` if a number is not finite.
    fn read_problem(&mut self, problem: &ConeProblem<'_, T>, f: &[T]) -> bool {
        match const { T::LANES > 1 } {
            true => (self.search).start(&self.lane.problem(), &self.lane.forces, 0),
            false => self.search.start(problem, f, 0),
        }
    }

    /// Solves the problem at hand.
    fn search_lane(&mut self, problem: &ConeProblem<'_, T>, f: &[T]) -> Certificate {
        let finite = self.read_problem(problem, f);
        let mut certificate = Certificate::default();
        if finite {
            certificate = self.search.run(&self.options);
        }
        if !finite || !self.search.is_finite() {
            certificate = self.search.give_up();
        }
        certificate
    }

    /// Solves a problem with blocks: with memory and time that grow with the blocks and those that fill, not with the square of the rows.
    /// Not smoothed.
    ///
    /// * `f` – on entry the forces to start from
    pub(crate) fn solve_blocks(
        &mut self,
        problem: &BlockProblem<'_>,
        f: &mut [f64],
    ) -> Certificate {
        self.blocks = problem.blocks.len();
        self.modes.clear();
        self.statuses.clear();
        let finite = self.search.start_blocks(problem, f);
        let mut certificate = Certificate::default();
        if finite {
            certificate = self.search.run(&self.options);
        }
        if !finite || !self.search.is_finite() {
            certificate = self.search.give_up();
        }
        let newton = &self.search.newton;
        let forces = newton.f.iter().zip(&newton.system.scale);
        f.iter_mut()
            .zip(forces)
            .for_each(|(f, (force, scale))| *f = force * scale);
        if self.options.measured {
            self.find_modes();
        }
        self.statuses.push(certificate.status);
        certificate
    }

    /// Regularisation that the last solution added to the scaled diagonal.
    pub(crate) fn added_regularization(&self) -> f64 {
        self.search.regularization
    }

    /// Takes forces that were found elsewhere for those of the last solution, and adds the derivatives of the problem.
    ///
    /// * `added` – regularisation that was added there
    pub(crate) fn adopt(&mut self, problem: &ConeProblem<'_, T>, added: f64, f: &mut [T]) {
        self.blocks = problem.blocks.len();
        self.y.resize(f.len(), T::zero());
        self.e.resize(f.len(), T::zero());
        let finite = self.search.start(problem, f, 0);
        if !finite {
            self.search.give_up();
            return;
        }
        self.search.adopt(&self.options, added);
        if is_more_than_values::<T>() {
            self.differentiate(problem, f);
        }
    }

    /// Of lanes, blocks that take no part are separated.
    fn find_modes(&mut self) {
        let (first, newton) = (self.modes.len(), &self.search.newton);
        let is_one = T::LANES == 1;
        let rest = if is_one {
            Mode::Bilateral
        } else {
            Mode::Separated
        };
        self.modes.resize(first + self.blocks, rest);
        for (unit, own) in newton.system.units.iter().zip(&newton.equations) {
            let block = if is_one || newton.has_blocks {
                unit.block
            } else {
                self.lane.blocks[unit.block]
            };
            self.modes[first + block] = mode(newton, unit, own);
        }
    }
}

/// Sets the value of a lane.
fn set_lane<T: Scalar>(x: &mut T, lane: usize, value: f64) {
    let others = *x;
    *x = T::from_values(|l| if l == lane { value } else { others.value(l) });
}
