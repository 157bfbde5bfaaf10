//! Sensors of links and joints, with their frames.

use super::reader::Reader;
use super::scene::FrameKind;
use crate::error::LoadError;
use crate::io::context::{Node, child, children};
use crate::io::sensors::{self, Carrier};

impl Reader<'_, '_, '_> {
    /// Reads the sensors of a link or joint. One with a pose, or on a joint, gets a frame `CARRIER/SENSOR`.
    ///
    /// * `frame` – of the link or joint
    pub(super) fn sensors(
        &mut self,
        node: Node<'_>,
        scope: usize,
        carrier: Carrier,
        frame: usize,
    ) -> Result<(), LoadError> {
        for sensor in children(node, "sensor") {
            let object = self.shared.scene.frames[frame].name.clone();
            let element = sensors::read(&mut self.context, sensor, carrier, &object)?;
            let has_own_frame = child(sensor, "pose").is_some() || carrier == Carrier::Joint;
            let own = match has_own_frame && element.is_modelled() {
                false => frame,
                true => {
                    let carrier = self.name(node)?;
                    let name = sensor.attribute("name").unwrap_or("sensor");
                    let pose = self.pose(sensor)?;
                    let kind = FrameKind::Free(Some(carrier.clone()));
                    let name = self.fresh_name(scope, format!("{carrier}/{name}"));
                    self.add_frame(sensor, scope, &name, kind, pose)?
                }
            };
            self.shared.scene.sensors.push((element, own));
        }
        Ok(())
    }

    /// The name, or the name with as many underscores as it takes to be new in a scope.
    fn fresh_name(&self, scope: usize, mut name: String) -> String {
        while self.shared.scene.models[scope].names.contains_key(&name) {
            name.push('_');
        }
        name
    }
}
