//! Hunt–Crossley force: a spring with a damper that never pulls, for soft contact and joint limits.

use super::law::ContactRow;
use crate::numbers::numbers;
use crate::scalar::{Over, Scalar};

/// A spring with a damper that never pulls:  f = max(0, K δ¹⁺ᵖ + D δ^q δ̇) at a depth δ > 0, else 0.
///
/// For p, q > 0 force and damping grow from zero with the depth, so the force is continuous at touch-down; with q = 0 the damper acts fully from the
/// first touch. The clamp removes pulling forces, so a contact never adds energy. With q = 1 + p the clamp is inactive in an impact, and the
/// restitution has a closed form: [`with_restitution`](Self::with_restitution), [`restitution`](Self::restitution),
/// [`impact_time`](Self::impact_time).
///
/// # References
/// [Hunt, Crossley 1975]; [Azad, Featherstone 2010] for the exponents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HuntCrossley<P = f64> {
    /// K, N/m¹⁺ᵖ (at a joint N·m/rad¹⁺ᵖ); a larger value is harder and needs smaller steps.
    pub stiffness: P,
    /// D, N·s/m¹⁺^q (at a joint N·m·s/rad¹⁺^q); a larger value dissipates more.
    pub damping: P,
    /// p, the growth of stiffness with depth: 0 is a linear spring, ½ a sphere on a half-space (Hertz).
    pub stiffness_exponent: P,
    /// q, the growth of damping with depth.
    pub damping_exponent: P,
}

numbers! { pub struct HuntCrossley {
    stiffness: NotNegative("stiffness"),
    damping: NotNegative("damping"),
    stiffness_exponent: NotNegative("stiffness exponent"),
    damping_exponent: NotNegative("damping exponent"),
} }

/// A force at the end of a step, f = push − Δt resistance · a, that is linear in the acceleration a over the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepForce<T> {
    /// The force if nothing accelerates, N or N·m.
    pub(crate) push: T,
    /// Loss of force per unit of velocity, N·s/m or N·m·s/rad.
    pub(crate) resistance: T,
}

/// Coefficients of a linear spring and damper, s = K δᵖ and c = D δ^q.
#[derive(Clone, Copy)]
pub(crate) struct SpringDamper<T> {
    /// s, N/m.
    pub(crate) spring: T,
    /// c, N·s/m.
    pub(crate) damper: T,
}

/// Resistance below which a spring and damper count as this, N·s/m: it moves nothing.
const LEAST_RESISTANCE: f64 = 1e-12;

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

    /// Computes the force, N (N·m), at a depth δ (m, rad) that grows at the rate δ̇. At δ = 0 force and derivative are those of separation.
    pub fn force<T: Over<P>>(&self, depth: T, rate: T) -> T {
        let at = self.at(depth);
        at.force(depth, rate)
    }

    /// Row of the solver along the push of a spring and damper whose force is that at the end of a step: with f ≥ 0 ⊥ y ≥ 0 it has
    /// f = max(0, s δ⁺ + c δ̇⁺)  with δ̇⁺ = −(v + Δt a) and δ⁺ = δ + Δt δ̇⁺.
    ///
    /// s = K dᵖ belongs to the depth d = δ − Δt v that the step would reach, so that what arrives within the step is met; c = D δ^q to that of
    /// its start, so that nothing is damped before it touches. Without both the compliance is infinite, and there is no force.
    ///
    /// * `v` – velocity out of the depth, −δ̇ at the start
    /// * `dt` – the step, s
    pub(crate) fn row<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        depth: T,
        v: T,
        dt: D,
    ) -> ContactRow<T> {
        self.over_step(depth, v, dt).row(depth, v, dt)
    }

    /// The force of a spring and damper at the end of a step, as a function of the acceleration out of the depth, if it may pull.
    ///
    /// * `v` – velocity out of the depth, −δ̇ at the start
    /// * `dt` – the step, s
    pub(crate) fn step_force<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        depth: T,
        v: T,
        dt: D,
    ) -> StepForce<T> {
        let SpringDamper { spring, damper } = self.over_step(depth, v, dt);
        let resistance = spring * dt + damper;
        StepForce {
            push: spring * depth - resistance * v,
            resistance,
        }
    }

    /// Coefficients for a force at the end of a step: the spring of the depth that the step would reach, the damper of its start; zero where
    /// that depth is none.
    pub(super) fn over_step<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        depth: T,
        v: T,
        dt: D,
    ) -> SpringDamper<T> {
        let (zero, ahead) = (T::zero(), depth - v * dt);
        SpringDamper {
            spring: zero.select_lt(ahead, self.spring(log(ahead)), zero),
            damper: zero.select_lt(depth, self.damper(log(depth)), zero),
        }
    }

    /// Coefficients at a depth; without contact those of [`SHALLOW`].
    pub(super) fn at<T: Over<P>>(&self, depth: T) -> SpringDamper<T> {
        let log = log(depth);
        SpringDamper {
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

/// Depth whose coefficients are used without contact, m: a bristle without contact straightens as at this depth.
const SHALLOW: f64 = 1e-3;

/// ln δ, where there is no contact that of [`SHALLOW`].
fn log<T: Scalar>(depth: T) -> T {
    let shallow = T::constant(SHALLOW);
    T::zero().select_lt(depth, depth, shallow).ln()
}

impl<T: Scalar> SpringDamper<T> {
    /// s δ + c δ̇ where it pushes at a depth, else 0.
    pub(super) fn force(&self, depth: T, rate: T) -> T {
        let zero = T::zero();
        let force = self.spring * depth + self.damper * rate;
        zero.select_lt(depth, zero.select_lt(force, force, zero), zero)
    }

    /// s Δt + c: the force against a velocity that lasts for a step.
    pub(super) fn resistance<D: Scalar>(&self, dt: D) -> T
    where
        T: Over<D>,
    {
        let resistance = self.spring * dt + self.damper;
        resistance.max(T::constant(LEAST_RESISTANCE))
    }

    /// [`HuntCrossley::row`] with these coefficients.
    pub(crate) fn row<D: Scalar>(&self, depth: T, v: T, dt: D) -> ContactRow<T>
    where
        T: Over<D>,
    {
        let resistance = self.resistance(dt);
        let compliance = T::one() / (resistance * dt);
        ContactRow {
            reference: (self.spring * depth / resistance - v) * (D::one() / dt),
            compliance: self.if_touching(compliance, T::constant(f64::INFINITY)),
        }
    }

    /// One of two numbers by whether there is a spring or a damper.
    pub(super) fn if_touching(&self, then: T, other: T) -> T {
        T::zero().select_lt(self.spring + self.damper, then, other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Numbers;

    const LAW: HuntCrossley = HuntCrossley {
        stiffness: 2e4,
        damping: 300.0,
        stiffness_exponent: 0.5,
        damping_exponent: 1.5,
    };

    #[test]
    fn force_equals_the_power_law_where_it_pushes_and_is_zero_elsewhere() {
        let (depth, rate) = (0.01_f64, 0.2);
        let expected = 2e4 * depth.powf(1.5) + 300.0 * depth.powf(1.5) * rate;
        assert!((LAW.force(depth, rate) - expected).abs() < 1e-12 * expected);
        for (depth, rate) in [(0.0, 1.0), (-0.01, 1.0), (0.01, -100.0)] {
            assert_eq!(LAW.force(depth, rate), 0.0, "{depth} {rate}");
        }
    }

    // A mass that a unit force accelerates by G: f from the row at y = 0, and from the law at the end of the step.
    #[test]
    fn row_and_step_force_give_the_force_at_the_end_of_the_step() {
        let (law, g, dt) = (HuntCrossley::linear(5e3, 40.0), 0.5, 0.01);
        for (depth, v, free) in [(0.01, 0.0, 0.0), (0.002, -0.4, -9.81), (0.03, 0.1, 3.0)] {
            let row = law.row(depth, v, dt);
            // y = (G + R) f + a − reference
            let f = (row.reference - free) / (g + row.compliance);
            let a = free + g * f;
            let end = v + dt * a;
            let expected = 5e3 * (depth - dt * end) - 40.0 * end;
            assert!(
                (f - expected).abs() < 1e-9 * expected.abs(),
                "{f} {expected}"
            );
            let at_end = law.step_force(depth, v, dt);
            let other = at_end.push - dt * at_end.resistance * a;
            assert!((f - other).abs() < 1e-9 * expected.abs(), "{f} {other}");
        }
    }

    // The spring is that of the depth which the step would reach, the damper that of its start.
    #[test]
    fn coefficients_over_a_step_meet_what_arrives_and_damp_what_has_touched() {
        let dt = 0.01;
        let arriving = LAW.over_step(-0.001, -0.5, dt);
        assert!((arriving.spring - 2e4 * 0.004_f64.sqrt()).abs() < 1e-9);
        assert_eq!(arriving.damper, 0.0);
        let leaving = LAW.over_step(0.001, 0.5, dt);
        assert_eq!(leaving.spring, 0.0);
        assert!((leaving.damper - 300.0 * 0.001_f64.powf(1.5)).abs() < 1e-12);
        assert_eq!(LAW.row(-0.001, 0.0, dt).compliance, f64::INFINITY);
    }

    #[test]
    #[should_panic(expected = "the damping exponent is -1: negative or not finite")]
    fn negative_exponent_is_refused() {
        let odd = HuntCrossley {
            damping_exponent: -1.0,
            ..LAW
        };
        odd.check_numbers();
    }
}
