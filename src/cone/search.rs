//! From any start to the forces of one lane.

use super::Law;
use super::certificate::{Certificate, Status, measure, project, shortened};
use super::descent::Descent;
use super::interior::{Interior, PathTarget};
use super::interval::clamped;
use super::newton::Newton;
use super::system::{Kind, of_unit};
use super::{ConeOptions, ConeProblem, REGULARIZATION};
use crate::scalar::Scalar;

/// Steps of Newton's method from a guess: an active set that has not settled by then goes in circles.
const NEWTON_STEPS: usize = 8;
/// Matrices by blocks, which cost little, for one of those that are allowed.
const BY_BLOCKS: usize = 3;
/// The part of the iterations after which a problem is taken for one without solution.
const ITERATION_SHARE: f64 = 0.7;
/// Steps of Newton's method from a place on the path, where the active set is nearly right.
const MORE_NEWTON_STEPS: usize = 25;
/// Point of the path, as κ beside the size of the problem squared, at which the active set is tried: too early, it is not yet the right one, too
/// late, the path's matrices have lost their digits. The last ones are for contacts that slip slowly beside the fastest one: the path knows
/// them from sticking ones once κ is smaller than the slip squared.
const PATH_TARGETS: [f64; 6] = [1e-4, 1e-7, 1e-10, 1e-13, 1e-16, 1e-19];
/// Convex problems in a row on the way to Coulomb's law; each is nearer by a factor that friction and geometry set.
const FIXED_POINT_STEPS: usize = 30;
/// Proximal steps, each of which gains a factor of about the smallest eigenvalue over the regularisation; without this gain there is nothing to be
/// found.
const PROXIMAL_STEPS: usize = 15;
const PROXIMAL_GAIN: f64 = 0.7;
/// The residual that is good enough where redundant forces drift instead of settling.
const ACCEPTABLE: f64 = 1e-9;

/// One lane of a problem and all that its solution needs.
#[derive(Clone, Debug, Default)]
pub(super) struct Search {
    pub(super) newton: Newton,
    interior: Interior,
    pub(super) descent: Descent,
    /// Tikhonov regularisation that was added to the diagonal of W′.
    pub(super) regularization: f64,
    /// Forces of the regularised problem.
    regularized: Vec<f64>,
    g: Vec<f64>,
    /// Matrices that may be factorised.
    pub(super) allowed: usize,
    /// The residual at which a search that takes long may end.
    pub(super) acceptable: f64,
}

impl Search {
    /// Makes room for so many rows, without touching it: most problems are smaller.
    pub(super) fn reserve(&mut self, rows: usize) {
        self.newton.reserve(rows);
        self.interior.reserve(rows);
        self.regularized.reserve(rows);
        self.g.reserve(rows);
    }

    /// Reads one lane of a problem and the forces to start from. `false` if a number is not finite.
    pub(super) fn start<T: Scalar>(
        &mut self,
        problem: &ConeProblem<'_, T>,
        f: &[T],
        lane: usize,
    ) -> bool {
        self.allowed = usize::MAX;
        let newton = &mut self.newton;
        newton.has_blocks = false;
        let finite = newton.system.load(problem, lane);
        newton.reset();
        for (i, f) in f.iter().enumerate() {
            newton.f[i] = f.value(lane) / newton.system.scale[i];
        }
        finite && newton.f.iter().all(|f| f.is_finite())
    }

    /// Takes the forces there are for those of a solution, with a regularisation that was added.
    pub(super) fn adopt(&mut self, options: &ConeOptions, regularization: f64) {
        self.regularization = regularization;
        self.newton.kappa = options.smoothing;
        self.newton.smoothed = options.smoothed;
        self.add_to_diagonal(regularization);
        self.newton.evaluate();
    }

    /// Whether the forces are finite, also in the units of the problem.
    pub(super) fn is_finite(&self) -> bool {
        let newton = &self.newton;
        let mut forces = newton.f.iter().zip(&newton.system.scale);
        forces.all(|(f, scale)| (f * scale).is_finite())
    }

    /// An empty problem in place of one that is not finite.
    pub(super) fn give_up(&mut self) -> Certificate {
        self.newton.system.blank();
        self.newton.blocks.blank();
        self.newton.reset();
        self.newton.evaluate();
        self.regularization = 0.0;
        Certificate {
            status: Status::NotFinite,
            ..Certificate::default()
        }
    }

    /// Solves the system in `newton` from the forces there.
    pub(super) fn run(&mut self, options: &ConeOptions) -> Certificate {
        self.newton.kappa = options.smoothing;
        self.newton.smoothed = options.smoothed;
        self.regularization = 0.0;
        self.interior.steps = 0;
        let status = self.find_or_regularize(options);
        self.clip_to_cones();
        let mut certificate = Certificate::default();
        if options.measured {
            certificate = self.measure_unregularized();
        }
        Certificate {
            status,
            iterations: self.iterations(),
            ..certificate
        }
    }

    fn find_or_regularize(&mut self, options: &ConeOptions) -> Status {
        let tolerance = options.tolerance;
        self.acceptable = options.acceptable;
        let most = match self.newton.has_blocks {
            true => BY_BLOCKS * options.iterations,
            false => options.iterations,
        };
        self.allowed = (ITERATION_SHARE * most as f64).ceil() as usize;
        if self.find(tolerance) {
            return Status::Converged;
        }
        if self.is_near() {
            let acceptable = self.is_acceptable();
            self.newton.take_best();
            return if acceptable {
                Status::Acceptable
            } else {
                Status::IterationLimit
            };
        }
        self.allowed = most;
        self.start_regularized();
        if !self.find(tolerance) {
            self.newton.take_best();
            return Status::IterationLimit;
        }
        if self.refine_proximally(tolerance) {
            Status::Converged
        } else {
            Status::Regularized
        }
    }

    /// Matrices factorised so far.
    pub(super) fn iterations(&self) -> usize {
        self.newton.steps + self.interior.steps
    }

    /// Takes at most so many steps of Newton's method, and as many as are left.
    pub(super) fn solve_active_set(&mut self, steps: usize, tolerance: f64) -> bool {
        let left = self.allowed.saturating_sub(self.iterations());
        self.newton.solve(steps.min(left), tolerance)
    }

    /// Follows the path of a system as long as matrices are left.
    fn follow(&mut self, kappa: f64, relative: f64) -> bool {
        let left = self.allowed.saturating_sub(self.iterations());
        let newton = &mut self.newton;
        self.interior.follow(
            &newton.system,
            &mut newton.lu,
            PathTarget { kappa, relative },
            left,
        )
    }

    /// Goes from the forces of the regularised problem to those of the problem itself, by proximal steps: each puts the regularisation about the
    /// last forces. `false`, with the regularised forces, if that does not lead there.
    fn refine_proximally(&mut self, tolerance: f64) -> bool {
        self.regularized.clone_from(&self.newton.f);
        self.g.clone_from(&self.newton.system.g);
        let mut residual = f64::INFINITY;
        for _ in 0..PROXIMAL_STEPS {
            let newton = &mut self.newton;
            for ((g, free), f) in newton.system.g.iter_mut().zip(&self.g).zip(&newton.f) {
                *g = free - REGULARIZATION * f;
            }
            let found = self.solve_active_set(MORE_NEWTON_STEPS, tolerance);
            let newton = &mut self.newton;
            newton.system.g.copy_from_slice(&self.g);
            self.add_to_diagonal(-REGULARIZATION);
            let last = residual;
            residual = self.newton.evaluate();
            let done = !found || residual > PROXIMAL_GAIN * last || residual <= tolerance;
            if done && residual <= tolerance.max(ACCEPTABLE) {
                self.regularization = 0.0;
                return true;
            }
            self.add_to_diagonal(REGULARIZATION);
            if done {
                break;
            }
        }
        self.newton.f.copy_from_slice(&self.regularized);
        self.newton.evaluate();
        false
    }

    fn find(&mut self, tolerance: f64) -> bool {
        self.newton.regularized = false;
        if self.newton.has_blocks {
            return self.by_descent(tolerance);
        }
        if self.may_start_here() && self.solve_active_set(NEWTON_STEPS, tolerance) {
            return true;
        }
        if self.newton.kappa == 0.0 && self.by_proximal_steps(tolerance) {
            return true;
        }
        if self.is_near() {
            return false;
        }
        self.newton.regularized = true;
        self.along_the_path(tolerance)
            || (self.newton.system.law == Law::Coulomb && self.by_convex_problems(tolerance))
    }

    /// On the central path, Newton's method only works from inside the cones.
    fn may_start_here(&self) -> bool {
        let newton = &self.newton;
        let mut units = newton.system.units.iter();
        newton.kappa == 0.0
            || units.all(|unit| match unit.kind {
                Kind::Row | Kind::Spin | Kind::Roll => true,
                Kind::Interval => newton.f[unit.row].abs() < unit.mu,
                Kind::Ray | Kind::Cone => newton.f[unit.row] > 0.0,
            })
    }

    fn along_the_path(&mut self, tolerance: f64) -> bool {
        self.interior.g.clone_from(&self.newton.system.g);
        let system = &self.newton.system;
        self.interior
            .start(system, system.law, self.newton.size_of_problem());
        self.follow_and_solve(tolerance)
    }

    fn follow_and_solve(&mut self, tolerance: f64) -> bool {
        let kappa = self.newton.kappa;
        for target in PATH_TARGETS {
            let target = if kappa > 0.0 { 0.0 } else { target };
            let followed = self.follow(kappa, target);
            self.newton.f.copy_from_slice(&self.interior.f);
            if self.solve_active_set(MORE_NEWTON_STEPS, tolerance) {
                return true;
            }
            if !followed {
                return false;
            }
        }
        false
    }

    /// Coulomb's law as a fixed point: the convex law with the normal velocity raised by μ ‖yₜ‖ of the last solution.
    /// [Acary, Cadoux, Lemaréchal, Malick 2011]
    fn by_convex_problems(&mut self, tolerance: f64) -> bool {
        self.interior.g.clone_from(&self.newton.system.g);
        for _ in 0..FIXED_POINT_STEPS {
            let newton = &mut self.newton;
            self.interior
                .start(&newton.system, Law::Convex, newton.size_of_problem());
            let kappa = newton.kappa;
            if !self.follow(kappa, PATH_TARGETS[2]) {
                return false;
            }
            let newton = &mut self.newton;
            newton.f.copy_from_slice(&self.interior.f);
            newton.evaluate();
            for unit in newton
                .system
                .units
                .iter()
                .filter(|unit| unit.kind == Kind::Cone)
            {
                let y = of_unit(&newton.y, unit);
                self.interior.g[unit.row] = newton.system.g[unit.row] + unit.mu * y[1].hypot(y[2]);
            }
            if self.solve_active_set(MORE_NEWTON_STEPS, tolerance) {
                return true;
            }
        }
        false
    }

    /// Starts again with Tikhonov regularisation on the diagonal.
    fn start_regularized(&mut self) {
        self.add_to_diagonal(REGULARIZATION);
        self.regularization = REGULARIZATION;
        let steps = self.newton.steps;
        self.newton.reset();
        self.newton.steps = steps;
    }

    pub(super) fn add_to_diagonal(&mut self, x: f64) {
        if self.newton.has_blocks {
            let all = self.newton.blocks.diagonal.iter_mut();
            return all.for_each(|r| *r += x);
        }
        let system = &mut self.newton.system;
        for i in 0..system.n {
            system.w[i * system.n + i] += x;
        }
    }

    /// Puts forces that rounding left outside their cones on the surface.
    fn clip_to_cones(&mut self) {
        let newton = &mut self.newton;
        let mut clipped = false;
        for unit in &newton.system.units {
            let f = of_unit(&newton.f, unit);
            let inside = match unit.kind {
                Kind::Row => continue,
                Kind::Ray => [f[0].max(0.0), 0.0, 0.0],
                Kind::Interval => [clamped(f[0], unit.mu), 0.0, 0.0],
                Kind::Cone => project(f, unit.mu),
                Kind::Spin | Kind::Roll => {
                    let bounded = newton.system.bounded(unit, &newton.f);
                    shortened(f, bounded.map_or(0.0, |unit| unit.mu))
                }
            };
            clipped |= inside != f;
            newton.f[unit.row..unit.row + unit.rows()].copy_from_slice(&inside[..unit.rows()]);
        }
        if clipped {
            newton.evaluate();
        }
    }

    pub(super) fn measure_unregularized(&mut self) -> Certificate {
        if self.regularization == 0.0 {
            return measure(&self.newton);
        }
        self.add_to_diagonal(-self.regularization);
        self.newton.evaluate();
        let certificate = measure(&self.newton);
        self.add_to_diagonal(self.regularization);
        self.newton.evaluate();
        certificate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cone::Block;

    const TOLERANCE: f64 = 1e-12;

    /// Two contacts, just read, and their forces.
    fn search_and_forces(law: Law) -> (Search, Vec<f64>) {
        let entry = |i: usize, k: usize| (((i + 1) * (k + 1)) as f64).sin();
        let product = |i, j| (0..9).map(|k| entry(i, k) * entry(j, k)).sum();
        let matrix: Vec<f64> = (0..36).map(|at| product(at % 6, at / 6)).collect();
        let problem = ConeProblem {
            law,
            blocks: &[Block::Cone; 2],
            friction: &[0.6, 0.3],
            matrix: &matrix,
            regularization: &[0.0; 6],
            free_velocity: &[-1.0, 0.1, 0.2, -0.5, 2.0, 1.0],
        };
        let mut search = Search::default();
        assert!(search.start(&problem, &[0.0; 6], 0));
        assert!(search.newton.solve(NEWTON_STEPS, TOLERANCE));
        let forces = search.newton.f.clone();
        assert!(search.start(&problem, &[0.0; 6], 0));
        (search, forces)
    }

    fn assert_near(actual: &[f64], expected: &[f64]) {
        for (a, e) in actual.iter().zip(expected) {
            assert!((a - e).abs() < 1e-9, "{actual:?}, not {expected:?}");
        }
    }

    #[test]
    fn proximal_steps_lead_from_regularized_forces_to_the_exact_ones() {
        for law in [Law::Convex, Law::Coulomb] {
            let (mut search, forces) = search_and_forces(law);
            search.start_regularized();
            assert!(search.find(TOLERANCE));
            let regularized = search.newton.f.clone();
            assert!(
                regularized
                    .iter()
                    .zip(&forces)
                    .any(|(a, b)| (a - b).abs() > 1e-6)
            );
            assert!(search.refine_proximally(TOLERANCE));
            assert_near(&search.newton.f, &forces);
        }
    }

    // Derivatives are taken at the forces that were evaluated last, whether or not their residual was computed.
    #[test]
    fn regularized_forces_leave_their_own_velocities_also_unmeasured() {
        let problem = ConeProblem {
            law: Law::Coulomb,
            blocks: &[Block::Free(1); 2],
            friction: &[0.0; 2],
            matrix: &[1.0; 4],
            regularization: &[0.0; 2],
            free_velocity: &[1.0, -2.0],
        };
        let options = ConeOptions {
            measured: false,
            ..ConeOptions::default()
        };
        let mut search = Search::default();
        assert!(search.start(&problem, &[0.0; 2], 0));
        assert_eq!(search.run(&options).status, Status::Regularized);
        let (newton, mut y) = (&search.newton, vec![0.0; 2]);
        newton
            .system
            .velocities(&newton.f, &newton.system.g, &mut y);
        assert_eq!(newton.y, y);
    }

    #[test]
    fn path_leads_to_the_forces_that_newtons_method_finds() {
        for law in [Law::Convex, Law::Coulomb] {
            let (mut search, forces) = search_and_forces(law);
            assert!(search.along_the_path(TOLERANCE));
            assert_near(&search.newton.f, &forces);
        }
    }

    // With a tolerance of zero Newton's method does not end the row early, and the forces at its end are those of the path.
    #[test]
    fn convex_problems_in_a_row_lead_to_coulombs_forces() {
        let (mut search, forces) = search_and_forces(Law::Coulomb);
        search.by_convex_problems(0.0);
        for (a, e) in search.interior.f.iter().zip(&forces) {
            assert!(
                (a - e).abs() < 1e-3,
                "{:?}, not {forces:?}",
                search.interior.f
            );
        }
    }
}
