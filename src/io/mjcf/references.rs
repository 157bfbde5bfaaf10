//! Names that elements refer to. A name that no element has is an error, as in `MuJoCo`.
//!
//! `MuJoCo` also replicates what refers to a replica: the motor of a joint that is there three times is three motors. They come behind the other
//! elements of their section, replica by replica.

use std::collections::{HashMap, HashSet};

use super::documents::Source;
use super::naming::Naming;
use super::reference_kinds::{Kind, Reference, references};
use super::scenery::WORLD;
use super::walk::{MAX_ADDED, Part};
use crate::error::LoadError;
use crate::io::context::Context;
use crate::nested::IntoNested;
use crate::sorting::sort_seldom;

/// Elements that make others, whose names are not known here, and the section of those that have this tag in others too.
const MAKERS: [(&str, Option<&str>); 3] = [
    ("composite", None),
    ("flexcomp", None),
    ("flex", Some("deformable")),
];

/// The names of elements.
#[derive(Debug, Default)]
pub(super) struct References {
    names: HashSet<(Kind, String)>,
    /// Replicas that an element is in, by its name without their numbers.
    replicas: HashMap<(Kind, String), Vec<Naming>>,
    /// Bodies that cameras and lights look at: the name here, and the error if there is none.
    targets: Vec<(String, LoadError)>,
    /// Replicas of elements of sections so far.
    made: usize,
    /// Whether there may be elements whose names are not known here.
    is_open: bool,
}

impl References {
    /// No names so far.
    pub(super) fn new(sources: &[Source<'_>]) -> Self {
        let mut nodes = sources.iter().nested(|source| source.root.tree.nodes());
        Self {
            is_open: nodes.any(|node| {
                let section = node.tree.node(node.element().section).tag();
                let mut makers = MAKERS.iter();
                makers.any(|(tag, of)| *tag == node.tag() && of.is_none_or(|of| of == section))
            }),
            ..Self::default()
        }
    }

    /// Adds the name of an element of a section, if it has one.
    pub(super) fn add(&mut self, section: &str, part: &Part<'_, '_>) {
        let tag = part.node.tag();
        if let ("camera" | "light", Some(name)) = (tag, part.node.peek("target")) {
            self.add_target(part, name);
        }
        let kind = Kind::of(section, tag);
        let Some((kind, name)) = kind.zip(part.node.filled("name")) else {
            return;
        };
        self.names.insert((kind, part.naming.own(name)));
        if !part.naming.replicas().is_empty() {
            let common = (kind, part.naming.common(name));
            let own = self.replicas.entry(common).or_default();
            own.push(part.naming.clone());
        }
    }

    fn add_target(&mut self, part: &Part<'_, '_>, name: &str) {
        let target = references(part.node).find(|own| own.attribute == "target");
        // A replica may look at what is not replicated; parts of attached models that look at others are not attached.
        let is_plain = part.naming.replicas().is_empty() && !part.naming.is_attached();
        if let Some(target) = target.filter(|_| is_plain) {
            self.targets.push((name.into(), target.unknown()));
        }
    }

    /// Checks what cameras and lights look at.
    pub(super) fn check_targets(&mut self) -> Result<(), LoadError> {
        for (name, unknown) in std::mem::take(&mut self.targets) {
            let is_known = name == WORLD || self.names.contains(&(Kind::Body, name));
            if !is_known && !self.is_open {
                return Err(unknown);
            }
        }
        Ok(())
    }

    /// Checks elements that are not read.
    pub(super) fn check_unread(&self, main: &Source<'_>) -> Result<(), LoadError> {
        let sections = main.root.children();
        let sections = sections.filter(|node| matches!(node.tag(), "custom" | "deformable"));
        let parts = sections.nested(|node| node.children());
        for part in parts.map(|node| Part::of(node, main, Naming::plain())) {
            let known = |own: &Reference<'_>| {
                let common = (own.kind, own.name.to_owned());
                self.has(&part, own, &part.naming) || self.replicas.contains_key(&common)
            };
            let unknown = references(part.node).find(|own| !known(own));
            if let Some(unknown) = unknown.filter(|_| !self.is_open) {
                return Err(unknown.unknown());
            }
        }
        Ok(())
    }

    /// Whether there is what a reference means, in a naming.
    fn has(&self, part: &Part<'_, '_>, own: &Reference<'_>, naming: &Naming) -> bool {
        match own.kind {
            Kind::Body if own.name == WORLD => true,
            Kind::Material => part.source.assets.color(own.name).is_some(),
            Kind::Mesh => part.source.assets.has_mesh(own.name),
            kind => self.names.contains(&(kind, naming.of(own.name))),
        }
    }

    /// The elements of a section, each with the naming in which its references are known, and their names with the others. The elements are in groups:
    /// of the description, and of each attached model.
    pub(super) fn resolve_all<'t, 'c>(
        &mut self,
        section: &str,
        groups: Vec<Vec<Part<'t, 'c>>>,
        context: &mut Context<'_>,
    ) -> Result<Vec<Part<'t, 'c>>, LoadError> {
        let mut out = Vec::new();
        for group in groups {
            out.extend(self.resolve(section, group, context)?);
        }
        for part in out
            .iter()
            .filter(|_| matches!(section, "actuator" | "tendon"))
        {
            self.add(section, part);
        }
        Ok(out)
    }

    /// The elements of a group: those that refer to replicas once for each of them, at the end. An element of an attached model that refers to a part that
    /// was not attached is none.
    fn resolve<'t, 'c>(
        &mut self,
        section: &str,
        parts: Vec<Part<'t, 'c>>,
        context: &mut Context<'_>,
    ) -> Result<Vec<Part<'t, 'c>>, LoadError> {
        let mut plain = Vec::with_capacity(parts.len());
        let mut replicas = Vec::new();
        for part in parts {
            let unknown = references(part.node).find(|own| !self.has(&part, own, &part.naming));
            let Some(unknown) = unknown else {
                plain.push(part);
                continue;
            };
            let before = replicas.len();
            self.replicate(section, &part, &unknown, &mut replicas)?;
            if replicas.len() > before {
                continue;
            }
            match self.without(section, &part, &unknown)? {
                // Readers of these keep what they do not know.
                None => plain.push(part),
                Some(reason) => {
                    part.node.read_all();
                    context.ignore(&part.node.place(), reason);
                }
            }
        }
        sort_seldom(&mut replicas, |one, other| {
            one.naming.replicas().cmp(other.naming.replicas())
        });
        plain.extend(replicas);
        Ok(plain)
    }

    /// Why an element that names something unknown is not used; `None` if its reader decides.
    fn without(
        &self,
        section: &str,
        part: &Part<'_, '_>,
        unknown: &Reference<'_>,
    ) -> Result<Option<String>, LoadError> {
        let common = (unknown.kind, part.naming.common(unknown.name));
        if self.replicas.contains_key(&common) {
            let reason =
                "names a part of a replica and one that is not in it: not used, as in MuJoCo";
            return Ok(Some(reason.into()));
        }
        let error = unknown.unknown();
        if part.naming.is_attached() {
            return Ok(Some(format!("is not attached: {error}")));
        }
        match (self.is_open, section) {
            (true, "actuator" | "sensor") => Ok(None),
            (true, _) => Ok(Some(format!("is not modelled: {error}"))),
            (false, _) => Err(error),
        }
    }

    /// Adds the replicas of an element that names one. It may name parts outside of them too, but not as an actuator or equality.
    fn replicate<'t, 'c>(
        &mut self,
        section: &str,
        part: &Part<'t, 'c>,
        unknown: &Reference<'_>,
        out: &mut Vec<Part<'t, 'c>>,
    ) -> Result<(), LoadError> {
        let common = (unknown.kind, part.naming.common(unknown.name));
        let candidates = self.replicas.get(&common).map_or(&[][..], Vec::as_slice);
        self.made += candidates.len();
        if self.made > MAX_ADDED {
            let reason = format!("elements of replicas are more than {MAX_ADDED}");
            return Err(part.node.place().unsupported(reason));
        }
        for naming in candidates.iter().filter(|own| own.is_within(&part.naming)) {
            let outside = |own: &Reference<'_>| !self.has(part, own, naming);
            let mut outer = references(part.node).filter(outside);
            let is_plain = part.naming.replicas().is_empty();
            let may_be = is_plain && !matches!(section, "actuator" | "equality");
            if outer.all(|own| may_be && self.has(part, &own, &part.naming)) {
                let outer = references(part.node).filter(outside);
                out.push(Part {
                    naming: naming.with_outside(outer.map(|own| own.name.into())),
                    ..part.clone()
                });
            }
        }
        Ok(())
    }
}
