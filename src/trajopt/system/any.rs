//! Systems as trait objects, on the scalars that solvers use, so that solvers are compiled once for all systems.

#[cfg(feature = "second-order")]
use num_dual::HyperDual64;

use super::System;
use crate::autodiff::{CHUNK, Dual};
use crate::linearize::Linearization;
use crate::model::Model;
use crate::trajopt::scratch::Scratch;

/// Declares a trait that goes through a pointer, and implements it for every type of another trait by its functions of the same names.
macro_rules! behind_a_pointer {
    (
        $(#[$about:meta])*
        pub trait $name:ident $(<$T:ident>)?: [$($bounds:tt)*] of $own:ident {
            $($(#[$doc:meta])* fn $f:ident(&self $(, $x:ident: $X:ty)* $(,)?) $(-> $out:ty)?;)*
        }
    ) => {
        $(#[$about])*
        pub trait $name $(<$T: $crate::scalar::Scalar>)?: $($bounds)* {
            $($(#[$doc])* fn $f(&self $(, $x: $X)*) $(-> $out)?;)*
        }

        impl<$($T: $crate::scalar::Scalar,)? Own: $own> $name $(<$T>)? for Own {
            $(fn $f(&self $(, $x: $X)*) $(-> $out)? {
                $own::$f(self $(, $x)*)
            })*
        }
    };
}
pub(in crate::trajopt) use behind_a_pointer;

behind_a_pointer! {
    /// The sizes of a system, and its robot; see [`System`] for each.
    pub trait Sizes: [Send + Sync] of System {
        /// Numbers in a state.
        fn nx(&self) -> usize;
        /// Dimension of the tangent space of the states.
        fn ndx(&self) -> usize;
        /// Dimension of the tangent space of the configuration.
        fn ndq(&self) -> usize;
        /// Number of inputs.
        fn nu(&self) -> usize;
        /// Time from one state to the next, s.
        fn time_step(&self) -> f64;
        /// Whether ⊕ is the plain sum.
        fn is_vector_space(&self) -> bool;
        /// The robot, if the system is one.
        fn robot(&self) -> Option<&Model>;
    }
}

behind_a_pointer! {
    /// The manifold of a system's states on one scalar; see [`System`] for each function.
    pub trait Manifold<T>: [Sizes] of System {
        /// x ⊕ δx.
        fn integrate(&self, x: &[T], dx: &[T], out: &mut [T]);
        /// `x1` ⊖ `x0`.
        fn difference(&self, x0: &[T], x1: &[T], dx: &mut [T]);
        /// The rate of ξ = x ⊖ start when x moves at `rate`.
        fn chart_rate(&self, xi: &[T], rate: &[T], out: &mut [T]);
    }
}

/// A manifold on the numbers of second derivatives, with the feature `second-order` that takes them.
#[cfg(feature = "second-order")]
pub trait ManifoldTwice: Manifold<HyperDual64> {}
#[cfg(feature = "second-order")]
impl<M: Manifold<HyperDual64>> ManifoldTwice for M {}

/// A manifold without second derivatives, which the feature `second-order` adds.
#[cfg(not(feature = "second-order"))]
pub trait ManifoldTwice: Sizes {}
#[cfg(not(feature = "second-order"))]
impl<M: Sizes> ManifoldTwice for M {}

behind_a_pointer! {
    /// A system of any type, as solvers use it: on plain numbers with its derivatives; its manifold also on dual numbers, for first derivatives of
    /// residuals, and with the feature `second-order` on hyper-dual numbers for second ones. A system with its own derivatives is not compiled on dual numbers here.
    pub trait AnySystem: [Manifold<f64> + Manifold<Dual<f64, CHUNK>> + ManifoldTwice] of System {
        /// x⁺ = f(x, u).
        fn step(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, next: &mut [f64]);
        /// ẋ = f(x, u).
        fn rate(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, rate: &mut [f64]);
        /// The Jacobians of the step.
        fn linearize(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization);
        /// The Jacobians of the rate.
        fn linearize_rate(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization);
        /// Aᵀ λ and Bᵀ λ of the step.
        fn vjp(&self, x: &[f64], u: &[f64], lambda: &[f64], scratch: &mut Scratch, dx: &mut [f64], du: &mut [f64]);
        /// Whether the step has second derivatives.
        fn has_step_hessian(&self) -> bool;
        /// Adds the Hessian of λᵀ f to the upper triangle of `hessian`.
        fn add_step_hessian(&self, x: &[f64], u: &[f64], lambda: &[f64], hessian: &mut [f64]);
        /// Makes the memory that steps and Jacobians will ask for.
        fn prepare(&self, scratch: &mut Scratch);
    }
}

/// Hands functions of a [`System`] on to a system inside it, where one is put around another.
///
/// # Examples
/// ```
/// use dualbody::{Scalar, Simulator, trajopt::{Robot, Scratch, System}};
///
/// /// A robot that applies twice its input.
/// struct Doubled(Simulator);
/// impl System for Doubled {
///     dualbody::forward_system!(0: nx, ndx, ndq, nu, time_step, robot, integrate, difference, is_vector_space);
///
///     fn step<T: Scalar>(&self, x: &[T], u: &[T], scratch: &mut Scratch, next: &mut [T]) {
///         let u: Vec<T> = u.iter().map(|&u| u * 2.0).collect();
///         System::step(&self.0, x, &u, scratch, next);
///     }
/// }
/// impl Robot for Doubled {}
/// ```
#[macro_export]
macro_rules! forward_system {
    ($own:tt: $($function:ident),+ $(,)?) => {
        $($crate::forward_system!(@ $own $function);)+
    };
    (@ $own:tt time_step) => { $crate::forward_system!(@ $own time_step () -> f64); };
    (@ $own:tt is_vector_space) => { $crate::forward_system!(@ $own is_vector_space () -> bool); };
    (@ $own:tt robot) => { $crate::forward_system!(@ $own robot () -> Option<&$crate::Model>); };
    (@ $own:tt integrate) => { $crate::forward_system!(@ $own integrate <T> (x: &[T], dx: &[T], out: &mut [T]) -> ()); };
    (@ $own:tt difference) => { $crate::forward_system!(@ $own difference <T> (x0: &[T], x1: &[T], dx: &mut [T]) -> ()); };
    (@ $own:tt chart_rate) => { $crate::forward_system!(@ $own chart_rate <T> (xi: &[T], rate: &[T], out: &mut [T]) -> ()); };
    (@ $own:tt step) => { $crate::forward_system!(@ $own step <T> (x: &[T], u: &[T], scratch: &mut $crate::trajopt::Scratch, next: &mut [T]) -> ()); };
    (@ $own:tt rate) => { $crate::forward_system!(@ $own rate <T> (x: &[T], u: &[T], scratch: &mut $crate::trajopt::Scratch, rate: &mut [T]) -> ()); };
    (@ $own:tt linearize) => { $crate::forward_system!(@ $own linearize (x: &[f64], u: &[f64], scratch: &mut $crate::trajopt::Scratch, out: &mut $crate::Linearization) -> ()); };
    (@ $own:tt linearize_rate) => { $crate::forward_system!(@ $own linearize_rate (x: &[f64], u: &[f64], scratch: &mut $crate::trajopt::Scratch, out: &mut $crate::Linearization) -> ()); };
    (@ $own:tt vjp) => { $crate::forward_system!(@ $own vjp (x: &[f64], u: &[f64], lambda: &[f64], scratch: &mut $crate::trajopt::Scratch, dx: &mut [f64], du: &mut [f64]) -> ()); };
    (@ $own:tt prepare) => { $crate::forward_system!(@ $own prepare (scratch: &mut $crate::trajopt::Scratch) -> ()); };
    (@ $own:tt $size:ident) => { $crate::forward_system!(@ $own $size () -> usize); };
    (@ $own:tt $function:ident $(<$T:ident>)? ($($x:ident: $X:ty),*) -> $out:ty) => {
        fn $function $(<$T: $crate::Scalar>)? (&self $(, $x: $X)*) -> $out {
            $crate::trajopt::System::$function(&self.$own $(, $x)*)
        }
    };
}

/// A system by type, or as a trait object such as that of [`Problem::dynamics`](crate::trajopt::Problem::dynamics).
pub trait AsSystem {
    /// The system behind a pointer.
    fn as_system(&self) -> &dyn AnySystem;
}

impl<S: System> AsSystem for S {
    fn as_system(&self) -> &dyn AnySystem {
        self.face()
    }
}

impl AsSystem for dyn AnySystem + '_ {
    fn as_system(&self) -> &dyn AnySystem {
        self
    }
}
