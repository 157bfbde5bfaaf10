//! Distances of shapes with rounded edges and faces that bulge: smooth where nearest features switch.
//!
//! A polytope with vertices vₖ has the support function h(n) = max n · vₖ. Its soft maximum over a width w,
//!
//! > h_w(n) = w ln Σ exp(n · vₖ / w),  h ≤ h_w ≤ h + w ln K,
//!
//! is that of a smooth convex body around the polytope: near an edge or on a face, the vertices that are about equally far along n all count. The
//! support function √(‖Mᵀ n‖² + w²) of an ellipsoid or a disc takes the place of ‖Mᵀ n‖, at most w less; radii are exact. The distance of two such bodies is
//! max over n of `−h_A(n) − h_B(−n)`, as that of the shapes, and by at most the sum of both excesses smaller.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix2, Vector2, Vector3};

use super::feature::{PairFeature, Witness};
use super::field_pairs::{each_pair, is_field};
use super::guard::{normalized_or, plane_across};
use super::nearest::about_first;
use super::newton::{LEAST_STIFFNESS, STEPS, step_across};
use super::shape::Shape;
use super::solid::Solid;
use super::witness::witness;
use crate::scalar::{MapEach, Scalar};
use crate::spatial::Transform;
use crate::spatial::linear::{columns, dot, rotate, rotate_back, scale};

/// Widths beyond the nearest feature at which others count as nothing: e⁻⁴⁰ is below rounding.
pub(crate) const NOTHING: f64 = 40.0;
/// Most steps on values: one or two where the shapes are far apart, some ten where their bodies overlap.
const MOST_STEPS: usize = 60;
/// Longest step on values, rad.
const LONGEST: f64 = 0.5;
/// Step on values below which the solution is found, rad.
const SHORTEST: f64 = 1e-14;
/// Decrease of a gap that is rounding, relative to the sizes of the shapes.
const ROUNDED: f64 = 1e-15;

/// A shape with a soft maximum over its vertices, at a pose.
struct Rounded<'a, T> {
    shape: &'a Shape,
    X: &'a Transform<T>,
    /// w, m.
    width: f64,
}

/// The vertices that are about the farthest along a direction, in the frame of the shape.
struct Cluster<T> {
    /// Their mean, each with its share exp(n · v / w).
    mean: Vector3<T>,
    /// n · v of the farthest one, m, without derivatives.
    top: f64,
    /// Sum of exp((n · v − top) / w).
    sum: T,
}

/// Largest excess of a rounded shape over the shape, in widths.
pub(crate) fn excess(shape: &Shape) -> f64 {
    let count = f64::from(shape.n_vertices());
    match shape {
        Shape::HalfSpace | Shape::Sphere { .. } => 0.0,
        Shape::Ellipsoid { .. } => 1.0,
        Shape::Cylinder { .. } => 1.0 + count.ln(),
        _ => count.ln(),
    }
}

impl<T: Scalar> Rounded<'_, T> {
    /// Number of vertices over which the maximum is.
    fn count(&self) -> u32 {
        match self.shape {
            Shape::Ellipsoid { .. } => 1,
            shape => shape.n_vertices(),
        }
    }

    /// Semi-axes of the ellipsoid or disc about each vertex.
    fn semi_axes(&self) -> Option<Vector3<f64>> {
        match *self.shape {
            Shape::Ellipsoid { semi_axes } => Some(semi_axes.into()),
            Shape::Cylinder { radius, .. } => Some(Vector3::new(radius, radius, 0.0)),
            _ => None,
        }
    }

    /// Radius around the core.
    fn radius(&self) -> f64 {
        match *self.shape {
            Shape::Sphere { radius } | Shape::Capsule { radius, .. } => radius,
            _ => 0.0,
        }
    }

    /// Passes each vertex that counts along a direction in the frame of the shape, with exp((n · v − top) / w), to `each`; returns the top.
    fn each_vertex(&self, n: &Vector3<T>, mut each: impl FnMut(Vector3<T>, T)) -> f64 {
        let plain = n.map(|x| x.value(0));
        let along = |k: u32| plain.dot(&self.shape.vertex(k));
        let top = (0..self.count()).map(along).fold(f64::MIN, f64::max);
        for k in 0..self.count() {
            if top - along(k) <= NOTHING * self.width {
                let v = self.shape.vertex(k).map(T::constant);
                each(v, ((dot(n, &v) - top) / self.width).exp());
            }
        }
        top
    }

    fn cluster(&self, n: &Vector3<T>) -> Cluster<T> {
        let (mut sum, mut moment) = (T::zero(), Vector3::from_element(T::zero()));
        let top = self.each_vertex(n, |v, share| {
            sum += share;
            moment += scale(&v, share);
        });
        Cluster {
            mean: scale(&moment, T::one() / sum),
            top,
            sum,
        }
    }

    /// Excess of the soft maximum over the mean of the vertices that count, m.
    fn above(&self, n: &Vector3<T>, cluster: &Cluster<T>) -> T {
        cluster.sum.ln() * self.width + cluster.top - dot(n, &cluster.mean)
    }

    /// The ellipsoid about each vertex along n: M Mᵀ + w² 1, and its height √(‖Mᵀ n‖² + w²), m.
    fn bulge(&self, n: &Vector3<T>) -> Option<(Vector3<f64>, T)> {
        let squares = self.semi_axes()?.map(|a| a * a + self.width * self.width);
        let square = dot(n, &stretched(n, &squares));
        Some((squares, square.sqrt()))
    }

    /// The point of the body, without the radius, that lies farthest along a unit direction, in the world: `∇h_w(n)`.
    fn support(&self, n: &Vector3<T>) -> Vector3<T> {
        let n = rotate_back(&self.X.rotation, n);
        let cluster = self.cluster(&n);
        let mut point = cluster.mean + scale(&n, self.above(&n, &cluster));
        if let Some((squares, height)) = self.bulge(&n) {
            point += scale(&stretched(&n, &squares), T::one() / height);
        }
        self.X.point(&point)
    }

    /// The change of that point with the direction, along e across it: `∇²h_w(n) e`.
    fn curvature(&self, n: &Vector3<T>, e: &Vector3<T>) -> Vector3<T> {
        let [n, e] = [n, e].map_each(|x| rotate_back(&self.X.rotation, x));
        let cluster = self.cluster(&n);
        let mut moment = Vector3::from_element(T::zero());
        self.each_vertex(&n, |v, share| {
            let v = v - cluster.mean;
            moment += scale(&v, share * dot(&v, &e));
        });
        let spread = T::one() / (cluster.sum * self.width);
        let mut change = scale(&moment, spread) + scale(&e, self.above(&n, &cluster));
        if let Some((squares, height)) = self.bulge(&n) {
            let (inverse, wide) = (T::one() / height, stretched(&e, &squares));
            let p = scale(&stretched(&n, &squares), inverse);
            change += scale(&(wide - scale(&p, dot(&p, &e))), inverse);
        }
        rotate(&self.X.rotation, &change)
    }
}

/// A vector stretched along the axes.
fn stretched<T: Scalar>(v: &Vector3<T>, factors: &Vector3<f64>) -> Vector3<T> {
    v.zip_map(factors, |x, factor| x * factor)
}

/// Two rounded shapes.
struct Pair<'a, T>([Rounded<'a, T>; 2]);

impl<T: Scalar> Pair<'_, T> {
    /// From the supporting point of the first shape to that of the second.
    fn apart(&self, n: &Vector3<T>) -> Vector3<T> {
        let [a, b] = &self.0;
        b.support(&-n) - a.support(n)
    }

    /// `(∇²h_A + ∇²h_B + g 1) e`.
    fn curvature(&self, n: &Vector3<T>, e: &Vector3<T>, g: T) -> Vector3<T> {
        let [a, b] = &self.0;
        a.curvature(n, e) + b.curvature(&-n, e) + scale(e, g)
    }

    /// Distance and points along a unit normal.
    fn witness(&self, n: &Vector3<T>) -> Witness<T> {
        let [a, b] = &self.0;
        let point = |own: &Rounded<'_, T>, n: Vector3<T>| {
            own.support(&n) + scale(&n, T::constant(own.radius()))
        };
        let [p, q] = [point(a, *n), point(b, -n)];
        let distance = dot(n, &(q - p));
        // Of a plane the point across from that of the other shape.
        let foot = scale(n, distance);
        let points = match (a.shape, b.shape) {
            (Shape::HalfSpace, _) => [q - foot, q],
            (_, Shape::HalfSpace) => [p, p + foot],
            _ => [p, q],
        };
        Witness {
            distance,
            points,
            normal: *n,
        }
    }

    /// Newton steps over the scalar from the solution.
    fn refined(&self, seed: &Vector3<f64>) -> Vector3<T> {
        let mut n = seed.map(T::constant);
        for _ in 0..STEPS {
            let w = self.apart(&n);
            let g = dot(&n, &w);
            let curvature = |e: &Vector3<T>| self.curvature(&n, e, g);
            let step = step_across(&n, seed, &w, curvature, LEAST_STIFFNESS);
            n = normalized_or(&(n + step), T::zero(), &n);
        }
        n
    }
}

impl Pair<'_, f64> {
    /// The normal, from a seed: Newton's method for the widest gap, with shorter steps where a whole one would narrow it.
    fn widest(&self, seed: &Vector3<f64>) -> Vector3<f64> {
        let (mut n, mut w) = (*seed, self.apart(seed));
        let slack = ROUNDED * w.norm();
        for _ in 0..MOST_STEPS {
            let step = self.ascent(&n, &w);
            let gap = n.dot(&w) - slack;
            let found = (0..MOST_STEPS).find_map(|halvings| {
                let next = (n + step * 0.5_f64.powi(halvings as i32)).normalize();
                let apart = self.apart(&next);
                (next.dot(&apart) >= gap).then_some((next, apart))
            });
            let Some((next, apart)) = found else { break };
            (n, w) = (next, apart);
            if step.norm() <= SHORTEST {
                break;
            }
        }
        n
    }

    /// A step of Newton's method across n that widens the gap: where it is not concave, as if it were.
    fn ascent(&self, n: &Vector3<f64>, w: &Vector3<f64>) -> Vector3<f64> {
        let axes = plane_across(n);
        let columns = axes.map_each(|e| self.curvature(n, &e, n.dot(w)));
        let stiffness = Matrix2::from_fn(|i, j| axes[i].dot(&columns[j]));
        let eigen = stiffness.symmetric_eigen();
        let slope = Vector2::new(axes[0].dot(w), axes[1].dot(w));
        let least = LEAST_STIFFNESS * eigen.eigenvalues.amax().max(w.norm());
        let along = eigen.eigenvectors.tr_mul(&slope);
        let along = along.zip_map(&eigen.eigenvalues, |x, k| x / k.abs().max(least));
        let step = eigen.eigenvectors * along;
        let step = axes[0] * step.x + axes[1] * step.y;
        let length = step.norm();
        match length > LONGEST {
            true => step * (LONGEST / length),
            false if length.is_finite() => step,
            false => Vector3::zeros(),
        }
    }
}

/// Passes distance, points and normal of two rounded shapes to `each`: once, or of a [field](Shape::Field) once for each point of the other shape that is near.
///
/// * `near` – the nearest features of the shapes, and their distance and normal
/// * `plain` – poses of the shapes in the world on values, as in `X`
/// * `width` – w, m, above zero
pub(crate) fn each_rounded<T: Scalar>(
    near: &(PairFeature, Witness<f64>),
    [a, b]: [&Shape; 2],
    plain: &[Transform<f64>; 2],
    X: &[Transform<T>; 2],
    width: f64,
    mut each: impl FnMut(Witness<T>),
) {
    if is_field(a, b) {
        let [a_at, b_at] = [Solid::new(a, &plain[0]), Solid::new(b, &plain[1])];
        each_pair(&a_at, &b_at, &mut |pair, distance| {
            if distance - near.1.distance <= NOTHING * width {
                each(witness(&pair, a, &X[0], b, &X[1]));
            }
        });
        return;
    }
    let origin = X[0].translation;
    let (plain, X) = (about_first(&plain[0], &plain[1]), about_first(&X[0], &X[1]));
    let pair = Pair(rounded([a, b], &X, width));
    let normal = match (a, b) {
        (Shape::HalfSpace, _) => columns(&X[0].rotation)[2],
        (_, Shape::HalfSpace) => -columns(&X[1].rotation)[2],
        _ => pair.refined(&Pair(rounded([a, b], &plain, width)).widest(&near.1.normal)),
    };
    let found = pair.witness(&normal);
    let points = found.points.map_each(|point| point + origin);
    each(Witness { points, ..found });
}

fn rounded<'a, T>(
    shapes: [&'a Shape; 2],
    X: &'a [Transform<T>; 2],
    width: f64,
) -> [Rounded<'a, T>; 2] {
    let [a, b] = shapes;
    [
        Rounded {
            shape: a,
            X: &X[0],
            width,
        },
        Rounded {
            shape: b,
            X: &X[1],
            width,
        },
    ]
}
