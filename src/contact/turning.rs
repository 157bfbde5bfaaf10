//! Torsional and rolling friction: moments at a contact, bounded by its normal force.
//!
//! A patch of contact has moments beside its force. About the normal |m| ≤ c fₙ, with the coefficient c of torsional friction; about the tangents
//! ‖m‖ ≤ r fₙ, with the coefficient r of rolling friction. Below its bound a moment stops the relative rotation ω of both bodies about its axes; at the bound it
//! acts against ω. Both are independent of the friction across, and of each other.

use std::ops::Range;

use crate::numbers::numbers;
use crate::scalar::{MapEach, Scalar};

/// Coefficients of torsional and rolling friction of a surface, or between two surfaces; zero by default.
///
/// A coefficient is a length: the moment is at most that length times the normal force. A coefficient up to 10 nm adds nothing to a step, and has no derivative.
/// A pair of surfaces has the larger coefficient of both, as in `MuJoCo`: the softer surface determines the size of the contact patch.
///
/// | contact model | moment |
/// |---|---|
/// | [`Rigid`](super::Rigid) | exact: rotation stops, or the moment is at its bound |
/// | [`RelaxedRigid`](super::RelaxedRigid) | the same, regularised like friction with the compliance Rₜ / c², that of `MuJoCo` for μ = 1: under a moment, rotation creeps |
/// | [`SoftContact`](super::SoftContact) | over linearly implicit steps as rigid contact; else −c fₙ ω / √(‖ω‖² + ω₀²) with ω₀ = 0.1 rad/s |
///
/// These bounds are separate from that of the tangential force. An elliptic cone of `MuJoCo` has one bound for all: a sliding contact has less torsional
/// friction there, and a rotating contact lifts. A [recorded](crate::scalar::traced) step refuses these moments.
///
/// # Examples
/// A ball of mass m and radius r that spins at Ω about the vertical stops after t = 2 m r² Ω / (5 c m g):
/// ```
/// use dualbody::contact::{ContactLaw, Contacts, Rigid, Terrain, TurningFriction};
/// use dualbody::{Model, Simulator};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let xml = r#"<robot name="ball"><link name="ball">
///   <inertial><mass value="1"/><inertia ixx="0.004" iyy="0.004" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial>
///   <collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>"#;
/// let model = Model::from_urdf_str(xml)?;
/// let soft = TurningFriction { torsional: 0.005, rolling: 0.0 };
/// let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Rigid(Rigid::default()))
///     .with_turning_friction(&model, "ball", soft)?;
/// let simulator = Simulator::new(model).with_contacts(contacts).with_time_step(0.001);
/// let mut state = simulator.neutral_state();
/// state.q[2] = 0.1;
/// state.v[5] = 5.0;
/// for _ in 0..100 {
///     state = simulator.step(&state, &[]);
/// }
/// let expected = 5.0 - 0.1 * 0.005 * 9.81 / 0.004;
/// assert!((state.v[5] - expected).abs() < 1e-3, "{} {expected}", state.v[5]);
/// # Ok(())
/// # }
/// ```
///
/// # References
/// The chapter on computation of the manual of `MuJoCo`, contact, on `condim` 4 and 6.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TurningFriction<P = f64> {
    /// c, the coefficient of torsional friction, m: of rotation about the normal. For a patch with uniform pressure and radius a, ⅔ μ a.
    pub torsional: P,
    /// r, the coefficient of rolling friction, m: of rotation about the tangents. A wheel of radius ρ decelerates by r g / ρ as if it were on a slope r / ρ.
    pub rolling: P,
}

numbers! { pub struct TurningFriction {
    torsional: NotNegative("torsional friction"),
    rolling: NotNegative("rolling friction"),
} }

/// Coefficient up to which there is no moment, m: smaller than that of any contact. Regularised rows have the compliance Rₜ / c², with which the solver
/// finds no forces for smaller ones.
pub(super) const LEAST: f64 = 1e-8;

/// Whether a coefficient acts, in some lane.
fn acts<P: Scalar>(x: &P) -> bool {
    !x.has_value() || (0..P::LANES).any(|lane| x.value(lane) > LEAST)
}

impl<P: Scalar> TurningFriction<P> {
    pub(crate) fn none() -> Self {
        Self {
            torsional: P::zero(),
            rolling: P::zero(),
        }
    }

    /// That of two surfaces.
    pub(super) fn between(&self, other: &Self) -> Self {
        Self {
            torsional: self.torsional.max(other.torsional),
            rolling: self.rolling.max(other.rolling),
        }
    }

    /// Axes of a point (normal, tangent, tangent) about which there are moments.
    pub(crate) fn axes(&self) -> Range<usize> {
        let [spins, rolls] = [&self.torsional, &self.rolling].map_each(acts);
        usize::from(!spins)..if rolls { 3 } else { 1 }
    }

    /// Whether there are any moments.
    pub(crate) fn acts(&self) -> bool {
        !self.axes().is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_those_of_the_coefficients_that_act() {
        let axes = |torsional, rolling| TurningFriction { torsional, rolling }.axes();
        assert_eq!(axes(0.1, 0.0), 0..1);
        assert_eq!(axes(0.0, 0.1), 1..3);
        assert_eq!(axes(0.1, 0.1), 0..3);
        assert!(axes(0.0, 0.0).is_empty());
    }
}
