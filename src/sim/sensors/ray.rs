//! Distances of rays to shapes, in closed form, over the scalar.

use std::sync::Arc;

use nalgebra::Vector3;

use super::mesh::{MeshFiles, MeshTree};
use crate::contact::ShapeWithoutPoints;
use crate::model::{BodyId, Geometry, Model, short_reference};
use crate::scalar::{MapEach, Scalar};
use crate::spatial::Transform;
use crate::spatial::linear::{dot, scale};

/// A shape that a ray can hit.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    /// The body that it is on; `None` is the world.
    pub(super) body: Option<BodyId>,
    /// Pose in the body.
    pub(super) placement: Transform<f64>,
    pub(super) solid: Solid,
}

/// A shape about its own frame, m.
#[derive(Clone, Debug)]
pub(super) enum Solid {
    /// A box by half its edges.
    Box([f64; 3]),
    Sphere(f64),
    /// An ellipsoid by its semi-axes.
    Ellipsoid([f64; 3]),
    /// A cylinder about z, with half its length.
    Cylinder {
        radius: f64,
        half: f64,
    },
    /// A cylinder about z with half spheres on its ends.
    Capsule {
        radius: f64,
        half: f64,
    },
    /// A mesh, with factors along its axes.
    Mesh {
        mesh: Arc<MeshTree>,
        factors: [f64; 3],
    },
}

impl Shape {
    /// The shapes for collision of all links; those that rays do not see are added to `missing`.
    pub(super) fn of_model(model: &Model, missing: &mut Vec<ShapeWithoutPoints>) -> Vec<Self> {
        let (mut out, mut meshes) = (Vec::new(), MeshFiles::default());
        for link in model.links() {
            let frame = &model.frames()[link.frame.0];
            for collision in &link.collisions {
                match Solid::new(&collision.geometry, &mut meshes) {
                    Ok(solid) => out.push(Self {
                        body: frame.body,
                        placement: frame.placement * collision.placement,
                        solid,
                    }),
                    Err(reason) => missing.push(ShapeWithoutPoints {
                        link: frame.name.clone(),
                        reason,
                    }),
                }
            }
        }
        out
    }
}

impl Solid {
    /// The shape of a geometry, or why there is none, as a sentence about it.
    fn new(geometry: &Geometry, meshes: &mut MeshFiles) -> Result<Self, String> {
        Ok(match geometry {
            Geometry::Box { size } => Self::Box(size.map_each(|x| 0.5 * x)),
            Geometry::Sphere { radius } => Self::Sphere(*radius),
            Geometry::Ellipsoid { size } => Self::Ellipsoid(size.map_each(|x| 0.5 * x)),
            Geometry::Cylinder { radius, length } => Self::Cylinder {
                radius: *radius,
                half: 0.5 * length,
            },
            Geometry::Capsule { radius, length } => Self::Capsule {
                radius: *radius,
                half: 0.5 * length,
            },
            mesh @ Geometry::Mesh { uri, scale, .. } => {
                let of_mesh =
                    |reason: String| format!("the mesh {} {reason}", short_reference(uri));
                Self::Mesh {
                    mesh: meshes.tree(mesh).map_err(of_mesh)?,
                    factors: *scale,
                }
            }
        })
    }
}

/// A slope below which a ray is parallel to a face, and hits it far away: its square would be lost beside 1.
pub(super) const PARALLEL: f64 = 1e-9;

/// A ray in the frame of a shape, and the nearest distance so far.
pub(super) struct LocalRay<T> {
    pub(super) origin: Vector3<T>,
    /// A unit vector.
    pub(super) direction: Vector3<T>,
    pub(super) nearest: T,
}

impl<T: Scalar> LocalRay<T> {
    /// The nearest distance at which the ray passes the surface of a shape.
    pub(super) fn hit(mut self, solid: &Solid) -> T {
        match *solid {
            Solid::Mesh { ref mesh, factors } => self.hit_mesh(mesh, factors),
            Solid::Box(half) => self.hit_box(half),
            Solid::Sphere(radius) => self.hit_sphere(0.0, radius, None),
            Solid::Ellipsoid(semi_axes) => self.hit_ellipsoid(semi_axes),
            Solid::Cylinder { radius, half } => {
                self.hit_side(radius, half);
                self.hit_lids(radius, half);
            }
            Solid::Capsule { radius, half } => {
                self.hit_side(radius, half);
                self.hit_sphere(half, radius, Some(1.0));
                self.hit_sphere(-half, radius, Some(-1.0));
            }
        }
        self.nearest
    }

    /// Takes a distance where it is ahead, nearer than others, and `inside`, a number that is not negative on the surface.
    fn offer(&mut self, t: T, inside: T) {
        let (zero, nearest) = (T::zero(), self.nearest);
        let t = inside.select_lt(zero, nearest, t);
        let t = t.select_lt(zero, nearest, t);
        self.nearest = t.select_lt(nearest, t, nearest);
    }

    /// The place at a distance.
    fn place(&self, t: T) -> Vector3<T> {
        self.origin + scale(&self.direction, t)
    }

    /// Distance to the plane in which a coordinate has a value.
    fn to_plane(&self, axis: usize, value: f64) -> T {
        let slope = self.direction[axis];
        let least = T::constant(PARALLEL);
        let steep = slope.abs().select_lt(least, least, slope);
        (-self.origin[axis] + value) / steep
    }

    fn hit_box(&mut self, half: [f64; 3]) {
        for axis in 0..3 {
            let [j, k] = [(axis + 1) % 3, (axis + 2) % 3];
            for side in [-half[axis], half[axis]] {
                let t = self.to_plane(axis, side);
                let at = self.place(t);
                let inside = (-at[j].abs() + half[j]).min(-at[k].abs() + half[k]);
                self.offer(t, inside);
            }
        }
    }

    /// A sphere about a point of z, or the half of it beyond that on a side.
    fn hit_sphere(&mut self, z: f64, radius: f64, side: Option<f64>) {
        let mut from = self.origin;
        from.z = from.z + (-z);
        let (b, c) = (
            dot(&from, &self.direction),
            dot(&from, &from) - radius * radius,
        );
        for t in roots(T::one(), b, c) {
            let beyond = |side: f64| (self.place(t.at).z + (-z)) * side;
            let inside = side.map_or(t.exists, |side| t.exists.min(beyond(side)));
            self.offer(t.at, inside);
        }
    }

    /// An ellipsoid, which is a unit sphere in lengths by its semi-axes.
    fn hit_ellipsoid(&mut self, semi_axes: [f64; 3]) {
        let relative = |v: &Vector3<T>| Vector3::from_fn(|k, _| v[k] * (1.0 / semi_axes[k]));
        let (o, d) = (relative(&self.origin), relative(&self.direction));
        for t in roots(dot(&d, &d), dot(&o, &d), dot(&o, &o) - 1.0) {
            self.offer(t.at, t.exists);
        }
    }

    /// The side of a cylinder about z.
    fn hit_side(&mut self, radius: f64, half: f64) {
        let (o, d) = (self.origin, self.direction);
        let a = d.x * d.x + d.y * d.y;
        let (b, c) = (
            o.x * d.x + o.y * d.y,
            o.x * o.x + o.y * o.y - radius * radius,
        );
        let least = T::constant(PARALLEL * PARALLEL);
        for t in roots(a.max(least), b, c) {
            let inside = t.exists.min(-self.place(t.at).z.abs() + half);
            self.offer(t.at, inside);
        }
    }

    /// The flat ends of a cylinder about z.
    fn hit_lids(&mut self, radius: f64, half: f64) {
        for end in [-half, half] {
            let t = self.to_plane(2, end);
            let at = self.place(t);
            let inside = -(at.x * at.x + at.y * at.y) + radius * radius;
            self.offer(t, inside);
        }
    }
}

/// A root, and a number that is negative where there is none.
struct Root<T> {
    at: T,
    exists: T,
}

/// The roots of  a t² + 2 b t + c = 0.
fn roots<T: Scalar>(a: T, b: T, c: T) -> [Root<T>; 2] {
    let discriminant = b * b - a * c;
    // A number to take the root of, where there is none.
    let least = T::constant(f64::MIN_POSITIVE);
    let root = discriminant.select_lt(least, T::one(), discriminant).sqrt();
    [-root, root].map(|root| Root {
        at: (root - b) / a,
        exists: discriminant,
    })
}
