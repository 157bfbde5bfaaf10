//! Products of small matrices, blocked for registers: the matrices of a stage are too small for a library's packing to pay, and must
//! not allocate.

use crate::scalar::Scalar;

/// A matrix by columns: `rows` numbers each.
#[derive(Clone, Copy)]
pub(super) struct Columns<'a> {
    pub(super) data: &'a [f64],
    pub(super) rows: usize,
}

/// Which entries of a product are wanted.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    All,
    /// On and above the diagonal; some below it are written too.
    Upper,
}

/// Columns of the result that are worked off together.
const WIDTH: usize = 4;

/// C += s A Bᵀ, with A and B by columns, one for each of the inner indices.
///
/// * `c` – by columns, `stride` numbers from one to the next
pub(super) fn add_product(
    a: Columns<'_>,
    b: Columns<'_>,
    s: f64,
    (c, stride): (&mut [f64], usize),
    part: Part,
) {
    let mut j = 0;
    while j < b.rows {
        let columns = &mut c[j * stride..];
        j += match b.rows - j {
            WIDTH.. => strip::<WIDTH>(a, b, s, (columns, stride), j, part),
            3 => strip::<3>(a, b, s, (columns, stride), j, part),
            2 => strip::<2>(a, b, s, (columns, stride), j, part),
            _ => strip::<1>(a, b, s, (columns, stride), j, part),
        };
    }
}

/// `J` columns of the result from column `j` on; returns `J`.
fn strip<const J: usize>(
    a: Columns<'_>,
    b: Columns<'_>,
    s: f64,
    (c, stride): (&mut [f64], usize),
    j: usize,
    part: Part,
) -> usize {
    let end = match part {
        Part::All => a.rows,
        Part::Upper => a.rows.min(j + J),
    };
    let mut i = 0;
    while i < end {
        // A tile may reach below what is wanted, not below the matrix.
        i += match a.rows - i {
            8.. if end - i > 4 => tile::<8, J>(a, b, s, (c, stride), i, j),
            4.. => tile::<4, J>(a, b, s, (c, stride), i, j),
            2.. => tile::<2, J>(a, b, s, (c, stride), i, j),
            _ => tile::<1, J>(a, b, s, (c, stride), i, j),
        };
    }
    J
}

/// `R` rows from row `i` on; returns `R`.
#[inline(always)]
fn tile<const R: usize, const J: usize>(
    a: Columns<'_>,
    b: Columns<'_>,
    s: f64,
    (c, stride): (&mut [f64], usize),
    i: usize,
    j: usize,
) -> usize {
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
            c[r] = Scalar::mul_add(sum[r], s, c[r]);
        }
    }
    R
}

/// out += s x, entry by entry.
pub(super) fn add_scaled(out: &mut [f64], x: &[f64], s: f64) {
    let both = out.iter_mut().zip(x);
    both.for_each(|(out, &x)| *out = Scalar::mul_add(x, s, *out));
}

pub(super) fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// Copies what is above the diagonal of a square matrix below it.
pub(super) fn mirror_upper(m: &mut [f64], n: usize) {
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

    #[test]
    fn blocked_product_equals_the_one_of_nalgebra_for_all_small_sizes() {
        let matrix = |rows, cols, seed: usize| {
            DMatrix::from_fn(rows, cols, |i, j| ((seed + 7 * i + 3 * j) as f64).sin())
        };
        for (rows, inner, cols) in (1..20).flat_map(|n| [(n, 5, 20 - n), (n, 1, n), (n, n, 3)]) {
            let (a, b) = (matrix(rows, inner, 1), matrix(cols, inner, 2));
            let c = matrix(rows, cols, 3);
            let expected = &c - 2.0 * &a * b.transpose();
            let columns = |m: &DMatrix<f64>| (m.as_slice().to_vec(), m.nrows());
            let ((a, a_rows), (b, b_rows)) = (columns(&a), columns(&b));
            let a = Columns {
                data: &a,
                rows: a_rows,
            };
            let b = Columns {
                data: &b,
                rows: b_rows,
            };
            let mut all = c.clone();
            add_product(a, b, -2.0, (all.as_mut_slice(), rows), Part::All);
            assert!((&all - &expected).amax() < 1e-13, "{rows} {inner} {cols}");
            let mut upper = c;
            add_product(a, b, -2.0, (upper.as_mut_slice(), rows), Part::Upper);
            let difference = (upper - expected).upper_triangle();
            assert!(difference.amax() < 1e-13, "{rows} {inner} {cols}");
        }
    }
}
