//! Reads text as an XML document with the right root, or gives an error that says why not.

use roxmltree::Document;

use crate::error::LoadError;
use crate::input::xml::{self, XmlError};

/// Parses a text whose root element must be `root`.
pub(super) fn parse<'a>(file: &str, text: &'a str, root: &str) -> Result<Document<'a>, LoadError> {
    let document = parse_any(file, text)?;
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

/// Parses a text, whatever its root element.
pub(super) fn parse_any<'a>(file: &str, text: &'a str) -> Result<Document<'a>, LoadError> {
    xml::parse(text).map_err(|error| load_error(file, error))
}

/// `true` if the first element of a text has a name, whatever its prefix.
pub(super) fn begins_with(text: &str, root: &str) -> bool {
    let tag = xml::first_tag(text);
    tag.rsplit_once(':').map_or(tag, |(_, name)| name) == root
}

fn load_error(file: &str, error: XmlError) -> LoadError {
    let file = file.to_owned();
    match error {
        XmlError::Empty => LoadError::Empty { file },
        XmlError::Unsupported { line, reason } => LoadError::UnsupportedXml { file, line, reason },
        XmlError::UnknownPrefix { line, prefix, .. } if prefix == "xacro" => {
            LoadError::NotExpanded {
                file,
                line,
                found: "an element or attribute of xacro".into(),
            }
        }
        XmlError::UnknownPrefix {
            line,
            column,
            prefix,
        } => LoadError::NotXml {
            file,
            line,
            column,
            reason: format!("an unknown namespace prefix '{prefix}'"),
        },
        XmlError::NotXml {
            line,
            column,
            reason,
        } => LoadError::NotXml {
            file,
            line,
            column,
            reason,
        },
    }
}
