//! The law of one block as equations, and which of its pieces holds.
//!
//! Everything is in scaled numbers (see [`System`](super::system::System)), where forces and velocities have the same unit.

use super::Law;
use crate::scalar::Scalar;

/// A vector shorter than this has no direction; its square is still far from the smallest number.
const NO_DIRECTION: f64 = 1e-100;

/// The equations that replace the law of one block near one force and velocity.
///
/// All but the smoothed ones have the form  e = f − Π(f − y)  with one smooth piece Π of a projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Piece {
    /// y = 0: bilateral rows, pressing rays, sticking contacts, forces between their bounds. Π(a) = a.
    Stick,
    /// f = 0: no contact. Π(a) = 0.
    Separated,
    /// The force is on the surface of its cone, against the slip.
    Slip(Law),
    /// No friction, or none that has a direction: Π(a) = (aₙ, 0).
    Frictionless,
    /// The central path of a ray, or of a cone without friction:  fₙ yₙ = κ,  fₜ = 0.
    PathOfRay,
    /// The force is at the upper bound b of its interval: Π(a) = b.
    Upper,
    /// The force is at the lower bound: Π(a) = −b.
    Lower,
    /// The moment is at its bound, against the motion: Π(a) = b a / ‖a‖.
    Turning,
    /// The central path of a cone with friction.
    PathOfCone(Law),
    /// The central path of an interval:  y = κ / (b + f) − κ / (b − f).
    PathOfInterval,
}

impl Piece {
    /// The force of a piece that gives it, per bound of the interval; `None` where the force is to be found.
    pub(super) fn given(self) -> Option<f64> {
        match self {
            Self::Separated => Some(0.0),
            Self::Upper => Some(1.0),
            Self::Lower => Some(-1.0),
            _ => None,
        }
    }

    /// Whether it is a plane, whose slopes are the same everywhere.
    pub(super) fn is_flat(self) -> bool {
        use Piece::{Frictionless, Lower, Separated, Stick, Upper};
        matches!(self, Stick | Separated | Frictionless | Upper | Lower)
    }

    /// Whether it is one of the central path.
    pub(super) fn is_smoothed(self) -> bool {
        matches!(
            self,
            Self::PathOfRay | Self::PathOfCone(_) | Self::PathOfInterval
        )
    }
}

/// The piece of a ray's law that holds at f − y.
pub(super) fn piece_of_ray(f: f64, y: f64) -> Piece {
    if f > y {
        Piece::Stick
    } else {
        Piece::Separated
    }
}

/// The piece of an interval's law that holds at f − y.
pub(super) fn piece_of_interval(f: f64, y: f64, bound: f64) -> Piece {
    let a = f - y;
    if a > bound {
        Piece::Upper
    } else if a < -bound {
        Piece::Lower
    } else {
        Piece::Stick
    }
}

/// The piece of a moment's law that holds at f − y, while its bound is `bound`.
pub(super) fn piece_of_moment(f: [f64; 3], y: [f64; 3], bound: f64) -> Piece {
    let size = (f[0] - y[0]).hypot(f[1] - y[1]);
    if bound <= 0.0 {
        Piece::Separated
    } else if size > bound {
        Piece::Turning
    } else {
        Piece::Stick
    }
}

/// The piece of a cone's law that holds at f − y.
#[inline(always)]
pub(super) fn piece_of_cone(law: Law, f: [f64; 3], y: [f64; 3], mu: f64) -> Piece {
    let a = [f[0] - y[0], f[1] - y[1], f[2] - y[2]];
    let tangential = (a[1] * a[1] + a[2] * a[2]).sqrt();
    let separated = match law {
        Law::Convex => a[0] + mu * tangential <= 0.0,
        Law::Coulomb => a[0] <= 0.0,
    };
    if separated {
        Piece::Separated
    } else if mu > 0.0 && tangential <= mu * a[0] {
        Piece::Stick
    } else if tangential > NO_DIRECTION {
        Piece::Slip(law)
    } else {
        Piece::Frictionless
    }
}

/// The left sides of a piece's equations e(f, y, μ) = 0.
///
/// * `mu` – friction of a cone, bound of an interval or of a moment
/// * `kappa` – κ, where the piece is one of the central path
///
/// One row for a ray or an interval, in the first entry, and one or two for a moment; the others have to be zero then.
#[inline]
pub(super) fn equations<T: Scalar>(
    piece: Piece,
    f: [T; 3],
    y: [T; 3],
    mu: T,
    kappa: f64,
) -> [T; 3] {
    match piece {
        Piece::Stick => y,
        Piece::Separated => f,
        Piece::Frictionless => [y[0], f[1], f[2]],
        Piece::Slip(law) => slip(law, f, y, mu),
        Piece::Upper => [f[0] - mu, f[1], f[2]],
        Piece::Lower => [f[0] + mu, f[1], f[2]],
        Piece::Turning => turning(f, y, mu),
        Piece::PathOfRay => [f[0] * y[0] - kappa, f[1], f[2]],
        Piece::PathOfInterval => path_of_interval(f, y, mu, kappa),
        Piece::PathOfCone(Law::Convex) => path_of_convex(f, y, mu, kappa),
        Piece::PathOfCone(Law::Coulomb) => path_of_coulomb(f, y, mu, kappa),
    }
}

/// Convex:   Π(a) = p (1, μ d)  with  p = (aₙ + μ l) / (1 + μ²),
/// Coulomb:  Π(a) = (aₙ, μ aₙ d),   where  l = ‖aₜ‖, d = aₜ / l.
fn slip<T: Scalar>(law: Law, f: [T; 3], y: [T; 3], mu: T) -> [T; 3] {
    let a = [f[0] - y[0], f[1] - y[1], f[2] - y[2]];
    let l = (a[1] * a[1] + a[2] * a[2]).sqrt();
    let normal = match law {
        Law::Convex => (a[0] + mu * l) / (mu * mu + 1.0),
        Law::Coulomb => a[0],
    };
    let along = mu * normal / l;
    [f[0] - normal, f[1] - along * a[1], f[2] - along * a[2]]
}

/// f = b a / ‖a‖ with a = f − y.
fn turning<T: Scalar>(f: [T; 3], y: [T; 3], bound: T) -> [T; 3] {
    let a = [f[0] - y[0], f[1] - y[1]];
    let along = bound / (a[0] * a[0] + a[1] * a[1]).sqrt();
    [f[0] - along * a[0], f[1] - along * a[1], f[2]]
}

/// Jordan product in the scaled cone:  fᵀy = κ,  μ² fₙ yₜ + yₙ fₜ = 0.
fn path_of_convex<T: Scalar>(f: [T; 3], y: [T; 3], mu: T, kappa: f64) -> [T; 3] {
    let weight = mu * mu * f[0];
    [
        f[0] * y[0] + f[1] * y[1] + f[2] * y[2] - kappa,
        weight * y[1] + y[0] * f[1],
        weight * y[2] + y[0] * f[2],
    ]
}

/// fₙ yₙ = κ,  (μ² fₙ² − ‖fₜ‖²) yₜ + κ fₜ = 0: Signorini's law and that of greatest dissipation, each with its barrier.
fn path_of_coulomb<T: Scalar>(f: [T; 3], y: [T; 3], mu: T, kappa: f64) -> [T; 3] {
    let inside = mu * mu * f[0] * f[0] - f[1] * f[1] - f[2] * f[2];
    [
        f[0] * y[0] - kappa,
        inside * y[1] + f[1] * kappa,
        inside * y[2] + f[2] * kappa,
    ]
}

/// (b² − f²) y + 2 κ f = 0: both products of a bound's distance and its multiplier are κ.
fn path_of_interval<T: Scalar>(f: [T; 3], y: [T; 3], bound: T, kappa: f64) -> [T; 3] {
    let inside = (bound - f[0]) * (bound + f[0]);
    [inside * y[0] + f[0] * (2.0 * kappa), f[1], f[2]]
}
