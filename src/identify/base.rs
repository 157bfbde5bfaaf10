//! Base parameters: the identifiable combinations of unknowns.

use std::fmt;

use nalgebra::{DMatrix, DVector};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use super::regressor::{Regressor, Unknown};
use crate::error::rounded;

/// Size of a column that is left of its own length after those before it were taken away, below which it depends on them: far above the rounding of
/// thousands of equations, far below what another number would do.
const RANK: f64 = 1e-9;
/// Factors of combinations below this are rounding.
const ROUNDING: f64 = 1e-10;
/// Equations for each unknown.
const EQUATIONS: usize = 4;

/// The base parameters β = `x_I` + C `x_D`: the independent combinations of the unknowns x on which joint forces depend.
///
/// Found by QR decomposition with column pivoting of the regressor of random motions: the columns `Y_I` that are independent, and `Y_D` = `Y_I` C for
/// the others. So Y x = `Y_I` β for all motions.
///
/// # Examples
/// ```
/// use dualbody::{identify::{BaseParameters, Regressor}, model::samples};
///
/// // A rod on a pivot: of ten numbers it shows its moment about the axis, and two first moments.
/// let base = BaseParameters::new(&Regressor::new(&samples::pendulum()));
/// assert_eq!(base.len(), 3);
/// ```
///
/// # References
/// [Gautier 1991; Golub, Van Loan 2013, section 5.4].
#[derive(Clone, Debug, PartialEq)]
pub struct BaseParameters {
    /// Independent unknowns, by index: one for each base parameter.
    pub independent: Vec<usize>,
    /// Dependent unknowns, by index, which are merged into the independent ones.
    pub dependent: Vec<usize>,
    /// C, independent × dependent.
    pub combination: DMatrix<f64>,
    /// Unknowns on which no force depends, by index.
    pub without_effect: Vec<usize>,
    /// Names of the unknowns.
    names: Vec<String>,
    /// Velocity coordinates whose forces depend on each independent unknown.
    support: Vec<Vec<bool>>,
}

#[expect(
    clippy::len_without_is_empty,
    reason = "a count, none of which is rare"
)]
impl BaseParameters {
    /// Finds the base parameters of a regressor. The random motions are deterministic.
    pub fn new(regressor: &Regressor) -> Self {
        let equations = random_equations(regressor);
        let n = equations.ncols();
        let lengths: Vec<f64> = equations
            .column_iter()
            .map(|column| column.norm())
            .collect();
        let largest = lengths.iter().copied().fold(0.0, f64::max);
        let has_effect = |k: &usize| lengths[*k] > RANK * largest;
        let (kept, without_effect): (Vec<usize>, Vec<usize>) = (0..n).partition(has_effect);
        // Without units; those that shall rather depend on others are shorter, so that the pivoting takes them late.
        let preference = |k: usize| preference(regressor.unknowns()[k]);
        let unit = |k: usize| lengths[k] / preference(k);
        let scaled = DMatrix::from_fn(equations.nrows(), kept.len(), |i, k| {
            equations[(i, kept[k])] / unit(kept[k])
        });
        let (order, r) = pivoted(scaled);
        let diagonal = |k: usize| r[(k, k)].abs();
        let rank = (0..order.len())
            .take_while(|&k| diagonal(k) > RANK * diagonal(0))
            .count();
        let index = |k: usize| kept[order[k]];
        let own = r.view((0, 0), (rank, rank)).into_owned();
        let others = r.view((0, rank), (rank, order.len() - rank)).into_owned();
        let solved = own.solve_upper_triangular(&others).unwrap_or(others);
        let combination = DMatrix::from_fn(rank, solved.ncols(), |i, k| {
            let (to, from) = (index(i), index(rank + k));
            match solved[(i, k)].abs() < ROUNDING * preference(from) {
                true => 0.0,
                false => solved[(i, k)] * unit(from) / unit(to),
            }
        });
        let nv = regressor.model().nv();
        let independent: Vec<usize> = (0..rank).map(index).collect();
        let acts = |k: usize, row: usize| {
            let column = equations.column(k);
            column.iter().skip(row).step_by(nv).any(|&x| x != 0.0)
        };
        let support = (independent.iter()).map(|&k| (0..nv).map(|row| acts(k, row)).collect());
        Self {
            support: support.collect(),
            independent,
            dependent: (rank..order.len()).map(index).collect(),
            combination,
            without_effect,
            names: regressor.names().to_vec(),
        }
        .sorted()
    }

    /// In the order of the unknowns.
    fn sorted(self) -> Self {
        let mut order: Vec<usize> = (0..self.independent.len()).collect();
        order.sort_unstable_by_key(|&k| self.independent[k]);
        Self {
            independent: order.iter().map(|&k| self.independent[k]).collect(),
            combination: self.combination.select_rows(&order),
            support: order.iter().map(|&k| self.support[k].clone()).collect(),
            ..self
        }
    }

    /// Number of base parameters.
    pub fn len(&self) -> usize {
        self.independent.len()
    }

    /// Whether the force along a velocity coordinate depends on a base parameter.
    pub(super) fn acts_on(&self, base: usize, coordinate: usize) -> bool {
        self.support[base][coordinate]
    }

    /// Computes β from values of the unknowns.
    ///
    /// # Panics
    /// If the number of values differs from that of unknowns.
    pub fn of(&self, x: &DVector<f64>) -> DVector<f64> {
        assert_eq!(
            x.len(),
            self.names.len(),
            "number of values, given and of unknowns"
        );
        x.select_rows(&self.independent) + &self.combination * x.select_rows(&self.dependent)
    }

    /// Values of the unknowns with these base parameters: independent ones change, the others keep what is given.
    pub(super) fn unknowns(&self, base: &DVector<f64>, others: &DVector<f64>) -> DVector<f64> {
        let mut out = others.clone();
        let own = base - &self.combination * others.select_rows(&self.dependent);
        for (&k, x) in self.independent.iter().zip(&own) {
            out[k] = *x;
        }
        out
    }

    /// The linear map from unknowns to base parameters.
    pub(super) fn map(&self) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(self.len(), self.names.len());
        for (i, &k) in self.independent.iter().enumerate() {
            out[(i, k)] = 1.0;
        }
        for (j, &k) in self.dependent.iter().enumerate() {
            out.set_column(k, &self.combination.column(j));
        }
        out
    }

    /// Meaning of a base parameter, for example `upper: Jzz + lower: mass`.
    ///
    /// # Panics
    /// If there is no such base parameter.
    pub fn meaning(&self, base: usize) -> String {
        /// Digits of a factor.
        const DIGITS: i32 = 6;
        let mut out = self.names[self.independent[base]].clone();
        for (&k, &factor) in self.dependent.iter().zip(self.combination.row(base).iter()) {
            if factor != 0.0 {
                let (sign, size) = (if factor < 0.0 { '−' } else { '+' }, factor.abs());
                let size = rounded(size, DIGITS);
                out += &match &*size {
                    "1" => format!(" {sign} {}", self.names[k]),
                    _ => format!(" {sign} {size}·{}", self.names[k]),
                };
            }
        }
        out
    }
}

impl fmt::Display for BaseParameters {
    /// A line for each base parameter, and what cannot be found.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for base in 0..self.len() {
            writeln!(f, "{:>4}  {}", base + 1, self.meaning(base))?;
        }
        if !self.without_effect.is_empty() {
            let names: Vec<&str> = self
                .without_effect
                .iter()
                .map(|&k| &*self.names[k])
                .collect();
            writeln!(f, "no force depends on: {}", names.join(", "))?;
        }
        Ok(())
    }
}

/// Size of an unknown's column, of unit length else: masses and rotors shall be seen as parts of moments, as mechanics does.
fn preference(unknown: Unknown) -> f64 {
    match unknown {
        Unknown::Inertia { number: 0, .. } => 1e-3,
        Unknown::Armature(_) => 1e-2,
        _ => 1.0,
    }
}

/// The permutation and R of a QR decomposition with column pivoting: each step takes the column of which most is left.
fn pivoted(m: DMatrix<f64>) -> (Vec<usize>, DMatrix<f64>) {
    let qr = m.col_piv_qr();
    let n = qr.r().ncols();
    let mut order = nalgebra::RowDVector::from_fn(n, |_, k| k as f64);
    qr.p().permute_columns(&mut order);
    (order.iter().map(|&k| k as usize).collect(), qr.r())
}

/// The regressor of random motions, one below the other.
fn random_equations(regressor: &Regressor) -> DMatrix<f64> {
    /// Largest velocity (rad/s or m/s) and acceleration: both matter beside gravity.
    const SPEED: f64 = 3.0;
    const ACCELERATION: f64 = 10.0;
    const SEED: u64 = 1;
    let model = regressor.model();
    let (nv, n) = (model.nv(), regressor.unknowns().len());
    let motions = (EQUATIONS * n).div_ceil(nv.max(1));
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(SEED);
    let mut out = DMatrix::zeros(motions * nv, n);
    for k in 0..motions {
        let q = model.random_configuration(&mut rng);
        let mut vector =
            |largest: f64| DVector::from_fn(nv, |_, _| rng.random_range(-largest..largest));
        let (v, a) = (vector(SPEED), vector(ACCELERATION));
        let own = regressor.matrix(q.as_slice(), v.as_slice(), a.as_slice());
        out.rows_mut(k * nv, nv).copy_from(&own);
    }
    out
}
