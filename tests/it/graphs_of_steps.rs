//! A and B recorded as graphs beside those of the library, at states where they were not recorded.

use dualbody::codegen::linearization;
use dualbody::constraint::Anchor;
use dualbody::contact::{ContactLaw, Contacts, SoftContact, Terrain};
use dualbody::model::samples;
use dualbody::sim::{FrameActuator, Integrator};
use dualbody::{Model, Simulator, State};
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

use crate::common::OTHER_ALGORITHM;

/// Asserts that the graph gives A and B at a state where it was not recorded.
fn assert_traced(simulator: &Simulator, state: &State) {
    let u: Vec<f64> = (0..simulator.nu()).map(|k| (k as f64).sin()).collect();
    let inputs: Vec<f64> = state.numbers().chain(&u).copied().collect();
    let graph = linearization(simulator);
    let found = graph.evaluate(&inputs).expect("slow motion");
    let step = simulator.linearize(state, &u);
    let expected: Vec<f64> = step.a.iter().chain(&step.b).copied().collect();
    let largest = expected.iter().fold(1.0, |most: f64, x| x.abs().max(most));
    for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
        let off = (found - expected).abs();
        let by = simulator.integrator();
        assert!(off < OTHER_ALGORITHM * largest, "{by:?}, {k}: {off:e}");
    }
}

#[test]
fn graphs_with_thrusters_give_the_jacobians_of_all_integrators() {
    let model = samples::arm();
    let tip = *model.link_names().last().expect("a link");
    let tip = Anchor::frame(&model, tip).expect("a link of the robot");
    let jet = FrameActuator::thruster("jet", tip, [0.1, 0.2, 0.9], 0.1);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    let state = State::random(&model, &mut rng, 1.0);
    for integrator in [
        Integrator::SemiImplicitEuler,
        Integrator::ImplicitVelocity,
        Integrator::RungeKutta4,
    ] {
        let simulator = Simulator::new(model.clone()).with_integrator(integrator);
        assert_traced(&simulator, &state);
        assert_traced(&simulator.with_frame_actuators(vec![jet.clone()]), &state);
    }
}

#[test]
fn graphs_on_soft_ground_give_the_jacobians() {
    let path = format!("{}/assets/sphere.urdf", env!("CARGO_MANIFEST_DIR"));
    let model = Model::from_urdf_file(path).expect("an asset");
    let law = ContactLaw::Soft(SoftContact::estimate(1.0, 1, 1e-2));
    let contacts = Contacts::new(&model, Terrain::incline(0.2), law);
    let simulator = Simulator::new(model).with_contacts(contacts);
    let mut state = simulator.neutral_state();
    for height in [0.0, 0.09, 10.0] {
        state.q[2] = height;
        state.v[1] = 0.3;
        assert_traced(&simulator, &state);
    }
}
