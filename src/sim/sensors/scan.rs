//! Directions of the rays of a scanning range finder.

use nalgebra::Vector3;

use crate::nested::IntoNested;
use crate::numbers::Domain;

/// Equally spaced angles of the rays of a [`Sensor::Lidar`](super::Sensor::Lidar).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanAngles {
    /// Number of rays.
    pub count: u32,
    /// Angle of the first ray, rad.
    pub first: f64,
    /// Angle of the last ray, rad; a single ray has the first.
    pub last: f64,
}

impl ScanAngles {
    /// A single ray at the angle 0.
    pub const ONE: Self = Self {
        count: 1,
        first: 0.0,
        last: 0.0,
    };

    /// The angles in their order.
    fn each(self) -> impl Iterator<Item = f64> + Clone {
        let gaps = f64::from(self.count.saturating_sub(1).max(1));
        let step = (self.last - self.first) / gaps;
        (0..self.count).map(move |k| self.first + step * f64::from(k))
    }

    /// # Panics
    /// If there is no ray, or an angle is not finite.
    pub(super) fn check(&self) {
        assert!(self.count > 0, "a scan has 0 rays, expected at least 1");
        for angle in [self.first, self.last] {
            Domain::Finite.check("angle of a scan", angle);
        }
    }
}

/// Unit vectors along all rays in the frame: for each elevation above its xy-plane those of all angles about z, from x.
pub(super) fn directions(
    horizontal: ScanAngles,
    vertical: ScanAngles,
) -> impl Iterator<Item = Vector3<f64>> {
    vertical.each().nested(move |elevation| {
        let (up, along) = elevation.sin_cos();
        horizontal.each().map(move |angle| {
            let (sin, cos) = angle.sin_cos();
            Vector3::new(along * cos, along * sin, up)
        })
    })
}

/// Number of rays.
pub(super) fn count(horizontal: ScanAngles, vertical: ScanAngles) -> usize {
    (horizontal.count as usize).saturating_mul(vertical.count as usize)
}
