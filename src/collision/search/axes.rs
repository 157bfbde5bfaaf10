//! Directions across which the gap of simple shapes is widest where they overlap: those of faces, of pairs of edges, and of rims and sides of cylinders.
//!
//! The gap as a function of its unit normal has its maxima at few normals. For polytopes they are the normals of faces and the products of edges; a cylinder adds its
//! axis, the radial directions to vertices, and for each edge the normals of its rims across that edge. Where the widest of these gaps is negative, the shapes overlap
//! by it; else they are apart, perhaps farther. This is the theorem of separating axes, with cylinders.

use nalgebra::Vector3;

use super::difference::Difference;
use super::ellipse::normal_of_quarter;
use super::options::Choice;
use crate::collision::feature::Feature;
use crate::collision::shape::Shape;
use crate::collision::solid::Solid;
use crate::scalar::{MapEach, from_each};

/// Sine of the angle between directions below which their product has no direction.
const PARALLEL: f64 = 1e-9;
/// Part of the size by which gaps differ that are equal up to rounding.
const EQUAL: f64 = 1e-14;
/// Most directions of edges, and of faces, of a polytope: those of a box.
const MAX_DIRECTIONS: usize = 3;

/// A unit normal and the gap across it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) normal: Vector3<f64>,
    pub(super) gap: f64,
    parts: [Part; 2],
}

/// The part that a shape has in a normal.
#[derive(Clone, Copy, Debug)]
enum Part {
    /// The normal is that of the face along an axis of the shape.
    Face(usize),
    /// The feature that is farthest along the normal of another one.
    Farthest,
    /// The k-th edge, of a box one of those along the k-th axis.
    Edge(usize),
    Side,
    Rim,
}

impl Axis {
    /// The features, those of faces with them.
    pub(super) fn choices(&self, difference: &Difference<'_>) -> [Choice; 2] {
        let n = self.normal;
        [
            choice(&difference.a, self.parts[0], &n),
            choice(&difference.b, self.parts[1], &-n),
        ]
    }
}

/// The feature of a part that lies farthest along a direction.
fn choice(solid: &Solid<'_>, part: Part, n: &Vector3<f64>) -> Choice {
    let feature = match part {
        Part::Face(axis) => {
            let face = solid.face(axis, n);
            let feature = face.vertex();
            return Choice {
                feature,
                face: Some(face),
            };
        }
        Part::Farthest => solid.extreme_feature(n),
        Part::Side => Feature::Edge([0, 1]),
        Part::Rim => Feature::Rim(solid.support(n).vertex),
        Part::Edge(k) => Feature::Edge(solid.edge(k as u32, n)),
    };
    Choice {
        feature,
        face: None,
    }
}

/// The widest gap across the candidate directions, or one that is wider than `far` (m); `None` for shapes of other kinds, and where neither has a volume.
pub(super) fn widest(difference: &Difference<'_>, far: f64) -> Option<Axis> {
    let Difference { a, b, .. } = difference;
    if !(has_volume(a) || has_volume(b)) {
        return None;
    }
    let mut search = Search::new(difference, far);
    match (Polytope::new(a), Polytope::new(b)) {
        (Some(p), Some(q)) => search.try_polytopes(&p, &q),
        (Some(p), None) => search.try_cylinder(&Cylinder::new(b)?, &p, -1.0),
        (None, Some(q)) => search.try_cylinder(&Cylinder::new(a)?, &q, 1.0),
        _ => return None,
    }
    search.best
}

fn has_volume(solid: &Solid<'_>) -> bool {
    match solid.shape {
        Shape::Box { half_extents } => half_extents.iter().all(|&x| x > 0.0),
        Shape::Cylinder {
            radius,
            half_length,
        } => *radius > 0.0 && *half_length > 0.0,
        _ => false,
    }
}

/// A polytope of few faces.
struct Polytope<'a> {
    solid: &'a Solid<'a>,
    /// Directions of edges, of any length.
    edges: [Vector3<f64>; MAX_DIRECTIONS],
    n_edges: usize,
    /// Normals of faces, of any length; both signs are meant.
    normals: [Vector3<f64>; MAX_DIRECTIONS],
    n_normals: usize,
}

impl<'a> Polytope<'a> {
    fn new(solid: &'a Solid<'a>) -> Option<Self> {
        let axes: [Vector3<f64>; 3] = from_each(|k| solid.X.rotation.column(k).into_owned());
        let [x, y, z] = axes;
        let (edges, [n_edges, n_normals], normals) = match solid.shape {
            Shape::Sphere { .. } => (axes, [0, 0], axes),
            Shape::Capsule { .. } => ([z, x, y], [1, 0], axes),
            Shape::Box { .. } => (axes, [3, 3], axes),
            Shape::Triangle { .. } => {
                let [a, b, c] = [0, 1, 2].map_each(|k| solid.vertex(k));
                ([b - a, c - b, a - c], [3, 1], [(b - a).cross(&(c - a)); 3])
            }
            _ => return None,
        };
        Some(Self {
            solid,
            edges,
            n_edges,
            normals,
            n_normals,
        })
    }

    fn vertices(&self) -> impl Iterator<Item = Vector3<f64>> {
        let indices = 0..self.solid.shape.n_vertices();
        indices.map(|k| self.solid.vertex(k))
    }

    fn edges(&self) -> &[Vector3<f64>] {
        &self.edges[..self.n_edges]
    }

    fn normals(&self) -> &[Vector3<f64>] {
        &self.normals[..self.n_normals]
    }

    /// The vertices as seen along an edge: of a box, whose edges are parallel, one of each two.
    fn vertices_along(&self, edge: usize) -> impl Iterator<Item = Vector3<f64>> {
        let is_box = matches!(self.solid.shape, Shape::Box { .. });
        let indices = 0..self.solid.shape.n_vertices();
        let seen = indices.filter(move |k| !is_box || k >> edge & 1 == 0);
        seen.map(|k| self.solid.vertex(k))
    }
}

struct Cylinder {
    center: Vector3<f64>,
    axis: Vector3<f64>,
    /// A unit direction across the axis.
    across: Vector3<f64>,
    radius: f64,
    half_length: f64,
}

impl Cylinder {
    fn new(solid: &Solid<'_>) -> Option<Self> {
        match *solid.shape {
            Shape::Cylinder {
                radius,
                half_length,
            } => Some(Self {
                center: solid.X.translation,
                axis: solid.X.rotation.column(2).into_owned(),
                across: solid.X.rotation.column(0).into_owned(),
                radius,
                half_length,
            }),
            _ => None,
        }
    }
}

/// Parts of a cylinder and of another shape, in the order of the shapes.
fn ordered([cylinder, other]: [Part; 2], sign: f64) -> [Part; 2] {
    if sign > 0.0 {
        [cylinder, other]
    } else {
        [other, cylinder]
    }
}

/// The widest gap so far.
struct Search<'a> {
    difference: &'a Difference<'a>,
    /// Whether both shapes are the same from opposite sides, so that one sign of a normal is enough.
    are_symmetric: bool,
    apart: Vector3<f64>,
    /// A wider gap than this one ends the search.
    far: f64,
    best: Option<Axis>,
}

impl<'a> Search<'a> {
    fn new(difference: &'a Difference<'a>, far: f64) -> Self {
        let is_symmetric = |solid: &Solid<'_>| !matches!(solid.shape, Shape::Triangle { .. });
        let (a, b) = (&difference.a, &difference.b);
        Self {
            difference,
            are_symmetric: is_symmetric(a) && is_symmetric(b),
            apart: b.X.translation - a.X.translation,
            far,
            best: None,
        }
    }

    fn try_polytopes(&mut self, p: &Polytope<'_>, q: &Polytope<'_>) {
        use Part::{Edge, Face, Farthest};
        for (k, n) in p.normals().iter().enumerate() {
            self.try_both(n, [Face(k), Farthest]);
        }
        for (k, n) in q.normals().iter().enumerate() {
            self.try_both(n, [Farthest, Face(k)]);
        }
        if self.is_far() {
            return;
        }
        for (k, u) in p.edges().iter().enumerate() {
            for (l, v) in q.edges().iter().enumerate() {
                self.try_product(u, v, [Edge(k), Edge(l)]);
            }
        }
    }

    /// * `sign` – 1 where the cylinder is the first shape, else -1
    fn try_cylinder(&mut self, cylinder: &Cylinder, polytope: &Polytope<'_>, sign: f64) {
        let axis = &cylinder.axis;
        self.try_both(axis, ordered([Part::Face(2), Part::Farthest], sign));
        for (k, n) in polytope.normals().iter().enumerate() {
            self.try_both(n, ordered([Part::Farthest, Part::Face(k)], sign));
        }
        for (k, edge) in polytope.edges().iter().enumerate() {
            self.try_product(edge, axis, ordered([Part::Side, Part::Edge(k)], sign));
        }
        for vertex in polytope.vertices() {
            let apart = vertex - cylinder.center;
            // By products, which are across the axis however near to it the vertex is; on it all radial directions are as good.
            let radial = axis.cross(&apart.cross(axis));
            let n = radial.try_normalize(f64::MIN_POSITIVE);
            let n = n.unwrap_or(cylinder.across);
            self.offer(n * sign, ordered([Part::Side, Part::Farthest], sign));
        }
        if self.is_far() {
            return;
        }
        for k in 0..polytope.n_edges {
            self.try_rims(cylinder, polytope, k, sign);
        }
    }

    /// Normals of the rims across an edge: seen along it they are ellipses, and the edge is a point.
    fn try_rims(&mut self, cylinder: &Cylinder, polytope: &Polytope<'_>, edge: usize, sign: f64) {
        let Some(u) = polytope.edges[edge].try_normalize(f64::MIN_POSITIVE) else {
            return;
        };
        let product = u.cross(&cylinder.axis);
        let sine = product.norm();
        if sine <= PARALLEL {
            return;
        }
        let x = product / sine;
        let y = x.cross(&u);
        let semi_axes = [
            cylinder.radius,
            cylinder.radius * u.dot(&cylinder.axis).abs(),
        ];
        for vertex in polytope.vertices_along(edge) {
            let apart = vertex - cylinder.center;
            let [along_x, along_y] = [x.dot(&apart), y.dot(&apart)];
            for end in [1.0, -1.0] {
                let at = [along_x.abs(), end * along_y - cylinder.half_length * sine];
                let least = self.best.map_or(f64::NEG_INFINITY, |best| best.gap);
                let Some([c, s]) = normal_of_quarter(at, semi_axes, least) else {
                    continue;
                };
                let n = x * c.copysign(along_x) + y * (s * end);
                self.offer(n * sign, ordered([Part::Rim, Part::Edge(edge)], sign));
            }
        }
    }

    fn is_far(&self) -> bool {
        self.best.is_some_and(|best| best.gap > self.far)
    }

    fn try_product(&mut self, u: &Vector3<f64>, v: &Vector3<f64>, parts: [Part; 2]) {
        let product = u.cross(v);
        let square = product.norm_squared();
        if square > PARALLEL * PARALLEL * u.norm_squared() * v.norm_squared() {
            self.try_both(&product, parts);
        }
    }

    /// A direction of any length, and its opposite.
    fn try_both(&mut self, n: &Vector3<f64>, parts: [Part; 2]) {
        let Some(n) = n.try_normalize(f64::MIN_POSITIVE) else {
            return;
        };
        let is_forward = n.dot(&self.apart) >= 0.0;
        if is_forward || !self.are_symmetric {
            self.offer(n, parts);
        }
        if !(is_forward && self.are_symmetric) {
            self.offer(-n, parts);
        }
    }

    /// Keeps a unit normal if the gap across it is wider than all others.
    fn offer(&mut self, normal: Vector3<f64>, parts: [Part; 2]) {
        let gap = self.difference.gap(&normal);
        let least = EQUAL * self.difference.size;
        if self.best.is_none_or(|best| gap > best.gap + least) {
            self.best = Some(Axis { normal, gap, parts });
        }
    }
}
