//! Fixed scene objects: obstacles, goals, walls.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::ground::Heights;
use super::meshes::{Meshes, Piece};
use super::shape::{Pose, Shape, pose};
use crate::model::{Geometry, UpAxis};
use crate::spatial::Transform;

/// A fixed object in the display, without effect on the motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneObject {
    /// Display name of the object.
    pub name: String,
    /// Pose of the object in the world.
    #[serde(with = "entries")]
    pub placement: Transform<f64>,
    /// Appearance of the object.
    #[serde(rename = "look")]
    pub appearance: Appearance,
}

/// Appearance of a [`SceneObject`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase")]
#[non_exhaustive]
pub enum Appearance {
    /// The axes of its placement: x red, y green, z blue.
    Axes,
    /// A ground: heights above the placement's xy plane.
    Ground(Heights),
    /// A shape.
    Solid {
        /// The shape, centred at the placement.
        #[serde(with = "StoredGeometry")]
        geometry: Geometry,
        /// Red, green, blue, opacity in 0..1.
        color: [f64; 4],
    },
}

impl Appearance {
    pub(super) fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Axes => Vec::new(),
            Self::Ground(heights) => heights.numbers(),
            Self::Solid { geometry, color } => {
                let size = match geometry {
                    Geometry::Mesh { scale, .. } => *scale,
                    _ => Piece::of(geometry).size,
                };
                [&size[..], color].concat()
            }
        }
    }
}

/// A scene object as drawn by the viewers.
#[derive(Debug, Serialize)]
pub(super) struct Scenery<'a> {
    pub(super) name: &'a str,
    pub(super) axes: Option<Pose>,
    /// Whether robots stand on it: then it does not count for what is to be seen.
    pub(super) is_ground: bool,
    /// Height of level ground, which the viewer draws as its floor.
    pub(super) level: Option<f64>,
    /// Shapes at their poses in the world.
    pub(super) shapes: Vec<Shape>,
}

impl SceneObject {
    /// Flaw of an object from a file, where every number is finite; `None` if it has none.
    pub(super) fn flaw(&self) -> Option<&'static str> {
        match &self.appearance {
            Appearance::Ground(heights) => heights.flaw(),
            Appearance::Axes | Appearance::Solid { .. } => None,
        }
    }

    /// Changes the path of its mesh, if it has one.
    pub(super) fn move_mesh(&mut self, moved: impl FnOnce(&Path) -> PathBuf) {
        if let Appearance::Solid {
            geometry: Geometry::Mesh {
                path: Some(path), ..
            },
            ..
        } = &mut self.appearance
        {
            *path = moved(path);
        }
    }

    pub(super) fn scenery(&self, meshes: &mut Meshes) -> Scenery<'_> {
        let (mut axes, mut level, mut is_ground, mut shapes) = (None, None, false, Vec::new());
        match &self.appearance {
            Appearance::Axes => axes = Some(pose(&self.placement)),
            Appearance::Solid { geometry, color } => shapes = self.shapes(geometry, *color, meshes),
            Appearance::Ground(heights) => {
                is_ground = true;
                level = heights.level().map(|z| z + self.placement.translation.z);
                shapes.extend(
                    level
                        .is_none()
                        .then(|| heights.shape(&self.placement, meshes)),
                );
            }
        }
        Scenery {
            name: &self.name,
            axes,
            is_ground,
            level,
            shapes,
        }
    }

    fn shapes(&self, geometry: &Geometry, color: [f64; 4], meshes: &mut Meshes) -> Vec<Shape> {
        let pieces = meshes.pieces(&format!("\"{}\"", self.name), geometry);
        let shapes = pieces.into_iter().map(|(X, piece, _)| Shape {
            body: None,
            pose: pose(&(self.placement * X)),
            color: Some(color),
            piece,
        });
        shapes.collect()
    }
}

/// [`Geometry`] in a file.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Geometry", deny_unknown_fields, rename_all = "lowercase")]
enum StoredGeometry {
    Box {
        size: [f64; 3],
    },
    Cylinder {
        radius: f64,
        length: f64,
    },
    Capsule {
        radius: f64,
        length: f64,
    },
    Sphere {
        radius: f64,
    },
    Ellipsoid {
        size: [f64; 3],
    },
    Mesh {
        uri: String,
        #[serde(serialize_with = "as_text")]
        path: Option<PathBuf>,
        scale: [f64; 3],
        #[serde(default)]
        up_axis: UpAxis,
    },
}

/// A path that is not a text loses what is none.
fn as_text<S: Serializer>(path: &Option<PathBuf>, out: S) -> Result<S::Ok, S::Error> {
    let text = path.as_ref().map(|path| path.to_string_lossy());
    text.serialize(out)
}

/// A transform as its rotation row by row, then its translation.
mod entries {
    use super::{Deserialize, Deserializer, Serialize, Serializer, Transform};

    pub(super) fn serialize<S: Serializer>(X: &Transform<f64>, out: S) -> Result<S::Ok, S::Error> {
        X.to_entries().serialize(out)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        source: D,
    ) -> Result<Transform<f64>, D::Error> {
        Ok(Transform::from_entries(Deserialize::deserialize(source)?))
    }
}
