//! Regularised constraints, as in `MuJoCo`.

use super::impedance::Impedance;
use super::reference::Reference;
use crate::numbers::numbers;
use crate::scalar::{Over, Scalar};

/// Parameters of a regularised constraint, which follows a damped oscillator and yields in proportion to its force, as the equalities of `MuJoCo`:
///
/// > φ̈ + b φ̇ + k d φ + R f = 0  with  R = (1 − d) / d · w.
///
/// The impedance d is between 0 and 1: the nearer to 1, the less the row yields. It is a function of the size of the error of the whole constraint, √(|p|² + (l |θ|)²) with errors
/// p of position and θ of angle.
///
/// | in `MuJoCo` | here |
/// |---|---|
/// | `solref` | [`reference`](Self::reference) |
/// | `solimp` | [`impedance`](Self::impedance) |
/// | `body_invweight0`, `dof_invweight0`, `tendon_invweight0`, the sum of both bodies, joints or tendons | [`inverse_mass`](Self::inverse_mass), [`inverse_inertia`](Self::inverse_inertia) |
/// | half of `torquescale` of a weld | [`lever`](Self::lever) |
///
/// # References
/// [Todorov 2014]; the chapter on computation of the manual of `MuJoCo`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regularisation<P = f64> {
    /// b and k of the reference acceleration −b φ̇ − k d φ.
    pub reference: Reference<P>,
    /// d, the enforced share of the reference acceleration.
    pub impedance: Impedance<P>,
    /// w of all rows but the angular ones of a weld, in the unit of acceleration per force, 1/kg for rows in m. A larger value makes
    /// the rows yield more. That of a body of mass m on a rail is 1 / m.
    pub inverse_mass: P,
    /// w of the angular rows of a weld, 1/(kg m²).
    pub inverse_inertia: P,
    /// l, the length by which an angle counts in the size of the error of a weld, m.
    pub lever: P,
}

numbers! { pub struct Regularisation {
    reference: part(Reference),
    impedance: part(Impedance),
    inverse_mass: NotNegative("inverse mass", "inverse mass of a constraint"),
    inverse_inertia: NotNegative("inverse inertia", "inverse inertia of a constraint"),
    lever: NotNegative("lever", "lever of a constraint"),
} }

impl Default for Regularisation {
    /// The defaults of `MuJoCo`: 20 ms, critically damped, d from 0.9 to 0.95 over 1 mm, a lever of ½ m; for 1 kg and 1 kg m².
    fn default() -> Self {
        Self {
            reference: Reference::TimeConstant {
                time_constant: 0.02,
                damping_ratio: 1.0,
            },
            impedance: Impedance::default(),
            inverse_mass: 1.0,
            inverse_inertia: 1.0,
            lever: 0.5,
        }
    }
}

/// Coefficients of all rows of a constraint at a state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoftGains<T> {
    /// b.
    pub(super) damping: T,
    /// k d.
    pub(super) stiffness: T,
    /// (1 − d) / d.
    pub(super) share: T,
    /// w of linear and of angular rows.
    pub(super) inverses: [T; 2],
}

/// Sizes of errors below this count as this, m: those of none have no derivative.
const NO_ERROR: f64 = 1e-15;

impl<P: Scalar> Regularisation<P> {
    /// Coefficients at errors.
    ///
    /// * `squares` – |p|² and |θ|²
    /// * `dt` – the step, s: time constants are bounded by it
    pub(crate) fn gains<T: Over<P>>(&self, squares: [T; 2], dt: T) -> SoftGains<T> {
        let lever = T::from(self.lever);
        let square = squares[0] + lever * lever * squares[1];
        let least = T::constant(NO_ERROR * NO_ERROR);
        let d = self
            .impedance
            .at(square.select_lt(least, least, square).sqrt());
        let (damping, stiffness) = self.reference.gains(&self.impedance, dt);
        SoftGains {
            damping,
            stiffness: stiffness * d,
            share: (T::one() - d) / d,
            inverses: [self.inverse_mass.into(), self.inverse_inertia.into()],
        }
    }
}
