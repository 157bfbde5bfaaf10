//! Systems: the step x⁺ = f(x, u), the rate ẋ that it approximates, and ⊕ and ⊖ on the states.

mod any;
pub(super) mod tangent;

use std::any::type_name;

use super::scratch::Scratch;
use crate::linearize::Linearization;
#[cfg(not(feature = "second-order"))]
use crate::minimize::Status;
use crate::model::Model;
use crate::scalar::Scalar;

pub(super) use any::behind_a_pointer;
pub use any::{AnySystem, AsSystem, Manifold, Sizes};
pub(super) use tangent::zero_linearization;

/// A system x⁺ = f(x, u) whose state may be on a manifold; with [`rate`](Self::rate) also in continuous time.
///
/// A state has `nx` coordinates, a small change `ndx`; for a vector space the defaults suffice. Derivatives use dual numbers; a system with faster
/// ones overrides [`linearize`](Self::linearize). A [`Simulator`](crate::Simulator) is one with x = (q, v).
///
/// # Examples
/// ```
/// use dualbody::{Scalar, trajopt::{Scratch, System}};
///
/// /// A mass of 1 kg pushed along a line, steps of 0.1 s.
/// struct Mass;
/// impl System for Mass {
///     fn nx(&self) -> usize {
///         2
///     }
///     fn nu(&self) -> usize {
///         1
///     }
///     fn step<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, next: &mut [T]) {
///         next[1] = x[1] + u[0] * 0.1;
///         next[0] = x[0] + next[1] * 0.1;
///     }
/// }
/// let mut next = [0.0; 2];
/// Mass.step(&[1.0, 0.0], &[10.0], &mut Scratch::new(), &mut next);
/// assert_eq!(next, [1.1, 1.0]);
/// ```
pub trait System: Sized + Send + Sync + 'static {
    /// Numbers in a state.
    fn nx(&self) -> usize;

    /// Dimension of the tangent space of the states.
    fn ndx(&self) -> usize {
        self.nx()
    }

    /// Dimension of the tangent space of the configuration, whose directions come first, for costs of it alone: half of [`ndx`](Self::ndx) by default.
    fn ndq(&self) -> usize {
        self.ndx() / 2
    }

    /// Number of inputs.
    fn nu(&self) -> usize;

    /// Time from one state to the next, s: the factor of running costs. One by default.
    fn time_step(&self) -> f64 {
        1.0
    }

    /// The robot whose state is the first part of x, as (q, v); residuals of robots need it. `None` by default; implemented by a [`Robot`](super::Robot).
    fn robot(&self) -> Option<&Model> {
        None
    }

    /// Computes x⁺ = f(x, u).
    ///
    /// * `x`, `next` – states, length `nx`
    /// * `u` – input, length `nu`
    /// * `scratch` – working memory that is reused between calls
    fn step<T: Scalar>(&self, x: &[T], u: &[T], scratch: &mut Scratch, next: &mut [T]);

    /// x ⊕ δx. Must not allocate. The sum by default.
    ///
    /// * `x`, `out` – states, length `nx`
    /// * `dx` – tangent, length `ndx`
    fn integrate<T: Scalar>(&self, x: &[T], dx: &[T], out: &mut [T]) {
        for (out, (&x, &dx)) in out.iter_mut().zip(x.iter().zip(dx)) {
            *out = x + dx;
        }
    }

    /// `x1` ⊖ `x0`, the δx with `x0` ⊕ δx = `x1`. Must not allocate. The difference by default.
    ///
    /// * `dx` – output, length `ndx`
    fn difference<T: Scalar>(&self, x0: &[T], x1: &[T], dx: &mut [T]) {
        for (dx, (&x0, &x1)) in dx.iter_mut().zip(x0.iter().zip(x1)) {
            *dx = x1 - x0;
        }
    }

    /// Whether ⊕ is the plain sum, which makes some derivatives trivial. Saying `false`, the default, is never wrong.
    fn is_vector_space(&self) -> bool {
        false
    }

    /// Computes ẋ = f(x, u), of which [`step`](Self::step) is some integrator's approximation: for solvers in
    /// continuous time (`Transcription`); the others do without.
    ///
    /// On a manifold ẋ is in the tangent space at x: a body's velocity in its own frame, not the rate of its
    /// quaternion. A [`Simulator`](crate::Simulator) has ẋ = (v, v̇): the acceleration that its steps integrate.
    ///
    /// * `x` – state, length `nx`
    /// * `u` – input, length `nu`
    /// * `rate` – output, tangent at x, length `ndx`
    ///
    /// # Panics
    /// Unless a system overrides it.
    fn rate<T: Scalar>(&self, x: &[T], u: &[T], scratch: &mut Scratch, rate: &mut [T]) {
        let _ = (x, u, scratch, rate);
        let name = type_name::<Self>();
        panic!("{name} has steps, but no rate: continuous time needs `System::rate`");
    }

    /// The rate of the coordinates ξ of  x = start ⊕ ξ,  the start fixed, when x moves at `rate`. The rate itself by
    /// default, which is right where ⊕ is the plain sum. Must not allocate.
    ///
    /// * `xi` – ξ, length `ndx`
    /// * `rate`, `out` – length `ndx`
    fn chart_rate<T: Scalar>(&self, _xi: &[T], rate: &[T], out: &mut [T]) {
        out.copy_from_slice(rate);
    }

    /// Computes the step Jacobians: δx⁺ = A δx + B δu at (x, u), in the tangent spaces of x and x⁺. The default uses dual numbers through [`step`](Self::step).
    ///
    /// * `out` – output, A `ndx` × `ndx` and B `ndx` × `nu`
    fn linearize(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization) {
        tangent::linearize_step(self, x, u, scratch, out);
    }

    /// Computes Aᵀ λ and Bᵀ λ of the step at (x, u): the gradient of λᵀ x⁺. By default from [`linearize`](Self::linearize); a system that knows it
    /// without A and B says so here.
    ///
    /// * `lambda` – λ, weights of the tangent of x⁺, length `ndx`
    /// * `dx` – output Aᵀ λ, length `ndx`
    /// * `du` – output Bᵀ λ, length `nu`
    fn vjp(
        &self,
        x: &[f64],
        u: &[f64],
        lambda: &[f64],
        scratch: &mut Scratch,
        dx: &mut [f64],
        du: &mut [f64],
    ) {
        tangent::vjp(self, x, u, lambda, scratch, dx, du);
    }

    /// Whether [`add_step_hessian`](Self::add_step_hessian) is there: with the feature `second-order`, without which solvers take no
    /// second derivatives.
    fn has_step_hessian(&self) -> bool {
        cfg!(feature = "second-order")
    }

    /// Adds the Hessian of  λᵀ (f(x ⊕ δx, u + δu) ⊖ f(x, u))  in (δx, δu) to the upper triangle of `hessian`, n × n by columns with n = `ndx` + `nu`:
    /// what second-order methods take beside A and B. By hyper-dual numbers through [`step`](Self::step), each pair of numbers by itself, unless a
    /// system knows better. Allocates.
    ///
    /// * `lambda` – λ, weights of the tangent of x⁺, length `ndx`
    ///
    /// # Panics
    /// Without the feature `second-order`, unless a system overrides it. Solvers ask [`has_step_hessian`](Self::has_step_hessian) first.
    fn add_step_hessian(&self, x: &[f64], u: &[f64], lambda: &[f64], hessian: &mut [f64]) {
        #[cfg(feature = "second-order")]
        tangent::add_step_hessian(self, x, u, lambda, hessian);
        #[cfg(not(feature = "second-order"))]
        {
            let _ = (x, u, lambda, hessian);
            panic!("{}: {}", type_name::<Self>(), Status::NoStepHessian);
        }
    }

    /// Computes the Jacobians of the rate: δẋ = A δx + B δu at (x, u), in the tangent space of x. By dual numbers
    /// through [`rate`](Self::rate) unless a system knows better.
    ///
    /// * `out` – output, A `ndx` × `ndx` and B `ndx` × `nu`
    fn linearize_rate(&self, x: &[f64], u: &[f64], scratch: &mut Scratch, out: &mut Linearization) {
        tangent::linearize_rate(self, x, u, scratch, out);
    }

    /// Makes the memory that steps and their Jacobians on `f64` will ask for, so that not even the first ones allocate:
    /// what a solver calls before it starts.
    fn prepare(&self, scratch: &mut Scratch) {
        tangent::prepare(self, scratch);
    }

    /// The system behind a pointer, which is all that solvers know of it. A system of this library has its functions
    /// compiled here.
    #[doc(hidden)]
    fn face(&self) -> &dyn AnySystem {
        self
    }

    /// [`face`](Self::face) of a system that is given away.
    #[doc(hidden)]
    fn boxed(self) -> Box<dyn AnySystem> {
        Box::new(self)
    }
}
