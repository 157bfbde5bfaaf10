//! Eigenvalues, the stability boundary, and modes that are unreachable from the input or unobservable in the cost.
//!
//! A mode λ of A is unreachable from B exactly when [A − λI, B] loses rank [Popov 1973; Belevitch 1968;
//! Hautus 1969]. It is unobservable from Q exactly when it is an unreachable mode of (Aᵀ, Q).

use nalgebra::{Complex, DMatrix};

use super::balance::Balance;
use super::doubling::{TimeDomain, is_finite};
use super::riccati::Riccati;
use super::triple::Triple;
use crate::linalg::{eigenvalues as unsorted, svd};
use crate::sorting::sort_seldom;

/// Tolerances of the search for a hidden mode.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tolerances {
    /// Distance from the stability boundary up to which an eigenvalue counts as on it.
    boundary_width: f64,
    /// The rank defect of [A − λI, B], relative to A and with B scaled to the size of A, up to which λ counts as
    /// unreachable.
    rank_tolerance: f64,
}

/// Tolerances for a loop that looks stable: only what is hidden up to roundings counts.
pub(super) const STRICT: Tolerances = Tolerances {
    boundary_width: 1e-11,
    rank_tolerance: 1e-13,
};

/// Tolerances for a loop that is not stable, so that there is something to explain. A double eigenvalue is known only
/// to the square root of the rounding error, and both widths allow for that.
pub(super) const LENIENT: Tolerances = Tolerances {
    boundary_width: 3e-8,
    rank_tolerance: 1e-7,
};

/// The eigenvalues of a square matrix, from least to most stable; empty where it is not finite or the iteration fails.
pub(super) fn eigenvalues(time: TimeDomain, m: &DMatrix<f64>) -> Vec<Complex<f64>> {
    if m.is_empty() || !is_finite(m) {
        return Vec::new();
    }
    let mut values = unsorted(balanced(m));
    sort_seldom(&mut values, |x, y| {
        let key = |z: &Complex<f64>| (growth(time, *z), z.re, z.im);
        let ((a, b, c), (d, e, f)) = (key(x), key(y));
        d.total_cmp(&a).then(e.total_cmp(&b)).then(f.total_cmp(&c))
    });
    values
}

/// The modulus, or the real part: what the stability of a mode is judged by, and what eigenvalues are sorted by.
fn growth(time: TimeDomain, eigenvalue: Complex<f64>) -> f64 {
    match time {
        TimeDomain::Discrete => eigenvalue.norm(),
        TimeDomain::Continuous => eigenvalue.re,
    }
}

/// Stability margin: distance by which the least stable of the sorted `eigenvalues` is inside the stability boundary,
/// relative to the largest modulus in continuous time; negative outside, and −∞ without eigenvalues.
pub(super) fn margin(time: TimeDomain, eigenvalues: &[Complex<f64>]) -> f64 {
    let Some(&worst) = eigenvalues.first() else {
        return f64::NEG_INFINITY;
    };
    -excess(time, worst, largest_modulus(eigenvalues))
}

/// Finds the least stable mode on or outside the boundary that is unreachable from the input.
pub(super) fn unreachable_mode(riccati: &Riccati, tolerances: Tolerances) -> Option<Complex<f64>> {
    let suspect = |excess: f64| excess >= -tolerances.boundary_width;
    let pair = [&riccati.a, &riccati.b];
    hidden_mode(riccati.time, pair, suspect, tolerances.rank_tolerance)
}

/// Finds a mode on the boundary that is unobservable in the cost.
pub(super) fn unobservable_mode(riccati: &Riccati, tolerances: Tolerances) -> Option<Complex<f64>> {
    let suspect = |excess: f64| excess.abs() <= tolerances.boundary_width;
    let pair = [&riccati.a.transpose(), &riccati.q];
    hidden_mode(riccati.time, pair, suspect, tolerances.rank_tolerance)
}

/// The first mode λ of A, of those that are `suspect` by their distance outside the boundary, for which [A − λI, B]
/// loses rank.
fn hidden_mode(
    time: TimeDomain,
    [a, b]: [&DMatrix<f64>; 2],
    suspect: impl Fn(f64) -> bool,
    tolerance: f64,
) -> Option<Complex<f64>> {
    let modes = eigenvalues(time, a);
    let largest = largest_modulus(&modes);
    modes
        .into_iter()
        .filter(|&mode| suspect(excess(time, mode, largest)))
        .find(|&mode| rank_distance(a, b, mode) <= tolerance)
}

/// |λ| − 1, or Re λ relative to the largest modulus.
fn excess(time: TimeDomain, eigenvalue: Complex<f64>, largest: f64) -> f64 {
    match time {
        TimeDomain::Discrete => eigenvalue.norm() - 1.0,
        TimeDomain::Continuous if largest > 0.0 => eigenvalue.re / largest,
        TimeDomain::Continuous => 0.0,
    }
}

fn largest_modulus(eigenvalues: &[Complex<f64>]) -> f64 {
    eigenvalues.iter().map(|z| z.norm()).fold(0.0, f64::max)
}

/// Distance of [(A − λI) / ‖A‖, B / ‖B‖] from losing rank; zero matrices stay as they are.
///
/// The smallest singular value, in real numbers: of [Re, −Im; Im, Re], which has each singular value twice.
fn rank_distance(a: &DMatrix<f64>, b: &DMatrix<f64>, mode: Complex<f64>) -> f64 {
    let n = a.nrows();
    // All of the size of one, so that no square underflows.
    let unit = |size: f64| if size > 0.0 { size.recip() } else { 1.0 };
    let (scale, input_scale) = (unit(a.norm().max(mode.norm())), unit(b.norm()));
    let real = |i: usize, j: usize| match j.checked_sub(n) {
        None => (a[(i, j)] - if i == j { mode.re } else { 0.0 }) * scale,
        Some(input) => b[(i, input)] * input_scale,
    };
    let imaginary = |i, j| if i == j { -mode.im * scale } else { 0.0 };
    let width = n + b.ncols();
    // Transposed, so that it has more rows than columns.
    let pencil = DMatrix::from_fn(2 * width, 2 * n, |row, column| {
        let (i, j) = (column % n, row % width);
        match (column < n, row < width) {
            (true, true) | (false, false) => real(i, j),
            (true, false) => -imaginary(i, j),
            (false, true) => imaginary(i, j),
        }
    });
    svd(pencil, [false, false]).map_or(f64::INFINITY, |found| found.singular_values.min())
}

/// D⁻¹ M D with rows and columns of equal size.
fn balanced(m: &DMatrix<f64>) -> DMatrix<f64> {
    let zero = DMatrix::zeros(m.nrows(), m.nrows());
    let triple = Triple {
        a: m.clone(),
        g: zero.clone(),
        h: zero,
    };
    Balance::of(&triple).state_map(m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{ROUNDING, SAME_ALGEBRA};
    use approx::assert_relative_eq;
    use nalgebra::DVector;

    fn rotation(angle: f64, radius: f64) -> DMatrix<f64> {
        let (s, c) = angle.sin_cos();
        DMatrix::from_row_slice(2, 2, &[c, -s, s, c]) * radius
    }

    #[test]
    fn eigenvalues_of_a_scaled_rotation_equal_radius_and_angle() {
        let values = eigenvalues(TimeDomain::Discrete, &rotation(0.3, 1.5));
        assert_relative_eq!(values[0].norm(), 1.5, max_relative = 10.0 * ROUNDING);
        assert_relative_eq!(values[0].arg(), 0.3, max_relative = 10.0 * ROUNDING);
        assert_relative_eq!(values[1].arg(), -0.3, max_relative = 10.0 * ROUNDING);
    }

    // The eigenvalues of a cyclic shift are the n-th roots of one.
    #[test]
    fn eigenvalues_of_a_cyclic_shift_equal_the_roots_of_unity() {
        for n in [3, 4, 7, 12] {
            let shift = DMatrix::from_fn(n, n, |i, j| if i == (j + 1) % n { 1.0 } else { 0.0 });
            let values = eigenvalues(TimeDomain::Continuous, &shift);
            assert_eq!(values.len(), n);
            for value in values {
                assert!(
                    (value.powu(n as u32) - 1.0).norm() < SAME_ALGEBRA,
                    "n = {n}: {value}"
                );
            }
        }
    }

    #[test]
    fn eigenvalues_are_sorted_from_least_to_most_stable() {
        let m = DMatrix::from_diagonal(&DVector::from_vec(vec![0.5, -3.0, 2.0]));
        let real_parts = |time| {
            eigenvalues(time, &m)
                .iter()
                .map(|z| z.re)
                .collect::<Vec<_>>()
        };
        assert_eq!(real_parts(TimeDomain::Discrete), [-3.0, 2.0, 0.5]);
        assert_eq!(real_parts(TimeDomain::Continuous), [2.0, 0.5, -3.0]);
    }

    #[test]
    fn rank_is_lost_exactly_at_the_mode_without_input() {
        let a = DMatrix::from_diagonal(&DVector::from_vec(vec![2.0, 3.0, 0.5]));
        let b = DMatrix::from_vec(3, 1, vec![1.0, 0.0, 1.0]);
        let lost =
            [2.0, 3.0, 0.5].map(|mode| rank_distance(&a, &b, Complex::from(mode)) < ROUNDING);
        assert_eq!(lost, [false, true, false]);
    }

    #[test]
    fn standing_still_is_a_mode_that_an_input_reaches() {
        let (still, one) = (DMatrix::zeros(1, 1), DMatrix::from_element(1, 1, 1.0));
        let distance = |b| rank_distance(&still, b, Complex::default());
        assert_eq!((distance(&one), distance(&still)), (1.0, 0.0));
    }

    #[test]
    fn not_a_number_has_no_eigenvalues() {
        let m = DMatrix::from_element(3, 3, f64::NAN);
        assert!(eigenvalues(TimeDomain::Discrete, &m).is_empty());
    }
}
