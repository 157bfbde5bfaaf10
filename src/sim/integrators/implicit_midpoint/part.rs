//! One part of a step.

use super::newton::Newton;
use super::parts::Search;
use super::point::Midpoint;
use crate::scalar::{Over, Scalar, is_more_than_values};
use crate::sim::integrators::AccelerationScratch;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// Working memory for one part of a step: its middle, and the search for it on plain numbers.
#[derive(Clone, Debug)]
pub(super) struct Part<T: Scalar> {
    pub(super) point: Midpoint<T>,
    pub(super) newton: Newton,
}

impl<T: Scalar> Part<T> {
    /// Takes one of so many equal parts of a step.
    pub(super) fn take<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        parts: usize,
        found: &mut AccelerationScratch<T>,
        next: &mut State<T>,
    ) -> Search
    where
        T: Over<P>,
    {
        let point = &mut self.point;
        point.part = 1.0 / parts as f64;
        point.start(simulator, state);
        let search = self.newton.solve(simulator, state, u, point.part);
        point.take_values(&self.newton.point);
        point.evaluate(simulator, state, u, found);
        // Each makes one more order of derivatives exact.
        let corrections = T::ORDER.max(usize::from(is_more_than_values::<T>()));
        for _ in 0..corrections {
            point.find_residual(simulator, state);
            (self.newton).correct(&mut point.residual, &mut point.held.errors);
            point.move_by_residual();
            point.evaluate(simulator, state, u, found);
        }
        point.finish(simulator, state, next);
        search.with_energy_error(point.energy_error(state, next))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Integrator;
    use crate::dynamics::{Calls, kinetic_energy};
    use crate::model::{Model, samples};
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    /// Takes a whole step. Its energy error, and its end.
    fn step(model: &Model, state: &State<f64>, u: f64) -> (f64, State<f64>) {
        let simulator = Simulator::new(model.clone())
            .with_integrator(Integrator::ImplicitMidpoint)
            .with_time_step(0.05);
        let mut part = Part {
            point: Midpoint::new(&simulator),
            newton: Newton::new(&simulator),
        };
        let mut found = AccelerationScratch::new(&simulator, Calls::Many);
        let (u, mut next) = (vec![u; simulator.nu()], state.clone());
        part.take(&simulator, state, &u, 1, &mut found, &mut next);
        (part.point.energy_error(state, &next), next)
    }

    /// A strong damper, gravity and an input do work, which the rule accounts for exactly at a constant inertia.
    #[test]
    fn energy_error_vanishes_at_a_constant_mass_matrix() {
        let model = samples::pendulum().with_damping(0, 30.0);
        let (error, next) = step(&model, &State::new(&[1.0], &[5.0]), 2.0);
        assert!((next.v[0] - 5.0).abs() > 1.0);
        assert!(error < 1e-11, "{error:e}");
    }

    #[test]
    fn energy_error_is_the_change_of_kinetic_energy_where_nothing_does_work() {
        for seed in 0..4 {
            let model = samples::random_tree(6, seed).with_gravity(nalgebra::Vector3::zeros());
            let model = (0..model.nv()).fold(model, |model, k| model.with_damping(k, 0.0));
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let q = model.random_configuration(&mut rng);
            let v = model.random_velocity(&mut rng, 2.0);
            let state = State::new(q.as_slice(), v.as_slice());
            let (error, next) = step(&model, &state, 0.0);
            let kinetic = |x: &State<f64>| kinetic_energy(&model, x.q.as_slice(), x.v.as_slice());
            let (before, after) = (kinetic(&state), kinetic(&next));
            let expected = (after - before).abs() / before.max(after);
            assert!(
                (error - expected).abs() < 1e-10,
                "seed {seed}: {error:e} {expected:e}"
            );
        }
    }
}
