//! Articulated-body algorithm: which accelerations follow from given forces.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DVector;

use super::articulated_factor::ArticulatedFactor;
use super::coupled::CoupledScratch;
use super::rnea::world_acceleration;
use crate::model::Model;
use crate::model::manifold::v_range;
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Motion};

/// Working memory of [`forward_dynamics_into`].
#[derive(Clone, Debug)]
pub struct AbaScratch<T> {
    V: Vec<Motion<T>>,
    /// Velocity-product accelerations.
    C: Vec<Motion<T>>,
    /// Articulated bias forces.
    F: Vec<Force<T>>,
    A: Vec<Motion<T>>,
    /// Per degree of freedom: the joint force that is left to accelerate it, and D⁻¹ times it.
    u: Vec<T>,
    free: Vec<T>,
    factor: ArticulatedFactor<T>,
    /// For robots whose joints follow one another.
    coupled: Option<Box<CoupledScratch<T>>>,
}

impl<T: Scalar> AbaScratch<T> {
    /// Memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        let (n, nv) = (model.n_bodies(), model.nv());
        Self {
            V: vec![Motion::zero(); n],
            C: vec![Motion::zero(); n],
            F: vec![Force::zero(); n],
            A: vec![Motion::zero(); n],
            u: vec![T::zero(); nv],
            free: vec![T::zero(); nv],
            factor: ArticulatedFactor::new(model),
            coupled: CoupledScratch::new(model),
        }
    }
}

/// Computes the accelerations that the joint forces `tau` produce:  v̇ = M(q)⁻¹ (τ − h(q, v)).
///
/// O(n), but O(nv³) where joints follow one another. Allocates its result and working memory.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
/// * `tau` – joint forces, length `nv` (N·m or N)
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::forward_dynamics, model::samples};
///
/// // A rod of 1 m let go at the horizontal: v̇ = −(m g l / 2) / (m l² / 3) = −3 g / 2
/// let a = forward_dynamics(&samples::pendulum(), &[std::f64::consts::FRAC_PI_2], &[0.0], &[0.0]);
/// assert!((a[0] + 1.5 * 9.81).abs() < 1e-12);
/// ```
///
/// # References
/// [Featherstone 2008, table 7.1].
pub fn forward_dynamics<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &[T],
) -> DVector<T> {
    let mut a = DVector::zeros(model.nv());
    forward_dynamics_into(
        model,
        q,
        v,
        tau,
        &[],
        &mut AbaScratch::new(model),
        a.as_mut_slice(),
    );
    a
}

/// [`forward_dynamics`] with external forces and without allocation:  v̇ = M⁻¹ (τ − h + Σᵢ Jᵢᵀ Fᵢ).
///
/// * `external` – force on each body in its body frame, length `n_bodies`, see
///   [`add_frame_force`](super::add_frame_force); empty for none
/// * `a` – output, length `nv` (rad/s² or m/s²)
///
/// # Panics
/// If an argument has not the size that the model gives it.
pub fn forward_dynamics_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &[T],
    external: &[Force<T>],
    scratch: &mut AbaScratch<T>,
    a: &mut [T],
) {
    model.check_q(q);
    [v, tau, a].into_iter().for_each(|x| model.check_v(x));
    model.check_external(external);
    assert_eq!(
        scratch.V.len(),
        model.n_bodies(),
        "the scratch belongs to another model than \"{}\"",
        model.name()
    );
    if let Some(coupled) = &mut scratch.coupled {
        return coupled.accelerations(model, q, v, tau, external, a);
    }
    scratch.factor.place(model, q);
    velocities(model, v, external, scratch);
    scratch.factor.eliminate(model);
    forces(model, tau, scratch);
    accelerations(model, scratch, a);
}

/// Outward: velocities, and the force that each body alone needs.
fn velocities<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    v: &[T],
    external: &[Force<T>],
    s: &mut AbaScratch<T>,
) {
    for (i, body) in model.bodies().iter().enumerate() {
        let X = &s.factor.X_PB[i];
        // V = X⁻¹ V_P + S v,  C = V × S v
        let mut V = body
            .parent
            .map_or_else(Motion::zero, |p| X.motion_inverse(&s.V[p.0]));
        body.add_motion(v, &mut V);
        s.C[i] = body.velocity_product(&V, v);
        // F = V ×* I V − F_ext
        s.F[i] = V.cross_force(&body.inertia.times(&V));
        if let Some(&F_ext) = external.get(i) {
            s.F[i] = s.F[i] - F_ext;
        }
        s.V[i] = V;
    }
}

/// Inward: u = τ − Sᵀ F, and what the parent feels of a body whose joint gives way:  `F_P += X* (F + I_a C + W u)`.
fn forces<P: Scalar, T: Over<P>>(model: &Model<P>, tau: &[T], s: &mut AbaScratch<T>) {
    for (i, body) in model.bodies().iter().enumerate().rev() {
        let mut F = s.F[i];
        for (k, &axis) in v_range(body).zip(body.joint.axes()) {
            s.u[k] = tau[k] - F.coordinate(axis);
        }
        s.factor.free_acceleration(body, &s.u, &mut s.free);
        let Some(p) = body.parent else { continue };
        F += s.factor.I[i].times(&s.C[i]);
        for k in v_range(body) {
            F += s.factor.W[k].scaled(s.u[k]);
        }
        s.F[p.0] += s.factor.X_PB[i].force(&F);
    }
}

/// Outward: `A' = X⁻¹ A_P + C`,  v̇ = D⁻¹ u − Wᵀ A',  A = A' + S v̇.
fn accelerations<P: Scalar, T: Over<P>>(model: &Model<P>, s: &mut AbaScratch<T>, a: &mut [T]) {
    let A_W = world_acceleration(model);
    for (i, body) in model.bodies().iter().enumerate() {
        let A_P = body.parent.map_or(A_W, |p| s.A[p.0]);
        let mut A = s.factor.X_PB[i].motion_inverse(&A_P) + s.C[i];
        for k in v_range(body) {
            a[k] = s.free[k] - A.power(&s.factor.W[k]);
        }
        body.add_motion(a, &mut A);
        s.A[i] = A;
    }
}
