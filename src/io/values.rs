//! Values of elements: what another reader would drop or swallow is an error here.
//!
//! A format writes them as attributes or as the texts of child elements; what is made of the text is the same.

use std::borrow::Cow;

use super::context::{Context, Node, child};
use super::schema::{UNKNOWN, check_attributes};
use crate::error::LoadError;

/// The entries of a rotational inertia, row by row, as formats call them.
pub(super) const INERTIA_ENTRIES: [&str; 6] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];

/// A way in which a format writes the values of an element.
pub(super) trait Values {
    /// The text of a value; `None` if the element has none of that name.
    fn value<'a>(
        context: &mut Context<'_>,
        node: Node<'a>,
        name: &str,
    ) -> Result<Option<Cow<'a, str>>, LoadError>;

    /// Description of a value that is missing.
    fn called(name: &str) -> String;

    /// The text of a value that must be there, and must not be empty.
    fn required_text<'a>(
        context: &mut Context<'_>,
        node: Node<'a>,
        name: &str,
    ) -> Result<Cow<'a, str>, LoadError> {
        let text = Self::value(context, node, name)?.filter(|text| !text.is_empty());
        text.ok_or_else(|| context.missing(node, Self::called(name)))
    }

    /// The N finite numbers of a value; `None` if there is no such value.
    fn numbers<const N: usize>(
        context: &mut Context<'_>,
        node: Node<'_>,
        name: &str,
    ) -> Result<Option<[f64; N]>, LoadError> {
        match Self::value(context, node, name)? {
            None => Ok(None),
            Some(text) => finite(context, node, name, &text).map(Some),
        }
    }

    /// The finite number of a value; `None` if there is no such value.
    fn number(
        context: &mut Context<'_>,
        node: Node<'_>,
        name: &str,
    ) -> Result<Option<f64>, LoadError> {
        Ok(Self::numbers::<1>(context, node, name)?.map(|[x]| x))
    }

    /// The N finite numbers of a value that must be there.
    fn required<const N: usize>(
        context: &mut Context<'_>,
        node: Node<'_>,
        name: &str,
    ) -> Result<[f64; N], LoadError> {
        Self::numbers(context, node, name)?.ok_or_else(|| context.missing(node, Self::called(name)))
    }
}

/// Values as attributes, as in `<mass value="2"/>`.
#[derive(Debug)]
pub(super) enum Attributes {}

impl Values for Attributes {
    fn value<'a>(
        _: &mut Context<'_>,
        node: Node<'a>,
        name: &str,
    ) -> Result<Option<Cow<'a, str>>, LoadError> {
        Ok(node.attribute(name).map(Cow::Borrowed))
    }

    fn called(name: &str) -> String {
        format!("attribute {name}")
    }
}

/// Values as texts of child elements.
#[derive(Debug)]
pub(super) enum Elements {}

impl Values for Elements {
    fn value<'a>(
        context: &mut Context<'_>,
        node: Node<'a>,
        name: &str,
    ) -> Result<Option<Cow<'a, str>>, LoadError> {
        let Some(value) = child(node, name) else {
            return Ok(None);
        };
        check_value(context, value, "")?;
        Ok(Some(Cow::Owned(text_of(value))))
    }

    fn called(name: &str) -> String {
        format!("child element <{name}>")
    }
}

/// The text of an element, without the white space around it.
pub(super) fn text_of(node: Node<'_>) -> String {
    let texts = node.children().filter(Node::is_text);
    let text: String = texts.filter_map(|text| text.text()).collect();
    text.trim().to_owned()
}

/// Reports what a value holds beside its text and the attributes that are read.
pub(super) fn check_value(
    context: &mut Context<'_>,
    node: Node<'_>,
    attributes: &str,
) -> Result<(), LoadError> {
    check_attributes(context, node, attributes)?;
    for inner in node.children().filter(Node::is_element) {
        context.ignore(inner, UNKNOWN);
    }
    Ok(())
}

/// The finite numbers of a text that belongs to an element.
pub(super) fn finite<const N: usize>(
    context: &Context<'_>,
    node: Node<'_>,
    name: &str,
    text: &str,
) -> Result<[f64; N], LoadError> {
    let numbers: [f64; N] = any(context, node, name, text)?;
    if numbers.iter().all(|x| x.is_finite()) {
        return Ok(numbers);
    }
    Err(context.non_finite(node, name))
}

/// The numbers of a text that belongs to an element, infinite ones among them.
pub(super) fn any<const N: usize>(
    context: &Context<'_>,
    node: Node<'_>,
    name: &str,
    text: &str,
) -> Result<[f64; N], LoadError> {
    parse(text).map_err(|reason| context.malformed_value(node, name, text, reason))
}

/// Parses N numbers between white space.
pub(super) fn parse<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let mut numbers = [0.0; N];
    let mut count = 0;
    for token in text.split_whitespace() {
        let number = token
            .parse()
            .map_err(|_| format!("\"{token}\" is not a number"))?;
        if let Some(place) = numbers.get_mut(count) {
            *place = number;
        }
        count += 1;
    }
    if count == N {
        return Ok(numbers);
    }
    let plural = if N == 1 { "" } else { "s" };
    Err(format!("expected {N} number{plural}, found {count}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parsed_numbers_equal_the_tokens_and_nothing_is_dropped() {
        assert_eq!(parse(" 1\t-2.5e3\r\n .5 "), Ok([1.0, -2500.0, 0.5]));
        assert_eq!(
            parse::<3>("1 2 x 3"),
            Err("\"x\" is not a number".to_owned())
        );
        assert_eq!(
            parse::<3>("1 2"),
            Err("expected 3 numbers, found 2".to_owned())
        );
        assert_eq!(
            parse::<1>("1 2"),
            Err("expected 1 number, found 2".to_owned())
        );
        assert_eq!(parse::<1>(""), Err("expected 1 number, found 0".to_owned()));
        assert_eq!(parse::<1>("1,5"), Err("\"1,5\" is not a number".to_owned()));
    }
}
