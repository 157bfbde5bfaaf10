//! Activations of inputs: closed forms, Jacobians against differences, gradients against Jacobians, an actuator of one's own.

use dualbody::autodiff::{Dual, finite_difference};
use dualbody::linearize::{StepGradient, VjpScratch};
use dualbody::model::samples;
use dualbody::sim::{
    Activation, Actuation, Actuator, ActuatorFunction, ActuatorNetwork, ActuatorPoint,
    BatchSimulator, Servo, StepScratch,
};
use dualbody::{Cast, Integrator, Scalar, Simulator, State};
use nalgebra::{DVector, dmatrix};

const DT: f64 = 0.01;
/// Two ways to the same numbers in other orders of operations.
const SAME: f64 = 1e-12;

/// A learned actuator: a network of one hidden layer on the error of the position, that of the step before, and the velocity, beside a lag of its own.
struct Network;

impl ActuatorFunction for Network {
    fn states(&self) -> usize {
        2
    }

    fn respond<T: Scalar>(
        &self,
        at: &ActuatorPoint<T>,
        state: &[T],
        parameters: &[T],
        next: &mut [T],
    ) -> T {
        let error = at.u - at.q;
        let mut sum = T::zero();
        for k in 0..4 {
            let k = f64::from(k);
            let x = error * (k + 1.0).cos() + state[0] * (k + 2.0).sin() + at.v * (0.3 * k - 0.5);
            sum += x / (x * x + 1.0).sqrt() * (1.0 + 0.2 * k);
        }
        next[0] = error;
        next[1] = state[1] + (sum * parameters[0] - state[1]) * at.dt / parameters[1];
        next[1] + sum * 0.1
    }
}

/// Two layers on errors and velocities of now and two steps ago.
fn layers() -> ActuatorNetwork {
    let hidden = dmatrix![1.0, 0.5, -0.2, 0.1; 0.3, -0.4, 0.1, 0.2];
    let last = (dmatrix![4.0, -3.0], vec![0.05]);
    ActuatorNetwork::new(vec![(hidden, vec![0.1, -0.2]), last], &[0, 2])
}

fn kinds() -> Vec<(&'static str, Activation)> {
    vec![
        ("delay", Activation::delay(3)),
        ("filter", Activation::filter(0.03)),
        (
            "explicit",
            Activation::explicit_filter(0.05).with_range(-2.0, 2.0),
        ),
        ("early", Activation::filter(0.03).early().with_delay(1)),
        (
            "integrator",
            Activation::integrator()
                .with_range(-1.0, 1.0)
                .with_input_range(-5.0, 5.0),
        ),
        ("late filter", Activation::filter(0.02).with_delay(2)),
        ("network", Activation::function(Network, &[3.0, 0.04])),
        (
            "late network",
            Activation::function(Network, &[3.0, 0.04]).with_delay(2),
        ),
        ("layers", Activation::function(layers(), &[])),
    ]
}

/// A double pendulum with a position servo behind an activation on its first joint, and a delayed motor on the second.
fn simulator(activation: Activation, integrator: Integrator) -> Simulator {
    let model = samples::double_pendulum();
    let joints: Vec<String> = model.joint_names().iter().map(|x| x.to_string()).collect();
    let servo = Actuator {
        servo: Some(Servo::position(40.0, 2.0)),
        effort: Some(60.0),
        ..Actuator::default()
    };
    let actuation = Actuation::ideal(&model).with_actuator(&model, &joints[0], servo);
    let simulator = Simulator::new(model)
        .with_time_step(DT)
        .with_integrator(integrator)
        .with_actuation(actuation.expect("the joint"));
    (simulator.with_activation(&joints[1], Activation::delay(1)))
        .and_then(|own| own.with_activation(&joints[0], activation))
        .expect("the inputs")
}

fn state(simulator: &Simulator) -> State {
    let mut state = simulator.state(&[0.3, -0.5], &[0.7, -1.1]);
    for (k, x) in state.activation.iter_mut().enumerate() {
        *x = 0.2 * (1.0 + k as f64).sin();
    }
    state
}

const INTEGRATORS: [Integrator; 4] = [
    Integrator::SemiImplicitEuler,
    Integrator::ImplicitVelocity,
    Integrator::RungeKutta4,
    Integrator::ImplicitMidpoint,
];

/// Position of the mass of a motor without loop, after so many steps, of the force that it had.
fn forces(activation: Activation, inputs: &[f64]) -> Vec<f64> {
    let simulator = Simulator::new(samples::pendulum().with_gravity([0.0; 3].into()))
        .with_time_step(DT)
        .with_activation("pivot", activation)
        .expect("the pivot");
    let mut state: State = simulator.neutral_state();
    let mut out = Vec::new();
    for &u in inputs {
        let next = simulator.step(&state, &[u]);
        // J = 1/3 kg·m²
        out.push((next.v[0] - state.v[0]) / (3.0 * DT));
        state = next;
    }
    out
}

fn assert_near(found: &[f64], expected: &[f64], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (k, (x, y)) in found.iter().zip(expected).enumerate() {
        let error = (x - y).abs() / (1.0 + y.abs());
        assert!(error < SAME, "{what}, {k}: {x} for {y}");
    }
}

#[test]
fn each_kind_gives_the_forces_of_its_closed_form() {
    let inputs = [1.0, 2.0, -3.0, 0.5, 0.5, 4.0];
    let late = forces(Activation::delay(2), &inputs);
    assert_near(&late, &[0.0, 0.0, 1.0, 2.0, -3.0, 0.5], "delay");
    let constant = [1.5; 8];
    let lag = forces(Activation::filter(0.02), &constant);
    let expected: Vec<f64> = (0..8)
        .map(|k| 1.5 * (1.0 - (-0.5 * f64::from(k)).exp()))
        .collect();
    assert_near(&lag, &expected, "filter");
    let early = forces(Activation::filter(0.02).early(), &constant);
    assert_near(&early[..7], &expected[1..], "early filter");
    let euler = forces(Activation::explicit_filter(0.02), &constant);
    let expected: Vec<f64> = (0..8).map(|k| 1.5 * (1.0 - 0.5_f64.powi(k))).collect();
    assert_near(&euler, &expected, "explicit filter");
    let integrator = Activation::integrator()
        .with_range(-1.0, 0.04)
        .with_input_range(-1.0, 1.0);
    let integral = forces(integrator, &constant);
    let expected: Vec<f64> = (0..8).map(|k| (0.01 * f64::from(k)).min(0.04)).collect();
    assert_near(&integral, &expected, "integrator");
    // Steps of any length: the filter is there after one of a thousand time constants.
    let stiff = forces(Activation::filter(1e-5), &[2.0, 2.0]);
    assert_near(&stiff, &[0.0, 2.0], "stiff filter");
}

#[test]
fn jacobians_equal_finite_differences_with_every_integrator() {
    for (name, activation) in kinds() {
        for integrator in INTEGRATORS {
            let simulator = simulator(activation.clone(), integrator);
            let (state, u) = (state(&simulator), [0.4, -0.8]);
            let exact = simulator.linearize(&state, &u);
            let options = finite_difference::Options::default();
            let found = simulator.estimate_linearization(&state, &u, &options);
            for (exact, found, error) in [
                (&exact.a, &found.linearization.a, &found.error.a),
                (&exact.b, &found.linearization.b, &found.error.b),
            ] {
                let all = exact.iter().zip(found).zip(error);
                for ((x, y), e) in all {
                    let bound = 1e-9 + 10.0 * e;
                    assert!(
                        (x - y).abs() < bound,
                        "{name}, {integrator:?}: {x} for {y} ± {e}"
                    );
                }
            }
        }
    }
}

#[test]
fn gradients_equal_products_with_jacobians_and_derivatives_in_all_parameters() {
    for (name, activation) in kinds() {
        for integrator in INTEGRATORS {
            let simulator = simulator(activation.clone(), integrator);
            let (state, u) = (state(&simulator), [0.4, -0.8]);
            let n = simulator.n_tangent();
            let lambda: Vec<f64> = (0..n).map(|k| (0.7 + k as f64).cos()).collect();
            let mut out = StepGradient::zeros(&simulator);
            let mut scratch = VjpScratch::new(&simulator);
            simulator.vjp_into(&state, &u, &lambda, &mut scratch, &mut out);
            let step = simulator.linearize(&state, &u);
            let weights = DVector::from_column_slice(&lambda);
            let what = format!("{name}, {integrator:?}");
            assert_near(
                out.state.as_slice(),
                (step.a.transpose() * &weights).as_slice(),
                &what,
            );
            assert_near(
                out.input.as_slice(),
                (step.b.transpose() * &weights).as_slice(),
                &what,
            );
            let parameters = simulator.parameters();
            let layout = simulator.parameter_layout();
            for (group, range) in layout.groups() {
                let text = format!("{group:?}");
                if !text.contains("Activation") && !text.contains("TimeStep") {
                    continue;
                }
                for k in range.clone() {
                    let seeded: Vec<_> = (parameters.iter().enumerate())
                        .map(|(l, &x)| Dual::<f64, 1>::new(x, [f64::from(u8::from(l == k))]))
                        .collect();
                    let lifted = simulator.with_parameters(&seeded);
                    let next = lifted.step(&state.cast(), &u.map(Dual::from));
                    let base: State<Dual<f64, 1>> = simulator.step(&state, &u).cast();
                    let change = next.deviation(simulator.model(), &base);
                    let slope: f64 = change.iter().zip(&lambda).map(|(x, w)| x.eps[0] * w).sum();
                    let error = (slope - out.parameters[k]).abs();
                    let of = &layout.names()[k];
                    assert!(
                        error < 1e-10 * (1.0 + slope.abs()),
                        "{what}, {of}: {error:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_network_looks_at_errors_and_velocities_of_its_ages() {
    let simulator = Simulator::new(samples::pendulum())
        .with_time_step(DT)
        .with_activation("pivot", Activation::function(layers(), &[]))
        .expect("the pivot");
    let mut state = simulator.state(&[0.2], &[-0.3]);
    let mut seen = vec![[0.0; 2]; 2];
    for k in 0..5 {
        let u = (0.7 * f64::from(k)).sin();
        seen.push([u - state.q[0], state.v[0]]);
        let [then, .., now] = &seen[seen.len() - 3..] else {
            panic!("three steps")
        };
        let [error, old_error, v, old_v] = [now[0], then[0], now[1], then[1]];
        let soft = |x: f64| x / (1.0 + x.abs());
        let first = soft(error + 0.5 * old_error - 0.2 * v + 0.1 * old_v + 0.1);
        let second = soft(0.3 * error - 0.4 * old_error + 0.1 * v + 0.2 * old_v - 0.2);
        let torque = 4.0 * first - 3.0 * second + 0.05;
        // J = 1/3 kg·m², and gravity m g l/2 sin q
        let a = 3.0 * (torque - 0.5 * 9.81 * state.q[0].sin());
        let next = simulator.step(&state, &[u]);
        assert!((next.v[0] - state.v[0] - DT * a).abs() < SAME, "step {k}");
        state = next;
    }
}

#[test]
#[should_panic(expected = "expected 2 columns")]
fn a_network_whose_layers_do_not_fit_is_refused() {
    let _ = ActuatorNetwork::new(vec![(dmatrix![1.0], vec![0.0])], &[0]);
}

#[test]
#[should_panic(expected = "looks back at most 16 steps")]
fn a_network_that_looks_back_too_far_is_refused() {
    let _ = ActuatorNetwork::new(vec![(dmatrix![1.0, 1.0], vec![0.0])], &[17]);
}

// Second derivatives through the function of a user: those of the first ones by differences.
#[test]
fn jacobians_over_dual_numbers_are_those_of_a_moved_state() {
    let activation = Activation::function(Network, &[3.0, 0.04]).with_delay(1);
    let simulator = simulator(activation, Integrator::SemiImplicitEuler);
    let (state, u) = (state(&simulator), [0.4, -0.8]);
    let along = |h: f64| {
        let dx: Vec<f64> = (0..simulator.n_tangent())
            .map(|k| h * (k as f64).cos())
            .collect();
        simulator
            .linearize(&state.integrate(simulator.model(), &dx), &u)
            .a
    };
    let lifted: State<Dual<f64, 1>> = state.cast();
    let dx: Vec<_> = (0..simulator.n_tangent())
        .map(|k| Dual::<f64, 1>::new(0.0, [(k as f64).cos()]))
        .collect();
    let moved = lifted.integrate(simulator.model(), &dx);
    let exact = simulator.linearize(&moved, &u.map(Dual::from)).a;
    let h = 1e-5;
    let difference = (along(h) - along(-h)) / (2.0 * h);
    for (x, y) in exact.iter().zip(&difference) {
        assert!(
            (x.eps[0] - y).abs() < 1e-7 * (1.0 + y.abs()),
            "{} for {y}",
            x.eps[0]
        );
    }
}

#[test]
fn batches_and_rollouts_equal_single_steps() {
    for (name, activation) in kinds() {
        let simulator = simulator(activation, Integrator::SemiImplicitEuler);
        let start = state(&simulator);
        let rollout = simulator.rollout(&start, 20, |t, _, u| {
            u[0] = (7.0 * t).sin();
            u[1] = 0.3;
        });
        let mut batch = BatchSimulator::new(simulator.clone(), 3);
        let mut states = batch.states(&vec![start.clone(); 3]);
        let mut scratch = StepScratch::new(&simulator);
        let (mut single, mut next) = (start.clone(), start.clone());
        for u in &rollout.inputs {
            let inputs: Vec<f64> = u.iter().copied().cycle().take(6).collect();
            batch.step(&mut states, &inputs);
            simulator.step_into(&single, u.as_slice(), &mut scratch, &mut next);
            std::mem::swap(&mut single, &mut next);
        }
        assert_eq!(*rollout.last(), single, "{name}");
        assert_eq!(states.state(1), single, "{name}");
    }
}

#[test]
fn a_reading_of_the_step_is_that_of_the_signal() {
    use dualbody::sim::{Sensor, Sensors};
    let simulator = Simulator::new(samples::pendulum()).with_time_step(DT);
    let pivot = simulator.model().find_joint("pivot").expect("the pivot");
    let delayed = simulator
        .with_activation("pivot", Activation::delay(1))
        .expect("the pivot");
    let sensors = Sensors::new(delayed.model(), [("torque", Sensor::JointForce(pivot))]);
    let state = delayed
        .state(&[0.4], &[0.0])
        .with_activation(DVector::from_element(1, 2.5));
    assert!((sensors.read(&delayed, &state, &[7.0])[0] - 2.5).abs() < SAME);
    let a = delayed.acceleration(&state, &[7.0]);
    assert!((delayed.step(&state, &[7.0]).v[0] - DT * a[0]).abs() < SAME);
}

#[test]
fn activations_keep_to_their_inputs_when_these_move() {
    let simulator = Simulator::new(samples::cartpole())
        .with_activation("pivot", Activation::filter(0.1))
        .expect("the pivot");
    let alone = simulator
        .clone()
        .with_actuated_joints(&["pivot"])
        .expect("the joint");
    let state = alone.neutral_state();
    assert!(alone.step(&state, &[1.0]).activation[0] > 0.0);
    let step = alone.linearize(&state, &[1.0]);
    assert_eq!((step.a.nrows(), step.b.ncols()), (5, 1));
    assert_eq!(alone.tangent_names()[4], "activation0");
    let error = simulator
        .with_activation("elbow", Activation::delay(1))
        .unwrap_err();
    assert!(error.to_string().contains("elbow"), "{error}");
}

#[test]
#[should_panic(expected = "which is not an input any more")]
fn an_activation_without_its_input_is_refused() {
    let simulator = Simulator::new(samples::cartpole())
        .with_activation("pivot", Activation::filter(0.1))
        .expect("the pivot");
    let _ = simulator.with_actuated_joints(&["linear"]);
}

#[test]
#[should_panic(expected = "a delay of 100001 steps")]
fn a_delay_out_of_proportion_is_refused() {
    let _ = Activation::delay(100_001);
}

#[test]
#[should_panic(expected = "the time constant of an activation is 0")]
fn a_time_constant_of_zero_is_refused() {
    let _ = Activation::filter(0.0);
}

#[test]
#[should_panic(expected = "the numbers of an activation go from 1 to -1")]
fn ends_that_are_not_in_order_are_refused() {
    let _ = Activation::integrator().with_range(1.0, -1.0);
}

#[test]
#[should_panic(expected = "the activations of \"cartpole\" have 1 entries")]
fn a_state_without_activations_is_refused() {
    let simulator = Simulator::new(samples::cartpole())
        .with_activation("pivot", Activation::filter(0.1))
        .expect("the pivot");
    simulator.step(&State::new(&[0.0; 2], &[0.0; 2]), &[0.0; 2]);
}
