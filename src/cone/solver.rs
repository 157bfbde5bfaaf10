//! The solver: lane by lane in plain numbers, then derivatives.

use super::certificate::{Certificate, Mode, Status, mode};
use super::problem::{BlockProblem, ConeProblem};
use super::recorded::Recorded;
use super::search::Search;
use super::smoothed::Smoothed;
use super::transposed::Transposed;
use crate::scalar::{Scalar, is_more_than_values};

/// Tikhonov regularisation of a problem without solution, relative to its diagonal: bilateral rows that contradict each other then share
/// the contradiction with forces at most so many times stronger than consistent ones.
pub const REGULARIZATION: f64 = 1e-4;

/// Options of a [`ConeSolver`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConeOptions {
    /// Largest residual, scaled as in [`Certificate`]; default 1e-12. A larger one saves at most a step, as the last steps gain many digits each.
    pub tolerance: f64,
    /// Most matrices that are factorised for one lane; default 200. With fewer a problem that is hard to solve may end with the best forces
    /// so far, and [`Status::IterationLimit`].
    pub iterations: usize,
    /// Residual that is taken from a search that goes on for long, with [`Status::Acceptable`]; default 0, none. Where many contacts press
    /// against each other, as those of a robot that lies, forces drift towards their last digits while the motion has long been found. A
    /// larger one ends more of these searches early. Problems with bilateral rows are not concerned.
    pub acceptable: f64,
    /// κ of the smoothed law, in units of force times velocity; default 0, the exact law. A larger one makes forces reach farther ahead of
    /// the contact and friction set in more softly. Smoothed forces exist only where some velocity opens all contacts at once, or R > 0: a
    /// body squeezed between two others needs R.
    pub smoothing: f64,
    /// Laws that κ smooths; default all but bilateral rows, which have nothing to smooth.
    pub smoothed: Smoothed,
    /// Whether modes, and of the certificate more than the status and the iterations, are asked for.
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
    /// These options with a κ.
    ///
    /// # Panics
    /// If it is negative or not finite.
    #[must_use]
    pub fn with_smoothing(mut self, kappa: f64) -> Self {
        assert!(
            kappa >= 0.0 && kappa.is_finite(),
            "κ is not negative: {kappa}"
        );
        self.smoothing = kappa;
        self
    }

    /// These options with a say in what κ smooths.
    #[must_use]
    pub fn with_smoothed(mut self, smoothed: Smoothed) -> Self {
        self.smoothed = smoothed;
        self
    }
}

/// Solves [`ConeProblem`]s; owns all working memory, which grows to the largest problem seen and then stays.
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
    /// Working memory for problems of so many rows and blocks; larger ones will allocate once.
    pub fn new(rows: usize, blocks: usize) -> Self {
        let mut solver = Self {
            options: ConeOptions::default(),
            search: Search::default(),
            recorded: Recorded::default(),
            blocks: 0,
            modes: Vec::with_capacity(blocks * T::LANES),
            statuses: Vec::with_capacity(T::LANES),
            y: vec![T::zero(); rows],
            e: vec![T::zero(); rows],
            transposed: Transposed::new(rows),
        };
        solver.search.reserve(rows);
        solver
    }

    /// This solver with other options.
    #[must_use]
    pub fn with_options(mut self, options: ConeOptions) -> Self {
        self.options = options;
        self
    }

    /// Solves a problem, in f64 lane by lane, and differentiates the solution.
    ///
    /// Costs O(n³) a step, without allocation: none from the solution itself, a few from forces nearby, some tens by proximal steps or the
    /// path, and hundreds for the rare problem of Coulomb's law that is solved as a row of convex ones.
    ///
    /// * `f` – on entry the values to start from, such as the forces of the last time step, or zeros; on return the forces, length n
    ///
    /// Differentiable in G, R, g, μ and bounds on each piece of the laws; between pieces, derivatives are those of one side, and finite. Where rows are
    /// redundant, the forces are one of many solutions, near the one with least change from the start, and derivatives those of least size.
    /// The values of `f` have the same bits for every scalar that can hold them. What a scalar of another kind holds besides its value goes
    /// through the last step of the solution alone, which is linear in it.
    ///
    /// For [traced](crate::scalar::traced) numbers a fixed number of steps along the path is recorded, and whether they have led to the forces is a
    /// condition of the graph.
    ///
    /// # Panics
    /// If a length is wrong, friction or a bound negative, or a scalar has both lanes and derivatives; of traced numbers, if cones obey Coulomb's law, or are
    /// smoothed beside rays or intervals that are not.
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
        // A constant: what is not called is not compiled.
        if const { !T::HAS_VALUES } {
            self.statuses.push(certificate.status);
            self.recorded.solve(problem, self.options.smoothing, f);
            return certificate;
        }
        for lane in 0..T::LANES {
            let own = self.solve_lane(problem, f, lane);
            self.statuses.push(own.status);
            certificate = certificate.worse(own);
        }
        if is_more_than_values::<T>() && certificate.status != Status::NotFinite {
            self.differentiate(problem, f);
        }
        certificate
    }

    /// The mode of every block in the last solution, all those of the first lane first.
    pub fn modes(&self) -> &[Mode] {
        &self.modes
    }

    /// Status of the last solution in each lane.
    pub(crate) fn statuses(&self) -> &[Status] {
        &self.statuses
    }

    fn solve_lane(
        &mut self,
        problem: &ConeProblem<'_, T>,
        f: &mut [T],
        lane: usize,
    ) -> Certificate {
        let finite = self.search.start(problem, f, lane);
        let mut certificate = Certificate::default();
        if finite {
            certificate = self.search.run(&self.options);
        }
        if !finite || !self.search.is_finite() {
            certificate = self.search.give_up();
        }
        let newton = &self.search.newton;
        for (f, (force, scale)) in f.iter_mut().zip(newton.f.iter().zip(&newton.system.scale)) {
            let others = *f;
            let value = |l| {
                if l == lane {
                    force * scale
                } else {
                    others.value(l)
                }
            };
            *f = T::from_values(value);
        }
        if self.options.measured {
            self.find_modes();
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

    /// Takes forces that were found by blocks for those of the last solution, and gives them what the problem has besides values.
    pub(crate) fn adopt(&mut self, problem: &ConeProblem<'_, T>, f: &mut [T]) {
        let regularization = self.search.regularization;
        self.y.resize(f.len(), T::zero());
        self.e.resize(f.len(), T::zero());
        self.search.start(problem, f, 0);
        self.search.adopt(regularization);
        if is_more_than_values::<T>() {
            self.differentiate(problem, f);
        }
    }

    fn find_modes(&mut self) {
        let (first, newton) = (self.modes.len(), &self.search.newton);
        self.modes.resize(first + self.blocks, Mode::Bilateral);
        for (unit, own) in newton.system.units.iter().zip(&newton.equations) {
            self.modes[first + unit.block] = mode(newton, unit, own);
        }
    }
}
