//! Jacobians of the rate beside the limit of those of short steps.

use super::{lower, simulator};
use dualbody::contact::{ContactLaw, SoftContact, Terrain};
use dualbody::model::samples;
use dualbody::{Integrator, Simulator, State};
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
    // Rounding of A − 1, by a step of 1e-10 s.
    let error = difference_from_short_steps(&simulator, &state, &u);
    assert!(error < 3e-5, "{error:e}");
}
