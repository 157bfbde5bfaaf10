//! Kinetic and potential energy.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::center_of_mass::first_moment;
use super::kinematics::{Kinematics, forward_kinematics};
use super::passes::velocity;
use super::weightless::spared_moment;
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{dot, lift_vector};
use crate::spatial::{Force, Motion, Transform};

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
pub(crate) fn kinetic_energy_at<P: Scalar, T: Over<P>>(
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
    let of_armature = v.iter().zip(model.armature());
    of_armature.fold(of_bodies, |sum, (&v, &armature)| sum + v * v * armature) * 0.5
}

/// Passes each velocity coordinate k with the derivatives of the kinetic energy T in that rate, the momentum (M v)ₖ, and in that tangent direction of q at
/// fixed v, the term of Lagrange's equation, to `each`, in parts that add up; those of armature are left out. Does not allocate.
///
/// When a joint moves on by δq, its subtree rotates with it, and so the velocity `V_P` that it has from before the
/// joint changes by δV = `V_P` × S δq. With the momentum h of the whole subtree,  ∂T/∂v = h · S  and  ∂T/∂q = h · (`V_P` × S).
///
/// * `X_PB` – the pose of each body in its parent at q
/// * `scratch` – working memory, a motion and a force for each body
pub(crate) fn each_kinetic_derivative<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    X_PB: &[Transform<T>],
    v: &[T],
    scratch: &mut [(Motion<T>, Force<T>)],
    mut each: impl FnMut(usize, T, T),
) {
    for (i, body) in model.bodies().iter().enumerate() {
        let V = velocity(body, &X_PB[i], v, |p| scratch[p.0].0);
        scratch[i] = (V, body.inertia.times(&V));
    }
    for (i, body) in model.bodies().iter().enumerate().rev() {
        let (V, h) = scratch[i];
        let V_P = V - body.motion(v);
        body.columns()
            .for_each(|(k, S)| each(k, S.power(&h), V_P.cross(&S).power(&h)));
        if let Some(p) = body.parent {
            scratch[p.0].1 += X_PB[i].force(&h);
        }
    }
}

/// Computes the potential energy U = −m gᵀ c in J: zero with the centre of mass at the origin, and increasing with its height. Links without gravity are ignored.
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
pub(crate) fn potential_energy_at<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
) -> T {
    let mut moment = first_moment(model, kinematics);
    if !model.weightless().is_empty() {
        moment -= spared_moment(model, kinematics);
    }
    -dot(&moment, &lift_vector::<P, T>(model.gravity()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::mass_matrix;
    use crate::model::samples;
    use nalgebra::DVector;
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    /// T(q ⊕ δ) by central differences.
    #[test]
    fn slopes_of_the_kinetic_energy_equal_momenta_and_differences() {
        const STEP: f64 = 1e-6;
        for seed in 0..6 {
            let model = samples::random_tree(10, seed);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let q = model.random_configuration(&mut rng);
            let v = model.random_velocity(&mut rng, 2.0);
            let mut scratch = vec![(Motion::zero(), Force::zero()); model.n_bodies()];
            let mut gradient = vec![0.0; model.nv()];
            let bodies = model.bodies().iter();
            let X_PB: Vec<Transform<f64>> = bodies.map(|body| body.place(q.as_slice())).collect();
            let mut momentum = vec![0.0; model.nv()];
            each_kinetic_derivative(&model, &X_PB, v.as_slice(), &mut scratch, |k, p, slope| {
                momentum[k] += p;
                gradient[k] += slope;
            });
            let armature = model.armature().iter().zip(&v).map(|(r, v)| r * v);
            let expected = mass_matrix(&model, q.as_slice()) * &v
                - DVector::from_iterator(model.nv(), armature);
            let error = (DVector::from_vec(momentum) - &expected).amax();
            assert!(
                error < 1e-12 * (1.0 + expected.amax()),
                "seed {seed}, momentum: {error:e}"
            );
            for k in 0..model.nv() {
                let energy = |step: f64| {
                    let mut dq = vec![0.0; model.nv()];
                    dq[k] = step;
                    let moved = model.integrate(q.as_slice(), &dq);
                    kinetic_energy(&model, moved.as_slice(), v.as_slice())
                };
                let expected = (energy(STEP) - energy(-STEP)) / (2.0 * STEP);
                let error = (gradient[k] - expected).abs() / (1.0 + expected.abs());
                assert!(
                    error < 1e-7,
                    "seed {seed}, {k}: {} not {expected}",
                    gradient[k]
                );
            }
        }
    }
}
