//! Directions spread over the sphere.

use std::f64::consts::PI;

use nalgebra::Vector3;

use crate::nested::IntoNested;

/// The axes both ways, and so many unit vectors spread evenly: on a spiral that turns by the golden angle, at heights of equal areas.
pub(super) fn directions(count: usize) -> Vec<Vector3<f64>> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let spiral = (0..count).map(|k| {
        let z = 1.0 - (2 * k + 1) as f64 / count as f64;
        let (sin, cos) = (golden * k as f64).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        Vector3::new(radius * cos, radius * sin, z)
    });
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let axes = axes.into_iter().nested(|axis| [axis, -axis]);
    axes.chain(spiral).collect()
}
