//! Semismooth Newton on the active set: the equations of the pieces of the laws that hold.

use super::Law;
use super::blocks::{Blocks, inverse};
use super::jacobian::{EquationJacobian, Square, jacobian_of};
use super::law::{
    Piece, equations, piece_of_cone, piece_of_interval, piece_of_moment, piece_of_ray,
};
use super::smoothed::Smoothed;
use super::system::{Kind, System, Unit, UnitState, of_unit};
use crate::linalg::Lu;
use crate::scalar::{MapEach, Scalar, each, from_each};

/// Added to the diagonal of W′ in Newton's matrix: large enough that redundant rows leave it regular, small enough that each step still gains
/// many digits. The equations themselves do not have it, so their solution is exact.
pub(super) const RIDGE: f64 = 1e-10;
/// Ratio of the ridge to the residual farther from the solution, and its largest value. The ridge keeps redundant forces from jumping between pieces of their laws.
const RIDGE_OF_RESIDUAL: f64 = 0.1;
const RIDGES_END: f64 = 1e-3;
/// Forces that grow so far beyond the velocities that they shall stop belong to a problem without solution.
const RUNAWAY: f64 = 1e7;

/// The equations of a unit at the last force and velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnitEquations {
    pub(super) piece: Piece,
    pub(super) e: [f64; 3],
    /// Up to date after [`Newton::assemble`].
    pub(super) jacobian: EquationJacobian,
    /// The piece of which it is.
    linearized: Piece,
    /// Scale factors that bring each equation to size 1.
    pub(super) weight: [f64; 3],
}

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
        if !self.has_blocks {
            self.assemble_forces(ridge);
            return self.lu.factorize();
        }
        self.linearize();
        self.inverses.clear();
        for (unit, own) in self.system.units.iter().zip(&self.equations) {
            let (mut b, jacobian) = (own.jacobian.f, &own.jacobian.y);
            for j in 0..unit.rows() {
                let compliance = self.blocks.diagonal[unit.row + j] + ridge;
                (0..unit.rows()).for_each(|i| b[i][j] += jacobian[i][j] * compliance);
            }
            self.inverses.push(inverse(&b, unit.rows()));
        }
        let (equations, inverses) = (&self.equations, &self.inverses);
        self.blocks.factorize(&self.system.units, |k| {
            let own = &equations[k];
            let has_force = own.piece != Piece::Separated;
            has_force.then(|| square_product(&inverses[k], &own.jacobian.y))
        });
    }

    /// δf = −B⁻¹ (e + `E_y` Xᵀ δz)  with  (1 + X B⁻¹ `E_y` Xᵀ) δz = −X B⁻¹ e.
    fn step_by_blocks(&mut self) {
        let (units, blocks) = (&self.system.units, &self.blocks);
        let all = || units.iter().zip(self.equations.iter().zip(&self.inverses));
        self.step.clear();
        self.step.resize(blocks.columns.n_coordinates(), 0.0);
        for (unit, (own, inverse)) in all() {
            let change = product(inverse, own.e).map_each(|x| -x);
            blocks.add_unit(unit, change, &mut self.step);
        }
        blocks.solve(&mut self.step);
        for (unit, (own, inverse)) in all() {
            let change = product(&own.jacobian.y, blocks.columns.along(unit, &self.step));
            let change = product(inverse, each(|i| own.e[i] + change[i]));
            for i in 0..unit.rows() {
                self.f[unit.row + i] -= change[i];
            }
        }
    }

    /// ∂e/∂f + ∂e/∂y (W′ + ridge).
    pub(super) fn assemble(&mut self, ridge: f64) {
        self.linearize();
        self.rows.clear();
        self.rows.extend(0..self.system.n);
        self.fill(ridge, |_| true);
    }

    /// [`assemble`](Self::assemble) for the rows of pieces that do not give their force: of the others the step is known.
    fn assemble_forces(&mut self, ridge: f64) {
        self.linearize();
        self.rows.clear();
        for (unit, own) in self.system.units.iter().zip(&self.equations) {
            if own.piece.given().is_none() {
                self.rows.extend(unit.row..unit.row + unit.rows());
            }
        }
        self.fill(ridge, |piece| piece.given().is_none());
    }

    fn linearize(&mut self) {
        for (unit, own) in self.system.units.iter().zip(&mut self.equations) {
            // Those of smoothed laws are there already, and so may those of planes be, which are the same everywhere.
            let is_there = own.piece.is_flat() && own.linearized == own.piece;
            if !own.piece.is_smoothed() && !is_there {
                let bounded = self.system.bounded(unit, &self.f);
                let at = UnitState::of(unit, &self.f, &self.y);
                own.linearize(bounded.as_ref().unwrap_or(unit), at, 0.0);
            }
        }
    }

    /// Writes the entries of the listed rows for each other, for the pieces that are `taken`.
    fn fill(&mut self, ridge: f64, taken: impl Fn(Piece) -> bool) {
        let (n, system) = (self.system.n, &self.system);
        let units = system.units.iter().zip(&self.equations);
        let units = units.filter(|(_, own)| taken(own.piece));
        self.lu.start(self.rows.len());
        for (at, &j) in self.rows.iter().enumerate() {
            let w = &system.w[n * j..][..n];
            let mut left = self.lu.column_mut(at);
            for (unit, own) in units.clone() {
                let (out, rest) = left.split_at_mut(unit.rows());
                fill(own, &w[unit.row..][..out.len()], out);
                left = rest;
            }
        }
        let mut first = 0;
        for (unit, own) in units {
            add_own(system, &self.rows, first, unit, own, ridge, &mut self.lu);
            first += unit.rows();
        }
    }

    fn step_once(&mut self) {
        if self.has_blocks {
            return self.step_by_blocks();
        }
        self.settle_given();
        self.step.clear();
        for (unit, own) in self.system.units.iter().zip(&self.equations) {
            if own.piece.given().is_none() {
                let change = product(&own.jacobian.y, of_unit(&self.settled, unit));
                let e = own.e.iter().zip(change).take(unit.rows());
                self.step.extend(e.map(|(e, change)| e + change));
            }
        }
        self.lu.solve(&mut self.step);
        for (&row, step) in self.rows.iter().zip(&self.step) {
            self.f[row] -= step;
        }
    }

    /// Sets the forces that pieces give, and notes what that does to velocities.
    fn settle_given(&mut self) {
        let n = self.system.n;
        self.settled.fill(0.0);
        for (unit, own) in self.system.units.iter().zip(&self.equations) {
            let Some(share) = own.piece.given() else {
                continue;
            };
            for row in unit.row..unit.row + unit.rows() {
                // Zero of what is separated, also of a cone, of which μ is not its bound.
                let given = if share == 0.0 { 0.0 } else { share * unit.mu };
                let change = given - std::mem::replace(&mut self.f[row], given);
                if change != 0.0 {
                    let column = self.system.w[n * row..n * (row + 1)].iter();
                    let all = self.settled.iter_mut().zip(column);
                    all.for_each(|(settled, w)| *settled += w * change);
                }
            }
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

impl UnitEquations {
    const NONE: Self = Self {
        piece: Piece::Separated,
        e: [0.0; 3],
        jacobian: EquationJacobian {
            f: [[0.0; 3]; 3],
            y: [[0.0; 3]; 3],
            mu: [0.0; 3],
        },
        linearized: Piece::PathOfRay,
        weight: [1.0; 3],
    };

    /// The piece that holds, and its equations.
    #[inline(always)]
    fn evaluate(&mut self, law: Law, unit: &Unit, at: UnitState, kappa: f64) {
        let UnitState { f, y } = at;
        self.piece = match (unit.kind, kappa > 0.0) {
            (Kind::Row, _) if unit.absent => Piece::Separated,
            (Kind::Row, _) => Piece::Stick,
            (Kind::Ray, false) => piece_of_ray(f[0], y[0]),
            (Kind::Ray, true) => Piece::PathOfRay,
            (Kind::Interval, false) => piece_of_interval(f[0], y[0], unit.mu),
            (Kind::Interval, true) => Piece::PathOfInterval,
            (Kind::Cone, false) => piece_of_cone(law, f, y, unit.mu),
            (Kind::Cone, true) if unit.mu > 0.0 => Piece::PathOfCone(law),
            (Kind::Cone, true) => Piece::PathOfRay,
            (Kind::Spin | Kind::Roll, _) => piece_of_moment(f, y, unit.mu),
        };
        self.e = equations(self.piece, f, y, unit.mu, kappa);
        self.weight = [1.0; 3];
        if self.piece.is_smoothed() {
            self.linearize(unit, at, kappa);
            self.equilibrate(unit.rows());
        }
    }

    fn linearize(&mut self, unit: &Unit, at: UnitState, kappa: f64) {
        self.linearized = self.piece;
        self.jacobian = jacobian_of(self.piece, at.f, at.y, unit.mu, kappa);
    }

    fn equilibrate(&mut self, rows: usize) {
        for i in 0..rows {
            let entries = self.jacobian.f[i].iter().chain(&self.jacobian.y[i]);
            let size = entries.fold(0.0_f64, |size, x| size.max(x.abs()));
            let weight = if size > 0.0 { 1.0 / size } else { 1.0 };
            self.weight[i] = weight;
            self.e[i] *= weight;
            self.jacobian.mu[i] *= weight;
            for j in 0..3 {
                self.jacobian.f[i][j] *= weight;
                self.jacobian.y[i][j] *= weight;
            }
        }
    }
}

/// ∂e/∂y times the part of one column of W′ in the rows of a unit.
#[inline(always)]
fn fill(own: &UnitEquations, w: &[f64], out: &mut [f64]) {
    match (w, out) {
        (&[x, y, z], [a, b, c]) if own.piece == Piece::Stick => (*a, *b, *c) = (x, y, z),
        (&[x, y, z], out) => out.copy_from_slice(&product(&own.jacobian.y, [x, y, z])),
        (&[x, y], out) => out.copy_from_slice(&product(&own.jacobian.y, [x, y, 0.0])[..2]),
        (w, out) => out[0] = own.jacobian.y[0][0] * w[0],
    }
}

/// Adds ∂e/∂f and the ridge of a unit, and how a moment at its bound depends on the normal force.
///
/// * `first` – the first of its rows among `rows`, those of the matrix
fn add_own(
    system: &System,
    rows: &[usize],
    first: usize,
    unit: &Unit,
    own: &UnitEquations,
    ridge: f64,
    out: &mut Lu,
) {
    let jacobian = &own.jacobian;
    for j in 0..unit.rows() {
        let column = &mut out.column_mut(first + j)[first..][..unit.rows()];
        for (i, x) in column.iter_mut().enumerate() {
            *x += jacobian.f[i][j] + ridge * jacobian.y[i][j];
        }
    }
    if own.piece == Piece::Turning
        && let Ok(at) = rows.binary_search(&system.normal(unit))
    {
        let column = &mut out.column_mut(at)[first..][..unit.rows()];
        let slopes = column.iter_mut().zip(jacobian.mu);
        slopes.for_each(|(x, slope)| *x += slope * unit.mu);
    }
}

/// A B.
fn square_product(a: &Square, b: &Square) -> Square {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
    from_each(|i| from_each(|j| entry(i, j)))
}

/// A x.
pub(super) fn product<T: Scalar>(a: &Square<T>, x: [T; 3]) -> [T; 3] {
    each(|i| a[i][0] * x[0] + a[i][1] * x[1] + a[i][2] * x[2])
}
