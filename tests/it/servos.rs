//! Servos against closed forms: gains that act at the end of the step, force ranges, gears, Jacobians.

use dualbody::autodiff::VectorFunction;
use dualbody::autodiff::finite_difference;
use dualbody::joint::JointKind;
use dualbody::model::{JointSpec, LinkSpec, ModelBuilder, samples};
use dualbody::sim::{Actuation, Actuator, CoulombFriction, Servo};
use dualbody::{Integrator, Model, Scalar, Simulator, State};

use crate::common::{OTHER_ALGORITHM, SAME_ALGEBRA, with_solver};

const EULER: [Integrator; 2] = [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity];
const MASS: f64 = 2.0;

fn slider() -> Model {
    let mut builder = ModelBuilder::new("slider");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("slider").with_mass(MASS, [0.0; 3], [1.0; 3]));
    let rail = JointSpec::new("rail", JointKind::Prismatic, "world", "slider");
    builder.add_joint(rail.with_axis([1.0, 0.0, 0.0]));
    builder.build().expect("a slider")
}

fn driven(actuator: Actuator, dt: f64, integrator: Integrator) -> Simulator {
    let model = slider();
    let actuation = Actuation::ideal(&model).with_actuator(&model, "rail", actuator);
    Simulator::new(model)
        .with_actuation(actuation.expect("the rail"))
        .with_time_step(dt)
        .with_integrator(integrator)
}

fn servo(servo: Servo) -> Actuator {
    Actuator {
        servo: Some(servo),
        ..Actuator::default()
    }
}

// m (v⁺ − v) / Δt = n (g u + b − k_p n (q + Δt v⁺) − k_v n v⁺)
#[test]
fn gains_act_at_the_end_of_the_step_whatever_they_are() {
    let general = Servo {
        gain: 0.7,
        bias: 0.4,
        position_gain: 50.0,
        velocity_gain: 2.0,
        ..Servo::torque(-3.0)
    };
    for law in [
        Servo::position(1e4, 0.0),
        Servo::position(1e9, 1e3).with_gear(0.1),
        Servo::velocity(1e6),
        Servo::torque(12.0),
        general,
    ] {
        for (dt, integrator) in [0.01, 0.1]
            .into_iter()
            .flat_map(|dt| EULER.map(|by| (dt, by)))
        {
            let simulator = driven(servo(law), dt, integrator);
            let (q, v, u) = (0.3, -1.2, 0.8);
            let next = simulator.step(&State::new(&[q], &[v]), &[u]);
            let Servo {
                gear: n,
                gain,
                bias,
                position_gain: kp,
                velocity_gain: kv,
                ..
            } = law;
            let force = n * (gain * u + bias - kp * n * q);
            let expected = (MASS * v + dt * force) / (MASS + n * n * dt * (kv + dt * kp));
            let error = (next.v[0] - expected).abs() / (1.0 + expected.abs());
            assert!(error < SAME_ALGEBRA, "{law:?}, {dt}: {error:e}");
            let step = simulator.linearize(&State::new(&[q], &[v]), &[u]);
            let slope = dt * n * gain / (MASS + n * n * dt * (kv + dt * kp));
            assert!((step.b[(1, 0)] - slope).abs() < SAME_ALGEBRA * (1.0 + slope.abs()));
        }
    }
}

#[test]
fn position_servo_of_ten_thousand_newtons_a_metre_is_stable_at_ten_milliseconds() {
    for integrator in EULER {
        for kv in [0.0, 50.0] {
            let simulator = driven(servo(Servo::position(1e4, kv)), 0.01, integrator);
            let reached = simulator.rollout(&State::new(&[0.0], &[0.0]), 500, |_, _, u| u[0] = 0.2);
            assert!(
                (reached.last().q[0] - 0.2).abs() < 1e-6,
                "{:?}",
                reached.last()
            );
            let a = simulator.linearize(&State::new(&[0.1], &[0.3]), &[0.2]).a;
            let radius = a
                .complex_eigenvalues()
                .iter()
                .map(|x| x.norm())
                .fold(0.0, f64::max);
            assert!(radius < 1.0, "{radius}");
        }
    }
    let critical = Servo::position_with_damping_ratio(100.0, 1.0, MASS);
    assert!((critical.velocity_gain - 2.0 * 200.0_f64.sqrt()).abs() < 1e-12);
}

// The force is that of the end of the step where that is within the range, else the end of the range.
#[test]
fn force_range_holds_at_the_end_of_the_step_also_beside_a_solver() {
    let (kp, kv, dt) = (1e4, 20.0, 0.01);
    let (mut within, mut beyond) = (0, [0; 2]);
    let symmetric = Actuator {
        effort: Some(7.0),
        ..servo(Servo::position(kp, kv))
    };
    // Gains and range of the motor: behind the gear they are kp and kv, and -3 to 9; the effort limit is beyond one end.
    let geared = Servo::position(4.0 * kp, 4.0 * kv)
        .with_gear(-0.5)
        .with_force_range(-18.0, 6.0);
    let uneven = Actuator {
        effort: Some(20.0),
        ..servo(geared)
    };
    let shortened = Actuator {
        effort: Some(4.0),
        ..servo(geared)
    };
    let cases = [
        (symmetric, [-7.0, 7.0], 1.0),
        (servo(geared), [-3.0, 9.0], -2.0),
        (uneven, [-3.0, 9.0], -2.0),
        (shortened, [-3.0, 4.0], -2.0),
    ];
    for (integrator, (actuator, [lower, upper], by_input)) in EULER
        .into_iter()
        .flat_map(|by| cases.map(|case| (by, case)))
    {
        let simulator = driven(actuator, dt, integrator);
        let solved = with_solver(&simulator);
        for k in 0..60 {
            let (q, v) = (0.002 * (k as f64).sin(), 0.05 * (1.7 * k as f64).cos());
            let state = State::new(&[q], &[v]);
            let free = (MASS * v - dt * kp * q) / (MASS + dt * (kv + dt * kp));
            let force = MASS * (free - v) / dt;
            let expected = v + dt * force.clamp(lower, upper) / MASS;
            let is_within = (lower..upper).contains(&force);
            within += usize::from(is_within);
            beyond[usize::from(force > upper)] += usize::from(!is_within);
            for simulator in [&simulator, &solved] {
                let next = simulator.step(&state, &[0.0]);
                assert!(
                    (next.v[0] - expected).abs() < OTHER_ALGORITHM,
                    "{k}: {}",
                    next.v[0]
                );
                let b = simulator.linearize(&state, &[0.0]).b[(1, 0)];
                let slope = match is_within {
                    true => by_input * dt * kp / (MASS + dt * (kv + dt * kp)),
                    false => 0.0,
                };
                assert!((b - slope).abs() < OTHER_ALGORITHM, "{k}: {b}, not {slope}");
            }
        }
    }
    assert!(
        within > 50 && beyond.iter().all(|&n| n > 50),
        "{within} {beyond:?}"
    );
}

/// A step without state of contact, as a function of state and input.
pub(crate) struct Step(pub(crate) Simulator);

impl VectorFunction for Step {
    fn n_outputs(&self) -> usize {
        2 * self.0.model().nv()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let n = self.0.model().nv();
        let state = State::new(&x[..n], &x[n..2 * n]);
        let next = self.0.step(&state, &x[2 * n..]);
        let all = next.q.iter().chain(next.v.iter());
        y.iter_mut().zip(all).for_each(|(y, &x)| *y = x);
    }
}

#[test]
fn jacobians_with_servos_and_friction_equal_finite_differences() {
    let model = samples::arm();
    let n = model.nv();
    let all = (0..n).map(|k| Actuator {
        servo: Some(match k % 3 {
            0 => Servo::velocity(30.0).with_force_range(-9.0, 14.0),
            1 => Servo::position(1e4, 10.0)
                .with_gear(-1.5)
                .with_force_range(-3.0, 5.0),
            _ => Servo::position(1e4, 10.0),
        }),
        effort: (k % 2 == 0).then_some(20.0),
        friction: (k % 2 == 1).then(|| CoulombFriction::exact(3.0)),
        ..Actuator::default()
    });
    let actuation = Actuation::ideal(&model).with_actuators(&all.collect::<Vec<_>>());
    let simulator = Simulator::new(model)
        .with_actuation(actuation)
        .with_time_step(0.01);
    let wave = |k: usize, size: f64| size * (1.3 * k as f64).sin();
    for (simulator, speed) in EULER
        .into_iter()
        .flat_map(|by| [0.01, 0.5].map(|speed| (simulator.clone().with_integrator(by), speed)))
        .flat_map(|(simulator, speed)| [(with_solver(&simulator), speed), (simulator, speed)])
    {
        let q: Vec<f64> = (0..n).map(|k| wave(k, 0.4)).collect();
        let v: Vec<f64> = (0..n).map(|k| wave(k + 3, speed)).collect();
        let u: Vec<f64> = (0..n).map(|k| q[k] + wave(k + 5, 0.01)).collect();
        let step = simulator.linearize(&State::new(&q, &v), &u);
        let x: Vec<f64> = q.iter().chain(&v).chain(&u).copied().collect();
        let expected = finite_difference::jacobian(&Step(simulator), &x);
        let found = step.a.iter().chain(&step.b);
        let largest = expected.amax();
        for (found, expected) in found.zip(&expected) {
            let error = (found - expected).abs();
            assert!(error < 1e-6 * largest, "{found}, not {expected}");
        }
    }
}

// An input beyond its range is its end, and moves nothing.
#[test]
fn inputs_beyond_their_range_are_its_end() {
    for integrator in [EULER[0], Integrator::RungeKutta4] {
        let law = Servo::position(30.0, 2.0).with_input_range(-0.5, 0.2);
        let simulator = driven(servo(law), 0.01, integrator);
        let state = State::new(&[0.1], &[0.3]);
        for (u, end) in [(3.0, 0.2), (-0.7, -0.5)] {
            assert_eq!(simulator.step(&state, &[u]), simulator.step(&state, &[end]));
            assert_eq!(simulator.linearize(&state, &[u]).b.amax(), 0.0);
            assert!(simulator.linearize(&state, &[end]).b[(1, 0)] > 0.0);
        }
    }
}

#[test]
#[should_panic(expected = "not in order")]
fn ranges_whose_ends_are_not_in_order_are_refused() {
    let _ = driven(
        servo(Servo::torque(1.0).with_force_range(2.0, -2.0)),
        0.01,
        EULER[0],
    );
}

#[test]
#[should_panic(expected = "several degrees of freedom")]
fn position_gains_of_joints_without_a_position_are_refused() {
    let mut builder = ModelBuilder::new("ball");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("ball").with_mass(1.0, [0.0; 3], [1.0; 3]));
    builder.add_joint(JointSpec::new(
        "socket",
        JointKind::Spherical,
        "world",
        "ball",
    ));
    let model = builder.build().expect("a ball");
    let _ =
        Actuation::ideal(&model).with_actuator(&model, "socket", servo(Servo::position(1.0, 0.0)));
}

// Without gains the force n (g u + b) is known before the step. In gains that are not there it has the slope that a little less than none shows, a row
// of the solver whose force is that of the start of the step.
#[test]
fn motors_without_gains_keep_their_range_and_have_slopes_in_gains() {
    const SMALL: f64 = 1e-6;
    let bare = Servo {
        bias: 0.4,
        ..Servo::torque(-3.0)
    };
    let (dt, q, v) = (0.01, 0.3, -1.2);
    let state = State::new(&[q], &[v]);
    let limited = bare.with_force_range(-2.0, 5.0);
    let cases = [(0.6, 1.0, true), (9.0, 5.0, false), (-7.0, -2.0, false)];
    for (integrator, (u, force, is_within)) in EULER
        .into_iter()
        .flat_map(|by| cases.map(|case| (by, case)))
    {
        let own = driven(servo(limited), dt, integrator);
        for simulator in [with_solver(&own), own] {
            let after = v - dt * 3.0 * force / MASS;
            assert!((simulator.step(&state, &[u]).v[0] - after).abs() < OTHER_ALGORITHM);
            let b = simulator.linearize(&state, &[u]).b[(1, 0)];
            let slope = if is_within { -3.0 * dt / MASS } else { 0.0 };
            assert!((b - slope).abs() < OTHER_ALGORITHM, "{u}: {b}");
            let out = simulator.vjp(&state, &[u], &[0.0, 1.0]);
            let parameters = simulator.parameters();
            let layout = simulator.parameter_layout();
            // A largest force of zero has none below it.
            let may_fall = |k: &usize| !layout.names()[*k].contains("largest force");
            for k in (0..parameters.len()).filter(may_fall) {
                let slope = out.parameters[k];
                let mut less = parameters.clone();
                less[k] -= SMALL;
                let after_less = simulator
                    .with_parameters(less.as_slice())
                    .step(&state, &[u]);
                let expected = (after - after_less.v[0]) / SMALL;
                assert!(
                    (slope - expected).abs() < 1e-4,
                    "{u}, {k}: {slope}, not {expected}"
                );
            }
        }
    }
}
