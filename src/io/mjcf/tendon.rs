//! Fixed tendons: sums of joint positions, and their springs and dampers.

use std::collections::HashMap;

use super::body::Bodies;
use super::entry::Entry;
use super::joint::{Kind, first};
use super::scene::MjcfTendon;
use super::walk::Part;
use crate::constraint::Constraint;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::io::place::SourcePlace;
use crate::model::Model;
use crate::nested::IntoNested;

/// A spring and damper along a tendon.
#[derive(Debug)]
pub(super) struct TendonSpring {
    /// In the units of force by those of the length.
    stiffness: f64,
    damping: f64,
    /// Length at which there is no force; that at the references of the springs of its joints where there is none.
    length: Option<f64>,
    place: SourcePlace,
}

/// Reads a fixed tendon.
pub(super) fn read(
    part: &Part<'_, '_>,
    kinds: &HashMap<String, Kind>,
    context: &mut Context<'_>,
) -> Result<(MjcfTendon, TendonSpring), LoadError> {
    let spring = spring(&part.entry(&["tendon"])?, context)?;
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
    let name = part.name().unwrap_or_default();
    Ok((MjcfTendon { name, joints }, spring))
}

fn spring(entry: &Entry<'_, '_>, context: &mut Context<'_>) -> Result<TendonSpring, LoadError> {
    let place = entry.node.place();
    let mut coefficient = |name| match first(entry, name, context)? {
        x if x < 0.0 => Err(entry.malformed(name, "is negative")),
        x => Ok(x),
    };
    let (mut stiffness, damping) = (coefficient("stiffness")?, coefficient("damping")?);
    let range = entry.list("springlength", 2)?.unwrap_or_default();
    let length = range.first().copied().filter(|x| *x >= 0.0);
    if length.is_some() && range.len() == 2 && range[0] != range[1] && stiffness > 0.0 {
        stiffness = 0.0;
        let reason = "a spring with a range of lengths without force is not modelled";
        context.ignore(&place, reason);
    }
    Ok(TendonSpring {
        stiffness,
        damping,
        length,
        place,
    })
}

/// The springs and dampers of tendons as constraints.
pub(super) fn springs(
    tendons: &[MjcfTendon],
    springs: &[TendonSpring],
    model: &Model,
    bodies: &Bodies,
    context: &mut Context<'_>,
) -> Vec<Constraint> {
    let joints = bodies.entries.iter().nested(|body| &body.joints);
    let rests = joints.map(|joint| (joint.name.as_str(), joint.axis.spring.rest));
    let rests: HashMap<&str, f64> = rests.collect();
    let mut out = Vec::new();
    for (tendon, own) in tendons.iter().zip(springs) {
        let acts = own.stiffness > 0.0 || own.damping > 0.0;
        if !acts || tendon.joints.iter().all(|(_, c)| *c == 0.0) {
            continue;
        }
        let joints = tendon.joints.iter().map(|(joint, c)| (joint.as_str(), *c));
        let joints: Vec<(&str, f64)> = joints.collect();
        let at_rest = || joints.iter().map(|(joint, c)| c * rests[joint]).sum();
        let length = own.length.unwrap_or_else(at_rest);
        match Constraint::tendon(model, &joints, length) {
            Ok(made) => out.push(made.with_spring(own.stiffness, own.damping)),
            Err(_) => context.ignore(&own.place, "spring and damper: a joint of it is locked"),
        }
    }
    out
}
