//! Parts of contacts that have parameters.

/// A part of contacts that has numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ContactPart {
    Point(usize),
    Law(usize),
    /// Torsional and rolling friction of a point.
    Turning(usize),
    Terrain,
    Shape(usize),
    ShapeMaterial(usize),
    ShapeTurning(usize),
    PairLaw,
    PairTurning,
}

impl ContactPart {
    /// Whether it has torsional and rolling friction.
    pub(crate) fn is_turning(self) -> bool {
        matches!(
            self,
            Self::Turning(_) | Self::ShapeTurning(_) | Self::PairTurning
        )
    }
}
