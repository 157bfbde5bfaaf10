//! From text to an XML document with the right root, or an error that says why not.
//!
//! The XML parser takes nesting of any depth in linear time, but its checks are quadratic in the number of attributes of an
//! element and of name spaces; both are bounded here. Document types are refused: descriptions have no use for
//! entities, whose expansion can be arbitrarily long.

use roxmltree::{Document, Error, ParsingOptions};

use crate::error::LoadError;

/// Most attributes of an element: no element of a description has a tenth of them, and checking so many takes milliseconds.
const MAX_ATTRIBUTES: usize = 1000;

/// Most declarations of name spaces in a file: a description has ten or so.
const MAX_NAMESPACES: usize = 1000;

/// Parses a text whose root element must be `root`.
pub(super) fn parse<'a>(file: &str, text: &'a str, root: &str) -> Result<Document<'a>, LoadError> {
    if text.trim_start_matches(BYTE_ORDER_MARK).trim().is_empty() {
        return Err(LoadError::Empty { file: file.into() });
    }
    check_amounts(file, text)?;
    let options = ParsingOptions {
        allow_dtd: false,
        ..ParsingOptions::default()
    };
    let document =
        Document::parse_with_options(text, options).map_err(|error| not_xml(file, text, &error))?;
    let element = document.root_element().tag_name().name();
    if element != root {
        return Err(LoadError::NotARobot {
            file: file.into(),
            element: element.into(),
            expected: root.into(),
        });
    }
    Ok(document)
}

/// What some editors write at the start of a file.
const BYTE_ORDER_MARK: char = '\u{feff}';

fn check_amounts(file: &str, text: &str) -> Result<(), LoadError> {
    let unsupported = |at: &str, reason: String| LoadError::UnsupportedXml {
        file: file.into(),
        line: line_of(text, text.len() - at.len()),
        reason,
    };
    let mut namespaces = 0;
    for at in Tags(text) {
        let tag = at[1..].split('<').next().unwrap_or_default();
        if tag.bytes().filter(|&byte| byte == b'=').count() > MAX_ATTRIBUTES {
            let reason = format!("an element with more than {MAX_ATTRIBUTES} attributes");
            return Err(unsupported(at, reason));
        }
        namespaces += tag.matches("xmlns").count();
        if namespaces > MAX_NAMESPACES {
            let reason = format!("more than {MAX_NAMESPACES} declarations of name spaces");
            return Err(unsupported(at, reason));
        }
    }
    Ok(())
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

fn not_xml(file: &str, text: &str, error: &Error) -> LoadError {
    let (file, position) = (file.to_owned(), error.pos());
    let (line, column) = (position.row, position.col);
    match error {
        Error::DtdDetected => LoadError::UnsupportedXml {
            file,
            line: line_of(text, text.find("<!DOCTYPE").unwrap_or_default()),
            reason: "a document type declaration; remove it".into(),
        },
        Error::UnknownNamespace(prefix, _) if prefix == "xacro" => LoadError::NotExpanded {
            file,
            line,
            found: "an element or attribute of xacro".into(),
        },
        _ => LoadError::NotXml {
            file,
            line,
            column,
            reason: without_position(error),
        },
    }
}

/// What the parser says, without the position that it puts at the end.
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
