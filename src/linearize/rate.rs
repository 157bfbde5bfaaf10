//! Jacobians in continuous time: derivatives of the rate (v, v̇) in state and input.

use std::ops::Range;

use super::Linearization;
use crate::contact::Contacts;
use crate::dynamics::Calls;
use crate::scalar::Opaque;
use crate::sim::{AccelerationColumns, AccelerationScratch, EvaluationPoint, Simulator, State};

/// Working memory of [`Simulator::linearize_rate_into`].
#[derive(Clone, Debug)]
pub struct RateScratch(Opaque<Memory>);

#[derive(Clone)]
struct Memory {
    found: AccelerationScratch<f64>,
    columns: AccelerationColumns<f64>,
}

impl RateScratch {
    /// Makes memory for a simulator.
    pub fn new(simulator: &Simulator) -> Self {
        Self::for_calls(simulator, Calls::Many)
    }

    fn for_calls(simulator: &Simulator, calls: Calls) -> Self {
        Self(Opaque::new(Memory {
            found: AccelerationScratch::new(simulator, calls),
            columns: AccelerationColumns::new(simulator, calls),
        }))
    }
}

impl Simulator<f64> {
    /// Computes the Jacobians A and B of the rate (v, v̇(q, v, u)) at `state` with input `u`:  δ(v, v̇) = A δx + B δu.  Allocates.
    ///
    /// A = (0, 1; ∂v̇/∂q, ∂v̇/∂v) and B = (0; ∂v̇/∂u), in tangent directions of q, with a block row for the rates of the contact state if there is
    /// one. Use them to design a controller in continuous time, at rest. They are exact to rounding, and independent of the integrator and of the
    /// time step, except for the stabilisation of constraints, which depends on the time step.
    ///
    /// # Panics
    /// If state or input have the wrong length, or if there is rigid contact or an [activation](crate::sim::Activation), which act over a step.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples};
    ///
    /// let rate = Simulator::new(samples::pendulum()).linearize_rate(&State::new(&[0.0], &[0.0]), &[0.0]);
    /// // v̇ = (u − ½ g sin q) / J with J = 1/3 kg·m²
    /// assert_eq!((rate.a[(0, 1)], rate.b[(0, 0)]), (1.0, 0.0));
    /// assert!((rate.b[(1, 0)] - 3.0).abs() < 1e-14 && (rate.a[(1, 0)] + 1.5 * 9.81).abs() < 1e-14);
    /// ```
    ///
    /// # References
    /// [Carpentier, Mansard 2018].
    pub fn linearize_rate(&self, state: &State, u: &[f64]) -> Linearization {
        let mut out = Linearization::zeros(self);
        self.linearize_rate_into(
            state,
            u,
            &mut RateScratch::for_calls(self, Calls::One),
            &mut out,
        );
        out
    }

    /// [`linearize_rate`](Self::linearize_rate) without allocation.
    ///
    /// # Panics
    /// If state, input, scratch or output have the wrong size, or if there is rigid contact or an activation, which act over a step.
    pub fn linearize_rate_into(
        &self,
        state: &State,
        u: &[f64],
        scratch: &mut RateScratch,
        out: &mut Linearization,
    ) {
        let law = self.contacts().and_then(Contacts::acting_over_step);
        assert!(
            law.is_none(),
            "{} contact acts over a step and has no rate, Simulator::linearize has its Jacobians",
            law.unwrap_or_default()
        );
        assert!(
            self.n_activation() == 0 && self.activations().is_empty(),
            "inputs of \"{}\" have activations, which act over a step and have no rate: Simulator::linearize has their Jacobians",
            self.model().name()
        );
        self.check_input(u);
        self.check(state);
        let at = EvaluationPoint::instant(self, state, u);
        let Memory { found, columns } = scratch.0.get_mut();
        self.accelerate(&at, found);
        columns.linearize(&at, found);
        let (minus_a, bristles) = (columns.minus_a(), columns.bristles());
        let (nv, n) = (self.model().nv(), self.n_contact());
        out.a.fill(0.0);
        out.b.fill(0.0);
        minus_a.copy_columns_to(rows_of_all(out, nv..2 * nv), |x| -x);
        if n > 0 {
            bristles.copy_columns_to(rows_of_all(out, 2 * nv..2 * nv + n), |x| x);
        }
        for k in 0..nv {
            out.a[(k, nv + k)] = 1.0;
        }
    }
}

/// Some rows of all columns of A and B.
fn rows_of_all(out: &mut Linearization, rows: Range<usize>) -> impl Iterator<Item = &mut [f64]> {
    let n = out.a.nrows().max(1);
    let a = out.a.as_mut_slice().chunks_exact_mut(n);
    let columns = a.chain(out.b.as_mut_slice().chunks_exact_mut(n));
    columns.map(move |column| &mut column[rows.clone()])
}
