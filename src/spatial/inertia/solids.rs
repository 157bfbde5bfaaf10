//! Inertias of homogeneous solids, about their centres of mass.

use nalgebra::Vector3;

use super::Inertia;
use crate::scalar::{MapEach, Scalar};
use crate::spatial::Symmetric3;

/// Distance of a half ball's centre of mass from its flat face, in r; also that of the cross term 2 (½ l) (⅜ r) = ⅜ l
/// r.
const HALF_BALL: f64 = 3.0 / 8.0;
/// Moment of a ball about a diameter, in m r².
const BALL: f64 = 2.0 / 5.0;
/// Moment of a rod about its middle, in m l².
const ROD: f64 = 1.0 / 12.0;

impl<P: Scalar> Inertia<P> {
    /// A solid box with full edge lengths `size`:  J = m/12 (y² + z², x² + z², x² + y²).
    pub(crate) fn solid_box(mass: P, size: [P; 3]) -> Self {
        let [x, y, z] = size.map_each(|length| length * length * mass * ROD);
        Self::centred(mass, [y + z, x + z, x + y])
    }

    /// A solid ball:  J = ⅖ m r².
    pub(crate) fn solid_sphere(mass: P, radius: P) -> Self {
        Self::centred(mass, [mass * radius * radius * BALL; 3])
    }

    /// A solid ellipsoid with the semi-axes a, b, c:  J = m/5 (b² + c², a² + c², a² + b²).
    pub(crate) fn solid_ellipsoid(mass: P, semi_axes: [P; 3]) -> Self {
        let [x, y, z] = semi_axes.map_each(|length| length * length * mass * (0.5 * BALL));
        Self::centred(mass, [y + z, x + z, x + y])
    }

    /// A solid cylinder about z of full length `length`:  Jₓ = m (3 r² + l²)/12,  `J_z` = ½ m r².
    pub(crate) fn solid_cylinder(mass: P, radius: P, length: P) -> Self {
        let axial = mass * radius * radius * 0.5;
        let across = axial * 0.5 + mass * length * length * ROD;
        Self::centred(mass, [across, across, axial])
    }

    /// A solid capsule: a cylinder about z of full length `length` with half balls at its ends.
    ///
    /// Cylinder and balls share the mass in proportion to their volumes, `m_c : m_b = l : 4/3 r`;
    /// Jₓ = Jₓ(cylinder) + `m_b` (⅖ r² + ¼ l² + ⅜ l r),  `J_z` = ½ `m_c` r² + ⅖ `m_b` r².
    ///
    /// # Limitations
    /// Not finite if radius and length are both zero.
    pub(crate) fn solid_capsule(mass: P, radius: P, length: P) -> Self {
        /// Volume of a ball per that of a cylinder of its radius and length.
        const BALL_TO_CYLINDER: f64 = 4.0 / 3.0;
        let (r2, l2) = (radius * radius, length * length);
        let cylinder = mass * length / (length + radius * BALL_TO_CYLINDER);
        let balls = mass - cylinder;
        let axial = cylinder * r2 * 0.5 + balls * r2 * BALL;
        let of_cylinder = cylinder * (r2 * 0.25 + l2 * ROD);
        let of_balls = balls * (r2 * BALL + l2 * 0.25 + length * radius * HALF_BALL);
        let across = of_cylinder + of_balls;
        Self::centred(mass, [across, across, axial])
    }

    fn centred(mass: P, [x, y, z]: [P; 3]) -> Self {
        Self {
            mass,
            first_moment: Vector3::zeros(),
            rotational: Symmetric3::diagonal(&Vector3::new(x, y, z)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::ROUNDING;
    use num_dual::Dual64;
    use std::f64::consts::PI;

    /// Cells along each edge of the cube that is summed over.
    const CELLS: usize = 160;
    /// Cells at the surface count whole or not at all: an error of the order of the cells' share there.
    const SUM: f64 = 2e-3;

    /// Mass and moments at density 1 of the points in ±`half` that are `inside`, by the midpoint rule.
    fn summed(half: [f64; 3], inside: impl Fn(&Vector3<f64>) -> bool) -> Inertia<f64> {
        let cell = half.map(|half| 2.0 * half / CELLS as f64);
        let at = |i: usize, k: usize| (i as f64 + 0.5) * cell[k] - half[k];
        let mut sum = Inertia::zero();
        for i in 0..CELLS {
            for j in 0..CELLS {
                for k in 0..CELLS {
                    let p = Vector3::new(at(i, 0), at(j, 1), at(k, 2));
                    if inside(&p) {
                        let mass = cell[0] * cell[1] * cell[2];
                        sum = sum + Inertia::from_com(mass, &p, &Symmetric3::zero());
                    }
                }
            }
        }
        sum
    }

    fn assert_equal(closed: &Inertia<f64>, summed: &Inertia<f64>, what: &str) {
        let error = (closed.to_matrix() - summed.to_matrix()).amax() / closed.to_matrix().amax();
        assert!(error < SUM, "{what}: {closed:?} against {summed:?}");
    }

    #[test]
    fn closed_forms_equal_sums_over_small_cells() {
        let (r, l) = (0.7_f64, 1.1_f64);
        let box_sum = summed([0.5, 0.6, 0.9], |_| true);
        assert_equal(&Inertia::solid_box(2.16, [1.0, 1.2, 1.8]), &box_sum, "box");
        let ball = 4.0 / 3.0 * PI * r.powi(3);
        let ball_sum = summed([r; 3], |p| p.norm() < r);
        assert_equal(&Inertia::solid_sphere(ball, r), &ball_sum, "ball");
        let ellipsoid_sum = summed([r, 1.1, 0.4], |p| {
            Vector3::new(p.x / r, p.y / 1.1, p.z / 0.4).norm() < 1.0
        });
        let ellipsoid = 4.0 / 3.0 * PI * r * 1.1 * 0.4;
        let closed = Inertia::solid_ellipsoid(ellipsoid, [r, 1.1, 0.4]);
        assert_equal(&closed, &ellipsoid_sum, "ellipsoid");
        let cylinder = PI * r * r * l;
        let cylinder_sum = summed([r, r, l / 2.0], |p| p.xy().norm() < r);
        let closed = Inertia::solid_cylinder(cylinder, r, l);
        assert_equal(&closed, &cylinder_sum, "cylinder");
        let capsule_sum = summed([r, r, r + l / 2.0], |p| {
            let on_axis = p.z.clamp(-l / 2.0, l / 2.0);
            (p - Vector3::z() * on_axis).norm() < r
        });
        let closed = Inertia::solid_capsule(ball + cylinder, r, l);
        assert_equal(&closed, &capsule_sum, "capsule");
    }

    // Textbook numbers: 12 kg box of 1 × 2 × 3 m, 5 kg ball of 1 m, 12 kg cylinder of 1 m and 2 m, 12 kg rod of 1 m.
    #[test]
    fn moments_equal_textbook_numbers() {
        let moments = |inertia: Inertia<f64>| {
            let j = inertia.rotational;
            [j.xx, j.yy, j.zz]
        };
        assert_eq!(
            moments(Inertia::solid_box(12.0, [1.0, 2.0, 3.0])),
            [13.0, 10.0, 5.0]
        );
        assert_eq!(moments(Inertia::solid_sphere(5.0, 1.0)), [2.0; 3]);
        assert_eq!(
            moments(Inertia::solid_cylinder(12.0, 1.0, 2.0)),
            [7.0, 7.0, 6.0]
        );
        assert_eq!(
            moments(Inertia::solid_cylinder(12.0, 0.0, 1.0)),
            [1.0, 1.0, 0.0]
        );
    }

    #[test]
    fn capsule_without_cylinder_equals_a_ball_and_thin_capsule_a_rod() {
        let (capsule, ball) = (
            Inertia::solid_capsule(5.0, 1.0, 0.0),
            Inertia::solid_sphere(5.0, 1.0),
        );
        assert_eq!(capsule, ball);
        let (capsule, rod) = (
            Inertia::solid_capsule(12.0, 0.0, 1.0),
            Inertia::solid_cylinder(12.0, 0.0, 1.0),
        );
        assert_eq!(capsule, rod);
    }

    // dJ/dr about the axis of a cylinder = m r.
    #[test]
    fn derivative_in_the_radius_equals_its_closed_form() {
        let of = |x: f64| Dual64::from(x);
        let inertia = Inertia::solid_cylinder(of(3.0), Dual64::new(0.5, 1.0), of(2.0));
        assert!((inertia.rotational.zz.eps - 1.5).abs() < ROUNDING);
    }
}
