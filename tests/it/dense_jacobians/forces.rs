//! Jacobians with external forces and frame actuators.

use nalgebra::Vector3;

use super::{EULER, difference, inputs, laws, lower, simulator};
use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::Terrain;
use dualbody::model::samples;
use dualbody::scalar::Scalar;
use dualbody::sim::{ExternalForce, ForceFunction, FrameActuator};
use dualbody::spatial::{Force, Motion, Representation, Transform};
use dualbody::{Simulator, State};
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

/// A damped spring to a point, stiffer the farther it is, that also turns its place: all that a force can follow.
struct Tether;

impl ForceFunction for Tether {
    fn force<T: Scalar>(
        &self,
        pose: &Transform<T>,
        velocity: &Motion<T>,
        parameters: &[T],
    ) -> Force<T> {
        let p = &pose.translation;
        let stiffness = (p.x * p.x + p.y * p.y + p.z * p.z + 1.0).sqrt() * parameters[0];
        let pull = p.map(|x| -x * stiffness) - velocity.linear.map(|x| x * parameters[1]);
        let axis = pose.rotation.column(2).into_owned();
        let turn = Vector3::new(
            axis.y * pull.z - axis.z * pull.y,
            axis.z * pull.x - axis.x * pull.z,
            axis.x * pull.y - axis.y * pull.x,
        );
        Force::new(pull, turn - velocity.angular)
    }
}

/// Forces of all sorts on the last link and on the first.
pub(super) fn with_forces(simulator: Simulator) -> Simulator {
    let model = simulator.model();
    let links = model.link_names();
    let on = |name: &str| Anchor::frame(model, name).expect("a link of the robot");
    let (tip, base) = (on(links[links.len() - 1]), on(links[0]));
    // The first link may be the world.
    let base = if model.has_floating_base() { base } else { tip };
    let push = Force::from_array([1.0, -2.0, 3.0, 0.4, 0.5, -0.6]);
    let (mut forces, mut actuators) = (Vec::new(), Vec::new());
    for r in Representation::ALL {
        let place = tip.moved([0.1, 0.2, -0.3]);
        forces.push(ExternalForce::constant(place, push, r));
        forces.push(ExternalForce::function(base, Tether, &[5.0, 0.7], r));
        actuators.push(FrameActuator::new(format!("{r:?}"), place, push, r));
    }
    let direction = [0.1, 0.2, 0.9];
    let thruster = FrameActuator::thruster("thruster", base, direction, -0.1);
    actuators.push(thruster.with_limits(-10.0, 0.1));
    simulator
        .with_external_forces(forces)
        .with_frame_actuators(actuators)
}

#[test]
fn jacobians_with_forces_on_frames_equal_those_of_the_dense_step() {
    for (seed, integrator) in (0..6).flat_map(|seed| EULER.map(|by| (seed, by))) {
        let simulator = Simulator::new(samples::random_tree(9, seed));
        let simulator = with_forces(simulator).with_integrator(integrator);
        let simulator = simulator.with_time_step(0.01);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let state = State::random(simulator.model(), &mut rng, 2.0);
        let error = difference(&simulator, &state, &inputs(&simulator));
        assert!(error < 1e-12, "seed {seed} {integrator:?}: {error:e}");
    }
}

#[test]
fn jacobians_with_forces_on_frames_contact_and_constraints_equal_those_of_the_dense_step() {
    let (mut touching, mut rng) = (0, Xoshiro256PlusPlus::seed_from_u64(5));
    for (law, integrator) in laws().iter().flat_map(|&law| EULER.map(|by| (law, by))) {
        let simulator = simulator("quadruped", &Terrain::incline(0.1), law);
        let mut state = simulator.neutral_state();
        let random = State::random(simulator.model(), &mut rng, 0.5);
        state.v.copy_from(&random.v);
        state.v[2] -= 1.0;
        lower(&simulator, &mut state);
        let foot = |name: &str| Anchor::frame(simulator.model(), name).unwrap();
        let tied = Constraint::distance([foot("FL_foot"), foot("RL_foot")], 0.35);
        let simulator = with_forces(simulator.with_constraints(vec![tied]));
        let simulator = simulator.with_integrator(integrator);
        let u = inputs(&simulator);
        let forces = simulator.contact_report(&state, &u).forces;
        touching += forces.iter().filter(|f| f.norm() > 0.0).count();
        let error = difference(&simulator, &state, &u);
        assert!(error < 1e-10, "{law:?} {integrator:?}: {error:e}");
    }
    assert!(touching > 3, "{touching}");
}

#[test]
fn rate_with_a_thruster_equals_its_closed_form() {
    // A body of 2 kg and 0.1 kg·m² under a thrust of 3 N a quarter of a metre beside its centre of mass, which turns with it.
    let mut builder = dualbody::model::ModelBuilder::new("body");
    let link = dualbody::model::LinkSpec::new("body");
    builder.add_link(link.with_mass(2.0, [0.0; 3], [0.1; 3]));
    let model = builder.build().unwrap();
    let place = Anchor::frame(&model, "body").unwrap();
    let beside = place.moved([0.25, 0.0, 0.0]);
    let jet = FrameActuator::thruster("jet", beside, [0.0, 0.0, 2.0], 0.02);
    let simulator = Simulator::new(model).with_frame_actuators(vec![jet]);
    let rate = simulator.linearize_rate(&simulator.neutral_state(), &[3.0]);
    let expected = [0.0, 0.0, 0.5, 0.0, -2.5, 0.2];
    for (row, expected) in expected.into_iter().enumerate() {
        assert!((rate.b[(6 + row, 0)] - expected).abs() < 1e-14);
    }
    // Gravity turns with the body's axes, and the thrust does not: δv̇ = −δθ × g in the body.
    let g = Vector3::new(0.0, 0.0, -9.81);
    for k in 0..3 {
        let turned = -Vector3::ith(k, 1.0).cross(&g);
        for row in 0..3 {
            assert!((rate.a[(6 + row, 3 + k)] - turned[row]).abs() < 1e-13);
        }
    }
}
