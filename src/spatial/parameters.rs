//! Inertias as parameter vectors: standard parameters, pseudo-inertia, log-Cholesky.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix4, SMatrix};

use super::linear::{add_cross, cross, dot};
use super::{Inertia, Motion, Symmetric3};
use crate::scalar::{Dual, Scalar, from_each};

/// Number of standard inertial parameters of a body.
pub const INERTIAL_PARAMETERS: usize = 10;

impl<P: Scalar> Inertia<P> {
    /// The standard parameters (m, hx, hy, hz, Jxx, Jxy, Jyy, Jxz, Jyz, Jzz), Pinocchio's order.
    #[inline]
    pub fn to_parameters(&self) -> [P; INERTIAL_PARAMETERS] {
        let (h, j) = (&self.first_moment, &self.rotational);
        [self.mass, h.x, h.y, h.z, j.xx, j.xy, j.yy, j.xz, j.yz, j.zz]
    }

    /// Makes a spatial inertia from the standard parameters; see [`to_parameters`](Self::to_parameters).
    #[inline]
    pub fn from_parameters(
        [m, hx, hy, hz, xx, xy, yy, xz, yz, zz]: [P; INERTIAL_PARAMETERS],
    ) -> Self {
        Self {
            mass: m,
            first_moment: nalgebra::Vector3::new(hx, hy, hz),
            rotational: Symmetric3::new(xx, xy, xz, yy, yz, zz),
        }
    }

    /// The inertia whose k-th standard parameter is one and whose others are zero: no body, but a direction of
    /// parameters.
    ///
    /// # Panics
    /// If `k ≥ 10`.
    pub(crate) fn unit(k: usize) -> Self {
        let mut parameters = [P::zero(); INERTIAL_PARAMETERS];
        parameters[k] = P::one();
        Self::from_parameters(parameters)
    }

    /// The derivatives of the power U · (I V) in the [standard parameters](Self::to_parameters) of I, in which it is linear.
    #[inline(always)]
    pub(crate) fn power_slopes(U: &Motion<P>, V: &Motion<P>) -> [P; INERTIAL_PARAMETERS] {
        let (u, v, a, b) = (&U.linear, &V.linear, &U.angular, &V.angular);
        // u · (ω × h) + Ω · (h × v) = h · (u × ω + v × Ω)
        let h = add_cross(&cross(u, b), v, a);
        [
            dot(u, v),
            h.x,
            h.y,
            h.z,
            a.x * b.x,
            a.x * b.y + a.y * b.x,
            a.y * b.y,
            a.x * b.z + a.z * b.x,
            a.y * b.z + a.z * b.y,
            a.z * b.z,
        ]
    }

    /// The pseudo-inertia [Σ h; hᵀ m] with Σ = ½ tr(J) 1 − J, the second moment of mass: an inertia is physically consistent if and only if it is
    /// positive definite.
    ///
    /// # References
    /// [Wensing, Kim, Slotine 2018].
    pub fn to_pseudo_inertia(&self) -> Matrix4<P> {
        let (h, j) = (&self.first_moment, &self.rotational);
        let half = (j.xx + j.yy + j.zz) * 0.5;
        let (xx, yy, zz) = (half - j.xx, half - j.yy, half - j.zz);
        let (xy, xz, yz) = (-j.xy, -j.xz, -j.yz);
        Matrix4::new(
            xx, xy, xz, h.x, xy, yy, yz, h.y, xz, yz, zz, h.z, h.x, h.y, h.z, self.mass,
        )
    }

    /// Makes a spatial inertia from a pseudo-inertia (its upper triangle): J = tr(Σ) 1 − Σ.
    pub(crate) fn from_pseudo_inertia(p: &Matrix4<P>) -> Self {
        let trace = p.m11 + p.m22 + p.m33;
        Self {
            mass: p.m44,
            first_moment: nalgebra::Vector3::new(p.m14, p.m24, p.m34),
            rotational: Symmetric3::new(
                trace - p.m11,
                -p.m12,
                -p.m13,
                trace - p.m22,
                -p.m23,
                trace - p.m33,
            ),
        }
    }

    /// Makes the inertia of log-Cholesky parameters θ = (α, d₁, d₂, d₃, s₁₂, s₂₃, s₁₃, t₁, t₂, t₃). All vectors of ten numbers give physically
    /// consistent inertias, and small changes remain small.
    ///
    /// The pseudo-inertia is U Uᵀ with U = eᵅ [e^d₁ s₁₂ s₁₃ t₁; 0 e^d₂ s₂₃ t₂; 0 0 e^d₃ t₃; 0 0 0 1].
    ///
    /// # References
    /// [Rucker, Wensing 2022].
    pub fn from_log_cholesky(theta: [P; INERTIAL_PARAMETERS]) -> Self {
        let [alpha, d1, d2, d3, s12, s23, s13, t1, t2, t3] = theta;
        let zero = P::zero();
        let (e1, e2, e3) = (d1.exp(), d2.exp(), d3.exp());
        let u = Matrix4::new(
            e1,
            s12,
            s13,
            t1,
            zero,
            e2,
            s23,
            t2,
            zero,
            zero,
            e3,
            t3,
            zero,
            zero,
            zero,
            P::one(),
        );
        let scale = (alpha * 2.0).exp();
        let product =
            |i: usize, k: usize| (0..4).fold(zero, |sum, l| sum + u[(i, l)] * u[(k, l)]) * scale;
        Self::from_pseudo_inertia(&Matrix4::from_fn(product))
    }

    /// The exact Jacobian ∂π/∂θ of the [standard parameters](Self::to_parameters) π (rows) in the log-Cholesky parameters θ (columns). Never singular;
    /// its inverse is the Jacobian of [`to_log_cholesky`](Self::to_log_cholesky). The pseudo-inertia is linear in π.
    ///
    /// # References
    /// [Rucker, Wensing 2022].
    pub fn log_cholesky_jacobian(
        theta: [P; INERTIAL_PARAMETERS],
    ) -> SMatrix<P, INERTIAL_PARAMETERS, INERTIAL_PARAMETERS> {
        let seeded = from_each(|k| Dual::variable(theta[k], k));
        let all: [Dual<P, INERTIAL_PARAMETERS>; INERTIAL_PARAMETERS] =
            Inertia::from_log_cholesky(seeded).to_parameters();
        SMatrix::from_fn(|row, column| all[row].eps[column])
    }

    /// The log-Cholesky parameters of a physically consistent inertia; not finite for an inconsistent one.
    pub fn to_log_cholesky(&self) -> [P; INERTIAL_PARAMETERS] {
        // P = U Uᵀ with upper triangular U, from the last column: U₄₄ = √m.
        let p = self.to_pseudo_inertia();
        let mut u = Matrix4::from_element(P::zero());
        for k in (0..4).rev() {
            let rest = |i: usize, u: &Matrix4<P>| {
                (k + 1..4).fold(p[(i, k)], |sum, l| sum - u[(i, l)] * u[(k, l)])
            };
            u[(k, k)] = rest(k, &u).sqrt();
            for i in 0..k {
                u[(i, k)] = rest(i, &u) / u[(k, k)];
            }
        }
        let unscaled = |i: usize, k: usize| u[(i, k)] / u[(3, 3)];
        let log = |k: usize| unscaled(k, k).ln();
        let alpha = u[(3, 3)].ln();
        [
            alpha,
            log(0),
            log(1),
            log(2),
            unscaled(0, 1),
            unscaled(1, 2),
            unscaled(0, 2),
            unscaled(0, 3),
            unscaled(1, 3),
            unscaled(2, 3),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{ROUNDING, SAME_ALGEBRA};
    use nalgebra::Vector3;
    use num_dual::Dual64;

    fn body() -> Inertia<f64> {
        Inertia::from_com(
            2.5,
            &Vector3::new(0.1, -0.2, 0.3),
            &Symmetric3::new(0.5, 0.02, -0.03, 0.4, 0.01, 0.3),
        )
    }

    fn assert_same(a: &Inertia<f64>, b: &Inertia<f64>) {
        let same = a
            .to_parameters()
            .iter()
            .zip(b.to_parameters())
            .all(|(a, b)| (a - b).abs() < 10.0 * ROUNDING);
        assert!(same, "{a:?} against {b:?}");
    }

    #[test]
    fn every_parametrisation_gives_the_body_back() {
        assert_same(&Inertia::from_parameters(body().to_parameters()), &body());
        assert_same(
            &Inertia::from_pseudo_inertia(&body().to_pseudo_inertia()),
            &body(),
        );
        assert_same(
            &Inertia::from_log_cholesky(body().to_log_cholesky()),
            &body(),
        );
    }

    // The pseudo-inertia of four point masses is Σ m (x; 1) (x; 1)ᵀ.
    #[test]
    fn pseudo_inertia_equals_the_second_moment_of_point_masses() {
        let points = [
            (1.0, [0.1, 0.2, 0.3]),
            (0.5, [-0.4, 0.0, 0.2]),
            (2.0, [0.3, -0.1, 0.0]),
            (0.7, [0.0, 0.5, -0.2]),
        ];
        let mut total = Inertia::zero();
        let mut expected = Matrix4::zeros();
        for (m, x) in points {
            total = total + Inertia::from_com(m, &x.into(), &Symmetric3::zero());
            let x = nalgebra::Vector4::new(x[0], x[1], x[2], 1.0);
            expected += x * x.transpose() * m;
        }
        assert!((total.to_pseudo_inertia() - expected).norm() < ROUNDING);
    }

    #[test]
    fn every_log_cholesky_vector_is_a_possible_body_with_finite_derivatives() {
        let theta = [0.3, -1.0, 2.0, -0.5, 0.7, -0.4, 1.1, 0.2, -3.0, 0.9];
        let pseudo = Inertia::from_log_cholesky(theta).to_pseudo_inertia();
        assert!(pseudo.cholesky().is_some());
        for k in 0..INERTIAL_PARAMETERS {
            let mut seeded = theta.map(Dual64::from);
            seeded[k].eps = 1.0;
            let back = Inertia::from_log_cholesky(seeded).to_log_cholesky();
            for (i, x) in back.iter().enumerate() {
                let expected = if i == k { 1.0 } else { 0.0 };
                assert!(
                    (x.re - theta[i]).abs() < SAME_ALGEBRA && (x.eps - expected).abs() < 1e-11,
                    "({i}, {k}): {x}"
                );
            }
        }
    }

    #[test]
    fn jacobian_of_log_cholesky_parameters_equals_central_differences() {
        const BY: f64 = 1e-6;
        let theta = [0.3, -1.0, 0.4, -0.5, 0.7, -0.4, 1.1, 0.2, -0.6, 0.9];
        let slopes = Inertia::log_cholesky_jacobian(theta);
        for k in 0..INERTIAL_PARAMETERS {
            let [after, before] = [BY, -BY].map(|by| {
                let mut moved = theta;
                moved[k] += by;
                Inertia::from_log_cholesky(moved).to_parameters()
            });
            for (i, (after, before)) in after.iter().zip(before).enumerate() {
                let expected = (after - before) / (2.0 * BY);
                let error = (slopes[(i, k)] - expected).abs();
                assert!(
                    error < 1e-8 * (1.0 + expected.abs()),
                    "({i}, {k}): {error:e}"
                );
            }
        }
        assert!(slopes.determinant() != 0.0);
    }

    #[test]
    fn power_slopes_equal_the_powers_of_unit_inertias() {
        let U = Motion::from_array([0.3, -1.0, 0.7, 2.0, 0.1, -0.4]);
        let V = Motion::from_array([1.3, 0.2, -0.6, -1.0, 0.9, 0.5]);
        let slopes = Inertia::power_slopes(&U, &V);
        for (k, slope) in slopes.into_iter().enumerate() {
            let power = U.power(&Inertia::<f64>::unit(k).times(&V));
            assert!((slope - power).abs() < ROUNDING, "{k}: {slope}, {power}");
        }
    }
}
