//! Placement of a file in the world: its unit and its up axis.

use nalgebra::{Matrix3, Matrix4, matrix};

use crate::input::xml::{Node, child, children};
use crate::io::mesh::soup::Soup;
use crate::model::UpAxis;

/// Name that the library of `MeshLab` gives itself; it states `Y_UP` in every file.
const STATES_Y_ALWAYS: &str = "VCGLib";

/// The map from the coordinates of a file to metres with z up. Remarks on another axis that the file calls up.
pub(super) fn placement(
    root: Node<'_>,
    up_axis: UpAxis,
    soup: &mut Soup,
) -> Result<Matrix4<f64>, String> {
    let Some(asset) = child(root, "asset") else {
        return Ok(Matrix4::identity());
    };
    let placement = upright(asset, up_axis, soup) * unit(asset)?;
    Ok(placement.to_homogeneous())
}

/// The unit of length, m.
fn unit(asset: Node<'_>) -> Result<f64, String> {
    let meters = child(asset, "unit").and_then(|unit| unit.attribute("meter"));
    let Some(text) = meters else { return Ok(1.0) };
    let meters = super::number(text.trim()).filter(|&m: &f64| m > 0.0 && m.is_finite());
    meters.ok_or_else(|| "has a unit of length that is not a positive number".into())
}

/// The rotation that brings the up axis of a file to z, if it is requested.
fn upright(asset: Node<'_>, up_axis: UpAxis, soup: &mut Soup) -> Matrix3<f64> {
    let stated = child(asset, "up_axis").and_then(|axis| super::words(axis).next());
    // The axes of a file to the right, up and towards the viewer [COLLADA 1.4.1, up_axis] are x, z and −y of a scene with z
    // up.
    let (stated, turned) = match stated.unwrap_or("Y_UP") {
        "X_UP" => (
            "X_UP",
            matrix![0.0, -1.0, 0.0; 0.0, 0.0, -1.0; 1.0, 0.0, 0.0],
        ),
        "Y_UP" if stated.is_some() => (
            "Y_UP",
            matrix![1.0, 0.0, 0.0; 0.0, 0.0, -1.0; 0.0, 1.0, 0.0],
        ),
        _ => return Matrix3::identity(),
    };
    let (is_turned, reason) = match up_axis {
        UpAxis::Auto if states_y_always(asset) => {
            (false, ", as MeshLab does whatever a file holds")
        }
        UpAxis::Auto | UpAxis::Honour => (true, ""),
        UpAxis::Ignore => (false, ""),
    };
    if is_turned {
        soup.remark(format!("states {stated}: it is rotated so that this axis is up (the up-axis option ignore uses it without rotation)"));
        turned
    } else {
        soup.remark(format!(
            "states {stated}{reason}: it is used without rotation, z up (the up-axis option honour rotates it)"
        ));
        Matrix3::identity()
    }
}

fn states_y_always(asset: Node<'_>) -> bool {
    let mut tools = children(asset, "contributor").filter_map(|c| child(c, "authoring_tool"));
    tools.any(|tool| tool.text().unwrap_or_default().contains(STATES_Y_ALWAYS))
}
