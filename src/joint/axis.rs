//! The direction of one degree of freedom: a column of the motion subspace S.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::hash::{Hash, Hasher};

use crate::scalar::Scalar;
use crate::spatial::{Force, Motion};

/// Linear z, the direction in which a screw advances.
const ALONG: usize = 2;
/// The first of the angular coordinates of a spatial vector.
const FIRST_ANGLE: usize = 3;

/// Advance of a screw joint per angle, m/rad; positive for a right-handed thread.
///
/// A constant of the description: it is not a parameter of the model and has no derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Pitch(f64);

impl Pitch {
    /// Makes a pitch from an advance in metres per radian.
    pub const fn per_radian(metres: f64) -> Self {
        Self(metres)
    }

    /// Makes a pitch from an advance in metres per revolution, the pitch of a single-start thread.
    pub fn per_turn(metres: f64) -> Self {
        Self(metres / std::f64::consts::TAU)
    }

    /// Metres per radian.
    pub const fn metres_per_radian(self) -> f64 {
        self.0
    }
}

/// Of the same bits, so that kinds of joints can be compared and hashed.
impl PartialEq for Pitch {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_bits() == other.0.to_bits()
    }
}

impl Eq for Pitch {}

impl Hash for Pitch {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.to_bits().hash(state);
    }
}

/// Quantity of an entry of a configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coordinate {
    /// m.
    Length,
    /// rad.
    Angle,
    /// One of the four of a unit quaternion.
    Quaternion,
}

/// The direction of a degree of freedom in the body frame, constant there: a coordinate axis of the spatial vector
/// `[linear; angular]`, or a screw about z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    coordinate: usize,
    /// m/rad along z beside the turn about z; 0 for a coordinate axis.
    pitch: f64,
}

impl Axis {
    /// A coordinate axis, 0 to 5; about z, with an advance by the pitch.
    #[inline(always)]
    pub(super) const fn new(coordinate: usize, pitch: f64) -> Self {
        Self { coordinate, pitch }
    }

    /// The coordinate of the spatial vector (order `[linear; angular]`) that the velocity is; of a screw the angular one.
    #[inline(always)]
    pub(crate) fn coordinate(self) -> usize {
        self.coordinate
    }

    /// Advance along z per angle about z, m/rad; 0 except for a screw.
    #[inline(always)]
    pub(crate) fn pitch(self) -> f64 {
        self.pitch
    }

    /// `true` if the coordinate is an angle or its rate, `false` if it is a length or its rate.
    #[inline(always)]
    pub fn is_angular(self) -> bool {
        self.coordinate >= FIRST_ANGLE
    }

    /// Quantity of a displacement along it.
    pub(crate) fn displacement(self) -> Coordinate {
        if self.is_angular() {
            Coordinate::Angle
        } else {
            Coordinate::Length
        }
    }

    /// The column of S: the motion at unit rate.
    #[inline]
    pub(crate) fn motion<T: Scalar>(self) -> Motion<T> {
        let scaled = |along: Motion<T>, pitch: f64| along * T::constant(pitch);
        self.combine(Motion::basis, |about, along, pitch| {
            about + scaled(along, pitch)
        })
    }

    /// The row of Sᵀ F: the force along the axis.
    #[inline(always)]
    pub(crate) fn project<T: Scalar>(self, F: &Force<T>) -> T {
        self.combine(
            #[inline(always)]
            |axis| F.coordinate(axis),
            #[inline(always)]
            |about, along, pitch| about + along * pitch,
        )
    }

    /// Image of the axis under a linear map, from those of coordinate axes; `add(x, y, h)` is x + h y.
    ///
    /// Where the kind of joint is known when this is compiled, nothing is left of the choice.
    #[inline(always)]
    pub(crate) fn combine<X>(self, of: impl Fn(usize) -> X, add: impl FnOnce(X, X, f64) -> X) -> X {
        let own = of(self.coordinate);
        if self.pitch == 0.0 {
            own
        } else {
            add(own, of(ALONG), self.pitch)
        }
    }

    /// [`combine`](Self::combine) for forces, the columns of an inertia.
    #[inline(always)]
    pub(crate) fn column<T: Scalar>(self, of: impl Fn(usize) -> Force<T>) -> Force<T> {
        self.combine(
            of,
            #[inline(always)]
            |about, along, pitch| about + along.scaled(T::constant(pitch)),
        )
    }
}
