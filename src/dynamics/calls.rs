//! Number of calls that working memory is made for.

/// Expected reuse of working memory: precomputation that pays only over several calls is skipped for a single one. Results are equal to rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Calls {
    One,
    Many,
}
