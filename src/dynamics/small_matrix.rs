//! Inverse of the small symmetric matrices that joints with several degrees of freedom have.

use crate::joint::MAX_NV;
use crate::scalar::Scalar;

pub(super) type Small<T> = [[T; MAX_NV]; MAX_NV];

/// The inverse of the leading n × n block of a symmetric positive definite matrix, by L D Lᵀ without pivoting: no decision depends
/// on a value.
pub(super) fn inverse<T: Scalar>(a: &Small<T>, n: usize) -> Small<T> {
    let (l, d) = factorize(a, n);
    let mut out = [[T::zero(); MAX_NV]; MAX_NV];
    for column in 0..n {
        // L y = e,  x = L⁻ᵀ D⁻¹ y
        let mut x = [T::zero(); MAX_NV];
        x[column] = T::one();
        for i in column..n {
            for k in column..i {
                x[i] -= l[i][k] * x[k];
            }
        }
        for i in (0..n).rev() {
            x[i] /= d[i];
            for k in i + 1..n {
                x[i] -= l[k][i] * x[k];
            }
        }
        for i in 0..n {
            out[i][column] = x[i];
        }
    }
    out
}

/// A = L D Lᵀ with unit lower triangular L.
fn factorize<T: Scalar>(a: &Small<T>, n: usize) -> (Small<T>, [T; MAX_NV]) {
    let mut l = [[T::zero(); MAX_NV]; MAX_NV];
    let mut d = [T::zero(); MAX_NV];
    for j in 0..n {
        d[j] = (0..j).fold(a[j][j], |sum, k| sum - l[j][k] * l[j][k] * d[k]);
        for i in j + 1..n {
            let sum = (0..j).fold(a[i][j], |sum, k| sum - l[i][k] * l[j][k] * d[k]);
            l[i][j] = sum / d[j];
        }
    }
    (l, d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_times_matrix_is_the_identity() {
        let b: Small<f64> =
            std::array::from_fn(|i| std::array::from_fn(|k| ((3 * i + 5 * k) % 7) as f64 - 2.5));
        let a: Small<f64> = std::array::from_fn(|i| {
            std::array::from_fn(|k| {
                (0..6).map(|l| b[i][l] * b[k][l]).sum::<f64>() + if i == k { 1.0 } else { 0.0 }
            })
        });
        for n in 1..=6 {
            let inverse = inverse(&a, n);
            for i in 0..n {
                for k in 0..n {
                    let product: f64 = (0..n).map(|l| a[i][l] * inverse[l][k]).sum();
                    assert!(
                        (product - if i == k { 1.0 } else { 0.0 }).abs() < 1e-11,
                        "n = {n}: ({i}, {k}) is {product}"
                    );
                }
            }
        }
    }
}
