//! Regularised rigid contact: a convex problem, in which a point follows a damped spring and yields in proportion to its force.

use super::law::{ContactRow, LawKind, PointKinematics, PointLaw, ROWS};
use crate::cone::Law;
use crate::constraint::{Impedance, Reference};
use crate::contact::activation::ActivationMargin;
use crate::contact::compliance::Compliance;
use crate::contact::material::Material;
use crate::contact::reason::{ContactReason, PointOutcome};
use crate::contact::turning::TurningFriction;
use crate::numbers::numbers;
use crate::scalar::{Over, Scalar};

/// Rigid contact, regularised to a convex problem as in `MuJoCo`. The point follows the reference acceleration of a damped spring with the
/// regularisation R = (1 − d) / d · Gₙₙ. Its force is in the exact friction cone: it neither pulls nor exceeds friction. A contact that slides at v
/// also lifts at about μ v.
///
/// # Limitations
/// * Sticking contacts creep: under a friction force fₜ with b v = Rₜ fₜ. R is proportional to the exact diagonal Gₙₙ of the Delassus matrix, while
///   `MuJoCo` uses that of the body without rotation; so a box on its corners creeps several times as fast as in `MuJoCo`. A larger coefficient of
///   friction does not help, even an infinite one: with the defaults a plate of 0.5 m × 0.5 m creeps down a slope of 1.2 rad at 15.5 mm/s.
///   [`friction_impedance_ratio`](Self::friction_impedance_ratio) divides this speed.
/// * A stack of boxes is an elastic column, which buckles under its own weight if it is too high. With the time constant T and the largest impedance d,
///   about n = ∛(w / (g T² (1 − d))) cubes of width w stand, independent of their mass: ten of 0.2 m with the defaults. In lower stacks creep increases
///   an initial tilt exponentially, at 0.02/s (six boxes), 0.16/s (eight), 0.4/s (nine); higher stacks buckle at 0.9/s (ten) and 1.7/s (twelve). With
///   rounding as the only disturbance, ten boxes fall after 18 s, and eight stand for a minute. Contacts of `MuJoCo` are four times as stiff, for the
///   reason above, and carry ∛4 times as many boxes: with its elliptic cones 14 stand for a minute and 15 fall after 53 s; with pyramids 20 stand with a
///   tilt. For a higher stack raise the largest impedance: with 0.99, ten boxes stand for a minute at 1e-14 m/s, and the tilt of twelve grows at
///   0.003/s. A stack of [`Rigid`](crate::contact::Rigid) contacts does not buckle.
/// * Where the line of a normal passes close to the axis of the only joint that moves the point, Gₙₙ and R are nearly zero: a deep overlap there demands
///   joint accelerations that grow without bound. `MuJoCo` yields, since its R is that of the body. A robot whose shapes overlap at such a joint should exclude
///   this pair.
/// * With long steps, an impact lasts several steps and can tip a body that should slide: a box of width 0.4 times its height with μ = 0.37 on a
///   slope of ½ tips over at 10 ms. [`Rigid`](crate::contact::Rigid) distinguishes both cases correctly.
/// * The derivatives of each step are exact, but those of a motion through a bounce are biased at any step length. The depth at the first step in
///   contact is a sawtooth function of the state: the derivative contains its slope, but not its jumps. A ball thrown at 2 m/s from 0.6 m has ∂x/∂vz
///   = 0.017 after 1.5 s, and 0.068 by differences over 0.01 m/s; with [`SoftContact`](crate::contact::SoftContact) both are 0.064.
///
/// # References
/// [Todorov 2011]; [Todorov 2014]; the chapter on computation of the manual of `MuJoCo`. Columns under their own weight: [Greenhill 1881], whose critical height is
/// ∛(7.84 B / q) with the bending stiffness B and the weight q per length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelaxedRigid<P = f64> {
    /// μ, the coefficient of friction; infinite for no slip (contacts still creep, see above).
    pub friction: P,
    /// b and k of the reference acceleration −b v − k d δ.
    pub reference: Reference<P>,
    /// d, the enforced share of the reference acceleration.
    pub impedance: Impedance<P>,
    /// Ratio of normal to tangential regularisation, R / Rₜ: `impratio` of `MuJoCo`. 1 by default; with a larger ratio, a point that sticks on a
    /// slope creeps more slowly.
    pub friction_impedance_ratio: P,
}
numbers! { pub struct RelaxedRigid {
    friction: NotNegativeOrInfinite("friction", "friction of regularised rigid contact"),
    reference: part(Reference),
    impedance: part(Impedance),
    friction_impedance_ratio:
        Positive("friction impedance ratio", "ratio of impedances of regularised rigid contact"),
} }

impl Default for RelaxedRigid {
    /// μ = ½ and the defaults of `MuJoCo`: 20 ms, critically damped, d from 0.9 to 0.95 over 1 mm.
    fn default() -> Self {
        Self {
            friction: 0.5,
            reference: Reference::TimeConstant {
                time_constant: 0.02,
                damping_ratio: 1.0,
            },
            impedance: Impedance::default(),
            friction_impedance_ratio: 1.0,
        }
    }
}
impl<P: Scalar> RelaxedRigid<P> {
    /// Compliance R below the ground for an impedance d, and above it: (k d δ)² / κ more where the law is smoothed, which is felt there as
    /// well; without, infinite.
    ///
    /// * `pull` – k d δ, the reference acceleration of a point at rest, m/s²
    fn compliance<D: Scalar, T: Over<D>>(
        &self,
        at: &PointKinematics<'_, D, T>,
        d: T,
        pull: T,
    ) -> T {
        let below = (T::one() - d) / d * at.delassus;
        let above = match at.kappa {
            Some(kappa) => pull * pull * (D::one() / kappa) + below,
            None if at.speculative => below,
            None => T::constant(f64::INFINITY),
        };
        at.state.depth.select_lt(T::zero(), above, below)
    }
}

impl<P: Scalar> RelaxedRigid<P> {
    /// The normal row of a speculative point, whose depth increases in a step by at most the width w of the impedance: if it would increase more, vₙ⁺
    /// = (min(δ, 0) − w) / Δt without compliance. Smoothed contact already acts on points above the ground.
    fn before_it_passes<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        own: ContactRow<T>,
        at: &PointKinematics<'_, D, T>,
    ) -> ContactRow<T> {
        if at.kappa.is_some() {
            return own;
        }
        let (depth, zero, per_step) = (at.state.depth, T::zero(), D::one() / at.dt);
        let above = depth.select_lt(zero, depth, zero);
        let least = (above - T::from(self.impedance.width)) * per_step;
        let stopped = ContactRow {
            reference: (least - at.velocity()[0]) * per_step,
            compliance: zero,
        };
        let choose = |own_part: T, stopped_part: T| {
            let faster = own
                .reference
                .select_lt(stopped.reference, stopped_part, own_part);
            depth.select_lt(zero, stopped_part, faster)
        };
        ContactRow {
            reference: choose(own.reference, stopped.reference),
            compliance: choose(own.compliance, stopped.compliance),
        }
    }
}

impl<P: Scalar> PointLaw<P> for RelaxedRigid<P> {
    const KIND: LawKind = LawKind {
        name: "regularised rigid",
        solved_explicitly: true,
        solved_implicitly: true,
        cone: Law::Convex,
        bristle: false,
        acts_over_step: false,
        can_be_smoothed: true,
        working_set: false,
        reads_delassus: true,
    };

    fn material(&self) -> Material<P> {
        Material {
            friction: self.friction,
            restitution: P::zero(),
            margin: P::zero(),
            turning: TurningFriction::none(),
            compliance: None,
        }
    }

    fn set_material(&mut self, pair: Material<P>) {
        self.friction = pair.friction;
    }

    fn set_compliance(&mut self, own: Compliance<P>) -> bool {
        let Compliance::Regularised {
            reference,
            impedance,
        } = own
        else {
            return false;
        };
        (self.reference, self.impedance) = (reference, impedance);
        true
    }

    /// Takes points in the ground, and none above it.
    fn activation_margin<D: Scalar>(&self, _: D) -> ActivationMargin<D> {
        ActivationMargin::surface()
    }

    /// The point comes back with −b v − k d δ; across it follows −b v.
    fn rows<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        at: &PointKinematics<'_, D, T>,
    ) -> [ContactRow<T>; ROWS] {
        let (depth, v) = (at.state.depth, at.velocity());
        let d = self.impedance.at(depth);
        let (b, k) = self.reference.gains(&self.impedance, T::from(at.dt));
        let pull = k * d * depth;
        let normal = self.compliance(at, d, pull);
        let across = normal / T::from(self.friction_impedance_ratio);
        let row = |reference: T, compliance: T| ContactRow {
            reference,
            compliance,
        };
        let along = row(pull - b * v[0], normal);
        [
            if at.speculative {
                self.before_it_passes(along, at)
            } else {
                along
            },
            row(-(b * v[1]), across),
            row(-(b * v[2]), across),
        ]
    }

    /// b and Rₜ, as across.
    fn turning<T: Over<P>>(&self, dt: T, across: T) -> [T; 2] {
        [self.reference.gains(&self.impedance, dt).0, across]
    }

    fn reason<T: Scalar>(&self, at: &PointOutcome<'_, T>) -> ContactReason {
        ContactReason::of_mode(at.state, at.mode)
    }
}

#[cfg(test)]
mod tests {
    use super::super::law::SamplePoint;
    use super::*;

    /// 1 mm deep or deeper, where d is 0.95: R = 0.05 / 0.95 G.
    const AT: SamplePoint = SamplePoint {
        depth: 2e-3,
        velocity: [-0.3, 0.2, -0.1],
        deflection: [0.0; 2],
        delassus: 4.0,
        dt: 0.01,
        kappa: 0.0,
        speculative: false,
    };

    // `MuJoCo`'s manual, solver parameters: b = 2 / (d_max T), k = 1 / (d_max T ζ)², a_ref = −b v − k d r with r = −δ, and R = (1 − d) / d Gₙₙ.
    #[test]
    fn rows_equal_the_documented_formulas() {
        let law = RelaxedRigid {
            reference: Reference::TimeConstant {
                time_constant: 0.04,
                damping_ratio: 0.5,
            },
            friction_impedance_ratio: 5.0,
            ..RelaxedRigid::default()
        };
        let (b, k) = (2.0 / (0.95 * 0.04), (0.95_f64 * 0.04 * 0.5).powi(-2));
        let rows = AT.rows(&law);
        let expected = [b * 0.3 + k * 0.95 * 2e-3, -b * 0.2, b * 0.1];
        for (row, expected) in rows.iter().zip(expected) {
            assert!((row.reference - expected).abs() < 1e-12 * expected.abs());
        }
        let r = 0.05 / 0.95 * 4.0;
        for (row, expected) in rows.iter().zip([r, r / 5.0, r / 5.0]) {
            assert!((row.compliance - expected).abs() < 1e-15);
        }
    }

    // T = 20 ms acts as 1.9 Δt = 57 ms, and as itself at Δt = 10 ms.
    #[test]
    fn a_time_constant_has_a_least_number_of_steps() {
        let short = RelaxedRigid::default();
        let as_long = RelaxedRigid {
            reference: Reference::TimeConstant {
                time_constant: 0.057,
                damping_ratio: 1.0,
            },
            ..short
        };
        let long_step = SamplePoint { dt: 0.03, ..AT };
        let (found, expected) = (long_step.rows(&short)[0], long_step.rows(&as_long)[0]);
        assert!((found.reference - expected.reference).abs() < 1e-12);
        assert!(AT.rows(&short)[0].reference > 2.0 * expected.reference);
    }

    // b = damping / d_max, k = stiffness / d_max².
    #[test]
    fn direct_reference_equals_its_formula() {
        let law = RelaxedRigid {
            reference: Reference::Direct {
                stiffness: 900.0,
                damping: 40.0,
            },
            ..RelaxedRigid::default()
        };
        let expected = 40.0 / 0.95 * 0.3 + 900.0 / (0.95 * 0.95) * 0.95 * 2e-3;
        assert!((AT.rows(&law)[0].reference - expected).abs() < 1e-13);
    }

    // Above the ground d = 0.9: without smoothing no force; with κ, R = (k d δ)² / κ + (1 − d) / d G.
    #[test]
    fn compliance_above_the_ground_is_infinite_or_that_of_smoothing() {
        let law = RelaxedRigid::default();
        let above = SamplePoint { depth: -0.01, ..AT };
        for row in above.rows(&law) {
            assert_eq!(row.compliance, f64::INFINITY);
        }
        let smoothed = SamplePoint {
            kappa: 3.0,
            ..above
        };
        let pull = (0.95_f64 * 0.02).powi(-2) * 0.9 * 0.01;
        let expected = pull * pull / 3.0 + 0.1 / 0.9 * 4.0;
        let found = smoothed.rows(&law)[0].compliance;
        assert!(
            (found - expected).abs() < 1e-12 * expected,
            "{found} {expected}"
        );
        // Below it smoothing does not change the rows.
        let below = SamplePoint { kappa: 3.0, ..AT }.rows(&law);
        assert_eq!(below[0].compliance, AT.rows(&law)[0].compliance);
    }
}
