//! Recursive Newton–Euler algorithm: forces from accelerations.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DVector;

use super::weightless::add_spared;
use crate::model::manifold::q_range;
use crate::model::{Body, Model};
use crate::scalar::{Over, Scalar, pairs};
use crate::spatial::linear::{lift_vector, zero};
use crate::spatial::{Force, Motion, Transform};

/// Working memory of [`inverse_dynamics_into`], [`bias_forces_into`] and [`gravity_forces_into`].
#[derive(Clone, Debug)]
pub struct RneaScratch<T> {
    sin_cos: Vec<(T, T)>,
    X_PB: Vec<Transform<T>>,
    V: Vec<Motion<T>>,
    A: Vec<Motion<T>>,
    F: Vec<Force<T>>,
}

impl<T: Scalar> RneaScratch<T> {
    /// Makes memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        let n = model.n_bodies();
        Self {
            sin_cos: vec![(T::zero(), T::one()); model.nq()],
            X_PB: vec![Transform::identity(); n],
            V: vec![Motion::zero(); n],
            A: vec![Motion::zero(); n],
            F: vec![Force::zero(); n],
        }
    }

    /// The pose of each body in its parent, and its velocity in its own frame, at the last configuration and velocity.
    pub(crate) fn motions(&self) -> (&[Transform<T>], &[Motion<T>]) {
        (&self.X_PB, &self.V)
    }

    fn check<P: Scalar>(&self, model: &Model<P>) {
        assert_eq!(
            self.V.len(),
            model.n_bodies(),
            "the scratch belongs to another model than \"{}\"",
            model.name()
        );
    }

    /// Takes the motion of a body that has been found elsewhere.
    pub(super) fn set_motion(&mut self, i: usize, X_PB: Transform<T>, V: Motion<T>, A: Motion<T>) {
        (self.X_PB[i], self.V[i], self.A[i]) = (X_PB, V, A);
    }

    /// [`motions`](Self::motions) with the accelerations of the bodies.
    pub(crate) fn accelerated(&self) -> Motions<'_, T> {
        Motions {
            X_PB: &self.X_PB,
            V: &self.V,
            A: &self.A,
        }
    }
}

/// Motions of bodies at a state and an acceleration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motions<'a, T> {
    /// Pose of each body in its parent.
    pub(crate) X_PB: &'a [Transform<T>],
    /// Velocity of each body in its own frame.
    pub(crate) V: &'a [Motion<T>],
    /// Spatial acceleration of each body in its own frame, with that of the world against gravity.
    pub(crate) A: &'a [Motion<T>],
}

/// The motion for which forces are computed; `None` means zero.
struct DesiredMotion<'a, T> {
    q: &'a [T],
    v: Option<&'a [T]>,
    a: Option<&'a [T]>,
    external: &'a [Force<T>],
}

/// Computes the joint forces that produce the accelerations `a`:  τ = M(q) a + h(q, v).
///
/// O(n), allocates its result and working memory.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
/// * `a` – acceleration in tangent coordinates, length `nv` (rad/s² or m/s²)
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::inverse_dynamics, model::samples};
///
/// // A rod of 1 kg and 1 m, horizontal: τ = m g l / 2
/// let tau = inverse_dynamics(&samples::pendulum(), &[std::f64::consts::FRAC_PI_2], &[0.0], &[0.0]);
/// assert!((tau[0] - 0.5 * 9.81).abs() < 1e-12);
/// ```
///
/// # References
/// [Featherstone 2008, table 5.1].
pub fn inverse_dynamics<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: &[T],
) -> DVector<T> {
    let (mut scratch, mut tau) = (RneaScratch::new(model), DVector::zeros(model.nv()));
    inverse_dynamics_into(model, q, v, a, &[], &mut scratch, tau.as_mut_slice());
    tau
}

/// [`inverse_dynamics`] with external forces and without allocation:  τ = M a + h − Σᵢ Jᵢᵀ Fᵢ.
///
/// * `external` – force on each body in its body frame, length `n_bodies`, see
///   [`add_frame_force`](super::add_frame_force); empty for none
/// * `tau` – output, length `nv` (N·m or N)
///
/// # Panics
/// If an argument has the wrong size for the model.
pub fn inverse_dynamics_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: &[T],
    external: &[Force<T>],
    scratch: &mut RneaScratch<T>,
    tau: &mut [T],
) {
    let desired = DesiredMotion {
        q,
        v: Some(v),
        a: Some(a),
        external,
    };
    recursive_newton_euler(model, &desired, scratch, tau);
}

/// Computes h(q, v), the joint forces for zero acceleration: Coriolis, centrifugal and gravity forces.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::bias_forces, model::samples};
///
/// // One hinge has no Coriolis forces: what is left is m g l / 2 at any speed
/// let h = bias_forces(&samples::pendulum(), &[std::f64::consts::FRAC_PI_2], &[7.0]);
/// assert!((h[0] - 0.5 * 9.81).abs() < 1e-12);
/// ```
pub fn bias_forces<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T], v: &[T]) -> DVector<T> {
    let (mut scratch, mut tau) = (RneaScratch::new(model), DVector::zeros(model.nv()));
    bias_forces_into(model, q, v, &[], &mut scratch, tau.as_mut_slice());
    tau
}

/// [`bias_forces`] with external forces (as in [`inverse_dynamics_into`]) and without allocation.
///
/// # Panics
/// If an argument has the wrong size for the model.
pub fn bias_forces_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    external: &[Force<T>],
    scratch: &mut RneaScratch<T>,
    tau: &mut [T],
) {
    let desired = DesiredMotion {
        q,
        v: Some(v),
        a: None,
        external,
    };
    recursive_newton_euler(model, &desired, scratch, tau);
}

/// Finds the pose of each body in its parent, and its velocity; they stay in the scratch. Does not allocate.
///
/// # Panics
/// If an argument has the wrong size for the model.
pub(crate) fn place_bodies_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    scratch: &mut RneaScratch<T>,
) {
    model.check_q(q);
    model.check_v(v);
    scratch.check(model);
    T::vectorized(
        #[inline(always)]
        || {
            T::sin_cos_each(q, &mut scratch.sin_cos);
            for (i, body) in model.bodies().iter().enumerate() {
                let X = body.place_turned(q, &scratch.sin_cos);
                let mut V = match body.parent {
                    Some(p) => X.motion_inverse(&scratch.V[p.0]),
                    None => Motion::zero(),
                };
                body.add_motion(v, &mut V);
                (scratch.X_PB[i], scratch.V[i]) = (X, V);
            }
        },
    );
}

/// [`bias_forces_into`] for bodies that [have been placed](place_bodies_into).
///
/// # Panics
/// If an argument has the wrong size for the model.
pub(crate) fn bias_forces_of_placed_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    v: &[T],
    external: &[Force<T>],
    scratch: &mut RneaScratch<T>,
    tau: &mut [T],
) {
    [v, tau].into_iter().for_each(|x| model.check_v(x));
    model.check_external(external);
    scratch.check(model);
    T::vectorized(
        #[inline(always)]
        || {
            let A_W = world_acceleration(model);
            for (i, body) in model.bodies().iter().enumerate() {
                let A_P = body.parent.map_or(A_W, |p| scratch.A[p.0]);
                let mut A = scratch.X_PB[i].motion_inverse(&A_P);
                A += body.velocity_product(&scratch.V[i], v);
                scratch.A[i] = A;
                load(body, i, external, scratch);
            }
            tau.fill(T::zero());
            sum_inward(model, scratch, tau);
        },
    );
}

/// Computes g(q), the joint forces that hold the robot at rest: the gradient of the potential energy.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::gravity_forces, model::samples};
///
/// let g = gravity_forces(&samples::pendulum(), &[std::f64::consts::FRAC_PI_6]);
/// assert!((g[0] - 0.25 * 9.81).abs() < 1e-12); // m g l / 2 · sin 30°
/// ```
pub fn gravity_forces<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T]) -> DVector<T> {
    let mut tau = DVector::zeros(model.nv());
    gravity_forces_into(model, q, &mut RneaScratch::new(model), tau.as_mut_slice());
    tau
}

/// [`gravity_forces`] without allocation.
///
/// # Panics
/// If an argument has the wrong size for the model.
pub fn gravity_forces_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    scratch: &mut RneaScratch<T>,
    tau: &mut [T],
) {
    let desired = DesiredMotion {
        q,
        v: None,
        a: None,
        external: &[],
    };
    recursive_newton_euler(model, &desired, scratch, tau);
}

fn recursive_newton_euler<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    desired: &DesiredMotion<'_, T>,
    scratch: &mut RneaScratch<T>,
    tau: &mut [T],
) {
    check(model, desired, scratch, tau);
    T::vectorized(
        #[inline(always)]
        || {
            outward(model, desired, scratch);
            add_armature(model, desired, tau);
            sum_inward(model, scratch, tau);
        },
    );
}

fn check<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    desired: &DesiredMotion<'_, T>,
    scratch: &RneaScratch<T>,
    tau: &[T],
) {
    model.check_q(desired.q);
    desired
        .v
        .into_iter()
        .chain(desired.a)
        .for_each(|x| model.check_v(x));
    model.check_external(desired.external);
    model.check_v(tau);
    scratch.check(model);
}

/// From the world to the tips: velocities, accelerations, and the force that each body needs.
#[inline(always)]
fn outward<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    desired: &DesiredMotion<'_, T>,
    s: &mut RneaScratch<T>,
) {
    let A_W = world_acceleration(model);
    T::sin_cos_each(desired.q, &mut s.sin_cos);
    for (i, body) in model.bodies().iter().enumerate() {
        accelerate(body, i, desired, &A_W, s);
        load(body, i, desired.external, s);
    }
}

/// Finds pose, velocity and acceleration of a body from those of its parent.
#[inline(always)]
fn accelerate<P: Scalar, T: Over<P>>(
    body: &Body<P>,
    i: usize,
    desired: &DesiredMotion<'_, T>,
    A_W: &Motion<T>,
    s: &mut RneaScratch<T>,
) {
    let X = body.place_turned(desired.q, &s.sin_cos);
    let carried = match body.parent {
        Some(p) => Accelerated {
            V: X.motion_inverse(&s.V[p.0]),
            A: X.motion_inverse(&s.A[p.0]),
        },
        None => Accelerated {
            V: Motion::zero(),
            A: X.motion_inverse(A_W),
        },
    };
    let Accelerated { V, A } = joint_motion(body, desired.v, desired.a, carried);
    (s.X_PB[i], s.V[i], s.A[i]) = (X, V, A);
}

/// Finds the force that a body needs to move as it does, less what acts on it from outside.
#[inline(always)]
fn load<P: Scalar, T: Over<P>>(
    body: &Body<P>,
    i: usize,
    external: &[Force<T>],
    s: &mut RneaScratch<T>,
) {
    s.F[i] = body.inertia.force(&s.V[i], &s.A[i]);
    if let Some(&F_ext) = external.get(i) {
        s.F[i] = s.F[i] - F_ext;
    }
}

/// Gravity acts like an acceleration of the world the other way.
#[inline(always)]
pub(crate) fn world_acceleration<P: Scalar, T: Over<P>>(model: &Model<P>) -> Motion<T> {
    Motion::new(-lift_vector::<P, T>(model.gravity()), zero())
}

/// The motion of a body, in its own frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accelerated<T> {
    /// Velocity.
    pub(crate) V: Motion<T>,
    /// Spatial acceleration, with that of the world against gravity.
    pub(crate) A: Motion<T>,
}

/// Adds the joint's own motion to that of the parent, seen from the body:  V += S v,  A += S a + V × S v.
#[inline(always)]
pub(crate) fn joint_motion<P: Scalar, T: Over<P>>(
    body: &Body<P>,
    v: Option<&[T]>,
    a: Option<&[T]>,
    carried: Accelerated<T>,
) -> Accelerated<T> {
    joint_motion_over::<P, P, T>(body, v, a, carried)
}

/// [`joint_motion`] over a scalar over one over the data.
#[inline(always)]
pub(crate) fn joint_motion_over<P: Scalar, R: Over<P>, T: Over<R>>(
    body: &Body<P>,
    v: Option<&[T]>,
    a: Option<&[T]>,
    carried: Accelerated<T>,
) -> Accelerated<T> {
    let Accelerated { mut V, mut A } = carried;
    if let Some(v) = v {
        body.add_motion_over::<R, T>(v, &mut V);
        A += body.velocity_product_over::<R, T>(&V, v);
    }
    if let Some(a) = a {
        body.add_motion_over::<R, T>(a, &mut A);
    }
    Accelerated { V, A }
}

/// Computes the forces that accelerate the rotors of the joints' motors:  τ = armature · a.
#[inline(always)]
fn add_armature<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    desired: &DesiredMotion<'_, T>,
    tau: &mut [T],
) {
    let Some(a) = desired.a else {
        return tau.fill(T::zero());
    };
    for (tau, (&a, &armature)) in pairs(tau, pairs(a, model.armature())) {
        *tau = a * armature;
    }
}

/// Adds the joint forces for the forces that bodies need, of those that gravity does not act on too.
#[inline(always)]
fn sum_inward<P: Scalar, T: Over<P>>(model: &Model<P>, s: &mut RneaScratch<T>, tau: &mut [T]) {
    if !model.weightless().is_empty() {
        add_spared(model, &s.X_PB, &mut s.F);
    }
    inward(model, s, tau);
}

/// From the tips to the world: each joint carries what is needed beyond it.  τ += Sᵀ F,  `F_P += X* F`.
#[inline(always)]
fn inward<P: Scalar, T: Over<P>>(model: &Model<P>, s: &mut RneaScratch<T>, tau: &mut [T]) {
    for (i, body) in model.bodies().iter().enumerate().rev() {
        body.add_projection(&s.F[i], tau);
        propagate(body, i, s);
    }
}

/// `F_P += X* F` at one joint.
#[inline(always)]
fn propagate<P: Scalar, T: Over<P>>(body: &Body<P>, i: usize, s: &mut RneaScratch<T>) {
    if let Some(p) = body.parent {
        let F_P = s.X_PB[i].force(&s.F[i]);
        s.F[p.0] += F_P;
    }
}

/// Computes the motions of some bodies for given accelerations; they stay in the scratch. Does not allocate.
///
/// * `bodies` – indices, ascending, each with all of its ancestors
pub(crate) fn motions_of_some<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    bodies: &[usize],
    [q, v, a]: [&[T]; 3],
    s: &mut RneaScratch<T>,
) {
    let desired = DesiredMotion {
        q,
        v: Some(v),
        a: Some(a),
        external: &[],
    };
    let A_W = world_acceleration(model);
    let ends = bodies.iter().map(|&i| q_range(&model.bodies()[i]).end);
    let end = ends.max().unwrap_or(0);
    T::sin_cos_each(&q[..end], &mut s.sin_cos[..end]);
    for &i in bodies {
        accelerate(&model.bodies()[i], i, &desired, &A_W, s);
    }
}

/// Computes the accelerations of some bodies from their known poses and velocities; they stay in the scratch. Does not allocate.
///
/// * `bodies` – indices, ascending, each with all of its ancestors
/// * `X_PB`, `V` – as in [`Motions`], of all bodies
pub(crate) fn accelerations_of_some<'s, P: Scalar, T: Over<P>>(
    model: &Model<P>,
    bodies: &[usize],
    (X_PB, V): (&'s [Transform<T>], &'s [Motion<T>]),
    [v, a]: [&[T]; 2],
    s: &'s mut RneaScratch<T>,
) -> Motions<'s, T> {
    let A_W = world_acceleration(model);
    for &i in bodies {
        let body = &model.bodies()[i];
        let A_P = body.parent.map_or(A_W, |p| s.A[p.0]);
        let mut A = X_PB[i].motion_inverse(&A_P);
        A += body.velocity_product_over::<P, T>(&V[i], v);
        body.add_motion(a, &mut A);
        s.A[i] = A;
    }
    Motions { X_PB, V, A: &s.A }
}

/// Computes the force that the joints of some bodies transmit to them, in the body. Does not allocate.
///
/// * `bodies` – indices, ascending, each with all of its descendants
/// * `external` – force on each body in its body frame, length `n_bodies`; empty for none
/// * `out` – output, length `n_bodies`; that of other bodies has no meaning
pub(crate) fn transmitted_forces<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    bodies: &[usize],
    Motions { X_PB, V, A }: Motions<'_, T>,
    external: &[Force<T>],
    out: &mut [Force<T>],
) {
    for &i in bodies {
        let F = model.bodies()[i].inertia.force(&V[i], &A[i]);
        out[i] = external.get(i).map_or(F, |&F_ext| F - F_ext);
    }
    add_spared(model, X_PB, out);
    for &i in bodies.iter().rev() {
        let parent = model.bodies()[i].parent;
        if let Some(p) = parent.filter(|p| bodies.binary_search(&p.0).is_ok()) {
            let F_P = X_PB[i].force(&out[i]);
            out[p.0] += F_P;
        }
    }
}
