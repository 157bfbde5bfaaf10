//! LU factors of a small dense matrix in plain storage.

use crate::scalar::{GROUP, Linear, Scalar, plus_scaled, vectorized};

/// A pivot this small is rounding: its unknown is left at zero rather than divided by noise. The matrices here have rows of size 1.
const NO_PIVOT: f64 = 1e-14;

/// 1 in the entries of a group below each of them.
const BELOW: [[f64; GROUP]; GROUP] = below();

const fn below() -> [[f64; GROUP]; GROUP] {
    let mut out = [[0.0; GROUP]; GROUP];
    let mut at = 0;
    while at < GROUP * GROUP {
        let (k, i) = (at / GROUP, at % GROUP);
        out[k][i] = if i > k { 1.0 } else { 0.0 };
        at += 1;
    }
    out
}

/// A Q = L D⁻¹ U by columns, where L and U both have the pivots D on their diagonals, with partial pivoting among columns.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lu {
    n: usize,
    /// Number of groups of entries in a column.
    groups: usize,
    /// Column after column, each filled up with zeros.
    a: Vec<[f64; GROUP]>,
    /// Order of the columns: Q, and its exchanges.
    order: Vec<usize>,
    exchanges: Vec<usize>,
    reciprocals: Vec<f64>,
    /// The smallest pivot, by magnitude.
    pub(crate) smallest: f64,
}

impl Lu {
    /// Makes room for up to so many rows.
    pub(crate) fn reserve(&mut self, n: usize) {
        self.a.reserve(n * n.div_ceil(GROUP));
        self.order.reserve(n);
        self.exchanges.reserve(n);
        self.reciprocals.reserve(n);
    }

    /// Starts with an n × n matrix of zeros.
    pub(crate) fn start(&mut self, n: usize) {
        (self.n, self.groups) = (n, n.div_ceil(GROUP));
        self.a.clear();
        self.a.resize(n * self.groups, [0.0; GROUP]);
        self.order.clear();
        self.order.extend(0..n);
        self.exchanges.resize(n, 0);
        self.reciprocals.resize(n, 0.0);
    }

    #[inline(always)]
    fn column(&self, j: usize) -> &[f64] {
        let groups = self.groups;
        &self.a[groups * j..groups * (j + 1)].as_flattened()[..self.n]
    }

    /// A column of the matrix that is to be factorised.
    #[inline(always)]
    pub(crate) fn column_mut(&mut self, j: usize) -> &mut [f64] {
        let (n, groups) = (self.n, self.groups);
        &mut self.a[groups * j..groups * (j + 1)].as_flattened_mut()[..n]
    }

    /// Factorises the columns.
    pub(crate) fn factorize(&mut self) {
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

    /// Brings the column with the largest entry in row k forward.
    #[inline(always)]
    fn exchange(&mut self, k: usize) -> f64 {
        let groups = self.groups;
        let entry = |j: usize| self.a[groups * j + k / GROUP][k % GROUP];
        let (mut at, mut pivot) = (k, entry(self.order[k]));
        // Mostly there is no larger one, which is quickly seen.
        let mut others = self.order[k + 1..].iter();
        if others.any(|&j| entry(j).abs() > pivot.abs()) {
            for (i, &j) in self.order.iter().enumerate().skip(k + 1) {
                if entry(j).abs() > pivot.abs() {
                    (at, pivot) = (i, entry(j));
                }
            }
        }
        self.exchanges[k] = at;
        self.order.swap(k, at);
        pivot
    }

    /// Takes multiples of column k from those after it, below row k.
    #[inline(always)]
    fn eliminate(&mut self, k: usize) {
        let (groups, own, reciprocal) = (self.groups, self.order[k], self.reciprocals[k]);
        let in_pivots = k / GROUP;
        for group in in_pivots..groups {
            let mut l = self.a[groups * own + group];
            if group == in_pivots {
                for i in 0..GROUP {
                    l[i] *= BELOW[k % GROUP][i];
                }
            }
            for &j in &self.order[k + 1..] {
                let factor = self.a[groups * j + in_pivots][k % GROUP] * reciprocal;
                let column = &mut self.a[groups * j + group];
                *column = plus_scaled(column, -factor, &l);
            }
        }
    }

    /// x ← A⁻¹ x.
    #[inline(always)]
    pub(crate) fn solve<T: Linear<f64>>(&self, x: &mut [T]) {
        self.solve_over::<f64, T>(x);
    }

    /// [`solve`](Self::solve) where the entries of A act as numbers of type `P`.
    #[inline(always)]
    pub(crate) fn solve_over<P: Scalar, T: Linear<P>>(&self, x: &mut [T]) {
        for (k, &j) in self.order.iter().enumerate() {
            let (done, rest) = x.split_at_mut(k + 1);
            let share = done[k] * P::from(self.reciprocals[k]);
            let l = &self.column(j)[k + 1..][..rest.len()];
            for i in 0..rest.len() {
                rest[i] = share.times_plus(P::from(-l[i]), rest[i]);
            }
        }
        for (k, &j) in self.order.iter().enumerate().rev() {
            let (rest, done) = x.split_at_mut(k);
            done[0] = done[0] * P::from(self.reciprocals[k]);
            let u = &self.column(j)[..k];
            for i in 0..k {
                rest[i] = done[0].times_plus(P::from(-u[i]), rest[i]);
            }
        }
        for (k, &at) in self.exchanges.iter().enumerate().rev() {
            x.swap(k, at);
        }
    }

    /// x ← A⁻ᵀ x: the parts of [`solve`](Self::solve), each transposed, in the other order.
    pub(crate) fn solve_transposed<T: Linear<f64>>(&self, x: &mut [T]) {
        for (k, &at) in self.exchanges.iter().enumerate() {
            x.swap(k, at);
        }
        for (k, &j) in self.order.iter().enumerate() {
            let known = x.iter().zip(&self.column(j)[..k]);
            let left = known.fold(x[k], |left, (x, &u)| x.times_plus(-u, left));
            x[k] = left * self.reciprocals[k];
        }
        for (k, &j) in self.order.iter().enumerate().rev() {
            let known = x[k + 1..].iter().zip(&self.column(j)[k + 1..]);
            let sum = known.fold(T::zero(), |sum, (x, &l)| x.times_plus(l, sum));
            x[k] -= sum * self.reciprocals[k];
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
        lu.start(3);
        for (j, column) in a.chunks(3).enumerate() {
            lu.column_mut(j).copy_from_slice(column);
        }
        lu.factorize();
        let mut x = [1.0, -2.0, 0.5];
        lu.solve(&mut x);
        for (i, b) in [1.0, -2.0, 0.5].into_iter().enumerate() {
            let product: f64 = (0..3).map(|k| a[3 * k + i] * x[k]).sum();
            assert!((product - b).abs() < 1e-14);
        }
        let mut x = [1.0, -2.0, 0.5];
        lu.solve_transposed(&mut x);
        for (i, b) in [1.0, -2.0, 0.5].into_iter().enumerate() {
            let product: f64 = (0..3).map(|k| a[3 * i + k] * x[k]).sum();
            assert!((product - b).abs() < 1e-14);
        }
    }

    #[test]
    fn unknowns_of_zero_columns_are_left_at_zero() {
        let mut lu = Lu::default();
        lu.start(2);
        lu.column_mut(0)[0] = 2.0;
        lu.factorize();
        let mut x = [3.0, 1.0];
        lu.solve(&mut x);
        assert_eq!((x, lu.smallest), ([1.5, 0.0], 0.0));
    }
}
