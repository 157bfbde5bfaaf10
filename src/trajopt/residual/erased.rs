//! Residuals behind pointers: those of users know their system by its type, those of this library (`built_in.rs`) by
//! its face alone.

use std::fmt;

use num_dual::HyperDual64;

use super::built_in::{AnyBuiltIn, Site};
use super::{Dependence, Node, Residual, ResidualJacobian};
use crate::model::Model;
use crate::trajopt::system::{AnySystem, System};

/// A residual of whatever type, as costs and constraints hold it.
pub enum Erased<D> {
    /// One of a user.
    User(Box<dyn AnyResidual<D>>),
    /// One of this library; where it is about a robot, with the way from the system to its model.
    BuiltIn(Box<dyn AnyBuiltIn>, Option<fn(&D) -> &Model>),
    /// One for each stage, the last from there on; all with the dimension of the first.
    Schedule(Vec<Self>),
}

/// A residual of a user on the scalars that solvers use.
pub trait AnyResidual<D: System>: Send + Sync {
    fn dim(&self, dynamics: &D) -> usize;
    fn depends_on(&self) -> Dependence;
    fn value(&self, node: &Node<'_, D>, x: &[f64], u: &[f64], r: &mut [f64]);
    fn linearize(&self, node: &Node<'_, D>, x: &[f64], u: &[f64], out: &mut ResidualJacobian);
    fn second_order(
        &self,
        node: &Node<'_, D>,
        x: &[HyperDual64],
        u: &[HyperDual64],
        r: &mut [HyperDual64],
    );
}

impl<D: System, R: Residual<D>> AnyResidual<D> for R {
    fn dim(&self, dynamics: &D) -> usize {
        Residual::dim(self, dynamics)
    }

    fn depends_on(&self) -> Dependence {
        Residual::<D>::depends_on(self)
    }

    fn value(&self, node: &Node<'_, D>, x: &[f64], u: &[f64], r: &mut [f64]) {
        Residual::value(self, node, x, u, r);
    }

    fn linearize(&self, node: &Node<'_, D>, x: &[f64], u: &[f64], out: &mut ResidualJacobian) {
        Residual::linearize(self, node, x, u, out);
    }

    fn second_order(
        &self,
        node: &Node<'_, D>,
        x: &[HyperDual64],
        u: &[HyperDual64],
        r: &mut [HyperDual64],
    ) {
        self.eval(node, x, u, r);
    }
}

impl<D: System> Erased<D> {
    pub(in crate::trajopt) fn user<R: Residual<D>>(residual: R) -> Self {
        Self::User(Box::new(residual))
    }

    pub(in crate::trajopt) fn depends_on(&self) -> Dependence {
        match self {
            Self::User(residual) => residual.depends_on(),
            Self::BuiltIn(residual, _) => residual.depends_on(),
            Self::Schedule(residuals) => residuals[0].depends_on(),
        }
    }

    pub(in crate::trajopt) fn dim(&self, dynamics: &D) -> usize {
        match self {
            Self::User(residual) => residual.dim(dynamics),
            Self::BuiltIn(residual, _) => residual.dim(dynamics),
            Self::Schedule(residuals) => residuals[0].dim(dynamics),
        }
    }

    /// The residual on its system.
    pub(in crate::trajopt) fn on<'a>(&'a self, dynamics: &'a D) -> OnSystem<'a, D> {
        OnSystem {
            residual: self,
            dynamics,
        }
    }
}

impl<D> fmt::Debug for Erased<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Erased")
    }
}

/// A residual on its system: all that solvers know of it.
pub(in crate::trajopt) trait BoundResidual {
    fn dim(&self) -> usize;
    fn value(&self, stage: usize, x: &[f64], u: &[f64], r: &mut [f64]);
    /// * `out` – prepared with `dim` rows of zeros
    fn linearize(&self, stage: usize, x: &[f64], u: &[f64], out: &mut ResidualJacobian);
    fn second_order(
        &self,
        stage: usize,
        x: &[HyperDual64],
        u: &[HyperDual64],
        r: &mut [HyperDual64],
    );
}

/// A residual and its system.
pub(in crate::trajopt) struct OnSystem<'a, D> {
    residual: &'a Erased<D>,
    dynamics: &'a D,
}

impl<'a, D: System> OnSystem<'a, D> {
    fn node(&self, stage: usize) -> Node<'a, D> {
        let dynamics = self.dynamics;
        Node { dynamics, stage }
    }

    fn site(&self, model: Option<fn(&D) -> &Model>, stage: usize) -> Site<'a, dyn AnySystem + 'a> {
        let model = model.map(|model| model(self.dynamics));
        Site::new(self.dynamics.face(), model, stage)
    }

    /// Residual of a stage in a schedule.
    fn scheduled(&self, residuals: &'a [Erased<D>], stage: usize) -> Self {
        let own = residuals[stage.min(residuals.len() - 1)].on(self.dynamics);
        check_scheduled(own.dim(), self.dim(), stage);
        own
    }
}

fn check_scheduled(dim: usize, first: usize, stage: usize) {
    assert_eq!(
        dim, first,
        "the residual of stage {stage} in a schedule has the dimension of the first one"
    );
}

impl<D: System> BoundResidual for OnSystem<'_, D> {
    fn dim(&self) -> usize {
        self.residual.dim(self.dynamics)
    }

    fn value(&self, stage: usize, x: &[f64], u: &[f64], r: &mut [f64]) {
        match self.residual {
            Erased::User(own) => own.value(&self.node(stage), x, u, r),
            Erased::BuiltIn(own, model) => own.value(&self.site(*model, stage), x, u, r),
            Erased::Schedule(all) => self.scheduled(all, stage).value(stage, x, u, r),
        }
    }

    fn linearize(&self, stage: usize, x: &[f64], u: &[f64], out: &mut ResidualJacobian) {
        match self.residual {
            Erased::User(own) => own.linearize(&self.node(stage), x, u, out),
            Erased::BuiltIn(own, model) => own.linearize(&self.site(*model, stage), x, u, out),
            Erased::Schedule(all) => self.scheduled(all, stage).linearize(stage, x, u, out),
        }
    }

    fn second_order(
        &self,
        stage: usize,
        x: &[HyperDual64],
        u: &[HyperDual64],
        r: &mut [HyperDual64],
    ) {
        match self.residual {
            Erased::User(own) => own.second_order(&self.node(stage), x, u, r),
            Erased::BuiltIn(own, model) => own.second_order(&self.site(*model, stage), x, u, r),
            Erased::Schedule(all) => self.scheduled(all, stage).second_order(stage, x, u, r),
        }
    }
}
