//! Number of calls that working memory is made for.

/// Number of calls that working memory is made for: what is found once for all calls and pays only over several is left out for a single one. Results
/// are the same to rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Calls {
    One,
    Many,
}
