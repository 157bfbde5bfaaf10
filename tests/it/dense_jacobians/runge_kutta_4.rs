//! Jacobians of the step of Runge and Kutta by the chain rule beside those of the step on dual numbers.

use super::forces::with_forces;
use super::{difference, inputs, laws, lower, simulator, with_stiff_joints};
use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::{ContactLaw, Terrain};
use dualbody::model::samples;
use dualbody::sim::Integrator;
use dualbody::{Simulator, State};
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

fn assert_exact(simulator: &Simulator, state: &State) {
    let simulator = simulator.clone().with_integrator(Integrator::RungeKutta4);
    let error = difference(&simulator, state, &inputs(&simulator));
    // Servos of 10⁴ N·m/rad make the entries of an explicit step's Jacobian large.
    assert!(error < 1e-11, "{}: {error:e}", simulator.model().name());
}

#[test]
fn jacobians_of_trees_equal_those_of_the_step_on_dual_numbers() {
    for seed in 0..8 {
        let tree = samples::random_tree(12, seed);
        let plain = Simulator::new(tree.clone());
        for simulator in [plain.clone(), with_stiff_joints(tree), with_forces(plain)] {
            let simulator = simulator.with_time_step(0.01);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            assert_exact(&simulator, &State::random(simulator.model(), &mut rng, 2.0));
        }
    }
}

#[test]
fn jacobians_in_contact_and_closed_loops_equal_those_of_the_step_on_dual_numbers() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    for law in laws() {
        if matches!(law, ContactLaw::Rigid(_)) {
            continue; // it acts over a step
        }
        let simulator = simulator("quadruped", &Terrain::incline(0.1), law);
        let mut state = simulator.neutral_state();
        state
            .v
            .copy_from(&State::random(simulator.model(), &mut rng, 0.5).v);
        lower(&simulator, &mut state);
        state
            .contact
            .iter_mut()
            .enumerate()
            .for_each(|(k, m)| *m = 1e-4 * (k as f64).sin());
        let foot = |name: &str| Anchor::frame(simulator.model(), name).unwrap();
        let tied = Constraint::distance([foot("FL_foot"), foot("RL_foot")], 0.35);
        assert_exact(&simulator, &state);
        assert_exact(&simulator.clone().with_constraints(vec![tied]), &state);
    }
}
