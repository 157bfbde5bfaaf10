//! Source positions in a description, for errors and remarks.

use std::fmt;

use crate::error::{LoadError, SourcePosition, message};
use crate::input::xml::{Node, tag};

/// A remark on an element of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ImportNote {
    /// The elements from the root to this one, as in `robot/joint/limit`; an attribute follows an `@`.
    pub path: String,
    /// Name of the link, joint, … of the element; empty without.
    pub name: String,
    /// Line of the element, from 1; 0 if the robot was not a text.
    pub line: u32,
    /// The remark.
    pub reason: String,
}

impl ImportNote {
    /// Makes a remark, for programs that store reports.
    pub fn new(
        path: impl Into<String>,
        name: impl Into<String>,
        line: u32,
        reason: impl Into<String>,
    ) -> Self {
        Self {
            path: path.into(),
            name: name.into(),
            line,
            reason: reason.into(),
        }
    }
}

impl fmt::Display for ImportNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            path,
            name,
            line,
            reason,
        } = self;
        if *line > 0 {
            write!(f, "line {line}: ")?;
        }
        write!(
            f,
            "{}",
            message(format_args!("{path} \"{name}\": {reason}"))
        )
    }
}

/// A part of a description that a remark is about.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place<'a> {
    /// An element of a text.
    Element(Node<'a>),
    /// A part of a description that is not a text: the path that it would have in one, and its name.
    Part(&'static str, &'a str),
    /// An element of a text that is read no more.
    Kept(&'a SourcePlace),
}

impl<'a> From<Node<'a>> for Place<'a> {
    fn from(node: Node<'a>) -> Self {
        Self::Element(node)
    }
}

impl<'a> From<&'a SourcePlace> for Place<'a> {
    fn from(kept: &'a SourcePlace) -> Self {
        Self::Kept(kept)
    }
}

/// Place of an element in a file, for errors and remarks that come after reading.
#[derive(Clone, Debug)]
pub(super) struct SourcePlace {
    pub(super) position: SourcePosition,
    pub(super) element: String,
    pub(super) name: String,
    /// A remark without a reason.
    pub(super) note: ImportNote,
}

impl SourcePlace {
    /// A remark on this place.
    pub(super) fn note(&self, reason: impl Into<String>) -> ImportNote {
        // The text of the kept remark already names the file if that is another one.
        ImportNote {
            reason: reason.into() + &self.note.reason,
            ..self.note.clone()
        }
    }

    /// There is no frame with this name.
    pub(super) fn unknown(&self, frame: &str) -> LoadError {
        LoadError::UnknownFrame {
            at: self.position.clone(),
            element: self.element.clone(),
            name: self.name.clone(),
            frame: frame.into(),
        }
    }

    /// Frames are placed in each other in a circle.
    pub(super) fn cycle(&self) -> LoadError {
        LoadError::FrameCycle {
            at: self.position.clone(),
            element: self.element.clone(),
            name: self.name.clone(),
        }
    }

    /// The name is there already.
    pub(super) fn duplicate(&self, name: &str) -> LoadError {
        LoadError::DuplicateName {
            at: self.position.clone(),
            element: self.element.clone(),
            name: name.into(),
        }
    }

    /// A value cannot be understood.
    pub(super) fn malformed(
        &self,
        attribute: &str,
        value: &str,
        reason: impl Into<String>,
    ) -> LoadError {
        LoadError::Malformed {
            at: self.position.clone(),
            element: self.element.clone(),
            name: self.name.clone(),
            attribute: attribute.into(),
            value: value.into(),
            reason: reason.into(),
        }
    }

    /// A number is infinite or NaN.
    pub(super) fn non_finite(&self, attribute: &str) -> LoadError {
        LoadError::NonFinite {
            at: self.position.clone(),
            element: self.element.clone(),
            name: self.name.clone(),
            quantity: attribute.into(),
        }
    }

    /// The robot needs something that cannot be modelled.
    pub(super) fn unsupported(&self, reason: impl Into<String>) -> LoadError {
        LoadError::Unsupported {
            at: self.position.clone(),
            element: self.element.clone(),
            name: self.name.clone(),
            reason: reason.into(),
        }
    }

    /// A child element is missing.
    pub(super) fn missing(&self, missing: &str) -> LoadError {
        LoadError::Missing {
            at: self.position.clone(),
            element: self.element.clone(),
            name: self.name.clone(),
            missing: missing.into(),
        }
    }
}

/// The names of the elements from the root down to one.
pub(super) fn path(node: Node<'_>) -> String {
    let mut tags: Vec<&str> = node.ancestors().filter(Node::is_element).map(tag).collect();
    tags.reverse();
    tags.join("/")
}

/// Elements that errors and remarks inside them are named after, the innermost first.
const NAMED: [&str; 5] = ["link", "joint", "frame", "model", "world"];

/// An element, from the link, joint, … that it is a part of down to it, as in `joint/limit`.
pub(super) fn element(node: Node<'_>) -> String {
    let mut tags = Vec::new();
    for part in node
        .ancestors()
        .take_while(|part| part.parent_element().is_some())
    {
        tags.push(tag(part));
        if is_named(&part) {
            break;
        }
    }
    if tags.is_empty() {
        return tag(node).into();
    }
    tags.reverse();
    tags.join("/")
}

fn is_named(part: &Node<'_>) -> bool {
    NAMED.contains(&tag(*part)) && part.has_attribute("name")
}

/// Name of the link, joint, … that an element is a part of.
pub(super) fn name<'a>(node: Node<'a>) -> &'a str {
    let in_root = |node: &Node<'_>| node.parent_element().is_some();
    let mut parts = node.ancestors().take_while(in_root);
    let part = parts
        .clone()
        .find(is_named)
        .or_else(|| parts.by_ref().last());
    let part = part.unwrap_or(node);
    let name = part
        .attribute("name")
        .or_else(|| part.attribute("reference"));
    name.unwrap_or_default()
}
