//! Derivatives of the rows of a solver and, through its forces, of the accelerations.
//!
//! The acceleration a and the forces f obey
//!
//! > ID(q, v, a) = τ + Jᵀ f,  and the laws for  y = J ã − w + R f,
//!
//! where ã is a with the rotation of axes of linear velocities, and w and R are reference and compliance of the laws. At fixed f, the first equation
//! gives the change of a, and so of y; then the solver gives the change of the forces, and the first equation the final change of a: the implicit
//! function theorem twice.
//!
//! It uses half factors, M = Lᵀ D L, in which J keeps its zeros: with Lᵀ X = Jᵀ and Lᵀ Z = `δID` − δτ − δJᵀ f,  J δa = −Xᵀ D⁻¹ Z at fixed f,
//! and −δa = L⁻¹ D⁻¹ (Z − X δf).

use super::weights::StepGradientSum;
use crate::dynamics::{Blocks, ParameterSlots};
use crate::joint::{Joint as _, MAX_NV};
use crate::model::manifold::v_range;
use crate::model::{Body, Model};
use crate::scalar::{BLOCK, Dual, GROUP, Linear, Pack, Scalar, is_nothing, vectorized_over};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::spatial::linear::cross;

/// ∂y of all rows at fixed forces and accelerations, then at fixed forces, then ∂f.
#[derive(Clone, Debug)]
pub(crate) struct RowColumns<T = f64> {
    pub(crate) columns: Blocks<T>,
    /// ã.
    pub(crate) seen: Vec<T>,
    memory: Vec<Pack<T, BLOCK>>,
}

impl<T: Scalar> RowColumns<T> {
    /// Memory for so many rows and columns at most.
    pub(crate) fn new(model: &Model, rows: usize, columns: usize) -> Self {
        Self {
            columns: Blocks::new(rows, columns),
            seen: vec![T::zero(); model.nv()],
            memory: Vec::with_capacity(2 * rows),
        }
    }

    /// ã, and its contribution to y = J ã through rotating axes; the rest of ∂y is added later.
    ///
    /// * `jacobian` – J, row by row
    pub(crate) fn start(
        &mut self,
        model: &Model,
        v: &[T],
        a: &[T],
        jacobian: &[T],
        columns: usize,
    ) {
        let nv = model.nv();
        self.columns.resize(jacobian.len() / nv.max(1), columns);
        turned_into(model, v, a, &mut self.seen);
        add_turning(model, v, jacobian, &mut self.columns);
    }

    /// From the derivatives of the balance at fixed forces to −∂a and ∂f.
    pub(crate) fn solve(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        balance: &mut Balance<T>,
        columns: &mut Blocks<T>,
    ) {
        let (halves, factor) = (balance.rows(), balance.factor());
        if halves.count() == 0 {
            return columns.solve(factor);
        }
        vectorized_over::<T, _>(
            #[inline(always)]
            || {
                for (z, y) in columns.blocks_mut().zip(self.columns.blocks_mut()) {
                    factor.back_substitute(z);
                    for (group, y) in halves.halves().zip(y.chunks_mut(GROUP)) {
                        for (k, (z, x)) in z.iter().zip(group).enumerate() {
                            subtract_product(*z * factor.reciprocal(k), x, y);
                        }
                    }
                }
            },
        );
        balance.respond(at, self.columns.blocks_mut(), &mut self.memory);
        let (halves, factor) = (balance.rows(), balance.factor());
        vectorized_over::<T, _>(
            #[inline(always)]
            || {
                for (z, f) in columns.blocks_mut().zip(self.columns.blocks()) {
                    for (group, f) in halves.halves().zip(f.chunks(GROUP)) {
                        let coordinates = z.iter_mut().zip(group);
                        coordinates.for_each(|(z, x)| *z = minus_product(*z, f, x));
                    }
                    factor.forward_substitute(z);
                }
            },
        );
    }
}

/// ã: the acceleration with the turning of axes that carry linear velocities.
pub(crate) fn turned_into<T: Scalar>(model: &Model, v: &[T], a: &[T], out: &mut [T]) {
    out.copy_from_slice(a);
    for body in model.independent() {
        each_turning(body, v, |k, x| out[k] += x.re);
    }
}

/// Passes each coordinate along which the axes of a joint turn its linear velocity, and by how much with its derivatives in the velocity of that
/// joint, to `each`.
pub(crate) fn each_turning<T: Scalar>(
    body: &Body<f64>,
    v: &[T],
    mut each: impl FnMut(usize, Dual<T, MAX_NV>),
) {
    if !body.joint.turns_with_body() {
        return;
    }
    let own = v_range(body);
    let mut rates = [Dual::from(0.0); MAX_NV];
    for (k, &v) in v[own.clone()].iter().enumerate() {
        rates[k] = Dual::variable(v, k);
    }
    let turn = |k, x| each(own.start + k, x);
    (body.joint).turning(&body.center(), &rates[..own.len()], turn);
}

/// Adds what y = J (ω × (v + ω × c)) changes with v.
pub(crate) fn add_turning<T: Scalar>(
    model: &Model,
    v: &[T],
    jacobian: &[T],
    columns: &mut Blocks<T>,
) {
    let nv = model.nv();
    let rows = jacobian.len() / nv.max(1);
    for body in model.independent() {
        let own = v_range(body);
        each_turning(body, v, |k, x| {
            for row in 0..rows {
                let entry = jacobian[nv * row + k];
                for (l, slope) in own.clone().zip(x.eps) {
                    *columns.at(row, nv + l) += entry * slope;
                }
            }
        });
    }
}

/// Adds the gradient of a weighted ã in the velocity that turns axes, and in the centres of mass about which bodies turn.
///
/// * `by_seen` – its weights
/// * `slots` – places of parameters
pub(crate) fn add_weighted_turning<T: Scalar>(
    model: &Model,
    v: &[T],
    by_seen: &[T],
    slots: &ParameterSlots,
    out: &mut StepGradientSum<'_, T>,
) {
    for (id, body) in model.independent_with_ids() {
        each_turning(body, v, |k, x| {
            for (l, &slope) in x.eps.iter().enumerate().take(body.joint.nv()) {
                out.v[body.v + l] += by_seen[k] * slope;
            }
        });
        if body.joint.turns_with_body() {
            // ω × (v + ω × c), whose derivative in c is symmetric.
            let omega = body.motion(v).angular;
            let weights = body.motion(by_seen).linear;
            let by_center = cross(&omega, &cross(&omega, &weights));
            slots.add_center(id, body, &by_center, out.parameters);
        }
    }
}

/// y −= z x, where x is mostly zeros.
#[inline(always)]
fn subtract_product<T: Scalar>(z: Pack<T, BLOCK>, x: &[T], y: &mut [Pack<T, BLOCK>]) {
    let x = &x[..y.len()];
    for i in 0..y.len() {
        if !is_nothing(&x[i]) {
            y[i] = z.times_plus(-x[i], y[i]);
        }
    }
}

/// z − f x, where x is mostly zeros.
#[inline(always)]
fn minus_product<T: Scalar>(
    mut z: Pack<T, BLOCK>,
    f: &[Pack<T, BLOCK>],
    x: &[T],
) -> Pack<T, BLOCK> {
    let x = &x[..f.len()];
    for i in 0..f.len() {
        if !is_nothing(&x[i]) {
            z = f[i].times_plus(-x[i], z);
        }
    }
    z
}
