//! Diagonal scaling of the state before a Riccati equation is solved.
//!
//! With x = D x̂ the equation keeps its form and its data become
//!
//! ```text
//!   Â = D⁻¹ A D,    Ĝ = D⁻¹ G D⁻¹,    Ĥ = D H D,    P̂ = D P D
//! ```
//!
//! D is chosen so that what drives a state (its row of A and of G) and what the state drives (its column of A and of H)
//! are of equal size. G and H count for the states that have both: with one alone a state would be scaled until it does
//! not matter. The entries of D are powers of two, so the scaling itself rounds nothing.

use nalgebra::{DMatrix, DVector};

use super::triple::Triple;
use crate::scalar::MapEach;

/// Sweeps over all states. One settles a lightly coupled system; more than this only chase the last factor of two.
const SWEEPS: usize = 12;

/// Largest power of two by which a state is scaled relative to the common factor. It binds when a matrix holds rounding
/// noise where it should hold zeros: scaling further would lift the noise to the size of the data.
const EXPONENT_LIMIT: i32 = 24;

/// Largest power of two of the common factor, so that D² and D⁻² stay finite.
const COMMON_EXPONENT_LIMIT: i32 = 200;

/// The diagonal of D.
pub(super) struct Balance {
    scale: DVector<f64>,
}

impl Balance {
    /// The scaling that balances `triple`.
    pub(super) fn of(triple: &Triple) -> Self {
        let n = triple.a.nrows();
        let common = common_exponent(triple);
        let mut exponents = vec![common; n];
        let mut scaled = Self::from_exponents(&exponents).apply(triple);
        for _ in 0..SWEEPS {
            let updated = sweep(&scaled, &exponents, common);
            if updated == exponents {
                break;
            }
            exponents = updated;
            scaled = Self::from_exponents(&exponents).apply(triple);
        }
        Self::from_exponents(&exponents)
    }

    fn from_exponents(exponents: &[i32]) -> Self {
        let scale = exponents.iter().map(|&e| 2.0_f64.powi(e));
        Self {
            scale: DVector::from_iterator(exponents.len(), scale),
        }
    }

    /// The triple in the coordinates x̂.
    pub(super) fn apply(&self, triple: &Triple) -> Triple {
        Triple {
            a: self.state_map(&triple.a),
            g: self.product(&triple.g, |d| 1.0 / d),
            h: self.product(&triple.h, |d| d),
        }
    }

    /// D⁻¹ A D.
    pub(super) fn state_map(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        a.map_with_location(|i, j, entry| entry / self.scale[i] * self.scale[j])
    }

    /// D⁻¹ B.
    pub(super) fn input(&self, b: &DMatrix<f64>) -> DMatrix<f64> {
        b.map_with_location(|i, _, entry| entry / self.scale[i])
    }

    /// D H D.
    pub(super) fn cost(&self, h: &DMatrix<f64>) -> DMatrix<f64> {
        self.product(h, |d| d)
    }

    /// P = D⁻¹ P̂ D⁻¹, back in the coordinates x.
    pub(super) fn restore_cost(&self, p: &DMatrix<f64>) -> DMatrix<f64> {
        self.product(p, |d| 1.0 / d)
    }

    /// K = K̂ D⁻¹, back in the coordinates x.
    pub(super) fn restore_gain(&self, k: &DMatrix<f64>) -> DMatrix<f64> {
        k.map_with_location(|_, j, entry| entry / self.scale[j])
    }

    fn product(&self, m: &DMatrix<f64>, factor: impl Fn(f64) -> f64) -> DMatrix<f64> {
        m.map_with_location(|i, j, entry| entry * factor(self.scale[i]) * factor(self.scale[j]))
    }
}

/// The exponent e of the common factor 2ᵉ that makes Ĝ and Ĥ equally large, or whichever of them is not zero as large
/// as A.
fn common_exponent(triple: &Triple) -> i32 {
    let [a, g, h] = [&triple.a, &triple.g, &triple.h].map_each(DMatrix::amax);
    // 4ᵉ H ~ 4⁻ᵉ G
    let quarters = match (g > 0.0, h > 0.0) {
        (true, true) => 0.5 * (g.log2() - h.log2()),
        (true, false) if a > 0.0 => g.log2() - a.log2(),
        (false, true) if a > 0.0 => a.log2() - h.log2(),
        _ => 0.0,
    };
    rounded(0.5 * quarters).clamp(-COMMON_EXPONENT_LIMIT, COMMON_EXPONENT_LIMIT)
}

/// One pass over the states, each scaled by the square root of the ratio of what drives it to what it drives.
///
/// The dynamics are those after the changes already made in this pass, so that neighbours do not overshoot together.
fn sweep(scaled: &Triple, exponents: &[i32], common: i32) -> Vec<i32> {
    let mut change = vec![0; exponents.len()];
    for i in 0..exponents.len() {
        let weight = |j: usize| 2.0_f64.powi(change[j]);
        let (mut driven, mut driving) = (0.0, 0.0);
        for j in (0..exponents.len()).filter(|&j| j != i) {
            driven += scaled.a[(i, j)].abs() * weight(j);
            driving += scaled.a[(j, i)].abs() / weight(j);
        }
        let (input, cost) = (scaled.g.column(i).amax(), scaled.h.column(i).amax());
        if input > 0.0 && cost > 0.0 {
            driven += input;
            driving += cost;
        }
        if driven > 0.0 && driving > 0.0 {
            let wanted = rounded(0.5 * (driven / driving).log2());
            let bounded = (exponents[i] - common + wanted).clamp(-EXPONENT_LIMIT, EXPONENT_LIMIT);
            change[i] = bounded - (exponents[i] - common);
        }
    }
    exponents.iter().zip(&change).map(|(e, c)| e + c).collect()
}

/// The nearest exponent that a number can have, zero for what is NaN.
fn rounded(x: f64) -> i32 {
    let limit = f64::from(f64::MAX_EXP);
    // The cast makes NaN zero.
    x.round().clamp(-limit, limit) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cart_like() -> Triple {
        Triple {
            a: DMatrix::from_row_slice(2, 2, &[1.0, 1e-3, 0.0, 1.0]),
            g: DMatrix::from_row_slice(2, 2, &[1e-9, 1e-6, 1e-6, 1e-3]),
            h: DMatrix::from_row_slice(2, 2, &[1e3, 0.0, 0.0, 1.0]),
        }
    }

    #[test]
    fn restored_cost_equals_the_scaled_one_bit_by_bit() {
        let triple = cart_like();
        let balance = Balance::of(&triple);
        assert_eq!(
            balance.restore_cost(&balance.cost(&triple.h)),
            triple.h,
            "scale {}",
            balance.scale
        );
    }

    #[test]
    fn balanced_rows_and_columns_are_of_equal_size() {
        let balanced = Balance::of(&cart_like()).apply(&cart_like());
        let ratio = balanced.g.amax() / balanced.h.amax();
        assert!((1.0 / 64.0..64.0).contains(&ratio), "ratio {ratio}");
    }

    #[test]
    fn zero_and_huge_data_give_a_finite_scale() {
        for (a, g, h) in [(0.0, 0.0, 0.0), (1.0, 1e300, 1e-300), (1.0, 0.0, 1e300)] {
            let [a, g, h] = [a, g, h].map(|x| DMatrix::from_element(1, 1, x));
            let balance = Balance::of(&Triple { a, g, h });
            assert!(balance.scale[0].is_normal());
        }
    }
}
