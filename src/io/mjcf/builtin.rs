//! Surfaces that the format makes of parameters: `builtin` and `params` of meshes.
//!
//! # References
//! The attribute `builtin` in the XML reference of `MuJoCo`; vertices and triangles were measured with its library 4.0.0.

use std::f64::consts::PI;

use super::builtin_spheres::{hemisphere, sphere};
use super::builtin_surface::{MOST_VERTICES, Made, Surface, fits, surface, whole, within};
use super::entry::Entry;
use super::superquadrics::{supersphere, supertorus};
use crate::error::LoadError;
use crate::nested::IntoNested;

/// Number of parameters, and the surface that they make.
type Builtin = (usize, fn(&[f64], usize) -> Made);

const BUILTINS: [(&str, Option<Builtin>); 8] = [
    ("none", None),
    ("sphere", Some((1, sphere))),
    ("hemisphere", Some((1, hemisphere))),
    ("cone", Some((2, cone))),
    ("supersphere", Some((3, supersphere))),
    ("supertorus", Some((4, supertorus))),
    ("wedge", Some((5, wedge))),
    ("plate", Some((2, plate))),
];

/// The surface of a mesh, if its element has parameters of one.
///
/// * `made` – vertices that were made before
pub(super) fn read(entry: &Entry<'_, '_>, made: &mut usize) -> Result<Option<Surface>, LoadError> {
    let Some((count, make)) = entry.word("builtin", &BUILTINS)?.flatten() else {
        return Ok(None);
    };
    if entry.text("file").is_some() || entry.text("vertex").is_some() {
        return Err(entry.malformed("builtin", "is given together with file or vertex"));
    }
    let parameters = entry.list("params", count)?;
    let parameters = parameters.ok_or_else(|| entry.missing("params"))?;
    if parameters.len() != count {
        return Err(entry.malformed("params", &format!("expected {count} numbers")));
    }
    let left = MOST_VERTICES - *made;
    let surface = make(&parameters, left);
    let surface = surface.map_err(|reason| entry.malformed("params", &reason))?;
    *made += surface.vertices.len();
    Ok(Some(surface))
}

/// A pyramid or its stump from z = -1 to 1: corners of a circle of radius 1, and of a smaller one.
fn cone(parameters: &[f64], left: usize) -> Made {
    let corners = whole("the number of corners", parameters[0], 3, MOST_VERTICES)?;
    let radius = parameters[1];
    let radius = within(
        "the radius",
        radius,
        (0.0..=1.0).contains(&radius),
        "in [0, 1]",
    )?;
    fits(2 * corners, left)?;
    let circle = |radius: f64, z: f64| {
        let angles = (0..corners).map(move |k| 2.0 * PI * k as f64 / corners as f64);
        angles.map(move |angle| [radius * angle.cos(), radius * angle.sin(), z])
    };
    let mut points: Vec<[f64; 3]> = circle(1.0, -1.0).collect();
    match radius {
        0.0 => points.push([0.0, 0.0, 1.0]),
        _ => points.extend(circle(radius, 1.0)),
    }
    Ok(surface(&points, None))
}

/// A part of the unit sphere about -z, seen from its middle: a grid of angles, finer in its middle.
fn wedge(parameters: &[f64], left: usize) -> Made {
    let columns = whole("the first resolution", parameters[0], 1, MOST_VERTICES)?;
    let rows = whole("the second resolution", parameters[1], 1, MOST_VERTICES)?;
    let [wide, high, fovea] = [parameters[2], parameters[3], parameters[4]];
    let wide = within(
        "the first angle",
        wide,
        wide > 0.0 && wide <= 180.0,
        "in (0, 180]",
    )?;
    let high = within(
        "the second angle",
        high,
        high > 0.0 && high <= 90.0,
        "in (0, 90]",
    )?;
    let fovea = within("gamma", fovea, (0.0..=1.0).contains(&fovea), "in [0, 1]")?;
    fits(columns.saturating_mul(rows), left)?;
    let edge = |k: usize, n: usize| {
        let x = 2.0 * k as f64 / n as f64 - 1.0;
        fovea * x.powi(5) + (1.0 - fovea) * x
    };
    let middle = |k: usize, n: usize, most: f64| {
        let x = 0.5 * (edge(k, n) + edge(k + 1, n));
        (x * most).to_radians().sin_cos()
    };
    let points = (0..columns).nested(|i| {
        let (across, ahead) = middle(i, columns, wide);
        (0..rows).map(move |k| {
            let (up, level) = middle(k, rows, high);
            [across * level, up, -ahead * level]
        })
    });
    let points: Vec<[f64; 3]> = points.collect();
    Ok(surface(&points, None))
}

/// A grid of the middles of the cells of a square in the plane of y and z.
fn plate(parameters: &[f64], left: usize) -> Made {
    let columns = whole("the first resolution", parameters[0], 1, MOST_VERTICES)?;
    let rows = whole("the second resolution", parameters[1], 1, MOST_VERTICES)?;
    fits(columns.saturating_mul(rows), left)?;
    let middle = |k: usize, n: usize| 1.0 - (2 * k + 1) as f64 / n as f64;
    let points = (0..columns).nested(|i| {
        let y = middle(i, columns);
        (0..rows).map(move |k| [0.0, y, middle(k, rows)])
    });
    let points: Vec<[f64; 3]> = points.collect();
    Ok(surface(&points, None))
}
