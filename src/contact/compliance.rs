//! Compliance of surfaces that touch.

use crate::constraint::{Impedance, Reference};
use crate::numbers::{Numbers, numbers};
use crate::scalar::Scalar;

/// How a surface yields, against one of the same material: the parameters of the contact model that belong to the material.
///
/// Between two materials:
///
/// | parameter | rule |
/// |---|---|
/// | time constant, damping ratio, impedance | mean of both, as in `MuJoCo` with equal weights |
/// | stiffness and damping of a reference acceleration | the larger ones, as in `MuJoCo`; against a time constant, these |
/// | stiffness K of soft contact | harmonic mean 2 K₁ K₂ / (K₁ + K₂): springs in series, as in Drake |
/// | damping D of soft contact | D / K is the mean of both D / K, weighted with the stiffness of the other surface, as in Drake: the softer surface counts more |
///
/// If only one of both materials has a compliance, it is that of the pair.
///
/// # Examples
/// ```
/// use dualbody::contact::{Compliance, Material, Materials};
///
/// let soft = |stiffness, damping| Material {
///     compliance: Some(Compliance::Soft { stiffness, damping }),
///     ..Material::default()
/// };
/// let table = Materials::default().with_material("foam", soft(1e3, 50.0)).with_material("wood", soft(3e3, 30.0));
/// let Some(Compliance::Soft { stiffness, damping }) = table.between("foam", "wood")?.compliance else { panic!("soft") };
/// assert!((stiffness - 1.5e3).abs() < 1e-9); // 2 · 1e3 · 3e3 / 4e3
/// assert!((damping - 60.0).abs() < 1e-9); // (¾ · 0.05 s/m + ¼ · 0.01 s/m) of it
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Compliance<P = f64> {
    /// For [`RelaxedRigid`](super::RelaxedRigid).
    Regularised {
        /// Coefficients of the reference acceleration.
        reference: Reference<P>,
        /// Enforced share of the reference acceleration.
        impedance: Impedance<P>,
    },
    /// For [`SoftContact`](super::SoftContact), whose exponents p and q are those of the contact model.
    Soft {
        /// K, N/m¹⁺ᵖ.
        stiffness: P,
        /// D, N·s/m¹⁺^q.
        damping: P,
    },
}

numbers! { pub enum Compliance {
    Regularised { reference: part(Reference), impedance: part(Impedance) },
    Soft {
        stiffness: Positive("stiffness", "stiffness of a material"),
        damping: NotNegative("damping", "damping of a material"),
    },
} }

impl<P: Scalar> Compliance<P> {
    /// That of two surfaces; of two for different contact models, which no table holds, the first one.
    fn between(&self, other: &Self) -> Self {
        match (*self, *other) {
            (
                Self::Regularised {
                    reference,
                    impedance,
                },
                Self::Regularised {
                    reference: second,
                    impedance: other,
                },
            ) => Self::Regularised {
                reference: reference.between(&second),
                impedance: impedance.between(&other),
            },
            (
                Self::Soft {
                    stiffness: a,
                    damping,
                },
                Self::Soft {
                    stiffness: b,
                    damping: other,
                },
            ) => {
                let share = P::one() / (a + b);
                let stiffness = a * share * b * 2.0;
                // a b is at least the smaller one squared: the ratios D / K are formed first, which are moderate.
                let ratio = damping / a * (b * share) + other / b * (a * share);
                Self::Soft {
                    stiffness,
                    damping: stiffness * ratio,
                }
            }
            (own, _) => own,
        }
    }

    /// That of two materials, of which both, one or none have a compliance.
    pub(super) fn of_both(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        match (one, other) {
            (Some(one), Some(other)) => Some(one.between(&other)),
            (one, other) => one.or(other),
        }
    }

    /// Whether another one is for the same contact model.
    pub(super) fn is_like<Q>(&self, other: &Compliance<Q>) -> bool {
        matches!(
            (self, other),
            (Self::Regularised { .. }, Compliance::Regularised { .. })
                | (Self::Soft { .. }, Compliance::Soft { .. })
        )
    }
}

/// The most parameters of a compliance.
pub(crate) const COMPLIANCE_NUMBERS: usize = <Compliance as Numbers<f64>>::COUNT;
