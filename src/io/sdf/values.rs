//! Values as texts of child elements, as in `<mass>2</mass>`.

use std::borrow::Cow;

use crate::error::LoadError;
use crate::io::context::{Context, Node};
use crate::io::motion::{Bound, bound};
use crate::io::values::Values;
pub(super) use crate::io::values::{Elements, check_value, text_of};

/// Value that means “no limit” in SDF before version 1.8; larger values mean the same.
const UNLIMITED: f64 = 1e16;

/// The text of a child element, if there is one that is not empty.
pub(super) fn text(
    context: &mut Context<'_>,
    node: Node<'_>,
    name: &str,
) -> Result<Option<String>, LoadError> {
    let text = Elements::value(context, node, name)?.filter(|text| !text.is_empty());
    Ok(text.map(Cow::into_owned))
}

/// A limit, `None` where there is none, or one that is infinite towards its side, or as good as.
///
/// * `side` – sign of the side on which it is
pub(super) fn limit(
    context: &mut Context<'_>,
    node: Node<'_>,
    name: &str,
    side: f64,
) -> Result<Option<f64>, LoadError> {
    let text = text(context, node, name)?;
    match bound(context, node, name, text.as_deref(), [side, UNLIMITED])? {
        Bound::Finite(x) => Ok(Some(x)),
        Bound::Absent | Bound::Infinite => Ok(None),
    }
}

/// A limit of velocity or effort: a negative one is none.
pub(super) fn magnitude(
    context: &mut Context<'_>,
    node: Node<'_>,
    name: &str,
) -> Result<Option<f64>, LoadError> {
    if text(context, node, name)?.is_some_and(|text| text == "-inf") {
        return Ok(None);
    }
    Ok(limit(context, node, name, 1.0)?.filter(|&x| x >= 0.0))
}

/// Parses a truth value: `true` or `1`; `false`, `0` or an empty text.
pub(super) fn truth(
    context: &Context<'_>,
    node: Node<'_>,
    name: &str,
    text: &str,
) -> Result<bool, LoadError> {
    match text.trim().to_ascii_lowercase().as_str() {
        "true" | "1" => Ok(true),
        "false" | "0" | "" => Ok(false),
        _ => Err(context.malformed_value(node, name, text, "expected true or false")),
    }
}
