//! A capsule against a box: at a face up to two points, elsewhere one.

use nalgebra::Vector3;

use super::cuboid::{Cuboid, is_largest};
use super::pack::{Candidate, packed};
use super::plane::deepest;
use super::point_box::NearPoint;
use super::round::{Round, crossing};
use super::when::{Nearest, When};
use super::{EQUAL, FAR, PARALLEL, line, nearest as nearest_of_features, vertex};
use crate::collision::feature::Witness;
use crate::scalar::{MapEach, Scalar, from_each};
use crate::spatial::linear::{cross, dot};

/// A capsule, whose centre is at the origin of the lengths, and a box.
struct Pair<'a, T> {
    capsule: &'a Round<T>,
    cuboid: &'a Cuboid<T>,
    /// From the centre of the capsule to that of the box.
    apart: Vector3<T>,
    direction: Vector3<T>,
}

/// The widest gap across edges: of the line of the capsule with those of the box.
struct AcrossEdges<T> {
    gap: T,
    is: When<T>,
    point: Witness<T>,
}

/// The points of a capsule and a box.
pub(super) fn points<T: Scalar>(a: &Round<T>, b: &Cuboid<T>) -> Vec<Witness<T>> {
    let &[start, end] = a.ends() else {
        return Vec::new();
    };
    let own = Pair {
        capsule: a,
        cuboid: b,
        apart: b.center - (start + end) * T::constant(0.5),
        direction: end - start,
    };
    let (gap, all) = own.on_face([start, end]);
    let edges = own.across_edges();
    let nearest = own.nearest(&edges);
    let overlap = When::less(gap.max(edges.gap), T::zero());
    let free = nearest.distance.detached() + a.radius.detached();
    let beside = overlap.pick(edges.gap, free);
    let size = (b.size() + dot(&own.apart, &own.apart).sqrt()).detached();
    let is_face = When::less(beside - size * EQUAL, gap);
    let single = overlap.pick_point(&edges.point, &nearest);
    let is = is_face.not();
    let mut all: Vec<Candidate<T>> = all.into_iter().map(|own| own.and(is_face)).collect();
    all.insert(0, Candidate { is, point: single });
    packed(&all, 2)
}

impl<T: Scalar> Pair<'_, T> {
    /// The widest gap across a face, and the points there.
    fn on_face(&self, ends: [Vector3<T>; 2]) -> (T, Vec<Candidate<T>>) {
        let (b, radius) = (self.cuboid, self.capsule.radius);
        let gaps: [T; 3] = from_each(|k| {
            let [apart, u] = [&self.apart, &self.direction].map_each(|v| dot(&b.axes[k], v).abs());
            (apart - b.half[k] - u * 0.5).detached()
        });
        let face = b.face(&is_largest(&gaps), &-self.apart);
        let (far, other, near) = deepest(&ends, &-face.normal);
        let mut all = vec![face.corner(far, radius).or_if(near.not())];
        let other_end = [face.corner(other, radius)];
        let crossings = face.crossings(&far, &other, radius);
        let beside = other_end.into_iter().chain(crossings);
        all.extend(beside.map(|own| own.and(near)));
        (gaps[0].max(gaps[1]).max(gaps[2]), all)
    }

    /// The line of the capsule against the edge of the box across which the gap is widest.
    fn across_edges(&self) -> AcrossEdges<T> {
        let (b, u) = (self.cuboid, &self.direction);
        let mut gap = T::constant(-FAR);
        let mut edge = b.axes[0];
        for axis in &b.axes {
            let n = cross(u, axis);
            let square = dot(&n, &n).detached();
            let crosses = When::less(dot(u, u) * (PARALLEL * PARALLEL), square);
            let own = (dot(&n, &self.apart).abs() - b.reach(&n)).detached();
            let own = own / crosses.pick(square, T::one()).sqrt();
            let wider = crosses.and(When::less(gap, own));
            gap = wider.pick(own, gap);
            edge = wider.pick_vector(axis, &edge);
        }
        let n = cross(u, &edge);
        let toward = When::positive(dot(&n, &self.apart)).signed(&n);
        let edge = line(b.support(&-toward), edge, T::zero());
        let own = line(self.capsule.ends()[0], *u, self.capsule.radius);
        let (crosses, point) = crossing(&[own, edge], &self.apart);
        let on_capsule = self.capsule.is_beside(&point.points[0]);
        AcrossEdges {
            gap,
            is: crosses.and(on_capsule).and(self.is_on_box(&point)),
            point,
        }
    }

    /// Whether the point of the box lies on it: an edge has ends.
    fn is_on_box(&self, own: &Witness<T>) -> When<T> {
        let (b, from) = (self.cuboid, own.points[1] - self.cuboid.center);
        let inside = |k: usize| {
            let edge = b.half[k] * (1.0 + EQUAL) + f64::MIN_POSITIVE;
            When::less(dot(&b.axes[k], &from).abs(), edge)
        };
        inside(0).and(inside(1)).and(inside(2))
    }

    /// The nearest points of the line and its ends with the edges, corners and faces of the box, where they do not overlap.
    fn nearest(&self, edges: &AcrossEdges<T>) -> Witness<T> {
        let (a, b) = (self.capsule, self.cuboid);
        let mut best = Nearest(edges.is.only(&edges.point));
        for &end in a.ends() {
            let own = NearPoint::new(end, a.radius, b).nearest();
            best.offer(When::always(), &own);
        }
        let corner = vertex(self.corner_beside(), T::zero());
        let line = line(a.ends()[0], self.direction, a.radius);
        let own = nearest_of_features(&[line, corner]);
        best.offer(a.is_beside(&own.points[0]), &own);
        best.0
    }

    /// The corner of the box that is nearest to the line, of those beside the capsule.
    fn corner_beside(&self) -> Vector3<T> {
        let (a, b, u) = (self.capsule, self.cuboid, &self.direction);
        let mut best = (b.support(&-self.apart), T::constant(FAR));
        let signs = (0..8).map(|k: usize| [0, 1, 2].map(|axis| k >> axis & 1 == 0));
        for sides in signs {
            let steps = b.axes.iter().zip(b.half).zip(sides);
            let steps = steps.map(|((axis, half), side)| axis * if side { half } else { -half });
            let corner = steps.fold(b.center, |sum, step| sum + step);
            let across = cross(&(corner - a.ends()[0]), u);
            let square = dot(&across, &across).detached();
            let nearer = a.is_beside(&corner).and(When::less(square, best.1));
            best.0 = nearer.pick_vector(&corner, &best.0);
            best.1 = nearer.pick(square, best.1);
        }
        best.0
    }
}
