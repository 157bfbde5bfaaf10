//! Fixed tendons: sums of joint positions.

use std::collections::HashMap;

use super::joint::Kind;
use super::scene::MjcfTendon;
use super::walk::Part;
use crate::error::LoadError;

/// Reads a fixed tendon.
pub(super) fn read(
    part: &Part<'_, '_>,
    kinds: &HashMap<String, Kind>,
) -> Result<MjcfTendon, LoadError> {
    part.entry(&["tendon"])?;
    let mut joints = Vec::new();
    for node in part.node.all("joint") {
        let own = Part::of(node, part.source, part.naming.clone());
        let entry = own.plain();
        let name = entry.text("joint").ok_or_else(|| entry.missing("joint"))?;
        let name = part.naming.of(name);
        let kind = kinds
            .get(&name)
            .ok_or_else(|| node.place().unknown(&name))?;
        if !kind.is_single() {
            return Err(entry.malformed("joint", "is neither a hinge nor a slide"));
        }
        let coefficient = entry.number("coef")?;
        let coefficient = coefficient.ok_or_else(|| entry.missing("coef"))?;
        joints.push((name, coefficient));
    }
    if joints.is_empty() {
        return Err(part.node.place().missing("joint"));
    }
    Ok(MjcfTendon {
        name: part.name().unwrap_or_default(),
        joints,
    })
}
