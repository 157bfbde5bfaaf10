//! The terms of a cost on its system, whatever that is: their sum, to second order as Gauss and Newton have it, and
//! exactly.

use std::ops::Range;

use num_dual::HyperDual64;

use super::Expansion;
use crate::scalar::{Scalar, lift_into};
use crate::trajopt::activation::Activation;
use crate::trajopt::residual::{BoundResidual, ResidualJacobian};
use crate::trajopt::system::{AnySystem, On};

/// Weighting of the residual of a term of a cost.
pub(in crate::trajopt) struct Weighting {
    pub(in crate::trajopt) weight: f64,
    pub(in crate::trajopt) activation: Activation,
    /// The stages at which it counts; all where none are said.
    pub(in crate::trajopt) stages: Option<Range<usize>>,
}

/// Takes a term of a cost, its residual on its system.
pub(in crate::trajopt) type TermVisitor<'a> = dyn FnMut(&Weighting, &dyn BoundResidual) + 'a;
/// A cost on its system: hands out its terms, one after the other.
pub(in crate::trajopt) type Terms<'a> = dyn Fn(&mut TermVisitor<'_>) + 'a;

/// A stage at a state and an input; no input at the end of the horizon.
#[derive(Clone, Copy)]
pub(in crate::trajopt) struct Point<'a> {
    pub(in crate::trajopt) stage: usize,
    pub(in crate::trajopt) x: &'a [f64],
    pub(in crate::trajopt) u: &'a [f64],
}

impl Weighting {
    fn counts_at(&self, stage: usize) -> bool {
        let stages = self.stages.as_ref();
        stages.is_none_or(|stages| stages.contains(&stage))
    }
}

/// The value of a cost, without allocation.
pub(in crate::trajopt) fn evaluate(
    terms: &Terms<'_>,
    at: Point<'_>,
    memory: &mut ResidualJacobian,
) -> f64 {
    let mut sum = 0.0;
    terms(&mut |term, residual| {
        if term.counts_at(at.stage) {
            memory.values.resize(residual.dim(), 0.0);
            residual.value(at.stage, at.x, at.u, &mut memory.values);
            sum += term.weight * term.activation.value(&memory.values);
        }
    });
    sum
}

/// Adds `scale` times value, gradient and the upper triangle of the Gauss–Newton Hessian.
pub(in crate::trajopt) fn add_expansion(
    terms: &Terms<'_>,
    at: Point<'_>,
    scale: f64,
    memory: &mut ResidualJacobian,
    out: &mut Expansion,
) {
    terms(&mut |term, residual| {
        if !term.counts_at(at.stage) {
            return;
        }
        memory.prepare(residual.dim());
        residual.linearize(at.stage, at.x, at.u, memory);
        let weight = scale * term.weight;
        out.value += weight * term.activation.value(&memory.values);
        for (i, &r) in memory.values.iter().enumerate() {
            let (slope, curvature) = term.activation.slope_and_curvature(i, r);
            out.add_row(memory.row(i), weight * slope, weight * curvature);
        }
    });
}

/// Adds `scale` times value, gradient and exact Hessian. Allocates.
pub(in crate::trajopt) fn add_exact_expansion(
    terms: &Terms<'_>,
    system: &dyn AnySystem,
    at: Point<'_>,
    scale: f64,
    out: &mut Expansion,
) {
    let exact = expand_exactly(terms, system, at);
    out.value += scale * exact.value;
    out.gradient.axpy(scale, &exact.gradient, 1.0);
    out.hessian += exact.hessian * scale;
}

/// Value, gradient and exact Hessian, by hyper-dual numbers. Allocates.
pub(in crate::trajopt) fn expand_exactly(
    terms: &Terms<'_>,
    system: &dyn AnySystem,
    at: Point<'_>,
) -> Expansion {
    let n = system.ndx() + at.u.len();
    let mut out = Expansion::zeros(n);
    let mut seeded = SecondOrder::new(system, at);
    out.value = seeded.cost(terms).re;
    for i in 0..n {
        for k in 0..=i {
            let cost = seeded.in_directions(i, k, terms);
            out.gradient[i] = cost.eps1;
            out.hessian[(i, k)] = cost.eps1eps2;
            out.hessian[(k, i)] = cost.eps1eps2;
        }
    }
    out
}

/// A point with two directions, on hyper-dual numbers.
struct SecondOrder<'a> {
    system: &'a dyn On<HyperDual64>,
    stage: usize,
    base: Vec<HyperDual64>,
    moved: Vec<HyperDual64>,
    /// (δx, u + δu).
    z: Vec<HyperDual64>,
}

impl<'a> SecondOrder<'a> {
    fn new(system: &'a dyn AnySystem, at: Point<'_>) -> Self {
        let zero = HyperDual64::from(0.0);
        let mut base = vec![zero; at.x.len()];
        lift_into(at.x, &mut base);
        let inputs = at.u.iter().map(|&u| HyperDual64::from(u));
        let zeros = std::iter::repeat_n(zero, system.ndx());
        Self {
            system,
            stage: at.stage,
            moved: base.clone(),
            base,
            z: zeros.chain(inputs).collect(),
        }
    }

    fn in_directions(&mut self, i: usize, k: usize, terms: &Terms<'_>) -> HyperDual64 {
        (self.z[i].eps1, self.z[k].eps2) = (1.0, 1.0);
        let out = self.cost(terms);
        (self.z[i].eps1, self.z[k].eps2) = (0.0, 0.0);
        out
    }

    fn cost(&mut self, terms: &Terms<'_>) -> HyperDual64 {
        let (dx, u) = self.z.split_at(self.system.ndx());
        self.system.integrate(&self.base, dx, &mut self.moved);
        let zero = HyperDual64::from(0.0);
        let (stage, moved, mut sum) = (self.stage, &self.moved, zero);
        terms(&mut |term, residual| {
            if term.counts_at(stage) {
                let mut r = vec![zero; residual.dim()];
                residual.second_order(stage, moved, u, &mut r);
                let weighted = Scalar::mul_add_real(term.activation.value(&r), term.weight, zero);
                sum += weighted;
            }
        });
        sum
    }
}
