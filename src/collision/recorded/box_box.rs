//! A box against a box: two edges, or a face with up to eight points. Only where they overlap; apart they have no point within reach.

use nalgebra::Vector3;

use super::cuboid::{Cuboid, Patch, is_largest};
use super::pack::{Candidate, distinct, packed};
use super::rectangle::Rectangle;
use super::round::crossing;
use super::when::When;
use super::{EQUAL, FAR, PARALLEL, line, swapped, vertex};
use crate::collision::clip::SLACK;
use crate::collision::feature::{Face, MAX_POINTS, NormalSource, Witness};
use crate::collision::witness::along;
use crate::scalar::{MapEach, Scalar, from_each};
use crate::spatial::linear::{cross, dot};

/// The points of two boxes.
pub(super) fn points<T: Scalar>(a: &Cuboid<T>, b: &Cuboid<T>) -> Vec<Witness<T>> {
    let apart = b.center - a.center;
    let faces = [Faces::new(a, b, &apart), Faces::new(b, a, &apart)];
    let edges = Edges::new(a, b, &apart);
    let size = a.size() + b.size();
    let rounding = (size + dot(&apart, &apart).sqrt()).detached() * EQUAL;
    let of_second = When::less(faces[0].gap + rounding, faces[1].gap);
    let widest = faces[0].gap.max(faces[1].gap);
    let at_edges = When::less(widest + rounding, edges.gap);
    let overlap = When::less(widest.max(edges.gap), T::zero());
    // The box on whose face the points lie, and the other one.
    let own = of_second.pick_box(b, a);
    let other = of_second.pick_box(a, b);
    let toward = of_second.signed(&-apart);
    let largest =
        [0, 1].map_each(|k| of_second.pick_condition(faces[1].largest[k], faces[0].largest[k]));
    let face = own.face(&largest, &toward);
    let mut all = on_face(&face, &other);
    distinct(&mut all, size);
    let is_face = at_edges.not().and(overlap);
    let mut found = vec![edges.point(a, b, &apart).and(at_edges).and(overlap)];
    // Points on a face are those of the other box with it.
    found.extend(all.into_iter().map(|own| Candidate {
        is: own.is.and(is_face),
        point: of_second.pick_point(&own.point, &swapped(own.point)),
    }));
    packed(&found, MAX_POINTS)
}

/// The widest gap across the faces of a box.
struct Faces<T> {
    gap: T,
    largest: [When<T>; 2],
}

impl<T: Scalar> Faces<T> {
    fn new(own: &Cuboid<T>, other: &Cuboid<T>, apart: &Vector3<T>) -> Self {
        let gaps: [T; 3] = from_each(|k| {
            let axis = &own.axes[k];
            (dot(axis, apart).abs() - own.half[k] - other.reach(axis)).detached()
        });
        Self {
            gap: gaps[0].max(gaps[1]).max(gaps[2]),
            largest: is_largest(&gaps),
        }
    }
}

/// The pair of edges across which the gap is widest.
struct Edges<T> {
    gap: T,
    along: [Vector3<T>; 2],
}

impl<T: Scalar> Edges<T> {
    fn new(a: &Cuboid<T>, b: &Cuboid<T>, apart: &Vector3<T>) -> Self {
        let mut best = Self {
            gap: T::constant(-FAR),
            along: [a.axes[0], b.axes[0]],
        };
        for u in &a.axes {
            for v in &b.axes {
                let n = cross(u, v);
                let square = dot(&n, &n).detached();
                let crosses = When::less(T::constant(PARALLEL * PARALLEL), square);
                let gap = (dot(&n, apart).abs() - a.reach(&n) - b.reach(&n)).detached();
                let gap = gap / crosses.pick(square, T::one()).sqrt();
                let wider = crosses.and(When::less(best.gap, gap));
                best.gap = wider.pick(gap, best.gap);
                best.along = [
                    wider.pick_vector(u, &best.along[0]),
                    wider.pick_vector(v, &best.along[1]),
                ];
            }
        }
        best
    }

    /// The edges that lie farthest towards the other box.
    fn point(&self, a: &Cuboid<T>, b: &Cuboid<T>, apart: &Vector3<T>) -> Candidate<T> {
        let [u, v] = self.along;
        let n = cross(&u, &v);
        let n = When::positive(dot(&n, apart)).signed(&n);
        let first = line(a.support(&n), u, T::zero());
        let second = line(b.support(&-n), v, T::zero());
        let (is, point) = crossing(&[first, second], apart);
        Candidate { is, point }
    }
}

/// The points of a box on a face of another one: its corners there, corners of the face on it, and crossings of sides.
fn on_face<T: Scalar>(face: &Rectangle<T>, other: &Cuboid<T>) -> Vec<Candidate<T>> {
    let patch = other.patch(&-face.normal);
    let polygon = Polygon::new(face, &patch);
    let zero = T::zero();
    let corners = patch.corners.iter().zip(patch.present);
    let corners = corners.map(|(&corner, is)| face.corner(corner, zero).and(is));
    let mut all: Vec<Candidate<T>> = corners.collect();
    let [_, second, third, fourth] = patch.present;
    all[0] = all[0].or_if(second.or(third).or(fourth).not());
    all.extend(face.corners().map_each(|corner| polygon.corner(&corner)));
    for (k, is) in polygon.sides.iter().enumerate() {
        let [from, to] = polygon.side(k);
        let crossings = face.crossings(from, to, zero);
        all.extend(crossings.map_each(|own| own.and(*is)));
    }
    all
}

/// The corners of a patch that are there; in place of each other one its neighbour, so that sides have no length.
struct Polygon<T> {
    corners: [Vector3<T>; 4],
    /// Whether a side is none of the others.
    sides: [When<T>; 4],
    /// Whether it has three corners or more.
    is_face: When<T>,
    /// Outward.
    normal: Vector3<T>,
    /// Of the face on which it lies, from where its corners are clockwise.
    seen: Vector3<T>,
}

impl<T: Scalar> Polygon<T> {
    fn new(face: &Rectangle<T>, patch: &Patch<T>) -> Self {
        let [p, q, r, s] = patch.corners;
        let [always, second, third, fourth] = patch.present;
        let turn = dot(&cross(&(q - p), &(s - p)), &face.normal);
        let q_or = second.pick_vector(&q, &p);
        let r_or = third.pick_vector(&r, &q_or);
        let s_or = fourth.pick_vector(&s, &p);
        let is_face = third.and(second.or(fourth)).or(second.and(fourth));
        Self {
            corners: [p, q_or, r_or, s_or],
            sides: [always, always, is_face, always],
            is_face,
            normal: patch.normal,
            seen: When::positive(turn).signed(&face.normal),
        }
    }

    fn side(&self, k: usize) -> [&Vector3<T>; 2] {
        [k, (k + 1) % 4].map_each(|k| &self.corners[k])
    }

    /// A corner of the face where it lies on the polygon, along the normal of that.
    fn corner(&self, corner: &Vector3<T>) -> Candidate<T> {
        let mut is = self.is_face;
        for k in 0..4 {
            let [from, to] = self.side(k);
            let u = to - from;
            let beyond = dot(&cross(&(corner - from), &u), &self.seen);
            let slack = dot(&u, &u) * SLACK + f64::MIN_POSITIVE;
            is = is.and(When::less(beyond, slack));
        }
        let placed = [self.corners[0], *corner].map_each(|at| vertex(at, T::zero()));
        let source = NormalSource::First(Face::Flat(0));
        let point = along(&placed, &self.normal, source);
        Candidate { is, point }
    }
}
