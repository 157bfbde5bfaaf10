//! A system behind a pointer, on the scalars that solvers use: so that solvers are compiled once, whatever the system.

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

behind_a_pointer! {
    /// A system of whatever type, as solvers know it: on plain numbers with its derivatives, and its manifold on dual numbers too, for first derivatives of
    /// what stands on it, and on hyper-dual ones for second ones. A system that gives derivatives of its own is not compiled on dual numbers here.
    pub trait AnySystem: [Manifold<f64> + Manifold<Dual<f64, CHUNK>> + Manifold<HyperDual64>] of System {
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

/// A system as such, or behind a pointer as [`Problem::dynamics`](crate::trajopt::Problem::dynamics) gives it.
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
