//! Names of joints and coordinates.

use std::fmt::Display;

use super::manifold::v_range;
use super::{BodyId, Model};
use crate::joint::JointKind;
use crate::nested::IntoNested;
use crate::scalar::Scalar;

/// Name of a floating base among the joints of parameters and of measurements.
pub(crate) const FLOATING_BASE: &str = "floating base";

/// `<prefix>0`, `<prefix>1`, …
pub(crate) fn numbered(prefix: &str, n: usize) -> impl Iterator<Item = String> + '_ {
    (0..n).map(move |k| format!("{prefix}{k}"))
}

impl<P: Scalar> Model<P> {
    /// The name of the joint of a body, with the index of the axis if it has two bodies; `None` for a floating base.
    pub(crate) fn part_name(&self, body: BodyId) -> Option<String> {
        let joint = &self.joints[self.body_joint(body)?.0];
        let bodies = joint.bodies();
        Some(match bodies.len() {
            1 => joint.name.clone(),
            _ => format!("{}.{}", joint.name, body.0 - bodies.start),
        })
    }

    /// The name of the joint of a body in parameters and measurements.
    pub(crate) fn joint_name(&self, body: BodyId) -> String {
        let name = self.part_name(body);
        name.unwrap_or_else(|| FLOATING_BASE.into())
    }

    /// Name of a quantity along a velocity coordinate.
    pub(crate) fn coordinate_name(&self, v: usize, quantity: &dyn Display) -> String {
        let mut bodies = self.independent_with_ids();
        let own = bodies.find(|(_, body)| v_range(body).contains(&v));
        let (id, body) = own.expect("a joint has the coordinate");
        let joint = self.joint_name(id);
        match body.joint.nv() {
            1 => format!("{joint}: {quantity}"),
            _ => format!("{joint}: {quantity} {}", v - body.v),
        }
    }

    /// The name of the joint of each coordinate, `<joint>.0`, `<joint>.1`, … where it has several.
    ///
    /// * `count` – number of coordinates of a joint
    /// * `base` – name of a floating base
    pub(crate) fn coordinate_names<'a>(
        &'a self,
        count: fn(JointKind) -> usize,
        base: &'a str,
    ) -> impl Iterator<Item = String> + 'a {
        self.independent_with_ids().nested(move |(id, body)| {
            let name = self.part_name(id);
            let name = name.unwrap_or_else(|| base.to_owned());
            match count(body.joint) {
                1 => vec![name],
                n => numbered(&format!("{name}."), n).collect(),
            }
        })
    }
}
