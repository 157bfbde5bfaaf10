//! The features of a shape that may take part where it is approached from a direction.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use crate::collision::feature::{Face, Feature};
use crate::collision::guard::plane_across;
use crate::collision::shape::Shape;
use crate::collision::solid::Solid;
use crate::nested::IntoNested;
use crate::scalar::{MapEach, from_each};

/// Most options of a shape: edges, vertices and some faces.
const MAX_OPTIONS: usize = 48;
/// Most vertices of which edges and faces are made: those of a box that is thin both ways.
const MAX_NEAR: usize = 8;
/// Part of the reach of a shape by which a vertex may be above a face of it, and of the square of its longest side that a face must have.
const FLAT: f64 = 1e-13;

/// A feature, with the face that has its normal, if it is on one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    pub(super) feature: Feature,
    pub(super) face: Option<Face>,
}

/// Tilt of the normal against the axis of a cylinder below which a rim has no point that lies farthest, rad.
const UPRIGHT: f64 = 1e-12;

/// Features of a shape, faces first, vertices last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Options {
    choices: [Choice; MAX_OPTIONS],
    len: usize,
}

impl Options {
    /// The features that lie farthest along a unit direction, or would if it changed by an angle (rad).
    pub(super) fn new(solid: &Solid<'_>, n: &Vector3<f64>, angle: f64) -> Self {
        let nothing = Choice {
            feature: Feature::Surface,
            face: None,
        };
        let mut own = Self {
            choices: [nothing; MAX_OPTIONS],
            len: 0,
        };
        match solid.shape {
            Shape::Ellipsoid { semi_axes } => match flat_axes(semi_axes) {
                (0, _) => own.push(Feature::Surface, None),
                (1, axis) => own.add_flat_ellipsoid(solid, n, angle, axis),
                _ => own.add_polytope(solid, n, angle),
            },
            Shape::Cylinder { .. } => own.add_cylinder(solid, n, angle),
            _ => own.add_polytope(solid, n, angle),
        }
        own
    }

    pub(super) fn choices(&self) -> &[Choice] {
        &self.choices[..self.len]
    }

    fn push(&mut self, feature: Feature, face: Option<Face>) {
        if self.len < MAX_OPTIONS {
            self.choices[self.len] = Choice { feature, face };
            self.len += 1;
        }
    }

    fn add_cylinder(&mut self, solid: &Solid<'_>, n: &Vector3<f64>, angle: f64) {
        let along = solid.X.rotation.column(2).dot(n);
        let end = u32::from(along > 0.0);
        let tilt = solid.tilt(2, n);
        if tilt <= angle {
            self.push(Feature::Vertex(end), Some(Face::Cap(end)));
        }
        if along.abs() <= angle {
            self.push(Feature::Edge([0, 1]), None);
            self.push(Feature::Rim(1 - end), None);
        }
        if tilt > UPRIGHT {
            self.push(Feature::Rim(end), None);
        }
    }

    /// An ellipse, which has two faces.
    fn add_flat_ellipsoid(&mut self, solid: &Solid<'_>, n: &Vector3<f64>, angle: f64, axis: usize) {
        let along = solid.X.rotation.column(axis).dot(n);
        if solid.tilt(axis, n) <= angle {
            let face = 2 * axis as u32 + u32::from(along > 0.0);
            self.push(Feature::Vertex(0), Some(Face::Flat(face)));
        }
        self.push(Feature::Surface, None);
    }

    fn add_polytope(&mut self, solid: &Solid<'_>, n: &Vector3<f64>, angle: f64) {
        let near = Near::new(solid, n, angle);
        let vertices = near.vertices();
        near.each_face(solid, n, &mut |face| {
            self.push(Feature::Vertex(face[0]), Some(Face::Vertices(face)));
        });
        for (k, &i) in vertices.iter().enumerate() {
            for &j in &vertices[..k] {
                self.push(Feature::Edge([j, i]), None);
            }
        }
        for &i in vertices {
            self.push(Feature::Vertex(i), None);
        }
    }
}

/// The vertices of a polytope that lie farthest along a direction.
struct Near {
    vertices: [u32; MAX_NEAR],
    heights: [f64; MAX_NEAR],
    len: usize,
}

impl Near {
    /// Those within an angle as seen from the farthest; the highest if there are too many.
    fn new(solid: &Solid<'_>, n: &Vector3<f64>, angle: f64) -> Self {
        let mut own = Self {
            vertices: [0; MAX_NEAR],
            heights: [0.0; MAX_NEAR],
            len: 0,
        };
        let farthest = solid.support(n).point;
        let flat = FLAT * solid.reach();
        let is_level = |k: &u32| (farthest - solid.vertex(*k)).dot(n) <= flat;
        if (0..solid.shape.n_vertices()).filter(is_level).count() > MAX_NEAR {
            own.add_outermost(solid, n, is_level);
            return own;
        }
        let is_near = |below: &Vector3<f64>| below.dot(n) <= angle * below.norm();
        let mut count = 0;
        for k in 0..solid.shape.n_vertices() {
            let below = farthest - solid.vertex(k);
            if is_near(&below) {
                own.insert(k, below.dot(n));
                count += 1;
            }
        }
        if count > MAX_NEAR {
            own.add_ends(solid, |k| is_near(&(farthest - solid.vertex(*k))));
        }
        own
    }

    /// In place of the lowest two: the end of a needle that is tilted a little, among whose vertices are all of the highest, and a corner of such a plate.
    fn add_ends(&mut self, solid: &Solid<'_>, is_near: impl Fn(&u32) -> bool) {
        let top = solid.vertex(self.vertices[0]);
        let apart = |k: &u32| solid.vertex(*k) - top;
        let most = |measure: &dyn Fn(&u32) -> f64| {
            let near = (0..solid.shape.n_vertices()).filter(&is_near);
            near.max_by(|i, j| measure(i).total_cmp(&measure(j)))
        };
        let Some(end) = most(&|k| apart(k).norm_squared()) else {
            return;
        };
        let along = apart(&end);
        let corner = most(&|k| along.cross(&apart(k)).norm_squared());
        for (place, vertex) in [(MAX_NEAR - 1, Some(end)), (MAX_NEAR - 2, corner)] {
            if let Some(vertex) = vertex.filter(|vertex| !self.vertices().contains(vertex)) {
                self.vertices[place] = vertex;
            }
        }
    }

    /// Those of a large face or a needle that lie farthest along directions across its normal: which is the highest of them rounding decides.
    fn add_outermost(
        &mut self,
        solid: &Solid<'_>,
        n: &Vector3<f64>,
        is_level: impl Fn(&u32) -> bool,
    ) {
        let [x, y] = plane_across(n);
        for k in 0..MAX_NEAR {
            let (sin, cos) = (TAU * k as f64 / MAX_NEAR as f64).sin_cos();
            let reach = |k: &u32| solid.vertex(*k).dot(&(x * cos + y * sin));
            let level = (0..solid.shape.n_vertices()).filter(&is_level);
            let outermost = level.max_by(|i, j| reach(i).total_cmp(&reach(j)));
            match outermost {
                Some(vertex) if !self.vertices().contains(&vertex) => self.insert(vertex, 0.0),
                _ => {}
            }
        }
    }

    fn insert(&mut self, vertex: u32, depth: f64) {
        let at = self.heights[..self.len].partition_point(|&d| d <= depth);
        if at == MAX_NEAR {
            return;
        }
        self.len = (self.len + 1).min(MAX_NEAR);
        self.vertices.copy_within(at..self.len - 1, at + 1);
        self.heights.copy_within(at..self.len - 1, at + 1);
        self.vertices[at] = vertex;
        self.heights[at] = depth;
    }

    fn vertices(&self) -> &[u32] {
        &self.vertices[..self.len]
    }

    /// Hands on the faces among the vertices, each by its widest triangle, counter-clockwise as seen from where n points.
    fn each_face(&self, solid: &Solid<'_>, n: &Vector3<f64>, each: &mut dyn FnMut([u32; 3])) {
        if self.len < 3 {
            return;
        }
        let all: [Vector3<f64>; MAX_NEAR] =
            from_each(|k| solid.vertex(self.vertices[k.min(self.len - 1)]));
        let points = &all[..self.len];
        let flat = FLAT * solid.reach();
        for corners in triples(self.len) {
            if is_widest_of_a_face(points, corners, n, flat) {
                let [i, j, k] = corners;
                let turned = area(points, corners).dot(n) < 0.0;
                let ids = if turned { [i, k, j] } else { corners };
                each(ids.map_each(|k| self.vertices[k]));
            }
        }
    }
}

/// Twice the area of a triangle, along its normal.
fn area(points: &[Vector3<f64>], [i, j, k]: [usize; 3]) -> Vector3<f64> {
    (points[j] - points[i]).cross(&(points[k] - points[i]))
}

/// Whether no point is above the plane of a triangle, seen from where n points, and no triangle of that plane is wider; of equal ones the first.
fn is_widest_of_a_face(
    points: &[Vector3<f64>],
    corners: [usize; 3],
    n: &Vector3<f64>,
    flat: f64,
) -> bool {
    let own = area(points, corners);
    let [i, j, k] = corners.map_each(|corner| points[corner]);
    let longest = [j - i, k - i, k - j].map_each(|u| u.norm_squared());
    if own.norm() <= FLAT * longest.into_iter().fold(0.0, f64::max) {
        return false;
    }
    let Some(normal) = own.try_normalize(f64::MIN_POSITIVE) else {
        return false;
    };
    let normal = if normal.dot(n) < 0.0 { -normal } else { normal };
    let height = |k: usize| normal.dot(&(points[k] - points[corners[0]]));
    if (0..points.len()).any(|k| height(k) > flat) {
        return false;
    }
    let is_rival = |other: [usize; 3]| {
        let wider = area(points, other).norm() - own.norm();
        let is_first = wider > 0.0 || (wider == 0.0 && other < corners);
        is_first && other.iter().all(|&k| height(k) >= -flat)
    };
    !triples(points.len()).any(is_rival)
}

/// All triples i < j < k of indices.
fn triples(len: usize) -> impl Iterator<Item = [usize; 3]> {
    (2..len).nested(|k| (1..k).nested(move |j| (0..j).map(move |i| [i, j, k])))
}

/// Number of semi-axes that are zero, and the last of these.
fn flat_axes(semi_axes: &[f64; 3]) -> (usize, usize) {
    let flat = (0..3).filter(|&axis| semi_axes[axis] == 0.0);
    (flat.clone().count(), flat.max().unwrap_or(0))
}
