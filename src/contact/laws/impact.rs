//! Impacts in closed form: the restitution of a spring and damper of Hunt and Crossley, the damping for a restitution, the time of contact.
//!
//! A mass m arrives at the speed v, nothing else acts on it, and q = 1 + p = n, so that the force is  f = K δⁿ (1 + a δ̇)  with a = D / K.
//! From m δ̇ dδ̇ = −f dδ follows
//!
//! > m δ̇ dδ̇ / (1 + a δ̇) = −K δⁿ dδ.
//!
//! The right side integrates to the same number on the way in (δ̇ from v to 0) and on the way out (δ̇ from 0 to −e v). With
//! G(y) = y − ln(1 + y), the integral of y dy / (1 + y), this is
//!
//! > G(a v) = G(−e a v),
//!
//! a relation between e and a v alone: neither the mass, nor K, nor p matters. As e a v < 1, the body leaves more slowly than 1 / a however fast
//! it comes, and the force never pulls. For small a v it says e = 1 − ⅔ a v, the relation of [Hunt, Crossley 1975].
//!
//! Without damping, energy gives δ̇ = v √(1 − (δ/δₘ)ⁿ⁺¹) with the greatest depth  δₘ = ((n + 1) m v² / (2 K))^(1/(n+1)), and a contact lasts
//!
//! > T = 2 ∫ dδ / δ̇ = (2 δₘ / v) √π Γ(1 + r) / Γ(½ + r),  r = 1 / (n + 1).

use std::f64::consts::PI;

use super::hunt_crossley::HuntCrossley;
use crate::special::ln_gamma;

/// Halvings of an interval, enough for the last bit of a double.
const HALVINGS: usize = 120;

impl HuntCrossley<f64> {
    /// Sets D, and q = 1 + p, for a given coefficient of restitution at an impact speed.
    ///
    /// With q = 1 + p the restitution depends on the speed and on D / K alone, not on the mass: it is lower for faster impacts, and tends to 1 for
    /// slow ones, e ≈ 1 − ⅔ (D / K) v. With gravity or a motor force on the body the rebound is slightly lower.
    ///
    /// # Panics
    /// If the restitution is not in (0, 1], or the speed (m/s, rad/s) is not positive and finite.
    ///
    /// # Examples
    /// ```
    /// use dualbody::contact::HuntCrossley;
    ///
    /// let spring = HuntCrossley::linear(1e5, 0.0).with_restitution(0.6, 2.0);
    /// assert_eq!(spring.damping_exponent, 1.0);
    /// assert!((spring.restitution(2.0).unwrap() - 0.6).abs() < 1e-12);
    /// ```
    ///
    /// # References
    /// [Hunt, Crossley 1975].
    #[must_use]
    pub fn with_restitution(mut self, restitution: f64, speed: f64) -> Self {
        assert!(
            restitution > 0.0 && restitution <= 1.0,
            "a restitution of {restitution} is not in (0, 1]; a smaller one takes more damping than a step resolves"
        );
        assert_speed(speed);
        // With w = e a v:  G(w / e) = G(−w); the left side is the larger one below the root.
        let w = bisected(|w| work(w / restitution) > work(-w));
        self.damping_exponent = 1.0 + self.stiffness_exponent;
        self.damping = self.stiffness * w / (restitution * speed);
        self
    }

    /// Coefficient of restitution of an impact at a speed (m/s, rad/s), without other forces: ratio of rebound speed to impact speed.
    ///
    /// `None` if q ≠ 1 + p: then it depends on the mass and has no closed form.
    ///
    /// # Panics
    /// If the speed is not positive and finite.
    ///
    /// # References
    /// [Hunt, Crossley 1975].
    pub fn restitution(&self, speed: f64) -> Option<f64> {
        assert_speed(speed);
        if self.damping == 0.0 {
            return Some(1.0);
        }
        if !self.has_matching_exponents() || self.stiffness == 0.0 {
            return None;
        }
        let y = self.damping / self.stiffness * speed;
        let w = bisected(|w| work(y) > work(-w));
        Some((w / y).min(1.0))
    }

    /// Time of contact of an impact, s, of a mass (kg, kg·m²) at a speed (m/s, rad/s), without damping and other forces.
    ///
    /// Damping prolongs the rebound: with p = 3/2 the contact lasts 14 % longer at a restitution of 0.6, and 2.6 times as long at 0.1. To resolve an
    /// impact, use steps of about a fiftieth of this time, see [`SoftContact`](super::SoftContact).
    ///
    /// # Panics
    /// If mass or speed are not positive and finite, or the stiffness is zero.
    ///
    /// # Examples
    /// ```
    /// use dualbody::contact::HuntCrossley;
    ///
    /// // A linear spring: half a period of the oscillation, π √(m / K).
    /// let time = HuntCrossley::linear(100.0, 0.0).impact_time(4.0, 2.0);
    /// assert!((time - std::f64::consts::PI * 0.2).abs() < 1e-12);
    /// ```
    pub fn impact_time(&self, mass: f64, speed: f64) -> f64 {
        assert_speed(speed);
        assert!(
            mass > 0.0 && mass.is_finite() && self.stiffness > 0.0,
            "an impact takes a mass and a stiffness that are positive, not {mass} and {}",
            self.stiffness
        );
        let order = 2.0 + self.stiffness_exponent;
        let depth = self.depth_of(mass, 0.5 * speed * speed);
        let (above, below) = (ln_gamma(1.0 + 1.0 / order), ln_gamma(0.5 + 1.0 / order));
        2.0 * depth / speed * PI.sqrt() * (above - below).exp()
    }

    /// The greatest depth of an impact, m, with damping where q = 1 + p, else without:  δₘⁿ⁺¹ = (n + 1) m G(a v) / (a² K).
    pub(crate) fn impact_depth(&self, mass: f64, speed: f64) -> f64 {
        let ratio = self.damping / self.stiffness;
        if ratio == 0.0 || !self.has_matching_exponents() {
            return self.depth_of(mass, 0.5 * speed * speed);
        }
        self.depth_of(mass, work(ratio * speed) / (ratio * ratio))
    }

    /// Depth at which the spring has taken an energy of each unit of mass.
    fn depth_of(&self, mass: f64, energy: f64) -> f64 {
        let order = 2.0 + self.stiffness_exponent;
        (order * mass * energy / self.stiffness).powf(1.0 / order)
    }

    /// q = 1 + p
    fn has_matching_exponents(&self) -> bool {
        (self.damping_exponent - self.stiffness_exponent - 1.0).abs() < 1e-12
    }
}

fn assert_speed(speed: f64) {
    assert!(
        speed > 0.0 && speed.is_finite(),
        "a speed of impact of {speed} is not positive and finite"
    );
}

/// G(y) = y − ln(1 + y) for y ≥ −1; near 0 by its series, as the difference would lose its digits.
fn work(y: f64) -> f64 {
    if y.abs() > 0.02 {
        return y - y.ln_1p();
    }
    // y² (1/2 − y (1/3 − y (1/4 − …)))
    let series = (2..10)
        .rev()
        .fold(0.0, |sum, k| 1.0 / f64::from(k) - y * sum);
    y * y * series
}

/// The number in (0, 1) below which something holds.
fn bisected(holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if holds(middle) { &mut low } else { &mut high }) = middle;
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Restitution and time of contact of a mass of 1 kg by small steps of the Runge–Kutta method.
    fn simulated(law: &HuntCrossley, speed: f64, dt: f64) -> (f64, f64) {
        let rate = |[d, v]: [f64; 2]| [v, -law.force(d, v)];
        let mut x = [0.0, speed];
        let mut time = 0.0;
        while x[0] >= 0.0 {
            let moved = |k: [f64; 2], h: f64| [x[0] + h * k[0], x[1] + h * k[1]];
            let k1 = rate(x);
            let k2 = rate(moved(k1, 0.5 * dt));
            let k3 = rate(moved(k2, 0.5 * dt));
            let k4 = rate(moved(k3, dt));
            for i in 0..2 {
                x[i] += dt / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
            }
            time += dt;
        }
        (-x[1] / speed, time)
    }

    #[test]
    fn restitution_and_time_of_contact_equal_those_of_the_motion() {
        for p in [0.0, 0.5, 1.5] {
            let spring = HuntCrossley {
                stiffness: 1e4,
                damping: 0.0,
                stiffness_exponent: p,
                damping_exponent: 0.0,
            };
            let (_, time) = simulated(&spring, 2.0, 1e-5);
            assert!((time - spring.impact_time(1.0, 2.0)).abs() < 3e-5, "{p}");
            for e in [0.9, 0.6, 0.2] {
                let law = spring.with_restitution(e, 2.0);
                let (found, _) = simulated(&law, 2.0, 1e-5);
                assert!((found - e).abs() < 1e-4, "{p} {e} {found}");
                for speed in [0.5, 8.0] {
                    let (found, _) = simulated(&law, speed, 1e-5);
                    let expected = law.restitution(speed).unwrap();
                    assert!((found - expected).abs() < 1e-4, "{p} {e} {speed} {found}");
                }
            }
        }
    }

    #[test]
    fn restitution_and_damping_are_inverse_to_each_other() {
        for e in [1e-3, 0.1, 0.5, 0.99, 1.0 - 1e-9, 1.0] {
            let law = HuntCrossley::linear(3e4, 7.0).with_restitution(e, 0.3);
            assert!((law.restitution(0.3).unwrap() - e).abs() < 1e-11, "{e}");
        }
    }

    // e = 1 − ⅔ a v
    #[test]
    fn slow_impacts_obey_the_relation_of_hunt_and_crossley() {
        let law = HuntCrossley {
            damping_exponent: 1.0,
            ..HuntCrossley::linear(1e4, 1e4 * 0.1)
        };
        let e = law.restitution(1e-3).unwrap();
        assert!((e - (1.0 - 2.0 / 3.0 * 1e-4)).abs() < 1e-8);
    }

    #[test]
    fn restitution_has_no_closed_form_with_other_exponents() {
        assert_eq!(HuntCrossley::linear(1e4, 10.0).restitution(1.0), None);
        assert_eq!(HuntCrossley::linear(1e4, 0.0).restitution(1.0), Some(1.0));
    }

    #[test]
    #[should_panic(expected = "a restitution of 0 is not in (0, 1]")]
    fn restitution_of_nothing_is_refused() {
        let _ = HuntCrossley::linear(1e4, 0.0).with_restitution(0.0, 1.0);
    }
}
