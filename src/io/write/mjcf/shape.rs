//! Visuals and collisions as geoms.

use super::mesh::Collides;
use super::{Writer, numbers, pose};
use crate::model::{Geometry, LinkSpec, short_reference};
use crate::scalar::MapEach;
use crate::spatial::Transform;

/// Groups of geoms: the first three are shown by default.
const VISUAL_GROUP: &str = "1";
const COLLISION_GROUP: &str = "3";
/// A pair of geoms touches where the type of one has a bit in common with the affinity of the other. Those of the robot
/// have no affinity, so that they touch what is put around the robot (by default, of type and affinity 1), not one
/// another: as contact points do here.
const COLLISION_TYPE: &str = "1";
impl Writer<'_> {
    pub(super) fn shapes(&mut self, link: &LinkSpec) {
        for visual in &link.visuals {
            let mut attributes = vec![("group", VISUAL_GROUP.to_owned())];
            attributes.extend(visual.color.map(|color| ("rgba", numbers(&color))));
            self.geom(&visual.placement, &visual.geometry, attributes);
        }
        for collision in &link.collisions {
            let mut attributes = vec![("group", COLLISION_GROUP.to_owned())];
            match self.meshes.collides(&collision.geometry) {
                Collides::Yes => attributes.push(("contype", COLLISION_TYPE.to_owned())),
                Collides::No(reason) => self
                    .xml
                    .comment(&format!("the next geom does not collide: {reason}")),
            }
            self.geom(&collision.placement, &collision.geometry, attributes);
        }
    }

    fn geom(
        &mut self,
        placement: &Transform<f64>,
        geometry: &Geometry,
        others: Vec<(&'static str, String)>,
    ) {
        let (kind, size) = half_lengths(geometry);
        let shape = match geometry {
            Geometry::Mesh { uri, .. } => match self.meshes.find(geometry) {
                Ok(mesh) => ("mesh", mesh),
                Err(reason) => {
                    let uri = short_reference(uri);
                    self.xml.comment(&format!("left out: mesh {uri}: {reason}"));
                    return;
                }
            },
            _ if size.iter().any(|&length| length <= 0.0) => {
                let size = numbers(&size);
                self.xml
                    .comment(&format!("left out: {kind} of size {size}"));
                return;
            }
            _ => ("size", numbers(&size)),
        };
        let mut attributes = vec![("type", kind.to_owned()), shape];
        attributes.extend(pose(placement));
        attributes.extend(others);
        self.xml.leaf("geom", &attributes);
    }
}

/// The type of a shape in `MuJoCo`, which gives radii and half lengths.
fn half_lengths(geometry: &Geometry) -> (&'static str, Vec<f64>) {
    match geometry {
        Geometry::Box { size } => ("box", size.map_each(|length| length / 2.0).to_vec()),
        Geometry::Ellipsoid { size } => ("ellipsoid", size.map_each(|x| x / 2.0).to_vec()),
        Geometry::Sphere { radius } => ("sphere", vec![*radius]),
        Geometry::Cylinder { radius, length } => ("cylinder", vec![*radius, length / 2.0]),
        Geometry::Capsule { radius, length } => ("capsule", vec![*radius, length / 2.0]),
        Geometry::Mesh { .. } => ("mesh", Vec::new()),
    }
}
