//! Classes of defaults.

use std::collections::HashMap;

use super::tree::Node;
use crate::error::LoadError;
use crate::nested::IntoNested;

/// Deepest nesting of classes: files nest about three, and a look-up goes through all of them.
const MAX_DEPTH: usize = 30;

/// Name of the outermost class where it has no other.
const MAIN: &str = "main";

/// A class of defaults by its number; the first is the outermost one.
pub(super) type ClassId = usize;

/// The classes of a description.
#[derive(Debug)]
pub(super) struct Classes<'t> {
    classes: Vec<Class<'t>>,
    by_name: HashMap<&'t str, ClassId>,
}

#[derive(Debug)]
struct Class<'t> {
    around: Option<ClassId>,
    /// Elements that set defaults of a few tags; later ones win.
    defaults: Vec<(&'t str, Vec<Node<'t>>)>,
    depth: usize,
}

impl<'t> Classes<'t> {
    /// Reads the classes of a description.
    pub(super) fn read(root: Node<'t>) -> Result<Self, LoadError> {
        let mut classes = Self {
            classes: vec![Class::new(None, 0)],
            by_name: HashMap::from([(MAIN, 0)]),
        };
        let mut is_first = true;
        let mut open = Vec::new();
        for node in root.all("default") {
            let id = match node.filled("class") {
                None => 0,
                Some(name) if is_first => *classes.by_name.entry(name).or_insert(0),
                Some(name) => classes.named(node, name, 0)?,
            };
            is_first = false;
            open.push((node, id));
        }
        open.reverse();
        while let Some((node, id)) = open.pop() {
            classes.elements(node, id, &mut open)?;
        }
        Ok(classes)
    }

    /// Notes the elements of a class, and the classes in it.
    fn elements(
        &mut self,
        node: Node<'t>,
        id: ClassId,
        open: &mut Vec<(Node<'t>, ClassId)>,
    ) -> Result<(), LoadError> {
        for child in node.children() {
            if child.tag() != "default" {
                self.classes[id].add(child.read());
                continue;
            }
            let name = child.read().filled("class");
            let name = name.ok_or_else(|| child.place().missing("attribute class"))?;
            let inner = self.named(child, name, id)?;
            open.push((child, inner));
        }
        Ok(())
    }

    /// A class of a name in another one.
    fn named(
        &mut self,
        node: Node<'t>,
        name: &'t str,
        around: ClassId,
    ) -> Result<ClassId, LoadError> {
        let depth = self.classes[around].depth + 1;
        if depth > MAX_DEPTH {
            let reason = format!("classes are nested more than {MAX_DEPTH} deep");
            return Err(node.place().unsupported(reason));
        }
        let new = self.classes.len();
        let id = *self.by_name.entry(name).or_insert(new);
        if id == new {
            self.classes.push(Class::new(Some(around), depth));
        }
        Ok(id)
    }

    /// The class that an attribute of an element names, if it has that attribute.
    pub(super) fn of(
        &self,
        node: Node<'t>,
        attribute: &'static str,
    ) -> Result<Option<ClassId>, LoadError> {
        let Some(name) = node.filled(attribute) else {
            return Ok(None);
        };
        let found = self.by_name.get(name).copied();
        let unknown = || {
            let reason = "there is no default class of that name";
            node.place().malformed(attribute, name, reason)
        };
        found.ok_or_else(unknown).map(Some)
    }

    /// The elements that set defaults of tags in a class, from the outermost class on.
    pub(super) fn defaults(&self, class: ClassId, tags: &[&'static str]) -> Vec<Node<'t>> {
        let mut found = Vec::new();
        let mut at = Some(class);
        while let Some(id) = at {
            let own = tags.iter().map(|tag| self.classes[id].of(tag));
            let mut own: Vec<Node<'t>> = own.flatten().copied().collect();
            own.sort_unstable_by_key(|node| std::cmp::Reverse(node.index));
            found.extend(own);
            at = self.classes[id].around;
        }
        found.reverse();
        found
    }

    /// The element that sets the default of an attribute.
    ///
    /// * `tags` – tags of elements whose defaults are meant
    pub(super) fn find(
        &self,
        class: ClassId,
        tags: &[&'static str],
        name: &'static str,
    ) -> Option<(Node<'t>, &'t str)> {
        let mut at = Some(class);
        while let Some(id) = at {
            let own = tags.iter().map(|tag| self.classes[id].of(tag));
            let own = own.nested(|nodes| nodes.iter().rev());
            let mut found = own.filter_map(|&node| Some((node, node.attribute(name)?)));
            if let Some(found) = found.next() {
                return Some(found);
            }
            at = self.classes[id].around;
        }
        None
    }
}

impl<'t> Class<'t> {
    fn new(around: Option<ClassId>, depth: usize) -> Self {
        Self {
            around,
            defaults: Vec::new(),
            depth,
        }
    }

    fn add(&mut self, node: Node<'t>) {
        let known = self.defaults.iter_mut().find(|(tag, _)| *tag == node.tag());
        match known {
            Some((_, nodes)) => nodes.push(node),
            None => self.defaults.push((node.tag(), vec![node])),
        }
    }

    /// The elements that set defaults of a tag.
    fn of(&self, tag: &str) -> &[Node<'t>] {
        let found = self.defaults.iter().find(|(own, _)| *own == tag);
        found.map_or(&[], |(_, nodes)| nodes)
    }
}
