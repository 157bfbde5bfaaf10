//! The map from the points of a shape to those of the same shape with other sizes.
//!
//! In the axes of a shape, a point moves by a factor along each: x, y, z of a box or mesh, radius and length of a cylinder, the radius of a sphere along
//! all. Of a capsule, z moves by the factor of the length as far as the cylinder reaches, and beyond by that of the radius, so that its ends stay half
//! spheres. All that is fixed to the link moves along; its origin, on the joint that carries it, stays.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix4, Vector3};

use crate::model::Geometry;
use crate::model::solids::capsule_volume;
use crate::scalar::{MapEach, Scalar};
use crate::spatial::linear::{rotate, rotate_back};
use crate::spatial::{Inertia, Transform};

/// The map of a link.
#[derive(Clone, Debug)]
pub(crate) struct Stretch<T> {
    /// Pose of the shape in the link, before.
    X_LG: Transform<f64>,
    /// Factors along the axes of the shape.
    factors: [T; 3],
    capsule: Option<Capsule<T>>,
    /// Factor of balls.
    ball: T,
}

/// Sizes of a capsule.
#[derive(Clone, Copy, Debug)]
struct Capsule<T> {
    before: [f64; 2],
    after: [T; 2],
}

impl<T: Scalar> Stretch<T> {
    /// * `ratios` – ratio of each size to its original value, in the order of [`dimensions_of`](super::dimension::dimensions_of)
    pub(super) fn new(X_LG: Transform<f64>, shape: &Geometry, ratios: &[T]) -> Self {
        let (factors, capsule) = match *shape {
            Geometry::Box { .. } | Geometry::Ellipsoid { .. } | Geometry::Mesh { .. } => {
                ([ratios[0], ratios[1], ratios[2]], None)
            }
            Geometry::Cylinder { .. } => ([ratios[0], ratios[0], ratios[1]], None),
            Geometry::Capsule { radius, length } => {
                let after = [ratios[0] * radius, ratios[1] * length];
                let before = [radius, length];
                let capsule = Capsule { before, after };
                ([ratios[0], ratios[0], ratios[1]], Some(capsule))
            }
            Geometry::Sphere { .. } => ([ratios[0]; 3], None),
        };
        let ball = match shape {
            Geometry::Box { .. } | Geometry::Ellipsoid { .. } | Geometry::Mesh { .. } => {
                cube_root(product(&factors))
            }
            _ => ratios[0],
        };
        Self {
            X_LG,
            factors,
            capsule,
            ball,
        }
    }

    /// Displacement of a point, both in the link, m; zero for the origin of the link.
    pub(crate) fn displacement(&self, p_L: &Vector3<f64>) -> Vector3<T> {
        let X_GL = self.X_LG.inverse();
        let moved = self.displacement_in_shape(&X_GL.point(p_L))
            - self.displacement_in_shape(&X_GL.translation);
        rotate(&self.X_LG.rotation, &moved)
    }

    fn displacement_in_shape(&self, p_G: &Vector3<f64>) -> Vector3<T> {
        let [x, y, z] = self.factors.map_each(|factor| factor - 1.0);
        let reach = self.capsule.map(|capsule| 0.5 * capsule.before[1]);
        let inside = reach.map_or(p_G.z, |reach| p_G.z.clamp(-reach, reach));
        Vector3::new(x * p_G.x, y * p_G.y, z * inside + x * (p_G.z - inside))
    }

    /// Factor of a length along a unit vector in the link:  |S a|.
    pub(crate) fn along(&self, axis_L: &Vector3<f64>) -> T {
        let a = rotate_back(&self.X_LG.rotation, axis_L);
        let squares = (0..3).map(|k| {
            let part = self.factors[k] * a[k];
            part * part
        });
        squares.fold(T::zero(), |sum, x| sum + x).sqrt()
    }

    /// Factor of the radius of a shape that is round about a unit vector in the link: the mean of those of two perpendicular directions.
    pub(crate) fn across(&self, axis_L: &Vector3<f64>) -> T {
        let a = rotate_back(&self.X_LG.rotation, axis_L);
        // The axis of the shape that is least along it.
        let mut other = Vector3::zeros();
        other[a.iamin()] = 1.0;
        let first = a.cross(&other).normalize();
        let second = a.cross(&first);
        let [first, second] =
            [first, second].map_each(|d| self.along(&rotate(&self.X_LG.rotation, &d)));
        (first * second).sqrt()
    }

    /// Factor of the radius of a ball: that of the radius where the shape is round, else the cube root of that of the volume.
    pub(crate) fn ball(&self) -> T {
        self.ball
    }

    /// Inertia in the link afterwards, from that of the same link in the frame of the shape before: every particle moves with its point of the shape,
    /// and keeps its density up to a factor.
    ///
    /// * `solid` – share of the inertia that is a homogeneous solid of the shape; needed for capsules
    pub(super) fn inertia(
        &self,
        before_G: &Inertia<f64>,
        solid: &Inertia<f64>,
        density: T,
    ) -> Inertia<T> {
        let p_LG = &self.X_LG.translation;
        let X_LG = Transform::new(
            self.X_LG.rotation.map(T::constant),
            p_LG.map(T::constant) + self.displacement(p_LG),
        );
        let after_G = match self.capsule {
            None => pushed(before_G, &self.factors, density),
            Some(capsule) => {
                let rest = *before_G + solid.scaled(-1.0);
                let factors = [self.factors[0], self.factors[1], capsule.reach()];
                pushed(&rest, &factors, density) + capsule.solid(solid.mass, density)
            }
        };
        X_LG.inertia(&after_G)
    }
}

impl<T: Scalar> Capsule<T> {
    /// Factor of the whole length.
    fn reach(&self) -> T {
        let [[r, l], [radius, length]] = [self.before.map_each(T::constant), self.after];
        (length + radius * 2.0) / (l + r * 2.0)
    }

    /// The homogeneous solid afterwards.
    ///
    /// * `mass` – its mass before, kg
    fn solid(&self, mass: f64, density: T) -> Inertia<T> {
        let ([r, l], [radius, length]) = (self.before, self.after);
        let volumes = capsule_volume(radius, length) * (1.0 / capsule_volume(r, l));
        Inertia::solid_capsule(volumes * density * mass, radius, length)
    }
}

/// Inertia of a body whose particles move by a factor along each axis from the origin:  Σ' = ρ det(S) S Σ S,  h' = ρ det(S) S h,  m' = ρ det(S) m.
pub(super) fn pushed<T: Scalar>(
    inertia: &Inertia<f64>,
    factors: &[T; 3],
    density: T,
) -> Inertia<T> {
    let mass = product(factors) * density;
    let [x, y, z] = *factors;
    let s = [x, y, z, T::one()];
    let pseudo = inertia.to_pseudo_inertia();
    let pseudo = Matrix4::from_fn(|i, j| s[i] * s[j] * mass * pseudo[(i, j)]);
    Inertia::from_pseudo_inertia(&pseudo)
}

fn product<T: Scalar>([x, y, z]: &[T; 3]) -> T {
    *x * *y * *z
}

fn cube_root<T: Scalar>(x: T) -> T {
    (x.ln() * (1.0 / 3.0)).exp()
}
