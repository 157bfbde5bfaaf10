//! Remarks that loaders of all formats make on what they read.

use crate::model::Limits;

/// Remark on limits of position between which there is nothing.
pub(super) fn on_room(limits: &Limits) -> Option<String> {
    let lower = limits.lower.filter(|_| limits.lower == limits.upper)?;
    Some(format!(
        "lower = upper = {lower}: the limits leave no room to move"
    ))
}

/// Remark on Coulomb friction, which not every simulator takes.
pub(super) fn on_friction(friction: f64) -> Option<String> {
    let acts = (friction != 0.0).then_some(friction)?;
    Some(format!(
        "friction {acts} acts in simulators with Actuation::from_model only"
    ))
}

/// Remark on a joint that moves independently and mimics one that does not exist.
pub(super) fn on_missing_leader(leader: &str) -> String {
    format!("there is no joint \"{leader}\" to mimic: the joint moves independently")
}
