//! Derivatives of the equations of one block.

use super::Law;
use super::law::Piece;
use crate::scalar::Scalar;

/// A 3 × 3 matrix by rows.
pub(super) type Square<T = f64> = [[T; 3]; 3];

fn zero<T: Scalar>() -> Square<T> {
    [[T::zero(); 3]; 3]
}

fn identity<T: Scalar>() -> Square<T> {
    let mut out = zero();
    (0..3).for_each(|i| out[i][i] = T::one());
    out
}

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
        let square = |m: &Square| m.map(|row| row.map(T::from));
        EquationJacobian {
            f: square(&self.f),
            y: square(&self.y),
            mu: self.mu.map(T::from),
        }
    }
}

/// Derivatives of [`equations`](super::law::equations).
pub(super) fn jacobian_of<T: Scalar>(
    piece: Piece,
    f: [T; 3],
    y: [T; 3],
    mu: T,
    kappa: f64,
) -> EquationJacobian<T> {
    match piece {
        Piece::Stick => of_projection(identity(), [T::zero(); 3]),
        Piece::Separated => of_projection(zero(), [T::zero(); 3]),
        Piece::Frictionless => {
            let mut normal = zero();
            normal[0][0] = T::one();
            of_projection(normal, [T::zero(); 3])
        }
        Piece::Slip(law) => slip(law, f, y, mu),
        Piece::PathOfRay => {
            let (mut by_f, mut by_y) = (identity(), zero());
            (by_f[0][0], by_y[0][0]) = (y[0], f[0]);
            EquationJacobian {
                f: by_f,
                y: by_y,
                mu: [T::zero(); 3],
            }
        }
        Piece::PathOfCone(Law::Convex) => path_of_convex(f, y, mu),
        Piece::PathOfCone(Law::Coulomb) => path_of_coulomb(f, y, mu, kappa),
    }
}

/// e = f − Π(f − y, μ):  ∂e/∂f = 1 − Π′,  ∂e/∂y = Π′.
fn of_projection<T: Scalar>(slope: Square<T>, by_mu: [T; 3]) -> EquationJacobian<T> {
    let mut f = identity();
    for i in 0..3 {
        for j in 0..3 {
            f[i][j] -= slope[i][j];
        }
    }
    EquationJacobian {
        f,
        y: slope,
        mu: by_mu.map(|slope| -slope),
    }
}

/// Π = (p, μ p d):  Π′ = (p′, μ d p′ + μ p d′),  d′ = (1 − d dᵀ) / l.
fn slip<T: Scalar>(law: Law, f: [T; 3], y: [T; 3], mu: T) -> EquationJacobian<T> {
    let a = [f[0] - y[0], f[1] - y[1], f[2] - y[2]];
    let l = (a[1] * a[1] + a[2] * a[2]).sqrt();
    let d = [a[1] / l, a[2] / l];
    let (p, by_a, by_mu) = match law {
        Law::Convex => {
            let share = T::one() / (mu * mu + 1.0);
            let p = (a[0] + mu * l) * share;
            let by_a = [share, share * mu * d[0], share * mu * d[1]];
            (p, by_a, (l - mu * p * 2.0) * share)
        }
        Law::Coulomb => (a[0], [T::one(), T::zero(), T::zero()], T::zero()),
    };
    let mut slope = [by_a, [T::zero(); 3], [T::zero(); 3]];
    for i in 0..2 {
        for j in 0..3 {
            slope[1 + i][j] = mu * d[i] * by_a[j];
        }
        for j in 0..2 {
            let across = if i == j {
                -d[i] * d[j] + 1.0
            } else {
                -d[i] * d[j]
            };
            slope[1 + i][1 + j] += mu * p * across / l;
        }
    }
    let along = p + mu * by_mu;
    of_projection(slope, [by_mu, d[0] * along, d[1] * along])
}

fn path_of_convex<T: Scalar>(f: [T; 3], y: [T; 3], mu: T) -> EquationJacobian<T> {
    let zero = T::zero();
    let (mu2, weight) = (mu * mu, mu * mu * f[0]);
    EquationJacobian {
        f: [y, [mu2 * y[1], y[0], zero], [mu2 * y[2], zero, y[0]]],
        y: [f, [f[1], weight, zero], [f[2], zero, weight]],
        mu: [zero, mu * f[0] * y[1] * 2.0, mu * f[0] * y[2] * 2.0],
    }
}

fn path_of_coulomb<T: Scalar>(f: [T; 3], y: [T; 3], mu: T, kappa: f64) -> EquationJacobian<T> {
    let zero = T::zero();
    let inside = mu * mu * f[0] * f[0] - f[1] * f[1] - f[2] * f[2];
    let by_f = [mu * mu * f[0] * 2.0, f[1] * -2.0, f[2] * -2.0];
    let by_mu = mu * f[0] * f[0] * 2.0;
    let mut rows = [[y[0], zero, zero], [zero; 3], [zero; 3]];
    for i in 1..3 {
        rows[i] = by_f.map(|slope| slope * y[i]);
        rows[i][i] += T::constant(kappa);
    }
    EquationJacobian {
        f: rows,
        y: [
            [f[0], zero, zero],
            [zero, inside, zero],
            [zero, zero, inside],
        ],
        mu: [zero, by_mu * y[1], by_mu * y[2]],
    }
}
