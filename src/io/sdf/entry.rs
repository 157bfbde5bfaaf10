//! A model of a file or of a world, written there or included.

use super::reader::{Overrides, Reader, attribute};
use super::scene::WORLD;
use super::values::text_of;
use crate::error::LoadError;
use crate::io::context::{Node, child, tag};

/// Reads a model in the world or on its own, in this file or in another one; returns its index.
pub(super) fn read_model(
    reader: &mut Reader<'_, '_, '_>,
    model: Node<'_>,
) -> Result<usize, LoadError> {
    if tag(model) == "include" {
        return reader.include(model, WORLD);
    }
    reader.model(model, WORLD, Overrides::default())
}

/// The name of a model, or of an include: its own, or else the last part of its reference.
pub(super) fn name(model: Node<'_>) -> String {
    let of_child = |name| {
        child(model, name)
            .map(text_of)
            .filter(|text| !text.is_empty())
    };
    let of_uri = || {
        let uri = of_child("uri")?;
        uri.rsplit('/')
            .find(|part| !part.is_empty())
            .map(Into::into)
    };
    if tag(model) == "model" {
        return attribute(model, "name").unwrap_or_default();
    }
    of_child("name").or_else(of_uri).unwrap_or_default()
}
