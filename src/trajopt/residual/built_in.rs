//! Residuals of this library: formulas over the scalar that know a system by its [face](AnySystem) alone, so that they
//! are compiled once, whatever the system.

use std::fmt;

use num_dual::HyperDual64;

use super::{Dependence, ResidualJacobian};
use crate::autodiff::{CHUNK, Dual};
use crate::model::Model;
use crate::scalar::Scalar;
use crate::trajopt::system::{AnySystem, On, Sizes};

/// Site at which a residual of this library is evaluated: what it may know of a system, which is `S`, and the stage.
pub struct Site<'a, S: ?Sized> {
    pub(in crate::trajopt) system: &'a S,
    /// The robot, for residuals about one.
    model: Option<&'a Model>,
    pub(in crate::trajopt) stage: usize,
}

impl<'a, S: ?Sized> Site<'a, S> {
    pub(in crate::trajopt) fn new(system: &'a S, model: Option<&'a Model>, stage: usize) -> Self {
        Self {
            system,
            model,
            stage,
        }
    }

    /// The robot that the residual is about.
    pub(in crate::trajopt) fn model(&self) -> &'a Model {
        self.model.expect("a residual about a robot has its model")
    }
}

impl<S: ?Sized> fmt::Debug for Site<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Site(stage {})", self.stage)
    }
}

/// A residual of this library: a formula over the scalar that knows a system by its face.
pub(in crate::trajopt) trait BuiltIn: Send + Sync {
    fn dim(&self, sizes: &dyn Sizes) -> usize;
    fn depends_on(&self) -> Dependence;
    fn eval<T: Scalar>(&self, site: &Site<'_, dyn On<T> + '_>, x: &[T], u: &[T], r: &mut [T]);

    /// [`eval`](Self::eval) on plain numbers, where a residual knows a shorter way.
    fn value(&self, site: &Site<'_, dyn AnySystem + '_>, x: &[f64], u: &[f64], r: &mut [f64]) {
        let site = Site::new(site.system as &dyn On<f64>, site.model, site.stage);
        self.eval(&site, x, u, r);
    }

    /// Linearises by dual numbers, unless a residual knows better.
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
        let dual = Site::new(
            site.system as &dyn On<Dual<f64, CHUNK>>,
            site.model,
            site.stage,
        );
        let mut eval =
            |x: &[Dual<f64, CHUNK>], u: &[Dual<f64, CHUNK>], r: &mut [Dual<f64, CHUNK>]| {
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
                $crate::trajopt::residual::built_in::BuiltIn::dim(self, dynamics)
            }

            fn eval<T: $crate::Scalar>(
                &self,
                node: &$crate::trajopt::Node<'_, D>,
                x: &[T],
                u: &[T],
                r: &mut [T],
            ) {
                let $dynamics = node.dynamics;
                let system: &dyn $crate::trajopt::system::On<T> = $dynamics;
                let site =
                    $crate::trajopt::residual::built_in::Site::new(system, $model, node.stage);
                $crate::trajopt::residual::built_in::BuiltIn::eval(self, &site, x, u, r);
            }

            fn depends_on(&self) -> $crate::trajopt::Dependence {
                $crate::trajopt::residual::built_in::BuiltIn::depends_on(self)
            }

            fn value(
                &self,
                node: &$crate::trajopt::Node<'_, D>,
                x: &[f64],
                u: &[f64],
                r: &mut [f64],
            ) {
                let $dynamics = node.dynamics;
                let site = $crate::trajopt::residual::built_in::Site::new(
                    $dynamics.face(),
                    $model,
                    node.stage,
                );
                $crate::trajopt::residual::built_in::BuiltIn::value(self, &site, x, u, r);
            }

            fn linearize(
                &self,
                node: &$crate::trajopt::Node<'_, D>,
                x: &[f64],
                u: &[f64],
                out: &mut $crate::trajopt::ResidualJacobian,
            ) {
                let $dynamics = node.dynamics;
                let site = $crate::trajopt::residual::built_in::Site::new(
                    $dynamics.face(),
                    $model,
                    node.stage,
                );
                $crate::trajopt::residual::built_in::BuiltIn::linearize(self, &site, x, u, out);
            }

            fn erase(self) -> $crate::trajopt::residual::Erased<D> {
                $crate::trajopt::residual::Erased::BuiltIn(self.boxed(), $way)
            }
        }

        impl $residual {
            /// Boxes the residual, with all that the pointer leads to compiled here.
            #[inline(never)]
            fn boxed(self) -> Box<dyn $crate::trajopt::residual::built_in::AnyBuiltIn> {
                Box::new(self)
            }
        }
    };
    ($residual:ty, of any system) => {
        $crate::trajopt::residual::built_in::built_in_residual!(
            $residual,
            System,
            |dynamics| None,
            None
        );
    };
    ($residual:ty, of a robot) => {
        $crate::trajopt::residual::built_in::built_in_residual!(
            $residual,
            Robot,
            |dynamics| Some($crate::trajopt::Robot::model(dynamics)),
            Some(<D as $crate::trajopt::Robot>::model)
        );
    };
}
pub(in crate::trajopt) use built_in_residual;
