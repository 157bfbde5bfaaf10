//! Jacobians of continuous time: how the rate (v, v̇) changes with state and input.

use super::acceleration::AccelerationColumns;
use super::{Linearization, acts_on_joints_only};
use crate::sim::{AccelerationScratch, Moment, Simulator, State};

/// Working memory of [`Simulator::linearize_rate_into`].
#[derive(Clone, Debug)]
pub struct RateScratch {
    found: AccelerationScratch<f64>,
    columns: AccelerationColumns,
}

impl RateScratch {
    /// Memory for a simulator.
    pub fn new(simulator: &Simulator) -> Self {
        Self {
            found: AccelerationScratch::new(simulator),
            columns: AccelerationColumns::new(simulator),
        }
    }
}

impl Simulator<f64> {
    /// Computes the Jacobians A and B of the rate (v, v̇(q, v, u)) at `state` with input `u`:  δ(v, v̇) = A δx + B δu.  Allocates.
    ///
    /// A = (0, 1; ∂v̇/∂q, ∂v̇/∂v) and B = (0; ∂v̇/∂u), in tangent directions of q: what a controller in continuous time is designed
    /// on, at rest. Exact to rounding; the same for every integrator and time step.
    ///
    /// # Panics
    /// If state or input have the wrong length, or if the robot touches a ground or has constraints.
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
        self.linearize_rate_into(state, u, &mut RateScratch::new(self), &mut out);
        out
    }

    /// [`linearize_rate`](Self::linearize_rate) without allocation.
    ///
    /// # Panics
    /// If state, input, scratch or output have the wrong size, or if the robot touches a ground or has constraints.
    pub fn linearize_rate_into(
        &self,
        state: &State,
        u: &[f64],
        scratch: &mut RateScratch,
        out: &mut Linearization,
    ) {
        let nv = self.model().nv();
        assert!(
            acts_on_joints_only(self),
            "the rate has no Jacobians with contact or constraints, Simulator::linearize does"
        );
        self.check_input(u);
        self.check(state);
        let at = Moment::instant(self, state, u);
        self.accelerate(&at, &mut scratch.found);
        scratch.columns.linearize(&at, &mut scratch.found);
        let columns = scratch.columns.minus_a();
        let of_state = out.a.column_iter_mut();
        for (k, mut column) in of_state.chain(out.b.column_iter_mut()).enumerate() {
            column.rows_mut(0, nv).fill(0.0);
            let entries = column.rows_mut(nv, nv);
            let both = entries.into_iter().zip(columns.column(k));
            both.for_each(|(out, minus_a)| *out = -minus_a);
        }
        for k in 0..nv {
            out.a[(k, nv + k)] = 1.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::samples;
    use crate::sim::Integrator;
    use nalgebra::DMatrix;
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    // One step of Runge and Kutta is x ⊕ Δt ẋ to first order.
    #[test]
    fn jacobians_of_the_rate_equal_the_limit_of_those_of_the_step() {
        /// A step so short that its square is rounding.
        const SHORT: f64 = 1e-8;
        for seed in 0..5 {
            let simulator = Simulator::new(samples::random_tree(9, seed));
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let state = State::random(simulator.model(), &mut rng, 2.0);
            let u: Vec<f64> = (0..simulator.nu()).map(|k| (k as f64).sin()).collect();
            let rate = simulator.linearize_rate(&state, &u);
            let short = simulator.with_integrator(Integrator::RungeKutta4);
            let short = short.with_time_step(SHORT);
            let step = short.linearize(&state, &u);
            let nv = short.model().nv();
            let a = (&step.a - DMatrix::identity(2 * nv, 2 * nv)) / SHORT;
            for (name, limit, exact) in [("A", a, &rate.a), ("B", step.b / SHORT, &rate.b)] {
                let error = (limit - exact).rows(nv, nv).amax() / exact.amax();
                assert!(error < 1e-5, "seed {seed}, {name}: {error:e}");
            }
        }
    }
}
