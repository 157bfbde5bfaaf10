//! Numbers in attributes: what another reader would drop or swallow is an error here.

use super::context::{Context, Node};
use crate::error::LoadError;

/// The finite number of an attribute; `None` if there is no such attribute.
pub(super) fn number(
    context: &Context<'_>,
    node: Node<'_>,
    attribute: &str,
) -> Result<Option<f64>, LoadError> {
    Ok(numbers::<1>(context, node, attribute)?.map(|[x]| x))
}

/// The N finite numbers of an attribute; `None` if there is no such attribute.
pub(super) fn numbers<const N: usize>(
    context: &Context<'_>,
    node: Node<'_>,
    attribute: &str,
) -> Result<Option<[f64; N]>, LoadError> {
    let Some(numbers) = any_numbers(context, node, attribute)? else {
        return Ok(None);
    };
    if numbers.iter().all(|x| x.is_finite()) {
        return Ok(Some(numbers));
    }
    Err(context.non_finite(node, attribute))
}

/// The N finite numbers of an attribute that must be there.
pub(super) fn required<const N: usize>(
    context: &Context<'_>,
    node: Node<'_>,
    attribute: &str,
) -> Result<[f64; N], LoadError> {
    numbers(context, node, attribute)?
        .ok_or_else(|| context.missing(node, format!("attribute {attribute}")))
}

/// A number of an attribute that may be infinite towards one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Bound {
    /// There is no such attribute.
    Absent,
    /// A finite number.
    Finite(f64),
    /// Infinite: no bound at all.
    Infinite,
}

/// The bound of an attribute, which may be `no_bound`, an infinity.
pub(super) fn bound(
    context: &Context<'_>,
    node: Node<'_>,
    attribute: &str,
    no_bound: f64,
) -> Result<Bound, LoadError> {
    match any_numbers::<1>(context, node, attribute)? {
        None => Ok(Bound::Absent),
        Some([x]) if x == no_bound => Ok(Bound::Infinite),
        Some([x]) if x.is_finite() => Ok(Bound::Finite(x)),
        Some(_) => Err(context.non_finite(node, attribute)),
    }
}

fn any_numbers<const N: usize>(
    context: &Context<'_>,
    node: Node<'_>,
    attribute: &str,
) -> Result<Option<[f64; N]>, LoadError> {
    let Some(text) = node.attribute(attribute) else {
        return Ok(None);
    };
    parse(text)
        .map(Some)
        .map_err(|reason| context.malformed(node, attribute, reason))
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
