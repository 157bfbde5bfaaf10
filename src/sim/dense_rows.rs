//! Rows of a robot, which is one tree: J, X and G with all their entries.
//!
//! With M = Lᵀ D L and Lᵀ X = Jᵀ, which keeps the zeros of J,  G = Xᵀ D⁻¹ X: half of each solution is enough.

use std::ops::Range;

use super::lane_rows::LaneRows;
use super::sparse_rows::SparseRows;
use crate::dynamics::MassMatrixFactor;
use crate::scalar::{GROUP, Scalar, TILE, each, plus_scaled, vectorized};

/// J, X and G of rows.
#[derive(Clone, Debug)]
pub(super) struct DenseRows<T> {
    nv: usize,
    /// J, row by row, `nv` numbers each.
    jacobian: Vec<T>,
    /// X with Lᵀ X = (Jᵀ, τ), filled up with zeros: for each group of rows, coordinate after coordinate.
    half: Vec<[T; GROUP]>,
    /// D⁻¹ X of one group.
    scaled: Vec<[T; GROUP]>,
    /// G.
    matrix: Vec<T>,
    /// Of lanes, in place of X.
    lanes: LaneRows<T>,
}

/// Rows that have just been added, in sequence, and the marks of their coordinates.
pub(super) type Added<'a, T> = (&'a mut [T], &'a mut [bool]);

impl<T: Scalar> DenseRows<T> {
    /// Memory for so many.
    pub(super) fn new(nv: usize, rows: usize) -> Self {
        Self {
            nv,
            jacobian: Vec::with_capacity(rows * nv),
            half: Vec::with_capacity((rows / GROUP + 1) * nv),
            scaled: Vec::with_capacity(nv),
            matrix: Vec::with_capacity(rows * rows),
            lanes: LaneRows::new(nv, rows),
        }
    }

    /// Takes back all rows from one on.
    pub(super) fn truncate(&mut self, rows: usize) {
        self.jacobian.truncate(rows * self.nv);
        self.lanes.truncate(rows);
    }

    /// Adds rows of zeros, which it returns.
    pub(super) fn grow(&mut self, rows: Range<usize>) -> Added<'_, T> {
        let start = self.jacobian.len();
        self.jacobian
            .resize(start + rows.len() * self.nv, T::zero());
        (&mut self.jacobian[start..], self.lanes.grow(rows))
    }

    /// X, G, and J M⁻¹ τ for the forces τ along the coordinates.
    pub(super) fn form(
        &mut self,
        factor: &MassMatrixFactor<T>,
        count: usize,
        tau: &[T],
        offset: &mut Vec<T>,
    ) {
        self.matrix.resize(count * count, T::zero());
        offset.resize(count, T::zero());
        if const { T::LANES > 1 } {
            return self.form_lanes(factor, tau, offset);
        }
        self.transpose(count, tau);
        vectorized(
            #[inline(always)]
            || {
                factor.back_substitute_together(&mut self.half);
                for first in (0..count).step_by(GROUP) {
                    self.multiply(factor, first, offset);
                }
            },
        );
    }

    /// The same of lanes.
    fn form_lanes(&mut self, factor: &MassMatrixFactor<T>, tau: &[T], offset: &mut [T]) {
        let (n, matrix) = (offset.len(), &mut self.matrix);
        self.lanes.form(
            factor,
            (n, &self.jacobian),
            tau,
            #[inline(always)]
            |row, column, x| match row < n {
                true => (matrix[row + n * column], matrix[column + n * row]) = (x, x),
                false => offset[column] = x,
            },
        );
    }

    /// Jᵀ, and τ beside it.
    fn transpose(&mut self, count: usize, tau: &[T]) {
        let nv = self.nv;
        self.clear_halves(count);
        let rows = self.jacobian.chunks_exact(nv.max(1));
        for (i, row) in rows.chain([tau]).enumerate() {
            let own = &mut self.half[nv * (i / GROUP)..][..nv];
            for k in 0..nv {
                own[k][i % GROUP] = row[k];
            }
        }
    }

    /// Zeros for X of so many rows and of one more.
    fn clear_halves(&mut self, count: usize) {
        self.half.clear();
        let groups = count / GROUP + 1;
        self.half.resize(self.nv * groups, [T::zero(); GROUP]);
    }

    /// The columns of Xᵀ D⁻¹ X for one group of rows.
    #[inline(always)]
    fn multiply(&mut self, factor: &MassMatrixFactor<T>, first: usize, offset: &mut [T]) {
        let (nv, count) = (self.nv, offset.len());
        let end = count.min(first + GROUP);
        self.scaled.clear();
        for (k, x) in self.half[nv * (first / GROUP)..][..nv].iter().enumerate() {
            let reciprocal = factor.reciprocal(k);
            self.scaled.push(each(|i| x[i] * reciprocal));
        }
        for from in (first..=count).step_by(GROUP) {
            for column in (first..end).step_by(TILE) {
                let x = &self.half[nv * (from / GROUP)..][..nv];
                let tile = products(x, &self.scaled, column - first);
                self.store(&tile, from, column, offset);
            }
        }
    }

    /// Puts what is on and below the diagonal of G on both sides of it, and what stands after its last row where it belongs.
    #[inline(always)]
    fn store(&mut self, tile: &[[T; GROUP]; TILE], from: usize, first: usize, offset: &mut [T]) {
        let n = offset.len();
        for j in first..n.min(first + TILE) {
            let column = &tile[j - first];
            for i in j.max(from)..n.min(from + GROUP) {
                self.matrix[i + n * j] = column[i - from];
                self.matrix[j + n * i] = column[i - from];
            }
            if n < from + GROUP {
                offset[j] = column[n - from];
            }
        }
    }

    /// Takes J and X of rows on several trees, for derivatives.
    pub(super) fn take(&mut self, sparse: &SparseRows<T>, count: usize) {
        self.truncate(0);
        sparse.fill_jacobian(self.grow(0..count).0);
        self.clear_halves(count);
        sparse.fill_halves(&mut self.half);
    }

    /// An entry of J.
    pub(super) fn entry(&self, row: usize, k: usize) -> T {
        self.jacobian[self.nv * row + k]
    }

    /// The entries of J in so many first rows, in sequence.
    pub(super) fn first_rows(&self, rows: usize) -> &[T] {
        &self.jacobian[..self.nv * rows]
    }

    /// X with Lᵀ X = Jᵀ, for each group of rows: their entries for each coordinate.
    pub(super) fn halves(&self) -> impl Iterator<Item = &[[T; GROUP]]> {
        self.half.chunks_exact(self.nv.max(1))
    }

    /// X of one row, coordinate after coordinate.
    pub(super) fn half(&self, row: usize) -> impl Iterator<Item = T> {
        let group = &self.half[self.nv * (row / GROUP)..][..self.nv];
        group.iter().map(move |x| x[row % GROUP])
    }

    /// G.
    pub(super) fn matrix(&self) -> &[T] {
        &self.matrix
    }

    /// n M⁻¹ nᵀ of a row n under a matrix M of which the factors are given.
    pub(super) fn delassus_of(
        &self,
        factor: &MassMatrixFactor<T>,
        row: usize,
        memory: &mut Vec<T>,
    ) -> T {
        memory.clear();
        memory.extend_from_slice(&self.jacobian[self.nv * row..][..self.nv]);
        vectorized(
            #[inline(always)]
            || {
                factor.back_substitute(&mut memory[..]);
                factor.square(0, memory)
            },
        )
    }

    /// Adds J of a coordinate, times `x`.
    pub(super) fn turn(&self, k: usize, x: T, offset: &mut [T]) {
        for (row, offset) in offset.iter_mut().enumerate() {
            *offset = self.entry(row, k).mul_add(x, *offset);
        }
    }

    /// a = M⁻¹ (τ + Jᵀ f)
    pub(super) fn accelerations(&self, factor: &MassMatrixFactor<T>, f: &[T], a: &mut [T]) {
        if const { T::LANES > 1 } {
            return T::vectorized(
                #[inline(always)]
                || {
                    a.fill(T::zero());
                    self.lanes.push(f, a);
                    factor.forward_substitute(a);
                },
            );
        }
        vectorized(
            #[inline(always)]
            || {
                a.fill(T::zero());
                for (group, x) in self.halves().enumerate() {
                    push(x, &f[GROUP * group..], a);
                }
                factor.forward_substitute(a);
            },
        );
    }
}

/// τ ← τ + Xᵀ f of one group of rows.
///
/// * `f` – forces of these rows and all later ones
#[inline(always)]
fn push<T: Scalar>(x: &[[T; GROUP]], f: &[T], tau: &mut [T]) {
    // What the forces act beside stands after the last row, as if it had a force of one.
    let mut forces = [T::one(); GROUP];
    for i in 0..GROUP.min(f.len()) {
        forces[i] = f[i];
    }
    let x = &x[..tau.len()];
    for (k, tau) in tau.iter_mut().enumerate() {
        // One after the other: a row without a force, which a lane has for the sake of others, then changes no bit of the sum.
        for i in 0..GROUP {
            *tau = x[k][i].mul_add(forces[i], *tau);
        }
    }
}

/// X Yᵀ, of which as many columns as a tile has, from `first` on.
#[inline(always)]
pub(super) fn products<T: Scalar>(
    x: &[[T; GROUP]],
    y: &[[T; GROUP]],
    first: usize,
) -> [[T; GROUP]; TILE] {
    let mut out = [[T::zero(); GROUP]; TILE];
    for (x, y) in x.iter().zip(y) {
        let y = &y[first..first + TILE];
        for j in 0..TILE {
            out[j] = plus_scaled(&out[j], y[j], x);
        }
    }
    out
}
