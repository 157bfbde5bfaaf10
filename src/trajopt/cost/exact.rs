//! Exact second derivatives of a cost, by hyper-dual numbers.

use num_dual::HyperDual64;

use super::terms::Point;
use super::{Cost, Expansion};
use crate::autodiff::TangentPoint;
use crate::scalar::Scalar;
use crate::trajopt::residual::Node;
use crate::trajopt::system::AsSystem;

impl Cost {
    /// Value, gradient and exact Hessian, by hyper-dual numbers. Allocates.
    ///
    /// * `x`, `u` – state and input; no input at the end of the horizon
    pub fn expand_exactly(
        &self,
        dynamics: &(impl AsSystem + ?Sized),
        stage: usize,
        x: &[f64],
        u: &[f64],
    ) -> Expansion {
        self.exact_expansion(Point::new(dynamics.as_system(), stage, x, u))
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
    fn exact_expansion(&self, at: Point<'_>) -> Expansion {
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
