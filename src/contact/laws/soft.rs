//! Soft contact: Hunt–Crossley normal force, and friction by the deflection of bristles.
//!
//! One law, with the coefficients s = K δᵖ and c = D δ^q of spring and damper at the depth δ:
//!
//! > `f_n` = max(0, s δ + c δ̇),  `f_t` = −(s m + c ṁ),  ‖`f_t`‖ ≤ μ `f_n`,
//!
//! where the deflection m of the bristle follows the ground, ṁ = `v_t`, while it sticks. It has three forms:
//!
//! * [`SoftContact::force`] is explicit: δ, v and m determine the force, and ṁ is such that the bristle feels this force;
//! * `rows` is implicit: with m⁺ = m + Δt v⁺ and s, c of the step, both forces are linear in the velocity v⁺ after it, and a solver keeps
//!   them in the cone;
//! * `bristle_step` solves the same `f_t` = −(s m⁺ + c (m⁺ − m) / Δt) for m⁺, under the friction that the solver has found.

use nalgebra::Vector3;

use super::hunt_crossley::{HuntCrossley, SpringDamper};
use super::law::{
    BristleLoad, BristleRate, ContactRow, ExplicitForce, LawKind, PointKinematics, PointLaw, ROWS,
    bounded_friction,
};
use crate::cone::Law;
use crate::contact::activation::ActivationMargin;
use crate::contact::compliance::Compliance;
use crate::contact::material::Material;
use crate::contact::point_state::PointState;
use crate::contact::reason::{ContactReason, PointOutcome};
use crate::contact::turning::TurningFriction;
use crate::numbers::{each_lane, numbers};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{dot, scale};

/// Soft contact with Coulomb friction.
///
/// The tangential force is that of a bristle with the spring and damper of the normal force, `f_t` = −(K δᵖ m + D δ^q `v_t`), projected to the cone
/// ‖`f_t`‖ ≤ μ `f_n` if it is outside. The deflection m is a state. While the bristle sticks, ṁ = `v_t`; on the cone ṁ is such that the bristle feels
/// the projected force. So contacts at rest hold without creep. A bristle without contact straightens at the rate K δᵖ / (D δ^q) of a depth of 1 mm.
///
/// # Exponents
/// Use q = 1 + p, as [`estimate`](Self::estimate) does. Then the normal force K δ¹⁺ᵖ (1 + (D / K) δ̇) returns to zero with the depth, and its clamp
/// at zero is inactive while (D / K) |δ̇| < 1, which holds in every free impact. With q < 1 + p the clamp cuts off the end of each contact; its time
/// within a step does not move with the state, which biases all derivatives. With p = 3/2, K δᵖ is also smooth at touch-down, which matters for steps
/// that are implicit in velocity; with p < 1 the derivatives of such a step are unbounded there, with q < 1 those of every step.
///
/// # Steps
/// A contact must last many steps. The table shows a ball that bounces at 2 m/s with a restitution of 0.6, dropped from 41 heights; the exact
/// derivative of its height after the bounce in the initial height is −0.6. The first column is the number of steps in the [contact
/// time](HuntCrossley::impact_time) without damping:
///
/// | steps | semi-implicit Euler: restitution | derivative: mean, smallest and largest | linearly implicit Euler: restitution | derivative |
/// |---|---|---|---|---|
/// | 10 | 0.600 | −0.601, −0.67 to −0.55 | 0.376 | −0.374, −0.51 to −0.27 |
/// | 20 | 0.600 | −0.600, −0.614 to −0.588 | 0.471 | −0.469, −0.53 to −0.44 |
/// | 50 | 0.600 | −0.600, −0.601 to −0.599 | 0.543 | −0.543, −0.552 to −0.535 |
/// | 100 | 0.600 | −0.600, ±0.0002 | 0.570 | −0.570, ±0.002 |
/// | the same with p = q = 3/2: 50 | 0.638 | −0.65, −0.74 to −0.55 | 0.574 | −0.57, −0.67 to −0.47 |
///
/// So a linearly implicit step dissipates energy, and more so if a contact lasts fewer steps: a ball of 1 kg on p = 3/2 with K = 10⁸ and
/// no damping should rise to 1.1 m again, and rises to 0.33 m with steps of 1 ms. It is stable at any step. Semi-implicit Euler is not: bodies on a
/// slope chatter, and no status reports it. [`Simulator::remarks`](crate::Simulator::remarks) finds steps that are too long.
///
/// # Between bodies
/// The contact points between two bodies are found anew in each step and have no bristles: friction is that of the damper alone, −D δ^q `v_t`
/// projected to the cone, or −(D δ^q + K δᵖ Δt) `v_t`⁺ in a linearly implicit step. It needs no shorter step than the normal force. Under
/// a force f it creeps at f / (D δ^q): with the parameters of [`estimate`](Self::estimate) for a depth of 1 mm, under half of the weight, at 16 mm/s.
/// For contacts that must not creep, such as grasps, use [`Rigid`](crate::contact::Rigid) or [`RelaxedRigid`](crate::contact::RelaxedRigid).
///
/// # References
/// [Azad, Featherstone 2010]; [Azad, Featherstone 2014].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftContact<P = f64> {
    /// The normal force.
    pub normal: HuntCrossley<P>,
    /// μ, the coefficient of friction; infinite for no slip.
    pub friction: P,
}

numbers! { pub struct SoftContact {
    normal: part(HuntCrossley, "{}", "{} of soft contact"),
    friction: NotNegativeOrInfinite("friction", "friction of soft contact"),
} }

/// Force of soft contact at a point, and the rate of its bristle.
#[derive(Clone, Copy, Debug)]
pub struct SoftForce<T> {
    /// Force on the body along the outward normal, N, never negative.
    pub normal: T,
    /// Friction on the body, N, in the tangent plane.
    pub tangent: Vector3<T>,
    /// ṁ, m/s.
    pub deflection_rate: Vector3<T>,
    /// Relaxation rate of the deflection, 1/s: −∂ṁ/∂m for a given force, 0 while it sticks.
    pub relaxation: T,
}

/// Square of the shortest tangent force that has a direction, N²: far below what moves anything, far above underflow.
const LEAST_SQUARE: f64 = 1e-60;

/// Time in which a bristle without a damper straightens while it slips, s: at once.
const LEAST_RELAXATION: f64 = 1e-9;

impl<P: Scalar> SoftContact<P> {
    /// # Panics
    /// If it has neither stiffness nor damping.
    pub(super) fn check_force(&self) {
        let push = self.normal.stiffness + self.normal.damping;
        each_lane([push], |[push]| {
            assert!(
                push > 0.0,
                "soft contact without stiffness and damping has no force"
            );
        });
    }

    /// Computes the force on a point at a depth (m, negative above the surface) that moves with the velocity `v` (m/s), to an outward unit
    /// normal, with a deflection m of the bristle (m); vectors in one frame.
    ///
    /// At zero velocity and deflection, value and derivatives are those of sticking.
    pub(crate) fn force<T: Over<P>>(
        &self,
        depth: T,
        v: &Vector3<T>,
        normal: &Vector3<T>,
        deflection: &Vector3<T>,
    ) -> SoftForce<T> {
        let tangent = |x: &Vector3<T>| x - scale(normal, dot(normal, x));
        let (v_t, m_t) = (tangent(v), tangent(deflection));
        let at = self.normal.at(depth);
        let f_n = at.force(depth, -dot(normal, v));
        // f_t as if it stuck, then the share of it that the cone allows.
        let f_t = -(scale(&m_t, at.spring) + scale(&v_t, at.damper));
        let (zero, one) = (T::zero(), T::one());
        let square = dot(&f_t, &f_t);
        let least = T::constant(LEAST_SQUARE);
        let length = least.select_lt(square, square, least).sqrt();
        let limit = f_n * bounded_friction::<P, T>(self.friction);
        let share = limit.select_lt(length, limit / length, one);
        // Without a force there is nothing to hold, and the bristle straightens.
        let share = zero.select_lt(f_n, share, zero);
        // c ṁ = −f_t − s m, which is ṁ = share v_t + (share − 1) r m, r = s / c
        let damper = at.damper.max(at.spring * LEAST_RELAXATION);
        let relaxed = at.spring / damper.max(T::constant(f64::MIN_POSITIVE));
        let m_n = deflection - m_t;
        let tangent_rate = scale(&v_t, share) + scale(&m_t, (share - one) * relaxed);
        SoftForce {
            normal: f_n,
            tangent: scale(&f_t, share),
            deflection_rate: tangent_rate - scale(&m_n, relaxed),
            relaxation: share.select_lt(one, relaxed, zero),
        }
    }
}

impl<P: Scalar> PointLaw<P> for SoftContact<P> {
    const KIND: LawKind = LawKind {
        name: "soft",
        solved_explicitly: false,
        solved_implicitly: true,
        cone: Law::Coulomb,
        bristle: true,
        acts_over_step: false,
        can_be_smoothed: false,
        working_set: false,
        reads_delassus: false,
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
        let Compliance::Soft { stiffness, damping } = own else {
            return false;
        };
        (self.normal.stiffness, self.normal.damping) = (stiffness, damping);
        true
    }

    /// Takes points that arrive within the step: they are met by the spring of the depth that they would reach.
    fn activation_margin<D: Scalar>(&self, dt: D) -> ActivationMargin<D> {
        ActivationMargin {
            duration: dt,
            ..ActivationMargin::surface()
        }
    }

    /// The normal as [`HuntCrossley::row`]; the bristle across, which at the end of the step is longer by Δt times the velocity then.
    fn rows<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        at: &PointKinematics<'_, D, T>,
    ) -> [ContactRow<T>; ROWS] {
        let (depth, dt) = (at.state.depth, at.dt);
        let [v_n, v_1, v_2] = at.velocity();
        let [_, m_1, m_2] = at.deflection();
        let own = self.normal.over_step(depth, v_n, dt);
        let normal = own.row(depth, v_n, dt);
        let back = own.spring / own.resistance(dt);
        let across = |m: T, v: T| ContactRow {
            reference: -(back * m + v) * (D::one() / dt),
            compliance: normal.compliance,
        };
        [normal, across(m_1, v_1), across(m_2, v_2)]
    }

    fn explicit_force<T: Over<P>>(
        &self,
        at: &PointState<T>,
        deflection: &Vector3<T>,
    ) -> Option<ExplicitForce<T>> {
        let own = self.force(at.depth, &at.velocity, &at.normal, deflection);
        Some(ExplicitForce {
            force: scale(&at.normal, own.normal) + own.tangent,
            bristle: BristleRate {
                deflection: own.deflection_rate,
                relaxation: own.relaxation,
            },
        })
    }

    /// m⁺ − m of  c (m⁺ − m) / Δt = −`f_t` − s m⁺; a bristle without contact straightens.
    fn bristle_step<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        at: &BristleLoad<'_, D, T>,
    ) -> Vector3<T> {
        let own = self.normal.over_step(at.depth, at.separation, at.dt);
        let apart = self.normal.at(T::zero());
        let own = SpringDamper {
            spring: own.if_touching(own.spring, apart.spring),
            damper: own.if_touching(own.damper, apart.damper),
        };
        let pull = at.friction + scale(at.deflection, own.spring);
        -scale(&pull, T::from(at.dt) / own.resistance(at.dt))
    }

    fn reason<T: Scalar>(&self, at: &PointOutcome<'_, T>) -> ContactReason {
        if at.normal_force.value(0) > 0.0 {
            let depth = at.state.depth.value(0);
            return ContactReason::Soft { depth };
        }
        ContactReason::without_force(at.state)
    }
}

/// p of [`SoftContact::estimate`]: the spring, the damper and their derivatives are continuous at touch-down, also in a step that is implicit in
/// velocity, where K δᵖ itself must be differentiable.
const ESTIMATED_EXPONENT: f64 = 1.5;

impl SoftContact<f64> {
    /// Parameters with which a robot at rest penetrates by a given depth and does not bounce, with p = 3/2, q = 1 + p = 5/2 and μ = ½.
    ///
    /// K balances the weight on the loaded points at that depth, m g / n = K δ¹⁺ᵖ. D damps the linearised oscillation about it critically: D δ^q = 2
    /// √(K (1 + p) δᵖ m / n). For a motion that bounces see [`with_restitution`](Self::with_restitution).
    ///
    /// * `mass` – of the whole robot, kg
    /// * `points` – number of points that carry the weight
    /// * `depth` – penetration, m; start with 1 % of the height of the centre of mass
    ///
    /// # Limitations
    /// The damper stiffens with depth. A hard landing is damped much more than a body at rest, so semi-implicit Euler needs short steps, see the
    /// section on steps of [`SoftContact`].
    ///
    /// A point that leaves the ground faster than K / D = ½ √(g δ / (1 + p)), 0.03 m/s at a depth of 1 mm and 0.1 m/s at 1 cm, is released at once,
    /// which is a nonsmooth point of all derivatives. For robots that jump or run, also call [`with_restitution`](Self::with_restitution), for
    /// example with 0.6 at 1 m/s: optimised torques of a jump from a mat of 1 cm converge with it, and stall with the damping of this function alone.
    ///
    /// # Panics
    /// If mass or depth are not positive and finite, or the number of points is zero.
    pub fn estimate(mass: f64, points: usize, depth: f64) -> Self {
        let good = |x: f64| x > 0.0 && x.is_finite();
        assert!(
            good(mass) && good(depth) && points > 0,
            "mass {mass} kg and depth {depth} m must be positive, with {points} points"
        );
        let order = 1.0 + ESTIMATED_EXPONENT;
        let carried = mass / points as f64;
        let weight = carried * STANDARD_GRAVITY;
        let slope = order * weight / depth;
        Self {
            normal: HuntCrossley {
                stiffness: weight / depth.powf(order),
                damping: 2.0 * (slope * carried).sqrt() / depth.powf(order),
                stiffness_exponent: ESTIMATED_EXPONENT,
                damping_exponent: order,
            },
            friction: 0.5,
        }
    }

    /// [`HuntCrossley::with_restitution`] of the normal force: sets the coefficient of restitution of an impact at `speed` (m/s) without other forces.
    ///
    /// # Panics
    /// If the restitution is not in (0, 1], or the speed is not positive and finite.
    ///
    /// # Examples
    /// ```
    /// use dualbody::contact::SoftContact;
    ///
    /// let ball = SoftContact::estimate(1.0, 1, 1e-3).with_restitution(0.6, 2.0);
    /// assert!((ball.normal.restitution(2.0).unwrap() - 0.6).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn with_restitution(mut self, restitution: f64, speed: f64) -> Self {
        self.normal = self.normal.with_restitution(restitution, speed);
        self
    }
}

/// m/s², for the scale of forces.
pub(crate) const STANDARD_GRAVITY: f64 = 9.806_65;

#[cfg(test)]
mod tests {
    use super::super::law::SamplePoint;
    use super::*;

    /// s = 2000 √δ, c = 30 √δ, μ = ½.
    const LAW: SoftContact = SoftContact {
        normal: HuntCrossley {
            stiffness: 2e3,
            damping: 30.0,
            stiffness_exponent: 0.5,
            damping_exponent: 0.5,
        },
        friction: 0.5,
    };

    const DEPTH: f64 = 0.04;
    /// s and c there, √δ = 0.2.
    const S: f64 = 400.0;
    const C: f64 = 6.0;

    fn force(velocity: [f64; 3], m: Vector3<f64>) -> SoftForce<f64> {
        LAW.force(DEPTH, &Vector3::from(velocity), &Vector3::z(), &m)
    }

    #[test]
    fn friction_that_sticks_is_that_of_spring_and_damper_and_the_bristle_follows() {
        let m = Vector3::new(0.003, -0.001, 0.0);
        let found = force([0.1, 0.2, -0.5], m);
        assert!((found.normal - (S * DEPTH + C * 0.5)).abs() < 1e-12);
        let expected = -(m * S + Vector3::new(0.1, 0.2, 0.0) * C);
        assert!((found.tangent - expected).norm() < 1e-12);
        assert!((found.deflection_rate - Vector3::new(0.1, 0.2, 0.0)).norm() < 1e-15);
        assert_eq!(found.relaxation, 0.0);
    }

    // On the cone the bristle moves so that it feels the force it gives:  c ṁ = −f_t − s m.
    #[test]
    fn friction_that_slips_is_on_the_cone_and_is_what_the_bristle_feels() {
        let m = Vector3::new(0.03, -0.01, 0.0);
        let found = force([1.0, 2.0, 0.0], m);
        assert!((found.tangent.norm() - 0.5 * found.normal).abs() < 1e-12);
        let felt = -(m * S + found.deflection_rate * C);
        assert!((found.tangent - felt).norm() < 1e-12);
        assert!((found.relaxation - S / C).abs() < 1e-12);
    }

    #[test]
    fn force_without_contact_is_zero_and_the_bristle_straightens() {
        let m = Vector3::new(0.03, 0.0, 0.0);
        let found = LAW.force(-0.01, &Vector3::x(), &Vector3::z(), &m);
        assert_eq!((found.normal, found.tangent), (0.0, Vector3::zeros()));
        assert!(found.deflection_rate.x < 0.0);
    }

    /// Force across, with a unit force that accelerates by `g`, and the velocity after the step.
    fn implicit(at: &SamplePoint, g: f64, free: f64) -> (f64, f64) {
        let row = at.rows(&LAW)[1];
        let f = (row.reference - free) / (g + row.compliance);
        (f, at.velocity[1] + at.dt * (free + g * f))
    }

    // While it sticks, the bristle's step under the force of the row is the way of the point over the ground, Δt v⁺, and the force is
    // that of the spring and damper at the end: f = −(s m⁺ + c v⁺).
    #[test]
    fn row_and_bristle_step_are_one_law() {
        let at = SamplePoint {
            depth: DEPTH,
            velocity: [0.0, 0.3, 0.0],
            deflection: [0.002, 0.0],
            dt: 0.01,
            ..SamplePoint::default()
        };
        let (f, v) = implicit(&at, 0.8, -2.0);
        let step = LAW.bristle_step(&BristleLoad {
            depth: DEPTH,
            separation: 0.0,
            friction: &Vector3::new(f, 0.0, 0.0),
            deflection: &Vector3::new(0.002, 0.0, 0.0),
            dt: at.dt,
        });
        assert!((step - Vector3::new(at.dt * v, 0.0, 0.0)).norm() < 1e-15);
        let end = S * (0.002 + at.dt * v) + C * v;
        assert!((f + end).abs() < 1e-11, "{f} {end}");
    }

    // In short steps the implicit friction is the explicit one.
    #[test]
    fn implicit_friction_tends_to_the_explicit_one() {
        let explicit = force([0.3, 0.0, 0.0], Vector3::new(0.002, 0.0, 0.0))
            .tangent
            .x;
        let at = SamplePoint {
            depth: DEPTH,
            velocity: [0.0, 0.3, 0.0],
            deflection: [0.002, 0.0],
            dt: 1e-7,
            ..SamplePoint::default()
        };
        assert!((implicit(&at, 0.8, -2.0).0 - explicit).abs() < 1e-4);
    }

    // With q = 1 + p and D / K = 20 s/m, s / c is 50 /s at a depth of 1 mm, and would be 0.05 /s at 1 m.
    #[test]
    fn bristle_of_a_law_of_estimates_straightens_within_a_second_in_both_ways() {
        let law = SoftContact {
            normal: HuntCrossley {
                damping: 4e4,
                damping_exponent: 1.5,
                ..LAW.normal
            },
            ..LAW
        };
        let m = Vector3::new(0.002, 0.0, -0.001);
        let explicit = law.force(-0.01, &Vector3::zeros(), &Vector3::y(), &m);
        assert!((explicit.deflection_rate + m * 50.0).norm() < 1e-12);
        let step = law.bristle_step(&BristleLoad {
            depth: -0.01,
            separation: 0.0,
            friction: &Vector3::zeros(),
            deflection: &m,
            dt: 0.01,
        });
        assert!((step + m / 3.0).norm() < 1e-12);
    }

    // δᵖ and δ^q both underflow.
    #[test]
    fn steepest_exponents_have_finite_rates() {
        let mut law = LAW;
        law.normal.stiffness_exponent = 200.0;
        law.normal.damping_exponent = 200.0;
        for depth in [-1e-3, 1e-6] {
            let found = law.force(depth, &Vector3::x(), &Vector3::z(), &Vector3::x());
            assert!(found.deflection_rate.norm().is_finite(), "{found:?}");
        }
    }

    // Without contact m⁺ = m − Δt K m / (K Δt + D).
    #[test]
    fn bristle_that_touches_nothing_straightens() {
        let m = Vector3::new(0.002, 0.0, -0.001);
        let step = LAW.bristle_step(&BristleLoad {
            depth: -0.1,
            separation: 0.0,
            friction: &Vector3::zeros(),
            deflection: &m,
            dt: 0.01,
        });
        let expected = m * (-0.01 * 2e3 / (2e3 * 0.01 + 30.0));
        assert!((step - expected).norm() < 1e-15);
    }

    // K δ¹⁺ᵖ = m g / n.
    #[test]
    fn estimate_carries_the_weight_at_the_wanted_depth() {
        let law = SoftContact::estimate(12.0, 4, 2e-3);
        let force = law.normal.force(2e-3, 0.0);
        assert!((force - 3.0 * STANDARD_GRAVITY).abs() < 1e-12);
    }
}
