//! The traversal of the elements of bodies. Frames, replicas and attached models give poses and names to their children.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::defaults::ClassId;
use super::documents::Source;
use super::entry::Entry;
use super::naming::Naming;
use super::orientation::{euler, pose};
use super::tree::Node;
use crate::error::LoadError;
use crate::scalar::MapEach;
use crate::spatial::Transform;

/// Elements that replicas and attached models may add to those of the text.
pub(super) const MAX_ADDED: usize = 10_000;

/// Bytes that prefixes and suffixes may add to names: nested replicas and long prefixes would make them grow with the square of the text.
const MAX_NAMING: usize = 4 << 20;

/// Bytes of the place of a replica among others, which namings keep.
const PLACE: usize = size_of::<[usize; 2]>();

/// Most models that are attached: each is searched for its body.
const MAX_ATTACHED: usize = 500;

/// An element with the model that it is from, its class, its name and its place.
#[derive(Clone, Debug)]
pub(super) struct Part<'t, 'c> {
    pub(super) node: Node<'t>,
    pub(super) source: &'c Source<'t>,
    /// Class where it names none.
    pub(super) class: ClassId,
    pub(super) naming: Naming,
    /// Pose of its parent, in the body or the world.
    pub(super) X: Transform<f64>,
}

impl<'t, 'c> Part<'t, 'c> {
    /// An element outside all bodies.
    pub(super) fn of(node: Node<'t>, source: &'c Source<'t>, naming: Naming) -> Self {
        Self {
            node,
            source,
            class: 0,
            naming,
            X: Transform::identity(),
        }
    }

    /// Its values with the defaults of tags.
    pub(super) fn entry(&self, tags: &'static [&'static str]) -> Result<Entry<'t, 'c>, LoadError> {
        Entry::new(self.node, &self.source.classes, self.class, tags)
    }

    /// Its values, of an element that has no defaults.
    pub(super) fn plain(&self) -> Entry<'t, 'c> {
        Entry::plain(self.node, &self.source.classes)
    }

    /// Its name, if it has one.
    pub(super) fn name(&self) -> Option<String> {
        self.node.filled("name").map(|name| self.naming.own(name))
    }

    /// The class of its child elements.
    pub(super) fn class_inside(&self) -> Result<ClassId, LoadError> {
        let own = self.source.classes.of(self.node, "childclass")?;
        Ok(own.unwrap_or(self.class))
    }

    /// Replaces the element.
    fn with(&self, node: Node<'t>, class: ClassId, X: Transform<f64>) -> Self {
        Self {
            node,
            class,
            X,
            ..self.clone()
        }
    }
}

/// The way through bodies, which ends where replicas become too many.
#[derive(Debug)]
pub(super) struct Walk<'t, 'c> {
    sources: &'c [Source<'t>],
    left: usize,
    /// Bytes that prefixes and suffixes may still add.
    naming_left: usize,
    /// Models that were attached: number and names.
    pub(super) attached: Vec<(usize, Naming)>,
}

impl<'t, 'c> Walk<'t, 'c> {
    pub(super) fn new(sources: &'c [Source<'t>]) -> Self {
        let elements = sources.iter().map(|source| source.root.tree.elements.len());
        Self {
            sources,
            left: elements.sum::<usize>() + MAX_ADDED,
            naming_left: MAX_NAMING,
            attached: Vec::new(),
        }
    }

    /// The bodies, joints, shapes and so on in an element, those in frames, replicas and attached models among them, in their order.
    pub(super) fn inside(&mut self, of: &Part<'t, 'c>) -> Result<Vec<Part<'t, 'c>>, LoadError> {
        let mut open = Vec::new();
        let mut out = Vec::new();
        push_children(&mut open, of, of.class_inside()?, of.X);
        while let Some(part) = open.pop() {
            self.count(&part)?;
            match part.node.tag() {
                "frame" => {
                    let X = part.X * pose(&part.plain(), &part.source.compiler)?;
                    push_children(&mut open, &part, part.class_inside()?, X);
                }
                "replicate" => self.replicate(&part, &mut open)?,
                "attach" => self.attach(&part, &mut open)?,
                _ => out.push(part),
            }
        }
        Ok(out)
    }

    fn count(&mut self, part: &Part<'t, 'c>) -> Result<(), LoadError> {
        let left = self.left.checked_sub(1);
        let many = || {
            let reason = format!("replicas and attached models add more than {MAX_ADDED} elements");
            part.node.place().unsupported(reason)
        };
        self.left = left.ok_or_else(many)?;
        self.count_naming(part, part.naming.len())
    }

    fn count_naming(&mut self, part: &Part<'t, 'c>, bytes: usize) -> Result<(), LoadError> {
        let left = self.naming_left.checked_sub(bytes);
        let long = || {
            let reason = "the names of replicas and attached models become too long";
            part.node.place().unsupported(reason)
        };
        self.naming_left = left.ok_or_else(long)?;
        Ok(())
    }

    /// Puts the replicas of the children of an element on the stack, the first on top.
    fn replicate(
        &mut self,
        part: &Part<'t, 'c>,
        open: &mut Vec<Part<'t, 'c>>,
    ) -> Result<(), LoadError> {
        let entry = part.plain();
        let count = entry
            .integer("count")?
            .ok_or_else(|| entry.missing("count"))?;
        let count = usize::try_from(count).map_err(|_| entry.malformed("count", "is negative"))?;
        if count.saturating_mul(part.node.element().children.len()) > self.left {
            self.left = 0;
            return self.count(part);
        }
        let compiler = &part.source.compiler;
        let offset = entry.numbers::<3>("offset")?.unwrap_or_default();
        let angles = entry.numbers::<3>("euler")?.unwrap_or_default();
        let step = Transform::new(
            euler(angles.map_each(|a| a * compiler.angle), compiler),
            Vector3::from(offset),
        );
        let separator = part.node.attribute("sep").unwrap_or_default();
        let digits = count.saturating_sub(1).to_string().len();
        let length = part.naming.len() + separator.len() + digits + PLACE;
        self.count_naming(part, count.saturating_mul(length))?;
        let class = part.class_inside()?;
        let mut X = part.X;
        let mut replicas = Vec::with_capacity(count);
        for number in 0..count {
            let name = format!("{separator}{number:0digits$}");
            let at = [part.node.index, number];
            replicas.push((part.naming.replica(&name, at), X));
            X = X * step;
        }
        for (naming, X) in replicas.into_iter().rev() {
            let replica = Part {
                naming,
                ..part.clone()
            };
            push_children(open, &replica, class, X);
        }
        Ok(())
    }

    /// Puts a body of another model on the stack, or all children of its world.
    fn attach(
        &mut self,
        part: &Part<'t, 'c>,
        open: &mut Vec<Part<'t, 'c>>,
    ) -> Result<(), LoadError> {
        let entry = part.plain();
        let model = entry.text("model").ok_or_else(|| entry.missing("model"))?;
        let unknown = || entry.malformed("model", "there is no model of that name in the assets");
        let index = *part.source.models.get(model).ok_or_else(unknown)?;
        let naming = part
            .naming
            .attached(entry.text("prefix").unwrap_or_default());
        if self.attached.len() >= MAX_ATTACHED {
            let reason = format!("more than {MAX_ATTACHED} models are attached");
            return Err(part.node.place().unsupported(reason));
        }
        self.attached.push((index, naming.clone()));
        let other = Part {
            source: &self.sources[index],
            class: 0,
            naming,
            ..part.clone()
        };
        let worlds = || other.source.root.all("worldbody");
        let Some(body) = entry.text("body") else {
            for world in worlds().rev() {
                push_children(open, &other.with(world, 0, part.X), 0, part.X);
            }
            return Ok(());
        };
        let found = worlds().find_map(|world| find_body(world, body, &other));
        let unknown = || entry.malformed("body", "the attached model has no body of that name");
        open.push(found.ok_or_else(unknown)??);
        Ok(())
    }
}

/// A body of a name below an element, with the class that it has there.
fn find_body<'t, 'c>(
    world: Node<'t>,
    name: &str,
    other: &Part<'t, 'c>,
) -> Option<Result<Part<'t, 'c>, LoadError>> {
    let mut open = vec![(world, 0)];
    while let Some((node, class)) = open.pop() {
        let is_body = matches!(node.tag(), "body" | "frame");
        if is_body && node.filled("name") == Some(name) {
            return Some(Ok(other.with(node, class, other.X)));
        }
        let inside = match other.with(node, class, other.X).class_inside() {
            Ok(inside) => inside,
            Err(error) => return Some(Err(error)),
        };
        open.extend(node.children().rev().map(|child| (child, inside)));
    }
    None
}

/// Puts the children of an element on the stack, the first on top.
fn push_children<'t, 'c>(
    open: &mut Vec<Part<'t, 'c>>,
    of: &Part<'t, 'c>,
    class: ClassId,
    X: Transform<f64>,
) {
    let children = of.node.read().children().rev();
    open.extend(children.map(|child| of.with(child, class, X)));
}
