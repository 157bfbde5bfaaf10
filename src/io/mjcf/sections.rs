//! The sections beside the bodies: of the description, and of the models that it attaches.

use std::collections::HashMap;

use super::body::Bodies;
use super::documents::Source;
use super::joint::Kind;
use super::naming::Naming;
use super::walk::{MAX_ADDED, Part, Walk};
use crate::error::LoadError;
use crate::io::context::Context;
use crate::nested::IntoNested;
use crate::spatial::Transform;

/// Names that sections refer to.
#[derive(Debug, Default)]
pub(super) struct Names {
    /// Kinds of joints.
    pub(super) kinds: HashMap<String, Kind>,
    /// Frames of sites.
    pub(super) sites: HashMap<String, String>,
    /// Poses of the sites of the world.
    pub(super) on_world: HashMap<String, Transform<f64>>,
}

impl Names {
    /// The joints of bodies, and the sites of the world; other sites come when they have frames.
    pub(super) fn of(bodies: &Bodies) -> Self {
        let joints = bodies.entries.iter().nested(|body| &body.joints);
        let on_world = bodies.entries[0].sites.iter();
        Self {
            on_world: on_world
                .map(|site| (site.name.clone(), site.placement))
                .collect(),
            kinds: joints
                .map(|joint| (joint.name.clone(), joint.kind))
                .collect(),
            sites: HashMap::new(),
        }
    }
}

/// The elements of a section: those of the description, and those of each attached model.
///
/// # Errors
/// If attached models add too many.
pub(super) fn parts<'t, 'c>(
    sources: &'c [Source<'t>],
    walk: &Walk<'t, 'c>,
    section: &'static str,
) -> Result<Vec<Vec<Part<'t, 'c>>>, LoadError> {
    let attached = walk.attached.iter().map(|(index, _)| {
        let all = sources[*index].root.all(section);
        all.map(|node| node.element().children.len()).sum::<usize>()
    });
    if attached.sum::<usize>() > MAX_ADDED {
        let reason = format!("attached models add more than {MAX_ADDED} elements of <{section}>");
        return Err(sources[0].root.place().unsupported(reason));
    }
    let own = [(0, Naming::plain())].into_iter();
    let all = own.chain(walk.attached.iter().cloned());
    let parts = all.map(|(index, naming)| {
        let source = &sources[index];
        let children = source.root.all(section).nested(|node| node.children());
        let parts = children.map(|node| Part::of(node, source, naming.clone()));
        parts.collect()
    });
    Ok(parts.collect())
}

/// Results of elements. One of an attached model that cannot be read has none.
pub(super) fn read<'t, 'c, T>(
    parts: &[Part<'t, 'c>],
    context: &mut Context<'_>,
    mut one: impl FnMut(&Part<'t, 'c>, &mut Context<'_>) -> Result<Option<T>, LoadError>,
) -> Result<Vec<T>, LoadError> {
    let mut out = Vec::new();
    for part in parts {
        match one(part, context) {
            Ok(found) => out.extend(found),
            Err(error) if part.naming.is_attached() => {
                part.node.read_all();
                context.ignore(&part.node.place(), format!("is not attached: {error}"));
            }
            Err(error) => return Err(error),
        }
    }
    Ok(out)
}
