//! Servos on tendons against those on joints, finite differences and the equations of a step.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use dualbody::autodiff::finite_difference;
use dualbody::dynamics::mass_matrix;
use dualbody::model::samples;
use dualbody::sim::{Actuation, Actuator, Servo, TendonServo};
use dualbody::{Integrator, Model, Simulator, State};
use nalgebra::{DMatrix, DVector};

use crate::common::OTHER_ALGORITHM;
use crate::servos::Step;

const ALL: [Integrator; 3] = [
    Integrator::SemiImplicitEuler,
    Integrator::ImplicitVelocity,
    Integrator::RungeKutta4,
];

fn arm() -> Model {
    samples::arm()
}

/// A servo with gains, one with a range that it reaches, and a motor.
fn servos() -> [Servo; 3] {
    [
        Servo::position(300.0, 10.0).with_gear(-1.5),
        Servo::position(400.0, 5.0).with_force_range(-0.3, 0.4),
        Servo::torque(3.0).with_input_range(-0.5, 0.05),
    ]
}

fn tendon(model: &Model, name: &str, joints: &[(usize, f64)], servo: Servo) -> TendonServo {
    let names = model.joint_names();
    let joints: Vec<(&str, f64)> = joints.iter().map(|&(k, c)| (names[k], c)).collect();
    TendonServo::new(model, name, &joints, servo).expect("joints")
}

fn wave(n: usize, phase: f64, size: f64) -> Vec<f64> {
    (0..n)
        .map(|k| size * (1.3 * k as f64 + phase).sin())
        .collect()
}

#[test]
fn a_tendon_on_one_joint_is_the_servo_of_that_joint() {
    let model = arm();
    let (n, joint) = (model.nv(), model.joint_names()[2].to_owned());
    // Implicit velocity forces are those of a motion that rows are not part of.
    let exact = [ALL[0], ALL[2]];
    for (servo, integrator) in servos().into_iter().flat_map(|s| exact.map(|by| (s, by))) {
        let free = Simulator::new(model.clone())
            .with_actuated_joints(&[])
            .expect("no joints")
            .with_time_step(0.01)
            .with_integrator(integrator);
        let actuator = Actuator {
            servo: Some(servo),
            ..Actuator::default()
        };
        let actuation = Actuation::ideal(&model).with_actuator(&model, &joint, actuator);
        let on_joint = free
            .clone()
            .with_actuated_joints(&[&joint])
            .expect("a joint")
            .with_actuation(actuation.expect("a joint"));
        let on_tendon = free.with_tendon_servos(vec![tendon(&model, "t", &[(2, 1.0)], servo)]);
        assert_eq!(
            (on_tendon.nu(), on_tendon.input_names()),
            (1, vec!["t".into()])
        );
        let state = State::new(&wave(n, 0.2, 0.4), &wave(n, 1.0, 0.5));
        let u = [state.q[2] + 0.01];
        let (a, b) = (on_joint.step(&state, &u), on_tendon.step(&state, &u));
        let (da, db) = (
            on_joint.linearize(&state, &u),
            on_tendon.linearize(&state, &u),
        );
        let errors = [
            (a.v - b.v).amax(),
            (&da.a - db.a).amax() / da.a.amax(),
            (&da.b - db.b).amax() / da.b.amax().max(1e-3),
        ];
        for error in errors {
            assert!(
                error < OTHER_ALGORITHM * 10.0,
                "{servo:?} {integrator:?}: {errors:?}"
            );
        }
    }
}

// M (v⁺ − v) / Δt = M a₀ + c F(L + Δt L̇⁺, L̇⁺) with the acceleration a₀ of the robot without the servo.
#[test]
fn gains_along_a_tendon_act_at_the_end_of_the_step() {
    let model = arm();
    let n = model.nv();
    let servo = Servo::position(1e4, 40.0).with_gear(0.5);
    let pulled = tendon(&model, "t", &[(0, 0.7), (2, -1.1)], servo);
    let simulator = Simulator::new(model.clone())
        .with_time_step(0.01)
        .with_tendon_servos(vec![pulled]);
    let (q, v) = (wave(n, 0.2, 0.4), wave(n, 1.0, 0.5));
    let state = State::new(&q, &v);
    let mut u = vec![0.0; n + 1];
    u[n] = 0.3;
    let next = simulator.step(&state, &u);
    let free = simulator.clone().with_tendon_servos(Vec::new());
    let other = free.step(&state, &u[..n]);
    let M = mass_matrix(&model, &q);
    let length = |q: &DVector<f64>| 0.7 * q[0] - 1.1 * q[2];
    let force = 0.5 * 1e4 * (0.3 - 0.5 * length(&next.q)) - 0.25 * 40.0 * length(&next.v);
    let mut along = DVector::zeros(n);
    (along[0], along[2]) = (0.7, -1.1);
    let missing = M * (&next.v - other.v) / 0.01 - along * force;
    assert!(missing.amax() < 1e-7 * force.abs().max(1.0), "{missing}");
}

/// Three servos on tendons that cross one another, with those of joints.
fn crossing(integrator: Integrator) -> (Simulator, State, Vec<f64>) {
    let model = arm();
    let n = model.nv();
    let [one, two, three] = servos();
    let pulled = vec![
        tendon(&model, "a", &[(0, 0.7), (1, -0.4), (2, 1.1)], one),
        tendon(&model, "b", &[(1, 1.0), (2, 0.6)], two).with_effort(0.35),
        tendon(&model, "c", &[(0, -1.0), (2, 0.3)], three),
    ];
    let bounded = Actuator {
        servo: Some(Servo::position(200.0, 3.0)),
        effort: Some(0.5),
        ..Actuator::default()
    };
    let joint = model.joint_names()[1].to_owned();
    let actuation = Actuation::ideal(&model).with_actuator(&model, &joint, bounded);
    let simulator = Simulator::new(model)
        .with_actuation(actuation.expect("a joint"))
        .with_time_step(0.01)
        .with_integrator(integrator)
        .with_tendon_servos(pulled);
    let state = State::new(&wave(n, 0.2, 0.4), &wave(n, 1.0, 0.5));
    let u = wave(n + 3, 0.5, 0.3);
    (simulator, state, u)
}

#[test]
fn jacobians_with_tendons_equal_finite_differences() {
    for integrator in ALL {
        let (simulator, state, u) = crossing(integrator);
        let step = simulator.linearize(&state, &u);
        let x: Vec<f64> = state.q.iter().chain(&state.v).chain(&u).copied().collect();
        let expected = finite_difference::jacobian(&Step(simulator), &x);
        let found = DMatrix::from_iterator(
            expected.nrows(),
            expected.ncols(),
            step.a.iter().chain(&step.b).copied(),
        );
        let error = (found - &expected).amax() / expected.amax();
        assert!(error < 1e-6, "{integrator:?}: {error:e}");
    }
}

#[test]
fn gradients_in_numbers_of_tendons_equal_central_differences() {
    for integrator in ALL {
        let (simulator, state, u) = crossing(integrator);
        let weights = DVector::from_vec(wave(2 * simulator.model().nv(), 0.7, 1.0));
        let gradient = simulator.vjp(&state, &u, weights.as_slice());
        let parameters = simulator.parameters();
        let layout = simulator.parameter_layout();
        let weighted = |k: usize, by: f64| {
            let mut moved = parameters.clone();
            moved[k] += by;
            let next = simulator.with_parameters(moved.as_slice()).step(&state, &u);
            let all = next.q.iter().chain(next.v.iter());
            all.zip(&weights).map(|(x, w)| x * w).sum::<f64>()
        };
        let mut compared = 0;
        for k in simulator.model().parameters().len()..parameters.len() {
            // Gains turn from those of the step's start to those of its end where they are 0.
            if parameters[k] == 0.0 && layout.names()[k].contains("gain") {
                continue;
            }
            let by = 1e-5 * parameters[k].abs().max(0.1);
            let expected = (weighted(k, by) - weighted(k, -by)) / (2.0 * by);
            let error = (gradient.parameters[k] - expected).abs();
            compared += usize::from(expected != 0.0);
            assert!(
                error < 1e-6 * expected.abs().max(1.0),
                "{integrator:?} {}: {} {expected}",
                layout.names()[k],
                gradient.parameters[k]
            );
        }
        assert!(compared > 15, "{compared}");
    }
}

#[test]
#[should_panic(expected = "the implicit midpoint rule does not simulate")]
fn gains_along_tendons_are_refused_by_the_implicit_midpoint_rule() {
    let (simulator, ..) = crossing(Integrator::SemiImplicitEuler);
    let _ = simulator.with_integrator(Integrator::ImplicitMidpoint);
}
