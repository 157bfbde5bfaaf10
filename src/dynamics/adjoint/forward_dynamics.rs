//! Vector-Jacobian product of forward dynamics, by the implicit function theorem.
//!
//! The acceleration solves  ID(q, v, a) = τ. So the gradient of λᵀ a is that of μᵀ ID(q, v, a) at fixed a with μ = −M⁻¹ λ, and −μ in τ: one
//! solution with M and one sweep.

use nalgebra::{DMatrix, DVector};

use super::sweep::{Gradients, Sweep, Weighted};
use crate::dynamics::calls::Calls;
use crate::dynamics::coupled::factorize;
use crate::dynamics::crba::CrbaScratch;
use crate::dynamics::forward_dynamics::{AbaScratch, forward_dynamics_into};
use crate::dynamics::mass_matrix_factor::MassMatrixFactor;
use crate::model::{Generation, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Motion};

/// Gradient of λᵀ FD(q, v, τ) with external forces F on bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct ForwardDynamicsGradient<T: Scalar = f64> {
    /// In tangent directions of q, length `nv`.
    pub q: DVector<T>,
    /// In v, length `nv`.
    pub v: DVector<T>,
    /// In τ, length `nv`: M(q)⁻¹ λ.
    pub tau: DVector<T>,
    /// In the external force on each body, in its body frame, length `n_bodies`: the velocity of the body for the joint rates M⁻¹ λ.
    pub external: Vec<Motion<T>>,
    /// In all [parameters](Model::parameters) of the model, in their order; empty if not requested. Zero for damping and springs, whose forces are a part of τ.
    pub parameters: DVector<T>,
}

impl<T: Scalar> ForwardDynamicsGradient<T> {
    /// Makes memory for a model. To omit the parameters, replace their vector by an empty one.
    pub fn zeros<P: Scalar>(model: &Model<P>) -> Self {
        let zeros = || DVector::zeros(model.nv());
        Self {
            q: zeros(),
            v: zeros(),
            tau: zeros(),
            external: vec![Motion::zero(); model.n_bodies()],
            parameters: DVector::zeros(model.parameter_layout().len()),
        }
    }
}

/// Working memory of [`forward_dynamics_vjp_into`]. It belongs to the model that it was made for and to clones of it.
#[derive(Clone, Debug)]
pub struct ForwardDynamicsVjpScratch<T> {
    generation: Generation,
    aba: AbaScratch<T>,
    crba: CrbaScratch<T>,
    factor: MassMatrixFactor<T>,
    sweep: Sweep<T>,
    a: Vec<T>,
    /// −M⁻¹ λ.
    mu: Vec<T>,
    /// M μ, which is −λ.
    by_a: Vec<T>,
}

impl<T: Scalar> ForwardDynamicsVjpScratch<T> {
    /// Makes memory for a model.
    ///
    /// # Panics
    /// If its mass matrix is singular, with the message of [`Model::check_mass_matrix`].
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        Self::for_calls(model, Calls::Many)
    }

    fn for_calls<P: Scalar>(model: &Model<P>, calls: Calls) -> Self {
        let nv = model.nv();
        Self {
            generation: model.generation(),
            aba: AbaScratch::for_calls(model, calls),
            crba: CrbaScratch::new(model),
            factor: MassMatrixFactor::new(model, &DMatrix::identity(nv, nv)),
            sweep: Sweep::new(model),
            a: vec![T::zero(); nv],
            mu: vec![T::zero(); nv],
            by_a: vec![T::zero(); nv],
        }
    }
}

/// Computes the gradient of λᵀ FD(q, v, τ), the vector-Jacobian product of
/// [`forward_dynamics`](crate::dynamics::forward_dynamics), in q (tangent), v, τ and all parameters at once, exact to rounding.
///
/// Costs a small multiple of forward dynamics, independent of the number of inputs. Allocates its result and working memory.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
/// * `tau` – joint forces, length `nv` (N·m or N)
/// * `lambda` – λ, the weights of the accelerations, length `nv`
///
/// # Panics
/// If a slice has the wrong length, or the mass matrix is singular: [`Model::check_mass_matrix`] checks this beforehand.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::forward_dynamics_vjp, model::samples};
///
/// // v̇ = 3 τ / (m l²) − (3 g / 2 l) sin q with 1 kg and 1 m
/// let gradient = forward_dynamics_vjp(&samples::pendulum(), &[0.0], &[0.0], &[0.0], &[1.0]);
/// assert!((gradient.q[0] + 1.5 * 9.81).abs() < 1e-12 && (gradient.tau[0] - 3.0).abs() < 1e-14);
/// ```
///
/// # References
/// [Griewank, Walther 2008, chapter 3]; [Carpentier, Mansard 2018] for the implicit function theorem.
pub fn forward_dynamics_vjp<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &[T],
    lambda: &[T],
) -> ForwardDynamicsGradient<T> {
    let mut out = ForwardDynamicsGradient::zeros(model);
    let mut scratch = ForwardDynamicsVjpScratch::for_calls(model, Calls::One);
    forward_dynamics_vjp_into(model, q, v, tau, &[], lambda, &mut scratch, &mut out);
    out
}

/// [`forward_dynamics_vjp`] with external forces and without allocation.
///
/// * `external` – force on each body in its body frame, which moves with the body, length `n_bodies`; empty for none
///
/// # Panics
/// If a slice, the scratch or the output has the wrong size.
pub fn forward_dynamics_vjp_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &[T],
    external: &[Force<T>],
    lambda: &[T],
    scratch: &mut ForwardDynamicsVjpScratch<T>,
    out: &mut ForwardDynamicsGradient<T>,
) {
    model.check_v(lambda);
    model.assert_generation(scratch.generation);
    let outputs = [&out.q, &out.v, &out.tau];
    outputs
        .into_iter()
        .for_each(|x| model.check_v(x.as_slice()));
    let s = scratch;
    s.sweep.check_outputs(model, &out.external, &out.parameters);
    forward_dynamics_into(model, q, v, tau, external, &mut s.aba, &mut s.a);
    factorize(model, q, &[], &mut s.crba, &mut s.factor);
    for (mu, &lambda) in s.mu.iter_mut().zip(lambda) {
        *mu = -lambda;
    }
    s.factor.solve(&mut s.mu);
    for x in [&mut out.q, &mut out.v, &mut out.parameters] {
        x.fill(T::zero());
    }
    let at = Weighted {
        q,
        v,
        a: &s.a,
        mu: &s.mu,
        external,
    };
    let mut slopes = Gradients {
        q: out.q.as_mut_slice(),
        v: out.v.as_mut_slice(),
        a: &mut s.by_a,
        parameters: out.parameters.as_mut_slice(),
    };
    s.sweep.add(model, &at, &mut slopes);
    for (tau, &mu) in out.tau.iter_mut().zip(&s.mu) {
        *tau = -mu;
    }
    for (out, body) in out.external.iter_mut().zip(&s.sweep.bodies) {
        *out = -body.W;
    }
}
