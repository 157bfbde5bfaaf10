//! The elements of a description in one tree, with those of included files in the place of what includes them.
//!
//! Elements and attributes know whether they were read, so that the report can name the others.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

use crate::error::SourcePosition;
use crate::io::place::{ImportNote, SourcePlace};

/// Address and length of a text.
type Place = (usize, usize);

/// All elements; the first one is the root.
#[derive(Debug)]
pub(super) struct Tree {
    pub(super) elements: Vec<Element>,
    /// Names of the files, the description first.
    pub(super) files: Vec<Rc<str>>,
    /// Pairs of tag and attribute that a reader requested.
    asked: RefCell<BTreeMap<[Place; 2], (&'static str, &'static str)>>,
}

/// An element.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) tag: Box<str>,
    pub(super) attributes: Vec<Attribute>,
    pub(super) parent: usize,
    pub(super) children: Vec<usize>,
    /// The section of the file that contains it: an element right below the root.
    pub(super) section: usize,
    pub(super) line: u32,
    pub(super) file: usize,
    pub(super) is_read: Cell<bool>,
}

/// An attribute.
#[derive(Debug)]
pub(super) struct Attribute {
    pub(super) name: Box<str>,
    pub(super) value: Box<str>,
    pub(super) is_read: Cell<bool>,
}

impl Tree {
    pub(super) fn new() -> Self {
        Self {
            elements: Vec::new(),
            files: Vec::new(),
            asked: RefCell::default(),
        }
    }

    /// The root element.
    pub(super) fn root(&self) -> Node<'_> {
        self.node(0)
    }

    /// An element by its number.
    pub(super) fn node(&self, index: usize) -> Node<'_> {
        Node { tree: self, index }
    }

    /// All elements, in the order of the text.
    pub(super) fn nodes(&self) -> impl Iterator<Item = Node<'_>> {
        (0..self.elements.len()).map(|index| self.node(index))
    }

    /// `true` if a reader requested an attribute of an element of a tag.
    pub(super) fn was_asked(&self, tag: &str, attribute: &str) -> bool {
        let asked = self.asked.borrow();
        asked.values().any(|&pair| pair == (tag, attribute))
    }

    /// `true` if some element of a tag was read.
    pub(super) fn has_asked(&self, tag: &str) -> bool {
        self.asked.borrow().values().any(|(asked, _)| *asked == tag)
    }
}

/// An element of a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node<'t> {
    pub(super) tree: &'t Tree,
    pub(super) index: usize,
}

impl<'t> Node<'t> {
    pub(super) fn element(self) -> &'t Element {
        &self.tree.elements[self.index]
    }

    pub(super) fn tag(self) -> &'t str {
        &self.element().tag
    }

    /// The text of an attribute, which counts as read.
    pub(super) fn attribute(self, name: &'static str) -> Option<&'t str> {
        let mut own = self.element().attributes.iter();
        let found = own.find(|attribute| &*attribute.name == name)?;
        found.is_read.set(true);
        Some(&found.value)
    }

    /// The text of an attribute that is not empty, which does not count as read.
    pub(super) fn peek(self, name: &str) -> Option<&'t str> {
        let mut own = self.element().attributes.iter();
        let found = own.find(|attribute| &*attribute.name == name)?;
        Some(found.value.trim()).filter(|text| !text.is_empty())
    }

    /// The text of an attribute that is not empty.
    pub(super) fn filled(self, name: &'static str) -> Option<&'t str> {
        self.attribute(name).filter(|text| !text.trim().is_empty())
    }

    /// Notes that an attribute of elements of a tag is understood, wherever it is.
    pub(super) fn ask(self, tag: &'static str, name: &'static str) {
        // Addresses are compared faster than texts: this is done for each attribute of each element.
        let places = [tag, name].map(|text| (text.as_ptr().addr(), text.len()));
        let mut asked = self.tree.asked.borrow_mut();
        asked.entry(places).or_insert((tag, name));
    }

    /// Counts as read.
    pub(super) fn read(self) -> Self {
        self.element().is_read.set(true);
        self
    }

    /// Counts as read with all its attributes: a remark names the whole element.
    pub(super) fn read_all(self) {
        let attributes = &self.read().element().attributes;
        attributes.iter().for_each(|own| own.is_read.set(true));
    }

    pub(super) fn children(self) -> impl DoubleEndedIterator<Item = Self> {
        let tree = self.tree;
        (self.element().children.iter()).map(move |&index| tree.node(index))
    }

    /// The child elements of a tag, which count as read.
    pub(super) fn all(self, tag: &'static str) -> impl DoubleEndedIterator<Item = Self> {
        let own = self.children().filter(move |child| child.tag() == tag);
        own.map(Self::read)
    }

    fn parent(self) -> Self {
        self.tree.node(self.element().parent)
    }

    /// Path for remarks: the section, the parent and the element, so that its length does not grow with nesting.
    fn path(self) -> String {
        let section = self.tree.node(self.element().section);
        let mut tags = vec![self.tree.root().tag()];
        let parent = self.parent();
        if section.index != self.index {
            tags.push(section.tag());
            if parent.index != section.index {
                tags.push(parent.tag());
            }
        }
        if self.index != 0 {
            tags.push(self.tag());
        }
        tags.join("/")
    }

    fn position(self) -> SourcePosition {
        let element = self.element();
        SourcePosition {
            file: self.tree.files[element.file].to_string(),
            line: element.line,
        }
    }

    /// Name of the element, or of the nearest one around it that has a name.
    fn name(self) -> &'t str {
        let named = [self, self.parent()].into_iter().find_map(|node| {
            let mut own = node.element().attributes.iter();
            own.find(|attribute| &*attribute.name == "name")
        });
        named.map_or("", |name| &name.value)
    }

    /// The place of the element, for errors and remarks.
    pub(super) fn place(self) -> SourcePlace {
        let (position, name) = (self.position(), self.name());
        let line = position.line;
        let in_other = self.element().file > 0;
        let file = in_other.then(|| format!(" (in {})", position.file));
        SourcePlace {
            note: ImportNote {
                path: self.path(),
                name: name.into(),
                line,
                reason: file.unwrap_or_default(),
            },
            element: self.tag().into(),
            name: match name {
                "" => format!("on line {line}"),
                _ => name.into(),
            },
            position,
        }
    }
}
