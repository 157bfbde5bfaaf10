//! Products of small matrices, blocked for registers: the matrices of a stage are too small for a library's packing to
//! pay, and must not allocate.

use crate::scalar::Scalar;

/// A matrix by columns.
#[derive(Clone, Copy)]
pub(crate) struct ColumnMajor<'a> {
    /// Entries, column by column.
    pub(crate) data: &'a [f64],
    /// Number of rows, at least one.
    pub(crate) rows: usize,
}

impl<'a> ColumnMajor<'a> {
    /// Makes the product s A Bᵀ.
    pub(crate) fn times_transposed(self, b: Self, scale: f64) -> Product<'a> {
        Product { a: self, b, scale }
    }
}

/// The product s A Bᵀ of two matrices with the same number of columns.
#[derive(Clone, Copy)]
pub(crate) struct Product<'a> {
    a: ColumnMajor<'a>,
    b: ColumnMajor<'a>,
    /// s.
    scale: f64,
}

/// Part of a product that is computed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    All,
    /// Entries on and above the diagonal; some below it are written too.
    Upper,
}

use crate::scalar::TILE;

impl Product<'_> {
    /// Adds the product to C.
    ///
    /// * `c` – C by columns, `stride` numbers from one to the next
    pub(crate) fn add_to(self, c: &mut [f64], stride: usize, part: Part) {
        let mut j = 0;
        while j < self.b.rows {
            let columns = &mut c[j * stride..];
            j += match self.b.rows - j {
                TILE.. => self.strip::<TILE>(columns, stride, j, part),
                3 => self.strip::<3>(columns, stride, j, part),
                2 => self.strip::<2>(columns, stride, j, part),
                _ => self.strip::<1>(columns, stride, j, part),
            };
        }
    }

    /// Adds `J` columns of the product from column `j` on; returns `J`.
    fn strip<const J: usize>(self, c: &mut [f64], stride: usize, j: usize, part: Part) -> usize {
        let end = match part {
            Part::All => self.a.rows,
            Part::Upper => self.a.rows.min(j + J),
        };
        let mut i = 0;
        while i < end {
            // A tile may reach below what is requested, not below the matrix.
            i += match self.a.rows - i {
                8.. if end - i > 4 => self.tile::<8, J>(c, stride, i, j),
                4.. => self.tile::<4, J>(c, stride, i, j),
                2.. => self.tile::<2, J>(c, stride, i, j),
                _ => self.tile::<1, J>(c, stride, i, j),
            };
        }
        J
    }

    /// Adds `R` rows of `J` columns from row `i` and column `j` on; returns `R`.
    #[inline(always)]
    fn tile<const R: usize, const J: usize>(
        self,
        c: &mut [f64],
        stride: usize,
        i: usize,
        j: usize,
    ) -> usize {
        let Self { a, b, scale } = self;
        let mut sum = [[0.0; R]; J];
        for (a, b) in a.data.chunks_exact(a.rows).zip(b.data.chunks_exact(b.rows)) {
            let a: &[f64; R] = a[i..i + R].try_into().expect("R rows");
            let b: &[f64; J] = b[j..j + J].try_into().expect("J columns");
            for j in 0..J {
                for r in 0..R {
                    sum[j][r] = Scalar::mul_add(a[r], b[j], sum[j][r]);
                }
            }
        }
        for (j, sum) in sum.iter().enumerate() {
            let c = &mut c[j * stride + i..j * stride + i + R];
            for r in 0..R {
                c[r] = Scalar::mul_add(sum[r], scale, c[r]);
            }
        }
        R
    }
}

/// out += s x, entry by entry.
pub(crate) fn add_scaled<T: Scalar>(out: &mut [T], x: &[T], s: T) {
    let both = out.iter_mut().zip(x);
    both.for_each(|(out, &x)| *out = x.mul_add(s, *out));
}

pub(crate) fn dot<T: Scalar>(x: &[T], y: &[T]) -> T {
    let products = x.iter().zip(y).map(|(&x, &y)| x * y);
    products.fold(T::zero(), |sum, x| sum + x)
}

/// Copies what is above the diagonal of a square matrix below it.
pub(crate) fn mirror_upper(m: &mut [f64], n: usize) {
    for j in 1..n {
        for i in 0..j {
            m[i * n + j] = m[j * n + i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    fn column_major(m: &DMatrix<f64>) -> ColumnMajor<'_> {
        ColumnMajor {
            data: m.as_slice(),
            rows: m.nrows(),
        }
    }

    #[test]
    fn blocked_product_equals_the_one_of_nalgebra_for_all_small_sizes() {
        let matrix = |rows, cols, seed: usize| {
            DMatrix::from_fn(rows, cols, |i, j| ((seed + 7 * i + 3 * j) as f64).sin())
        };
        for (rows, inner, cols) in (1..20).flat_map(|n| [(n, 5, 20 - n), (n, 1, n), (n, n, 3)]) {
            let (a, b) = (matrix(rows, inner, 1), matrix(cols, inner, 2));
            let c = matrix(rows, cols, 3);
            let expected = &c - 2.0 * &a * b.transpose();
            let product = column_major(&a).times_transposed(column_major(&b), -2.0);
            let mut all = c.clone();
            product.add_to(all.as_mut_slice(), rows, Part::All);
            assert!((&all - &expected).amax() < 1e-13, "{rows} {inner} {cols}");
            let mut upper = c;
            product.add_to(upper.as_mut_slice(), rows, Part::Upper);
            let difference = (upper - expected).upper_triangle();
            assert!(difference.amax() < 1e-13, "{rows} {inner} {cols}");
        }
    }
}
