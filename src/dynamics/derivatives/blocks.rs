//! Right-hand sides in blocks of columns.

use aligned_vec::{AVec, ConstAlign};

use super::propagate::Entries;
use crate::dynamics::mass_matrix_factor::MassMatrixFactor;
use crate::scalar::{BLOCK, CACHE_LINE, Pack, Scalar};

/// Columns of as many numbers as there are rows, in blocks that are worked on at once.
#[derive(Clone, Debug)]
pub(crate) struct Blocks<T = f64> {
    rows: usize,
    /// Block after block, each from the first row to the last. No vector lies across two cache lines, which costs a tenth.
    lanes: AVec<Pack<T, BLOCK>, ConstAlign<CACHE_LINE>>,
}

impl<T: Scalar> Blocks<T> {
    pub(crate) fn new(rows: usize, columns: usize) -> Self {
        let mut out = Self {
            rows,
            lanes: AVec::new(CACHE_LINE),
        };
        out.resize(rows, columns);
        out
    }

    pub(crate) fn clear(&mut self) {
        self.lanes.fill(Pack([T::zero(); BLOCK]));
    }

    /// Zeros in so many rows and columns; allocates if there have never been as many.
    pub(crate) fn resize(&mut self, rows: usize, columns: usize) {
        self.rows = rows;
        self.lanes.clear();
        let size = rows * columns.div_ceil(BLOCK);
        self.lanes.resize(size, Pack([T::zero(); BLOCK]));
    }

    #[inline(always)]
    pub(crate) fn at(&mut self, row: usize, column: usize) -> &mut T {
        entry(&mut self.lanes, self.rows, row, column)
    }

    #[inline(always)]
    pub(crate) fn view(&mut self) -> View<'_, T> {
        View {
            rows: self.rows,
            lanes: &mut self.lanes,
        }
    }

    /// Copies as many columns, from the first on, as there are outputs, each number changed on the way. By index: through the iterators of a matrix a number
    /// took a dozen instructions.
    ///
    /// * `outputs` – a slice for each column, as long as there are rows
    #[inline(always)]
    pub(crate) fn copy_columns_to<'a>(
        &self,
        mut outputs: impl Iterator<Item = &'a mut [T]>,
        change: impl Fn(T) -> T,
    ) {
        for block in self.blocks() {
            for (k, out) in (0..BLOCK).zip(outputs.by_ref()) {
                let out = &mut out[..block.len()];
                for i in 0..block.len() {
                    out[i] = change(block[i].0[k]);
                }
            }
        }
    }

    pub(crate) fn blocks(&self) -> impl Iterator<Item = &[Pack<T, BLOCK>]> {
        self.lanes.chunks_exact(self.rows.max(1))
    }

    /// Adds columns of the same size.
    pub(crate) fn add_all(&mut self, other: &Self) {
        let entries = self.lanes.iter_mut().zip(other.lanes.iter());
        entries.for_each(|(sum, &x)| *sum += x);
    }

    pub(crate) fn scale(&mut self, by: f64) {
        let entries = self.lanes.iter_mut();
        entries.for_each(|x| x.0.iter_mut().for_each(|x| *x = *x * by));
    }

    pub(crate) fn solve(&mut self, factor: &MassMatrixFactor<T>) {
        for block in self.blocks_mut() {
            factor.solve(block);
        }
    }

    pub(crate) fn blocks_mut(&mut self) -> impl Iterator<Item = &mut [Pack<T, BLOCK>]> {
        self.lanes.chunks_exact_mut(self.rows.max(1))
    }
}

/// Derivatives in q from the first column on, in v from column `nv` on.
impl<T: Scalar> Entries<T> for Blocks<T> {
    #[inline(always)]
    fn add(&mut self, row: usize, column: usize, by_q: T, by_v: T) {
        self.view().add(row, column, by_q, by_v);
    }
}

/// [`Blocks`] whose place is known once and for all.
pub(crate) struct View<'a, T> {
    rows: usize,
    lanes: &'a mut [Pack<T, BLOCK>],
}

impl<T: Scalar> Entries<T> for View<'_, T> {
    #[inline(always)]
    fn add(&mut self, row: usize, column: usize, by_q: T, by_v: T) {
        // As many rows as directions in q: those in v come next.
        *entry(self.lanes, self.rows, row, column) += by_q;
        *entry(self.lanes, self.rows, row, self.rows + column) += by_v;
    }
}

#[inline(always)]
fn entry<T>(lanes: &mut [Pack<T, BLOCK>], rows: usize, row: usize, column: usize) -> &mut T {
    &mut lanes[rows * (column / BLOCK) + row].0[column % BLOCK]
}
