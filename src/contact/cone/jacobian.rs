//! Derivatives of the equations of one block.

use super::Law;
use super::law::Piece;

/// A 3 × 3 matrix by rows.
pub(super) type Square<T = f64> = [[T; 3]; 3];

const ZERO: Square = [[0.0; 3]; 3];
const IDENTITY: Square = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// ∂e/∂f, ∂e/∂y and ∂e/∂μ of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct EquationJacobian {
    pub(super) f: Square,
    pub(super) y: Square,
    pub(super) mu: [f64; 3],
}

/// Derivatives of [`equations`](super::law::equations).
pub(super) fn jacobian_of(
    piece: Piece,
    f: [f64; 3],
    y: [f64; 3],
    mu: f64,
    kappa: f64,
) -> EquationJacobian {
    match piece {
        Piece::Stick => of_projection(IDENTITY, [0.0; 3]),
        Piece::Separated => of_projection(ZERO, [0.0; 3]),
        Piece::Frictionless => {
            let mut normal = ZERO;
            normal[0][0] = 1.0;
            of_projection(normal, [0.0; 3])
        }
        Piece::Slip(law) => slip(law, f, y, mu),
        Piece::PathOfRay => {
            let (mut by_f, mut by_y) = (IDENTITY, ZERO);
            (by_f[0][0], by_y[0][0]) = (y[0], f[0]);
            EquationJacobian {
                f: by_f,
                y: by_y,
                mu: [0.0; 3],
            }
        }
        Piece::PathOfCone(Law::Convex) => path_of_convex(f, y, mu),
        Piece::PathOfCone(Law::Coulomb) => path_of_coulomb(f, y, mu, kappa),
    }
}

/// e = f − Π(f − y, μ):  ∂e/∂f = 1 − Π′,  ∂e/∂y = Π′.
fn of_projection(slope: Square, by_mu: [f64; 3]) -> EquationJacobian {
    let mut f = IDENTITY;
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
fn slip(law: Law, f: [f64; 3], y: [f64; 3], mu: f64) -> EquationJacobian {
    let a = [f[0] - y[0], f[1] - y[1], f[2] - y[2]];
    let l = (a[1] * a[1] + a[2] * a[2]).sqrt();
    let d = [a[1] / l, a[2] / l];
    let (p, by_a, by_mu) = match law {
        Law::Convex => {
            let share = 1.0 / (1.0 + mu * mu);
            let p = (a[0] + mu * l) * share;
            let by_a = [share, share * mu * d[0], share * mu * d[1]];
            (p, by_a, (l - 2.0 * mu * p) * share)
        }
        Law::Coulomb => (a[0], [1.0, 0.0, 0.0], 0.0),
    };
    let mut slope = [by_a, [0.0; 3], [0.0; 3]];
    for i in 0..2 {
        for j in 0..3 {
            slope[1 + i][j] = mu * d[i] * by_a[j];
        }
        for j in 0..2 {
            let across = if i == j {
                1.0 - d[i] * d[j]
            } else {
                -d[i] * d[j]
            };
            slope[1 + i][1 + j] += mu * p * across / l;
        }
    }
    let along = p + mu * by_mu;
    of_projection(slope, [by_mu, d[0] * along, d[1] * along])
}

fn path_of_convex(f: [f64; 3], y: [f64; 3], mu: f64) -> EquationJacobian {
    let (mu2, weight) = (mu * mu, mu * mu * f[0]);
    EquationJacobian {
        f: [y, [mu2 * y[1], y[0], 0.0], [mu2 * y[2], 0.0, y[0]]],
        y: [f, [f[1], weight, 0.0], [f[2], 0.0, weight]],
        mu: [0.0, 2.0 * mu * f[0] * y[1], 2.0 * mu * f[0] * y[2]],
    }
}

fn path_of_coulomb(f: [f64; 3], y: [f64; 3], mu: f64, kappa: f64) -> EquationJacobian {
    let inside = mu * mu * f[0] * f[0] - f[1] * f[1] - f[2] * f[2];
    let by_f = [2.0 * mu * mu * f[0], -2.0 * f[1], -2.0 * f[2]];
    let by_mu = 2.0 * mu * f[0] * f[0];
    let mut rows = [[y[0], 0.0, 0.0], [0.0; 3], [0.0; 3]];
    for i in 1..3 {
        rows[i] = by_f.map(|slope| slope * y[i]);
        rows[i][i] += kappa;
    }
    EquationJacobian {
        f: rows,
        y: [[f[0], 0.0, 0.0], [0.0, inside, 0.0], [0.0, 0.0, inside]],
        mu: [0.0, by_mu * y[1], by_mu * y[2]],
    }
}
