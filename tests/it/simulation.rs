//! Integrators, rollouts, actuation.

use dualbody::dynamics::{frame_velocity, kinetic_energy, potential_energy};
use dualbody::joint::JointKind;
use dualbody::model::{JointSpec, LinkSpec, ModelBuilder, samples};
use dualbody::sim::RolloutStatus;
use dualbody::spatial::Representation;
use dualbody::{Integrator, InvalidState, Model, Simulator, State};
use nalgebra::DVector;

use crate::common::{
    ROUNDING, SAME_ALGEBRA, asset, floating_robot, free_body, generator, random_point, robots,
    statue,
};

/// Distance between two states in tangent coordinates.
fn distance(model: &Model, a: &State, b: &State) -> f64 {
    let dq = model.difference(a.q.as_slice(), b.q.as_slice());
    (dq.norm_squared() + (&b.v - &a.v).norm_squared()).sqrt()
}

/// The state after `duration` seconds in `steps` steps.
fn simulate(
    model: &Model,
    start: &State,
    integrator: Integrator,
    duration: f64,
    steps: usize,
) -> State {
    let simulator = Simulator::new(model.clone())
        .with_integrator(integrator)
        .with_time_step(duration / steps as f64);
    simulator
        .rollout(start, steps, |_, _, u| u.fill(0.1))
        .last()
        .clone()
}

/// Robots with every joint kind, with gentle motions.
fn moving_robots() -> Vec<(Model, State)> {
    let mut out = Vec::new();
    for model in [
        samples::cartpole(),
        samples::double_pendulum(),
        free_body(),
        floating_robot(),
        samples::random_tree(6, 2),
    ] {
        let point = random_point(&model, 4);
        out.push((model, State::new(point.q.as_slice(), point.v.as_slice())));
    }
    out
}

/// The order p from errors at two step sizes: error ∝ hᵖ.
fn observed_order(model: &Model, start: &State, integrator: Integrator, steps: usize) -> f64 {
    const DURATION: f64 = 0.1;
    let reference = simulate(model, start, Integrator::RungeKutta4, DURATION, 64 * steps);
    let error = |steps| {
        distance(
            model,
            &simulate(model, start, integrator, DURATION, steps),
            &reference,
        )
    };
    (error(steps) / error(2 * steps)).log2()
}

#[test]
fn semi_implicit_euler_is_of_first_order() {
    for (model, start) in moving_robots() {
        let order = observed_order(&model, &start, Integrator::SemiImplicitEuler, 200);
        assert!((order - 1.0).abs() < 0.1, "{}: order {order}", model.name());
    }
}

#[test]
fn runge_kutta_4_is_of_fourth_order_on_every_joint_kind() {
    for (model, start) in moving_robots() {
        let order = observed_order(&model, &start, Integrator::RungeKutta4, 10);
        assert!((order - 4.0).abs() < 0.3, "{}: order {order}", model.name());
    }
}

#[test]
fn energy_of_a_free_double_pendulum_stays_within_1e_6_over_ten_seconds() {
    let simulator = Simulator::new(samples::double_pendulum())
        .with_time_step(1e-3)
        .with_integrator(Integrator::RungeKutta4);
    let model = simulator.model();
    let energy = |s: &State| {
        kinetic_energy(model, s.q.as_slice(), s.v.as_slice())
            + potential_energy(model, s.q.as_slice())
    };
    let start = State::new(&[2.0, 0.5], &[0.0, 0.0]);
    let rollout = simulator.rollout(&start, 10_000, |_, _, _| {});
    let initial = energy(&start);
    let drift = rollout
        .states
        .iter()
        .map(|s| (energy(s) - initial).abs())
        .fold(0.0, f64::max);
    assert!(drift < 1e-6, "energy drifts by {drift} J");
}

// Semi-implicit Euler takes the new velocity for the position: v⁺ = v + Δt v̇, q⁺ = q + Δt v⁺.
#[test]
fn semi_implicit_euler_moves_with_the_new_velocity() {
    let simulator = Simulator::new(samples::pendulum()).with_time_step(0.1);
    let next = simulator.step(&State::new(&[0.4], &[0.7]), &[0.2]);
    let v = 0.7 + 0.1 * 3.0 * (0.2 - 0.5 * 9.81 * 0.4_f64.sin());
    assert!(
        (next.v[0] - v).abs() < 10.0 * ROUNDING
            && (next.q[0] - (0.4 + 0.1 * v)).abs() < 10.0 * ROUNDING
    );
}

// m v̇ = −d v: v(t) = v₀ exp(−d t / m)
#[test]
fn viscous_damping_equals_exponential_decay() {
    let mut builder = ModelBuilder::new("slider");
    builder
        .add_link(LinkSpec::new("world"))
        .add_link(LinkSpec::new("block").with_mass(2.0, [0.0; 3], [0.1; 3]));
    builder.add_joint(
        JointSpec::new("slide", JointKind::Prismatic, "world", "block").with_damping(0.5),
    );
    let simulator = Simulator::new(builder.build().expect("a slider"))
        .with_time_step(1e-3)
        .with_integrator(Integrator::RungeKutta4);
    let end = simulator
        .rollout(&State::new(&[0.0], &[3.0]), 2000, |_, _, _| {})
        .last()
        .clone();
    assert!((end.v[0] - 3.0 * (-0.5_f64).exp()).abs() < SAME_ALGEBRA);
}

#[test]
fn inputs_act_on_the_named_joints_only_in_the_given_order() {
    let model = samples::arm();
    let all = Simulator::new(model.clone());
    let some = Simulator::new(model.clone())
        .with_actuated_joints(&["joint5", "joint2"])
        .expect("known joints");
    assert_eq!((all.nu(), some.nu()), (7, 2));
    let state = State::neutral(&model);
    let full = all.step(&state, &[0.0, 0.2, 0.0, 0.0, 0.5, 0.0, 0.0]);
    assert_eq!(some.step(&state, &[0.5, 0.2]), full);
}

#[test]
fn unknown_actuated_joint_is_named_with_those_that_there_are() {
    let error = Simulator::new(samples::cartpole())
        .with_actuated_joints(&["elbow"])
        .expect_err("no elbow");
    let message = error.to_string();
    assert!(
        message.contains("elbow") && message.contains("linear") && message.contains("pivot"),
        "{message}"
    );
}

#[test]
fn floating_base_is_not_actuated() {
    let simulator = Simulator::new(floating_robot());
    assert_eq!(simulator.nu(), simulator.model().nv() - 6);
    assert_eq!(simulator.actuated()[0], 6);
}

#[test]
fn diverging_rollout_ends_with_its_step_and_finite_states() {
    let simulator = Simulator::new(samples::double_pendulum()).with_time_step(1.0);
    let rollout = simulator.rollout(&State::new(&[1.0, 1.0], &[0.0, 0.0]), 1000, |_, s, u| {
        u.iter_mut().zip(&s.v).for_each(|(u, v)| *u = 100.0 * v);
    });
    let RolloutStatus::Diverged { step } = rollout.status else {
        panic!("{:?}", rollout.status)
    };
    assert_eq!(
        (rollout.states.len(), rollout.inputs.len()),
        (step + 1, step)
    );
    assert!(rollout.states.iter().all(State::is_finite));
}

#[test]
fn non_finite_input_ends_the_rollout_with_its_step() {
    let simulator = Simulator::new(samples::pendulum());
    let start = State::new(&[1.0], &[0.0]);
    let rollout = simulator.rollout(&start, 100, |time, _, u| {
        u[0] = if time < 0.0095 { 0.0 } else { f64::NAN }
    });
    assert_eq!(rollout.status, RolloutStatus::NonFiniteInput { step: 10 });
    assert_eq!(rollout.states.len(), 11);
}

#[test]
fn rollout_equals_repeated_steps() {
    for model in robots() {
        let point = random_point(&model, 6);
        let simulator = Simulator::new(model).with_time_step(1e-3);
        let mut state = State::new(point.q.as_slice(), point.v.as_slice());
        let u = vec![0.3; simulator.nu()];
        let rollout = simulator.rollout(&state, 5, |_, _, input| input.copy_from_slice(&u));
        for _ in 0..5 {
            state = simulator.step(&state, &u);
        }
        assert_eq!(*rollout.last(), state);
    }
}

#[test]
fn robot_that_cannot_move_is_simulated() {
    let simulator = Simulator::new(statue());
    let rollout = simulator.rollout(&State::new(&[], &[]), 10, |_, _, _| {});
    assert_eq!(rollout.status, RolloutStatus::Completed);
    assert_eq!(
        simulator
            .linearize(&State::<f64>::new(&[], &[]), &[])
            .a
            .len(),
        0
    );
}

#[test]
fn written_table_has_a_named_column_per_number() {
    let simulator = Simulator::new(floating_robot()).with_time_step(0.5);
    let rollout = simulator.rollout(&State::neutral(simulator.model()), 2, |_, _, u| u[0] = 0.25);
    let mut csv = Vec::new();
    rollout
        .write_csv(simulator.model(), &mut csv)
        .expect("memory takes everything");
    let text = String::from_utf8(csv).expect("text");
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 4);
    let columns = 1 + simulator.model().nq() + simulator.model().nv() + simulator.nu();
    assert!(rows.iter().all(|row| row.len() == columns), "{text}");
    assert_eq!(rows[0][..3], ["time", "q.base.0", "q.base.1"]);
    let inputs = simulator.input_names().into_iter();
    let inputs: Vec<_> = inputs.map(|name| format!("u.{name}")).collect();
    assert_eq!(rows[0][columns - simulator.nu()..], inputs);
    assert_eq!(
        (
            rows[2][0],
            rows[2][columns - simulator.nu()],
            rows[3][columns - 1]
        ),
        ("0.5", "0.25", "")
    );
}

#[test]
fn interpolation_meets_both_ends_and_halves_the_way() {
    for model in robots() {
        let (a, b) = (random_point(&model, 1).q, random_point(&model, 2).q);
        let at = |t: f64| model.interpolate(a.as_slice(), b.as_slice(), t);
        let way = model.difference(a.as_slice(), b.as_slice());
        let half: DVector<f64> = model.difference(a.as_slice(), at(0.5).as_slice());
        assert!(model.difference(a.as_slice(), at(0.0).as_slice()).norm() < SAME_ALGEBRA);
        assert!(
            model.difference(b.as_slice(), at(1.0).as_slice()).norm() < 1e-10,
            "{}",
            model.name()
        );
        assert!((way * 0.5 - half).norm() < 1e-10, "{}", model.name());
    }
}

#[test]
#[should_panic(expected = "the fraction t must be finite, got NaN")]
fn interpolation_refuses_fractions_that_are_not_finite() {
    let model = samples::pendulum();
    let _ = model.interpolate(&[0.0], &[1.0], f64::NAN);
}

#[test]
#[should_panic(expected = "the actuated joint \"pivot\" is named twice")]
fn joints_have_one_input() {
    let _ = Simulator::new(samples::pendulum()).with_actuated_joints(&["pivot", "pivot"]);
}

#[test]
fn random_states_and_what_follows_from_them_equal_valid_states() {
    for model in robots() {
        let state = State::random(&model, &mut generator(7), 1.0);
        assert_eq!(state.check(&model), Ok(()), "{}", model.name());
        let simulator = Simulator::new(model).with_time_step(1e-3);
        let next = simulator.step(&state, &vec![0.0; simulator.nu()]);
        assert_eq!(next.check(simulator.model()), Ok(()));
    }
}

// One wrong number at a time: the error names where it stands and the joint that has it.
#[test]
fn each_wrong_number_of_a_state_equals_the_one_that_the_error_names() {
    let model = floating_robot();
    let good = State::random(&model, &mut generator(8), 1.0);
    let ball = model.joint("ball_joint").expect("a joint");
    let (of_ball, hinge) = (
        model.joint_q(ball),
        model.joint("hinge_joint").expect("a joint"),
    );
    let error = |change: &dyn Fn(&mut State)| {
        let mut state = good.clone();
        change(&mut state);
        state.check(&model).expect_err("a wrong state")
    };
    let nan = error(&|state| state.v[model.joint_v(hinge).start] = f64::NAN).to_string();
    assert!(
        nan.contains("\"hinge_joint\"") && nan.starts_with("v["),
        "{nan}"
    );
    let infinite = error(&|state| state.q[2] = f64::INFINITY);
    assert_eq!(infinite.to_string(), "q[2], of the floating base, is inf");
    let doubled = error(&|state| state.q.rows_mut(of_ball.start, 4).scale_mut(2.0));
    let InvalidState::QuaternionNorm { index, joint, norm } = doubled else {
        panic!("{doubled}")
    };
    assert_eq!(
        (index, joint.as_str()),
        (of_ball.start, "joint \"ball_joint\"")
    );
    assert!((norm - 2.0).abs() < SAME_ALGEBRA);
    let base = error(&|state| state.q[3] += 1e-3).to_string();
    assert!(base.contains("q[3..7] of the floating base"), "{base}");
    let short = error(&|state| state.v = DVector::zeros(3));
    let expected = InvalidState::WrongLength {
        model: "floating_robot".into(),
        vector: "v",
        expected: model.nv(),
        given: 3,
    };
    assert_eq!(short, expected);
}

#[test]
fn spinning_free_body_flies_straight_and_keeps_its_momentum() {
    let model = asset("sphere.urdf").with_gravity(nalgebra::Vector3::zeros());
    let simulator = Simulator::new(model).with_time_step(0.01);
    // Turned, so that body and world axes differ; a sphere spins about a fixed axis.
    let (sin, cos) = 0.4_f64.sin_cos();
    let start = State::new(
        &[1.0, 2.0, 3.0, cos, sin, 0.0, 0.0],
        &[0.3, -0.5, 0.7, 10.0, -20.0, 5.0],
    );
    let velocity = |state: &State| frame_velocity_in_world(simulator.model(), state);
    let v = velocity(&start);
    let end = simulator.rollout(&start, 1000, |_, _, _| {});
    assert!((velocity(end.last()) - v).amax() < 1e-11);
    let flown = end.last().q.fixed_rows::<3>(0) - start.q.fixed_rows::<3>(0);
    assert!((flown - v * 10.0).amax() < 1e-10);
}

fn frame_velocity_in_world(model: &Model, state: &State) -> nalgebra::Vector3<f64> {
    let frame = model.find_frame("sphere").expect("the link");
    let (q, v) = (state.q.as_slice(), state.v.as_slice());
    frame_velocity(model, q, v, frame, Representation::Mixed).linear
}
