//! Visuals and collisions as geoms.

use std::path::Path;

use super::{Writer, numbers, pose};
use crate::io::xml::Xml;
use crate::model::{Geometry, LinkSpec, ModelBuilder};
use crate::spatial::Transform;

/// Groups of geoms: the first three are shown by default.
const VISUAL_GROUP: &str = "1";
const COLLISION_GROUP: &str = "3";
/// File formats of meshes that `MuJoCo` reads.
const MESH_FORMATS: [&str; 3] = ["stl", "obj", "msh"];

/// The meshes that can be shown: file and scale.
pub(super) struct Meshes(Vec<(String, String)>);

impl Meshes {
    pub(super) fn of(builder: &ModelBuilder) -> Self {
        let mut meshes = Vec::new();
        for link in builder.links() {
            let visuals = link.visuals().iter().map(|visual| &visual.geometry);
            let collisions = link
                .collisions()
                .iter()
                .map(|collision| &collision.geometry);
            for mesh in visuals.chain(collisions).filter_map(asset) {
                if !meshes.contains(&mesh) {
                    meshes.push(mesh);
                }
            }
        }
        Self(meshes)
    }

    pub(super) fn write(&self, xml: &mut Xml) {
        if self.0.is_empty() {
            return;
        }
        xml.start("asset", &[]);
        for (i, (file, scale)) in self.0.iter().enumerate() {
            xml.leaf(
                "mesh",
                &[("name", &name(i)), ("file", file), ("scale", scale)],
            );
        }
        xml.end();
    }

    fn find(&self, geometry: &Geometry) -> Option<String> {
        let mesh = asset(geometry)?;
        self.0.iter().position(|known| *known == mesh).map(name)
    }
}

fn name(i: usize) -> String {
    format!("mesh_{i}")
}

fn asset(geometry: &Geometry) -> Option<(String, String)> {
    let Geometry::Mesh {
        path: Some(path),
        scale,
        ..
    } = geometry
    else {
        return None;
    };
    let is_read = |path: &Path| {
        let extension = path.extension()?.to_str()?.to_lowercase();
        MESH_FORMATS.contains(&extension.as_str()).then_some(())
    };
    is_read(path)?;
    let file = std::path::absolute(path).unwrap_or_else(|_| path.clone());
    Some((file.to_str()?.to_owned(), numbers(scale)))
}

impl Writer<'_> {
    pub(super) fn shapes(&mut self, link: &LinkSpec) {
        for visual in link.visuals() {
            let color = visual.color.map(|color| ("rgba", numbers(&color)));
            self.geom(VISUAL_GROUP, &visual.placement, &visual.geometry, color);
        }
        for collision in link.collisions() {
            self.geom(
                COLLISION_GROUP,
                &collision.placement,
                &collision.geometry,
                None,
            );
        }
    }

    fn geom(
        &mut self,
        group: &str,
        placement: &Transform<f64>,
        geometry: &Geometry,
        color: Option<(&'static str, String)>,
    ) {
        let (kind, size) = half_lengths(geometry);
        let shape = match (geometry, self.meshes.find(geometry)) {
            (_, Some(mesh)) => ("mesh", mesh),
            (Geometry::Mesh { uri, .. }, None) => {
                self.xml.comment(&format!("left out: mesh {uri}"));
                return;
            }
            _ if size.iter().any(|&length| length <= 0.0) => {
                let size = numbers(&size);
                self.xml
                    .comment(&format!("left out: {kind} of size {size}"));
                return;
            }
            _ => ("size", numbers(&size)),
        };
        let mut attributes = vec![
            ("type", kind.to_owned()),
            ("group", group.to_owned()),
            shape,
        ];
        attributes.extend(pose(placement));
        attributes.extend(color);
        self.leaf("geom", &attributes);
    }
}

/// The type of a shape in `MuJoCo`, which gives radii and half lengths.
fn half_lengths(geometry: &Geometry) -> (&'static str, Vec<f64>) {
    match geometry {
        Geometry::Box { size } => ("box", size.map(|length| length / 2.0).to_vec()),
        Geometry::Sphere { radius } => ("sphere", vec![*radius]),
        Geometry::Cylinder { radius, length } => ("cylinder", vec![*radius, length / 2.0]),
        Geometry::Capsule { radius, length } => ("capsule", vec![*radius, length / 2.0]),
        Geometry::Mesh { .. } => ("mesh", Vec::new()),
    }
}
