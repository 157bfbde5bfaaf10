//! Longest stable steps of a mass on a spring and damper whose forces are those of the start of a step.

use nalgebra::Complex;

use super::remark::SPEED;
use crate::contact::HuntCrossley;
use crate::sim::integrators::linear_factor;

/// Halvings of an interval that holds the longest step: to twelve digits.
const HALVINGS: usize = 40;

/// A mass on a spring and damper.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpringDamper {
    /// N/m or N·m/rad.
    pub(super) spring: f64,
    /// N·s/m or N·m·s/rad.
    pub(super) damper: f64,
    /// kg or kg·m².
    pub(super) mass: f64,
}

impl SpringDamper {
    /// Slopes of a contact force at the deepest point of an impact at 1 m/s.
    pub(super) fn in_impact(law: &HuntCrossley, mass: f64) -> Self {
        let (depth, n) = (law.impact_depth(mass, SPEED), 1.0 + law.stiffness_exponent);
        Self {
            spring: law.stiffness * n * depth.powf(law.stiffness_exponent),
            damper: law.damping * depth.powf(law.damping_exponent),
            mass,
        }
    }

    /// The longest stable step of semi-implicit Euler, s.
    ///
    /// There v⁺ = v − Δt (s x + c v) / m and x⁺ = x + Δt v⁺, which is stable where Δt² s + 2 Δt c < 4 m.
    pub(super) fn longest_of_euler(self) -> f64 {
        let Self {
            spring,
            damper,
            mass,
        } = self;
        4.0 * mass / (damper + (damper * damper + 4.0 * mass * spring).sqrt())
    }

    /// The longest stable step of the Runge–Kutta method, s.
    ///
    /// A step multiplies a motion e^(λ t) by R(Δt λ), the series of the exponential function up to the fourth power. All steps at which |R| = 1
    /// first have |Δt λ| < 4.
    pub(super) fn longest_of_runge_kutta(self) -> f64 {
        // m λ² + c λ + s = 0
        let half = self.damper / (2.0 * self.mass);
        let root = Complex::from(half * half - self.spring / self.mass).sqrt();
        let rate = root.re.max(0.0) + half;
        let rate = Complex::new(-rate, root.im);
        let is_stable = |dt: f64| linear_factor(&(rate * dt), &Complex::ONE).norm_sqr() <= 1.0;
        let (mut stable, mut unstable) = (0.0, 4.0 / rate.norm());
        for _ in 0..HALVINGS {
            let middle = 0.5 * (stable + unstable);
            match is_stable(middle) {
                true => stable = middle,
                false => unstable = middle,
            }
        }
        stable
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // |R(i y)|² = 1 − y⁶ / 72 + y⁸ / 576 is 1 at y = √8; R(−x) = 1 at the real root of x³ − 4 x² + 12 x = 24.
    #[test]
    fn longest_step_of_runge_kutta_equals_closed_forms_on_both_axes() {
        let of = |spring, damper| SpringDamper {
            spring,
            damper,
            mass: 2.0,
        };
        let vibrating = of(200.0, 0.0).longest_of_runge_kutta();
        assert!((vibrating - 8.0_f64.sqrt() / 10.0).abs() < 1e-6);
        let x = of(0.0, 2.0).longest_of_runge_kutta();
        assert!((x * x * x - 4.0 * x * x + 12.0 * x - 24.0).abs() < 1e-9);
        assert!((x - 2.785_293_563_405_282).abs() < 1e-9);
    }
}
