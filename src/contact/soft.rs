//! Soft contact: Hunt and Crossley's normal force, and friction by the deflection of bristles.
//!
//! A law knows no robot: it takes the depth of a point below the surface, its velocity, and the bristle's deflection.

use nalgebra::Vector3;

use super::material::bounded;
use super::rigid::PointRows;
use crate::given;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{dot, scale};

/// A spring with a damper that never pulls:  f = max(0, K δ¹⁺ᵖ + D δ^q δ̇) at a depth δ > 0, else 0.
///
/// As force and damping grow from nothing with the depth (p, q > 0), the force is continuous at touch-down; with q = 0 the damper
/// acts fully from the first touch. The clamp takes away what would pull, so that passing through never gives energy.
///
/// # References
/// [Hunt, Crossley 1975]; [Azad, Featherstone 2010] for the exponents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HuntCrossley<P = f64> {
    /// K, N/m¹⁺ᵖ (at a joint N·m/rad¹⁺ᵖ); larger is harder and needs smaller steps.
    pub stiffness: P,
    /// D, N·s/m¹⁺^q (at a joint N·m·s/rad¹⁺^q); larger dissipates more.
    pub damping: P,
    /// p: how the spring stiffens with depth; 0 is a linear spring, ½ a sphere on a half-space, after Hertz.
    pub stiffness_exponent: P,
    /// q: how damping grows with depth.
    pub damping_exponent: P,
}

impl<P: Scalar> HuntCrossley<P> {
    /// A linear spring and damper, p = q = 0.
    pub fn linear(stiffness: P, damping: P) -> Self {
        Self {
            stiffness,
            damping,
            stiffness_exponent: P::zero(),
            damping_exponent: P::zero(),
        }
    }

    /// Converts the law to another scalar type.
    pub fn cast<Q: Over<P>>(&self) -> HuntCrossley<Q> {
        HuntCrossley {
            stiffness: self.stiffness.into(),
            damping: self.damping.into(),
            stiffness_exponent: self.stiffness_exponent.into(),
            damping_exponent: self.damping_exponent.into(),
        }
    }

    /// # Panics
    /// If stiffness, damping or an exponent is negative or not finite.
    pub(crate) fn check(&self, of: &str) {
        for (name, number) in [
            ("stiffness", self.stiffness),
            ("damping", self.damping),
            ("stiffness exponent", self.stiffness_exponent),
            ("damping exponent", self.damping_exponent),
        ] {
            given::not_negative(&format!("{name} of {of}"), number);
        }
    }

    /// The force, N (N·m), at a depth δ (m, rad) that grows at the rate δ̇. At δ = 0 force and derivative are those of separation.
    pub fn force<T: Over<P>>(&self, depth: T, rate: T) -> T {
        let at = self.at(depth);
        at.force(depth, rate)
    }

    /// Reference acceleration along the push of a spring and damper whose force is that at the end of a step, and regularisation R: a row
    /// y = G f + R f + a − wanted with f ≥ 0 ⊥ y ≥ 0 has  f = max(0, s δ⁺ + c δ̇⁺)  with δ̇⁺ = −(v + Δt a) and δ⁺ = δ + Δt δ̇⁺.
    ///
    /// s = K dᵖ belongs to the depth d = δ − Δt v that the step would reach, so that what arrives within the step is met; c = D δ^q to that of
    /// its start, so that nothing is damped before it touches. Without both R is infinite, and there is no force.
    ///
    /// * `v` – velocity out of the depth, −δ̇ at the start
    /// * `dt` – the step, s
    pub fn ask<T: Over<P>>(&self, depth: T, v: T, dt: f64) -> (T, T) {
        self.over_step(depth, v, dt).ask(depth, v, dt)
    }

    /// The force of a spring and damper at the end of a step, as a function of the acceleration out of the depth, if it may pull.
    ///
    /// * `v` – velocity out of the depth, −δ̇ at the start
    /// * `dt` – the step, s
    pub(crate) fn step_force<T: Over<P>>(&self, depth: T, v: T, dt: f64) -> StepForce<T> {
        let Stiffness { spring, damper } = self.over_step(depth, v, dt);
        let resistance = spring * dt + damper;
        StepForce {
            push: spring * depth - resistance * v,
            resistance,
        }
    }

    fn over_step<T: Over<P>>(&self, depth: T, v: T, dt: f64) -> Stiffness<T> {
        let (zero, ahead) = (T::zero(), depth - v * dt);
        Stiffness {
            spring: zero.select_lt(ahead, self.spring(log(ahead)), zero),
            damper: zero.select_lt(depth, self.damper(log(depth)), zero),
        }
    }

    fn at<T: Over<P>>(&self, depth: T) -> Stiffness<T> {
        let log = log(depth);
        Stiffness {
            spring: self.spring(log),
            damper: self.damper(log),
        }
    }

    /// K δᵖ from ln δ.
    fn spring<T: Over<P>>(&self, log: T) -> T {
        (log * self.stiffness_exponent).exp() * self.stiffness
    }

    /// D δ^q from ln δ.
    fn damper<T: Over<P>>(&self, log: T) -> T {
        (log * self.damping_exponent).exp() * self.damping
    }
}

/// ln δ, where there is no contact that of a depth at which the powers are finite; the result is not used there.
fn log<T: Scalar>(depth: T) -> T {
    T::zero().select_lt(depth, depth, T::one()).ln()
}

/// A force at the end of a step, f = push − Δt resistance · a, that is linear in the acceleration a over the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepForce<T> {
    /// The force if nothing accelerates, N or N·m.
    pub(crate) push: T,
    /// Loss of force per unit of velocity, N·s/m or N·m·s/rad.
    pub(crate) resistance: T,
}

/// K δᵖ and D δ^q.
#[derive(Clone, Copy)]
struct Stiffness<T> {
    spring: T,
    damper: T,
}

/// Resistance below which a spring and damper count as this, N·s/m: it moves nothing.
const LEAST_RESISTANCE: f64 = 1e-12;

impl<T: Scalar> Stiffness<T> {
    /// s Δt + c: the force against a velocity that lasts for a step.
    fn resistance(&self, dt: f64) -> T {
        let resistance = self.spring * dt + self.damper;
        resistance.max(T::constant(LEAST_RESISTANCE))
    }

    /// [`HuntCrossley::ask`] with these for the step.
    fn ask(&self, depth: T, v: T, dt: f64) -> (T, T) {
        let resistance = self.resistance(dt);
        let give = T::one() / (resistance * dt);
        (
            (self.spring * depth / resistance - v) * (1.0 / dt),
            self.if_touching(give, T::constant(f64::INFINITY)),
        )
    }

    /// One of two numbers by whether there is a spring or a damper.
    fn if_touching(&self, then: T, other: T) -> T {
        T::zero().select_lt(self.spring + self.damper, then, other)
    }

    fn force(&self, depth: T, rate: T) -> T {
        let zero = T::zero();
        let force = self.spring * depth + self.damper * rate;
        zero.select_lt(depth, zero.select_lt(force, force, zero), zero)
    }
}

/// Soft contact with Coulomb friction.
///
/// The tangent force is that of a bristle with the spring and damper of the normal force, `f_t` = −(K δᵖ m + D δ^q `v_t`), brought back
/// to the cone ‖`f_t`‖ ≤ μ `f_n` where it is longer. The deflection m is a state, ṁ = `v_t` while it sticks, and on the cone such that
/// the bristle feels the force it gives: at rest it holds without creeping.
///
/// # References
/// [Azad, Featherstone 2010]; [Azad, Featherstone 2014].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftContact<P = f64> {
    /// The normal force.
    pub normal: HuntCrossley<P>,
    /// μ, the coefficient of friction; infinite where nothing slips.
    pub friction: P,
}

/// Response of soft contact at a point: the force on the body, and the rate of the bristle.
#[derive(Clone, Copy, Debug)]
pub struct SoftResponse<T> {
    /// Force on the body along the outward normal, N, never negative.
    pub normal: T,
    /// Friction on the body, N, in the tangent plane.
    pub tangent: Vector3<T>,
    /// ṁ, m/s.
    pub deflection_rate: Vector3<T>,
    /// Relaxation rate of the deflection, 1/s: −∂ṁ/∂m for a given force, 0 while it sticks.
    pub relaxation: T,
}

impl<T: Scalar> SoftResponse<T> {
    /// By how much the deflection changes over a step of `dt` (s), see [`step_of_bristle`].
    pub(crate) fn step(&self, dt: f64) -> Vector3<T> {
        step_of_bristle(&self.deflection_rate, self.relaxation, dt)
    }
}

/// By how much a deflection changes over a step, Δt ṁ / (1 + Δt r): implicit in how the bristle falls by itself, at the rate r, so that
/// short steps are needed for the motion of the robot only.
pub(crate) fn step_of_bristle<T: Scalar>(rate: &Vector3<T>, relaxation: T, dt: f64) -> Vector3<T> {
    scale(rate, T::constant(dt) / (relaxation * dt + 1.0))
}

/// Square of the shortest tangent force that has a direction, N²: far below what moves anything, far above underflow.
const LEAST_SQUARE: f64 = 1e-60;

/// Time in which a bristle without a damper straightens while it slips, s: at once.
const LEAST_RELAXATION: f64 = 1e-9;

impl<P: Scalar> SoftContact<P> {
    /// # Panics
    /// If a number makes no sense, with its name.
    pub(super) fn check(&self) {
        self.normal.check("soft contact");
        given::not_negative_or_infinite("friction of soft contact", self.friction);
        let push = self.normal.stiffness + self.normal.damping;
        let pushes = (0..P::LANES).all(|lane| push.value(lane) > 0.0);
        assert!(
            pushes,
            "soft contact without stiffness and damping has no force"
        );
    }

    /// Converts the law to another scalar type.
    pub fn cast<Q: Over<P>>(&self) -> SoftContact<Q> {
        SoftContact {
            normal: self.normal.cast(),
            friction: self.friction.into(),
        }
    }

    /// The response of a point at a depth (m, negative above the surface) that moves with the velocity `v` (m/s), to an outward unit
    /// normal, with a deflection m of the bristle (m); vectors in one frame.
    ///
    /// At zero velocity and deflection, value and derivatives are those of sticking.
    pub fn respond<T: Over<P>>(
        &self,
        depth: T,
        v: &Vector3<T>,
        normal: &Vector3<T>,
        deflection: &Vector3<T>,
    ) -> SoftResponse<T> {
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
        let limit = f_n * bounded::<P, T>(self.friction);
        let share = limit.select_lt(length, limit / length, one);
        // Without a force there is nothing to hold, and the bristle straightens.
        let share = zero.select_lt(f_n, share, zero);
        // c ṁ = −f_t − s m, s = K δᵖ and c = D δ^q, which is ṁ = share v_t + (share − 1) r m, r = s / c
        let relaxed = at.spring / at.damper.max(at.spring * LEAST_RELAXATION);
        let m_n = deflection - m_t;
        let tangent_rate = scale(&v_t, share) + scale(&m_t, (share - one) * relaxed);
        SoftResponse {
            normal: f_n,
            tangent: scale(&f_t, share),
            deflection_rate: tangent_rate - scale(&m_n, relaxed),
            relaxation: share.select_lt(one, relaxed, zero),
        }
    }
}

impl<P: Scalar> SoftContact<P> {
    /// Reference acceleration and regularisation of a point at a depth (m) with a velocity (normal, tangent, tangent; m/s), so that its
    /// force is that at the end of a step of `dt` (s), in the cone of Coulomb's law: the spring and damper of the normal, see
    /// [`HuntCrossley::ask`], and the bristle with its deflection across (m), which at the end of the step is longer by Δt times the
    /// velocity then.
    pub fn ask<T: Over<P>>(
        &self,
        depth: T,
        v: &[T; 3],
        deflection: [T; 2],
        dt: f64,
    ) -> PointRows<T> {
        let at = self.normal.over_step(depth, v[0], dt);
        let (normal, give) = at.ask(depth, v[0], dt);
        let back = at.spring / at.resistance(dt);
        let across = |k: usize| -(back * deflection[k] + v[1 + k]) * (1.0 / dt);
        PointRows {
            wanted: [normal, across(0), across(1)],
            regularization: [give; 3],
        }
    }

    /// By how much the deflection m of a bristle changes over a step of `dt` (s) at whose end the friction is `f_t` (N):
    /// c (m⁺ − m) / Δt = −`f_t` − s m⁺, and what touches nothing straightens.
    ///
    /// * `v` – velocity out of the depth at the start, m/s
    pub fn settle<T: Over<P>>(
        &self,
        (depth, v): (T, T),
        f_t: &Vector3<T>,
        deflection: &Vector3<T>,
        dt: f64,
    ) -> Vector3<T> {
        let at = self.normal.over_step(depth, v, dt);
        let (spring, damper) = (self.normal.stiffness.into(), self.normal.damping.into());
        let at = Stiffness {
            spring: at.if_touching(at.spring, spring),
            damper: at.if_touching(at.damper, damper),
        };
        let pull = f_t + scale(deflection, at.spring);
        -scale(&pull, T::constant(dt) / at.resistance(dt))
    }
}

impl SoftContact<f64> {
    /// Numbers with which a robot at rest sinks in by a wanted depth and does not bounce, with p = q = ½ and μ = ½.
    ///
    /// K balances the weight on the points that carry it at that depth, m g / n = K δ¹⁺ᵖ; D damps the oscillation about it as if
    /// critically, for the spring's slope there: D δ^q = 2 √(K (1 + p) δᵖ m / n).
    ///
    /// * `mass` – of the whole robot, kg
    /// * `points` – how many points carry it
    /// * `depth` – wanted penetration, m; 1 % of the height of the centre of mass is a good start
    ///
    /// # Limitations
    /// With p or q below 1 the derivatives of a step that is [implicit in velocity](crate::Integrator::ImplicitVelocity) have no bound where
    /// it just touches down. Optimisation through contact is better off with p = q = 3/2, as in the example `hopper`.
    ///
    /// # Panics
    /// If mass or depth are not positive and finite, or if there are no points.
    pub fn estimate(mass: f64, points: usize, depth: f64) -> Self {
        let good = |x: f64| x > 0.0 && x.is_finite();
        assert!(
            good(mass) && good(depth) && points > 0,
            "mass {mass} kg and depth {depth} m must be positive, with {points} points"
        );
        let exponent: f64 = 0.5;
        let carried = mass / points as f64;
        let stiffness = carried * STANDARD_GRAVITY / depth.powf(1.0 + exponent);
        let slope = stiffness * (1.0 + exponent) * depth.powf(exponent);
        Self {
            normal: HuntCrossley {
                stiffness,
                damping: 2.0 * (slope * carried).sqrt() / depth.powf(exponent),
                stiffness_exponent: exponent,
                damping_exponent: exponent,
            },
            friction: 0.5,
        }
    }
}

/// m/s², for estimates.
const STANDARD_GRAVITY: f64 = 9.806_65;
