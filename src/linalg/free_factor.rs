//! The Cholesky factor of some rows and columns of a matrix.

/// The curvature is not positive definite along free directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NotConvex;

/// L Lᵀ = H over the free entries.
#[derive(Clone, Debug)]
pub(crate) struct FreeFactor {
    /// Indices of the free entries, rising.
    pub(crate) free: Vec<usize>,
    /// L by rows of length n.
    pub(crate) l: Vec<f64>,
    n: usize,
}

impl FreeFactor {
    pub(crate) fn new(n: usize) -> Self {
        Self {
            free: Vec::with_capacity(n),
            l: vec![0.0; n * n],
            n,
        }
    }

    /// Factorises the rows and columns that are free.
    ///
    /// * `h` – H, n × n, of which the upper triangle by columns is read
    pub(crate) fn factorize(&mut self, h: &[f64]) -> Result<(), NotConvex> {
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
    pub(crate) fn solve(&self, x: &mut [f64]) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::SAME_ALGEBRA;
    use nalgebra::{DMatrix, DVector};

    // H_ij = 1 / (i + j + 1) + δᵢⱼ; of each choice of rows and columns the dense solution.
    #[test]
    fn solutions_over_free_entries_equal_those_of_the_dense_submatrix() {
        let n = 5;
        let h = DMatrix::from_fn(n, n, |i, j| {
            1.0 / (i + j + 1) as f64 + f64::from(u8::from(i == j))
        });
        for mask in 0..1_usize << n {
            let mut factor = FreeFactor::new(n);
            factor.free.extend((0..n).filter(|i| mask >> i & 1 == 1));
            factor.factorize(h.as_slice()).unwrap();
            let free = factor.free.clone();
            let sub = DMatrix::from_fn(free.len(), free.len(), |i, j| h[(free[i], free[j])]);
            let b = DVector::from_fn(free.len(), |i, _| 1.0 - i as f64);
            let mut x = b.clone();
            factor.solve(x.as_mut_slice());
            assert!(
                (sub * x - b).iter().all(|e| e.abs() < SAME_ALGEBRA),
                "{free:?}"
            );
        }
    }

    // Only the first two rows and columns of diag(1, 1, −1) are positive definite.
    #[test]
    fn negative_curvature_matters_along_free_entries_alone() {
        let h = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 1.0, -1.0]));
        let mut factor = FreeFactor::new(3);
        factor.free.extend([0, 1]);
        assert_eq!(factor.factorize(h.as_slice()), Ok(()));
        factor.free.push(2);
        assert_eq!(factor.factorize(h.as_slice()), Err(NotConvex));
    }
}
