//! The vertices of a convex hull, and a choice of some that keeps its extent.

use std::collections::HashMap;

use crate::linalg::symmetric_eigen3;
use glam::Vec3A;
use nalgebra::{Matrix3, Vector3};

use super::candidates::{LeftOut, candidates};
use super::convex::convex;
use super::directions::directions;
use crate::scalar::MapEach;

/// Width of what is flat, by the largest coordinate: some roundings of the single precision that mesh files have.
const FLAT: f64 = 1e-6;

/// Directions in which a choice of vertices is compared with all: a few degrees apart, and more than the points that anyone wants.
const DIRECTIONS: usize = 1024;

/// The vertices of a convex hull.
#[derive(Clone, Debug)]
pub(crate) struct Hull {
    /// In the order of the points, each once, m.
    pub(crate) vertices: Vec<[f32; 3]>,
    /// Vertices of the triangles of its surface, which all face outwards or all inwards; none where the points are flat.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Remark for a person if these are not all vertices, as an end of the sentence "the mesh …".
    pub(crate) remark: Option<String>,
}

/// The vertices of the convex hull of some points; of flat points those of the polygon or the line. Fails with the reason.
///
/// A hull commutes with affine maps: it is sought among points stretched along their principal axes to the cube from −1 to 1, where
/// thin shapes are as good as others. Directions in which the points are flat get a point of their own, outside.
///
/// Of very many points on a round surface some represent the others: see [`candidates`]. Time and memory are linear in
/// the number of points.
///
/// * `points` – finite, at least one
pub(crate) fn hull(points: &[[f32; 3]]) -> Result<Hull, String> {
    let (stretched, widths) = stretch(points).ok_or("has no principal axes")?;
    let is_flat = |axis: &usize| widths[*axis] == 0.0;
    let flat: Vec<Vec3A> = (0..3).filter(is_flat).map(|k| Vec3A::AXES[k]).collect();
    if flat.len() == 3 {
        return Ok(Hull {
            vertices: vec![points[0]],
            triangles: Vec::new(),
            remark: None,
        });
    }
    let chosen = candidates(&stretched, &flat);
    let own = chosen.indices.iter().map(|&i| stretched[i]);
    let found = convex(&own.chain(flat).collect::<Vec<_>>())?;
    let bits = |point: &Vec3A| point.to_array().map_each(f32::to_bits);
    let numbered = chosen.indices.iter().rev();
    let index_of: HashMap<_, _> = numbered.map(|&i| (bits(&stretched[i]), i)).collect();
    let index = |p: &Vec3A| index_of.get(&bits(p)).copied();
    let found_points = found.vertices();
    let mut indices: Vec<usize> = found_points.iter().filter_map(index).collect();
    indices.sort_unstable();
    indices.dedup();
    let number = |k: u32| {
        Some(
            indices
                .binary_search(&index(&found_points[k as usize])?)
                .ok()? as u32,
        )
    };
    let corners = |&[a, b, c]: &[u32; 3]| Some([number(a)?, number(b)?, number(c)?]);
    // The points outside of flat ones are in triangles, too.
    let is_solid = widths.iter().all(|width| *width > 0.0);
    let triangles = found
        .indices()
        .iter()
        .filter(|_| is_solid)
        .filter_map(corners);
    let triangles = triangles.collect();
    let vertices: Vec<_> = indices.into_iter().map(|i| points[i]).collect();
    let remark = chosen.left_out.map(|left_out| remark(left_out, &vertices));
    Ok(Hull {
        vertices,
        triangles,
        remark,
    })
}

fn remark(left_out: LeftOut, vertices: &[[f32; 3]]) -> String {
    let (of, taken) = (left_out.of, vertices.len());
    format!(
        "has {of} points on or near its convex hull; contact uses {taken} of them, the farthest out in their directions"
    )
}

/// Points along their principal axes, from −1 to 1, and how wide they are there; zero where they are flat, in m.
fn stretch(points: &[[f32; 3]]) -> Option<(Vec<Vec3A>, [f64; 3])> {
    let points = points.iter().map(|&p| Vector3::from(p).map(f64::from));
    let points: Vec<Vector3<f64>> = points.collect();
    let mean = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let spread = |sum, p: &Vector3<f64>| sum + (p - mean) * (p - mean).transpose();
    let covariance = points.iter().fold(Matrix3::zeros(), spread);
    let axes = symmetric_eigen3(&covariance)?.1;
    let reach = points.iter().map(Vector3::amax).fold(0.0, f64::max);
    let (mut out, mut widths) = (vec![Vec3A::ZERO; points.len()], [0.0; 3]);
    for axis in 0..3 {
        let along = |p: &Vector3<f64>| axes.column(axis).dot(&(p - mean));
        let least = points.iter().map(along).fold(f64::INFINITY, f64::min);
        let largest = points.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
        let width = largest - least;
        if width > FLAT * reach {
            widths[axis] = width;
            for (out, p) in out.iter_mut().zip(&points) {
                out[axis] = (2.0 * (along(p) - least) / width - 1.0) as f32;
            }
        }
    }
    Some((out, widths))
}

/// At most so many of some points, in their order: in sequence, that one without which the others reach least far in one of
/// many directions. All of them, if there are not more.
pub(crate) fn thinned(points: Vec<Vector3<f64>>, most: usize) -> Vec<Vector3<f64>> {
    if points.len() <= most {
        return points;
    }
    let directions = directions(DIRECTIONS);
    let farthest = |d: &Vector3<f64>| {
        let reaches = points.iter().map(|p| p.dot(d)).enumerate();
        reaches.fold((0, f64::NEG_INFINITY), |a, b| if b.1 > a.1 { b } else { a })
    };
    let wanted: Vec<(usize, f64)> = directions.iter().map(farthest).collect();
    let mut reached = vec![f64::NEG_INFINITY; directions.len()];
    let mut kept = Vec::with_capacity(most);
    while kept.len() < most {
        let missing = wanted.iter().zip(&reached).map(|(w, r)| (w.0, w.1 - r));
        let (next, gap) = missing.fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        if gap == 0.0 {
            break;
        }
        kept.push(next);
        for (reached, d) in reached.iter_mut().zip(&directions) {
            *reached = reached.max(points[next].dot(d));
        }
    }
    kept.sort_unstable();
    kept.into_iter().map(|i| points[i]).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::candidates::MAX_POINTS;
    use super::*;

    /// The vertices of an exact hull.
    fn exact(points: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let found = hull(points).unwrap();
        assert_eq!(found.remark, None);
        found.vertices
    }

    /// Numbers from −1 to 1.
    fn random(count: usize, seed: u64) -> Vec<f64> {
        use rand::{RngExt, SeedableRng, rngs::Xoshiro256PlusPlus};
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        (0..count).map(|_| rng.random_range(-1.0..1.0)).collect()
    }

    /// Random points in a box of these half edges, turned.
    fn cloud(count: usize, half: [f64; 3], seed: u64) -> Vec<[f32; 3]> {
        let turned = nalgebra::Rotation3::from_euler_angles(0.4, -0.7, seed as f64);
        let numbers = random(3 * count, seed);
        let points = numbers.as_chunks::<3>().0.iter();
        let points = points.map(|x| turned * Vector3::from_fn(|i, _| half[i] * x[i]));
        points.map(|p| p.map(|x| x as f32).into()).collect()
    }

    /// Largest difference of the support functions of all points and of some of them, relative to their size, in random directions.
    fn shortfall(all: &[[f32; 3]], some: &[[f32; 3]]) -> f64 {
        let size = all.iter().flatten().fold(0.0, |a: f32, x| a.max(x.abs()));
        let directions = random(900, 7);
        let each = directions.as_chunks::<3>().0.iter().map(|d| {
            let d = Vector3::from(*d).normalize();
            let reach = |points: &[[f32; 3]]| {
                let along = points
                    .iter()
                    .map(|&p| d.dot(&Vector3::from(p).map(f64::from)));
                along.fold(f64::NEG_INFINITY, f64::max)
            };
            reach(all) - reach(some)
        });
        each.fold(0.0, f64::max) / f64::from(size)
    }

    fn cube() -> Vec<[f32; 3]> {
        let side = |k: usize, axis: usize| if k >> axis & 1 == 0 { -0.5 } else { 0.5 };
        (0..8)
            .map(|k| [0, 1, 2].map(|axis| side(k, axis)))
            .collect()
    }

    #[test]
    fn hull_of_a_cube_with_points_inside_and_on_its_sides_equals_its_corners() {
        let mut points = vec![[0.1, 0.2, -0.3], [0.5, 0.0, 0.0], [0.5, 0.5, 0.25]];
        points.extend(cube());
        points.extend([[0.0; 3], [0.5, 0.5, 0.5], [-0.5, 0.1, 0.1]]);
        assert_eq!(exact(&points), cube());
    }

    #[test]
    fn hull_of_flat_points_equals_polygon_line_or_point() {
        let square = [
            [0.0, 0.0, 2.0],
            [1.0, 0.0, 2.0],
            [1.0, 1.0, 2.0],
            [0.0, 1.0, 2.0],
        ];
        let mut with_more = square.to_vec();
        with_more.extend([[0.5, 0.5, 2.0], [0.5, 0.0, 2.0], [1.0, 0.0, 2.0]]);
        assert_eq!(exact(&with_more), square);
        let line = [
            [0.3, 0.3, 0.3],
            [0.1, 0.1, 0.1],
            [0.2, 0.2, 0.2],
            [-1.0, -1.0, -1.0],
        ];
        assert_eq!(exact(&line), [line[0], line[3]]);
        assert_eq!(exact(&[[0.3; 3]; 5]), [[0.3; 3]]);
        assert_eq!(exact(&square[..1]), [square[0]]);
        assert_eq!(exact(&[[0.0; 3], [1e30, 0.0, 0.0]]).len(), 2);
    }

    #[test]
    fn hull_of_random_points_reaches_as_far_as_they_do() {
        for seed in 0..10 {
            for thickness in [1.0, 1e-2, 1e-4, 1e-5, 1e-7, 0.0] {
                for half in [[1.0, 1.0, thickness], [1.0, thickness, thickness]] {
                    let points = cloud(400, half, seed);
                    let found = exact(&points);
                    let (short, n) = (shortfall(&points, &found), found.len());
                    assert!(short < FLAT && n < 200, "{half:?} {seed}: {short:e}, {n}");
                }
            }
        }
    }

    #[test]
    fn every_point_of_a_sphere_is_a_vertex_and_some_of_them_reach_nearly_as_far() {
        let points = cloud(500, [1.0; 3], 3);
        let on_sphere = |p: &[f32; 3]| Vector3::from(*p).normalize().into();
        let points: Vec<[f32; 3]> = points.iter().map(on_sphere).collect();
        let found = exact(&points);
        assert_eq!(found, points);
        let found: Vec<_> = found
            .iter()
            .map(|&p| Vector3::from(p).map(f64::from))
            .collect();
        for (most, expected) in [(16, 0.3), (64, 0.07), (256, 0.02)] {
            let some = thinned(found.clone(), most);
            let some: Vec<[f32; 3]> = some.iter().map(|p| p.map(|x| x as f32).into()).collect();
            let short = shortfall(&points, &some);
            assert!(some.len() == most && short < expected, "{most}: {short}");
        }
        assert_eq!(thinned(found.clone(), 500), found);
        assert!(thinned(found, 0).is_empty());
    }

    fn on_sphere(count: usize, radii: [f64; 3]) -> Vec<[f32; 3]> {
        let points = directions(count).into_iter();
        let points = points.map(|d| d.component_mul(&Vector3::from(radii)));
        points.map(|p| p.map(|x| x as f32).into()).collect()
    }

    // Inner points are found first, and the search skips them.
    #[test]
    fn hull_of_a_box_with_very_many_points_inside_equals_its_corners() {
        let size = [0.3, 1.0, 2.0];
        let corners: Vec<[f32; 3]> = cube()
            .iter()
            .map(|c| std::array::from_fn(|k| 2.0 * c[k] * size[k] as f32))
            .collect();
        let numbers = random(1_200_000, 5);
        let inside = numbers.as_chunks::<3>().0.iter();
        let inside = inside.map(|x| std::array::from_fn(|k| (0.999 * x[k] * size[k]) as f32));
        let mut points: Vec<[f32; 3]> = inside.collect();
        points.splice(1000..1000, corners.iter().copied());
        assert_eq!(exact(&points), corners);
        // Without the corners, and flat: as far as all of them reach.
        points.drain(1000..1008);
        for flattened in [[1.0, 1.0, 1.0], [1.0, 0.0, 1.0]] {
            let points: Vec<[f32; 3]> = points
                .iter()
                .map(|p| std::array::from_fn(|k| p[k] * flattened[k]))
                .collect();
            let found = exact(&points);
            let (short, n) = (shortfall(&points, &found), found.len());
            assert!(short < FLAT && n < 1000, "{flattened:?}: {short:e}, {n}");
        }
    }

    // The search gets a bounded number of points, however many there are.
    #[test]
    fn hull_of_very_many_points_on_an_ellipsoid_is_bounded_and_reaches_nearly_as_far() {
        for (count, radii) in [(400_000, [1.0; 3]), (100_000, [0.02, 1.0, 0.3])] {
            let points = on_sphere(count, radii);
            let found = hull(&points).unwrap();
            let (short, n) = (shortfall(&points, &found.vertices), found.vertices.len());
            assert!(n > 5_000 && n <= MAX_POINTS, "{n}");
            assert!(short < 2e-3, "{radii:?}: {short:e}");
            let remark = found.remark.unwrap();
            let expected = format!(
                "has {} points on or near its convex hull; contact uses {n}",
                count + 6
            );
            assert!(remark.starts_with(&expected), "{remark}");
            assert_eq!(hull(&points).unwrap().vertices, found.vertices);
        }
        // A circle is flat.
        let circle: Vec<[f32; 3]> = (0..100_000)
            .map(|k| (TAU * f64::from(k) / 1e5).sin_cos())
            .map(|(y, x)| [x as f32, y as f32, 0.0])
            .collect();
        let found = hull(&circle).unwrap().vertices;
        assert!(shortfall(&circle, &found) < 2e-3 && found.len() < 1_000);
    }
}
