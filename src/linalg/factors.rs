//! Factors of a dense matrix that is written column by column, and solved with.

use super::lu::Lu;

/// The factors of a matrix, whichever they are.
pub(crate) trait Factors<T> {
    /// Starts with an n × n matrix of zeros.
    fn start(&mut self, n: usize);

    /// A column of the matrix that is to be factorised.
    fn column_mut(&mut self, j: usize) -> &mut [T];

    /// Factorises the columns.
    fn factorize(&mut self);

    /// x ← A⁻¹ x.
    fn solve(&self, x: &mut [T]);
}

impl Factors<f64> for Lu {
    fn start(&mut self, n: usize) {
        self.start(n);
    }

    fn column_mut(&mut self, j: usize) -> &mut [f64] {
        self.column_mut(j)
    }

    fn factorize(&mut self) {
        self.factorize();
    }

    fn solve(&self, x: &mut [f64]) {
        self.solve(x);
    }
}
