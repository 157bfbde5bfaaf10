//! Volume or area of shapes, and moments of inertia per kg: of solids, and of thin shells of even thickness.

use std::f64::consts::PI;

use crate::model::{Geometry, Mass};
use crate::scalar::{MapEach, from_each};

/// Exponent of Thomsen's formula for the area of an ellipsoid, with an error of 1 % at most.
const THOMSEN: f64 = 1.6075;

/// Amount of material of a shape, m³ or m², and its principal moments per kg about its centre, m².
#[derive(Clone, Copy, Debug)]
pub(super) struct Distribution {
    pub(super) measure: f64,
    pub(super) moments: [f64; 3],
}

/// The distribution of a shape's mass in its volume; `None` for meshes.
pub(super) fn solid(shape: &Geometry) -> Option<Distribution> {
    let inertia = shape.inertia(Mass::Kilograms(1.0))?.rotational;
    Some(Distribution {
        measure: shape.volume()?,
        moments: [inertia.xx, inertia.yy, inertia.zz],
    })
}

/// The distribution of a shape's mass in its surface, ends included; `None` for meshes.
pub(super) fn shell(shape: &Geometry) -> Option<Distribution> {
    Some(match *shape {
        Geometry::Sphere { radius: r } => Distribution {
            measure: 4.0 * PI * r * r,
            moments: [2.0 / 3.0 * r * r; 3],
        },
        Geometry::Box { size } => box_shell(size),
        Geometry::Cylinder { radius, length } => cylinder_shell(radius, length),
        Geometry::Capsule { radius, length } => capsule_shell(radius, length),
        Geometry::Ellipsoid { size } => ellipsoid_shell(size.map_each(|x| 0.5 * x)),
        Geometry::Mesh { .. } => return None,
    })
}

/// The distribution of the mass of the shell of an ellipsoid with half axes a, b, c, as the solid's changes where all half axes grow alike.
fn ellipsoid_shell([a, b, c]: [f64; 3]) -> Distribution {
    let products = [a * b, a * c, b * c];
    let mean = products.map_each(|x| x.powf(THOMSEN)).iter().sum::<f64>() / 3.0;
    // J = V (b² + c²) / 5 with V = k a b c, so that dJ / dV = (b² + c²) / 5 + 2 (b + c) / 5 · V / V'.
    let growth = a * b * c / products.iter().sum::<f64>();
    let [a2, b2, c2] = [a * a, b * b, c * c];
    let solid = [b2 + c2, a2 + c2, a2 + b2].map_each(|x| x / 5.0);
    let grown = [b + c, a + c, a + b].map_each(|x| 2.0 / 5.0 * x * growth);
    Distribution {
        measure: 4.0 * PI * mean.powf(1.0 / THOMSEN),
        moments: from_each(|i| solid[i] + grown[i]),
    }
}

/// Three pairs of plates.
fn box_shell(size: [f64; 3]) -> Distribution {
    let [x, y, z] = size;
    let pairs = [2.0 * y * z, 2.0 * x * z, 2.0 * x * y];
    let area: f64 = pairs.iter().sum();
    let moments = from_each(|axis| {
        // Mean square of the distance along each axis: L² / 12 in a plate, L² / 4 on the pair across it.
        let square = |along: usize| {
            let l2 = size[along] * size[along];
            let of_pair = |k: usize| pairs[k] * l2 / if k == along { 4.0 } else { 12.0 };
            (0..3).map(of_pair).sum::<f64>()
        };
        (0..3).filter(|&k| k != axis).map(square).sum::<f64>() / area
    });
    Distribution {
        measure: area,
        moments,
    }
}

/// A tube with two discs.
fn cylinder_shell(r: f64, h: f64) -> Distribution {
    let (tube, discs) = (2.0 * PI * r * h, 2.0 * PI * r * r);
    let across = tube * (r * r / 2.0 + h * h / 12.0) + discs * (r * r + h * h) / 4.0;
    let along = tube * r * r + discs * r * r / 2.0;
    mean(tube + discs, [across, along])
}

/// A tube with two half spheres, whose centres of mass are r / 2 beyond its ends.
fn capsule_shell(r: f64, h: f64) -> Distribution {
    let (tube, sphere) = (2.0 * PI * r * h, 4.0 * PI * r * r);
    let arm = (h + r) / 2.0;
    let ends = 5.0 / 12.0 * r * r + arm * arm;
    let across = tube * (r * r / 2.0 + h * h / 12.0) + sphere * ends;
    let along = tube * r * r + sphere * 2.0 / 3.0 * r * r;
    mean(tube + sphere, [across, along])
}

/// Moments across and along z, of an area.
fn mean(area: f64, [across, along]: [f64; 2]) -> Distribution {
    Distribution {
        measure: area,
        moments: [across / area, across / area, along / area],
    }
}
