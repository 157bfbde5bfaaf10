//! Proximal steps: forces of redundant contacts by problems that are regular.
//!
//! Each step solves the problem with a spring of ρ between the forces and those of the step before, y + ρ (f − f̄). However many contacts are
//! redundant, that has one solution where the laws are convex, and Newton's method on the active set finds it in the fewer steps the larger ρ
//! is. The remainder ρ (f − f̄) vanishes as the steps come to rest: quickly in velocities, and at the residual velocity over ρ in forces that
//! only press against each other. So ρ falls as long as steps go well, and rises where they do not.
//! [Rockafellar 1976; Carpentier, Le Lidec & Montaut 2024]

use super::search::Search;
use super::system::Kind;

/// ρ of the first step, beside a diagonal of 1: there nearly all of Newton's runs from no force at all arrive.
const FIRST_RHO: f64 = 1e-2;
/// ρ of the first step from forces nearby.
const RHO_NEARBY: f64 = 1e-3;
/// ρ above all eigenvalues of very many redundant contacts, where the problem is nearly one of single contacts.
const LARGEST_RHO: f64 = 100.0;
/// From here on the ridge of Newton's matrix does the same.
const LEAST_RHO: f64 = 1e-9;
/// Factors of ρ after a step that was easy, and after one that was not found.
const EASED: f64 = 1.0 / 30.0;
const FAILED: f64 = 10.0;
/// With blocks ρ goes back to its value before a step that was not found. From then on it falls more gently: by the root of the factor before, at last by
/// this one.
const GENTLY_EASED: f64 = 0.5;
/// Steps of Newton's method in a proximal step, in one piece and by blocks; a search that needs more steps is cycling. Half as many steps is an easy case.
const NEWTON_STEPS: usize = 10;
const NEWTON_STEPS_BY_BLOCKS: usize = 14;
/// The part of the last residual to which a step is solved. The first one with blocks goes farther: from no forces, rounding decides the pieces of contacts that
/// only press against each other, and an inexact step would leave them forces across the normal that others would keep.
const INEXACT: f64 = 0.1;
const INEXACT_AT_FIRST: f64 = 1e-6;
/// Matrices after which an acceptable residual is taken, and after which the search ends. With blocks proximal steps are the way that leads farthest: they
/// take as many matrices as there are, and a residual only below this limit is taken early.
const STALL_LIMIT: usize = 10;
const MOST: usize = 60;
const ACCEPTABLE_BY_BLOCKS: f64 = 5e-10;
/// A residual from which the path and regularised problems have not been seen to lead farther.
const NEAR: f64 = 1e-4;
/// Forces so much stronger than the free velocities, both scaled, make residuals small by themselves.
const STRONGEST: f64 = 1e3;

impl Search {
    /// Looks for forces by proximal steps, in one piece from none.
    pub(super) fn by_proximal_steps(&mut self, tolerance: f64) -> bool {
        let is_nearby = self.newton.has_blocks && self.newton.f.iter().any(|f| *f != 0.0);
        if is_nearby {
            return self.proximal_steps_from_here(RHO_NEARBY, tolerance);
        }
        self.newton.f.fill(0.0);
        self.proximal_steps_from_here(FIRST_RHO, tolerance)
    }

    /// Looks for forces by proximal steps from those that are there, at first with a ρ that is given.
    pub(super) fn proximal_steps_from_here(&mut self, mut rho: f64, tolerance: f64) -> bool {
        let (start, most) = (self.iterations(), self.newton_steps());
        let end = match self.newton.has_blocks {
            true => self.allowed,
            false => self.allowed.min(start + MOST),
        };
        let mut residual = self.newton.note();
        let mut eased = EASED;
        while self.iterations() < end {
            let before = self.iterations();
            let is_first = self.newton.has_blocks && before == start;
            let share = if is_first { INEXACT_AT_FIRST } else { INEXACT };
            let target = (0.5 * tolerance).max(share * residual);
            let found = self.step_proximally(rho, target);
            // Without a step there is none to come: forces run away.
            if self.iterations() == before {
                break;
            }
            if !found {
                rho = self.raised(rho, &mut eased);
                continue;
            }
            residual = self.newton.note();
            let may_stall = self.iterations() < start + STALL_LIMIT;
            if residual <= tolerance || (!may_stall && self.ends_early()) {
                break;
            }
            if self.iterations() - before <= most / 2 {
                rho = (eased * rho).max(LEAST_RHO);
            }
        }
        residual <= tolerance
    }

    /// ρ after a step that was not found, and the factor of later ones.
    fn raised(&self, rho: f64, eased: &mut f64) -> f64 {
        let by = match self.newton.has_blocks {
            true => 1.0 / *eased,
            false => FAILED,
        };
        if self.newton.has_blocks {
            *eased = eased.sqrt().min(GENTLY_EASED);
        }
        (by * rho).min(LARGEST_RHO)
    }

    fn newton_steps(&self) -> usize {
        match self.newton.has_blocks {
            true => NEWTON_STEPS_BY_BLOCKS,
            false => NEWTON_STEPS,
        }
    }

    /// Whether the best forces so far end a search that goes on.
    fn ends_early(&self) -> bool {
        let is_so_good = self.newton.best_residual() <= ACCEPTABLE_BY_BLOCKS;
        self.is_acceptable() && (is_so_good || !self.newton.has_blocks)
    }

    /// One step from the forces of Newton's method, which stay where it fails.
    fn step_proximally(&mut self, rho: f64, target: f64) -> bool {
        let newton = &mut self.newton;
        newton.center.copy_from_slice(&newton.f);
        newton.rho = rho;
        let found = self.solve_active_set(self.newton_steps(), target);
        let newton = &mut self.newton;
        newton.rho = 0.0;
        if !found {
            newton.f.copy_from_slice(&newton.center);
        }
        found
    }

    /// Whether the best forces so far may be taken.
    pub(super) fn is_acceptable(&self) -> bool {
        self.newton.best_residual() <= self.acceptable && self.is_bounded()
    }

    /// Whether the best forces so far are so good that other ways are not worth their time; never where none but exact ones are.
    pub(super) fn is_near(&self) -> bool {
        let near = self.newton.best_residual() <= NEAR.max(self.acceptable);
        self.acceptable > 0.0 && near && self.is_bounded()
    }

    /// Whether a small residual means that velocities are right: not where what contradicts itself makes forces grow without end, which is
    /// better regularised, nor on the path, which has another residual.
    fn is_bounded(&self) -> bool {
        let newton = &self.newton;
        let bounded = newton.best_force() <= STRONGEST * newton.size_of_problem();
        let mut units = newton.system.units.iter();
        // A row that holds with a bounded force may hold for ever, as bilateral rows do.
        let holds = |kind| matches!(kind, Kind::Row | Kind::Interval);
        let bilateral = units.any(|unit| holds(unit.kind) && !unit.absent);
        bounded && !bilateral && newton.kappa == 0.0 && self.regularization == 0.0
    }
}

#[cfg(test)]
mod tests {
    use crate::cone::search::Search;
    use crate::cone::{Block, ConeOptions, ConeProblem, Law, Status};

    const TOLERANCE: f64 = 1e-12;

    /// A plate of 1 kg with principal moments of inertia of 0.1 kg m² that lands turning on an m × m grid of points: so many more than
    /// it takes to hold it.
    fn on_grid(m: usize) -> (Vec<f64>, Vec<f64>) {
        let mut rows = Vec::new();
        let along = |i: usize| 2.0 * i as f64 / (m - 1) as f64 - 1.0;
        for (x, y) in (0..m * m).map(|k| (along(k / m), 0.7 * along(k % m))) {
            // Velocity of a point (x, y, −0.3) along z, x and y by that of the body
            rows.push([0.0, 0.0, 1.0, y, -x, 0.0]);
            rows.push([1.0, 0.0, 0.0, 0.0, -0.3, -y]);
            rows.push([0.0, 1.0, 0.0, 0.3, 0.0, x]);
        }
        let inverse = [1.0, 1.0, 1.0, 10.0, 10.0, 10.0];
        let velocity = [0.3, -0.2, -1.0, 0.4, 0.7, 2.0];
        let product = |a: &[f64; 6], b: &[f64; 6]| (0..6).map(|k| a[k] * inverse[k] * b[k]).sum();
        let matrix = rows
            .iter()
            .flat_map(|a| rows.iter().map(move |b| product(a, b)));
        let free_velocity = rows
            .iter()
            .map(|row| (0..6).map(|k| row[k] * velocity[k]).sum());
        (matrix.collect(), free_velocity.collect())
    }

    fn search(m: usize, (matrix, free_velocity): &(Vec<f64>, Vec<f64>)) -> Search {
        let n = m * m;
        let problem = ConeProblem {
            law: Law::Coulomb,
            blocks: &vec![Block::Cone; n],
            friction: &vec![0.5; n],
            matrix,
            regularization: &vec![0.0; 3 * n],
            free_velocity,
        };
        let mut search = Search::default();
        assert!(search.start(&problem, &vec![0.0; 3 * n], 0));
        search
    }

    #[test]
    fn proximal_steps_lead_to_the_laws_of_redundant_contacts() {
        for m in [2, 3, 5] {
            let mut search = search(m, &on_grid(m));
            assert!(search.by_proximal_steps(TOLERANCE), "{m}");
            let residual = search.newton.evaluate();
            assert!(residual <= TOLERANCE, "{m}: {residual:e}");
            assert!(search.newton.f.iter().any(|f| *f > 0.1), "{m}: no forces");
            assert!(search.iterations() <= super::MOST);
        }
    }

    // With a tolerance below rounding, the search ends with acceptable forces, or continues where there are none.
    #[test]
    fn acceptable_forces_end_a_search_that_takes_long() {
        let mut search = search(3, &on_grid(3));
        let options = ConeOptions {
            tolerance: 1e-30,
            acceptable: 1e-6,
            ..ConeOptions::default()
        };
        let certificate = search.run(&options);
        assert_eq!(certificate.status, Status::Acceptable);
        assert!(certificate.residual <= 1e-6, "{certificate:?}");
        let exact = ConeOptions {
            acceptable: 0.0,
            ..options
        };
        let other = self::search(3, &on_grid(3)).run(&exact);
        assert_ne!(other.status, Status::Acceptable);
        assert!(other.iterations > certificate.iterations);
    }

    // A body squeezed between two others has no forces, and ever larger ones no right velocities.
    #[test]
    fn forces_that_grow_without_end_are_not_acceptable() {
        let problem = ConeProblem {
            law: Law::Coulomb,
            blocks: &[Block::Ray; 2],
            friction: &[0.0; 2],
            matrix: &[1.0, -1.0, -1.0, 1.0],
            regularization: &[0.0; 2],
            free_velocity: &[-1.0; 2],
        };
        let options = ConeOptions {
            acceptable: 1e-6,
            ..ConeOptions::default()
        };
        let mut search = Search::default();
        assert!(search.start(&problem, &[0.0; 2], 0));
        assert_eq!(search.run(&options).status, Status::Regularized);
    }
}
