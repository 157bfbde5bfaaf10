//! Jacobians of a step by finite differences.

use nalgebra::{DMatrix, DVector};

use super::{Linearization, LinearizationEstimate};
use crate::autodiff::finite_difference::{Options, estimate_of};
use crate::scalar::{Scalar, add_into, lift_into};
use crate::sim::{Simulator, State, StepScratch};

/// The Jacobians by finite differences, with their errors.
pub(super) fn by_finite_differences(
    simulator: &Simulator,
    state: &State,
    u: &[f64],
    options: &Options,
) -> LinearizationEstimate {
    let (mut scratch, mut next) = (TangentScratch::new(simulator), state.clone());
    simulator.step_into(state, u, &mut scratch.step, &mut next);
    let point = Point {
        state,
        u,
        next: &next,
    };
    let n = simulator.n_tangent();
    let step = |dx: &[f64], dy: &mut [f64]| tangent_step(simulator, &point, dx, &mut scratch, dy);
    let zeros = vec![0.0; n + u.len()];
    let estimate = estimate_of(n, step, &zeros, options);
    let parts = |of: &DMatrix<f64>| Linearization {
        a: of.columns(0, n).into(),
        b: of.columns(n, u.len()).into(),
    };
    LinearizationEstimate {
        linearization: parts(&estimate.jacobian),
        error: parts(&estimate.error),
    }
}

/// Point at which the step is linearised, with its result there.
pub(super) struct Point<'a> {
    pub(super) state: &'a State,
    pub(super) u: &'a [f64],
    pub(super) next: &'a State,
}

/// Working memory of [`tangent_step`].
#[derive(Clone, Debug)]
pub(super) struct TangentScratch<T: Scalar> {
    step: StepScratch<T>,
    state: State<T>,
    next: State<T>,
    /// The state at the point of linearisation and the configuration after it, without derivatives.
    start: State<T>,
    next_q: DVector<T>,
    u: Vec<T>,
}

impl<T: Scalar> TangentScratch<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let state: State<T> = simulator.neutral_state();
        Self {
            step: StepScratch::awake(simulator),
            next: state.clone(),
            start: state.clone(),
            next_q: state.q.clone(),
            u: vec![T::zero(); simulator.nu()],
            state,
        }
    }
}

/// The step as a function (δq, δv, δm, δu) ↦ (δq⁺, δv⁺, δm⁺) that maps zero to zero.
pub(super) fn tangent_step<T: Scalar>(
    simulator: &Simulator,
    point: &Point<'_>,
    dx: &[T],
    s: &mut TangentScratch<T>,
    dy: &mut [T],
) {
    let (model, nv) = (simulator.model(), simulator.model().nv());
    let (dx, du) = dx.split_at(simulator.n_tangent());
    // x ⊕ δx,  u + δu
    let start = s.start.numbers_mut().zip(point.state.numbers());
    start.for_each(|(out, &x)| *out = T::constant(x));
    lift_into(point.next.q.as_slice(), s.next_q.as_mut_slice());
    s.start.integrate_into(model, dx, &mut s.state);
    add_into(point.u, du, &mut s.u);
    simulator.step_into(&s.state, &s.u, &mut s.step, &mut s.next);
    // δq⁺ = q⁺ ⊖ q⁺(0),  δv⁺ = v⁺ − v⁺(0), and so the rest
    let (dq_next, rest) = dy.split_at_mut(nv);
    model.difference_into(s.next_q.as_slice(), s.next.q.as_slice(), dq_next);
    let (ends, expected) = (s.next.beside_q(), point.next.beside_q());
    for ((out, &x), &x0) in rest.iter_mut().zip(ends).zip(expected) {
        *out = x - x0;
    }
}
