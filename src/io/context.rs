//! Errors and remarks that name the place in a file.

use crate::error::LoadError;
pub(super) use crate::input::xml::{Node, child, children, is_native, tag};
use crate::io::ImportNote;

/// The source of a description and the remarks about it.
#[derive(Debug)]
pub(super) struct Context<'a> {
    pub(super) file: &'a str,
    pub(super) warnings: Vec<ImportNote>,
    pub(super) ignored: Vec<ImportNote>,
    /// Start of each line after the first.
    line_starts: Vec<usize>,
}

impl<'a> Context<'a> {
    pub(super) fn new(file: &'a str, text: &str) -> Self {
        let newlines = text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n');
        Self {
            file,
            warnings: Vec::new(),
            ignored: Vec::new(),
            line_starts: newlines.map(|(i, _)| i + 1).collect(),
        }
    }

    /// The line on which an element starts, from 1.
    pub(super) fn line(&self, node: Node<'_>) -> u32 {
        let start = node.range().start;
        let line = 1 + self.line_starts.partition_point(|&at| at <= start);
        u32::try_from(line).unwrap_or(u32::MAX)
    }

    /// Remarks on something that was read.
    pub(super) fn warn(&mut self, node: Node<'_>, reason: impl Into<String>) {
        let note = self.note(node, "", reason.into());
        self.warnings.push(note);
    }

    /// Remarks on an element that is not used.
    pub(super) fn ignore(&mut self, node: Node<'_>, reason: impl Into<String>) {
        let note = self.note(node, "", reason.into());
        self.ignored.push(note);
    }

    /// Remarks on an attribute that is not used.
    pub(super) fn ignore_attribute(
        &mut self,
        node: Node<'_>,
        attribute: &str,
        reason: impl Into<String>,
    ) {
        let note = self.note(node, &format!("@{attribute}"), reason.into());
        self.ignored.push(note);
    }

    /// Takes over the remarks on another file.
    pub(super) fn take_remarks(&mut self, other: Context<'_>) {
        let suffix = format!(" (in {})", other.file);
        let with_file = |mut note: ImportNote| {
            note.reason += &suffix;
            note
        };
        self.warnings
            .extend(other.warnings.into_iter().map(with_file));
        self.ignored
            .extend(other.ignored.into_iter().map(with_file));
    }

    /// A remark on an element, or with a suffix on a part of it.
    pub(super) fn note(&self, node: Node<'_>, suffix: &str, reason: String) -> ImportNote {
        ImportNote {
            path: path(node) + suffix,
            name: name(node).into(),
            line: self.line(node),
            reason,
        }
    }

    /// An attribute or child element is missing.
    pub(super) fn missing(&self, node: Node<'_>, missing: impl Into<String>) -> LoadError {
        LoadError::Missing {
            file: self.file.into(),
            element: tag(node).into(),
            name: self.name_or_line(node),
            missing: missing.into(),
        }
    }

    /// The text of an attribute cannot be understood.
    pub(super) fn malformed(
        &self,
        node: Node<'_>,
        attribute: &str,
        reason: impl Into<String>,
    ) -> LoadError {
        let value = node.attribute(attribute).unwrap_or_default();
        self.malformed_value(node, attribute, value, reason)
    }

    /// A value of an element cannot be understood.
    pub(super) fn malformed_value(
        &self,
        node: Node<'_>,
        attribute: &str,
        value: &str,
        reason: impl Into<String>,
    ) -> LoadError {
        LoadError::Malformed {
            file: self.file.into(),
            element: tag(node).into(),
            name: self.name_or_line(node),
            attribute: attribute.into(),
            value: value.into(),
            reason: reason.into(),
        }
    }

    /// A number of an attribute is infinite or not a number.
    pub(super) fn non_finite(&self, node: Node<'_>, attribute: &str) -> LoadError {
        LoadError::NonFinite {
            file: self.file.into(),
            element: tag(node).into(),
            name: self.name_or_line(node),
            quantity: attribute.into(),
        }
    }

    /// Error for something that is left to expand.
    pub(super) fn not_expanded(&self, node: Node<'_>, found: impl Into<String>) -> LoadError {
        LoadError::NotExpanded {
            file: self.file.into(),
            line: self.line(node),
            found: found.into(),
        }
    }

    /// The name of what an element belongs to, or where it is.
    pub(super) fn name_or_line(&self, node: Node<'_>) -> String {
        let name = name(node);
        if name.is_empty() {
            return format!("on line {}", self.line(node));
        }
        name.into()
    }
}

/// The names of the elements from the root down to one.
fn path(node: Node<'_>) -> String {
    let mut tags: Vec<&str> = node.ancestors().filter(Node::is_element).map(tag).collect();
    tags.reverse();
    tags.join("/")
}

/// Elements that errors and remarks inside them are named after, the innermost first.
const NAMED: [&str; 5] = ["link", "joint", "frame", "model", "world"];

/// Name of the link, joint, … that an element is a part of.
fn name<'a>(node: Node<'a>) -> &'a str {
    let in_root = |node: &Node<'_>| node.parent_element().is_some();
    let mut parts = node.ancestors().take_while(in_root);
    let is_named = |part: &Node<'_>| NAMED.contains(&tag(*part)) && part.has_attribute("name");
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
