//! Residuals behind pointers: those of users know their system by its type, those of this library by its [face](AnySystem) alone, so
//! that they are compiled once, whatever the system.

use std::fmt;

use num_dual::HyperDual64;

use super::any_system::{AnySystem, On, Sizes};
use super::residual::{Dependence, Node, Residual, ResidualJacobian};
use super::system::System;
use crate::autodiff::{CHUNK, Dual};
use crate::model::Model;
use crate::scalar::Scalar;

/// Any residual of a system.
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

/// Where a residual of this library is evaluated: what it may know of a system, which is `S`, and the stage.
pub struct Site<'a, S: ?Sized> {
    pub(super) system: &'a S,
    /// The robot, for residuals about one.
    model: Option<&'a Model>,
    pub(super) stage: usize,
}

impl<'a, S: ?Sized> Site<'a, S> {
    pub(super) fn new(system: &'a S, model: Option<&'a Model>, stage: usize) -> Self {
        Self {
            system,
            model,
            stage,
        }
    }

    /// The robot that the residual is about.
    pub(super) fn model(&self) -> &'a Model {
        self.model.expect("a residual about a robot has its model")
    }
}

impl<S: ?Sized> fmt::Debug for Site<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Site(stage {})", self.stage)
    }
}

/// A residual of this library: a formula over the scalar that knows a system by its face.
pub(super) trait BuiltIn: Send + Sync {
    fn dim(&self, sizes: &dyn Sizes) -> usize;
    fn depends_on(&self) -> Dependence;
    fn eval<T: Scalar>(&self, site: &Site<'_, dyn On<T> + '_>, x: &[T], u: &[T], r: &mut [T]);

    /// [`eval`](Self::eval) on plain numbers, where a residual knows a shorter way.
    fn value(&self, site: &Site<'_, dyn AnySystem + '_>, x: &[f64], u: &[f64], r: &mut [f64]) {
        let site = Site::new(site.system as &dyn On<f64>, site.model, site.stage);
        self.eval(&site, x, u, r);
    }

    /// By dual numbers unless a residual knows better.
    fn linearize(
        &self,
        site: &Site<'_, dyn AnySystem + '_>,
        x: &[f64],
        u: &[f64],
        out: &mut ResidualJacobian,
    ) {
        self.linearize_by_duals(site, x, u, out);
    }

    /// Fills values and derivatives by dual numbers.
    fn linearize_by_duals(
        &self,
        site: &Site<'_, dyn AnySystem + '_>,
        x: &[f64],
        u: &[f64],
        out: &mut ResidualJacobian,
    ) {
        let dual = Site::new(site.system as &dyn On<Dual<CHUNK>>, site.model, site.stage);
        let mut eval = |x: &[Dual<CHUNK>], u: &[Dual<CHUNK>], r: &mut [Dual<CHUNK>]| {
            self.eval(&dual, x, u, r);
        };
        out.fill(site.system, self.depends_on(), x, u, &mut eval);
    }
}

/// A residual of this library on the scalars that solvers use.
pub trait AnyBuiltIn: Send + Sync {
    fn dim(&self, sizes: &dyn Sizes) -> usize;
    fn depends_on(&self) -> Dependence;
    fn value(&self, site: &Site<'_, dyn AnySystem + '_>, x: &[f64], u: &[f64], r: &mut [f64]);
    fn linearize(
        &self,
        site: &Site<'_, dyn AnySystem + '_>,
        x: &[f64],
        u: &[f64],
        out: &mut ResidualJacobian,
    );
    fn second_order(
        &self,
        site: &Site<'_, dyn AnySystem + '_>,
        x: &[HyperDual64],
        u: &[HyperDual64],
        r: &mut [HyperDual64],
    );
}

impl<R: BuiltIn> AnyBuiltIn for R {
    fn dim(&self, sizes: &dyn Sizes) -> usize {
        BuiltIn::dim(self, sizes)
    }

    fn depends_on(&self) -> Dependence {
        BuiltIn::depends_on(self)
    }

    fn value(&self, site: &Site<'_, dyn AnySystem + '_>, x: &[f64], u: &[f64], r: &mut [f64]) {
        BuiltIn::value(self, site, x, u, r);
    }

    fn linearize(
        &self,
        site: &Site<'_, dyn AnySystem + '_>,
        x: &[f64],
        u: &[f64],
        out: &mut ResidualJacobian,
    ) {
        BuiltIn::linearize(self, site, x, u, out);
    }

    fn second_order(
        &self,
        site: &Site<'_, dyn AnySystem + '_>,
        x: &[HyperDual64],
        u: &[HyperDual64],
        r: &mut [HyperDual64],
    ) {
        let site = Site::new(site.system as &dyn On<HyperDual64>, site.model, site.stage);
        self.eval(&site, x, u, r);
    }
}

/// Implements [`Residual`] by [`BuiltIn`], for systems that are `$system`: any, or robots, whose model is `$model`.
macro_rules! built_in_residual {
    ($residual:ty, $system:ident, |$dynamics:ident| $model:expr, $way:expr) => {
        impl<D: $crate::trajopt::$system> $crate::trajopt::Residual<D> for $residual {
            fn dim(&self, dynamics: &D) -> usize {
                $crate::trajopt::erased::BuiltIn::dim(self, dynamics)
            }

            fn eval<T: $crate::Scalar>(
                &self,
                node: &$crate::trajopt::Node<'_, D>,
                x: &[T],
                u: &[T],
                r: &mut [T],
            ) {
                let $dynamics = node.dynamics;
                let system: &dyn $crate::trajopt::any_system::On<T> = $dynamics;
                let site = $crate::trajopt::erased::Site::new(system, $model, node.stage);
                $crate::trajopt::erased::BuiltIn::eval(self, &site, x, u, r);
            }

            fn depends_on(&self) -> $crate::trajopt::Dependence {
                $crate::trajopt::erased::BuiltIn::depends_on(self)
            }

            fn value(
                &self,
                node: &$crate::trajopt::Node<'_, D>,
                x: &[f64],
                u: &[f64],
                r: &mut [f64],
            ) {
                let $dynamics = node.dynamics;
                let site = $crate::trajopt::erased::Site::new($dynamics.face(), $model, node.stage);
                $crate::trajopt::erased::BuiltIn::value(self, &site, x, u, r);
            }

            fn linearize(
                &self,
                node: &$crate::trajopt::Node<'_, D>,
                x: &[f64],
                u: &[f64],
                out: &mut $crate::trajopt::ResidualJacobian,
            ) {
                let $dynamics = node.dynamics;
                let site = $crate::trajopt::erased::Site::new($dynamics.face(), $model, node.stage);
                $crate::trajopt::erased::BuiltIn::linearize(self, &site, x, u, out);
            }

            fn erase(self) -> $crate::trajopt::erased::Erased<D> {
                $crate::trajopt::erased::Erased::BuiltIn(self.boxed(), $way)
            }
        }

        impl $residual {
            /// Behind a pointer, with all that it points to compiled here.
            #[inline(never)]
            fn boxed(self) -> Box<dyn $crate::trajopt::erased::AnyBuiltIn> {
                Box::new(self)
            }
        }
    };
    ($residual:ty, of any system) => {
        $crate::trajopt::erased::built_in_residual!($residual, System, |dynamics| None, None);
    };
    ($residual:ty, of a robot) => {
        $crate::trajopt::erased::built_in_residual!(
            $residual,
            Robot,
            |dynamics| Some($crate::trajopt::Robot::model(dynamics)),
            Some(<D as $crate::trajopt::Robot>::model)
        );
    };
}
pub(super) use built_in_residual;

impl<D: System> Erased<D> {
    pub(super) fn user<R: Residual<D>>(residual: R) -> Self {
        Self::User(Box::new(residual))
    }

    pub(super) fn depends_on(&self) -> Dependence {
        match self {
            Self::User(residual) => residual.depends_on(),
            Self::BuiltIn(residual, _) => residual.depends_on(),
            Self::Schedule(residuals) => residuals[0].depends_on(),
        }
    }

    pub(super) fn dim(&self, dynamics: &D) -> usize {
        match self {
            Self::User(residual) => residual.dim(dynamics),
            Self::BuiltIn(residual, _) => residual.dim(dynamics),
            Self::Schedule(residuals) => residuals[0].dim(dynamics),
        }
    }

    /// The residual on its system.
    pub(super) fn on<'a>(&'a self, dynamics: &'a D) -> OnSystem<'a, D> {
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
pub(super) trait BoundResidual {
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
pub(super) struct OnSystem<'a, D> {
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

    /// That of a stage in a schedule.
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
