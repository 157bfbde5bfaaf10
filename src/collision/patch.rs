//! The flat part of a shape that lies farthest along a direction: a point, an edge or a face, as a polygon.

use nalgebra::{Vector2, Vector3};

use super::corner::{Across, Corner, Ends};
use super::feature::{Face, Feature};
use super::shape::{RIM_VERTICES, Shape};
use super::solid::Solid;
use crate::scalar::MapEach;

/// Most corners of a polygon.
pub(super) const MAX_CORNERS: usize = RIM_VERTICES as usize;

/// A polygon, counter-clockwise as seen from where the direction points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    corners: [Corner; MAX_CORNERS],
    len: usize,
    pub(super) face: Option<Face>,
    /// Set if it is an end of a cylinder, of whose rim only some points are corners.
    disc: Option<Disc>,
}

/// A vertex near the farthest one, and its place across the direction.
#[derive(Clone, Copy, Debug, Default)]
struct Near {
    vertex: u32,
    at: Vector2<f64>,
}

/// A disc across a direction.
#[derive(Clone, Copy, Debug)]
struct Disc {
    center: Vector2<f64>,
    radius: f64,
}

impl Patch {
    /// The part of a shape that lies farthest along a unit direction, or would if it changed by an angle (rad).
    ///
    /// * `across` – axes of the polygon, across a normal that is near to the direction or opposite
    pub(super) fn new(solid: &Solid<'_>, n: &Vector3<f64>, angle: f64, across: &Across) -> Self {
        let nothing = Corner {
            feature: Feature::Surface,
            vertex: 0,
            point: Vector3::zeros(),
            at: Vector2::zeros(),
        };
        let mut own = Self {
            corners: [nothing; MAX_CORNERS],
            len: 0,
            face: None,
            disc: None,
        };
        match solid.shape {
            Shape::Cylinder { .. } => own.add_cylinder(solid, n, angle, across),
            Shape::HalfSpace => {}
            Shape::Ellipsoid { semi_axes } if semi_axes.iter().all(|&s| s > 0.0) => {
                own.push(Feature::Surface, 0, &solid.support(n).point, across);
            }
            _ => own.add_polytope(solid, n, angle, across),
        }
        own
    }

    pub(super) fn corners(&self) -> &[Corner] {
        &self.corners[..self.len]
    }

    /// The sides by their ends; that of an edge once.
    pub(super) fn sides(&self) -> impl Iterator<Item = Ends<'_>> {
        let n_sides = if self.len < 3 {
            self.len.saturating_sub(1)
        } else {
            self.len
        };
        (0..n_sides).map(|k| {
            let next = if k + 1 == self.len { 0 } else { k + 1 };
            [&self.corners[k], &self.corners[next]]
        })
    }

    /// Distance of a place from the polygon along the normal of a side, or from the disc, not positive inside; infinite for what is neither.
    pub(super) fn outside(&self, place: &Vector2<f64>) -> f64 {
        if let Some(Disc { center, radius }) = self.disc {
            return length(&(place - center)) - radius;
        }
        if self.len < 3 {
            return f64::INFINITY;
        }
        let mut outside = f64::NEG_INFINITY;
        for [a, b] in self.sides() {
            let u = b.at - a.at;
            outside = outside.max((place - a.at).perp(&u) / length(&u));
        }
        outside
    }

    fn push(&mut self, feature: Feature, vertex: u32, point: &Vector3<f64>, across: &Across) {
        if self.len < MAX_CORNERS {
            self.corners[self.len] = Corner {
                feature,
                vertex,
                point: *point,
                at: across.place(point),
            };
            self.len += 1;
        }
    }

    fn add_vertex(&mut self, solid: &Solid<'_>, vertex: u32, across: &Across) {
        self.push(
            Feature::Vertex(vertex),
            vertex,
            &solid.vertex(vertex),
            across,
        );
    }

    fn add_cylinder(&mut self, solid: &Solid<'_>, n: &Vector3<f64>, angle: f64, across: &Across) {
        let along = solid.X.rotation.column(2).dot(n);
        let end = u32::from(along > 0.0);
        if solid.tilt(2, n) <= angle {
            self.face = Some(Face::Cap(end));
            self.disc = Some(Disc {
                center: across.place(&solid.vertex(end)),
                radius: solid.rim_radius(),
            });
            (0..RIM_VERTICES).for_each(|k| self.add_vertex(solid, 2 + 2 * k + end, across));
            self.orient();
        } else if along.abs() <= angle {
            // The line of the side that is farthest.
            let aside = solid.support(n).point - solid.vertex(end);
            for end in 0..2 {
                self.push(Feature::Rim(end), end, &(solid.vertex(end) + aside), across);
            }
        } else {
            self.push(Feature::Rim(end), end, &solid.support(n).point, across);
        }
    }

    fn orient(&mut self) {
        let [a, b, c] = [0, 1, 2].map_each(|k| self.corners[k].at);
        if (b - a).perp(&(c - a)) < 0.0 {
            self.corners[..self.len].reverse();
        }
    }

    /// The vertices of a polytope that are near the farthest, wrapped as a gift is.
    fn add_polytope(&mut self, solid: &Solid<'_>, n: &Vector3<f64>, angle: f64, across: &Across) {
        let farthest = solid.support(n);
        let near = |vertex: u32, point: &Vector3<f64>, farthest: &Vector3<f64>| {
            let below = farthest - point;
            let is_near = below.dot(n) <= angle * below.dot(&below).sqrt();
            is_near.then(|| Near {
                vertex,
                at: across.place(point),
            })
        };
        if let Shape::Box { half_extents } = solid.shape {
            let points = solid.corners_of_box(half_extents);
            let farthest = points[farthest.vertex as usize];
            let all = (0..).zip(&points);
            let found = all.filter_map(|(k, point)| near(k, point, &farthest));
            let (mut known, mut len) = ([Near::default(); 8], 0);
            for own in found {
                known[len] = own;
                len += 1;
            }
            self.wrap(solid, across, || known[..len].iter().copied());
        } else {
            let vertices = || 0..solid.shape.n_vertices();
            let near = |k: u32| near(k, &solid.vertex(k), &farthest.point);
            self.wrap(solid, across, || vertices().filter_map(near));
        }
        self.find_face(solid, n);
    }

    /// From each corner to that one which has all others on its left.
    fn wrap<I: Iterator<Item = Near>>(
        &mut self,
        solid: &Solid<'_>,
        across: &Across,
        all: impl Fn() -> I,
    ) {
        let mut lowest = None;
        for own in all() {
            lowest = Some(match lowest {
                Some(best) if !is_lower(&own, &best) => best,
                _ => own,
            });
        }
        let Some(first) = lowest else { return };
        let mut corner = first;
        for _ in 0..MAX_CORNERS {
            self.add_vertex(solid, corner.vertex, across);
            let mut next = None;
            for own in all() {
                if !is_at(&own, &corner) {
                    next = Some(next.map_or(own, |best| right_of(&corner, best, own)));
                }
            }
            match next {
                Some(next) if !is_at(&next, &first) => corner = next,
                _ => break,
            }
        }
    }

    /// The widest triangle of the corners, of a box always the same.
    fn find_face(&mut self, solid: &Solid<'_>, n: &Vector3<f64>) {
        if let Shape::Box { half_extents } = solid.shape
            && half_extents.iter().all(|&x| x > 0.0)
        {
            let along = solid.X.rotation.tr_mul(n);
            self.face = (self.len > 2).then(|| solid.face(along.iamax(), n));
            return;
        }
        let mut widest = 0.0;
        for k in 2..self.len {
            let ids = [
                self.corners[0].vertex,
                self.corners[k - 1].vertex,
                self.corners[k].vertex,
            ];
            let [a, b, c] = ids.map_each(|k| solid.vertex(k));
            let area = (b - a).cross(&(c - a));
            if area.norm() > widest {
                widest = area.norm();
                let [i, j, k] = ids;
                let turned = area.dot(n) < 0.0;
                self.face = Some(Face::Vertices(if turned { [i, k, j] } else { [i, j, k] }));
            }
        }
        if let Shape::Ellipsoid { semi_axes } = solid.shape
            && let Some(axis) = semi_axes.iter().position(|&s| s == 0.0)
            && self.face.is_some()
        {
            let above = solid.X.rotation.column(axis).dot(n) > 0.0;
            self.face = Some(Face::Flat(2 * axis as u32 + u32::from(above)));
        }
    }
}

fn is_lower(a: &Near, b: &Near) -> bool {
    a.at.x < b.at.x
}

fn is_at(a: &Near, b: &Near) -> bool {
    a.at.x == b.at.x && a.at.y == b.at.y
}

/// That of two places which is farther to the right as seen from a corner; of those in one direction the farther one.
fn right_of(corner: &Near, a: Near, b: Near) -> Near {
    let (u, v) = (a.at - corner.at, b.at - corner.at);
    let (turn, lengths) = (u.perp(&v), [length(&u), length(&v)]);
    let is_straight = turn.abs() <= STRAIGHT * lengths[0] * lengths[1];
    let is_better = if is_straight {
        lengths[1] > lengths[0]
    } else {
        turn < 0.0
    };
    if is_better { b } else { a }
}

fn length(v: &Vector2<f64>) -> f64 {
    (v.x * v.x + v.y * v.y).sqrt()
}

/// Sine of an angle below which corners are on a line.
const STRAIGHT: f64 = 1e-12;
