//! The Cholesky factor of some rows and columns of a matrix.

/// The curvature is not positive definite along free directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NotConvex;

/// L Lᵀ = H over the free entries.
#[derive(Clone, Debug)]
pub(super) struct FreeFactor {
    /// Indices of the free entries, rising.
    pub(super) free: Vec<usize>,
    /// L by rows of length n.
    pub(super) l: Vec<f64>,
    n: usize,
}

impl FreeFactor {
    pub(super) fn new(n: usize) -> Self {
        Self {
            free: Vec::with_capacity(n),
            l: vec![0.0; n * n],
            n,
        }
    }

    /// Factorises the rows and columns that are free.
    ///
    /// * `h` – H, n × n, of which the upper triangle by columns is read
    pub(super) fn factorize(&mut self, h: &[f64]) -> Result<(), NotConvex> {
        let n = self.n;
        for (row, &i) in self.free.iter().enumerate() {
            for (column, &k) in self.free[..=row].iter().enumerate() {
                let (earlier, at) = self.l.split_at_mut(row * n);
                let other = if column == row {
                    &at[..n]
                } else {
                    &earlier[column * n..][..n]
                };
                let products = at[..column].iter().zip(other).map(|(x, y)| x * y);
                // The upper triangle: k ≤ i.
                let rest = h[i * n + k] - products.sum::<f64>();
                if column < row {
                    at[column] = rest / other[column];
                } else if rest > 0.0 && rest.is_finite() {
                    at[column] = rest.sqrt();
                } else {
                    return Err(NotConvex);
                }
            }
        }
        Ok(())
    }

    /// The first entries of x ← (L Lᵀ)⁻¹ x, as many as are free.
    pub(super) fn solve(&self, x: &mut [f64]) {
        let (n, l, count) = (self.n, &self.l, self.free.len());
        for i in 0..count {
            let sum: f64 = (0..i).map(|k| l[i * n + k] * x[k]).sum();
            x[i] = (x[i] - sum) / l[i * n + i];
        }
        for i in (0..count).rev() {
            let sum: f64 = (i + 1..count).map(|k| l[k * n + i] * x[k]).sum();
            x[i] = (x[i] - sum) / l[i * n + i];
        }
    }
}
