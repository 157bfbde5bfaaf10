//! Spheres and hemispheres of triangles.

use std::collections::HashMap;

use super::builtin_surface::{Made, fits, surface, whole};
use crate::nested::IntoNested;
use crate::scalar::{MapEach, from_each};

fn unit(p: [f64; 3]) -> [f64; 3] {
    let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
    p.map_each(|x| x / length)
}

/// An icosahedron whose triangles are divided into four, so many times: a sphere of radius 1.
pub(super) fn sphere(parameters: &[f64], left: usize) -> Made {
    let times = whole("the number of subdivisions", parameters[0], 0, 4)?;
    fits(10 * 4_usize.pow(times as u32) + 2, left)?;
    let (mut points, mut triangles) = icosahedron();
    for _ in 0..times {
        triangles = divided(&triangles, &mut points);
    }
    Ok(surface(&points, Some(triangles)))
}

/// Corners of an icosahedron on the unit sphere, and its triangles, which face outwards.
fn icosahedron() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    /// Cosine of the angle between neighbours is 1/√5; that of others is negative.
    const NEAR: f64 = 0.1;
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let rectangle = |k: usize| {
        signs.map_each(|(one, other)| {
            let p = [0.0, one, other * golden];
            unit(from_each(|i| p[(i + k) % 3]))
        })
    };
    let points: Vec<[f64; 3]> = (0..3).nested(rectangle).collect();
    let dot = |a: usize, b: usize| -> f64 { (0..3).map(|k| points[a][k] * points[b][k]).sum() };
    let n = points.len();
    let mut triangles = Vec::new();
    for a in 0..n {
        for b in (a + 1..n).filter(|&b| dot(a, b) > NEAR) {
            for c in (b + 1..n).filter(|&c| dot(a, c) > NEAR && dot(b, c) > NEAR) {
                let corners = match faces_out([points[a], points[b], points[c]]) {
                    true => [a, b, c],
                    false => [a, c, b],
                };
                triangles.push(corners.map_each(|k| k as u32));
            }
        }
    }
    (points, triangles)
}

/// Whether a triangle is counterclockwise as seen from outside of a surface around the origin.
fn faces_out([a, b, c]: [[f64; 3]; 3]) -> bool {
    let [a, b, c] = [a, b, c].map_each(nalgebra::Vector3::from);
    a.cross(&b).dot(&c) > 0.0
}

/// Four triangles for each: the midpoints of its edges are moved to the unit sphere.
fn divided(triangles: &[[u32; 3]], points: &mut Vec<[f64; 3]>) -> Vec<[u32; 3]> {
    let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            let [one, other] = [a, b].map_each(|k| points[k as usize]);
            points.push(unit(from_each(|k| one[k] + other[k])));
            points.len() as u32 - 1
        })
    };
    let mut out = Vec::with_capacity(4 * triangles.len());
    for &[a, b, c] in triangles {
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        out.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    out
}

/// The upper half of an octahedron in rings, moved to the unit sphere, with a flat bottom.
pub(super) fn hemisphere(parameters: &[f64], left: usize) -> Made {
    let resolution = whole("the resolution", parameters[0], 0, 10)?;
    let rings = resolution + 1;
    fits(2 * rings * (rings + 1) + 2, left)?;
    let mut points = vec![[0.0, 0.0, 1.0]];
    for ring in 1..=rings {
        let height = (rings - ring) as f64;
        for k in 0..4 * ring {
            let (quarter, along) = (k / ring, (k % ring) as f64);
            let ring = ring as f64;
            let [x, y] = match quarter {
                0 => [ring - along, along],
                1 => [-along, ring - along],
                2 => [along - ring, -along],
                _ => [along, along - ring],
            };
            points.push(unit([x, y, height]));
        }
    }
    let bottom = points.len() as u32;
    points.push([0.0; 3]);
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for quarter in 0..4 {
            add_quarter(&mut triangles, ring, quarter);
        }
    }
    let border = 4 * rings as u32;
    let last = bottom - border;
    triangles.extend((0..border).map(|k| [last + k, bottom, last + (k + 1) % border]));
    Ok(surface(&points, Some(triangles)))
}

/// The triangles between a ring and the next one in a quarter of the turn.
fn add_quarter(triangles: &mut Vec<[u32; 3]>, ring: usize, quarter: usize) {
    let corner = |ring: usize, along: usize| match ring {
        0 => 0,
        _ => (1 + 2 * ring * (ring - 1) + (quarter * ring + along) % (4 * ring)) as u32,
    };
    for k in 0..=ring {
        let (inner, outer) = (corner(ring, k), ring + 1);
        let [near, far] = [k, k + 1].map_each(|k| corner(outer, k));
        triangles.push([inner, near, far]);
        if k < ring {
            triangles.push([inner, far, corner(ring, k + 1)]);
        }
    }
}
