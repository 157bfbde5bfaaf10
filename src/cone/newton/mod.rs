//! Semismooth Newton on the active set: the equations of the pieces of the laws that hold.

mod blocks;
mod equations;
mod matrix;

use super::blocks::Blocks;
use super::jacobian::Square;
use super::law::Piece;
use super::smoothed::Smoothed;
use super::system::{System, UnitState};
use crate::linalg::Lu;
use crate::scalar::Scalar;
pub(super) use equations::{UnitEquations, product};

/// Added to the diagonal of W′ in Newton's matrix: large enough that redundant rows leave it regular, small enough that each step still gains
/// many digits. The equations themselves do not have it, so their solution is exact.
pub(super) const RIDGE: f64 = 1e-10;
/// Ratio of the ridge to the residual farther from the solution, and its largest value. The ridge keeps redundant forces from jumping between pieces of their laws.
const RIDGE_OF_RESIDUAL: f64 = 0.1;
const RIDGES_END: f64 = 1e-3;
/// Forces that grow so far beyond the velocities that they shall stop belong to a problem without solution.
const RUNAWAY: f64 = 1e7;

/// A system with its forces and velocities, all scaled, and the workspace of Newton's method.
#[derive(Clone, Debug, Default)]
pub(super) struct Newton {
    pub(super) system: System,
    /// κ; 0 for the exact law.
    pub(super) kappa: f64,
    /// Laws that κ smooths.
    pub(super) smoothed: Smoothed,
    pub(super) f: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) equations: Vec<UnitEquations>,
    pub(super) lu: Lu,
    /// X and R of a system with blocks, which has no W′.
    pub(super) blocks: Blocks,
    pub(super) has_blocks: bool,
    /// B⁻¹ of each unit, where there are blocks.
    inverses: Vec<Square>,
    step: Vec<f64>,
    best: (f64, Vec<f64>),
    /// ρ and f̄ of a proximal problem, whose velocities are those of the system plus ρ (f − f̄); ρ = 0 for the system itself.
    pub(super) rho: f64,
    pub(super) center: Vec<f64>,
    /// Rows whose forces are looked for: all but those of pieces that give them.
    rows: Vec<usize>,
    /// By how much velocities change as the others get the forces that are given.
    settled: Vec<f64>,
    /// Regularised mode: whether to keep the ridge beside the residual even where the active set seems settled.
    pub(super) regularized: bool,
    /// Whether the active set is another than at the forces before.
    changed: bool,
    /// Matrices factorised since the start.
    pub(super) steps: usize,
}

impl Newton {
    /// Makes room for so many rows.
    pub(super) fn reserve(&mut self, rows: usize) {
        self.system.reserve(rows);
        self.lu.reserve(rows);
        self.equations.reserve(rows);
        self.rows.reserve(rows);
        let (best, settled) = (&mut self.best.1, &mut self.settled);
        let own = [&mut self.f, &mut self.y, &mut self.step, &mut self.center];
        own.into_iter()
            .chain([best, settled])
            .for_each(|x| x.reserve(rows));
    }

    /// Forgets the last forces: all zero.
    pub(super) fn reset(&mut self) {
        let n = self.system.n;
        (self.steps, self.rho, self.best.0) = (0, 0.0, f64::INFINITY);
        self.equations
            .resize(self.system.units.len(), UnitEquations::NONE);
        let (best, settled) = (&mut self.best.1, &mut self.settled);
        for x in [
            &mut self.f,
            &mut self.y,
            &mut self.step,
            &mut self.center,
            best,
            settled,
        ] {
            x.clear();
            x.resize(n, 0.0);
        }
        self.rows.clear();
    }

    /// Takes at most so many steps from the forces `f`; whether they now solve the equations to `tolerance`.
    pub(super) fn solve(&mut self, max_steps: usize, tolerance: f64) -> bool {
        let mut last_ridge = f64::NAN;
        let least_ridge = if self.system.is_regularized {
            0.0
        } else {
            RIDGE
        };
        for step in 0..=max_steps {
            let residual = self.note();
            if residual <= tolerance {
                return self.is_inside();
            }
            if step == max_steps || !residual.is_finite() || self.runs_away() {
                return false;
            }
            let is_unsettled = self.regularized || (step > 0 && self.changed);
            let unsettled = if is_unsettled {
                RIDGE_OF_RESIDUAL * residual
            } else {
                0.0
            };
            let least_ridge = if self.rho > 0.0 { 0.0 } else { least_ridge };
            let ridge = unsettled.clamp(least_ridge, RIDGES_END);
            // On the same flat pieces the last matrix still holds, and the remaining error is the effect of the ridge.
            if ridge != last_ridge || self.changed || !self.is_flat() {
                self.factorize(ridge + self.rho);
                self.steps += 1;
            }
            last_ridge = ridge;
            self.step_once();
        }
        false
    }

    /// [`evaluate`](Self::evaluate), with a note of the best forces of the system itself.
    pub(super) fn note(&mut self) -> f64 {
        let residual = self.evaluate();
        if self.rho == 0.0 && residual < self.best.0 {
            self.best.0 = residual;
            self.best.1.copy_from_slice(&self.f);
        }
        residual
    }

    /// Velocities, pieces and equations at f. Returns the largest equation beside the [`Newton::size`].
    pub(super) fn evaluate(&mut self) -> f64 {
        let (f, g) = (&self.f, &self.system.g);
        match self.has_blocks {
            true => self.blocks.velocities(f, g, &mut self.y),
            false => self.system.velocities(f, g, &mut self.y),
        }
        if self.rho > 0.0 {
            let forces = self.f.iter().zip(&self.center);
            let all = self.y.iter_mut().zip(forces);
            all.for_each(|(y, (f, center))| *y += self.rho * (f - center));
        }
        self.changed = false;
        let (law, kappa, smoothed) = (self.system.law, self.kappa, self.smoothed);
        let mut largest = 0.0_f64;
        for (unit, last) in self.system.units.iter().zip(&mut self.equations) {
            let (at, piece) = (UnitState::of(unit, &self.f, &self.y), last.piece);
            let bounded = self.system.bounded(unit, &self.f);
            let unit = bounded.as_ref().unwrap_or(unit);
            last.evaluate(law, unit, at, smoothed.kappa(kappa, unit.kind));
            for e in last.e {
                largest = if e.abs() > largest || e.is_nan() {
                    e.abs()
                } else {
                    largest
                };
            }
            self.changed |= piece != last.piece;
        }
        let size = self.size();
        if largest == 0.0 { 0.0 } else { largest / size }
    }

    /// The largest force plus the largest free velocity, both scaled: the unit of residuals.
    pub(super) fn size(&self) -> f64 {
        largest(&self.f) + self.size_of_problem()
    }

    /// The largest free velocity, or on the path the velocity of κ.
    pub(super) fn size_of_problem(&self) -> f64 {
        largest(&self.system.g).max(self.kappa.sqrt())
    }

    /// The smallest residual since the start.
    pub(super) fn best_residual(&self) -> f64 {
        self.best.0
    }

    /// The largest force where the residual was smallest.
    pub(super) fn best_force(&self) -> f64 {
        largest(&self.best.1)
    }

    /// Goes back to the best forces since the start.
    pub(super) fn take_best(&mut self) {
        self.f.copy_from_slice(&self.best.1);
        self.evaluate();
    }

    fn runs_away(&self) -> bool {
        largest(&self.f) > RUNAWAY * self.size_of_problem()
    }

    /// Factorises Newton's matrix for the pieces that hold.
    fn factorize(&mut self, ridge: f64) {
        match self.has_blocks {
            true => self.factorize_blocks(ridge),
            false => self.factorize_forces(ridge),
        }
    }

    fn step_once(&mut self) {
        match self.has_blocks {
            true => self.step_by_blocks(),
            false => self.step_by_forces(),
        }
    }

    /// Whether the pieces that hold are planes.
    fn is_flat(&self) -> bool {
        self.equations.iter().all(|own| own.piece.is_flat())
    }

    /// On the central path: whether forces and velocities are inside their cones, as its equations have solutions outside as well.
    fn is_inside(&self) -> bool {
        let mut all = self.system.units.iter().zip(&self.equations);
        self.kappa == 0.0
            || all.all(|(unit, own)| {
                let UnitState { f, y } = UnitState::of(unit, &self.f, &self.y);
                let inside = unit.mu * unit.mu * f[0] * f[0] - f[1] * f[1] - f[2] * f[2];
                match own.piece {
                    Piece::PathOfInterval => f[0].abs() <= unit.mu,
                    piece => {
                        !piece.is_smoothed()
                            || (f[0] > 0.0 && y[0] > 0.0 && (inside >= 0.0 || unit.mu == 0.0))
                    }
                }
            })
    }
}

/// The largest magnitude.
pub(super) fn largest<T: Scalar>(x: &[T]) -> T {
    x.iter().fold(T::zero(), |largest, x| x.abs().max(largest))
}
