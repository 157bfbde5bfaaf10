//! The search for the forces of a problem with blocks, which may be many.
//!
//! Proximal steps are quickest, and lead farthest. Where they do not arrive, or rows have compliance, descents lead to where the active set is nearly right,
//! and proximal steps from there to the last digits.

use super::blocks::Blocks;
use super::newton::Newton;
use super::search::Search;
use super::system::{REGULARIZED_ABOVE, System, find_scale, read};
use super::{BlockProblem, Law};

/// ρ of the first descent, beside a diagonal of 1, and the least one.
const FIRST_RHO: f64 = 1e-3;
const LEAST_RHO: f64 = 1e-7;
/// Factor of ρ after a descent of few steps, and how many are few.
const EASED: f64 = 0.1;
const EASY: usize = 4;
/// The part of the last residual to which a descent goes.
const INEXACT: f64 = 0.1;
/// The residual below which the active set is tried, and ρ of the first proximal step then.
const EXACT_BELOW: f64 = 1e-6;
const LAST_RHO: f64 = 1e-6;

impl System {
    /// Reads a problem with blocks, whose X and R stay beside the system. `false` if a number is not finite.
    fn load_blocks(&mut self, problem: &BlockProblem<'_>, out: &mut Blocks) -> bool {
        let n = problem.free_velocity.len();
        (self.n, self.law) = (n, problem.law);
        self.w.clear();
        read(problem.free_velocity, 0, &mut self.g);
        let is_infinite = |row: usize| problem.regularization[row] == f64::INFINITY;
        self.list_units(problem.blocks, is_infinite, |block| problem.friction[block]);
        out.columns.copy_from(problem.columns);
        out.diagonal.clear();
        out.diagonal.extend_from_slice(problem.regularization);
        for i in self.units.iter().filter(|u| u.absent).map(|u| u.row) {
            out.columns.scale(i, 0.0);
            (self.g[i], out.diagonal[i]) = (0.0, 1.0);
        }
        self.scale.resize(n, 1.0);
        let diagonal = |i: usize| out.columns.diagonal(i) + out.diagonal[i];
        find_scale(&self.units, diagonal, &mut self.scale);
        self.scale_bounds();
        let mut finite = true;
        for (i, &scale) in self.scale.iter().enumerate() {
            self.g[i] *= scale;
            out.columns.scale(i, scale);
            out.diagonal[i] *= scale * scale;
            finite &= (self.g[i] + out.columns.diagonal(i) + out.diagonal[i]).is_finite();
        }
        self.is_regularized = out.diagonal.iter().all(|&r| r > REGULARIZED_ABOVE);
        finite && self.units.iter().all(|unit| unit.mu.is_finite())
    }
}

impl Search {
    /// Reads a problem with blocks and the forces to start from. `false` if a number is not finite.
    pub(super) fn start_blocks(&mut self, problem: &BlockProblem<'_>, f: &[f64]) -> bool {
        self.allowed = usize::MAX;
        let newton = &mut self.newton;
        newton.has_blocks = true;
        let finite = newton.system.load_blocks(problem, &mut newton.blocks);
        newton.reset();
        newton.blocks.connect(&newton.system.units);
        for ((own, f), scale) in newton.f.iter_mut().zip(f).zip(&newton.system.scale) {
            *own = f / scale;
        }
        finite && newton.f.iter().all(|f| f.is_finite())
    }

    /// By proximal steps, which lead farthest; else, and with compliance, by descents to where the active set is nearly right, and by proximal steps to the last
    /// digits.
    pub(super) fn by_descent(&mut self, tolerance: f64) -> bool {
        let is_regularized = self.newton.system.is_regularized;
        if !is_regularized && self.by_proximal_steps(tolerance) {
            return true;
        }
        if self.is_acceptable() {
            return false;
        }
        if self.newton.best_residual().is_finite() {
            self.newton.take_best();
        }
        self.descent.start(&self.newton);
        let mut rho = if is_regularized { 0.0 } else { FIRST_RHO };
        let mut residual = self.newton.note();
        while residual > tolerance && self.iterations() < self.allowed {
            let before = self.iterations();
            let goal = if is_regularized { tolerance } else { residual };
            self.descend(rho, INEXACT * goal);
            residual = self.newton.note();
            let used = self.iterations() - before;
            if residual <= EXACT_BELOW || used == 0 {
                if residual > tolerance && self.proximal_steps_from_here(LAST_RHO, tolerance) {
                    return true;
                }
                if used == 0 {
                    return false;
                }
                self.newton.take_best();
                self.descent.start(&self.newton);
                residual = self.newton.best_residual();
            }
            if used <= EASY && !is_regularized {
                rho = (rho * EASED).max(LEAST_RHO);
            }
        }
        residual <= tolerance
    }

    /// One descent: by Coulomb's law itself, or with shifts where that leads nowhere.
    fn descend(&mut self, rho: f64, goal: f64) {
        let left = |newton: &Newton, allowed: usize| allowed.saturating_sub(newton.steps);
        let (newton, descent, allowed) = (&mut self.newton, &mut self.descent, self.allowed);
        let most = left(newton, allowed);
        let exact = newton.system.law == Law::Coulomb;
        if !exact || !descent.run_exactly(newton, rho, goal, most) {
            let most = left(newton, allowed);
            descent.run(newton, rho, goal, most);
        }
    }
}
