//! Jacobians of continuous time: how the rate (v, v̇) changes with state and input.

use super::Linearization;
use super::acceleration::AccelerationColumns;
use crate::contact::Contacts;
use crate::dynamics::Calls;
use crate::sim::{AccelerationScratch, Moment, Simulator, State};

/// Working memory of [`Simulator::linearize_rate_into`].
#[derive(Clone, Debug)]
pub struct RateScratch {
    found: AccelerationScratch<f64>,
    columns: AccelerationColumns<f64>,
}

impl RateScratch {
    /// Memory for a simulator.
    pub fn new(simulator: &Simulator) -> Self {
        Self::for_calls(simulator, Calls::Many)
    }

    fn for_calls(simulator: &Simulator, calls: Calls) -> Self {
        Self {
            found: AccelerationScratch::new(simulator, calls),
            columns: AccelerationColumns::new(simulator, calls),
        }
    }
}

impl Simulator<f64> {
    /// Computes the Jacobians A and B of the rate (v, v̇(q, v, u)) at `state` with input `u`:  δ(v, v̇) = A δx + B δu.  Allocates.
    ///
    /// A = (0, 1; ∂v̇/∂q, ∂v̇/∂v) and B = (0; ∂v̇/∂u), in tangent directions of q, with a row of blocks for the rates of the state of contact, where
    /// there is one: what a controller in continuous time is designed on, at rest. Exact to rounding; the same for every integrator, and for
    /// every time step but for the stabilisation of constraints, which knows it.
    ///
    /// # Panics
    /// If state or input have the wrong length, or if there is rigid contact, whose forces act over a step.
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
    /// If state, input, scratch or output have the wrong size, or if there is rigid contact, whose forces act over a step.
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
        self.check_input(u);
        self.check(state);
        let at = Moment::instant(self, state, u);
        self.accelerate(&at, &mut scratch.found);
        scratch.columns.linearize(&at, &mut scratch.found);
        let (minus_a, bristles) = (scratch.columns.minus_a(), scratch.columns.bristles());
        let (nv, n) = (self.model().nv(), self.n_contact());
        let of_state = out.a.column_iter_mut();
        for (k, mut column) in of_state.chain(out.b.column_iter_mut()).enumerate() {
            column.rows_mut(0, nv).fill(0.0);
            let entries = column.rows_range_mut(nv..2 * nv).into_iter();
            entries
                .zip(minus_a.column(k))
                .for_each(|(out, x)| *out = -x);
            if n > 0 {
                let entries = column.rows_range_mut(2 * nv..).into_iter();
                entries
                    .zip(bristles.column(k))
                    .for_each(|(out, x)| *out = x);
            }
        }
        for k in 0..nv {
            out.a[(k, nv + k)] = 1.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{lower, simulator};
    use super::*;
    use crate::contact::{ContactLaw, SoftContact, Terrain};
    use crate::model::samples;
    use crate::sim::Integrator;
    use nalgebra::DMatrix;
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    /// Largest difference between A and B of a rate and the limit of those of steps of Runge and Kutta, which are x ⊕ Δt ẋ to first order.
    fn difference_from_short_steps(simulator: &Simulator, state: &State, u: &[f64]) -> f64 {
        /// A step so short that its square is rounding.
        const SHORT: f64 = 1e-10;
        let rate = simulator.linearize_rate(state, u);
        let short = (simulator.clone()).with_integrator(Integrator::RungeKutta4);
        let short = short.with_time_step(SHORT);
        let step = short.linearize(state, u);
        let (nv, n) = (short.model().nv(), step.a.nrows());
        let a = (&step.a - DMatrix::identity(n, n)) / SHORT;
        let pairs = [(a, &rate.a), (step.b / SHORT, &rate.b)];
        let errors = pairs.map(|(limit, exact)| {
            let error = (limit - exact).rows(nv, n - nv).amax();
            error / exact.amax()
        });
        errors.into_iter().fold(0.0, f64::max)
    }

    #[test]
    fn jacobians_of_the_rate_equal_the_limit_of_those_of_the_step() {
        for seed in 0..5 {
            let simulator = Simulator::new(samples::random_tree(9, seed));
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let state = State::random(simulator.model(), &mut rng, 2.0);
            let u: Vec<f64> = (0..simulator.nu()).map(|k| (k as f64).sin()).collect();
            let error = difference_from_short_steps(&simulator, &state, &u);
            assert!(error < 1e-5, "seed {seed}: {error:e}");
        }
    }

    #[test]
    fn jacobians_of_the_rate_in_soft_contact_equal_the_limit_of_those_of_the_step() {
        let law = ContactLaw::Soft(SoftContact::estimate(10.0, 4, 1e-3));
        let simulator = simulator("quadruped", &Terrain::incline(0.1), law);
        let mut state = simulator.neutral_state();
        lower(&simulator, &mut state);
        let u = vec![0.1; simulator.nu()];
        let forces = simulator.contact_report(&state, &u).forces;
        assert!(forces.iter().any(|f| f.norm() > 1.0));
        let error = difference_from_short_steps(&simulator, &state, &u);
        assert!(error < 1e-5, "{error:e}");
    }
}
