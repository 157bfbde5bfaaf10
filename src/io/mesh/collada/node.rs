//! Nodes of the scene: their poses, their shapes and their children.

use nalgebra::{Matrix4, Rotation3, Unit, Vector3};

use super::numbers;
use crate::input::xml::{Node, is_native, tag};

/// A `<node>`, or the `<visual_scene>` above them.
pub(super) struct SceneNode<'a> {
    /// The map from its coordinates to those of its parent.
    pub(super) placement: Matrix4<f64>,
    /// The elements below it that show something: nodes, and instances of nodes, geometries and controllers.
    pub(super) content: Vec<Node<'a>>,
    /// Whether an unread element places it.
    pub(super) is_approximate: bool,
}

/// Reads a node: its transforms apply from the last to the first.
pub(super) fn read(node: Node<'_>) -> Result<SceneNode<'_>, String> {
    let mut read = SceneNode {
        placement: Matrix4::identity(),
        content: Vec::new(),
        is_approximate: false,
    };
    for element in node
        .children()
        .filter(|node| node.is_element() && is_native(*node))
    {
        match tag(element) {
            "node" | "instance_node" | "instance_geometry" | "instance_controller" => {
                read.content.push(element);
            }
            "lookat" | "skew" => read.is_approximate = true,
            _ => {
                if let Some(transform) = transform(element)? {
                    read.placement *= transform;
                }
            }
        }
    }
    Ok(read)
}

fn transform(element: Node<'_>) -> Result<Option<Matrix4<f64>>, String> {
    Ok(Some(match tag(element) {
        "matrix" => Matrix4::from_row_slice(&numbers::<16>(element)?),
        "translate" => Matrix4::new_translation(&numbers::<3>(element)?.into()),
        "scale" => Matrix4::new_nonuniform_scaling(&numbers::<3>(element)?.into()),
        "rotate" => {
            let [x, y, z, degrees] = numbers::<4>(element)?;
            let axis = Unit::try_new(Vector3::new(x, y, z), 0.0);
            let turned = |axis| Rotation3::from_axis_angle(&axis, degrees.to_radians());
            axis.map_or(Matrix4::identity(), |axis| turned(axis).to_homogeneous())
        }
        _ => return Ok(None),
    }))
}
