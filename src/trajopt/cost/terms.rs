//! The terms of a cost: their sum, and to second order as Gauss and Newton have it.

use super::{Cost, Expansion, Term};
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
    pub(super) fn terms_at(&self, stage: usize) -> impl Iterator<Item = &Term> {
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
}
