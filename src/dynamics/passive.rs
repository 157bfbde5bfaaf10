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
/// If an argument has the wrong size for the model.
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
/// If an argument has the wrong size for the model.
pub(crate) fn add_passive_forces<P: Scalar, T: Over<P>>(
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
            each_passive(
                model,
                #[inline(always)]
                |k, own, passive| passive.add_force(own.map(|own| q[own]), v[k], &mut tau[k]),
            );
        },
    );
}

/// Damper and spring along a coordinate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passive<P> {
    /// d, N·s/m or N·m·s/rad.
    pub(crate) damping: P,
    /// k, N/m or N·m/rad; meaningless without a position.
    pub(crate) stiffness: P,
    /// Position without force.
    pub(crate) rest: P,
}

impl<P: Scalar> Passive<P> {
    /// Adds  −d v − k (q − rest)  to a joint force.
    ///
    /// * `q` – position; `None` where the coordinate has none, and so no spring
    #[inline(always)]
    pub(crate) fn add_force<T: Over<P>>(&self, q: Option<T>, v: T, tau: &mut T) {
        *tau -= v * self.damping;
        if let Some(q) = q {
            *tau -= (q - self.rest) * self.stiffness;
        }
    }
}

/// Hands damper and spring of each velocity coordinate, with the index of its position where it has one, to `each(coordinate, position, passive)`.
#[inline(always)]
pub(crate) fn each_passive<P: Scalar>(
    model: &Model<P>,
    mut each: impl FnMut(usize, Option<usize>, &Passive<P>),
) {
    for body in model.independent() {
        let q = (body.joint.nq() == 1).then_some(body.q);
        for k in v_range(body) {
            let spring = &model.springs()[k];
            let passive = Passive {
                damping: model.damping()[k],
                stiffness: spring.stiffness,
                rest: spring.rest,
            };
            each(k, q, &passive);
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
