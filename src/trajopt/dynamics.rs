//! Systems in discrete time: the step x⁺ = f(x, u), and ⊕ and ⊖ on the states.

use nalgebra::DMatrix;

use crate::autodiff::{CHUNK, Dual, JacobianScratch, jacobian_into};
use crate::linearize::Linearization;
use crate::scalar::{Scalar, add_into, lift_into};

/// A system in discrete time, x⁺ = f(x, u), whose state may live on a manifold.
///
/// A state is `nx` numbers, a small change of it `ndx`; where they are the same vectors, the defaults say all. A
/// [`Simulator`](crate::Simulator) is one with x = (q, v).
///
/// # Examples
/// ```
/// use dualbody::{Scalar, trajopt::Dynamics};
///
/// /// A mass of 1 kg pushed along a line, steps of 0.1 s.
/// struct Mass;
/// impl Dynamics for Mass {
///     fn nx(&self) -> usize {
///         2
///     }
///     fn nu(&self) -> usize {
///         1
///     }
///     fn step<T: Scalar>(&self, x: &[T], u: &[T], next: &mut [T]) {
///         next[1] = x[1] + u[0] * 0.1;
///         next[0] = x[0] + next[1] * 0.1;
///     }
/// }
/// let mut next = [0.0; 2];
/// Mass.step(&[1.0, 0.0], &[10.0], &mut next);
/// assert_eq!(next, [1.1, 1.0]);
/// ```
pub trait Dynamics: Sized + Send + Sync {
    /// Numbers in a state.
    fn nx(&self) -> usize;

    /// Dimension of the tangent space of the states.
    fn ndx(&self) -> usize {
        self.nx()
    }

    /// Dimension of the tangent space of the configuration, whose directions come first, for costs of it alone: half of
    /// [`ndx`](Self::ndx) unless a system says otherwise.
    fn ndq(&self) -> usize {
        self.ndx() / 2
    }

    /// Number of inputs.
    fn nu(&self) -> usize;

    /// Time from one state to the next, s: the factor of running costs. One by default.
    fn time_step(&self) -> f64 {
        1.0
    }

    /// Computes x⁺ = f(x, u). May allocate; what is called often goes through [`stepper`](Self::stepper).
    ///
    /// * `x`, `next` – states, length `nx`
    /// * `u` – input, length `nu`
    fn step<T: Scalar>(&self, x: &[T], u: &[T], next: &mut [T]);

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

    /// Working memory for steps and their Jacobians: by dual numbers through [`step`](Self::step) unless a system knows better.
    fn stepper(&self) -> Box<dyn Stepper<Self>> {
        Box::new(DualStepper::new(self))
    }
}

/// Steps of a system with memory of their own, one for each thread.
pub trait Stepper<D>: Send {
    /// x⁺ = f(x, u).
    fn step(&mut self, dynamics: &D, x: &[f64], u: &[f64], next: &mut [f64]);

    /// δx⁺ = A δx + B δu at (x, u), in the tangent spaces of x and x⁺.
    ///
    /// * `out` – output, A `ndx` × `ndx` and B `ndx` × `nu`
    fn linearize(&mut self, dynamics: &D, x: &[f64], u: &[f64], out: &mut Linearization);
}

/// The Jacobians of a step for any dynamics: memory of the right size.
pub(crate) fn zero_linearization<D: Dynamics>(dynamics: &D) -> Linearization {
    let (ndx, nu) = (dynamics.ndx(), dynamics.nu());
    Linearization {
        a: DMatrix::zeros(ndx, ndx),
        b: DMatrix::zeros(ndx, nu),
    }
}

/// Jacobians by the whole step on dual numbers.
struct DualStepper {
    zeros: Vec<f64>,
    next: Vec<f64>,
    /// x, its image x ⊕ δx, and x⁺, on dual numbers.
    lifted: [Vec<Dual<f64, CHUNK>>; 4],
    u: Vec<Dual<f64, CHUNK>>,
    jacobian: JacobianScratch<CHUNK>,
    /// (A, B) side by side.
    out: DMatrix<f64>,
}

impl DualStepper {
    fn new<D: Dynamics>(dynamics: &D) -> Self {
        let (nx, ndx, nu) = (dynamics.nx(), dynamics.ndx(), dynamics.nu());
        Self {
            zeros: vec![0.0; ndx + nu],
            next: vec![0.0; nx],
            lifted: std::array::from_fn(|_| vec![Dual::from(0.0); nx]),
            u: vec![Dual::from(0.0); nu],
            jacobian: JacobianScratch::new(ndx + nu, ndx),
            out: DMatrix::zeros(ndx, ndx + nu),
        }
    }
}

impl<D: Dynamics> Stepper<D> for DualStepper {
    fn step(&mut self, dynamics: &D, x: &[f64], u: &[f64], next: &mut [f64]) {
        dynamics.step(x, u, next);
    }

    fn linearize(&mut self, dynamics: &D, x: &[f64], u: &[f64], out: &mut Linearization) {
        dynamics.step(x, u, &mut self.next);
        let [start, moved, base, next] = &mut self.lifted;
        lift_into(x, start);
        lift_into(&self.next, base);
        let (ndx, u_moved) = (dynamics.ndx(), &mut self.u);
        // (δx, δu) ↦ f(x ⊕ δx, u + δu) ⊖ f(x, u)
        let step = |dz: &[Dual<f64, CHUNK>], dy: &mut [Dual<f64, CHUNK>]| {
            let (dx, du) = dz.split_at(ndx);
            dynamics.integrate(start, dx, moved);
            add_into(u, du, u_moved);
            dynamics.step(moved, u_moved, next);
            dynamics.difference(base, next, dy);
        };
        jacobian_into(&self.zeros, step, &mut self.jacobian, &mut self.out);
        out.a.copy_from(&self.out.columns(0, ndx));
        out.b.copy_from(&self.out.columns(ndx, u.len()));
    }
}
