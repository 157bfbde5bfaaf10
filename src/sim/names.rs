//! Names of coordinates.

use crate::joint::JointKind;
use crate::model::{BodyId, Model};
use crate::scalar::Scalar;

/// `<prefix>0`, `<prefix>1`, …
pub(crate) fn numbered(prefix: &str, n: usize) -> impl Iterator<Item = String> + '_ {
    (0..n).map(move |k| format!("{prefix}{k}"))
}

/// Names of the coordinates of q, then of v, as columns of a table.
pub(crate) fn column_names(model: &Model) -> Vec<String> {
    // A name with a comma or a quote would break the table.
    let clean = |name: String| name.replace([',', '"', '\n', '\r'], "_");
    let q = coordinate_names(model, JointKind::nq, BASE).map(|name| clean(format!("q.{name}")));
    let v = coordinate_names(model, JointKind::nv, BASE).map(|name| clean(format!("v.{name}")));
    q.chain(v).collect()
}

/// Name of a floating base in columns and inputs.
const BASE: &str = "base";

/// The name of the joint of each velocity coordinate, numbered where it has several; of a floating base `base`.
pub(super) fn tangent_names<P: Scalar>(model: &Model<P>) -> Vec<String> {
    coordinate_names(model, JointKind::nv, BASE).collect()
}

/// The name of the joint of each coordinate, `<joint>.0`, `<joint>.1`, … where it has several.
///
/// * `count` – number of coordinates of a joint
/// * `base` – name of a floating base
pub(crate) fn coordinate_names<'a, P: Scalar>(
    model: &'a Model<P>,
    count: fn(JointKind) -> usize,
    base: &'a str,
) -> impl Iterator<Item = String> + 'a {
    let bodies = model.bodies().iter().enumerate();
    let independent = bodies.filter(|(_, body)| body.coupling.is_none());
    independent.flat_map(move |(i, body)| {
        let name = model.part_name(BodyId(i));
        let name = name.unwrap_or_else(|| base.to_owned());
        match count(body.joint) {
            1 => vec![name],
            n => numbered(&format!("{name}."), n).collect(),
        }
    })
}
