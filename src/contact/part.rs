//! Parts of contacts that have parameters.

/// A part of contacts that has numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ContactPart {
    Point(usize),
    Law(usize),
    /// Torsional and rolling friction of a point.
    Turning(usize),
    /// Margin of a point.
    Margin(usize),
    Terrain,
    Shape(usize),
    Material(MaterialOf, MaterialPart),
    PairLaw,
    PairTurning,
}

/// The owner of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MaterialOf {
    Shape(usize),
    /// A pair of links or surfaces whose material is given.
    Pair(usize),
}

/// Numbers of a material, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MaterialPart {
    /// With restitution and margin.
    Friction,
    Turning,
    Compliance,
}

impl ContactPart {
    /// Whether it has torsional and rolling friction.
    pub(crate) fn is_turning(self) -> bool {
        matches!(
            self,
            Self::Turning(_) | Self::Material(_, MaterialPart::Turning) | Self::PairTurning
        )
    }
    /// Whether it has numbers of a compliance.
    pub(crate) fn is_compliance(self) -> bool {
        matches!(self, Self::Material(_, MaterialPart::Compliance))
    }
}
