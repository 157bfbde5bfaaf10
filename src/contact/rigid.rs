//! Rigid contact, exact and relaxed: what each asks of the motion of a point, for the solver of cones.
//!
//! Both speak of the point in its own frame (normal, tangent, tangent): a law gives the acceleration that is wanted of it, and how much it
//! gives way.

use super::impedance::Impedance;
use crate::given;
use crate::scalar::{Over, Scalar};

/// Reference acceleration and regularisation of a contact point:  y = (G + diag R) f + a − wanted, with its acceleration a without contact.
#[derive(Clone, Copy, Debug)]
pub struct PointRows<T> {
    /// The acceleration wanted, m/s².
    pub wanted: [T; 3],
    /// R, by which the point gives way, 1/kg; infinite where it does not touch.
    pub regularization: [T; 3],
}

/// A point less deep or high than this, m, which moves along the normal by less in a step, is at rest on the surface, where the derivatives
/// of [`Rigid`] are the mean of those on both sides: far above the rounding that decides on which side a body rests, and so small that
/// nothing else can tell.
const AT_REST: f64 = 1e-9;

/// Rigid contact with Coulomb friction in an elliptic cone, and impacts with restitution: velocities after a step obey
/// vₙ⁺ ≥ e |vₙ|, and a force acts only where this holds with equality; the friction after De Saxcé opposes the slip.
///
/// It acts over a step, so it needs semi-implicit Euler.
///
/// # At rest
/// The velocity that is wanted of a point has a kink at the surface: δ / Δt above, δ / T below with the recovery time T, and −e vₙ instead for
/// a velocity into the ground. A body at rest is there, on a side that rounding picks. Within 1 nm of the surface, and with less than
/// 1 nm of motion along the normal in a step, derivatives are the means of both sides, (1 / Δt + 1 / T) / 2 in the depth and −e / 2 in
/// vₙ: what central differences give, an element of the generalised Jacobian [Clarke 1983], and one that a regulator can be
/// designed on. Values are not touched. [`ContactReason`](crate::sim::ContactReason) tells points there from others.
///
/// # Limitations
/// Derivatives of a step are exact, but the step in which an impact falls does not move with the state: a chain of them through impacts
/// is that of impacts at fixed times. The height of a ball after any bounce has the derivative 1 in the height of its fall, not e² to the
/// number of bounces, however short the steps. Where that matters, [`SoftContact`](super::SoftContact) resolves the impact.
///
/// Restitution is of first order in the step, as an impact acts in whole steps and not when the surface is reached. A ball that falls 1 m comes back to
/// this share of its height, in the mean (and between, by where in a step it lands):
///
/// | e | exact, e² | at 1 ms | at 2 ms | at 5 ms | at 10 ms |
/// |---|---|---|---|---|---|
/// | 0.9 | 0.81 | 0.811 (0.807 to 0.811) | 0.811 (0.804 to 0.812) | 0.813 (0.796 to 0.815) | 0.816 (0.779 to 0.820) |
/// | 0.5 | 0.25 | 0.252 (0.249 to 0.254) | 0.254 (0.249 to 0.258) | 0.261 (0.248 to 0.269) | 0.271 (0.245 to 0.287) |
///
/// The error goes with the step by the time of the fall: from 0.1 m at 10 ms, e = 0.9 gives 0.824 (0.72 to 0.84).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rigid<P = f64> {
    /// μ, the coefficient of friction; infinite where nothing slips.
    pub friction: P,
    /// e in 0..1: the part of the normal velocity that comes back from an impact.
    pub restitution: P,
    /// Time in which a penetration is undone, s; larger moves more gently, and leaves the point in the ground longer. To lift what has sunk
    /// in adds energy, m g δ for a body by itself. A rim that whirls at Ω with the tilt α sinks in by about ½ r α Ω² Δt T, as its lowest point runs
    /// on by Ω Δt in a step.
    pub recovery_time: P,
}

/// Rigid contact relaxed to a convex problem, as `MuJoCo` does: the point follows a reference acceleration like a damped spring, and gives
/// way by R = (1 − d) / d · Gₙₙ. With its force in the true cone, it neither pulls nor sticks beyond friction; a contact that slides at v
/// also lifts at about μ v.
///
/// # Limitations
/// * What sticks creeps: under a friction fₜ at b v = Rₜ fₜ. As R goes with the exact mobility Gₙₙ of a point, where `MuJoCo` takes that of its
///   body without turning, a box on its corners creeps several times as fast as there. No friction helps, not even an infinite one:
///   with the defaults a plate of 0.5 m × 0.5 m creeps down a slope of 1.2 rad at 15.5 mm/s.
///   [`friction_impedance_ratio`](Self::friction_impedance_ratio) divides that.
/// * In long steps, an impact that is spread over several of them tips what must slide: a box of width 0.4 times its height with μ = 0.37 on a
///   slope of ½ turns over at 10 ms. [`Rigid`] decides between the two rightly.
/// * The derivatives of each step are exact, those of a motion through a bounce are biased, however short the steps: how deep the first
///   step that touches begins is a sawtooth in the state, whose slope is in the derivative and whose teeth are not. A ball thrown at
///   2 m/s from 0.6 m has ∂x/∂vz = 0.017 after 1.5 s where differences over 0.01 m/s say 0.068;
///   [`SoftContact`](super::SoftContact) gives 0.064 both ways.
///
/// # References
/// [Todorov 2011]; [Todorov 2014]; the chapter on computation of the manual of `MuJoCo`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelaxedRigid<P = f64> {
    /// μ, the coefficient of friction; infinite where nothing slips, though it creeps, see above.
    pub friction: P,
    /// b and k of the reference acceleration −b v − k d δ.
    pub reference: Reference<P>,
    /// d, how much of the wanted acceleration is enforced.
    pub impedance: Impedance<P>,
    /// By how much a point gives way less across the normal than along it, R / Rₜ: `impratio` of `MuJoCo`. 1 by default; what sticks on a
    /// slope creeps down with a speed that is the smaller the larger this is.
    pub friction_impedance_ratio: P,
}

/// Coefficients b and k of the reference acceleration, with which a point comes back to the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reference<P = f64> {
    /// As a damped oscillator, for any impedance: b = 2 / (`d_max` T), k = 1 / (`d_max` T ζ)².
    TimeConstant {
        /// T, s.
        time_constant: P,
        /// ζ; 1 is critically damped.
        damping_ratio: P,
    },
    /// As given: b = damping / `d_max`, k = stiffness / `d_max`².
    Direct {
        /// 1/s².
        stiffness: P,
        /// 1/s.
        damping: P,
    },
}

impl Default for Rigid {
    /// μ = ½, no restitution, 20 ms.
    fn default() -> Self {
        Self {
            friction: 0.5,
            restitution: 0.0,
            recovery_time: 0.02,
        }
    }
}

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

/// Whether a point at a depth (m) that moves along the normal so far in a step (m) is taken for one at rest on the surface.
pub(crate) fn is_at_rest(depth: f64, step: f64) -> bool {
    depth.abs() < AT_REST && step.abs() < AT_REST
}

impl<P: Scalar> Rigid<P> {
    /// # Panics
    /// If a number makes no sense, with its name.
    pub(super) fn check(&self) {
        given::not_negative_or_infinite("friction of rigid contact", self.friction);
        given::within_one("restitution of rigid contact", self.restitution);
        given::positive("recovery time of rigid contact", self.recovery_time);
    }

    /// Converts the law to another scalar type.
    pub fn cast<Q: Over<P>>(&self) -> Rigid<Q> {
        Rigid {
            friction: self.friction.into(),
            restitution: self.restitution.into(),
            recovery_time: self.recovery_time.into(),
        }
    }

    /// The least velocity along the normal after a step of `dt` (s) that the law allows a point at a depth (m) with a velocity along the
    /// normal (m/s) before the step.
    pub(crate) fn least_velocity<T: Over<P>>(&self, depth: T, v: T, dt: f64) -> T {
        let zero = T::zero();
        let recovered = depth / T::from(self.recovery_time);
        let closing = depth * (1.0 / dt);
        let allowed = zero.select_lt(depth, recovered, closing);
        // What would go deeper than that within the step bounces.
        let bounce = -(v * self.restitution);
        let impact = v.select_lt(zero, bounce, zero);
        // Where both are equal, as without restitution at the surface, a point above it would bounce: the closing velocity is that of no side.
        let bounced = impact.select_lt(allowed, allowed, impact);
        let exact = v.select_lt(allowed, bounced, allowed);
        // At rest, the same value with the means of the slopes on both sides.
        let mean = (recovered + closing + bounce) * 0.5;
        let value_of = |x: T| T::from_values(|lane| x.value(lane));
        let at_rest = mean - value_of(mean) + value_of(exact);
        let step = v * dt;
        let margin = T::constant(AT_REST * AT_REST);
        let at_surface = (depth * depth).select_lt(margin, at_rest, exact);
        (step * step).select_lt(margin, at_surface, exact)
    }

    /// Reference acceleration of a point at a depth (m) with a velocity (normal, tangent, tangent; m/s) over a step of `dt` (s), and R = 0.
    ///
    /// Above the ground it may come down to it within the step; below, it comes back in the recovery time; where it bounces, faster.
    pub fn ask<T: Over<P>>(&self, depth: T, v: &[T; 3], dt: f64) -> PointRows<T> {
        let zero = T::zero();
        let least = self.least_velocity(depth, v[0], dt);
        let towards = |target: T, v: T| (target - v) * (1.0 / dt);
        PointRows {
            wanted: [
                towards(least, v[0]),
                towards(zero, v[1]),
                towards(zero, v[2]),
            ],
            regularization: [zero; 3],
        }
    }
}

impl<P: Scalar> RelaxedRigid<P> {
    /// # Panics
    /// If a number makes no sense, with its name.
    pub(super) fn check(&self) {
        given::not_negative_or_infinite("friction of relaxed rigid contact", self.friction);
        let ratio = self.friction_impedance_ratio;
        given::positive("ratio of impedances of relaxed rigid contact", ratio);
        self.reference.check();
        self.impedance.check();
    }

    /// Converts the law to another scalar type.
    pub fn cast<Q: Over<P>>(&self) -> RelaxedRigid<Q> {
        RelaxedRigid {
            friction: self.friction.into(),
            reference: match self.reference {
                Reference::TimeConstant {
                    time_constant,
                    damping_ratio,
                } => Reference::TimeConstant {
                    time_constant: time_constant.into(),
                    damping_ratio: damping_ratio.into(),
                },
                Reference::Direct { stiffness, damping } => Reference::Direct {
                    stiffness: stiffness.into(),
                    damping: damping.into(),
                },
            },
            impedance: self.impedance.cast(),
            friction_impedance_ratio: self.friction_impedance_ratio.into(),
        }
    }

    /// Reference acceleration and regularisation R of a point at a depth (m) with a velocity (normal, tangent, tangent; m/s), which a unit
    /// force along the normal accelerates by `mobility` (1/kg); above the ground it gives way without a force.
    pub fn ask<T: Over<P>>(&self, depth: T, v: &[T; 3], mobility: T) -> PointRows<T> {
        self.ask_with(depth, v, mobility, |_, _| T::constant(f64::INFINITY))
    }

    /// [`ask`](Self::ask) for the law smoothed with κ > 0 (N·m/s²), which is felt above the ground as well: there the point follows the
    /// same reference, and gives way by (k d δ)² / κ more.
    pub fn ask_smoothed<T: Over<P>>(
        &self,
        depth: T,
        v: &[T; 3],
        mobility: T,
        kappa: f64,
    ) -> PointRows<T> {
        let above = |pull: T, give: T| pull * pull * (1.0 / kappa) + give;
        self.ask_with(depth, v, mobility, above)
    }

    /// With the R above the ground, from k d δ and the R below.
    fn ask_with<T: Over<P>>(
        &self,
        depth: T,
        v: &[T; 3],
        mobility: T,
        above: impl FnOnce(T, T) -> T,
    ) -> PointRows<T> {
        let (d, (b, k)) = (
            self.impedance.at(depth),
            self.reference.gains(&self.impedance),
        );
        let give = (T::one() - d) / d * mobility;
        let (b, k) = (T::from(b), T::from(k));
        let pull = k * d * depth;
        let give = depth.select_lt(T::zero(), above(pull, give), give);
        let across = give / T::from(self.friction_impedance_ratio);
        PointRows {
            wanted: [pull - b * v[0], -(b * v[1]), -(b * v[2])],
            regularization: [give, across, across],
        }
    }
}

impl<P: Scalar> Reference<P> {
    /// # Panics
    /// If a number makes no sense, with its name.
    fn check(&self) {
        match *self {
            Self::TimeConstant {
                time_constant,
                damping_ratio,
            } => {
                given::positive("time constant of relaxed rigid contact", time_constant);
                given::positive("damping ratio of relaxed rigid contact", damping_ratio);
            }
            Self::Direct { stiffness, damping } => {
                given::not_negative("stiffness of relaxed rigid contact", stiffness);
                given::not_negative("damping of relaxed rigid contact", damping);
            }
        }
    }

    fn gains(&self, impedance: &Impedance<P>) -> (P, P) {
        let (one, d) = (P::one(), impedance.largest);
        match *self {
            Self::TimeConstant {
                time_constant,
                damping_ratio,
            } => {
                let rate = one / (d * time_constant);
                let scaled = rate / damping_ratio;
                (rate * 2.0, scaled * scaled)
            }
            Self::Direct { stiffness, damping } => (damping / d, stiffness / (d * d)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The share of its height (m) to which a point comes back that falls with g = 9.81 m/s², in steps of `dt`: in the mean, least and most, by
    /// where in a step it lands.
    fn bounces(restitution: f64, height: f64, dt: f64) -> [f64; 3] {
        const PHASES: u32 = 400;
        let law = Rigid {
            restitution,
            ..Rigid::default()
        };
        let share = |phase: u32| {
            let step = dt * (2.0 * 9.81 * height).sqrt();
            let start = height + step * f64::from(phase) / f64::from(PHASES);
            let (mut z, mut v) = (start, 0.0);
            let mut apex = f64::NEG_INFINITY;
            // Until it has come up and goes down again.
            while z > apex {
                if v > 0.0 {
                    apex = z;
                }
                let asked = law.ask(-z, &[v, 0.0, 0.0], dt).wanted[0];
                v += dt * asked.max(-9.81);
                z += dt * v;
            }
            apex / start
        };
        let shares: Vec<f64> = (0..PHASES).map(share).collect();
        [
            shares.iter().sum::<f64>() / f64::from(PHASES),
            shares.iter().copied().fold(f64::INFINITY, f64::min),
            shares.iter().copied().fold(0.0, f64::max),
        ]
    }

    // The figures of the documentation.
    #[test]
    fn heights_after_an_impact_equal_the_table() {
        for (e, height, dt, expected) in [
            (0.9, 1.0, 1e-3, [0.811, 0.807, 0.811]),
            (0.9, 1.0, 2e-3, [0.811, 0.804, 0.812]),
            (0.9, 1.0, 5e-3, [0.813, 0.796, 0.815]),
            (0.9, 1.0, 1e-2, [0.816, 0.779, 0.820]),
            (0.5, 1.0, 1e-3, [0.252, 0.249, 0.254]),
            (0.5, 1.0, 2e-3, [0.254, 0.249, 0.258]),
            (0.5, 1.0, 5e-3, [0.261, 0.248, 0.269]),
            (0.5, 1.0, 1e-2, [0.271, 0.245, 0.287]),
            (0.9, 0.1, 1e-2, [0.824, 0.716, 0.840]),
        ] {
            let found = bounces(e, height, dt);
            for (found, expected) in found.iter().zip(expected) {
                assert!(
                    (found - expected).abs() < 1e-3,
                    "{e} {height} {dt}: {found} {expected}"
                );
            }
        }
        // The limit of short steps.
        assert!((bounces(0.9, 1.0, 1e-5)[0] - 0.81).abs() < 1e-4);
    }
}
