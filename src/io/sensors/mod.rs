//! Sensors of files: what the formats share, and the `<sensor>` of SDF, which Gazebo's settings in a URDF have too.
//!
//! | `type` | becomes |
//! |---|---|
//! | `imu` | a gyroscope `NAME/gyro` and an accelerometer `NAME/accelerometer` |
//! | `force_torque` | [`Sensor::Wrench`] |
//! | `contact` | [`Sensor::ContactForce`] |
//! | `ray`, `gpu_ray`, `lidar`, `gpu_lidar` | [`Sensor::RangeFinder`] with one ray, otherwise [`Sensor::Lidar`] |
//! | `magnetometer` | [`Sensor::Magnetometer`] |
//! | `altimeter` | [`Sensor::FramePose`] `NAME/position` and [`Sensor::FrameVelocity`] `NAME/velocity` |

mod element;
mod noise;

use std::collections::HashSet;

use super::names::Names;
use crate::model::Model;
use crate::sim::{Sensor, SensorNoise, Sensors};
pub(super) use element::{Carrier, SensorElement, read};

/// A sensor of a file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ImportedSensor {
    /// Its name; empty without.
    pub name: String,
    /// Its element in an MJCF, such as `framepos`; its type in an SDF, such as `imu`.
    pub kind: String,
    /// Name of the object that carries it; empty without.
    pub object: String,
    /// The corresponding sensor, which may have more readings: position with orientation, force with torque, linear with angular. `None` if it is not modelled.
    pub sensor: Option<Sensor>,
    /// Noise, resolution, limit, period and delay.
    pub noise: SensorNoise,
}

/// Names of the sensors that are modelled, with their indices: those of the file, and for sensors without a name, or with a taken one, kind and index, as in
/// `gyro 3`.
fn names(all: &[ImportedSensor]) -> impl Iterator<Item = (usize, String)> {
    let named = all.iter().map(|own| own.name.as_str());
    let mut names = Names::of(named.filter(|name| !name.is_empty()));
    let mut taken = HashSet::new();
    let modelled = all.iter().enumerate();
    let modelled = modelled.filter(|(_, own)| own.sensor.is_some());
    modelled.map(move |(k, own)| {
        let name = match !own.name.is_empty() && taken.insert(own.name.as_str()) {
            true => own.name.clone(),
            false => names.fresh(format!("{} {k}", own.kind)),
        };
        (k, name)
    })
}

/// The sensors, those that are modelled with [names] of their own.
pub(super) fn with_names(mut all: Vec<ImportedSensor>) -> Vec<ImportedSensor> {
    let names: Vec<(usize, String)> = names(&all).collect();
    for (k, name) in names {
        all[k].name = name;
    }
    all
}

/// The sensors of a model that are modelled, by their [names].
pub(super) fn known(all: &[ImportedSensor], model: &Model) -> Sensors {
    let own = names(all).filter_map(|(k, name)| Some((name, all[k].sensor?)));
    Sensors::new(model, own)
}
