//! Camera of the HTML viewer or a picture.

use serde::{Deserialize, Serialize};

/// Camera of the HTML viewer or a picture: target point and direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// The point in the middle of the picture, m.
    pub look_at: [f64; 3],
    /// Distance from it, m.
    pub distance: f64,
    /// Azimuth of the camera as seen from that point: from x towards y, degrees.
    pub azimuth: f64,
    /// Elevation of the camera as seen from that point: upwards from the xy plane, degrees.
    pub elevation: f64,
}

impl Camera {
    pub(super) fn is_finite(&self) -> bool {
        let others = [self.distance, self.azimuth, self.elevation];
        self.look_at.iter().chain(&others).all(|x| x.is_finite())
    }
}
