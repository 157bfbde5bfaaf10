//! The camera of a picture.

use nalgebra::{Matrix3, Vector3};

use super::PictureOptions;
use super::raster::Lens;
use crate::view::camera::Camera;

/// Angle of the picture from its lower to its upper edge, rad; that of the HTML viewer.
const FIELD_OF_VIEW: f64 = 40.0 * std::f64::consts::PI / 180.0;

/// Part of the picture that robots may fill.
const FILLED: f64 = 0.88;

/// Distance of the nearest points that are drawn, in distances of the camera.
const NEAREST: f64 = 0.02;

/// Distances of the camera that are taken, m.
const DISTANCES: [f64; 2] = [1e-3, 1e5];

/// Default position of the camera of the HTML viewer, degrees.
const AZIMUTH: f64 = 30.0;
const ELEVATION: f64 = 18.0;

/// Place and direction of a camera.
#[derive(Clone, Debug)]
pub(super) struct Eye {
    position: Vector3<f64>,
    /// Rows to the right, down, and forward.
    axes: Matrix3<f64>,
    distance: f64,
}

impl Eye {
    pub(super) fn new(camera: Camera) -> Self {
        let distance = camera.distance.clamp(DISTANCES[0], DISTANCES[1]);
        let axes = axes(camera.azimuth, camera.elevation);
        let forward = axes.row(2).transpose();
        Self {
            position: Vector3::from(camera.look_at) - forward * distance,
            axes,
            distance,
        }
    }

    /// The camera that has a box just in the picture: each corner is within the four planes of the view.
    pub(super) fn around([low, high]: [Vector3<f64>; 2], options: PictureOptions) -> Self {
        let axes = axes(AZIMUTH, ELEVATION);
        let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
        let t = (FIELD_OF_VIEW / 2.0).tan() * FILLED;
        let aspect = f64::from(options.width) / f64::from(options.height);
        let needed = (0..8).map(|corner| {
            let sign = |axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
            let from = axes * Vector3::from_fn(|axis, _| sign(axis) * half[axis]);
            (from.x.abs() / (t * aspect)).max(from.y.abs() / t) - from.z
        });
        let distance = needed.fold(DISTANCES[0], f64::max);
        Self::new(Camera {
            look_at: middle.into(),
            distance,
            azimuth: AZIMUTH,
            elevation: ELEVATION,
        })
    }

    /// A point of the world as the camera sees it: to the right, down, and ahead, m.
    pub(super) fn sees(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.axes * (point - self.position)
    }

    /// Position of the camera, m.
    pub(super) fn position(&self) -> &Vector3<f64> {
        &self.position
    }

    /// The picture of so many samples along each row, and rows.
    pub(super) fn lens(&self, size: [usize; 2]) -> Lens {
        Lens {
            size,
            focal_length: 0.5 * size[1] as f64 / (FIELD_OF_VIEW / 2.0).tan(),
            near: NEAREST * self.distance,
        }
    }
}

/// Rows to the right, down and forward of a camera in a direction from what it looks at, degrees.
fn axes(azimuth: f64, elevation: f64) -> Matrix3<f64> {
    /// From straight above left and right are not known.
    const STEEPEST: f64 = 89.0;
    let (a, e) = (
        azimuth.to_radians(),
        elevation.clamp(-STEEPEST, STEEPEST).to_radians(),
    );
    let back = Vector3::new(e.cos() * a.cos(), e.cos() * a.sin(), e.sin());
    let right = Vector3::z().cross(&back).normalize();
    let up = back.cross(&right);
    Matrix3::from_rows(&[right.transpose(), -up.transpose(), -back.transpose()])
}
