//! Servos on frames against closed forms, servos on joints, finite differences and `MuJoCo`.

use dualbody::autodiff::finite_difference;
use dualbody::constraint::Anchor;
use dualbody::joint::JointKind;
use dualbody::model::{JointSpec, LinkSpec, Model, ModelBuilder, samples};
use dualbody::sim::{Actuation, Actuator, ExternalForce, FrameActuator, Servo};
use dualbody::spatial::{Force, Representation};
use dualbody::{Integrator, ModelOptions, Simulator, State};
use nalgebra::{DMatrix, DVector};

use crate::servos::Step;

const ALL: [Integrator; 3] = [
    Integrator::SemiImplicitEuler,
    Integrator::ImplicitVelocity,
    Integrator::RungeKutta4,
];

fn wave(n: usize, phase: f64, size: f64) -> Vec<f64> {
    (0..n)
        .map(|k| size * (1.3 * k as f64 + phase).sin())
        .collect()
}

fn servo_on(place: Anchor, wrench: [f64; 6], by: Representation, servo: Servo) -> FrameActuator {
    let name = format!("{by:?} {wrench:?}");
    FrameActuator::new(name, place, Force::from_array(wrench), by).with_servo(servo)
}

const ALONG_X: [f64; 6] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];

/// A free ball of 2 kg.
fn ball() -> Model {
    let mut builder = ModelBuilder::new("ball");
    builder.add_link(LinkSpec::new("ball").with_mass(2.0, [0.0; 3], [0.1; 3]));
    builder
        .build()
        .expect("a ball")
        .with_gravity([0.0; 3].into())
}

// m (v⁺ − v) / Δt = k (u − x − Δt v⁺) − d v⁺, and a bound of the force.
#[test]
fn step_of_a_ball_is_that_of_a_spring_and_damper_at_its_end() {
    let place = Anchor::frame(&ball(), "ball").expect("a link");
    for (k, d, dt) in [
        (1e4, 0.0, 0.01),
        (1e4, 50.0, 0.01),
        (3.0, 1.0, 1e-3),
        (1e7, 1e4, 0.1),
    ] {
        let own = servo_on(place, ALONG_X, Representation::Mixed, Servo::position(k, d));
        let simulator = Simulator::new(ball())
            .with_frame_actuators(vec![own])
            .with_time_step(dt);
        let mut state: State = simulator.neutral_state();
        (state.q[0], state.v[0]) = (0.2, -0.7);
        let next = simulator.step(&state, &[0.5]);
        let expected = (2.0 * -0.7 / dt + k * (0.5 - 0.2)) / (2.0 / dt + k * dt + d);
        assert!(
            (next.v[0] - expected).abs() < 1e-9 * expected.abs(),
            "{} {expected}",
            next.v[0]
        );
        // The explicit force would throw it out.
        let end = simulator.rollout(&state, 3000, |_, _, u| u[0] = 0.5);
        let end = end.last();
        assert!(
            d < 10.0 || (end.q[0] - 0.5).abs() < 1e-3,
            "{k} {d}: {}",
            end.q[0]
        );
        assert!(end.q[0].abs() < 2.0);
    }
    let bounded = Servo::position(1e4, 0.0).with_force_range(-1.0, 6.0);
    let own = servo_on(place, ALONG_X, Representation::Mixed, bounded);
    let simulator = Simulator::new(ball())
        .with_frame_actuators(vec![own])
        .with_time_step(0.01);
    for (u, force) in [(3.0, 6.0), (-3.0, -1.0)] {
        let next = simulator.step(&simulator.neutral_state(), &[u]);
        assert!((next.v[0] - 0.01 * force / 2.0).abs() < 1e-12);
    }
}

/// Slide along x, then along y.
fn carriages() -> Model {
    let mut builder = ModelBuilder::new("carriages");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("a").with_mass(1.0, [0.0; 3], [0.1; 3]));
    builder.add_link(LinkSpec::new("b").with_mass(2.0, [0.0; 3], [0.1; 3]));
    builder.add_joint(
        JointSpec::new("x", JointKind::Prismatic, "world", "a").with_axis([1.0, 0.0, 0.0]),
    );
    builder
        .add_joint(JointSpec::new("y", JointKind::Prismatic, "a", "b").with_axis([0.0, 1.0, 0.0]));
    builder
        .build()
        .expect("carriages")
        .with_gravity([0.0; 3].into())
}

#[test]
fn servo_along_the_axis_of_a_joint_is_that_of_the_joint() {
    let model = carriages();
    let place = Anchor::frame(&model, "b")
        .expect("a link")
        .moved([0.0, 0.3, 0.1]);
    let along_y = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
    for servo in [
        Servo::position(300.0, 10.0),
        Servo::position(300.0, 10.0).with_gear(-1.5),
        Servo::position(400.0, 5.0).with_force_range(-0.3, 0.4),
        Servo::velocity(30.0).with_input_range(-0.2, 0.1),
        Servo::torque(2.0),
    ] {
        let free = Simulator::new(model.clone()).with_time_step(0.01);
        let free = free.with_actuated_joints(&[]).expect("none");
        let actuator = Actuator {
            servo: Some(servo),
            ..Actuator::default()
        };
        let actuation = Actuation::ideal(&model).with_actuator(&model, "y", actuator);
        let on_joint = free.clone().with_actuated_joints(&["y"]).expect("a joint");
        let on_joint = on_joint.with_actuation(actuation.expect("a joint"));
        let shift = 0.3 * servo.gear * servo.position_gain;
        let servo = Servo {
            bias: shift,
            ..servo
        };
        let on_frame =
            free.with_frame_actuators(vec![servo_on(place, along_y, Representation::Mixed, servo)]);
        let state = State::new(&[0.1, -0.2], &[0.3, 0.6]);
        for u in [-0.19, 0.4, -1.0] {
            let (a, b) = (
                on_joint.linearize(&state, &[u]),
                on_frame.linearize(&state, &[u]),
            );
            let next = on_joint.step(&state, &[u]).v - on_frame.step(&state, &[u]).v;
            let errors = [next.amax(), (&a.a - &b.a).amax(), (&a.b - &b.b).amax()];
            assert!(
                errors.iter().all(|x| *x < 1e-10),
                "{servo:?} {u}: {errors:?}"
            );
        }
    }
}

/// Servos of all representations on two frames of an arm, with motors of its joints and a force.
fn crossing(integrator: Integrator) -> (Simulator, State, Vec<f64>) {
    let model = samples::arm();
    let n = model.nv();
    let links = model.link_names();
    let [tip, middle] = [links.len() - 1, links.len() - 2].map(|k| {
        let place = Anchor::frame(&model, links[k]).expect("a link");
        place.moved([0.1, -0.2, 0.3])
    });
    let servos = vec![
        servo_on(
            tip,
            [0.7, -0.3, 0.4, 0.0, 0.0, 0.0],
            Representation::Mixed,
            Servo::position(300.0, 10.0).with_gear(-1.5),
        ),
        servo_on(
            tip,
            [0.0, 0.2, 0.0, 0.5, 0.6, -0.2],
            Representation::Mixed,
            Servo::position(40.0, 2.0),
        ),
        servo_on(
            middle,
            [0.5, 0.0, 1.0, 0.0, 0.3, 0.0],
            Representation::Body,
            Servo::velocity(20.0),
        )
        .with_limits(-0.1, 0.1),
        servo_on(
            tip,
            [0.3, 1.0, 0.0, 0.2, 0.0, 0.1],
            Representation::Inertial,
            Servo::velocity(15.0),
        ),
        servo_on(
            middle,
            [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
            Representation::Mixed,
            Servo::position(400.0, 5.0).with_force_range(-0.3, 0.4),
        ),
        FrameActuator::new(
            "push",
            tip,
            Force::from_array(ALONG_X),
            Representation::Mixed,
        ),
    ];
    let load = ExternalForce::constant(middle, Force::from_array([0.1; 6]), Representation::Mixed);
    let count = servos.len();
    // Explicit steps do not bear these gains on light links for longer.
    let step = match integrator {
        Integrator::RungeKutta4 => 1e-4,
        _ => 0.01,
    };
    let simulator = Simulator::new(model)
        .with_time_step(step)
        .with_integrator(integrator)
        .with_external_forces(vec![load])
        .with_frame_actuators(servos);
    let state = State::new(&wave(n, 0.2, 0.4), &wave(n, 1.0, 0.5));
    let u = wave(n + count, 0.5, 0.3);
    (simulator, state, u)
}

#[test]
fn jacobians_with_servos_on_frames_equal_finite_differences() {
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
fn gradients_in_numbers_of_servos_on_frames_equal_central_differences() {
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
        // Differences by these steps are too coarse for the small inertias of the hand where nothing but they resists.
        let first = match integrator {
            Integrator::RungeKutta4 => simulator.model().parameters().len(),
            _ => 0,
        };
        for k in first..parameters.len() {
            // A gain below zero is that of the start.
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
        assert!(compared > 60, "{compared}");
    }
}

// A free body that turns: directions of its tangent space.
#[test]
fn jacobians_of_a_floating_body_equal_finite_differences() {
    let model = ball();
    let place = Anchor::frame(&model, "ball")
        .expect("a link")
        .moved([0.1, 0.2, -0.3]);
    let servos: Vec<FrameActuator> = [
        Representation::Mixed,
        Representation::Body,
        Representation::Inertial,
    ]
    .into_iter()
    .flat_map(|by| {
        let stiff = if by == Representation::Mixed {
            200.0
        } else {
            0.0
        };
        let servo = Servo {
            position_gain: stiff,
            ..Servo::velocity(8.0)
        };
        [
            [0.6, -0.2, 0.4, 0.0, 0.0, 0.0],
            [0.1, 0.0, 0.0, 0.3, -0.5, 0.7],
        ]
        .map(|w| servo_on(place, w, by, servo))
    })
    .collect();
    for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
        let simulator = Simulator::new(model.clone())
            .with_frame_actuators(servos.clone())
            .with_integrator(integrator)
            .with_time_step(0.01);
        let mut start: State = simulator.neutral_state();
        start.q = model.integrate(start.q.as_slice(), &wave(6, 0.4, 0.6));
        start.v = DVector::from_vec(wave(6, 2.0, 0.8));
        let u = wave(6, 0.1, 0.5);
        let step = simulator.linearize(&start, &u);
        let moved = |k: usize, by: f64| {
            let mut state = start.clone();
            let mut dx = [0.0; 12];
            dx[k] = by;
            state.q = model.integrate(state.q.as_slice(), &dx[..6]);
            (0..6).for_each(|i| state.v[i] += dx[6 + i]);
            simulator.step(&state, &u)
        };
        for k in 0..12 {
            let h = 1e-6;
            let slope = moved(k, h).deviation(&model, &moved(k, -h)) / (2.0 * h);
            let error = (step.a.column(k) - slope.rows(0, 12)).amax();
            assert!(
                error < 1e-6 * step.a.amax(),
                "{integrator:?} {k}: {error:e}"
            );
        }
    }
}

#[test]
#[should_panic(expected = "the implicit midpoint rule does not simulate")]
fn servos_on_frames_are_refused_by_the_implicit_midpoint_rule() {
    let (simulator, ..) = crossing(Integrator::SemiImplicitEuler);
    let _ = simulator.with_integrator(Integrator::ImplicitMidpoint);
}

// (v⁺ − v) / Δt of MuJoCo 4.0 with integrator="implicit": velocity of the origin in the world, and angular velocity in the body.
const MUJOCO: [(f64, [f64; 6]); 2] = [
    (
        1e-4,
        [
            -6.50530842e-3,
            4.88098233e-1,
            -1.09478836,
            -1.47988893e1,
            -4.87900061,
            8.48368646,
        ],
    ),
    (
        1e-5,
        [
            -6.65780058e-3,
            4.89996627e-1,
            -1.10017771,
            -1.48665278e1,
            -4.90246643,
            8.52093401,
        ],
    ),
];

#[test]
fn servos_on_a_site_equal_those_of_mujoco_to_first_order_in_the_step() {
    let xml = r#"<mujoco><option gravity="0 0 0"/><worldbody>
      <body name="b" pos="0 0 1"><freejoint/><inertial pos="0.1 0 0" mass="2" diaginertia="0.1 0.2 0.15"/><site name="s" pos="0.2 -0.1 0.3" euler="20 -30 40"/></body></worldbody>
      <actuator><general site="s" gear="0.5 -0.2 0.7 0.3 0.1 -0.4" gainprm="4" biastype="affine" biasprm="0.5 -3 -6" ctrlrange="-1 1"/>
      <velocity site="s" gear="0 1 0 0 0 0.5" kv="9"/></actuator></mujoco>"#;
    let (scene, report) = ModelOptions::default()
        .load_mjcf_scene_str(xml)
        .expect("a body");
    assert!(report.ignored.is_empty(), "{report}");
    let own = scene.simulator();
    assert_eq!(own.frame_actuators().len(), 2);
    let same = Simulator::from_mjcf_str(xml).expect("the same");
    let mut state: State = own.neutral_state();
    assert_eq!(
        same.step(&state, &[0.5, 0.1]),
        own.step(&state, &[0.5, 0.1])
    );
    let mut q = [0.1, -0.2, 1.3, 0.8, 0.2, -0.4, 0.4];
    let norm = q[3..].iter().map(|x| x * x).sum::<f64>().sqrt();
    q[3..].iter_mut().for_each(|x| *x /= norm);
    state.q.copy_from_slice(&q);
    let body = Anchor::frame(own.model(), "b").expect("a link");
    let turn = |state: &State| body.pose_in_world(own.model(), state.q.as_slice()).rotation;
    let world = nalgebra::Vector3::new(0.3, -0.6, 0.2);
    let in_body = turn(&state).transpose() * world;
    state.v.rows_mut(0, 3).copy_from(&in_body);
    state.v.rows_mut(3, 3).copy_from_slice(&[1.1, -0.7, 0.5]);
    let errors = MUJOCO.map(|(dt, expected)| {
        let next = own.clone().with_time_step(dt).step(&state, &[0.4, -0.3]);
        let linear = (turn(&next) * next.v.fixed_rows::<3>(0) - world) / dt;
        let angular = (next.v.rows(3, 3) - state.v.rows(3, 3)) / dt;
        let found = linear.iter().chain(angular.iter());
        found
            .zip(expected)
            .map(|(x, y)| (x - y).abs())
            .fold(0.0, f64::max)
    });
    // MuJoCo's forces contain damping of the end of the step without its other parts: the difference is of first order.
    assert!(
        errors[0] < 0.02 && errors[1] < 0.2 * errors[0],
        "{errors:?}"
    );
}
