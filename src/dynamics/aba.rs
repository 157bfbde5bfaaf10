//! Articulated-body algorithm: which accelerations follow from given forces.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DVector, Vector3};

use super::small_matrix::inverse;
use crate::joint::MAX_NV;
use crate::model::manifold::{q_range, v_range};
use crate::model::{Body, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::lift_vector;
use crate::spatial::{ArticulatedInertia, Force, Motion, Transform};

/// Working memory of [`forward_dynamics_into`].
#[derive(Clone, Debug)]
pub struct AbaScratch<T> {
    X_PB: Vec<Transform<T>>,
    V: Vec<Motion<T>>,
    /// Velocity-product accelerations.
    C: Vec<Motion<T>>,
    /// Articulated inertias.
    I: Vec<ArticulatedInertia<T>>,
    /// Articulated bias forces.
    F: Vec<Force<T>>,
    A: Vec<Motion<T>>,
    /// Per degree of freedom: the column of U D⁻¹.
    W: Vec<Force<T>>,
    /// Per degree of freedom: the entry of D⁻¹ u.
    free: Vec<T>,
}

impl<T: Scalar> AbaScratch<T> {
    /// Memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        let (n, nv) = (model.n_bodies(), model.nv());
        let no_inertia = ArticulatedInertia::rigid(&crate::spatial::Inertia::zero());
        Self {
            X_PB: vec![Transform::identity(); n],
            V: vec![Motion::zero(); n],
            C: vec![Motion::zero(); n],
            I: vec![no_inertia; n],
            F: vec![Force::zero(); n],
            A: vec![Motion::zero(); n],
            W: vec![Force::zero(); nv],
            free: vec![T::zero(); nv],
        }
    }
}

/// Computes the accelerations that the joint forces `tau` produce:  v̇ = M(q)⁻¹ (τ − h(q, v)).
///
/// O(n), allocates its result and working memory.
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
    velocities(model, q, v, external, scratch);
    articulated_inertias(model, tau, scratch);
    accelerations(model, scratch, a);
}

/// Outward: velocities, and each articulated body starts as its own rigid body.
fn velocities<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    external: &[Force<T>],
    s: &mut AbaScratch<T>,
) {
    for (i, body) in model.bodies().iter().enumerate() {
        let v = &v[v_range(body)];
        let X = body.joint.compose(&body.placement, &q[q_range(body)]);
        // V = X⁻¹ V_P + S v,  C = V × S v
        let mut V = body
            .parent
            .map_or_else(Motion::zero, |p| X.motion_inverse(&s.V[p.0]));
        body.joint.add_motion(v, &mut V);
        s.C[i] = body.joint.velocity_product(&V, v);
        // F = V ×* I V − F_ext
        s.F[i] = V.cross_force(&body.inertia.times(&V));
        if let Some(&F_ext) = external.get(i) {
            s.F[i] = s.F[i] - F_ext;
        }
        s.I[i] = ArticulatedInertia::rigid(&body.inertia.lift());
        (s.X_PB[i], s.V[i]) = (X, V);
    }
}

/// Inward: what the parent feels of a body whose joint gives way.
fn articulated_inertias<P: Scalar, T: Over<P>>(model: &Model<P>, tau: &[T], s: &mut AbaScratch<T>) {
    for (i, body) in model.bodies().iter().enumerate().rev() {
        let (mut I, mut F) = (s.I[i], s.F[i]);
        let mut U = [Force::zero(); MAX_NV];
        let U = &mut U[..body.joint.nv()];
        U.iter_mut()
            .zip(body.joint.axes())
            .for_each(|(U, &axis)| *U = I.column(axis));
        solve_joint(body, U, &F, &tau[v_range(body)], s);
        let Some(p) = body.parent else { continue };
        // I_a = I − U D⁻¹ Uᵀ,  F_a = F + I_a C + U D⁻¹ u
        for (k, U) in U.iter().enumerate() {
            I = I.minus_outer(U, &s.W[body.v + k]);
        }
        F += I.times(&s.C[i]);
        for (k, U) in U.iter().enumerate() {
            F += U.scaled(s.free[body.v + k]);
        }
        s.I[p.0] = s.I[p.0] + I.moved(&s.X_PB[i]);
        s.F[p.0] += s.X_PB[i].force(&F);
    }
}

/// With D = Sᵀ U and u = τ − Sᵀ F: stores W = U D⁻¹ and D⁻¹ u.
#[inline]
fn solve_joint<P, T: Scalar>(
    body: &Body<P>,
    U: &[Force<T>],
    F: &Force<T>,
    tau: &[T],
    s: &mut AbaScratch<T>,
) {
    let axes = body.joint.axes();
    let u = |k: usize| tau[k] - F.coordinate(axes[k]);
    if let ([U], [axis]) = (U, axes) {
        let inverse = T::one() / U.coordinate(*axis);
        s.W[body.v] = U.scaled(inverse);
        s.free[body.v] = u(0) * inverse;
        return;
    }
    let mut D = [[T::zero(); MAX_NV]; MAX_NV];
    for (row, &axis) in axes.iter().enumerate() {
        for (column, U) in U.iter().enumerate() {
            D[row][column] = U.coordinate(axis);
        }
    }
    let D_inverse = inverse(&D, axes.len());
    for k in 0..axes.len() {
        s.W[body.v + k] =
            (0..axes.len()).fold(Force::zero(), |sum, l| sum + U[l].scaled(D_inverse[l][k]));
        s.free[body.v + k] = (0..axes.len()).fold(T::zero(), |sum, l| sum + D_inverse[k][l] * u(l));
    }
}

/// Outward: `A' = X⁻¹ A_P + C`,  v̇ = D⁻¹ u − Wᵀ A',  A = A' + S v̇.
fn accelerations<P: Scalar, T: Over<P>>(model: &Model<P>, s: &mut AbaScratch<T>, a: &mut [T]) {
    // Gravity acts like an acceleration of the world the other way.
    let A_W = Motion::new(-lift_vector::<P, T>(model.gravity()), Vector3::zeros());
    for (i, body) in model.bodies().iter().enumerate() {
        let A_P = body.parent.map_or(A_W, |p| s.A[p.0]);
        let mut A = s.X_PB[i].motion_inverse(&A_P) + s.C[i];
        for k in v_range(body) {
            a[k] = s.free[k] - A.power(&s.W[k]);
        }
        body.joint.add_motion(&a[v_range(body)], &mut A);
        s.A[i] = A;
    }
}
