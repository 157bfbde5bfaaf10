//! Selection of the points that take part in the search for a convex hull.
//!
//! The search takes some microseconds for each vertex of the hull that it finds. Links of robots have hulls of hundreds or some thousands
//! of vertices, but a file may hold any number of points on a sphere, all of which are vertices. So the search gets a bounded number of points:
//!
//! | how many there are | which are put to the search | the hull is |
//! |---|---|---|
//! | up to [`MAX_POINTS`] | all | exact |
//! | more, but no more outside of a polytope of some of them | those outside, as none inside is a vertex | exact |
//! | still more | of those in each cell of the directions from the middle, the one that is farthest out | within it |
//!
//! Time and memory are linear in the number of points.

use crate::nested::IntoNested;
use glam::Vec3A;
use nalgebra::Vector3;

use super::convex::convex;
use super::directions::directions;
use crate::scalar::MapEach;

/// Most points that are all put to the search: it takes some tenths of a second for as many vertices.
pub(super) const MAX_POINTS: usize = 20_000;

/// Directions of the extreme points that span a polytope, in rounds: a few for most of the points, more for the rest.
const DIRECTIONS: [usize; 2] = [64, 1024];

/// A point is inside only if it is so by this much, where the points reach from −1 to 1: some roundings of single precision.
const MARGIN: f64 = 1e-6;

/// Cells along each edge of a cube around the middle, on whose sides directions are sorted. Two points in a cell are at most 2 √2 / 48 = 3.4°
/// apart as seen from the middle, so that of a ball 1 − cos 3.4° = 0.2 % of the radius may be lost.
const CELLS: usize = 48;

/// The points that are put to the search.
pub(super) struct Candidates {
    /// Their positions, in their order.
    pub(super) indices: Vec<usize>,
    /// Whether vertices of the hull may be missing, and of how many points one is.
    pub(super) left_out: Option<LeftOut>,
}

/// Mark of an inexact hull, which may lack vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LeftOut {
    /// Points that may be vertices.
    pub(super) of: usize,
}

/// Chooses the points that are put to the search.
///
/// * `points` – from −1 to 1 along each axis, or 0 along those in which they are flat
/// * `flat` – the axes along which they are flat
pub(super) fn candidates(points: &[Vec3A], flat: &[Vec3A]) -> Candidates {
    let mut indices: Vec<usize> = (0..points.len()).collect();
    let mut extremes = Vec::new();
    for count in DIRECTIONS {
        if indices.len() <= MAX_POINTS {
            break;
        }
        extremes = extremes_of(points, &indices, &directions(count));
        let before = indices.len();
        match Polytope::of(points, &extremes, flat) {
            Some(inner) => indices.retain(|&i| !inner.holds(&wide(points[i]))),
            None => break,
        }
        // More directions find as little.
        if indices.len() > before / 2 {
            break;
        }
    }
    if indices.len() <= MAX_POINTS {
        return Candidates {
            indices,
            left_out: None,
        };
    }
    let left_out = Some(LeftOut { of: indices.len() });
    let mut indices = farthest_of_cells(points, &indices, &extremes);
    indices.append(&mut extremes);
    indices.sort_unstable();
    indices.dedup();
    Candidates { indices, left_out }
}

/// Those that are farthest in some directions, each once.
fn extremes_of(points: &[Vec3A], indices: &[usize], directions: &[Vector3<f64>]) -> Vec<usize> {
    let narrow = |d: &Vector3<f64>| Vec3A::new(d.x as f32, d.y as f32, d.z as f32);
    let directions = directions.iter().map(narrow);
    let farthest = directions.filter_map(|d| {
        let reaches = indices.iter().map(|&i| (i, points[i].dot(d)));
        reaches.reduce(|a, b| if b.1 > a.1 { b } else { a })
    });
    let mut extremes: Vec<usize> = farthest.map(|(i, _)| i).collect();
    extremes.sort_unstable();
    extremes.dedup();
    extremes
}

/// Convex polytope: the intersection of the half spaces on one side of each of some planes.
struct Polytope {
    /// Unit normals outwards, and how far out the planes are.
    planes: Vec<(Vector3<f64>, f64)>,
}

impl Polytope {
    /// The hull of some points, thickened along axes in which they are flat; `None` if it is not found.
    fn of(points: &[Vec3A], chosen: &[usize], flat: &[Vec3A]) -> Option<Self> {
        let mut corners: Vec<Vec3A> = chosen.iter().map(|&i| points[i]).collect();
        corners.extend(flat.iter().nested(|&axis| [axis, -axis]));
        let found = convex(&corners).ok()?;
        let middle = middle(corners.iter().copied());
        let corner = |i: u32| wide(found.vertices()[i as usize]);
        let planes = found.indices().iter().filter_map(|triangle| {
            let [a, b, c] = triangle.map_each(corner);
            // A triangle without area bounds nothing.
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
            let outwards = if normal.dot(&(a - middle)) < 0.0 {
                -normal
            } else {
                normal
            };
            Some((outwards, outwards.dot(&a)))
        });
        let planes: Vec<_> = planes.collect();
        (!planes.is_empty()).then_some(Self { planes })
    }

    /// Whether a point is inside, not on the surface.
    fn holds(&self, p: &Vector3<f64>) -> bool {
        let mut planes = self.planes.iter();
        planes.all(|(normal, reach)| normal.dot(p) < reach - MARGIN)
    }
}

/// Of the points in each cell of the directions from the middle of the extreme ones, that which is farthest from there.
fn farthest_of_cells(points: &[Vec3A], indices: &[usize], extremes: &[usize]) -> Vec<usize> {
    let middle = middle(extremes.iter().map(|&i| points[i]));
    let mut farthest = vec![None; 6 * CELLS * CELLS];
    for &i in indices {
        let arm = wide(points[i]) - middle;
        let (cell, reach) = (cell(&arm), arm.norm_squared());
        if farthest[cell].is_none_or(|(_, most)| reach > most) {
            farthest[cell] = Some((i, reach));
        }
    }
    farthest.into_iter().flatten().map(|(i, _)| i).collect()
}

/// The cell of a direction: on the side of a cube that it goes through.
fn cell(arm: &Vector3<f64>) -> usize {
    let axis = arm.iamax();
    let along = arm[axis];
    let side = 2 * axis + usize::from(along < 0.0);
    let place = |other: usize| {
        let x = arm[(axis + other) % 3] / along.abs().max(f64::MIN_POSITIVE);
        // From −1 to 1; the cast saturates.
        ((0.5 * (x + 1.0) * CELLS as f64) as usize).min(CELLS - 1)
    };
    (side * CELLS + place(1)) * CELLS + place(2)
}

fn middle(points: impl ExactSizeIterator<Item = Vec3A>) -> Vector3<f64> {
    let count = points.len().max(1) as f64;
    points.map(wide).sum::<Vector3<f64>>() / count
}

fn wide(point: Vec3A) -> Vector3<f64> {
    Vector3::from(point.to_array()).map(f64::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(axis: usize, sign: f64) -> Vector3<f64> {
        let mut out = Vector3::zeros();
        out[axis] = sign;
        out
    }

    #[test]
    fn cells_of_the_sides_of_a_cube_are_apart_and_directions_in_one_are_close() {
        let mut seen: Vec<usize> = (0..6)
            .map(|k| cell(&unit(k / 2, [1.0, -1.0][k % 2])))
            .collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 6);
        let mut mean = vec![Vec::new(); 6 * CELLS * CELLS];
        let spread = directions(50_000);
        for d in &spread {
            mean[cell(d)].push(*d);
        }
        let widest = 2.0 * 2.0_f64.sqrt() / CELLS as f64;
        for own in &mean {
            for pair in own.windows(2) {
                assert!(pair[0].angle(&pair[1]) <= widest, "{pair:?}");
            }
        }
        assert_eq!(cell(&Vector3::zeros()) / (CELLS * CELLS), 0);
    }

    #[test]
    fn polytope_of_a_cube_holds_what_is_inside_of_it_and_not_its_surface() {
        let side = |k: usize, axis: usize| if k >> axis & 1 == 0 { -1.0 } else { 1.0 };
        let corners: Vec<Vec3A> = (0..8)
            .map(|k| Vec3A::new(side(k, 0), side(k, 1), side(k, 2)))
            .collect();
        let cube = Polytope::of(&corners, &Vec::from_iter(0..8), &[]).unwrap();
        assert!(cube.holds(&Vector3::new(0.999, -0.999, 0.5)));
        assert!(!cube.holds(&Vector3::new(1.0, 0.0, 0.0)));
        assert!(!cube.holds(&Vector3::new(0.0, 1.001, 0.0)));
        // A square in a plane is thickened.
        let square: Vec<Vec3A> = corners[..4].iter().map(|p| p.with_z(0.0)).collect();
        let square = Polytope::of(&square, &Vec::from_iter(0..4), &[Vec3A::Z]).unwrap();
        assert!(square.holds(&Vector3::new(0.9, -0.9, 0.0)));
        assert!(!square.holds(&Vector3::new(1.0, 0.5, 0.0)));
    }
}
