//! Recorded steps with a user's functions, of the ground and of forces, against the steps themselves.

use dualbody::constraint::Anchor;
use dualbody::contact::{ContactLaw, RelaxedRigid, SoftContact};
use dualbody::scalar::traced::{Port, Traced, trace};
use dualbody::sim::{ExternalForce, ForceFunction};
use dualbody::spatial::{Force, Motion, Representation, Transform};
use dualbody::{Integrator, Scalar, Simulator, codegen};

use crate::common::asset;
use crate::common::ground::{on, waves};
use crate::traced::{assert_equal, assert_linearization, assert_step, step_inputs, touches};

/// Drag in a wind along x that grows with the height: −c |v − w z| (v − w z), with c (kg/m) and w (1/s).
struct Drag;

impl ForceFunction for Drag {
    fn force<T: Scalar>(
        &self,
        pose: &Transform<T>,
        velocity: &Motion<T>,
        parameters: &[T],
    ) -> Force<T> {
        let mut v = velocity.linear;
        v.x -= parameters[1] * pose.translation.z;
        let speed = (v.x * v.x + v.y * v.y + v.z * v.z + 1e-12).sqrt();
        let size = speed * parameters[0] * -1.0;
        Force::new(v * size, velocity.angular * (parameters[0] * -0.1))
    }
}

/// A box in the wind over waves.
fn brick(law: ContactLaw, integrator: Integrator) -> Simulator {
    let model = asset("box.urdf");
    let place = Anchor::frame(&model, model.link_names()[0]).expect("a link");
    let drag = ExternalForce::function(place, Drag, &[0.4, 2.0], Representation::Mixed);
    on(model, waves(), law)
        .with_external_forces(vec![drag])
        .with_integrator(integrator)
}

#[test]
fn traced_steps_and_linearizations_with_functions_equal_those_of_the_simulator() {
    let soft = ContactLaw::Soft(SoftContact::estimate(10.0, 4, 1e-2));
    for integrator in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
        let simulator = brick(soft, integrator);
        let step = codegen::step(&simulator);
        let linearization = codegen::linearization(&simulator);
        let seeds = 0..20;
        let touching = seeds.clone().filter(|&seed| touches(&simulator, seed));
        let n = touching.count();
        assert!((3..18).contains(&n), "{n} of 20 touch");
        for seed in seeds {
            let what = format!("{integrator:?}, seed {seed}");
            assert_step(&simulator, &step, seed, &what);
            assert_linearization(&simulator, &linearization, seed, &what);
        }
    }
}

// The parameters of both functions are inputs of a graph as those of the robot are.
#[test]
fn parameters_of_functions_are_inputs_of_a_graph() {
    let simulator = brick(
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        Integrator::SemiImplicitEuler,
    );
    let parameters = simulator.parameters();
    let touching = (0..20).find(|&seed| touches(&simulator, seed));
    let (state, _, all) = step_inputs(&simulator, touching.expect("a seed"));
    let graph = trace(|t| {
        let x = t.input(Port::vector("x", all.len()));
        let p = t.input(Port::vector("parameters", parameters.len()));
        let moving: Simulator<Traced> = simulator.with_parameters(&p);
        let mut at = moving.neutral_state();
        at.copy_from_slice(&x[..state.len()]);
        let next = moving.step(&at, &x[state.len()..]);
        t.output(Port::vector("next", state.len()), next.numbers());
    });
    for scale in [1.0, 1.02] {
        let own: Vec<f64> = parameters.iter().map(|x| x * scale).collect();
        let moved: Simulator = simulator.with_parameters(&own);
        let next = moved.step(&state, &all[state.len()..]);
        let next: Vec<f64> = next.numbers().copied().collect();
        let given: Vec<f64> = all.iter().copied().chain(own).collect();
        let found = graph.evaluate(&given).expect("forces are found");
        assert_equal(&found, &next, 1e-8, &format!("{scale}"));
    }
}
