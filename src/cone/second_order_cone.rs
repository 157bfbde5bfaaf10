//! The cone  z₀ ≥ ‖(z₁, z₂)‖, for pairs of a point inside it and one inside its dual, which is the same cone.

use super::jacobian::Square;
use crate::scalar::{MapEach, Scalar};

/// Two points inside the cone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<T = f64> {
    pub(super) z: [T; 3],
    pub(super) w: [T; 3],
}

impl<T: Scalar> Pair<T> {
    /// zᵀ w
    pub(super) fn product(&self) -> T {
        self.z[0] * self.w[0] + self.z[1] * self.w[1] + self.z[2] * self.w[2]
    }

    /// κ z⁻¹ − w
    pub(super) fn target(&self, kappa: T) -> [T; 3] {
        let factor = kappa / determinant(&self.z);
        [
            factor * self.z[0] - self.w[0],
            -factor * self.z[1] - self.w[1],
            -factor * self.z[2] - self.w[2],
        ]
    }

    /// Largest fraction of their steps that both points can go before one is on the surface.
    pub(super) fn room(&self, step: &Self) -> T {
        room(&self.z, &step.z).min(room(&self.w, &step.w))
    }
}

/// z₀² − z₁² − z₂², of which nothing is lost near the surface.
fn determinant<T: Scalar>(z: &[T; 3]) -> T {
    let (zero, square) = (T::zero(), z[1] * z[1] + z[2] * z[2]);
    // Where the root has no derivative, none is needed.
    let root = zero.select_lt(square, square, T::one()).sqrt();
    let radius = zero.select_lt(square, root, zero);
    // A point that rounding has put on the surface is a rounding inside.
    (z[0] - radius).max(z[0] * f64::EPSILON) * (z[0] + radius)
}

/// Nesterov and Todd's symmetric matrix S with  S z = w,  S² as smooth in both:
/// S = √(det w / det z) (2 u uᵀ − J),  u = (J z̃ + w̃) / ‖…‖  with z̃, w̃ of determinant 1,  J = diag(1, −1, −1).
pub(super) fn scaling<T: Scalar>(pair: &Pair<T>) -> Square<T> {
    let (dz, dw) = (determinant(&pair.z).sqrt(), determinant(&pair.w).sqrt());
    let z = pair.z.map_each(|z| z / dz);
    let w = pair.w.map_each(|w| w / dw);
    let product = z[0] * w[0] + z[1] * w[1] + z[2] * w[2];
    let length = ((product + 1.0) * 2.0).sqrt();
    let u = [
        (z[0] + w[0]) / length,
        (w[1] - z[1]) / length,
        (w[2] - z[2]) / length,
    ];
    let ratio = dw / dz;
    let mut s = [[T::zero(); 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            s[i][j] = u[i] * u[j] * ratio * 2.0;
        }
        s[i][i] += if i == 0 { -ratio } else { ratio };
    }
    s
}

/// The smallest t > 0 where z + t d is on the surface:  a t² + 2 b t + c = 0; infinite where there is none.
fn room<T: Scalar>(z: &[T; 3], d: &[T; 3]) -> T {
    let (zero, far) = (T::zero(), T::constant(f64::INFINITY));
    let a = d[0] * d[0] - d[1] * d[1] - d[2] * d[2];
    let b = z[0] * d[0] - z[1] * d[1] - z[2] * d[2];
    let c = determinant(z);
    let discriminant = b * b - a * c;
    let below = discriminant.max(zero).sqrt() - b;
    let to_surface = c / zero.select_lt(below, below, T::one());
    let room = zero.select_lt(below, to_surface, far);
    discriminant.select_lt(zero, far, room)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cone::newton::product;

    const PAIR: Pair = Pair {
        z: [2.0, 0.5, -1.2],
        w: [1.0, -0.3, 0.9],
    };

    // S z = w, and S is symmetric.
    #[test]
    fn scaling_maps_one_point_to_the_other() {
        let s = scaling(&PAIR);
        for (found, expected) in product(&s, PAIR.z).iter().zip(PAIR.w) {
            assert!((found - expected).abs() < 1e-14, "{s:?}");
        }
        for i in 0..3 {
            for j in 0..i {
                assert_eq!(s[i][j], s[j][i]);
            }
        }
    }

    // z ∘ w = κ e has  w = κ z⁻¹  with the product  zᵀ w = κ: the target is zero there.
    #[test]
    fn target_is_zero_on_the_central_path() {
        let [a, b, c] = PAIR.z;
        let (kappa, determinant) = (0.3, a * a - b * b - c * c);
        let inverse = [a, -b, -c].map(|x| kappa * x / determinant);
        let on_path = Pair {
            z: PAIR.z,
            w: inverse,
        };
        assert!(on_path.target(kappa).iter().all(|x| x.abs() < 1e-15));
        assert!((on_path.product() - kappa).abs() < 1e-15);
    }

    // From the axis straight to the surface, and into the cone for ever.
    #[test]
    fn room_ends_on_the_surface() {
        let z = [2.0, 0.0, 0.0];
        assert!((room(&z, &[0.0, 1.0, 0.0]) - 2.0).abs() < 1e-15);
        assert!((room(&z, &[-1.0, 0.6, 0.8]) - 1.0).abs() < 1e-15);
        assert_eq!(room(&z, &[1.0, 0.6, 0.0]), f64::INFINITY);
    }
}
