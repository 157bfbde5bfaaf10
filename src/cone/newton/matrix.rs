//! Newton's matrix and step of a system whose W′ is there.

use super::{Newton, UnitEquations, product};
use crate::cone::law::Piece;
use crate::cone::system::{System, Unit, UnitState, of_unit};
use crate::linalg::Lu;

impl Newton {
    /// Factorises Newton's matrix for the pieces that hold.
    pub(super) fn factorize_forces(&mut self, ridge: f64) {
        self.assemble_forces(ridge);
        self.lu.factorize();
    }

    /// ∂e/∂f + ∂e/∂y (W′ + ridge).
    pub(in crate::cone) fn assemble(&mut self, ridge: f64) {
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

    pub(super) fn linearize(&mut self) {
        for (unit, own) in self.system.units.iter().zip(&mut self.equations) {
            if !own.is_linearized() {
                let bounded = self.system.bounded(unit, &self.f);
                let at = UnitState::of(unit, &self.f, &self.y);
                own.linearize(bounded.as_ref().unwrap_or(unit), at, 0.0);
            }
        }
    }

    /// Writes the entries of the listed rows for each other, for the pieces that are `taken`.
    fn fill(&mut self, ridge: f64, taken: impl Fn(Piece) -> bool) {
        let system = &self.system;
        self.lu.start(self.rows.len());
        let units = system.units.iter().zip(&self.equations);
        let mut first = 0;
        for (unit, own) in units.filter(|(_, own)| taken(own.piece)) {
            fill_rows(system, &self.rows, first, unit, own, &mut self.lu);
            add_own(system, &self.rows, first, unit, own, ridge, &mut self.lu);
            first += unit.rows();
        }
    }

    /// Takes Newton's step, with the forces that pieces give.
    pub(super) fn step_by_forces(&mut self) {
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
}

/// Writes ∂e/∂y times the rows of a unit in W′, column by column.
///
/// * `first` – the first of its rows among `rows`, those of the matrix
fn fill_rows(
    system: &System,
    rows: &[usize],
    first: usize,
    unit: &Unit,
    own: &UnitEquations,
    out: &mut Lu,
) {
    let (n, a) = (system.n, &own.jacobian.y);
    let columns = rows.iter().map(|&j| &system.w[n * j + unit.row..]);
    for (at, w) in columns.enumerate() {
        let out = &mut out.column_mut(at)[first..];
        match (unit.rows(), w, out) {
            (3, &[x, y, z, ..], [a, b, c, ..]) if own.piece == Piece::Stick => {
                (*a, *b, *c) = (x, y, z);
            }
            (3, &[x, y, z, ..], out) => out[..3].copy_from_slice(&product(a, [x, y, z])),
            (2, &[x, y, ..], out) => out[..2].copy_from_slice(&product(a, [x, y, 0.0])[..2]),
            (_, w, out) => out[0] = a[0][0] * w[0],
        }
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
