//! Factors of the small symmetric matrices that joints with several degrees of freedom have.

use crate::scalar::Scalar;

/// The most coordinates that a joint has: those of free motion.
const MOST: usize = 6;

/// Replaces the lower triangle of a symmetric positive definite matrix, n rows of which the first n entries count, by
/// its factors: A = L D Lᵀ with unit lower triangular L below the diagonal and D⁻¹ on it. Without pivoting: no decision
/// depends on a value.
#[inline(always)]
pub(crate) fn factorize<T: Scalar, R: AsRef<[T]> + AsMut<[T]>>(a: &mut [R]) {
    match a {
        // Of known size the loops of the most frequent case, a floating base, are laid out flat.
        [_, _, _, _, _, _] => factorize_rows(&mut a[..MOST]),
        _ => factorize_rows(a),
    }
}

#[inline(always)]
fn factorize_rows<T: Scalar, R: AsRef<[T]> + AsMut<[T]>>(a: &mut [R]) {
    for j in 0..a.len() {
        let reciprocal = T::one() / a[j].as_ref()[j];
        // A_ik −= A_ij A_kj / A_jj
        for i in j + 1..a.len() {
            let ratio = -(a[i].as_ref()[j] * reciprocal);
            for k in j + 1..=i {
                let (below, own) = (a[k].as_ref()[j], a[i].as_ref()[k]);
                a[i].as_mut()[k] = ratio.mul_add(below, own);
            }
        }
        for row in &mut a[j + 1..] {
            row.as_mut()[j] *= reciprocal;
        }
        a[j].as_mut()[j] = reciprocal;
    }
}

/// Solves A x = b in place with the factors of A.
#[inline(always)]
pub(crate) fn solve<T: Scalar, R: AsRef<[T]>>(factors: &[R], x: &mut [T]) {
    match x {
        [_, _, _, _, _, _] => solve_rows(&factors[..MOST], &mut x[..MOST]),
        _ => solve_rows(factors, x),
    }
}

#[inline(always)]
fn solve_rows<T: Scalar, R: AsRef<[T]>>(factors: &[R], x: &mut [T]) {
    let n = factors.len();
    // L y = b
    for i in 0..n {
        for k in 0..i {
            x[i] = (-factors[i].as_ref()[k]).mul_add(x[k], x[i]);
        }
    }
    // Lᵀ x = D⁻¹ y
    for i in (0..n).rev() {
        x[i] *= factors[i].as_ref()[i];
        for k in i + 1..n {
            x[i] = (-factors[k].as_ref()[i]).mul_add(x[k], x[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrix_times_solution_is_the_right_hand_side() {
        let b: [[f64; MOST]; MOST] =
            std::array::from_fn(|i| std::array::from_fn(|k| ((3 * i + 5 * k) % 7) as f64 - 2.5));
        let a: [[f64; MOST]; MOST] = std::array::from_fn(|i| {
            std::array::from_fn(|k| {
                (0..6).map(|l| b[i][l] * b[k][l]).sum::<f64>() + if i == k { 1.0 } else { 0.0 }
            })
        });
        let right = [1.0, -2.0, 0.5, 3.0, -1.0, 4.0];
        for n in 1..=MOST {
            let (mut factors, mut x) = (a, right);
            factorize(&mut factors[..n]);
            solve(&factors[..n], &mut x[..n]);
            for i in 0..n {
                let product: f64 = (0..n).map(|k| a[i][k] * x[k]).sum();
                assert!(
                    (product - right[i]).abs() < 1e-11,
                    "n = {n}: row {i} is {product}"
                );
            }
        }
    }
}
