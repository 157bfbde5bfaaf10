//! The terms of a cost: their sum, to second order as Gauss and Newton have it, and exactly.

use num_dual::HyperDual64;

use super::{Cost, Expansion, Term};
use crate::autodiff::TangentPoint;
use crate::scalar::Scalar;
use crate::trajopt::residual::{Node, ResidualJacobian};
use crate::trajopt::system::AnySystem;

/// A stage at a state and an input; no input at the end of the horizon.
#[derive(Clone, Copy)]
pub(in crate::trajopt) struct Point<'a> {
    pub(in crate::trajopt) system: &'a dyn AnySystem,
    stage: usize,
    pub(in crate::trajopt) x: &'a [f64],
    pub(in crate::trajopt) u: &'a [f64],
}

impl<'a> Point<'a> {
    /// * `stage` – that of a longer motion, as residuals count it
    pub(in crate::trajopt) fn new(
        system: &'a dyn AnySystem,
        stage: usize,
        x: &'a [f64],
        u: &'a [f64],
    ) -> Self {
        Self {
            system,
            stage,
            x,
            u,
        }
    }

    pub(in crate::trajopt) fn node(&self) -> Node<'a> {
        Node::new(self.system, self.stage)
    }
}

impl Cost {
    /// The terms that count at a stage.
    fn terms_at(&self, stage: usize) -> impl Iterator<Item = &Term> {
        let counts = move |term: &&Term| {
            let stages = term.stages.as_ref();
            stages.is_none_or(|stages| stages.contains(&stage))
        };
        self.terms.iter().filter(counts)
    }

    /// The value, without allocation.
    pub(in crate::trajopt) fn evaluate(&self, at: Point<'_>, memory: &mut ResidualJacobian) -> f64 {
        let mut sum = 0.0;
        for term in self.terms_at(at.stage) {
            memory.values.resize(term.residual.dim(&at.node()), 0.0);
            let r = &mut memory.values;
            term.residual.value(&at.node(), at.x, at.u, r);
            sum += term.weight * term.activation.value(r);
        }
        sum
    }

    /// Adds `scale` times value, gradient and the upper triangle of the Gauss–Newton Hessian.
    pub(in crate::trajopt) fn add_expansion(
        &self,
        at: Point<'_>,
        scale: f64,
        memory: &mut ResidualJacobian,
        out: &mut Expansion,
    ) {
        for term in self.terms_at(at.stage) {
            memory.prepare(term.residual.dim(&at.node()));
            term.residual.linearize(&at.node(), at.x, at.u, memory);
            let weight = scale * term.weight;
            out.value += weight * term.activation.value(&memory.values);
            for (i, &r) in memory.values.iter().enumerate() {
                let (slope, curvature) = term.activation.slope_and_curvature(i, r);
                out.add_row(memory.row(i), weight * slope, weight * curvature);
            }
        }
    }

    /// Adds `scale` times value, gradient and exact Hessian. Allocates.
    pub(in crate::trajopt) fn add_exact_expansion(
        &self,
        at: Point<'_>,
        scale: f64,
        out: &mut Expansion,
    ) {
        let exact = self.exact_expansion(at);
        out.value += scale * exact.value;
        out.gradient.axpy(scale, &exact.gradient, 1.0);
        out.hessian += exact.hessian * scale;
    }

    /// Value, gradient and exact Hessian, by hyper-dual numbers. Allocates.
    pub(super) fn exact_expansion(&self, at: Point<'_>) -> Expansion {
        let n = at.system.ndx() + at.u.len();
        let mut out = Expansion::zeros(n);
        let node: Node<'_, HyperDual64> = at.node().on(|system| system);
        let integrate = |x: &[_], dx: &[_], out: &mut [_]| node.dynamics.integrate(x, dx, out);
        let mut point = TangentPoint::new(at.x.len(), at.system.ndx(), at.u.len());
        point.set(at.x, at.u);
        let [x, u] = point.moved(integrate);
        out.value = self.on_hyper_duals(&node, x, u).re;
        for i in 0..n {
            for k in 0..=i {
                let value = |x: &[_], u: &[_]| self.on_hyper_duals(&node, x, u);
                let cost = point.in_pair([i, k], integrate, value);
                out.gradient[i] = cost.eps1;
                out.hessian[(i, k)] = cost.eps1eps2;
                out.hessian[(k, i)] = cost.eps1eps2;
            }
        }
        out
    }

    fn on_hyper_duals(
        &self,
        node: &Node<'_, HyperDual64>,
        x: &[HyperDual64],
        u: &[HyperDual64],
    ) -> HyperDual64 {
        let zero = HyperDual64::from(0.0);
        let mut sum = zero;
        for term in self.terms_at(node.stage) {
            let mut r = vec![zero; term.residual.dim(&node.on_plain())];
            term.residual.eval(node, x, u, &mut r);
            sum += Scalar::mul_add_real(term.activation.value(&r), term.weight, zero);
        }
        sum
    }
}
