//! Tangents of states, and gradients in them, with the base velocity in another representation.
//!
//! A tangent δx = (δq, δv) of the state (q, v) has two parts. That of the configuration is a small motion, and transforms
//! as a velocity: δq' = T δq. In the mixed representation its base part is thus the change of the position of the base in
//! the world, then a rotation vector in axes of the world. The other part is the change of the numbers v' = T(q) v, and T
//! changes with the configuration: δv' = T (δv + Ω(δq) × v), with Ω as in the [rate](super) of T. So
//! δx' = S(x) δx with S = (T, 0; T (Ω(·) × v), T).

use nalgebra::DVector;

use super::{
    base_velocity, force_from_representation, force_to_representation,
    velocity_from_representation, velocity_to_representation,
};
use crate::model::Model;
use crate::scalar::{Over, Scalar, from_each};
use crate::spatial::{Force, Motion, Representation, SPATIAL};

/// A tangent δx = (δq, δv, δm) of a state with the base in another representation:  δx' = S(x) δx.
///
/// δq' is the small motion T(q) δq: in the mixed representation its base part is the change of the base's position in the
/// world, then a rotation vector in axes of the world. δv' is the change of the velocity T(q) v, which changes with q too:
/// the base part of δv' = T (δv + Ω(δq) × v), where Ω(δq) is δq without its linear part (*mixed*), δq (*inertial*), or zero
/// (*body*). Entries after these, such as a contact state δm, stay unchanged. A deviation of finite size is converted by the same linear map.
///
/// * `q`, `v` – the state, in the crate's own representation
/// * `dx` – length 2 `nv` or more
///
/// # Panics
/// If a slice has the wrong length.
pub(crate) fn deviation_to_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    dx: &[T],
    to: Representation,
) -> DVector<T> {
    let (dq, dv, rest) = split(model, v, dx);
    let mut dv = dv.to_vec();
    add_turned(model, v, dq, to, &mut dv);
    let dq = velocity_to_representation(model, q, dq, to);
    let dv = velocity_to_representation(model, q, &dv, to);
    joined(&dq, &dv, rest)
}

/// A tangent δx' of a state whose base is in another representation, in the crate's own: the inverse of
/// [`deviation_to_representation`].
///
/// * `q`, `v` – the state, in the crate's own representation
/// * `dx` – length 2 `nv` or more
///
/// # Panics
/// If a slice has the wrong length.
pub(super) fn deviation_from_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    dx: &[T],
    from: Representation,
) -> DVector<T> {
    let (dq, dv, rest) = split(model, v, dx);
    let dq = velocity_from_representation(model, q, dq, from);
    let mut dv = velocity_from_representation(model, q, dv, from);
    let back: Vec<T> = dq.iter().map(|&x| -x).collect();
    add_turned(model, v, &back, from, dv.as_mut_slice());
    joined(&dq, &dv, rest)
}

/// A gradient in the tangent of a state, as a row of a controller's gain is, with the base in another representation:
/// g' = S⁻ᵀ g, so that g' · δx' = g · δx.
///
/// * `q`, `v` – the state, in the crate's own representation
/// * `gradient` – length 2 `nv` or more
///
/// # Panics
/// If a slice has the wrong length.
pub(crate) fn gradient_to_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    gradient: &[T],
    to: Representation,
) -> DVector<T> {
    let (by_q, by_v, rest) = split(model, v, gradient);
    let mut by_q = by_q.to_vec();
    let turned = turned_part(model, v, by_v, to);
    (by_q.iter_mut().zip(turned)).for_each(|(x, part)| *x -= part);
    let by_q = force_to_representation(model, q, &by_q, to);
    let by_v = force_to_representation(model, q, by_v, to);
    joined(&by_q, &by_v, rest)
}

/// A gradient in the tangent of a state whose base is in another representation, in the crate's own: the inverse of [`gradient_to_representation`].
pub(super) fn gradient_from_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    gradient: &[T],
    from: Representation,
) -> DVector<T> {
    let (by_q, by_v, rest) = split(model, v, gradient);
    let mut by_q = force_from_representation(model, q, by_q, from);
    let by_v = force_from_representation(model, q, by_v, from);
    let turned = turned_part(model, v, by_v.as_slice(), from);
    (by_q.iter_mut().zip(turned)).for_each(|(x, part)| *x += part);
    joined(&by_q, &by_v, rest)
}

/// The part of a gradient that comes from the base's velocity having other numbers where the base has moved: Ω(v ×* `g_v`).
fn turned_part<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    v: &[T],
    by_v: &[T],
    to: Representation,
) -> Vec<T> {
    if !model.has_floating_base() {
        return Vec::new();
    }
    // g_v · (Ω(δq) × v) = −(v ×* g_v)... with both signs: Ω × v = −v × Ω, so it is (v ×* g_v) · Ω(δq).
    let force = base_velocity(v).cross_force(&Force::from_array(first_six(by_v)));
    let part = to.turning(&Motion::new(force.linear, force.angular));
    part.to_array().to_vec()
}

/// Adds Ω(δq) × v to the base part of a velocity.
fn add_turned<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    v: &[T],
    dq: &[T],
    representation: Representation,
    to: &mut [T],
) {
    if model.has_floating_base() {
        let turning = representation.turning(&base_velocity(dq));
        let turned = turning.cross(&base_velocity(v)).to_array();
        to.iter_mut().zip(turned).for_each(|(to, x)| *to += x);
    }
}

/// The parts of the configuration, of the velocity, and of what follows.
fn split<'a, P: Scalar, T: Scalar>(
    model: &Model<P>,
    v: &[T],
    dx: &'a [T],
) -> (&'a [T], &'a [T], &'a [T]) {
    model.check_v(v);
    let nv = model.nv();
    assert!(
        dx.len() >= 2 * nv,
        "the tangent of a state of \"{}\" has {} entries or more, not {}",
        model.name(),
        2 * nv,
        dx.len()
    );
    let (dq, rest) = dx.split_at(nv);
    let (dv, rest) = rest.split_at(nv);
    (dq, dv, rest)
}

fn joined<T: Scalar>(dq: &DVector<T>, dv: &DVector<T>, rest: &[T]) -> DVector<T> {
    let numbers = dq.iter().chain(dv).chain(rest).copied();
    DVector::from_vec(numbers.collect())
}

fn first_six<T: Scalar>(x: &[T]) -> [T; SPATIAL] {
    from_each(|k| x[k])
}
