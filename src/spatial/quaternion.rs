//! Rotations as unit quaternions, with exponential and logarithm that are differentiable everywhere a rotation is.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::Mul;

use nalgebra::{Matrix3, Vector3};

use super::linear::{columns, cross, dot, from_columns, rotate_back};
use super::series::{arc_over_sine, cos_sinc};
use crate::scalar::{MapEach, Over, Scalar};

/// A rotation `R_AB` as a unit quaternion (w, x, y, z); `-q` is the same rotation.
///
/// # Examples
/// ```
/// use dualbody::spatial::Quaternion;
/// use nalgebra::Vector3;
///
/// let quarter_turn = Quaternion::exp(&Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2));
/// let y = quarter_turn.to_matrix() * Vector3::x();
/// assert!((y - Vector3::y()).norm() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion<T> {
    /// Scalar part, cos(θ/2).
    pub w: T,
    /// Vector part, sin(θ/2) times the axis.
    pub xyz: Vector3<T>,
}

impl<T: Scalar> Quaternion<T> {
    /// Identity: the quaternion (1, 0, 0, 0).
    #[inline]
    pub fn identity() -> Self {
        Self {
            w: T::one(),
            xyz: Vector3::zeros(),
        }
    }

    /// Reads (w, x, y, z) from the first four entries of a slice.
    ///
    /// # Panics
    /// If the slice is shorter than 4.
    #[inline(always)]
    pub fn from_slice(q: &[T]) -> Self {
        Self {
            w: q[0],
            xyz: Vector3::new(q[1], q[2], q[3]),
        }
    }

    /// Writes (w, x, y, z) to the first four entries of a slice.
    ///
    /// # Panics
    /// If the slice is shorter than 4.
    #[inline(always)]
    pub fn write_to(&self, out: &mut [T]) {
        out[..4].copy_from_slice(&[self.w, self.xyz.x, self.xyz.y, self.xyz.z]);
    }

    /// The rotation by |φ| radians about φ / |φ|:  exp(φ) = (cos ½|φ|, ½φ sinc ½|φ|).
    ///
    /// Smooth everywhere, exact at 0.
    #[inline(always)]
    pub fn exp(phi: &Vector3<T>) -> Self {
        let half = phi * T::constant(0.5);
        let (cos, sinc) = cos_sinc(dot(&half, &half));
        Self {
            w: cos,
            xyz: half * sinc,
        }
    }

    /// The rotation vector φ with exp(φ) = ±self and |φ| ≤ π.
    ///
    /// Smooth except at |φ| = π, where the rotation vector jumps; there the derivative is the one-sided limit.
    pub fn log(&self) -> Vector3<T> {
        // The same rotation with w ≥ 0, so that the angle is at most π.
        let sign = self.w.select_lt(T::zero(), T::constant(-1.0), T::one());
        let (w, v) = (self.w * sign, self.xyz * sign);
        v * (arc_over_sine(dot(&v, &v), w) * 2.0)
    }

    /// Conjugate (w, −x, −y, −z), the inverse rotation of a unit quaternion.
    #[inline(always)]
    pub fn conjugate(&self) -> Self {
        Self {
            w: self.w,
            xyz: -self.xyz,
        }
    }

    /// Square of the norm, w² + x² + y² + z².
    #[inline(always)]
    pub(crate) fn norm_squared(&self) -> T {
        self.w * self.w + dot(&self.xyz, &self.xyz)
    }

    /// Divides by the norm: the unit quaternion of the same direction. Zero gives numbers that are not finite.
    pub(crate) fn normalized(&self) -> Self {
        let scale = T::one() / self.norm_squared().sqrt();
        Self {
            w: self.w * scale,
            xyz: self.xyz * scale,
        }
    }

    /// The quaternion of a rotation matrix, with w ≥ 0.
    ///
    /// Each row of 4 q qᵀ is a multiple of q; the one with the largest diagonal entry is normalised. So the result is also exact near rotations by π.
    ///
    /// # References
    /// [Shepperd 1978].
    pub fn from_matrix(R_AB: &Matrix3<T>) -> Self {
        let at = |i, j| R_AB[(i, j)];
        let diagonal = |x: f64, y: f64, z: f64| at(0, 0) * x + at(1, 1) * y + at(2, 2) * z + 1.0;
        let [wx, wy, wz] = [(2, 1), (0, 2), (1, 0)].map_each(|(i, j)| at(i, j) - at(j, i));
        let [yz, zx, xy] = [(2, 1), (0, 2), (1, 0)].map_each(|(i, j)| at(i, j) + at(j, i));
        let [ww, xx] = [diagonal(1.0, 1.0, 1.0), diagonal(1.0, -1.0, -1.0)];
        let [yy, zz] = [diagonal(-1.0, 1.0, -1.0), diagonal(-1.0, -1.0, 1.0)];
        let candidates = [
            [xx, wx, xx, xy, zx],
            [yy, wy, xy, yy, yz],
            [zz, wz, zx, yz, zz],
        ];
        let mut best = [ww, ww, wx, wy, wz];
        for other in candidates {
            let largest = best[0];
            let pick = |k: usize| largest.select_lt(other[0], other[k], best[k]);
            best = [pick(0), pick(1), pick(2), pick(3), pick(4)];
        }
        let [_, w, x, y, z] = best;
        let sign = w.select_lt(T::zero(), T::constant(-1.0), T::one());
        let signed = [w, x, y, z].map_each(|x| x * sign);
        Self::from_slice(&signed).normalized()
    }

    /// The rotation matrix `R_AB`, columns = axes of B in A.
    ///
    /// Independent of the norm of the quaternion: a quaternion that is not exactly of unit norm still gives an exact rotation.
    #[inline(always)]
    pub fn to_matrix(&self) -> Matrix3<T> {
        // R = 1 + s (w [v] + [v]²), s = 2 / |q|²
        let s = T::constant(2.0) / self.norm_squared();
        let v = &self.xyz;
        let (x, y, z) = (v.x * s, v.y * s, v.z * s);
        let (wx, wy, wz) = (self.w * x, self.w * y, self.w * z);
        let (xx, xy, xz) = (v.x * x, v.x * y, v.x * z);
        let (yy, yz, zz) = (v.y * y, v.y * z, v.z * z);
        Matrix3::new(
            -(yy + zz) + 1.0,
            xy - wz,
            xz + wy,
            xy + wz,
            -(xx + zz) + 1.0,
            yz - wx,
            xz - wy,
            yz + wx,
            -(xx + yy) + 1.0,
        )
    }
}

/// log(`R_WA`ᵀ `R_WB`), the rotation vector (rad) from A to B, in the axes of A; at half a revolution either of two opposite
/// ones.
pub(crate) fn rotation_vector<P: Scalar, T: Over<P>>(
    R_WA: &Matrix3<P>,
    R_WB: &Matrix3<T>,
) -> Vector3<T> {
    let [x, y, z] = columns(R_WB).map_each(|axis| rotate_back(R_WA, &axis));
    Quaternion::from_matrix(&from_columns(&x, &y, &z)).log()
}

impl<T: Scalar> Mul for Quaternion<T> {
    type Output = Self;

    /// Composition of rotations: `q_AC = q_AB * q_BC`.
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self {
            w: self.w * other.w - dot(&self.xyz, &other.xyz),
            xyz: other.xyz * self.w + self.xyz * other.w + cross(&self.xyz, &other.xyz),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{OTHER_ALGORITHM, ROUNDING, SAME_ALGEBRA};
    use approx::assert_relative_eq;
    use num_dual::DualSVec64;
    use std::f64::consts::PI;

    type D = DualSVec64<3>;

    fn seeded(phi: &Vector3<f64>) -> Vector3<D> {
        let mut out = Vector3::new(D::from(phi.x), D::from(phi.y), D::from(phi.z));
        for k in 0..3 {
            out[k] = out[k].derivative(k);
        }
        out
    }

    fn axis() -> Vector3<f64> {
        Vector3::new(0.36, -0.48, 0.8)
    }

    /// 2 is exactly the angle at which series and closed form meet.
    const ANGLES: [f64; 10] = [0.0, 1e-12, 1e-9, 1e-4, 0.2, 0.4, 1.0, 2.0, 3.0, PI - 1e-9];

    #[test]
    fn exp_equals_axis_angle_closed_form() {
        for angle in ANGLES {
            let q = Quaternion::exp(&(axis() * angle));
            assert_relative_eq!(
                q.w,
                (angle / 2.0).cos(),
                epsilon = 4e-16,
                max_relative = ROUNDING
            );
            assert_relative_eq!(
                q.xyz,
                axis() * (angle / 2.0).sin(),
                epsilon = 1e-16,
                max_relative = 10.0 * ROUNDING
            );
        }
    }

    #[test]
    fn log_inverts_exp_to_rounding() {
        for angle in ANGLES {
            let phi = axis() * angle;
            assert_relative_eq!(
                Quaternion::exp(&phi).log(),
                phi,
                epsilon = 1e-300,
                max_relative = 4e-15
            );
        }
    }

    #[test]
    fn log_of_the_opposite_quaternion_is_the_same_rotation_vector() {
        let q = Quaternion::exp(&(axis() * 0.7));
        let opposite = Quaternion {
            w: -q.w,
            xyz: -q.xyz,
        };
        assert_relative_eq!(q.log(), opposite.log(), epsilon = 1e-16);
    }

    // d/dφ log(exp(φ)) = 1, at 0, next to it, and next to π.
    #[test]
    fn derivative_of_log_of_exp_is_the_identity() {
        for angle in ANGLES {
            let phi = Quaternion::exp(&seeded(&(axis() * angle))).log();
            for i in 0..3 {
                let row = phi[i].eps.0.unwrap();
                for k in 0..3 {
                    let expected = if i == k { 1.0 } else { 0.0 };
                    assert!(
                        (row[k] - expected).abs() < OTHER_ALGORITHM,
                        "angle {angle}: entry ({i}, {k}) is {}",
                        row[k]
                    );
                }
            }
        }
    }

    // At a half turn the rotation vector jumps; the derivative taken from one side is finite.
    #[test]
    fn log_at_half_turn_has_finite_value_and_derivative() {
        let half_turn = Quaternion {
            w: D::from(0.0),
            xyz: seeded(&Vector3::new(0.0, 0.0, 1.0)),
        };
        let phi = half_turn.log();
        assert_relative_eq!(phi.z.re, PI, epsilon = ROUNDING);
        assert!(
            phi.iter()
                .all(|p| p.eps.0.is_none_or(|e| e.iter().all(|x| x.is_finite())))
        );
    }

    #[test]
    fn matrix_of_product_equals_product_of_matrices() {
        let a = Quaternion::exp(&Vector3::new(0.3, -1.2, 2.0));
        let b = Quaternion::exp(&Vector3::new(-2.0, 0.1, 0.4));
        assert_relative_eq!(
            (a * b).to_matrix(),
            a.to_matrix() * b.to_matrix(),
            epsilon = ROUNDING
        );
        assert_relative_eq!(
            a.to_matrix() * a.conjugate().to_matrix(),
            Matrix3::identity(),
            epsilon = ROUNDING
        );
    }

    #[test]
    fn scaled_quaternion_gives_the_same_matrix() {
        let a = Quaternion::exp(&Vector3::new(0.3, -1.2, 2.0));
        let scaled = Quaternion {
            w: a.w * 3.0,
            xyz: a.xyz * 3.0,
        };
        assert_relative_eq!(scaled.to_matrix(), a.to_matrix(), epsilon = ROUNDING);
    }

    #[test]
    fn quaternion_of_matrix_gives_back_the_matrix() {
        for phi in [
            Vector3::zeros(),
            Vector3::new(PI, 0.0, 0.0),
            Vector3::new(1.0, -2.0, 0.5),
        ] {
            let matrix = Quaternion::exp(&phi).to_matrix();
            assert_relative_eq!(
                Quaternion::from_matrix(&matrix).to_matrix(),
                matrix,
                epsilon = ROUNDING
            );
        }
    }

    // Every candidate has its turn: rotations by small angles, and by half a revolution about every axis.
    #[test]
    fn quaternion_of_a_matrix_gives_the_matrix_and_its_derivatives() {
        let small = [vector(0.0, 0.0, 0.0), axis() * 0.3];
        let large = [
            vector(3.1, 0.2, 0.1),
            vector(0.1, -3.1, 0.2),
            vector(0.1, 0.2, 3.1),
        ];
        for phi in small.into_iter().chain(large) {
            let q = Quaternion::exp(&seeded(&phi));
            let back = Quaternion::from_matrix(&q.to_matrix()).log();
            for k in 0..3 {
                assert!(
                    (back[k].re - phi[k]).abs() < 10.0 * ROUNDING,
                    "{phi}: {}",
                    back[k].re
                );
                for l in 0..3 {
                    let expected = f64::from(u8::from(k == l));
                    let slope = back[k].eps.0.unwrap()[l];
                    assert!((slope - expected).abs() < SAME_ALGEBRA, "{phi}: {slope}");
                }
            }
        }
        let half = Matrix3::from_diagonal(&vector(-1.0, 1.0, -1.0));
        assert_eq!(Quaternion::from_matrix(&half).log().y.abs(), PI);
    }

    #[test]
    fn rotation_vector_from_one_rotation_to_another_leads_there() {
        let near = vector(0.4, -1.1, 0.3);
        for (from, to) in [
            (near, near),
            (near, vector(0.5, -1.0, 0.3)),
            (near, vector(-2.0, 0.3, 0.9)),
        ] {
            let [R_WA, R_WB] = [from, to].map(nalgebra::Rotation3::from_scaled_axis);
            let expected = (R_WA.inverse() * R_WB).scaled_axis();
            let turn = rotation_vector(R_WA.matrix(), R_WB.matrix());
            assert_relative_eq!(turn, expected, epsilon = 10.0 * ROUNDING);
        }
    }

    fn vector(x: f64, y: f64, z: f64) -> Vector3<f64> {
        Vector3::new(x, y, z)
    }
}
