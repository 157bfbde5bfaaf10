//! Tangents of states, and gradients in them, with the base velocity in another representation.
//!
//! A tangent δx = (δq, δv) of the state (q, v) has two parts. That of the configuration is a small motion, and transforms
//! as a velocity: δq' = T δq. In the mixed representation its base part is thus the change of the position of the base in
//! the world, then a rotation vector in axes of the world. The other part is the change of the numbers v' = T(q) v, and T
//! changes with the configuration: δv' = T (δv + Ω(δq) × v), with Ω as in the [rate](super) of T. So
//! δx' = S(x) δx with S = (T, 0; T (Ω(·) × v), T).

use nalgebra::DVector;

use super::{
    base_velocity, force_to_representation, velocity_from_representation,
    velocity_to_representation,
};
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Motion, Representation, SPATIAL};

/// A tangent δx = (δq, δv, δm) of a state with the base in another representation:  δx' = S(x) δx.
///
/// δq' is the small motion T(q) δq: in the mixed representation its base part is the change of the base's position in the
/// world, then a rotation vector in axes of the world. δv' is the change of the velocity T(q) v, which changes with q too:
/// the base part of δv' = T (δv + Ω(δq) × v), where Ω(δq) is δq without its linear part (*mixed*), δq (*inertial*), or zero
/// (*body*). What follows, as a state of contact δm, stays. A deviation of finite size is converted by the same linear map.
///
/// * `q`, `v` – the state, in the crate's own representation
/// * `dx` – length 2 `nv` or more
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::dynamics::deviation_to_representation;
/// use dualbody::{model::{LinkSpec, ModelBuilder}, spatial::Representation};
///
/// let mut builder = ModelBuilder::new("ball");
/// builder.add_link(LinkSpec::new("ball").with_mass(1.0, [0.0; 3], [0.1; 3]));
/// let ball = builder.build()?;
/// // It flies along x. Turned by 1 mrad about z, the same velocity in its own axes points 1 mrad aside in the world.
/// let (q, v) = ([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// let mut dx = [0.0; 12];
/// dx[5] = 1e-3;
/// let mixed = deviation_to_representation(&ball, &q, &v, &dx, Representation::Mixed);
/// assert_eq!((mixed[5], mixed[7]), (1e-3, 2e-3));
/// # Ok::<(), dualbody::LoadError>(())
/// ```
pub fn deviation_to_representation<P: Scalar, T: Over<P>>(
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
pub fn deviation_from_representation<P: Scalar, T: Over<P>>(
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
pub fn gradient_to_representation<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    gradient: &[T],
    to: Representation,
) -> DVector<T> {
    let (by_q, by_v, rest) = split(model, v, gradient);
    let mut by_q = by_q.to_vec();
    if model.has_floating_base() {
        // g_v · (Ω(δq) × v) = −(v ×* g_v)... with both signs: Ω × v = −v × Ω, so it is (v ×* g_v) · Ω(δq).
        let force = base_velocity(v).cross_force(&Force::from_array(first_six(by_v)));
        let part = to.turning(&Motion::new(force.linear, force.angular));
        for (x, part) in by_q.iter_mut().zip(part.to_array()) {
            *x -= part;
        }
    }
    let by_q = force_to_representation(model, q, &by_q, to);
    let by_v = force_to_representation(model, q, by_v, to);
    joined(&by_q, &by_v, rest)
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
    std::array::from_fn(|k| x[k])
}
