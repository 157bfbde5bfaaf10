//! Text to an XML document in linear time and memory.
//!
//! The parser takes nesting of any depth in linear time, but its checks are quadratic in the number of attributes of an
//! element and of name spaces; both are bounded here. Document types are refused: neither descriptions nor meshes have
//! a use for entities, whose expansion can be arbitrarily long.

use roxmltree::{Document, Error, ParsingOptions};

use super::MAX_TEXT_BYTES;

/// Most attributes of an element: no element of a robot has a tenth of them, and checking so many takes milliseconds.
const MAX_ATTRIBUTES: usize = 1000;

/// Most declarations of name spaces in a file: a description has ten or so.
const MAX_NAMESPACES: usize = 1000;

/// Byte order mark, which some editors write at the start of a file.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// An element of a document, or a text in it.
pub(crate) type Node<'a> = roxmltree::Node<'a, 'a>;

/// Error for a text that is not a document that is read.
#[derive(Debug, PartialEq)]
pub(crate) enum XmlError {
    /// The file holds no text at all.
    Empty,
    /// The text uses a feature that is not needed and can make reading arbitrarily slow: line, from 1, and feature.
    Unsupported { line: u32, reason: String },
    /// The text is not well-formed: line, from 1, and message of the parser.
    NotXml {
        line: u32,
        column: u32,
        reason: String,
    },
    /// A prefix is not declared: where, from 1, and which.
    UnknownPrefix {
        line: u32,
        column: u32,
        prefix: String,
    },
}

/// Parses a text.
pub(crate) fn parse(text: &str) -> Result<Document<'_>, XmlError> {
    if text.trim_start_matches(BYTE_ORDER_MARK).trim().is_empty() {
        return Err(XmlError::Empty);
    }
    check_amounts(text)?;
    let options = ParsingOptions {
        allow_dtd: false,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options).map_err(|error| not_xml(text, &error))
}

/// The name of the first element with its prefix, or the text in its place; the text need not be XML.
pub(crate) fn first_tag(text: &str) -> &str {
    let tag = Tags(text).next().unwrap_or_default();
    let name = tag.get(1..).unwrap_or_default();
    let end = name.find(|c: char| c.is_whitespace() || matches!(c, '>' | '/'));
    &name[..end.unwrap_or(name.len())]
}

/// Name of an element without prefix.
pub(crate) fn tag<'a>(node: Node<'a>) -> &'a str {
    node.tag_name().name()
}

/// The first child element of a name.
pub(crate) fn child<'a>(node: Node<'a>, name: &str) -> Option<Node<'a>> {
    children(node, name).next()
}

/// The child elements of a name.
pub(crate) fn children<'a>(node: Node<'a>, name: &str) -> impl Iterator<Item = Node<'a>> {
    node.children()
        .filter(move |child| child.is_element() && tag(*child) == name && is_native(*child))
}

/// `true` for an element of the format itself, `false` for one of another name space.
pub(crate) fn is_native(node: Node<'_>) -> bool {
    let namespace = node.tag_name().namespace();
    namespace.is_none() || namespace == node.document().root_element().tag_name().namespace()
}

fn check_amounts(text: &str) -> Result<(), XmlError> {
    if text.len() as u64 > MAX_TEXT_BYTES {
        let reason = format!("more than {MAX_TEXT_BYTES} bytes");
        return Err(XmlError::Unsupported { line: 1, reason });
    }
    let unsupported = |at: &str, reason: String| XmlError::Unsupported {
        line: line_of(text, text.len() - at.len()),
        reason,
    };
    let mut namespaces = 0;
    for at in Tags(text) {
        let tag = start_tag(at);
        if tag.attributes > MAX_ATTRIBUTES {
            let reason = format!("an element with more than {MAX_ATTRIBUTES} attributes");
            return Err(unsupported(at, reason));
        }
        namespaces += tag.text.matches("xmlns").count();
        if namespaces > MAX_NAMESPACES {
            let reason = format!("more than {MAX_NAMESPACES} declarations of name spaces");
            return Err(unsupported(at, reason));
        }
    }
    Ok(())
}

/// A tag without the text that follows it.
struct StartTag<'a> {
    text: &'a str,
    attributes: usize,
}

/// The tag at the start of a text, up to its `>` outside of quotes or to the next `<`, whichever comes first.
fn start_tag(at: &str) -> StartTag<'_> {
    let (mut quote, mut attributes) = (None, 0);
    for (i, byte) in at.bytes().enumerate().skip(1) {
        match (byte, quote) {
            (b'<', _) | (b'>', None) => {
                return StartTag {
                    text: &at[..i],
                    attributes,
                };
            }
            (b'"' | b'\'', None) => quote = Some(byte),
            (b'=', None) => attributes += 1,
            (byte, Some(open)) if byte == open => quote = None,
            _ => {}
        }
    }
    StartTag {
        text: at,
        attributes,
    }
}

/// The text from each tag on; comments, CDATA and processing instructions are passed over.
struct Tags<'a>(&'a str);

impl<'a> Iterator for Tags<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        const NO_TAGS: [(&str, &str); 3] = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")];
        loop {
            let at = &self.0[self.0.find('<')?..];
            let no_tag = NO_TAGS.iter().find(|(start, _)| at.starts_with(start));
            let Some((start, end)) = no_tag else {
                self.0 = &at[1..];
                return Some(at);
            };
            self.0 = &at[start.len()..];
            self.0 = &self.0[self.0.find(end)?..];
        }
    }
}

fn not_xml(text: &str, error: &Error) -> XmlError {
    let position = error.pos();
    let (line, column) = (position.row, position.col);
    match error {
        Error::DtdDetected => XmlError::Unsupported {
            line: line_of(text, text.find("<!DOCTYPE").unwrap_or_default()),
            reason: "a document type declaration; remove it".into(),
        },
        Error::UnknownNamespace(prefix, _) => XmlError::UnknownPrefix {
            line,
            column,
            prefix: prefix.clone(),
        },
        _ => XmlError::NotXml {
            line,
            column,
            reason: without_position(error),
        },
    }
}

/// Message of the parser, without the position that it puts at the end.
fn without_position(error: &Error) -> String {
    let message = error.to_string();
    let position = format!(" at {}", error.pos());
    message.strip_suffix(&position).unwrap_or(&message).into()
}

/// The line of a byte, from 1.
fn line_of(text: &str, position: usize) -> u32 {
    let newlines = text.as_bytes()[..position].iter();
    newlines.fold(1, |line, &byte| line + u32::from(byte == b'\n'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_are_counted_outside_of_quotes_and_text() {
        let tag = start_tag("<a b='=\">=' c=\"'=\">x = y = z</a>");
        assert_eq!((tag.text, tag.attributes), ("<a b='=\">=' c=\"'=\"", 2));
        let text = format!("<a>{}</a>", "=".repeat(2 * MAX_ATTRIBUTES));
        assert!(parse(&text).is_ok());
    }

    #[test]
    fn first_tag_equals_the_root_also_of_what_is_no_xml() {
        let root = "\u{feff}<?xml version='1.0'?>\n<!-- <no> -->\n<sdf:sdf version='1.9'>";
        assert_eq!(first_tag(root), "sdf:sdf");
        assert_eq!(first_tag("<a/>"), "a");
        assert_eq!(first_tag("key = value"), "");
        assert_eq!(first_tag("<"), "");
    }

    #[test]
    fn texts_beyond_the_limit_are_refused_before_they_are_parsed() {
        let text = " ".repeat(usize::try_from(MAX_TEXT_BYTES).unwrap()) + "<a/>";
        assert!(matches!(
            parse(&text),
            Err(XmlError::Unsupported { line: 1, .. })
        ));
    }
}
