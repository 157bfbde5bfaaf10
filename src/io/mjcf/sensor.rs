//! Sensors, which are listed and not computed.

use super::scene::MjcfSensor;
use super::walk::Part;
use crate::io::context::Context;

/// Attributes that name the object of a sensor.
const OBJECTS: [&str; 8] = [
    "joint", "site", "objname", "body", "geom", "actuator", "tendon", "camera",
];

/// Lists a sensor.
pub(super) fn read(part: &Part<'_, '_>, context: &mut Context<'_>) -> MjcfSensor {
    let entry = part.plain();
    let object = OBJECTS.iter().find_map(|name| entry.text(name));
    entry.node.read_all();
    let reason = "sensors are not computed; kept in MjcfScene::sensors";
    context.ignore(&entry.node.place(), reason);
    MjcfSensor {
        name: part.name().unwrap_or_default(),
        kind: entry.node.tag().into(),
        object: object.map(|name| part.naming.of(name)).unwrap_or_default(),
    }
}
