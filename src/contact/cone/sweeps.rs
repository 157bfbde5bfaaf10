//! Block Gauss–Seidel: cheap steps that bring forces so near that the pieces of their laws can be told.
//!
//! One unit after the other takes a projected step on its own law while the forces of others stay,  f ← Π(f − y / W). A sweep costs a
//! product with W, where a step of Newton's method costs factors; it gains little where heavy bodies rest on light ones, and needs
//! neither full rank nor a good start. [Jourdan, Alart & Jean 1998].

use super::Law;
use super::certificate::project;
use super::system::{Kind, System, Unit, of_unit};

impl System {
    /// Takes one sweep. `y` is W f + g on entry, and on return again.
    pub(super) fn sweep(&self, f: &mut [f64], y: &mut [f64]) {
        for unit in self.units.iter().filter(|unit| !unit.absent) {
            match unit.kind {
                Kind::Row => self.move_to(unit.row, self.unbounded(unit.row, f, y), f, y),
                Kind::Ray => self.move_to(unit.row, self.unbounded(unit.row, f, y).max(0.0), f, y),
                Kind::Cone if self.law == Law::Convex => self.sweep_convex(unit, f, y),
                Kind::Cone => self.sweep_coulomb(unit, f, y),
            }
        }
    }

    /// The force with which the velocity of a row is zero.
    fn unbounded(&self, row: usize, f: &[f64], y: &[f64]) -> f64 {
        let own = self.w[row * (self.n + 1)];
        if own > 0.0 {
            f[row] - y[row] / own
        } else {
            f[row]
        }
    }

    /// Π on the cone, with the largest step that cannot overshoot.
    fn sweep_convex(&self, unit: &Unit, f: &mut [f64], y: &mut [f64]) {
        let own = self.w[unit.row * (self.n + 1)] + self.across(unit);
        if own > 0.0 {
            let (force, velocity) = (of_unit(f, unit), of_unit(y, unit));
            let moved = std::array::from_fn(|i| force[i] - velocity[i] / own);
            for (i, f_i) in project(moved, unit.mu).into_iter().enumerate() {
                self.move_to(unit.row + i, f_i, f, y);
            }
        }
    }

    /// Signorini's law along the normal, then friction within what the normal force allows.
    fn sweep_coulomb(&self, unit: &Unit, f: &mut [f64], y: &mut [f64]) {
        let normal = self.unbounded(unit.row, f, y).max(0.0);
        self.move_to(unit.row, normal, f, y);
        let own = self.across(unit);
        let along = |row: usize| {
            if own > 0.0 {
                f[row] - y[row] / own
            } else {
                f[row]
            }
        };
        let wanted = [along(unit.row + 1), along(unit.row + 2)];
        let (length, most) = (wanted[0].hypot(wanted[1]), unit.mu * normal);
        let share = if length > most { most / length } else { 1.0 };
        for (i, wanted) in wanted.into_iter().enumerate() {
            self.move_to(unit.row + 1 + i, share * wanted, f, y);
        }
    }

    /// The largest eigenvalue of the tangential block of a cone.
    fn across(&self, unit: &Unit) -> f64 {
        let entry = |i: usize, j: usize| self.w[(unit.row + i) + self.n * (unit.row + j)];
        let (mean, half) = (
            0.5 * (entry(1, 1) + entry(2, 2)),
            0.5 * (entry(1, 1) - entry(2, 2)),
        );
        mean + half.hypot(entry(1, 2))
    }

    /// Gives a row another force.
    fn move_to(&self, row: usize, force: f64, f: &mut [f64], y: &mut [f64]) {
        let change = force - f[row];
        if change != 0.0 {
            f[row] = force;
            let column = &self.w[self.n * row..self.n * (row + 1)];
            y.iter_mut().zip(column).for_each(|(y, w)| *y += w * change);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::contact::cone::search::Search;
    use crate::contact::cone::{Block, ConeProblem, Law};

    // Three contacts, a stop and a constraint on bodies of similar weight, where sweeps gain much: they come to rest where the laws hold,
    // which the equations of the pieces tell.
    #[test]
    fn forces_that_sweeps_no_longer_move_obey_the_laws() {
        let n = 11;
        let entry = |i: usize, k: usize| (((i + 2) * (2 * k + 1)) as f64).sin();
        let product = |i, j| (0..14).map(|k| entry(i, k) * entry(j, k)).sum();
        let matrix: Vec<f64> = (0..n * n).map(|at| product(at % n, at / n)).collect();
        let offset: Vec<f64> = (0..n).map(|i| ((3 * i + 1) as f64).cos() - 0.5).collect();
        for law in [Law::Convex, Law::Coulomb] {
            let problem = ConeProblem {
                law,
                blocks: &[
                    Block::Free(1),
                    Block::Ray,
                    Block::Cone,
                    Block::Cone,
                    Block::Cone,
                ],
                friction: &[0.0, 0.0, 0.6, 0.3, 0.1],
                matrix: &matrix,
                regularization: &[0.01; 11],
                offset: &offset,
            };
            let mut search = Search::default();
            assert!(search.start(&problem, &[0.0; 11], 0));
            let newton = &mut search.newton;
            let (mut f, mut y) = (vec![0.0; n], newton.system.g.clone());
            (0..3000).for_each(|_| newton.system.sweep(&mut f, &mut y));
            newton.f.copy_from_slice(&f);
            let residual = newton.evaluate();
            assert!(residual < 1e-10, "{law:?}: {residual:e}");
            assert!(f.iter().any(|f| f.abs() > 1e-2), "{law:?}: no forces");
        }
    }
}
