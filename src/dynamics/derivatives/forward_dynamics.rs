//! Derivatives of forward dynamics by the implicit function theorem.
//!
//! The acceleration solves  ID(q, v, a) = τ. So  M δa = δτ − ∂ID/∂q δq − ∂ID/∂v δv: the derivatives of inverse dynamics and one
//! factorisation of M, which is among them, replace a sweep through forward dynamics for each direction.
//!
//! # References
//! [Carpentier, Mansard 2018].

use nalgebra::DMatrix;

use super::blocks::Blocks;
use super::inverse_dynamics::{At, InverseDynamicsDerivativesScratch, add_derivatives};
use crate::dynamics::calls::Calls;
use crate::dynamics::forward_dynamics::{AbaScratch, forward_dynamics_into};
use crate::dynamics::mass_matrix_factor::MassMatrixFactor;
use crate::model::Model;
use crate::nested::IntoNested;
use crate::scalar::{Differentiable, Opaque, Over, Scalar, compiled_over_f64};
use crate::spatial::Force;

/// Derivatives of what the acceleration balances, then of −a, in q, v and further directions side by side.
#[derive(Clone, Debug)]
pub(crate) struct AccelerationDerivatives<T: Differentiable = f64> {
    inverse: InverseDynamicsDerivativesScratch<T>,
    pub(crate) columns: Blocks<T>,
    mass: DMatrix<T>,
    factor: MassMatrixFactor<T>,
}

impl<T: Differentiable> AccelerationDerivatives<T> {
    /// Memory for a model and a number of further directions.
    pub(crate) fn new<P: Scalar>(model: &Model<P>, further: usize, calls: Calls) -> Self {
        let nv = model.nv();
        Self {
            inverse: InverseDynamicsDerivativesScratch::for_calls(model, calls),
            columns: Blocks::new(nv, 2 * nv + further),
            mass: DMatrix::zeros(nv, nv),
            factor: MassMatrixFactor::new(model, &DMatrix::identity(nv, nv)),
        }
    }

    /// Turns the columns of −∂τ/∂x into those of what the acceleration `a` balances, −∂τ/∂x + ∂ID/∂x, and finds M.
    pub(crate) fn balance<P: Scalar>(
        &mut self,
        model: &Model<P>,
        at: &At<'_, T>,
        external: &[Force<T>],
    ) where
        T: Over<P>,
    {
        let (mut columns, mass) = (self.columns.view(), &mut self.mass);
        add_derivatives(model, at, external, &mut self.inverse, &mut columns, mass);
    }

    /// Turns them into −∂a/∂x, with what coordinates resist with beside M; none if empty.
    pub(crate) fn solve(&mut self, resistance: impl IntoIterator<Item = T>) {
        for (k, resistance) in resistance.into_iter().enumerate() {
            self.mass[(k, k)] += resistance;
        }
        self.factor.refactor(&self.mass);
        self.columns.solve(&self.factor);
    }
}

/// Derivatives of v̇ = FD(q, v, τ).
#[derive(Clone, Debug, PartialEq)]
pub struct ForwardDynamicsDerivatives<T: Scalar = f64> {
    /// ∂v̇/∂q in tangent directions of q, `nv` × `nv`.
    pub dq: DMatrix<T>,
    /// ∂v̇/∂v, `nv` × `nv`.
    pub dv: DMatrix<T>,
    /// ∂v̇/∂τ = M(q)⁻¹, `nv` × `nv`.
    pub dtau: DMatrix<T>,
}

impl<T: Scalar> ForwardDynamicsDerivatives<T> {
    /// Makes memory for a model.
    pub fn zeros<P: Scalar>(model: &Model<P>) -> Self {
        let zeros = DMatrix::zeros(model.nv(), model.nv());
        Self {
            dq: zeros.clone(),
            dv: zeros.clone(),
            dtau: zeros,
        }
    }
}

/// Working memory of [`forward_dynamics_derivatives_into`].
#[derive(Clone, Debug)]
pub struct ForwardDynamicsDerivativesScratch<T: Differentiable = f64>(Opaque<Memory<T>>);

#[derive(Clone)]
struct Memory<T: Differentiable> {
    aba: AbaScratch<T>,
    a: Vec<T>,
    derivatives: AccelerationDerivatives<T>,
}

impl<T: Differentiable> Memory<T> {
    fn new<P: Scalar>(model: &Model<P>, calls: Calls) -> Opaque<Self> {
        Opaque::new(Self {
            aba: AbaScratch::for_calls(model, calls),
            a: vec![T::zero(); model.nv()],
            derivatives: AccelerationDerivatives::new(model, model.nv(), calls),
        })
    }
}

impl<T: Differentiable> ForwardDynamicsDerivativesScratch<T> {
    /// Makes memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        Self::for_calls(model, Calls::Many)
    }

    fn for_calls<P: Scalar>(model: &Model<P>, calls: Calls) -> Self {
        Self(compiled_over_f64!(
            [P, T] Memory::new, model: &Model, calls: Calls => Opaque<Memory<f64>> as Opaque<Memory<T>>
        ))
    }
}

/// Computes the derivatives of [`forward_dynamics`](crate::dynamics::forward_dynamics) in q (tangent), v and τ, exact to rounding. Allocates.
///
/// By the implicit function theorem, at v̇ = FD(q, v, τ):  ∂FD = −M⁻¹ ∂ID,  ∂FD/∂τ = M⁻¹.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
/// * `tau` – joint forces, length `nv` (N·m or N)
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::forward_dynamics_derivatives, model::samples};
///
/// // v̇ = 3 τ / (m l²) − (3 g / 2 l) sin q with 1 kg and 1 m
/// let d = forward_dynamics_derivatives(&samples::pendulum(), &[0.0], &[0.0], &[0.0]);
/// assert!((d.dq[(0, 0)] + 1.5 * 9.81).abs() < 1e-12);
/// assert!((d.dtau[(0, 0)] - 3.0).abs() < 1e-14);
/// ```
///
/// # References
/// [Carpentier, Mansard 2018].
pub fn forward_dynamics_derivatives<P: Scalar, T: Over<P> + Differentiable>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &[T],
) -> ForwardDynamicsDerivatives<T> {
    let mut out = ForwardDynamicsDerivatives::zeros(model);
    let mut scratch = ForwardDynamicsDerivativesScratch::for_calls(model, Calls::One);
    forward_dynamics_derivatives_into(model, q, v, tau, &[], &mut scratch, &mut out);
    out
}

/// [`forward_dynamics_derivatives`] with external forces and without allocation.
///
/// * `external` – force on each body in its body frame, which moves with the body, length `n_bodies`; empty for none
///
/// # Panics
/// If a slice, the scratch or the output has the wrong size.
pub fn forward_dynamics_derivatives_into<P: Scalar, T: Over<P> + Differentiable>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &[T],
    external: &[Force<T>],
    scratch: &mut ForwardDynamicsDerivativesScratch<T>,
    out: &mut ForwardDynamicsDerivatives<T>,
) {
    let memory = &mut scratch.0;
    compiled_over_f64!(
        [P, T] derivatives_with, model: &Model, q: &[f64], v: &[f64], tau: &[f64], external: &[Force<f64>],
        memory: &mut Opaque<Memory<f64>>, out: &mut ForwardDynamicsDerivatives
    );
}

fn derivatives_with<P: Scalar, T: Over<P> + Differentiable>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &[T],
    external: &[Force<T>],
    memory: &mut Opaque<Memory<T>>,
    out: &mut ForwardDynamicsDerivatives<T>,
) {
    let Memory {
        aba,
        a,
        derivatives: s,
    } = memory.get_mut();
    let nv = model.nv();
    forward_dynamics_into(model, q, v, tau, external, aba, a);
    s.columns.clear();
    for k in 0..nv {
        *s.columns.at(k, 2 * nv + k) = -T::one();
    }
    s.balance(model, &At { q, v, a }, external);
    s.solve([]);
    let outputs = [&mut out.dq, &mut out.dv, &mut out.dtau].into_iter();
    let outputs = outputs.nested(|m| {
        assert_eq!(m.shape(), (nv, nv), "the derivatives are nv × nv");
        m.as_mut_slice().chunks_exact_mut(nv.max(1))
    });
    s.columns.copy_columns_to(outputs, |minus_a| -minus_a);
}
