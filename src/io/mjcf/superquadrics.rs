//! Superquadrics of triangles: spheres and tori whose circles have other powers.

use std::f64::consts::{FRAC_PI_2, PI};

use super::builtin_surface::{MOST_VERTICES, Made, fits, surface, whole, within};
use crate::scalar::MapEach;

/// |x|^power with the sign of x.
fn power(x: f64, power: f64) -> f64 {
    match x {
        0.0 => 0.0,
        _ => x.abs().powf(power).copysign(x),
    }
}

/// A superquadric: rings of latitude between two poles.
pub(super) fn supersphere(parameters: &[f64], left: usize) -> Made {
    let n = whole("the resolution", parameters[0], 3, MOST_VERTICES)?;
    let [east, north] = [parameters[1], parameters[2]];
    let east = within("e", east, east >= 0.0, "at least 0")?;
    let north = within("n", north, north >= 0.0, "at least 0")?;
    fits((n - 1).saturating_mul(n) + 2, left)?;
    let mut points = vec![[0.0, 0.0, -1.0]];
    for ring in 1..n {
        let latitude = PI * ring as f64 / n as f64 - FRAC_PI_2;
        let [radius, z] = [latitude.cos(), latitude.sin()].map_each(|x| power(x, north));
        points.extend((0..n).map(|k| {
            let longitude = 2.0 * PI * k as f64 / n as f64 - PI;
            let [x, y] = [longitude.cos(), longitude.sin()].map_each(|x| power(x, east));
            [radius * x, radius * y, z]
        }));
    }
    points.push([0.0, 0.0, 1.0]);
    let corner = |ring: usize, k: usize| (1 + (ring - 1) * n + k % n) as u32;
    let top = points.len() as u32 - 1;
    let mut triangles = Vec::new();
    for k in 0..n {
        triangles.push([0, corner(1, k + 1), corner(1, k)]);
        triangles.push([corner(n - 1, k), corner(n - 1, k + 1), top]);
        for ring in 1..n - 1 {
            let low = [k, k + 1].map_each(|k| corner(ring, k));
            let high = [k, k + 1].map_each(|k| corner(ring + 1, k));
            add_square(&mut triangles, [low[0], low[1], high[0], high[1]]);
        }
    }
    Ok(surface(&points, Some(triangles)))
}

/// A torus of radius 1 whose tube and path are superquadrics.
pub(super) fn supertorus(parameters: &[f64], left: usize) -> Made {
    let n = whole("the resolution", parameters[0], 3, MOST_VERTICES)?;
    let [radius, tube, path] = [parameters[1], parameters[2], parameters[3]];
    let is_radius = radius > 0.0 && radius <= 1.0;
    let radius = within("the radius", radius, is_radius, "in (0, 1]")?;
    let tube = within("s", tube, tube > 0.0, "positive")?;
    let path = within("t", path, path > 0.0, "positive")?;
    fits(n.saturating_mul(n), left)?;
    let angle = |k: usize| 2.0 * PI * k as f64 / n as f64;
    let on_path = |k: usize| [angle(k).cos(), angle(k).sin()].map_each(|x| power(x, path));
    let mut points = Vec::with_capacity(n * n);
    let mut triangles = Vec::new();
    let corner = |u: usize, v: usize| ((u % n) * n + v % n) as u32;
    for u in 0..n {
        let [x, y] = on_path(u);
        for v in 0..n {
            let [out, up] = [angle(v).cos(), angle(v).sin()].map_each(|x| power(x, tube));
            let distance = 1.0 + radius * out;
            points.push([distance * x, distance * y, radius * up]);
            let square = [
                corner(u, v),
                corner(u + 1, v),
                corner(u, v + 1),
                corner(u + 1, v + 1),
            ];
            add_square(&mut triangles, square);
        }
    }
    Ok(surface(&points, Some(triangles)))
}

/// The two triangles of a square of the corners near, near right, far, far right.
fn add_square(triangles: &mut Vec<[u32; 3]>, [a, b, c, d]: [u32; 4]) {
    triangles.extend([[a, b, c], [b, d, c]]);
}
