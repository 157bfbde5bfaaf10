//! Units of logged quantities.

use std::f64::consts::{PI, TAU};

/// Quantity of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Position of a joint, all its coordinates q.
    Position,
    /// Velocity of a joint, all its coordinates v.
    Velocity,
    /// Acceleration of a joint, length as v.
    Acceleration,
    /// Joint force, length as v.
    Force,
}

impl Quantity {
    pub(super) const ALL: [Self; 4] = [
        Self::Position,
        Self::Velocity,
        Self::Acceleration,
        Self::Force,
    ];

    /// The word for it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Force => "force",
        }
    }
}

/// Unit of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Unit {
    /// The SI unit of the quantity: rad or m, with s and s²; N·m or N.
    Si,
    /// Degree, degree per second, degree per second squared.
    Degree,
    /// Revolution, revolution per second, revolution per second squared.
    Turn,
    /// Revolution per minute; a unit of velocity.
    TurnPerMinute,
    /// Millimetre, millimetre per second, millimetre per second squared.
    Millimetre,
    /// SI value of one unit of the channel: for a motor current the torque constant times the gear ratio, 1000 for kN.
    Scale(f64),
}

/// Numbers of a joint that a unit fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dimension {
    Angle,
    Length,
    /// Several numbers of different dimensions, or none.
    Mixed,
}

impl Unit {
    /// SI units in one unit of this kind.
    ///
    /// # Errors
    /// Why the unit does not fit.
    pub(super) fn factor(self, quantity: Quantity, dimension: Dimension) -> Result<f64, String> {
        let (factor, fits) = match self {
            Self::Si => return Ok(1.0),
            Self::Scale(factor) if factor.is_finite() && factor != 0.0 => return Ok(factor),
            Self::Scale(factor) => {
                return Err(format!(
                    "a scale of {factor} is not a unit: expected a finite number other than 0"
                ));
            }
            Self::Degree => (PI / 180.0, Dimension::Angle),
            Self::Turn => (TAU, Dimension::Angle),
            Self::TurnPerMinute if quantity != Quantity::Velocity => {
                return Err("turns a minute are a unit of velocity".into());
            }
            Self::TurnPerMinute => (TAU / 60.0, Dimension::Angle),
            Self::Millimetre => (1e-3, Dimension::Length),
        };
        if quantity == Quantity::Force {
            return Err(format!("{self:?} is not a unit of force"));
        }
        if fits != dimension {
            return Err(format!(
                "{self:?} is not a unit of a joint whose coordinate is {}",
                match dimension {
                    Dimension::Angle => "an angle",
                    Dimension::Length => "a length",
                    Dimension::Mixed => "none or several numbers",
                }
            ));
        }
        Ok(factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_equal_those_of_the_units_and_units_that_do_not_fit_are_refused() {
        let angle = |unit: Unit, quantity| unit.factor(quantity, Dimension::Angle);
        let close = |x: Result<f64, String>, y: f64| (x.unwrap() - y).abs() < 1e-15;
        assert!(close(angle(Unit::Degree, Quantity::Position), PI / 180.0));
        assert!(close(
            angle(Unit::TurnPerMinute, Quantity::Velocity),
            PI / 30.0
        ));
        assert!(close(angle(Unit::Scale(0.12), Quantity::Force), 0.12));
        assert!(angle(Unit::TurnPerMinute, Quantity::Position).is_err());
        assert!(angle(Unit::Degree, Quantity::Force).is_err());
        assert!(angle(Unit::Millimetre, Quantity::Position).is_err());
        assert!(angle(Unit::Scale(f64::NAN), Quantity::Position).is_err());
        let length = Unit::Millimetre.factor(Quantity::Velocity, Dimension::Length);
        assert!(close(length, 1e-3));
    }
}
