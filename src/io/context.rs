//! Errors and remarks that name the place in a file.

use super::place::{ImportNote, Place, SourcePlace, element, name, path};
use crate::error::{LoadError, SourcePosition};
pub(super) use crate::input::xml::{Node, child, children, is_native, tag};
use crate::sim::Servo;

/// The source of a description and the remarks about it.
#[derive(Debug)]
pub(super) struct Context<'a> {
    pub(super) file: &'a str,
    pub(super) warnings: Vec<ImportNote>,
    pub(super) ignored: Vec<ImportNote>,
    /// Joints with inputs, with their servos, if the description states any.
    pub(super) commands: Option<Vec<(String, Option<Servo>)>>,
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
            commands: None,
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
    pub(super) fn warn<'p>(&mut self, place: impl Into<Place<'p>>, reason: impl Into<String>) {
        let note = self.note(place, reason);
        self.warnings.push(note);
    }

    /// Remarks on something that is not used.
    pub(super) fn ignore<'p>(&mut self, place: impl Into<Place<'p>>, reason: impl Into<String>) {
        let note = self.note(place, reason);
        self.ignored.push(note);
    }

    /// Remarks on an attribute that is not used.
    pub(super) fn ignore_attribute(
        &mut self,
        node: Node<'_>,
        attribute: &str,
        reason: impl Into<String>,
    ) {
        let mut note = self.note(node, reason);
        note.path.extend(["@", attribute]);
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

    /// A remark on a part.
    pub(super) fn note<'p>(
        &self,
        place: impl Into<Place<'p>>,
        reason: impl Into<String>,
    ) -> ImportNote {
        let reason = reason.into();
        let (path, name, line) = match place.into() {
            Place::Element(node) => (path(node), name(node), self.line(node)),
            Place::Part(path, name) => (path.into(), name, 0),
            Place::Kept(kept) => return kept.note(reason),
        };
        ImportNote {
            path,
            name: name.into(),
            line,
            reason,
        }
    }

    /// The file and the line of an element.
    pub(super) fn position(&self, node: Node<'_>) -> SourcePosition {
        SourcePosition {
            file: self.file.into(),
            line: self.line(node),
        }
    }

    /// The place of an element, for later.
    pub(super) fn keep(&self, node: Node<'_>) -> SourcePlace {
        SourcePlace {
            position: self.position(node),
            element: element(node),
            name: self.name_or_line(node),
            note: self.note(node, ""),
        }
    }

    /// An attribute or child element is missing.
    pub(super) fn missing(&self, node: Node<'_>, missing: impl Into<String>) -> LoadError {
        LoadError::Missing {
            at: self.position(node),
            element: element(node),
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
            at: self.position(node),
            element: element(node),
            name: self.name_or_line(node),
            attribute: attribute.into(),
            value: value.into(),
            reason: reason.into(),
        }
    }

    /// A number of an attribute is infinite or NaN.
    pub(super) fn non_finite(&self, node: Node<'_>, attribute: &str) -> LoadError {
        LoadError::NonFinite {
            at: self.position(node),
            element: element(node),
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

    /// The name of what an element belongs to, or its position.
    pub(super) fn name_or_line(&self, node: Node<'_>) -> String {
        let name = name(node);
        if name.is_empty() {
            return format!("on line {}", self.line(node));
        }
        name.into()
    }
}
