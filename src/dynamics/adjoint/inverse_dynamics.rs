//! Vector-Jacobian product of inverse dynamics.

use nalgebra::DVector;

use super::sweep::{Gradients, Sweep, Weighted};
use crate::model::{Generation, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Motion};

/// Gradient of μᵀ ID(q, v, a) with external forces F on bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct InverseDynamicsGradient<T: Scalar = f64> {
    /// In tangent directions of q, length `nv`.
    pub q: DVector<T>,
    /// In v, length `nv`.
    pub v: DVector<T>,
    /// In a, length `nv`: M(q) μ.
    pub a: DVector<T>,
    /// In the external force on each body, in its body frame, length `n_bodies`: minus the velocity of the body for the joint rates μ.
    pub external: Vec<Motion<T>>,
    /// In all [parameters](Model::parameters) of the model, in their order; empty if not requested. Zero for damping and springs, which are not part
    /// of inverse dynamics.
    pub parameters: DVector<T>,
}

impl<T: Scalar> InverseDynamicsGradient<T> {
    /// Makes memory for a model. To omit the parameters, replace their vector by an empty one.
    pub fn zeros<P: Scalar>(model: &Model<P>) -> Self {
        let zeros = || DVector::zeros(model.nv());
        Self {
            q: zeros(),
            v: zeros(),
            a: zeros(),
            external: vec![Motion::zero(); model.n_bodies()],
            parameters: DVector::zeros(model.parameter_layout().len()),
        }
    }
}

/// Working memory of [`inverse_dynamics_vjp_into`]. It belongs to the model that it was made for and to clones of it.
#[derive(Clone, Debug)]
pub struct InverseDynamicsVjpScratch<T> {
    generation: Generation,
    sweep: Sweep<T>,
}

impl<T: Scalar> InverseDynamicsVjpScratch<T> {
    /// Makes memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        Self {
            generation: model.generation(),
            sweep: Sweep::new(model),
        }
    }
}

/// Computes the gradient of μᵀ ID(q, v, a), the vector-Jacobian product of
/// [`inverse_dynamics`](crate::dynamics::inverse_dynamics), in q (tangent), v, a and all parameters at once, exact to rounding.
///
/// O(n): a small multiple of the cost of inverse dynamics, independent of the number of inputs. Allocates its result and working memory.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
/// * `a` – acceleration in tangent coordinates, length `nv` (rad/s² or m/s²)
/// * `mu` – μ, the weights of the joint forces, length `nv`
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::inverse_dynamics_vjp, model::samples};
///
/// // A hanging rod of 1 kg and 1 m: ∂τ/∂q = m g l / 2, ∂τ/∂a = m l² / 3, here twice as much
/// let model = samples::pendulum();
/// let gradient = inverse_dynamics_vjp(&model, &[0.0], &[0.0], &[3.0], &[2.0]);
/// assert!((gradient.q[0] - 9.81).abs() < 1e-12 && (gradient.a[0] - 2.0 / 3.0).abs() < 1e-12);
/// // τ = J a + m g c sin q grows with the rotational inertia J by the acceleration
/// let moment = model.parameter_layout().find("rod: Jzz")?;
/// assert_eq!(gradient.parameters[moment], 6.0);
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
///
/// # References
/// [Griewank, Walther 2008, chapter 3].
pub fn inverse_dynamics_vjp<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: &[T],
    mu: &[T],
) -> InverseDynamicsGradient<T> {
    let mut out = InverseDynamicsGradient::zeros(model);
    let mut scratch = InverseDynamicsVjpScratch::new(model);
    inverse_dynamics_vjp_into(model, q, v, a, &[], mu, &mut scratch, &mut out);
    out
}

/// [`inverse_dynamics_vjp`] with external forces and without allocation.
///
/// * `external` – force on each body in its body frame, which moves with the body, length `n_bodies`; empty for none
///
/// # Panics
/// If a slice, the scratch or the output has the wrong size.
pub fn inverse_dynamics_vjp_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    a: &[T],
    external: &[Force<T>],
    mu: &[T],
    scratch: &mut InverseDynamicsVjpScratch<T>,
    out: &mut InverseDynamicsGradient<T>,
) {
    model.check_q(q);
    let tangents = [v, a, mu, out.q.as_slice(), out.v.as_slice()];
    tangents.into_iter().for_each(|x| model.check_v(x));
    model.check_v(out.a.as_slice());
    model.check_external(external);
    model.assert_generation(scratch.generation);
    let at = Weighted {
        q,
        v,
        a,
        mu,
        external,
    };
    let sweep = &mut scratch.sweep;
    sweep.check_outputs(model, &out.external, &out.parameters);
    for x in [&mut out.q, &mut out.v, &mut out.a, &mut out.parameters] {
        x.fill(T::zero());
    }
    let mut slopes = Gradients {
        q: out.q.as_mut_slice(),
        v: out.v.as_mut_slice(),
        a: out.a.as_mut_slice(),
        parameters: out.parameters.as_mut_slice(),
    };
    sweep.add(model, &at, &mut slopes);
    for (out, body) in out.external.iter_mut().zip(&sweep.bodies) {
        *out = -body.W;
    }
}

impl<T: Scalar> Sweep<T> {
    /// Checks the sizes of what is written.
    pub(super) fn check_outputs<P: Scalar>(
        &self,
        model: &Model<P>,
        external: &[Motion<T>],
        parameters: &DVector<T>,
    ) {
        let (n, len) = (external.len(), parameters.len());
        assert_eq!(
            n,
            model.n_bodies(),
            "a gradient in the external forces on \"{}\" has {} motions",
            model.name(),
            model.n_bodies()
        );
        assert!(
            len == 0 || len == self.slots.len,
            "\"{}\" has {} parameters, got memory for the gradient in {len}",
            model.name(),
            self.slots.len
        );
    }
}
