//! Kinetic and potential energy.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::center_of_mass::first_moment;
use super::kinematics::{Kinematics, forward_kinematics};
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{dot, lift_vector};

/// Computes the kinetic energy T = ½ vᵀ M v of all bodies and rotors, in J. Allocates working memory.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::kinetic_energy, model::samples};
///
/// // A rod of 1 kg and 1 m about its end: ½ (m l² / 3) ω²
/// let energy = kinetic_energy(&samples::pendulum(), &[0.4], &[3.0]);
/// assert!((energy - 1.5).abs() < 1e-14);
/// ```
pub fn kinetic_energy<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T], v: &[T]) -> T {
    kinetic_energy_at(model, &forward_kinematics(model, q, v), v)
}

/// [`kinetic_energy`] from known velocities of the bodies, ½ Σ V · I V + ½ Σ armature v², without allocation.
///
/// # Panics
/// If a slice has the wrong length.
pub fn kinetic_energy_at<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
    v: &[T],
) -> T {
    kinematics.check(model);
    model.check_v(v);
    let bodies = model.bodies().iter().zip(&kinematics.V_WB_B);
    let of_bodies = bodies.fold(T::zero(), |sum, (body, V)| {
        sum + V.power(&body.inertia.times(V))
    });
    let rotors = v.iter().zip(model.armature());
    rotors.fold(of_bodies, |sum, (&v, &armature)| sum + v * v * armature) * 0.5
}

/// Computes the potential energy U = −m gᵀ c in J: zero with the centre of mass at the origin, larger the higher it is.
///
/// Allocates working memory.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::potential_energy, model::samples};
///
/// // The same rod, hanging from the origin: −m g l / 2
/// let energy = potential_energy(&samples::pendulum(), &[0.0]);
/// assert!((energy + 0.5 * 9.81).abs() < 1e-14);
/// ```
pub fn potential_energy<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T]) -> T {
    let at_rest = vec![T::zero(); model.nv()];
    potential_energy_at(model, &forward_kinematics(model, q, &at_rest))
}

/// [`potential_energy`] from known poses, without allocation.
pub fn potential_energy_at<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
) -> T {
    -dot(
        &first_moment(model, kinematics),
        &lift_vector::<P, T>(model.gravity()),
    )
}
