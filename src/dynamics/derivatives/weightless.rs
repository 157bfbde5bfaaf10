//! Derivatives of the weight of what gravity does not act on; see [`crate::dynamics::weightless`].

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::propagate::Entries;
use crate::dynamics::passes::to_world;
use crate::dynamics::weightless::Spared;
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::spatial::Transform;
use crate::spatial::linear::cross;

/// Adds the derivative in q of the joint forces that F₀ takes, with a body's joints where they are:  Σ `S_k` · X* ∂F₀/∂`q_j`.
pub(super) fn add_spared_slopes<P: Scalar, T: Over<P>, E: Entries<T>>(
    model: &Model<P>,
    X_PB: impl Fn(usize) -> Transform<T>,
    spared: &Spared<T>,
    out: &mut E,
) {
    let mut X_AB = Transform::<T>::identity();
    for (id, ancestor) in to_world(model, Some(spared.body)) {
        for (j, S) in ancestor.columns::<T>() {
            let turn = X_AB.motion_inverse(&S).angular;
            let mut F = spared.under(&cross(&spared.gravity, &turn));
            for (k, body) in to_world(model, Some(spared.body)) {
                body.project(&F, |row, x| out.add(row, j, x, T::zero()));
                F = X_PB(k.0).force(&F);
            }
        }
        X_AB = X_PB(id.0) * X_AB;
    }
}
