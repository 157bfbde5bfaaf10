//! The velocity after a step, to which rows look ahead.

use crate::dynamics::{Slopes, Sweep, Weighted};
use crate::model::Model;
use crate::scalar::Scalar;
use crate::sim::moment::Moment;
use crate::sim::terms::adjoint::StepSlopes;
use crate::sim::terms::columns::{add_weighted_turning, turned_into};

/// A sweep at the velocity v⁺ = v + Δt ã₀, the configuration of before the step, and ã = 0.
#[derive(Clone, Debug)]
pub(super) struct Ahead<T: Scalar> {
    pub(super) sweep: Sweep<T>,
    v: Vec<T>,
    /// The acceleration at which ã = 0.
    a: Vec<T>,
    /// Zeros: nothing is weighted but what is added between the passes.
    rest: Vec<T>,
    by_a: Vec<T>,
}

impl<T: Scalar> Ahead<T> {
    /// Memory for a model.
    pub(super) fn new(model: &Model) -> Self {
        let zeros = || vec![T::zero(); model.nv()];
        Self {
            sweep: Sweep::new(model),
            v: zeros(),
            a: zeros(),
            rest: zeros(),
            by_a: zeros(),
        }
    }

    /// The pass outward.
    ///
    /// * `seen` – ã₀
    pub(super) fn start(&mut self, at: &Moment<'_, f64, T>, seen: &[T]) {
        let stepped = self.v.iter_mut().zip(at.v()).zip(seen);
        stepped.for_each(|((out, &v), &a)| *out = v + a * at.dt());
        turned_into(at.model(), &self.v, &self.rest, &mut self.a);
        self.a.iter_mut().for_each(|a| *a = -*a);
        let weighted = weighted(at, &self.v, &self.a, &self.rest);
        self.sweep.start(at.model(), &weighted);
    }

    /// The pass inward. What depends on v⁺ goes to `by_next_v`, and moves with v.
    pub(super) fn finish(
        &mut self,
        at: &Moment<'_, f64, T>,
        out: &mut StepSlopes<'_, T>,
        by_next_v: &mut [T],
    ) {
        let weighted = weighted(at, &self.v, &self.a, &self.rest);
        self.by_a.fill(T::zero());
        let mut slopes = Slopes {
            q: &mut *out.q,
            v: &mut *by_next_v,
            a: &mut self.by_a,
            parameters: &mut *out.parameters,
        };
        self.sweep.finish(at.model(), &weighted, &mut slopes);
        self.by_a.iter_mut().for_each(|x| *x = -*x);
        add_weighted_turning(at.model(), &self.v, &self.by_a, by_next_v);
        let moved = out.v.iter_mut().zip(&*by_next_v);
        moved.for_each(|(out, &x)| *out += x);
    }
}

fn weighted<'a, T: Scalar>(
    at: &Moment<'a, f64, T>,
    v: &'a [T],
    a: &'a [T],
    rest: &'a [T],
) -> Weighted<'a, T> {
    Weighted {
        q: at.q(),
        v,
        a,
        mu: rest,
        external: &[],
    }
}
