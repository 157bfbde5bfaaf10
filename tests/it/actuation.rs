//! Motors, friction and stops against closed forms, one test for each way in which simulators get them wrong.

use dualbody::autodiff::{VectorFunction, finite_difference, jacobian};
use dualbody::contact::HuntCrossley;
use dualbody::dynamics::{kinetic_energy, potential_energy};
use dualbody::joint::JointKind;
use dualbody::model::{JointSpec, Limits, LinkSpec, ModelBuilder, samples};
use dualbody::sim::{
    Actuation, Actuator, CoulombFriction, PositionLimits, TorqueSpeed, VelocityLimit,
};
use dualbody::{Cast, Integrator, Model, Scalar, Simulator, State};

use crate::common::{FINITE_DIFFERENCE, OTHER_ALGORITHM, SAME_ALGEBRA, asset};

/// A flywheel of 0.5 kg m² on a vertical axis: gravity does not turn it.
fn wheel(limits: Limits, friction: f64) -> Model {
    let mut builder = ModelBuilder::new("wheel");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("disk").with_mass(1.0, [0.0; 3], [0.3, 0.3, 0.5]));
    builder.add_joint(
        JointSpec::new("axle", JointKind::Revolute, "world", "disk")
            .with_axis([0.0, 0.0, 1.0])
            .with_limits(limits)
            .with_friction(friction),
    );
    builder.build().expect("a wheel")
}

fn actuated(model: Model, actuator: Actuator) -> Simulator {
    let actuation = Actuation::ideal(&model)
        .with_actuator(&model, "axle", actuator)
        .expect("the axle");
    Simulator::new(model).with_actuation(actuation)
}

const CURVE: TorqueSpeed = TorqueSpeed {
    torque: 8.0,
    threshold: 10.0,
    maximum: 20.0,
};

#[test]
fn motor_gives_its_torque_at_low_speed_none_at_high_speed_and_a_share_between() {
    let motor = Actuator {
        servo: None,
        torque_speed: Some(CURVE),
        ..Actuator::default()
    };
    for (v, u, expected) in [
        (0.0, 100.0, 8.0),
        (10.0, 100.0, 8.0),
        (15.0, 100.0, 4.0),
        (-15.0, 100.0, 4.0),
        (15.0, -100.0, -4.0),
        (20.0, 100.0, 0.0),
        (30.0, -100.0, 0.0),
        (15.0, 3.0, 3.0),
    ] {
        assert_eq!(motor.force(0.0, v, u), expected, "v {v} u {u}");
    }
}

#[test]
fn curve_and_effort_limit_the_motor_not_friction_and_stops() {
    let stop = HuntCrossley::linear(1000.0, 0.0);
    let all = Actuator {
        servo: None,
        torque_speed: Some(CURVE),
        effort: Some(5.0),
        friction: Some(CoulombFriction::smoothed(2.0, 1e-3)),
        position: Some(PositionLimits {
            lower: Some(-1.0),
            upper: Some(1.0),
            stop,
        }),
        velocity: Some(VelocityLimit {
            speed: 25.0,
            damping: 3.0,
        }),
    };
    // Faster than the motor can: it is silent, friction, stop and speed limit are not.
    let expected = -2.0 - 1000.0 * 0.5 - 3.0 * 5.0;
    assert!((all.force(1.5, 30.0, 100.0) - expected).abs() < 1e-6);
    assert!((all.force(0.0, 1.0, 100.0) - (5.0 - 2.0)).abs() < 1e-5);
    assert!((all.force(-1.5, -30.0, 0.0) + expected).abs() < 1e-6);
}

#[test]
fn driven_wheel_gains_speed_as_effort_over_inertia_says() {
    let simulator = actuated(
        wheel(Limits::default(), 0.0),
        Actuator {
            effort: Some(2.0),
            ..Actuator::default()
        },
    );
    let end = simulator.rollout(&State::new(&[0.0], &[0.0]), 1000, |_, _, u| u[0] = -50.0);
    assert!((end.last().v[0] + 2.0 / 0.5).abs() < SAME_ALGEBRA);
}

#[test]
fn friction_is_finite_at_rest_and_brakes_a_wheel_in_the_time_of_coulomb() {
    let friction = CoulombFriction::smoothed(2.0, 1e-3);
    let actuator = Actuator {
        friction: Some(friction),
        ..Actuator::default()
    };
    let simulator = actuated(wheel(Limits::default(), 0.0), actuator).with_time_step(1e-4);
    // ω / t = f / I = 4 rad/s²: from 2 rad/s to rest in half a second.
    let states = simulator
        .rollout(&State::new(&[0.0], &[2.0]), 6000, |_, _, _| {})
        .states;
    assert!((states[4000].v[0] - 0.4).abs() < 1e-3);
    assert!(states[6000].v[0].abs() < 1e-6);
    let still = simulator.linearize(&State::new(&[0.0], &[0.0]), &[0.0]);
    // v⁺ = v − Δt f v⁺ / (v_s I)
    assert!((still.a[(1, 1)] - 1.0 / (1.0 + 1e-4 * 2.0 / 1e-3 / 0.5)).abs() < SAME_ALGEBRA);
    // Below the friction it holds: it creeps at about v_s τ / f.
    let pushed = simulator.rollout(&State::new(&[0.0], &[0.0]), 6000, |_, _, u| u[0] = 1.0);
    let creep = pushed.last().v[0];
    assert!(
        (creep - 1e-3 * 0.5 / 0.75_f64.sqrt()).abs() < OTHER_ALGORITHM,
        "{creep}"
    );
}

#[test]
fn driven_joint_stops_at_both_ends_and_its_energy_never_grows() {
    let limits = Limits {
        lower: Some(-1.0),
        upper: Some(0.5),
        velocity: None,
        effort: None,
    };
    let model = wheel(limits, 0.0);
    let actuation = Actuation::from_model(&model);
    let stop = actuation.actuators()[0].position.expect("limits").stop;
    let simulator = Simulator::new(model).with_actuation(actuation);
    // Starts inside the limits, at them, and beyond them; moving either way.
    for (q, v) in [
        (0.0, 3.0),
        (0.0, -3.0),
        (0.5, 2.0),
        (-1.0, -2.0),
        (0.6, 4.0),
        (-1.2, -4.0),
        (0.6, -4.0),
        (-1.2, 4.0),
    ] {
        let simulator = simulator
            .clone()
            .with_time_step(1e-4)
            .with_integrator(Integrator::RungeKutta4);
        let rollout = simulator.rollout(&State::new(&[q], &[v]), 4000, |_, _, _| {});
        let energy = |state: &State| {
            let out = (state.q[0] - 0.5).max(-1.0 - state.q[0]).max(0.0);
            0.5 * 0.5 * state.v[0] * state.v[0] + 0.5 * stop.stiffness * out * out
        };
        let mut last = f64::INFINITY;
        for state in &rollout.states {
            let now = energy(state);
            assert!(now <= last + 1e-9, "from {q} at {v}: {last} grows to {now}");
            last = now;
        }
        let farthest = rollout
            .states
            .iter()
            .map(|s| (s.q[0] - 0.5).max(-1.0 - s.q[0]));
        let beyond = (q - 0.5_f64).max(-1.0 - q).max(0.0);
        assert!(
            farthest.fold(0.0, f64::max) < beyond + 0.01 * v.abs(),
            "from {q} at {v}"
        );
    }
    // A motor that pushes against a stop rests there, at the depth that balances it.
    for (u, end) in [(20.0, 0.5), (-20.0, -1.0)] {
        let rollout = simulator.rollout(&State::new(&[0.0], &[0.0]), 3000, |_, _, tau| tau[0] = u);
        let expected = end + u / stop.stiffness;
        assert!(
            (rollout.last().q[0] - expected).abs() < 1e-6,
            "{}",
            rollout.last().q[0]
        );
        assert!(rollout.last().v[0].abs() < 1e-6);
    }
}

#[test]
fn stop_never_pulls() {
    let stop = HuntCrossley::linear(100.0, 10.0);
    for depth in [-0.1, 0.0, 1e-6, 0.01, 1.0] {
        for rate in [-100.0, -1.0, 0.0, 1.0, 100.0] {
            let force = stop.force(depth, rate);
            assert!(
                force >= 0.0 && (depth > 0.0 || force == 0.0),
                "{depth} {rate}: {force}"
            );
        }
    }
}

#[test]
fn speed_stays_near_its_limit() {
    let limits = Limits {
        velocity: Some(3.0),
        ..Limits::default()
    };
    let model = wheel(limits, 0.0);
    let actuation = Actuation::from_model(&model);
    let damping = actuation.actuators()[0].velocity.expect("a limit").damping;
    let simulator = Simulator::new(model).with_actuation(actuation);
    for u in [30.0, -30.0] {
        let end = simulator.rollout(&State::new(&[0.0], &[0.0]), 3000, |_, _, tau| tau[0] = u);
        let expected = u.signum() * 3.0 + u / damping;
        assert!((end.last().v[0] - expected).abs() < OTHER_ALGORITHM);
    }
}

#[test]
fn from_model_takes_every_limit_of_the_file() {
    let model = asset("panda.urdf");
    let actuation = Actuation::from_model(&model);
    let mut limited = 0;
    for joint in model.joints() {
        let body = model.body(joint.body);
        if body.coupling.is_some() {
            continue;
        }
        let own = &actuation.actuators()[body.v];
        assert_eq!(own.effort, joint.limits.effort);
        assert_eq!(own.velocity.map(|v| v.speed), joint.limits.velocity);
        let ends = own.position.map(|p| (p.lower, p.upper));
        assert_eq!(ends, Some((joint.limits.lower, joint.limits.upper)));
        limited += 1;
    }
    assert!(limited > 6);
    let model = wheel(Limits::default(), 0.7);
    let friction = Actuation::from_model(&model).actuators()[0].friction;
    assert_eq!(friction.map(|f| f.force), Some(0.7));
}

/// Everything at once, on both sides of every corner.
#[test]
fn jacobians_of_the_step_equal_finite_differences_with_every_part() {
    let model = samples::cartpole();
    let full = Actuator {
        servo: None,
        torque_speed: Some(TorqueSpeed {
            torque: 12.0,
            threshold: 1.0,
            maximum: 4.0,
        }),
        effort: Some(9.0),
        friction: Some(CoulombFriction::smoothed(0.8, 0.1)),
        position: Some(PositionLimits {
            lower: Some(-0.5),
            upper: Some(0.7),
            stop: HuntCrossley {
                stiffness: 300.0,
                damping: 40.0,
                stiffness_exponent: 0.5,
                damping_exponent: 1.0,
            },
        }),
        velocity: Some(VelocityLimit {
            speed: 2.0,
            damping: 1.5,
        }),
    };
    let actuation = Actuation::ideal(&model)
        .with_actuator(&model, "linear", full)
        .and_then(|a| a.with_actuator(&model, "pivot", full))
        .expect("joints");
    for integrator in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
        let simulator = Simulator::new(model.clone())
            .with_actuation(actuation.clone())
            .with_integrator(integrator)
            .with_time_step(0.01);
        for (q, v, u) in [
            ([0.0, 0.2], [0.0, 0.0], [1.0, 2.0]),
            ([0.9, -0.8], [0.3, -0.2], [20.0, -20.0]),
            ([0.9, 0.9], [2.5, 3.0], [20.0, 3.0]),
            ([0.1, 0.1], [5.0, -5.0], [1.0, 1.0]),
        ] {
            let state = State::new(&q, &v);
            let exact = simulator.linearize(&state, &u);
            let numeric = simulator
                .estimate_linearization(&state, &u, &finite_difference::Options::default())
                .linearization;
            let error = (&exact.a - &numeric.a)
                .amax()
                .max((&exact.b - &numeric.b).amax());
            assert!(
                error < FINITE_DIFFERENCE,
                "{integrator:?} {q:?} {v:?}: {error:e}"
            );
        }
    }
}

/// The velocity after a step as a function of all numbers of one actuator.
struct InActuator(Model, State);

impl VectorFunction for InActuator {
    fn n_outputs(&self) -> usize {
        1
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let actuator = Actuator {
            servo: None,
            torque_speed: Some(TorqueSpeed {
                torque: x[0],
                threshold: x[1],
                maximum: x[2],
            }),
            effort: None,
            friction: Some(CoulombFriction::smoothed(x[3], x[4])),
            position: Some(PositionLimits {
                lower: Some(x[5]),
                upper: Some(x[6]),
                stop: HuntCrossley::linear(x[7], x[8]),
            }),
            velocity: Some(VelocityLimit {
                speed: x[9],
                damping: x[10],
            }),
        };
        let ideal = Actuation::ideal(&self.0).with_actuators(&[actuator]);
        let simulator: Simulator<T> = Simulator::new(self.0.cast::<T>()).with_actuation(ideal);
        let next = simulator.step(&self.1.cast(), &[T::constant(50.0)]);
        y[0] = next.v[0];
    }
}

#[test]
fn derivatives_in_the_numbers_of_an_actuator_equal_finite_differences() {
    let x = [8.0, 1.0, 9.0, 0.6, 0.2, -0.4, 0.5, 900.0, 20.0, 2.0, 1.7];
    let model = wheel(Limits::default(), 0.0);
    let mut seen = [false; 11];
    for (q, v) in [(0.6, 3.0), (-0.6, -3.0), (0.0, 0.05)] {
        let f = InActuator(model.clone(), State::new(&[q], &[v]));
        let (exact, numeric) = (jacobian(&f, &x), finite_difference::jacobian(&f, &x));
        let error = (&exact - &numeric).amax();
        assert!(error < FINITE_DIFFERENCE, "{q} {v}: {error:e}");
        for k in 0..11 {
            seen[k] |= exact[(0, k)] != 0.0;
        }
    }
    assert_eq!(seen, [true; 11]);
}

#[test]
fn energy_balance_of_a_stopped_pole_is_that_of_its_parts() {
    // A pole that falls against a stop loses energy there and nowhere else.
    let model = samples::pendulum();
    let joint = model.joint_names()[0].to_owned();
    let stop = Actuator {
        position: Some(PositionLimits {
            lower: None,
            upper: Some(0.5),
            stop: HuntCrossley::linear(500.0, 10.0),
        }),
        ..Actuator::default()
    };
    let actuation = Actuation::ideal(&model)
        .with_actuator(&model, &joint, stop)
        .expect("joint");
    let simulator = Simulator::new(model)
        .with_actuation(actuation)
        .with_integrator(Integrator::RungeKutta4)
        .with_time_step(1e-4);
    let rollout = simulator.rollout(&State::new(&[-1.5], &[0.0]), 20_000, |_, _, _| {});
    let robot = simulator.model();
    let energy = |s: &State| {
        let (q, v) = (s.q.as_slice(), s.v.as_slice());
        let out = (s.q[0] - 0.5).max(0.0);
        kinetic_energy(robot, q, v) + potential_energy(robot, q) + 250.0 * out * out
    };
    let mut last = energy(&rollout.states[0]);
    let first = last;
    for state in &rollout.states {
        let now = energy(state);
        assert!(now < last + 1e-8);
        last = now;
    }
    assert!(last < first - 0.1);
}
