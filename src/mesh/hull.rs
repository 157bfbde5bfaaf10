//! The vertices of a convex hull, and a choice of some that keeps its extent.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::panic::catch_unwind;

use glam::Vec3A;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use quickhull::ConvexTriangleMesh;

/// Width of what is flat, by the largest coordinate: some roundings of the single precision that mesh files have.
const FLAT: f64 = 1e-6;

/// Directions in which a choice of vertices is compared with all: a few degrees apart, and more than the points that anyone wants.
const DIRECTIONS: usize = 1024;

/// Most sweeps for the principal axes: a few are needed.
const MAX_SWEEPS: usize = 100;

/// The vertices of the convex hull of some points, in their order, each once; of flat points those of the polygon or the line. Fails
/// with the reason.
///
/// A hull commutes with affine maps: it is sought among points stretched along their principal axes to the cube from −1 to 1, where
/// thin shapes are as good as others. Directions in which the points are flat get a point of their own, outside.
///
/// * `points` – finite, at least one
pub(crate) fn hull(points: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, String> {
    let (mut stretched, widths) = stretch(points).ok_or("has no principal axes")?;
    if widths.iter().all(|&width| width == 0.0) {
        return Ok(vec![points[0]]);
    }
    let outside = (0..3).filter(|&axis| widths[axis] == 0.0);
    stretched.extend(outside.map(|axis| Vec3A::AXES[axis]));
    let found = catch_unwind(|| ConvexTriangleMesh::try_from_points(&stretched, None));
    let found = match found {
        Ok(found) => found.map_err(|error| format!("has no convex hull: {error}"))?,
        Err(_) => return Err("has no convex hull that can be found".into()),
    };
    let bits = |point: &Vec3A| point.to_array().map(f32::to_bits);
    let numbered = stretched.iter().enumerate().rev();
    let index_of: HashMap<_, _> = numbered.map(|(i, point)| (bits(point), i)).collect();
    let mut indices: Vec<usize> = found
        .vertices()
        .iter()
        .map(|p| index_of[&bits(p)])
        .collect();
    indices.sort_unstable();
    indices.dedup();
    let own = indices.iter().filter_map(|&i| points.get(i));
    Ok(own.copied().collect())
}

/// Points along their principal axes, from −1 to 1, and how wide they are there; zero where they are flat, in m.
fn stretch(points: &[[f32; 3]]) -> Option<(Vec<Vec3A>, [f64; 3])> {
    let points = points.iter().map(|&p| Vector3::from(p).map(f64::from));
    let points: Vec<Vector3<f64>> = points.collect();
    let mean = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let spread = |sum, p: &Vector3<f64>| sum + (p - mean) * (p - mean).transpose();
    let covariance = points.iter().fold(Matrix3::zeros(), spread);
    let axes = SymmetricEigen::try_new(covariance, f64::EPSILON, MAX_SWEEPS)?.eigenvectors;
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

/// At most so many of some points, in their order: one after the other, that one without which the others reach least far in one of
/// many directions. All of them, if there are not more.
pub(crate) fn thinned(points: Vec<Vector3<f64>>, most: usize) -> Vec<Vector3<f64>> {
    if points.len() <= most {
        return points;
    }
    let directions = directions();
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

/// The axes both ways, and unit vectors spread evenly: on a spiral that turns by the golden angle, at heights of equal areas.
fn directions() -> Vec<Vector3<f64>> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let spiral = (0..DIRECTIONS).map(|k| {
        let z = 1.0 - (2 * k + 1) as f64 / DIRECTIONS as f64;
        let (sin, cos) = (golden * k as f64).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        Vector3::new(radius * cos, radius * sin, z)
    });
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let axes = axes.into_iter().flat_map(|axis| [axis, -axis]);
    axes.chain(spiral).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

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

    /// How far some of the points fall short of all, by their size, in random directions.
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
        assert_eq!(hull(&points).unwrap(), cube());
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
        assert_eq!(hull(&with_more).unwrap(), square);
        let line = [
            [0.3, 0.3, 0.3],
            [0.1, 0.1, 0.1],
            [0.2, 0.2, 0.2],
            [-1.0, -1.0, -1.0],
        ];
        assert_eq!(hull(&line).unwrap(), [line[0], line[3]]);
        assert_eq!(hull(&[[0.3; 3]; 5]).unwrap(), [[0.3; 3]]);
        assert_eq!(hull(&square[..1]).unwrap(), [square[0]]);
        assert_eq!(hull(&[[0.0; 3], [1e30, 0.0, 0.0]]).unwrap().len(), 2);
    }

    #[test]
    fn hull_of_random_points_reaches_as_far_as_they_do() {
        for seed in 0..10 {
            for thickness in [1.0, 1e-2, 1e-4, 1e-5, 1e-7, 0.0] {
                for half in [[1.0, 1.0, thickness], [1.0, thickness, thickness]] {
                    let points = cloud(400, half, seed);
                    let found = hull(&points).unwrap();
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
        let found = hull(&points).unwrap();
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
}
