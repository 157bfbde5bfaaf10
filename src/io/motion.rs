//! Axes of joints as formats write them: limits, damping, friction, joints to mimic.

use super::context::{Context, Node};
use super::place::Place;
use super::values::{Attributes, Values, any};
use crate::error::LoadError;
use crate::joint::JointKind;
/// An axis of a joint, with what acts along it.
pub(super) use crate::model::SecondAxis as Axis;
use crate::model::{Limits, Mimic};

/// Reads a name of a table from an attribute that must be there.
pub(super) fn one_of<'t, T>(
    context: &mut Context<'_>,
    node: Node<'_>,
    attribute: &str,
    table: &'t [(&str, T)],
) -> Result<&'t T, LoadError> {
    let text = Attributes::required_text(context, node, attribute)?;
    let found = table.iter().find(|(name, _)| *name == text.trim());
    found.map(|(_, meaning)| meaning).ok_or_else(|| {
        let names: Vec<&str> = table.iter().map(|(name, _)| *name).collect();
        let reason = format!("expected one of {}", names.join(", "));
        context.malformed(node, attribute, reason)
    })
}

/// Whether joints of a kind have limits of position in a URDF.
pub(super) fn is_bounded(kind: JointKind) -> bool {
    matches!(kind, JointKind::Revolute | JointKind::Prismatic)
}

/// A limit towards one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Bound {
    /// The file gives no value.
    Absent,
    /// A finite number.
    Finite(f64),
    /// The file states that there is no limit.
    Infinite,
}

/// The bound that a text states.
///
/// * `side` – sign of the side on which the bound is
/// * `unlimited` – size above which a bound on that side does not count
pub(super) fn bound(
    context: &Context<'_>,
    node: Node<'_>,
    name: &str,
    text: Option<&str>,
    [side, unlimited]: [f64; 2],
) -> Result<Bound, LoadError> {
    let Some(text) = text else {
        return Ok(Bound::Absent);
    };
    let [x] = any(context, node, name, text)?;
    match x {
        _ if x * side >= unlimited => Ok(Bound::Infinite),
        _ if x.is_finite() => Ok(Bound::Finite(x)),
        _ => Err(context.non_finite(node, name)),
    }
}

/// Remarks on limits of position between which there is nothing.
pub(super) fn check_room(context: &mut Context<'_>, place: Place<'_>, limits: &Limits) {
    if let Some(lower) = limits.lower.filter(|_| limits.lower == limits.upper) {
        let reason = format!("lower = upper = {lower}: the limits leave no room to move");
        context.warn(place, reason);
    }
}

/// Remarks on Coulomb friction, which not every simulator takes.
pub(super) fn check_friction(context: &mut Context<'_>, place: Place<'_>, friction: f64) {
    if friction != 0.0 {
        let reason =
            format!("friction {friction} acts in simulators with the actuation of the model only");
        context.warn(place, reason);
    }
}

/// Reads damping and friction along an axis.
pub(super) fn read_dynamics<V: Values>(
    context: &mut Context<'_>,
    node: Node<'_>,
    axis: &mut Axis,
) -> Result<(), LoadError> {
    axis.damping = V::number(context, node, "damping")?.unwrap_or_default();
    axis.friction = V::number(context, node, "friction")?.unwrap_or_default();
    check_friction(context, node.into(), axis.friction);
    Ok(())
}

/// Reads the joint that another one mimics.
pub(super) fn read_mimic<V: Values>(
    context: &mut Context<'_>,
    node: Node<'_>,
) -> Result<Mimic, LoadError> {
    Ok(Mimic {
        leader: Attributes::required_text(context, node, "joint")?.into_owned(),
        multiplier: V::number(context, node, "multiplier")?.unwrap_or(1.0),
        offset: V::number(context, node, "offset")?.unwrap_or_default(),
    })
}

/// Remark on a joint that moves independently and mimics one that does not exist.
pub(super) fn without_leader(leader: &str) -> String {
    format!("there is no joint \"{leader}\" to mimic: the joint moves independently")
}
