//! COLLADA: the triangles of the visual scene, with their transforms, unit, up axis and diffuse colours.
//!
//! [`asset`] says how the file lies in the world, [`node`] reads the nodes of the scene, [`geometry`] the triangles of
//! a shape, [`material`] its colours; [`scene`] walks from one to the others and draws. References are followed through
//! one table of all identifiers, and what is referred to is read once, however often it is.
//!
//! # References
//! [COLLADA 1.4.1], specification of the Khronos Group, 2008.

mod asset;
mod geometry;
mod material;
mod node;
mod scene;

use std::collections::HashMap;

use super::soup::Soup;
use crate::input::xml::{self, Node, XmlError, tag};
use crate::model::UpAxis;
use crate::nested::IntoNested;

/// Reads what the scene of a file shows; without a scene, all its shapes.
pub(super) fn read(bytes: &[u8], up_axis: UpAxis) -> Result<Soup, String> {
    let text = String::from_utf8_lossy(bytes);
    let document = xml::parse(&text).map_err(not_read)?;
    let root = document.root_element();
    if tag(root) != "COLLADA" {
        return Err("is not COLLADA".into());
    }
    let mut soup = Soup::default();
    let world = asset::placement(root, up_axis, &mut soup)?;
    scene::draw(root, &world, &mut soup)?;
    Ok(soup)
}

fn not_read(error: XmlError) -> String {
    match error {
        XmlError::Empty => "is empty".into(),
        XmlError::Unsupported { line, reason } => format!("has {reason} (line {line})"),
        XmlError::NotXml { line, .. } | XmlError::UnknownPrefix { line, .. } => {
            format!("is not well-formed XML on line {line}")
        }
    }
}

/// The elements of a file by their identifiers.
struct Ids<'a>(HashMap<&'a str, Node<'a>>);

impl<'a> Ids<'a> {
    fn of(root: Node<'a>) -> Self {
        let elements = root.descendants();
        Self(
            elements
                .filter_map(|e| Some((e.attribute("id")?, e)))
                .collect(),
        )
    }

    /// The element that an attribute refers to: `#id`, or in some attributes the identifier alone.
    fn target(&self, node: Node<'a>, attribute: &str) -> Option<Node<'a>> {
        let reference = node.attribute(attribute)?;
        let id = reference.strip_prefix('#').unwrap_or(reference);
        self.0.get(id).copied()
    }
}

/// The words of an element, also around comments.
fn words<'a>(node: Node<'a>) -> impl Iterator<Item = &'a str> {
    let texts = node
        .children()
        .filter_map(|child| child.text().filter(|_| child.is_text()));
    texts.nested(str::split_ascii_whitespace)
}

/// A number, with the decimal comma that some exporters write.
fn number<T: std::str::FromStr>(word: &str) -> Option<T> {
    let plain = word.parse().ok();
    plain.or_else(|| word.replace(',', ".").parse().ok())
}

/// Reads `N` finite numbers, which must be all that an element holds.
fn numbers<const N: usize>(node: Node<'_>) -> Result<[f64; N], String> {
    let mut words = words(node);
    let mut next = || {
        words
            .next()
            .and_then(number)
            .filter(|x: &f64| x.is_finite())
    };
    let mut numbers = [0.0; N];
    let are_numbers = numbers
        .iter_mut()
        .all(|x| next().map(|read| *x = read).is_some());
    if are_numbers && words.next().is_none() {
        return Ok(numbers);
    }
    Err(format!(
        "has a <{}> that is not {N} finite numbers",
        tag(node)
    ))
}

#[cfg(test)]
pub(super) mod tests;
