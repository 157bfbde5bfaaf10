//! Normal equations of the regression, coordinate by coordinate.

use nalgebra::{DMatrix, DVector};

use super::base::BaseParameters;
use super::dataset::{Dataset, Segment};
use super::regressor::{Regressor, Unknown};
use super::robot::{Moments, Prediction, Robot, Samples};
use crate::scalar::{Over, Scalar};

/// Samples that are multiplied at once: a block of them stays in the cache.
const BLOCK: usize = 256;

/// Normal equations of the force along one velocity coordinate, in the base parameters on which it depends.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    /// The base parameters.
    columns: Vec<usize>,
    /// Number of equations.
    pub(super) rows: usize,
    /// [Y y]ᵀ [Y y], with the measured forces y less what is known of them.
    products: DMatrix<f64>,
    /// [Y y]ᵀ of some samples.
    block: DMatrix<f64>,
    filled: usize,
}

impl Equations {
    fn new(base: &BaseParameters, coordinate: usize) -> Self {
        let columns: Vec<usize> = (0..base.len())
            .filter(|&k| base.acts_on(k, coordinate))
            .collect();
        let n = columns.len() + 1;
        Self {
            columns,
            rows: 0,
            products: DMatrix::zeros(n, n),
            block: DMatrix::zeros(n, BLOCK),
            filled: 0,
        }
    }

    /// Takes an equation.
    fn push(&mut self, entry: impl Fn(usize) -> f64, force: f64) {
        let n = self.columns.len();
        let mut column = self.block.column_mut(self.filled);
        for (to, &k) in column.iter_mut().zip(&self.columns) {
            *to = entry(k);
        }
        column[n] = force;
        self.filled += 1;
        self.rows += 1;
        if self.filled == BLOCK {
            self.multiply();
        }
    }

    /// Adds the products of the block.
    fn multiply(&mut self) {
        let block = self.block.columns(0, self.filled);
        self.products.gemm(1.0, &block, &block.transpose(), 1.0);
        self.filled = 0;
    }

    /// Σ y².
    fn square(&self) -> f64 {
        self.products[(self.columns.len(), self.columns.len())]
    }

    /// Computes ‖Y β − y‖², at least what rounding leaves of it.
    pub(super) fn residual(&self, base: &DVector<f64>) -> f64 {
        /// Relative rounding of the products of some thousand equations.
        const ROUNDING: f64 = 1e-14;
        let n = self.columns.len();
        let x = DVector::from_fn(n + 1, |i, _| match i < n {
            true => base[self.columns[i]],
            false => -1.0,
        });
        x.dot(&(&self.products * &x)).max(ROUNDING * self.square())
    }

    /// Adds w `YᵀY` and w `Yᵀy` to the equations of all base parameters.
    pub(super) fn add_to(&self, weight: f64, matrix: &mut DMatrix<f64>, right: &mut DVector<f64>) {
        let n = self.columns.len();
        for (k, &column) in self.columns.iter().enumerate() {
            for (i, &row) in self.columns.iter().enumerate() {
                matrix[(row, column)] += weight * self.products[(i, k)];
            }
            right[column] += weight * self.products[(k, n)];
        }
    }
}

/// Collects the equations of data, one set for each velocity coordinate.
pub(super) fn collect(
    regressor: &Regressor,
    base: &BaseParameters,
    data: &Dataset,
) -> Vec<Equations> {
    match Samples::is_supported() {
        true => collect_over::<Samples>(regressor, base, data),
        false => collect_over::<f64>(regressor, base, data),
    }
}

fn collect_over<T: Over<f64>>(
    regressor: &Regressor,
    base: &BaseParameters,
    data: &Dataset,
) -> Vec<Equations> {
    let nv = regressor.model().nv();
    let mut out: Vec<_> = (0..nv).map(|k| Equations::new(base, k)).collect();
    let known = Robot::of(regressor, &DVector::zeros(regressor.unknowns().len()));
    let mut scratch = Prediction::new(regressor.model());
    let mut tau = vec![T::zero(); nv];
    let has_friction = has_friction(regressor);
    for segment in &data.segments {
        for first in (0..segment.len()).step_by(T::LANES) {
            let at = Moments::<T>::of(segment, first);
            let rows = regressor.matrix(&at.q, &at.v, &at.a);
            known.predict_into(&at.q, &at.v, &at.a, &mut scratch, &mut tau);
            let block = Block {
                first,
                rows: &rows,
                known: &tau,
                has_friction: &has_friction,
            };
            block.push(regressor, base, segment, &mut out);
        }
    }
    out.iter_mut().for_each(Equations::multiply);
    out
}

/// Velocity coordinates with unknown dry friction.
fn has_friction(regressor: &Regressor) -> Vec<bool> {
    let mut out = vec![false; regressor.model().nv()];
    for unknown in regressor.unknowns() {
        if let Unknown::DryFriction(k) = unknown {
            out[*k] = true;
        }
    }
    out
}

/// The regressor at some samples.
struct Block<'a, T> {
    first: usize,
    rows: &'a DMatrix<T>,
    known: &'a [T],
    has_friction: &'a [bool],
}

impl<T: Scalar> Block<'_, T> {
    fn push(
        &self,
        regressor: &Regressor,
        base: &BaseParameters,
        segment: &Segment,
        out: &mut [Equations],
    ) {
        let independent = &base.independent;
        for lane in 0..T::LANES.min(segment.len() - self.first) {
            let sample = self.first + lane;
            for (k, equations) in out.iter_mut().enumerate() {
                let is_known = (regressor.dry_friction()).is_none_or(|shape| {
                    !self.has_friction[k] || shape.is_known(segment.v[(k, sample)])
                });
                if is_known {
                    let force = segment.tau[(k, sample)] - self.known[k].value(lane);
                    equations.push(
                        |column| self.rows[(k, independent[column])].value(lane),
                        force,
                    );
                }
            }
        }
    }
}
