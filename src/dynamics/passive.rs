//! Passive joint forces: springs and viscous damping.

use nalgebra::DVector;

use crate::model::Model;
use crate::model::manifold::v_range;
use crate::scalar::{Over, Scalar};

/// Computes the forces of springs and damping along the coordinates:  −k (q − rest) − d v.
///
/// They are not part of the bias forces: the simulator adds them to the joint forces. Allocates its result.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length.
pub fn passive_forces<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T], v: &[T]) -> DVector<T> {
    let mut out = DVector::zeros(model.nv());
    passive_forces_into(model, q, v, out.as_mut_slice());
    out
}

/// [`passive_forces`] without allocation.
///
/// # Panics
/// If an argument has not the size that the model gives it.
pub fn passive_forces_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &mut [T],
) {
    tau.fill(T::zero());
    add_passive_forces(model, q, v, tau);
}

/// Adds [`passive_forces`] to other joint forces, without allocation.
///
/// # Panics
/// If an argument has not the size that the model gives it.
pub fn add_passive_forces<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &mut [T],
) {
    model.check_q(q);
    model.check_v(v);
    model.check_v(tau);
    T::vectorized(
        #[inline(always)]
        || {
            for ((tau, &v), &d) in tau.iter_mut().zip(v).zip(model.damping()) {
                *tau -= v * d;
            }
            for body in model.bodies() {
                if body.joint.nq() == 1 && body.coupling.is_none() {
                    let spring = &model.springs()[body.v];
                    tau[body.v] -= (q[body.q] - spring.rest) * spring.stiffness;
                }
            }
        },
    );
}

/// Hands the damper and the spring along every coordinate to `each(coordinate, d, k)`: what [`passive_forces`] lose by
/// a velocity and by a displacement that grow (N·s/m and N/m, or of turning).
pub(crate) fn each_resistance<P: Scalar>(model: &Model<P>, mut each: impl FnMut(usize, P, P)) {
    for body in model.independent() {
        for k in v_range(body) {
            let spring = model.springs()[k].stiffness;
            let stiffness = if body.joint.nq() == 1 {
                spring
            } else {
                P::zero()
            };
            each(k, model.damping()[k], stiffness);
        }
    }
}

/// Computes the energy stored in the springs, ½ Σ k (q − rest)², in J.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length.
pub fn elastic_energy<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T]) -> T {
    model.check_q(q);
    let single = model.independent().filter(|body| body.joint.nq() == 1);
    single.fold(T::zero(), |sum, body| {
        let spring = &model.springs()[body.v];
        let stretch = q[body.q] - spring.rest;
        sum + stretch * stretch * spring.stiffness * 0.5
    })
}
