//! Rigid contact: Coulomb friction, impacts with restitution, and no compliance.

use super::law::{ContactRow, LawKind, PointKinematics, PointLaw, ROWS};
use crate::cone::Law;
use crate::contact::activation::ActivationMargin;
use crate::contact::material::Material;
use crate::contact::reason::{ContactReason, PointOutcome};
use crate::contact::turning::TurningFriction;
use crate::numbers::numbers;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::dot;

/// A point less deep or high than this, m, which moves along the normal by less in a step, is at rest on the surface, where the derivatives
/// of [`Rigid`] are the mean of those on both sides: far above the rounding that decides on which side a body rests, and so small that
/// nothing else can tell.
const AT_REST: f64 = 1e-9;
/// Rigid contact with Coulomb friction in an elliptic cone, and impacts with restitution: velocities after a step satisfy vₙ⁺ ≥ e |vₙ|, and a force
/// acts only if equality holds; friction opposes the slip (De Saxcé's formulation).
///
/// It acts over a step, so it needs the integrators semi-implicit Euler or implicit velocity.
///
/// # At rest
/// The reference velocity of a point is nonsmooth at the surface: δ / Δt above, δ / T below with the recovery time T, and −e vₙ for a velocity into
/// the ground. A body at rest is at this nonsmooth point, on a side that rounding determines. Within 1 nm of the surface, and with less than 1 nm of
/// motion along the normal in a step, derivatives are the means of both sides, (1 / Δt + 1 / T) / 2 in the depth and −e / 2 in vₙ. This equals the
/// central difference, is an element of the generalised Jacobian [Clarke 1983], and is suitable for the design of a regulator. Values are unchanged.
/// [`ContactReason`](crate::sim::ContactReason) marks such points.
///
/// # Impact times
/// With a restitution above zero, an isolated impact happens at its exact time within the step, and the rest of the step follows it.
/// This holds for values and for all derivatives, which include the dependence of the impact time on state, input and parameters (the saltation
/// matrix, by the implicit function theorem). So chained derivatives through impacts are those of the motion. Velocities of semi-implicit Euler count
/// as those of half a step earlier, so motion in a constant field is exact between impacts and through them. An impact is isolated if
///
/// - a single contact point, with the ground or between bodies, begins to touch in the step; other points may already be in contact,
/// - it arrives with at least 2 mm/s, and leaves with at least twice the velocity that the other forces add within a step,
/// - and the rest of the step increases the depth of no other point.
///
/// All other impacts act over whole steps: several points that begin to touch in one step (a box that lands flat), a second impact in the same step,
/// the last small bounces before a body rests, impacts without restitution, smoothed contact, steps over [lanes](crate::Lanes) and recorded graphs.
/// Batches step states with isolated impacts one by one. All other forces are constant over a step with an impact; they act for 1 µs more, the
/// duration of the impact.
///
/// # Limitations
/// Derivatives of a step are exact, but the time of an impact over whole steps does not depend on the state: chained derivatives through it are those
/// of an impact at a fixed time. If this matters, use [`SoftContact`](crate::contact::SoftContact), which resolves the impact.
///
/// The restitution of impacts over whole steps has an error of first order in the step. A ball that falls 1 m would rebound to this share of its
/// height, on average (and in this range, depending on the landing time within a step):
///
/// | e | exact, e² | at 1 ms | at 2 ms | at 5 ms | at 10 ms |
/// |---|---|---|---|---|---|
/// | 0.9 | 0.81 | 0.811 (0.807 to 0.811) | 0.811 (0.804 to 0.812) | 0.813 (0.796 to 0.815) | 0.816 (0.779 to 0.820) |
/// | 0.5 | 0.25 | 0.252 (0.249 to 0.254) | 0.254 (0.249 to 0.258) | 0.261 (0.248 to 0.269) | 0.271 (0.245 to 0.287) |
///
/// The error is proportional to the ratio of the step to the time of the fall: from 0.1 m at 10 ms, e = 0.9 gives 0.824 (0.72 to 0.84).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rigid<P = f64> {
    /// μ, the coefficient of friction; infinite for no slip.
    pub friction: P,
    /// e in 0..1, the coefficient of restitution: the ratio of normal velocities after and before an impact.
    pub restitution: P,
    /// Time in which a penetration recovers, s; a larger value is gentler, and leaves the point in the ground longer. Recovery adds energy, m g δ for
    /// a single body. A rim that rotates fast, at Ω with the tilt α, penetrates by about ½ r α Ω² Δt T, because its lowest point moves by Ω Δt in a
    /// step.
    pub recovery_time: P,
}
numbers! { pub struct Rigid {
    friction: NotNegativeOrInfinite("friction", "friction of rigid contact"),
    restitution: WithinOne("restitution", "restitution of rigid contact"),
    recovery_time: Positive("recovery time", "recovery time of rigid contact"),
} }

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
impl<P: Scalar> Rigid<P> {
    /// See [`PointLaw::least_velocity`]; `v` is that along the normal.
    fn velocity_after_step<D: Scalar, T: Over<P> + Over<D>>(&self, depth: T, v: T, dt: D) -> T {
        let zero = T::zero();
        let recovered = depth / T::from(self.recovery_time);
        let closing = depth * (D::one() / dt);
        let allowed = zero.select_lt(depth, recovered, closing);
        // A point that would go deeper within the step bounces.
        let bounce = -(v * self.restitution);
        let impact = v.select_lt(zero, bounce, zero);
        // Where both are equal, as without restitution at the surface, a point above it would bounce: the closing velocity is that of no side.
        let bounced = impact.select_lt(allowed, allowed, impact);
        let exact = v.select_lt(allowed, bounced, allowed);
        // At rest, the same value with the means of the derivatives on both sides.
        let mean = (recovered + closing + bounce) * 0.5;
        let value_of = |x: T| T::from_values(|lane| x.value(lane));
        let at_rest = mean - value_of(mean) + value_of(exact);
        let step = v * dt;
        let margin = T::constant(AT_REST * AT_REST);
        let at_surface = (depth * depth).select_lt(margin, at_rest, exact);
        (step * step).select_lt(margin, at_surface, exact)
    }

    /// See [`PointLaw::rows`]; above the ground a point may come down to it within the step; below, it comes back in the recovery time;
    /// where it bounces, faster.
    fn rows_over<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        depth: T,
        v: &[T; ROWS],
        dt: D,
    ) -> [ContactRow<T>; ROWS] {
        let zero = T::zero();
        let least = self.velocity_after_step(depth, v[0], dt);
        let towards = |target: T, v: T| ContactRow {
            reference: (target - v) * (D::one() / dt),
            compliance: zero,
        };
        [
            towards(least, v[0]),
            towards(zero, v[1]),
            towards(zero, v[2]),
        ]
    }
}

impl<P: Scalar> PointLaw<P> for Rigid<P> {
    const KIND: LawKind = LawKind {
        name: "rigid",
        solved_explicitly: true,
        solved_implicitly: true,
        cone: Law::Coulomb,
        bristle: false,
        acts_over_step: true,
        can_be_smoothed: true,
        working_set: true,
        reads_delassus: false,
    };

    fn material(&self) -> Material<P> {
        Material {
            friction: self.friction,
            restitution: self.restitution,
            margin: P::zero(),
            turning: TurningFriction::none(),
            compliance: None,
        }
    }

    fn set_material(&mut self, pair: Material<P>) {
        (self.friction, self.restitution) = (pair.friction, pair.restitution);
    }

    /// Takes points that could come down within the step, also under the forces of others.
    fn activation_margin<D: Scalar>(&self, dt: D) -> ActivationMargin<D> {
        ActivationMargin::over_step(dt)
    }

    fn rows<D: Scalar, T: Over<P> + Over<D>>(
        &self,
        at: &PointKinematics<'_, D, T>,
    ) -> [ContactRow<T>; ROWS] {
        self.rows_over(at.state.depth, &at.velocity(), at.dt)
    }

    fn least_velocity<D: Scalar, T: Over<P> + Over<D>>(&self, depth: T, v: T, dt: D) -> Option<T> {
        Some(self.velocity_after_step(depth, v, dt))
    }

    /// A point at rest exactly on the surface is marked, without smoothing: the law is nonsmooth there.
    fn reason<T: Scalar>(&self, at: &PointOutcome<'_, T>) -> ContactReason {
        let reason = ContactReason::of_mode(at.state, at.mode);
        let along = dot(&at.state.normal, &at.state.velocity);
        let at_rest = is_at_rest(at.state.depth.value(0), at.dt * along.value(0));
        match reason {
            reason if at.is_smoothed || !at_rest => reason,
            ContactReason::Sticking => ContactReason::Resting,
            ContactReason::Sliding => ContactReason::Gliding,
            // A point that no force has to hold takes no part in the solution.
            ContactReason::Leaving { .. } => ContactReason::Touching,
            reason => reason,
        }
    }
}

/// Whether a point at a depth (m) that moves along the normal so far in a step (m) is taken for one at rest on the surface.
fn is_at_rest(depth: f64, step: f64) -> bool {
    depth.abs() < AT_REST && step.abs() < AT_REST
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
                let row = law.rows_over(-z, &[v, 0.0, 0.0], dt)[0];
                v += dt * row.reference.max(-9.81);
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

    const LAW: Rigid = Rigid {
        friction: 0.5,
        restitution: 0.6,
        recovery_time: 0.04,
    };

    // Above the ground a point may come down to it within the step, below it comes back in the recovery time; what would go deeper bounces.
    #[test]
    fn least_velocity_equals_its_closed_form_on_each_side() {
        let dt = 0.01;
        for (depth, v, expected) in [
            (-0.02, -1.0, -0.02 / dt),
            (-0.02, -5.0, 3.0),
            (0.002, 1.0, 0.002 / 0.04),
            (0.002, -1.0, 0.6),
            (0.08, -1.0, 2.0),
        ] {
            let found = LAW.velocity_after_step(depth, v, dt);
            assert!((found - expected).abs() < 1e-15, "{depth} {v}: {found}");
        }
    }

    #[test]
    fn rows_lead_to_the_least_velocity_and_to_no_slip_without_compliance() {
        let at = super::super::law::SamplePoint {
            depth: 0.002,
            velocity: [-1.0, 0.3, -0.2],
            dt: 0.01,
            ..Default::default()
        };
        let rows = at.rows(&LAW);
        for ((row, v), end) in rows.iter().zip(at.velocity).zip([0.6, 0.0, 0.0]) {
            assert!((v + at.dt * row.reference - end).abs() < 1e-15);
            assert_eq!(row.compliance, 0.0);
        }
    }

    // (1 / Δt + 1 / T) / 2 in the depth and −e / 2 in the velocity, with the values of the exact law.
    #[test]
    fn slopes_at_rest_are_the_means_of_both_sides() {
        use crate::autodiff::Dual;
        let dt = 0.01;
        for (depth, v) in [(0.0, 0.0), (1e-10, 0.0), (-1e-10, 1e-9)] {
            let at = (Dual::<f64, 2>::variable(depth, 0), Dual::variable(v, 1));
            let found = LAW.velocity_after_step(at.0, at.1, dt);
            assert_eq!(found.re, LAW.velocity_after_step(depth, v, dt));
            assert!((found.eps[0] - 0.5 * (1.0 / dt + 1.0 / 0.04)).abs() < 1e-12);
            assert!((found.eps[1] + 0.3).abs() < 1e-15);
        }
        let beside =
            LAW.velocity_after_step(Dual::<f64, 2>::variable(1e-8, 0), Dual::from(0.0), dt);
        assert!((beside.eps[0] - 1.0 / 0.04).abs() < 1e-12);
    }
}
