//! LU factors of a small dense matrix in plain storage.

use crate::scalar::{Scalar, vectorized};

/// A pivot this small is rounding: its unknown is left at zero rather than divided by noise. The matrices here have rows of size 1.
const NO_PIVOT: f64 = 1e-14;

/// P A = L U by columns, with partial pivoting.
#[derive(Clone, Debug, Default)]
pub(super) struct Lu {
    n: usize,
    a: Vec<f64>,
    rows: Vec<usize>,
    reciprocals: Vec<f64>,
    /// The smallest pivot, by magnitude.
    pub(super) smallest: f64,
}

impl Lu {
    /// Makes room for an n × n matrix and hands it out, by columns, to be filled in all its entries.
    pub(super) fn start(&mut self, n: usize) -> &mut [f64] {
        self.n = n;
        self.a.resize(n * n, 0.0);
        self.rows.resize(n, 0);
        self.reciprocals.resize(n, 0.0);
        &mut self.a
    }

    /// Factorises what [`Lu::start`] handed out.
    pub(super) fn factorize(&mut self) {
        vectorized(
            #[inline(always)]
            || self.eliminate_all(),
        );
    }

    #[inline(always)]
    fn eliminate_all(&mut self) {
        self.smallest = f64::INFINITY;
        for k in 0..self.n {
            let pivot = self.exchange(k);
            self.smallest = self.smallest.min(pivot.abs());
            let usable = pivot.abs() > NO_PIVOT;
            self.reciprocals[k] = if usable { 1.0 / pivot } else { 0.0 };
            self.eliminate(k);
        }
    }

    /// Brings the largest entry left in column k to the diagonal.
    #[inline(always)]
    fn exchange(&mut self, k: usize) -> f64 {
        let n = self.n;
        let column = &self.a[k * n..(k + 1) * n];
        let mut row = k;
        for i in k + 1..n {
            if column[i].abs() > column[row].abs() {
                row = i;
            }
        }
        self.rows[k] = row;
        if row != k {
            for column in self.a.chunks_exact_mut(n) {
                column.swap(k, row);
            }
        }
        self.a[k * n + k]
    }

    /// Takes multiples of row k from those below it.
    #[inline(always)]
    fn eliminate(&mut self, k: usize) {
        let n = self.n;
        let (done, rest) = self.a.split_at_mut((k + 1) * n);
        let l = &mut done[k * n + k + 1..];
        l.iter_mut().for_each(|l| *l *= self.reciprocals[k]);
        for column in rest.chunks_exact_mut(n) {
            let factor = column[k];
            if factor != 0.0 {
                for (entry, l) in column[k + 1..].iter_mut().zip(&*l) {
                    *entry -= l * factor;
                }
            }
        }
    }

    /// x ← A⁻¹ x.
    #[inline(always)]
    pub(super) fn solve<T: Scalar>(&self, x: &mut [T]) {
        let n = self.n;
        for k in 0..n {
            x.swap(k, self.rows[k]);
        }
        for k in 0..n {
            let (done, rest) = x.split_at_mut(k + 1);
            let column = &self.a[k * n + k + 1..(k + 1) * n];
            for (x, &l) in rest.iter_mut().zip(column) {
                *x = done[k].mul_add_real(-l, *x);
            }
        }
        for k in (0..n).rev() {
            let (rest, done) = x.split_at_mut(k);
            done[0] = done[0] * self.reciprocals[k];
            for (x, &u) in rest.iter_mut().zip(&self.a[k * n..k * n + k]) {
                *x = done[0].mul_add_real(-u, *x);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solution_times_the_matrix_is_the_right_side() {
        // By columns; the first pivot is not on the diagonal.
        let a = [0.0, 2.0, 1.0, 1.0, 0.5, -1.0, 3.0, 1.0, 1.0];
        let mut lu = Lu::default();
        lu.start(3).copy_from_slice(&a);
        lu.factorize();
        let mut x = [1.0, -2.0, 0.5];
        lu.solve(&mut x);
        for (i, b) in [1.0, -2.0, 0.5].into_iter().enumerate() {
            let product: f64 = (0..3).map(|k| a[3 * k + i] * x[k]).sum();
            assert!((product - b).abs() < 1e-14);
        }
    }

    #[test]
    fn unknowns_of_zero_columns_are_left_at_zero() {
        let mut lu = Lu::default();
        lu.start(2).copy_from_slice(&[2.0, 0.0, 0.0, 0.0]);
        lu.factorize();
        let mut x = [3.0, 1.0];
        lu.solve(&mut x);
        assert_eq!((x, lu.smallest), ([1.5, 0.0], 0.0));
    }
}
