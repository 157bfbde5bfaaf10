//! Derivatives of inverse dynamics: dual numbers at each body, elimination along the tree.
//!
//! Inverse dynamics is a graph of small functions: a joint moves its body, the motion determines a force, and the force is propagated to the parent.
//! Each function is evaluated on dual numbers at its own body, in its few directions: the joint at each call ([`super::joint`]), the force once per
//! model, because its derivative is linear in the velocity ([`VelocityProductMatrix`]). The rest is linear and known: when a joint moves, its subtree
//! moves as one rigid body. So *composite* maps eliminate the motions of the subtree; they map a change of the joint's motion to the change of the
//! force that the whole subtree needs:
//!
//! > δF = I δÂ + B δω, with I = Σ X* Iᵢ X⁻¹ and B = Σ X* Bᵢ Rᵀ over the subtree.
//!
//! Each degree of freedom then propagates four vectors to the root: its rows of I and B, with which the ancestors act on it, and the forces δF of its
//! own two directions, which act on the ancestors. O(n · depth) with a small constant; the mass matrix is a by-product. The result equals that of
//! dense dual numbers to rounding.
//!
//! # References
//! [Griewank, Walther 2008, chapter 9] for elimination; [Jain, Rodriguez 1993] for the composite maps.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DMatrix;

use super::composite::Composite;
use super::joint::{Direction, Seeded, moved, place, place_rare, turned_by_rare, turned_force};
use super::propagate::{Entries, Matrices, Output, pass};
use super::weightless::add_spared_slopes;
use crate::dynamics::calls::Calls;
use crate::dynamics::columns::Columns;
use crate::dynamics::crba::add_armature;
use crate::dynamics::rnea::{Accelerated, world_acceleration};
use crate::dynamics::weightless::spared_part;
use crate::joint::{Joint, with_joint};
use crate::model::manifold::v_range;
use crate::model::{Body, Generation, Model};
use crate::scalar::{
    Differentiable, DualNumber, Over, Pack, Scalar, compiled_over_f64, vectorized_over,
};
use crate::spatial::{Force, Motion, Transform, UnitVelocityProducts};

/// Derivatives of τ = ID(q, v, a).
#[derive(Clone, Debug, PartialEq)]
pub struct InverseDynamicsDerivatives<T: Scalar = f64> {
    /// ∂τ/∂q in tangent directions of q, `nv` × `nv`.
    pub dq: DMatrix<T>,
    /// ∂τ/∂v, `nv` × `nv`.
    pub dv: DMatrix<T>,
    /// ∂τ/∂a = M(q), `nv` × `nv`.
    pub da: DMatrix<T>,
}

impl<T: Scalar> InverseDynamicsDerivatives<T> {
    /// Makes memory for a model.
    pub fn zeros<P: Scalar>(model: &Model<P>) -> Self {
        let zeros = DMatrix::zeros(model.nv(), model.nv());
        Self {
            dq: zeros.clone(),
            dv: zeros.clone(),
            da: zeros,
        }
    }
}

/// Working memory of [`inverse_dynamics_derivatives_into`]. It belongs to the model that it was made for and to clones of it; when masses,
/// placements or armature have changed, a new one is needed.
#[derive(Clone, Debug)]
pub struct InverseDynamicsDerivativesScratch<T: Differentiable = f64> {
    generation: Generation,
    calls: Calls,
    /// Of each body, from the first of many calls on.
    velocity_products: Vec<UnitVelocityProducts<T>>,
    sin_cos: Vec<(T, T)>,
    /// The velocities without and with a derivative of their own each, the accelerations without.
    v: Vec<T::Dual<1>>,
    v_moved: Vec<T::Dual<1>>,
    a: Vec<T::Dual<1>>,
    bodies: Vec<Composite<T>>,
    /// One for each degree of freedom of a body, as the columns.
    directions: Vec<Direction<T>>,
    columns: Columns<Pack<T, 4>>,
}

/// Position, velocity and acceleration at which derivatives are taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct At<'a, T> {
    pub(crate) q: &'a [T],
    pub(crate) v: &'a [T],
    pub(crate) a: &'a [T],
}

impl<T: Differentiable> InverseDynamicsDerivativesScratch<T> {
    /// Makes memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        Self::for_calls(model, Calls::Many)
    }

    /// Memory for a model that is called so often. Velocity products at unit velocities take as long as some calls to find.
    pub(crate) fn for_calls<P: Scalar>(model: &Model<P>, calls: Calls) -> Self {
        let zeros = |n: usize| vec![T::Dual::<1>::from(T::zero()); n];
        let columns = Columns::new(model);
        Self {
            generation: model.generation(),
            calls,
            velocity_products: match calls {
                Calls::One => Vec::new(),
                Calls::Many => Vec::with_capacity(model.n_bodies()),
            },
            bodies: vec![Composite::at_rest(); model.n_bodies()],
            directions: vec![Direction::zero(); columns.F.len()],
            columns,
            sin_cos: vec![(T::zero(), T::one()); model.nq()],
            v: zeros(model.nv()),
            v_moved: zeros(model.nv()),
            a: zeros(model.nv()),
        }
    }
}

/// Computes the derivatives of [`inverse_dynamics`](crate::dynamics::inverse_dynamics) in q (tangent), v and a, exact to rounding.
/// O(n · depth); allocates its result and working memory.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
/// * `a` – acceleration in tangent coordinates, length `nv` (rad/s² or m/s²)
///
/// # Examples
/// ```
/// use dualbody::{dynamics::inverse_dynamics_derivatives, model::samples};
///
/// // A hanging rod of 1 kg and 1 m: ∂τ/∂q = m g l / 2, ∂τ/∂a = m l² / 3
/// let tau = inverse_dynamics_derivatives(&samples::pendulum(), &[0.0], &[0.0], &[0.0]);
/// assert!((tau.dq[0] - 0.5 * 9.81).abs() < 1e-12 && (tau.da[0] - 1.0 / 3.0).abs() < 1e-12);
/// ```
///
/// # Panics
/// If a slice has the wrong length.
pub fn inverse_dynamics_derivatives<P: Scalar, T: Over<P> + Differentiable>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: &[T],
) -> InverseDynamicsDerivatives<T> {
    let mut out = InverseDynamicsDerivatives::zeros(model);
    let mut scratch = InverseDynamicsDerivativesScratch::for_calls(model, Calls::One);
    inverse_dynamics_derivatives_into(model, q, v, a, &[], &mut scratch, &mut out);
    out
}

/// [`inverse_dynamics_derivatives`] with external forces and without allocation.
///
/// * `external` – force on each body in its body frame, which moves with the body, length `n_bodies`; empty for none
///
/// # Panics
/// If a slice, the scratch or the output has the wrong size.
pub fn inverse_dynamics_derivatives_into<P: Scalar, T: Over<P> + Differentiable>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: &[T],
    external: &[Force<T>],
    scratch: &mut InverseDynamicsDerivativesScratch<T>,
    out: &mut InverseDynamicsDerivatives<T>,
) {
    compiled_over_f64!(
        [P, T] derivatives_with, model: &Model, q: &[f64], v: &[f64], a: &[f64], external: &[Force<f64>],
        scratch: &mut InverseDynamicsDerivativesScratch, out: &mut InverseDynamicsDerivatives
    );
}

fn derivatives_with<P: Scalar, T: Over<P> + Differentiable>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: &[T],
    external: &[Force<T>],
    scratch: &mut InverseDynamicsDerivativesScratch<T>,
    out: &mut InverseDynamicsDerivatives<T>,
) {
    let InverseDynamicsDerivatives { dq, dv, da } = out;
    for m in [&mut *dq, dv] {
        check_square(model, m);
        m.as_mut_slice().fill(T::zero());
    }
    let mut entries = Matrices {
        nv: model.nv(),
        dq: dq.as_mut_slice(),
        dv: dv.as_mut_slice(),
    };
    add_derivatives(model, &At { q, v, a }, external, scratch, &mut entries, da);
    da.fill_lower_triangle_with_upper_triangle();
}

fn check_square<P: Scalar, T: Scalar>(model: &Model<P>, m: &DMatrix<T>) {
    assert_eq!(
        m.shape(),
        (model.nv(), model.nv()),
        "the derivatives of \"{}\" are nv × nv",
        model.name()
    );
}

/// [`inverse_dynamics_derivatives_into`], the derivatives in q and v added to what `out` has; of M only the upper triangle.
pub(crate) fn add_derivatives<P: Scalar, T: Over<P> + Differentiable, E: Entries<T>>(
    model: &Model<P>,
    at: &At<'_, T>,
    external: &[Force<T>],
    scratch: &mut InverseDynamicsDerivativesScratch<T>,
    out: &mut E,
    mass: &mut DMatrix<T>,
) {
    model.check_q(at.q);
    [at.v, at.a].into_iter().for_each(|x| model.check_v(x));
    model.check_external(external);
    check_square(model, mass);
    mass.as_mut_slice().fill(T::zero());
    seed(model, at, scratch);
    let mut entries = Output {
        nv: model.nv(),
        mass: mass.as_mut_slice(),
        out,
    };
    vectorized_over::<T, _>(
        #[inline(always)]
        || {
            outward(model, at, external, scratch);
            if !model.weightless().is_empty() {
                spare(model, scratch, entries.out);
            }
            inward(model, scratch, &mut entries);
        },
    );
    add_armature(model, mass);
}

/// Takes the weight of what gravity does not act on from the forces and their derivatives.
#[inline(never)]
fn spare<P: Scalar, T: Over<P> + Differentiable, E: Entries<T>>(
    model: &Model<P>,
    s: &mut InverseDynamicsDerivativesScratch<T>,
    out: &mut E,
) {
    for k in 0..model.weightless().len() {
        let X_PB = |i: usize| s.bodies[i].X_PB;
        let (spared, F) = spared_part(model, k, X_PB);
        add_spared_slopes(model, X_PB, &spared, out);
        s.bodies[spared.body.0].F += F;
    }
}

fn seed<P: Scalar, T: Over<P> + Differentiable>(
    model: &Model<P>,
    at: &At<'_, T>,
    s: &mut InverseDynamicsDerivativesScratch<T>,
) {
    model.assert_generation(s.generation);
    if s.calls == Calls::Many && s.velocity_products.is_empty() {
        let of = |body: &Body<P>| UnitVelocityProducts::new(&body.inertia.lift());
        s.velocity_products.extend(model.bodies().iter().map(of));
    }
    T::sin_cos_each(at.q, &mut s.sin_cos);
    for k in 0..at.v.len() {
        let (v, a) = (at.v[k], at.a[k]);
        s.v[k] = v.into();
        s.v_moved[k] = DualNumber::variable(v, 0);
        s.a[k] = a.into();
    }
}

/// From the world to the tips: motions, forces, and their local derivatives.
#[inline(always)]
fn outward<P: Scalar, T: Over<P> + Differentiable>(
    model: &Model<P>,
    point: &At<'_, T>,
    external: &[Force<T>],
    s: &mut InverseDynamicsDerivativesScratch<T>,
) {
    let world = (Motion::zero(), world_acceleration(model));
    let at = Seeded {
        v: &s.v,
        v_moved: &s.v_moved,
        a: &s.a,
    };
    s.columns.number(model.bodies());
    for (i, body) in model.bodies().iter().enumerate() {
        let (before, local) = s.bodies.split_at_mut(i);
        let (local, units) = (&mut local[0], s.velocity_products.get(i));
        let parent = match body.parent {
            Some(p) => (&before[p.0].V, &before[p.0].A),
            None => (&world.0, &world.1),
        };
        let X = body.place_turned(point.q, &s.sin_cos);
        let carried = Accelerated {
            V: X.motion_inverse(parent.0),
            A: X.motion_inverse(parent.1),
        };
        let directions = &mut s.directions[s.columns.first[i]..s.columns.first[i + 1]];
        // Each arm writes its own result, so that those for frequent joints stay in registers.
        with_joint!(body.joint, joint => move_frequent(body, joint, &at, X, &carried, directions, local, units),
            else move_rare(body, point, X, &carried, directions, local, units));
        if let Some(&F_ext) = external.get(i) {
            let F = &mut s.bodies[i].F;
            *F = *F - F_ext;
        }
    }
}

/// A body whose joint is of a frequent kind; it would move by `carried` if the joint stood still.
#[inline(always)]
fn move_frequent<P: Scalar, T: Over<P> + Differentiable, J: Joint>(
    body: &Body<P>,
    joint: J,
    at: &Seeded<'_, T::Dual<1>>,
    X: Transform<T>,
    carried: &Accelerated<T>,
    directions: &mut [Direction<T>],
    local: &mut Composite<T>,
    units: Option<&UnitVelocityProducts<T>>,
) {
    let moved: [T::Dual<1>; 1] = [moved(body)];
    let motion = place(body, joint, &moved, at, carried, directions);
    local.move_to(body, units, X, &motion);
}

/// A body whose joint is of a rare kind; it would move by `carried` if the joint stood still.
fn move_rare<P: Scalar, T: Over<P> + Differentiable>(
    body: &Body<P>,
    at: &At<'_, T>,
    X: Transform<T>,
    carried: &Accelerated<T>,
    directions: &mut [Direction<T>],
    local: &mut Composite<T>,
    units: Option<&UnitVelocityProducts<T>>,
) {
    let (v, a) = (&at.v[v_range(body)], &at.a[v_range(body)]);
    let motion = place_rare(body, v, a, carried, directions);
    local.move_to(body, units, X, &motion);
}

/// From the tips to the world: the columns and rows of each joint, then the parent's composite maps grow.
#[inline(always)]
fn inward<P: Scalar, T: Differentiable + Over<P>, E: Entries<T>>(
    model: &Model<P>,
    s: &mut InverseDynamicsDerivativesScratch<T>,
    out: &mut Output<'_, T, E>,
) {
    for (i, body) in model.bodies().iter().enumerate().rev() {
        let (local, columns) = (&s.bodies[i], &mut s.columns);
        with_joint!(body.joint, joint => {
            let turned = || turned_force(joint, &[moved::<P, T, T::Dual<1>>(body)], &local.F);
            pass(i, body, joint, local, turned, &s.directions, columns, out);
        }, else pass_rare(i, body, local, &s.directions, columns, out));
        if let Some(p) = body.parent {
            let (before, local) = s.bodies.split_at_mut(i);
            let (parent, local) = (&mut before[p.0], &local[0]);
            parent.F += local.X_PB.force(&local.F);
            parent.I = parent.I + local.X_PB.inertia(&local.I);
            parent.B.add_carried(&local.X_PB, &local.B);
        }
    }
}

/// [`pass`] of a rare kind.
#[inline(always)]
fn pass_rare<P: Scalar, T: Differentiable + Over<P>, E: Entries<T>>(
    i: usize,
    body: &Body<P>,
    local: &Composite<T>,
    directions: &[Direction<T>],
    columns: &mut Columns<Pack<T, 4>>,
    out: &mut Output<'_, T, E>,
) {
    with_joint!(rare body.joint, joint => {
        let turned = || turned_by_rare(body.joint, joint, &local.F);
        pass(i, body, joint, local, turned, directions, columns, out);
    });
}
