//! Laws that smoothing applies to.

use super::system::Kind;

/// The laws of a problem that are smoothed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Smoothed {
    /// Those of rays, cones and intervals.
    #[default]
    All,
    /// Those of rays and of cones; intervals keep the exact law.
    RaysAndCones,
    /// Those of cones; rays and intervals keep the exact law.
    Cones,
}

impl Smoothed {
    /// κ for the law of a unit, 0 for the exact one.
    pub(super) fn kappa(self, kappa: f64, kind: Kind) -> f64 {
        match (self, kind) {
            (_, Kind::Row | Kind::Spin | Kind::Roll)
            | (Self::Cones, Kind::Ray | Kind::Interval)
            | (Self::RaysAndCones, Kind::Interval) => 0.0,
            _ => kappa,
        }
    }
}
