//! Articulated-body algorithm: which accelerations follow from given forces.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DVector, Vector3};

use super::articulated_factor::{ArticulatedFactor, SLIDE, TURN};
use super::coupled::CoupledScratch;
use super::rnea::world_acceleration;
use crate::joint::JointKind;
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
    pub(super) A: Vec<Motion<T>>,
    /// Per degree of freedom: the joint force that is left to accelerate it.
    pub(super) u: Vec<T>,
    pub(super) factor: ArticulatedFactor<T>,
    /// For robots whose joints follow one another.
    pub(super) coupled: Option<Box<CoupledScratch<T>>>,
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
    T::vectorized(
        #[inline(always)]
        || {
            outward(model, q, v, external, scratch);
            inward(model, tau, scratch);
            accelerations(model, &world_acceleration(model), scratch, a);
        },
    );
}

/// Outward: joint transforms, velocities, and the inertia and the force of each body alone.
#[inline(always)]
pub(super) fn outward<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    external: &[Force<T>],
    s: &mut AbaScratch<T>,
) {
    s.factor.turn(q);
    for (i, body) in model.bodies().iter().enumerate() {
        let X = s.factor.place(i, body, q);
        // V = X⁻¹ V_P + S v,  C = V × S v
        let mut V = match body.parent {
            Some(p) => X.motion_inverse(&s.V[p.0]),
            None => Motion::zero(),
        };
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

/// Inward: eliminates one joint after the other.
#[inline(always)]
pub(super) fn inward<P: Scalar, T: Over<P>>(model: &Model<P>, tau: &[T], s: &mut AbaScratch<T>) {
    for (i, body) in model.bodies().iter().enumerate().rev() {
        match body.joint {
            JointKind::Revolute | JointKind::Continuous => one::<P, T, TURN>(model, i, tau, s),
            JointKind::Prismatic => one::<P, T, SLIDE>(model, i, tau, s),
            _ => several(model, i, tau, s),
        }
    }
}

/// A joint with one axis:  u = τ − Sᵀ F, and the parent feels  `F_P += X* (F + I_a C + W u)`  with W = U D⁻¹.
#[inline(always)]
fn one<P: Scalar, T: Over<P>, const AXIS: usize>(
    model: &Model<P>,
    i: usize,
    tau: &[T],
    s: &mut AbaScratch<T>,
) {
    let body = &model.bodies()[i];
    let F = s.F[i];
    let u = tau[body.v] - F.coordinate(AXIS);
    s.u[body.v] = u;
    let (U, reciprocal) = s.factor.eliminate_one::<P, AXIS>(model, i);
    if let Some(p) = body.parent {
        let W = U.scaled(reciprocal);
        let I_a = s.factor.felt_through_one(i, &U, &W);
        // C has no components along and about z, the axis of the joint.
        let F_a = F + I_a.times_in_plane(&s.C[i]) + W.scaled(u);
        s.F[p.0] += s.factor.X_PB[i].force(&F_a);
        s.factor.hand_down(i, p.0, &I_a);
    }
}

/// The same for a joint with none or several axes.
#[inline(never)]
fn several<P: Scalar, T: Over<P>>(model: &Model<P>, i: usize, tau: &[T], s: &mut AbaScratch<T>) {
    let body = &model.bodies()[i];
    let F = s.F[i];
    body.project(&F, |k, x| s.u[k] = tau[k] - x);
    s.factor.eliminate_several(model, i);
    if let Some(p) = body.parent {
        let I_a = s.factor.felt_through_several(i, body);
        let F_a = s
            .factor
            .pushed(body, &s.u[v_range(body)], F + I_a.times(&s.C[i]));
        s.F[p.0] += s.factor.X_PB[i].force(&F_a);
        s.factor.hand_down(i, p.0, &I_a);
    }
}

/// Outward, with the acceleration of the world: `A' = X⁻¹ A_P + C`,  v̇ = D⁻¹ (u − Uᵀ A'),  A = A' + S v̇.
#[inline(always)]
pub(super) fn accelerations<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    A_W: &Motion<T>,
    s: &mut AbaScratch<T>,
    a: &mut [T],
) {
    // Slices, whose places the loop need not look up again after each write.
    let (X_PB, C, A, u) = (&s.factor.X_PB[..], &s.C[..], &mut s.A[..], &s.u[..]);
    let joints = s.factor.joints();
    for (i, body) in model.bodies().iter().enumerate() {
        let A_P = match body.parent {
            Some(p) => A[p.0],
            None => *A_W,
        };
        let A_i = X_PB[i].motion_inverse_plus(&A_P, &C[i]);
        let (v, w) = (A_i.linear, A_i.angular);
        match body.joint {
            JointKind::Revolute | JointKind::Continuous => {
                let turn = joints.acceleration(body.v, u, &A_i);
                a[body.v] = turn;
                A[i] = Motion::new(v, Vector3::new(w.x, w.y, w.z + turn));
            }
            JointKind::Prismatic => {
                let slide = joints.acceleration(body.v, u, &A_i);
                a[body.v] = slide;
                A[i] = Motion::new(Vector3::new(v.x, v.y, v.z + slide), w);
            }
            _ => A[i] = joints.accelerate(body, u, A_i, a),
        }
    }
}
