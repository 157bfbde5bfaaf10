//! Precision of numbers.

/// Precision of generated code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    /// `double`, 16 digits.
    #[default]
    Double,
    /// `float`, 7 digits.
    Single,
}

impl Precision {
    /// The type in C.
    pub(super) fn real(self) -> &'static str {
        match self {
            Self::Double => "double",
            Self::Single => "float",
        }
    }

    /// The product with a sum, rounded once.
    pub(super) fn fma(self) -> &'static str {
        match self {
            Self::Double => "fma",
            Self::Single => "fmaf",
        }
    }
}
