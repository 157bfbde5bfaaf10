//! Derivatives of the equations of one block.

use super::law::{Piece, equations};
use crate::scalar::{Dual, MapEach, Scalar, from_each};

/// A 3 × 3 matrix by rows.
pub(super) type Square<T = f64> = [[T; 3]; 3];

/// ∂e/∂f, ∂e/∂y and ∂e/∂μ of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct EquationJacobian<T = f64> {
    pub(super) f: Square<T>,
    pub(super) y: Square<T>,
    pub(super) mu: [T; 3],
}

impl EquationJacobian {
    /// Over another scalar.
    pub(super) fn cast<T: Scalar>(&self) -> EquationJacobian<T> {
        let square = |m: &Square| m.map_each(|row| row.map_each(T::from));
        EquationJacobian {
            f: square(&self.f),
            y: square(&self.y),
            mu: self.mu.map_each(T::from),
        }
    }
}

/// Derivatives of [`equations`], by dual numbers in f, y and μ.
#[inline]
pub(super) fn jacobian_of<T: Scalar>(
    piece: Piece,
    f: [T; 3],
    y: [T; 3],
    mu: T,
    kappa: f64,
) -> EquationJacobian<T> {
    let seeded = |x: [T; 3], first: usize| -> [Dual<T, 7>; 3] {
        from_each(|i| Dual::variable(x[i], first + i))
    };
    let e = equations(
        piece,
        seeded(f, 0),
        seeded(y, 3),
        Dual::variable(mu, 6),
        kappa,
    );
    let square = |first: usize| e.map_each(|e| [e.eps[first], e.eps[first + 1], e.eps[first + 2]]);
    EquationJacobian {
        f: square(0),
        y: square(3),
        mu: e.map_each(|e| e.eps[6]),
    }
}
