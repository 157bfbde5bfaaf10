//! The motion to which rows look ahead, with the gradient through it.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::columns::{add_weighted_turning, turned_into};
use super::sink::{Bias, SlopePoint};
use super::weights::StepSlopes;
use crate::constraint::CarrierMotion;
use crate::dynamics::{Kinematics, Slopes, Sweep, Weighted, world_acceleration};
use crate::model::{BodyId, Model};
use crate::scalar::Scalar;
use crate::sim::moment::Moment;
use crate::spatial::Motion;

/// v⁺ = v + Δt ã₀ of rows that look ahead along ã₀; v for others.
pub(super) fn velocity_after<T: Scalar>(
    at: &Moment<'_, f64, T>,
    bias: &Bias<'_, T>,
    out: &mut [T],
) {
    out.copy_from_slice(at.v());
    if let Bias::Ahead(seen) = bias {
        let stepped = out.iter_mut().zip(*seen);
        stepped.for_each(|(v, &a)| *v += a * at.dt());
    }
}

/// A sweep at the velocity after a step, the configuration of before it, and ã = 0.
#[derive(Clone, Debug)]
pub(super) struct After<T: Scalar> {
    pub(super) sweep: Sweep<T>,
    v: Vec<T>,
    /// The acceleration at which ã = 0.
    a: Vec<T>,
    /// Zeros: nothing is weighted but what is added between the passes.
    rest: Vec<T>,
    by_a: Vec<T>,
}

impl<T: Scalar> After<T> {
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
    pub(super) fn start(&mut self, at: &SlopePoint<'_, T>) {
        if let Some(held) = &at.held {
            velocity_after(at.moment, &held.bias, &mut self.v);
        }
        let at = at.moment;
        turned_into(at.model(), &self.v, &self.rest, &mut self.a);
        self.a.iter_mut().for_each(|a| *a = -*a);
        let weighted = weighted(at.q(), &self.v, &self.a, &self.rest);
        self.sweep.start(at.model(), &weighted);
    }

    /// The pass inward. What depends on v⁺ goes to `by_next_v`, and moves with v.
    pub(super) fn finish(
        &mut self,
        at: &Moment<'_, f64, T>,
        out: &mut StepSlopes<'_, T>,
        by_next_v: &mut [T],
    ) {
        let weighted = weighted(at.q(), &self.v, &self.a, &self.rest);
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

fn weighted<'a, T: Scalar>(q: &'a [T], v: &'a [T], a: &'a [T], rest: &'a [T]) -> Weighted<'a, T> {
    Weighted {
        q,
        v,
        a,
        mu: rest,
        external: &[],
    }
}

/// Motion of a body, or of the world, in a sweep between its passes. The acceleration has that of the world beside it.
pub(super) fn motion_in<T: Scalar>(
    sweep: &Sweep<T>,
    model: &Model,
    on: Option<BodyId>,
    kinematics: Option<&Kinematics<T>>,
) -> CarrierMotion<T> {
    let Some(body) = on else {
        return CarrierMotion {
            bias: world_acceleration(model),
            ..CarrierMotion::at_rest()
        };
    };
    let (own, seen) = (&sweep.bodies[body.0], sweep.seen.get(body.0));
    let U = seen.map_or_else(Motion::zero, |seen| seen.U);
    CarrierMotion {
        X_WB: kinematics.map_or_else(|| sweep.pose(model, body), |all| all.pose(on)),
        V: own.V,
        bias: own.A - U,
        U,
    }
}
