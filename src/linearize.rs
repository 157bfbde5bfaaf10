//! Exact Jacobians of the simulation step, in tangent coordinates.
//!
//! With x = (q, v) and the step x⁺ = f(x, u), small changes obey  δx⁺ = A δx + B δu  where δx = (δq, δv) ∈ ℝ²ⁿᵛ and q moves as
//! q ⊕ δq. The step itself is run on dual numbers, so A and B belong to the very step that is simulated.

mod batch;

use nalgebra::{DMatrix, DVector};
use num_dual::DualSVec64;

use crate::autodiff::{CHUNK, JacobianScratch, VectorFunction, finite_difference, jacobian_into};
use crate::scalar::Scalar;
use crate::sim::{Simulator, State, StepScratch};

/// The Jacobians of one step: δx⁺ = A δx + B δu.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearization {
    /// A, 2 `nv` × 2 `nv`; rows and columns (δq, δv).
    pub a: DMatrix<f64>,
    /// B, 2 `nv` × `nu`.
    pub b: DMatrix<f64>,
}

impl Linearization {
    /// Memory for the Jacobians of a simulator.
    pub fn zeros(simulator: &Simulator) -> Self {
        let n = 2 * simulator.model().nv();
        Self {
            a: DMatrix::zeros(n, n),
            b: DMatrix::zeros(n, simulator.nu()),
        }
    }
}

/// Working memory of [`Simulator::linearize_into`].
#[derive(Clone, Debug)]
pub struct LinearizeScratch {
    tangent: TangentScratch<DualSVec64<CHUNK>>,
    jacobian: JacobianScratch<CHUNK>,
    /// The step at the point of linearisation.
    step: StepScratch<f64>,
    next: State,
    zeros: Vec<f64>,
    /// (A, B) side by side.
    out: DMatrix<f64>,
}

impl LinearizeScratch {
    /// Memory for a simulator.
    pub fn new(simulator: &Simulator) -> Self {
        let n = 2 * simulator.model().nv();
        let inputs = n + simulator.nu();
        Self {
            tangent: TangentScratch::new(simulator),
            jacobian: JacobianScratch::new(inputs, n),
            step: StepScratch::new(simulator.model()),
            next: State::neutral(simulator.model()),
            zeros: vec![0.0; inputs],
            out: DMatrix::zeros(n, inputs),
        }
    }
}

impl Simulator<f64> {
    /// Computes the Jacobians A and B of the step from `state` with input `u`. Allocates.
    ///
    /// Works for every joint kind, base and integrator; exact to rounding.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples};
    ///
    /// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
    /// let step = simulator.linearize(&State::new(&[0.0], &[0.0]), &[0.0]);
    /// // v⁺ = v + Δt (u − ½ g sin q) / J with J = 1/3 kg·m²
    /// assert!((step.b[(1, 0)] - 0.03).abs() < 1e-15);
    /// assert!((step.a[(1, 0)] + 0.01 * 1.5 * 9.81).abs() < 1e-15);
    /// ```
    ///
    /// # Panics
    /// If state or input have the wrong length.
    pub fn linearize(&self, state: &State, u: &[f64]) -> Linearization {
        let mut out = Linearization::zeros(self);
        self.linearize_into(state, u, &mut LinearizeScratch::new(self), &mut out);
        out
    }

    /// [`linearize`](Self::linearize) without allocation.
    ///
    /// # Panics
    /// If state, input, scratch or output have the wrong size.
    pub fn linearize_into(
        &self,
        state: &State,
        u: &[f64],
        scratch: &mut LinearizeScratch,
        out: &mut Linearization,
    ) {
        let s = scratch;
        self.step_into(state, u, &mut s.step, &mut s.next);
        let (tangent, next) = (&mut s.tangent, &s.next);
        let step =
            |dx: &[_], dy: &mut [_]| tangent_step(self, &Point { state, u, next }, dx, tangent, dy);
        jacobian_into(&s.zeros, step, &mut s.jacobian, &mut s.out);
        let n = out.a.nrows();
        out.a.copy_from(&s.out.columns(0, n));
        out.b.copy_from(&s.out.columns(n, u.len()));
    }

    /// The Jacobians by finite differences of the step, to check against.
    ///
    /// # Panics
    /// If state or input have the wrong length.
    pub fn linearize_by_finite_differences(&self, state: &State, u: &[f64]) -> Linearization {
        let next = self.step(state, u);
        let step = TangentStep {
            simulator: self,
            point: Point {
                state,
                u,
                next: &next,
            },
        };
        let n = 2 * self.model().nv();
        let both = finite_difference::jacobian(&step, &vec![0.0; n + u.len()]);
        Linearization {
            a: both.columns(0, n).into(),
            b: both.columns(n, u.len()).into(),
        }
    }
}

/// Where the step is linearised, with its result there.
struct Point<'a> {
    state: &'a State,
    u: &'a [f64],
    next: &'a State,
}

/// The step as a function (δq, δv, δu) ↦ (δq⁺, δv⁺) that maps zero to zero.
struct TangentStep<'a> {
    simulator: &'a Simulator,
    point: Point<'a>,
}

impl VectorFunction for TangentStep<'_> {
    fn n_outputs(&self) -> usize {
        2 * self.simulator.model().nv()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        tangent_step(
            self.simulator,
            &self.point,
            x,
            &mut TangentScratch::new(self.simulator),
            y,
        );
    }
}

/// Working memory of [`tangent_step`].
#[derive(Clone, Debug)]
struct TangentScratch<T: Scalar> {
    step: StepScratch<T>,
    state: State<T>,
    next: State<T>,
    /// The configurations at the point of linearisation, without derivatives.
    start_q: DVector<T>,
    next_q: DVector<T>,
    u: Vec<T>,
}

impl<T: Scalar> TangentScratch<T> {
    fn new(simulator: &Simulator) -> Self {
        let model = simulator.model();
        let state = State::neutral(model);
        Self {
            step: StepScratch::new(model),
            next: state.clone(),
            start_q: state.q.clone(),
            next_q: state.q.clone(),
            u: vec![T::zero(); simulator.nu()],
            state,
        }
    }
}

fn tangent_step<T: Scalar>(
    simulator: &Simulator,
    point: &Point<'_>,
    dx: &[T],
    s: &mut TangentScratch<T>,
    dy: &mut [T],
) {
    let (model, nv) = (simulator.model(), simulator.model().nv());
    let (dq, rest) = dx.split_at(nv);
    let (dv, du) = rest.split_at(nv);
    // x = (q ⊕ δq, v + δv),  u + δu
    lift_into(&point.state.q, &mut s.start_q);
    lift_into(&point.next.q, &mut s.next_q);
    model.integrate_into(s.start_q.as_slice(), dq, s.state.q.as_mut_slice());
    add_into(dv, point.state.v.as_slice(), s.state.v.as_mut_slice());
    add_into(du, point.u, &mut s.u);
    simulator.step_into(&s.state, &s.u, &mut s.step, &mut s.next);
    // δq⁺ = q⁺ ⊖ q⁺(0),  δv⁺ = v⁺ − v⁺(0)
    let (dq_next, dv_next) = dy.split_at_mut(nv);
    model.difference_into(s.next_q.as_slice(), s.next.q.as_slice(), dq_next);
    for ((out, &v), &v0) in dv_next.iter_mut().zip(&s.next.v).zip(&point.next.v) {
        *out = v - v0;
    }
}

fn lift_into<T: Scalar>(x: &DVector<f64>, out: &mut DVector<T>) {
    out.iter_mut()
        .zip(x)
        .for_each(|(out, &x)| *out = T::constant(x));
}

fn add_into<T: Scalar>(dx: &[T], x: &[f64], out: &mut [T]) {
    out.iter_mut()
        .zip(dx)
        .zip(x)
        .for_each(|((out, &dx), &x)| *out = dx + x);
}
