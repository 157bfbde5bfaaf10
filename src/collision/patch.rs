//! The flat part of a shape that lies farthest along a direction: a point, an edge or a face, as a polygon.

use nalgebra::{Vector2, Vector3};

use super::feature::{Face, Feature};
use super::shape::{RIM_VERTICES, Shape};
use super::solid::Solid;

/// Most corners of a polygon.
pub(super) const MAX_CORNERS: usize = RIM_VERTICES as usize;

/// Vertices of a box, of which a table is kept.
const FEW: usize = 8;

/// A corner of a polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) feature: Feature,
    /// Vertex by which edges name the corner.
    vertex: u32,
    /// Place across the direction.
    pub(super) at: Vector2<f64>,
}

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
#[derive(Clone, Copy, Debug)]
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

/// Two axes across a normal, such that x × y = n.
#[derive(Clone, Copy, Debug)]
pub(super) struct Across {
    x: Vector3<f64>,
    y: Vector3<f64>,
}

impl Across {
    pub(super) fn new(n: &Vector3<f64>) -> Self {
        let x = n.cross(&Vector3::ith(n.iamin(), 1.0)).normalize();
        Self { x, y: n.cross(&x) }
    }

    pub(super) fn place(&self, p: &Vector3<f64>) -> Vector2<f64> {
        Vector2::new(self.x.dot(p), self.y.dot(p))
    }
}

impl Patch {
    /// The part of a shape that lies farthest along a unit direction, or would if it changed by an angle (rad).
    ///
    /// * `across` – axes of the polygon, across a normal that is near to the direction or opposite
    pub(super) fn new(solid: &Solid<'_>, n: &Vector3<f64>, angle: f64, across: &Across) -> Self {
        let nothing = Corner {
            feature: Feature::Surface,
            vertex: 0,
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
                own.push(Feature::Surface, 0, across.place(&solid.support(n).point));
            }
            _ => own.add_polytope(solid, n, angle, across),
        }
        own
    }

    pub(super) fn corners(&self) -> &[Corner] {
        &self.corners[..self.len]
    }

    /// The sides, each with its corners; that of an edge once.
    pub(super) fn sides(&self) -> impl Iterator<Item = (Feature, [Vector2<f64>; 2])> {
        let n_sides = if self.len < 3 {
            self.len.saturating_sub(1)
        } else {
            self.len
        };
        (0..n_sides).map(|k| {
            let [a, b] = [self.corners[k], self.corners[(k + 1) % self.len]];
            (Feature::Edge([a.vertex, b.vertex]), [a.at, b.at])
        })
    }

    /// Distance of a place from the polygon along the normal of a side, or from the disc, not positive inside; infinite for what is neither.
    pub(super) fn outside(&self, place: &Vector2<f64>) -> f64 {
        let beyond = |[a, b]: [Vector2<f64>; 2]| {
            let u = b - a;
            (place - a).perp(&u) / u.norm()
        };
        let sides = self.sides().map(|(_, side)| beyond(side));
        if let Some(Disc { center, radius }) = self.disc {
            (place - center).norm() - radius
        } else if self.len > 2 {
            sides.fold(f64::NEG_INFINITY, f64::max)
        } else {
            f64::INFINITY
        }
    }

    fn push(&mut self, feature: Feature, vertex: u32, at: Vector2<f64>) {
        if self.len < MAX_CORNERS {
            self.corners[self.len] = Corner {
                feature,
                vertex,
                at,
            };
            self.len += 1;
        }
    }

    fn add_vertex(&mut self, solid: &Solid<'_>, vertex: u32, across: &Across) {
        self.push(
            Feature::Vertex(vertex),
            vertex,
            across.place(&solid.vertex(vertex)),
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
                self.push(
                    Feature::Rim(end),
                    end,
                    across.place(&(solid.vertex(end) + aside)),
                );
            }
        } else {
            self.push(
                Feature::Rim(end),
                end,
                across.place(&solid.support(n).point),
            );
        }
    }

    fn orient(&mut self) {
        let [a, b, c] = [0, 1, 2].map(|k| self.corners[k].at);
        if (b - a).perp(&(c - a)) < 0.0 {
            self.corners[..self.len].reverse();
        }
    }

    /// The vertices of a polytope that are near the farthest, wrapped as a gift is.
    fn add_polytope(&mut self, solid: &Solid<'_>, n: &Vector3<f64>, angle: f64, across: &Across) {
        let farthest = solid.support(n).point;
        let near = |k: u32| {
            let vertex = solid.vertex(k);
            let below = farthest - vertex;
            let is_near = below.dot(n) <= angle * below.norm();
            is_near.then(|| Near {
                vertex: k,
                at: across.place(&vertex),
            })
        };
        let n_vertices = solid.shape.n_vertices();
        // Those of a box and what has fewer are placed once, not again for each corner.
        let mut known = [None; FEW];
        if n_vertices as usize <= FEW {
            let all = known.iter_mut().zip(0..n_vertices);
            all.for_each(|(own, k)| *own = near(k));
            self.wrap(n_vertices, &|k| known[k as usize]);
        } else {
            self.wrap(n_vertices, &near);
        }
        self.find_face(solid, n);
    }

    /// From each corner to that one which has all others on its left.
    fn wrap(&mut self, n_vertices: u32, near: &dyn Fn(u32) -> Option<Near>) {
        let all = || (0..n_vertices).filter_map(near);
        let lowest = |a: Near, b: Near| if b.at.x < a.at.x { b } else { a };
        let Some(first) = all().reduce(lowest) else {
            return;
        };
        let mut corner = first;
        for _ in 0..MAX_CORNERS {
            self.push(Feature::Vertex(corner.vertex), corner.vertex, corner.at);
            let right_of = |a: Near, b: Near| {
                let (u, v) = (a.at - corner.at, b.at - corner.at);
                let turn = u.perp(&v);
                let is_straight = turn.abs() <= STRAIGHT * u.norm() * v.norm();
                let is_better = if is_straight {
                    v.norm() > u.norm()
                } else {
                    turn < 0.0
                };
                if is_better { b } else { a }
            };
            let others = all().filter(|other| other.at != corner.at);
            match others.reduce(right_of) {
                Some(next) if next.at != first.at => corner = next,
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
            let [a, b, c] = ids.map(|k| solid.vertex(k));
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

/// Sine of an angle below which corners are on a line.
const STRAIGHT: f64 = 1e-12;
