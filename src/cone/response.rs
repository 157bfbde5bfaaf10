//! The force that a law gives for the push on a unit, and its derivatives: the law with a spring between force and velocity.
//!
//! With c = ρ f̄ − Xᵀ z − g and the compliance R + ρ the force is that with which the law holds for the velocity  (R + ρ) f − c: of the convex law the
//! projection of c / (R + ρ) on the cone, of Coulomb's the normal part first and then the part across in its circle.

use super::Law;
use super::certificate::project;
use super::interval::clamped;
use super::jacobian::Square;
use super::newton::Newton;
use super::system::{Kind, Unit};
use crate::scalar::{MapEach, from_each};

/// Law of a unit with its compliance.
#[derive(Clone, Copy)]
pub(super) struct Response {
    law: Law,
    /// `None` where it takes no part.
    kind: Option<Kind>,
    mu: f64,
    /// R + ρ along the normal, and across it.
    along: f64,
    across: f64,
}

impl Response {
    /// That of a unit.
    ///
    /// * `law` – of cones
    pub(super) fn of(newton: &Newton, law: Law, unit: &Unit, rho: f64) -> Self {
        let compliance = |row: usize| newton.blocks.diagonal[row] + rho;
        Self {
            law,
            kind: Some(unit.kind).filter(|_| !unit.absent),
            mu: unit.mu,
            along: compliance(unit.row),
            across: compliance(unit.row + unit.rows() - 1),
        }
    }

    /// The force.
    pub(super) fn force(&self, c: [f64; 3]) -> [f64; 3] {
        let alone = |f: f64| [f, 0.0, 0.0];
        match (self.kind, self.law) {
            // Moments are not solved by blocks.
            (None | Some(Kind::Spin | Kind::Roll), _) => [0.0; 3],
            (Some(Kind::Row), _) => alone(c[0] / self.along),
            (Some(Kind::Ray), _) => alone(c[0].max(0.0) / self.along),
            (Some(Kind::Interval), _) => alone(clamped(c[0] / self.along, self.mu)),
            (Some(Kind::Cone), Law::Coulomb) => self.force_after_coulomb(c),
            (Some(Kind::Cone), Law::Convex) => {
                let s = self.stretch();
                let scaled = [c[0], c[1] / s, c[2] / s].map_each(|c| c / self.along);
                let f = project(scaled, self.mu * s);
                [f[0], f[1] / s, f[2] / s]
            }
        }
    }

    /// ∂f/∂c.
    ///
    /// * `f` – the force for c
    pub(super) fn slopes(&self, c: [f64; 3], f: [f64; 3]) -> Square {
        let free = match self.kind {
            None | Some(Kind::Spin | Kind::Roll) => false,
            Some(Kind::Row) => true,
            Some(Kind::Ray) => c[0] > 0.0,
            Some(Kind::Interval) => (c[0] / self.along).abs() < self.mu,
            Some(Kind::Cone) if self.law == Law::Coulomb => return self.coulomb_slopes(c, f),
            Some(Kind::Cone) => return self.convex_slopes(c),
        };
        let mut h = [[0.0; 3]; 3];
        if free {
            h[0][0] = 1.0 / self.along;
        }
        h
    }

    /// Scale of the part across in coordinates in which the compliance is that of the normal everywhere.
    fn stretch(&self) -> f64 {
        (self.across / self.along).sqrt()
    }

    fn force_after_coulomb(&self, c: [f64; 3]) -> [f64; 3] {
        let normal = c[0].max(0.0) / self.along;
        let t = [c[1] / self.across, c[2] / self.across];
        let length = t[0].hypot(t[1]).max(f64::MIN_POSITIVE);
        let share = (self.mu * normal / length).min(1.0);
        [normal, share * t[0], share * t[1]]
    }

    fn coulomb_slopes(&self, c: [f64; 3], f: [f64; 3]) -> Square {
        let mut h = [[0.0; 3]; 3];
        if f[0] <= 0.0 {
            return h;
        }
        h[0][0] = 1.0 / self.along;
        let (length, radius) = (c[1].hypot(c[2]).max(f64::MIN_POSITIVE), self.mu * f[0]);
        if length <= radius * self.across {
            (h[1][1], h[2][2]) = (1.0 / self.across, 1.0 / self.across);
            return h;
        }
        let (d, turned) = (
            [c[1] / length, c[2] / length],
            [-c[2] / length, c[1] / length],
        );
        for i in 0..2 {
            h[1 + i][0] = self.mu * d[i] / self.along;
            for j in 0..2 {
                h[1 + i][1 + j] = radius / length * turned[i] * turned[j];
            }
        }
        h
    }

    fn convex_slopes(&self, c: [f64; 3]) -> Square {
        let s = self.stretch();
        let scale = [1.0, s, s];
        let slopes = slopes_of_projection([c[0], c[1] / s, c[2] / s], self.mu * s);
        from_each(|i| from_each(|j| slopes[i][j] / (scale[i] * scale[j] * self.along)))
    }
}

/// Derivatives of the projection on the cone ‖aₜ‖ ≤ μ aₙ, symmetric.
fn slopes_of_projection(a: [f64; 3], mu: f64) -> Square {
    let l = a[1].hypot(a[2]);
    if a[0] >= 0.0 && l <= mu * a[0] {
        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    }
    let p = (a[0] + mu * l) / (1.0 + mu * mu);
    if p <= 0.0 {
        return [[0.0; 3]; 3];
    }
    let l = l.max(f64::MIN_POSITIVE);
    let (share, across) = (1.0 / (1.0 + mu * mu), mu * p / l);
    let d = [1.0, mu * a[1] / l, mu * a[2] / l];
    let turned = [0.0, -a[2] / l, a[1] / l];
    let entry = |i: usize, j: usize| share * d[i] * d[j] + across * turned[i] * turned[j];
    from_each(|i| from_each(|j| entry(i, j)))
}

#[cfg(test)]
mod tests {
    use super::*;

    // Derivatives beside central differences, on every piece of both laws, with another compliance across than along.
    #[test]
    fn slopes_equal_finite_differences() {
        const BY: f64 = 1e-6;
        for law in [Law::Convex, Law::Coulomb] {
            let response = Response {
                law,
                kind: Some(Kind::Cone),
                mu: 0.6,
                along: 0.4,
                across: 0.3,
            };
            for c in [
                [1.0, 0.1, -0.2],
                [0.5, 1.3, -0.7],
                [-0.1, 0.9, 0.4],
                [-2.0, 0.3, 0.1],
            ] {
                let slopes = response.slopes(c, response.force(c));
                for j in 0..3 {
                    let at = |by: f64| {
                        let mut moved = c;
                        moved[j] += by;
                        response.force(moved)
                    };
                    let (after, before) = (at(BY), at(-BY));
                    for i in 0..3 {
                        let expected = (after[i] - before[i]) / (2.0 * BY);
                        let error = (slopes[i][j] - expected).abs();
                        assert!(error < 1e-8, "{law:?} {c:?} {i} {j}: {error:e}");
                    }
                }
            }
        }
    }
}
