//! Steps of an inertia, along the symmetric matrices S: from the pseudo-inertia P = L Lᵀ to L (1 + S) Lᵀ.
//!
//! In these directions, which are those of the linear parameters, simulated motion is nearly linear; and they measure a change beside the body that there is, as
//! log-Cholesky parameters do: damping keeps a descent from bodies whose moments vanish.

use nalgebra::{Matrix4, SMatrix};

use crate::scalar::from_each;
use crate::spatial::{INERTIAL_PARAMETERS, Inertia};

/// The standard parameters of a body, or changes of them, by its directions.
type Square = SMatrix<f64, INERTIAL_PARAMETERS, INERTIAL_PARAMETERS>;

/// Entries of S by directions; those off the diagonal are halved, so that all are of length one.
const ENTRIES: [[usize; 2]; INERTIAL_PARAMETERS] = [
    [0, 0],
    [1, 1],
    [2, 2],
    [3, 3],
    [0, 1],
    [0, 2],
    [0, 3],
    [1, 2],
    [1, 3],
    [2, 3],
];

/// A body of which all moments of mass are positive.
pub(super) struct Body {
    inertia: Inertia<f64>,
    /// L.
    factor: Matrix4<f64>,
}

impl Body {
    /// The body with these standard parameters first; `None` if there is none.
    pub(super) fn new(x: &[f64]) -> Option<Self> {
        let inertia = Inertia::from_parameters(from_each(|k| x[k]));
        let factor = inertia.to_pseudo_inertia().cholesky()?.l();
        Some(Self { inertia, factor })
    }

    /// L C Lᵀ as standard parameters.
    fn parameters(&self, change: &Matrix4<f64>) -> [f64; INERTIAL_PARAMETERS] {
        let pseudo = self.factor * change * self.factor.transpose();
        Inertia::from_pseudo_inertia(&pseudo).to_parameters()
    }

    /// Derivatives of the standard parameters in the directions, a row for each parameter.
    pub(super) fn slopes(&self) -> Square {
        let mut out = Square::zeros();
        for (k, mut column) in out.column_iter_mut().enumerate() {
            let mut along = [0.0; INERTIAL_PARAMETERS];
            along[k] = 1.0;
            column.copy_from_slice(&self.parameters(&symmetric(&along)));
        }
        out
    }

    /// The standard parameters after a step: L (1 + S) Lᵀ, but where an eigenvalue of 1 + S is below the half it falls inversely to the step instead of
    /// linearly. Not finite if the step is not.
    pub(super) fn moved(&self, d: &[f64]) -> [f64; INERTIAL_PARAMETERS] {
        let change = symmetric(d);
        if !change.iter().all(|x| x.is_finite()) {
            return [f64::NAN; INERTIAL_PARAMETERS];
        }
        let eigen = change.symmetric_eigen();
        let moments = Matrix4::from_diagonal(&eigen.eigenvalues.map(moment));
        let turn = eigen.eigenvectors;
        self.parameters(&(turn * moments * turn.transpose()))
    }

    /// Log-Cholesky parameters.
    pub(super) fn log_cholesky(&self) -> [f64; INERTIAL_PARAMETERS] {
        self.inertia.to_log_cholesky()
    }

    /// Derivatives of the log-Cholesky parameters in the directions, a row for each parameter.
    pub(super) fn log_slopes(&self) -> Option<Square> {
        let jacobian = Inertia::log_cholesky_jacobian(self.log_cholesky());
        Some(jacobian.try_inverse()? * self.slopes())
    }
}

/// S along d.
fn symmetric(d: &[f64]) -> Matrix4<f64> {
    let mut out = Matrix4::zeros();
    for (&[i, j], d) in ENTRIES.iter().zip(d) {
        let entry = if i == j { *d } else { d * 0.5_f64.sqrt() };
        (out[(i, j)], out[(j, i)]) = (entry, entry);
    }
    out
}

/// 1 + s, and from the half on downward ¼ / −s, which has the same value and slope there.
fn moment(s: f64) -> f64 {
    if s > -0.5 { 1.0 + s } else { -0.25 / s }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::SAME_ALGEBRA;

    // Some link of an arm.
    const ARM: [f64; INERTIAL_PARAMETERS] =
        [2.3, 0.1, -0.02, 0.5, 0.2, 0.002, 0.19, -0.03, 0.005, 0.04];

    #[test]
    fn small_steps_are_sums_and_large_ones_stay_bodies() {
        let own = Body::new(&ARM).unwrap();
        let mut n_bent = 0;
        for k in 0..INERTIAL_PARAMETERS {
            for d in [1e-6, 0.4, 3.0, 1e4].into_iter().flat_map(|d| [d, -d]) {
                let mut along = [0.0; INERTIAL_PARAMETERS];
                along[k] = d;
                let moved = own.moved(&along);
                assert!(Body::new(&moved).is_some(), "{k} by {d}: {moved:?}");
                let linear = own.slopes() * SMatrix::from(along);
                let off = (0..INERTIAL_PARAMETERS).map(|i| (moved[i] - ARM[i] - linear[i]).abs());
                let is_bent = off.fold(0.0, f64::max) > SAME_ALGEBRA * d.abs().max(1.0);
                // An entry off the diagonal has eigenvalues of both signs.
                let least = if k < 4 { d } else { -d.abs() * 0.5_f64.sqrt() };
                assert_eq!(is_bent, least < -0.5, "{k} by {d}");
                n_bent += usize::from(is_bent);
            }
        }
        assert!(n_bent > INERTIAL_PARAMETERS);
    }

    #[test]
    fn slopes_equal_central_differences() {
        const STEP: f64 = 1e-6;
        let own = Body::new(&ARM).unwrap();
        let (slopes, log_slopes) = (own.slopes(), own.log_slopes().unwrap());
        for k in 0..INERTIAL_PARAMETERS {
            let at = |by: f64| {
                let mut along = [0.0; INERTIAL_PARAMETERS];
                along[k] = by;
                own.moved(&along)
            };
            let [a, b] = [at(STEP), at(-STEP)];
            let logs = [&a, &b].map(|x| Body::new(x).unwrap().log_cholesky());
            for i in 0..INERTIAL_PARAMETERS {
                let error = (a[i] - b[i]) / (2.0 * STEP) - slopes[(i, k)];
                assert!(error.abs() < 1e-8, "{i} by {k}: {error}");
                let error = (logs[0][i] - logs[1][i]) / (2.0 * STEP) - log_slopes[(i, k)];
                assert!(error.abs() < 1e-8, "logarithm {i} by {k}: {error}");
            }
        }
    }

    #[test]
    fn what_is_no_body_is_none() {
        let mut flat = ARM;
        flat[0] = -1.0;
        assert!(Body::new(&flat).is_none());
        assert!(Body::new(&[f64::NAN; INERTIAL_PARAMETERS]).is_none());
    }
}
