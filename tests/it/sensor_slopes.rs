//! C and D of sensors beside finite differences of their readings, through the acceleration and the forces of contact and constraints.

use dualbody::autodiff::Dual;
use dualbody::contact::{ContactLaw, Contacts, Rigid, SoftContact, Terrain};
use dualbody::model::{Model, samples};
use dualbody::sim::{Sensor, Sensors};
use dualbody::spatial::Representation;
use dualbody::{Integrator, Simulator, State};
use nalgebra::DVector;
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

use crate::common::asset;
use crate::constraints::four_bar;

/// Every kind of sensor on the links of a robot.
fn all_sensors(model: &Model) -> Sensors {
    let mut all: Vec<(String, Sensor)> = vec![
        ("com".into(), Sensor::CenterOfMass),
        ("com velocity".into(), Sensor::CenterOfMassVelocity),
        ("momentum".into(), Sensor::Momentum),
    ];
    for name in model.joint_names() {
        let joint = model.find_joint(name).expect("a joint");
        all.push((format!("{name} q"), Sensor::JointPosition(joint)));
        all.push((format!("{name} v"), Sensor::JointVelocity(joint)));
        all.push((format!("{name} tau"), Sensor::JointForce(joint)));
    }
    let links = model.link_frames();
    let last = links[links.len() - 1];
    let [body, mixed] = [Representation::Body, Representation::Mixed];
    for (name, sensor) in [
        ("gyro", Sensor::Gyro(last)),
        ("accelerometer", Sensor::Accelerometer(last)),
        ("pose", Sensor::FramePose(last)),
        (
            "velocity",
            Sensor::FrameVelocity {
                frame: last,
                representation: body,
            },
        ),
        (
            "acceleration",
            Sensor::FrameAcceleration {
                frame: last,
                representation: mixed,
            },
        ),
        (
            "field",
            Sensor::Magnetometer {
                frame: last,
                field: [0.2, 0.1, -0.4],
            },
        ),
        ("wrench", Sensor::Wrench(last)),
        ("base wrench", Sensor::Wrench(links[0])),
        ("touch", Sensor::Touch(last)),
        ("contact", Sensor::ContactForce(last)),
    ] {
        all.push((name.into(), sensor));
    }
    // In a linkage it would look along a neighbour.
    if !model.name().contains("four") {
        let (direction, range) = ([0.3, 0.1, -1.0], 10.0);
        let finder = Sensor::RangeFinder {
            frame: last,
            direction,
            range,
        };
        all.push(("range".into(), finder));
    }
    Sensors::new(model, all)
}

/// Central differences of the readings along (δx, δu), a column each.
fn differences(
    sensors: &Sensors,
    simulator: &Simulator,
    state: &State,
    u: &[f64],
) -> Vec<DVector<f64>> {
    const H: f64 = 1e-6;
    let n = simulator.n_tangent();
    let moved = |k: usize, h: f64| {
        let mut dx = vec![0.0; n];
        let mut u = u.to_vec();
        match k.checked_sub(n) {
            None => dx[k] = h,
            Some(input) => u[input] += h,
        }
        sensors.read(simulator, &state.integrate(simulator.model(), &dx), &u)
    };
    (0..n + u.len())
        .map(|k| (moved(k, H) - moved(k, -H)) / (2.0 * H))
        .collect()
}

/// Derivatives of the readings along (δx, δu), where all that finds the acceleration runs on dual numbers.
fn over_duals(
    sensors: &Sensors,
    simulator: &Simulator,
    state: &State,
    u: &[f64],
) -> Vec<DVector<f64>> {
    type Direction = Dual<f64, 1>;
    let n = simulator.n_tangent();
    let lifted = |x: &DVector<f64>| x.map(Direction::from);
    let start = State::new(lifted(&state.q).as_slice(), lifted(&state.v).as_slice())
        .with_contact(lifted(&state.contact))
        .with_activation(lifted(&state.activation));
    let along = |k: usize| {
        let mut dx = vec![Direction::from(0.0); n];
        let mut u: Vec<Direction> = u.iter().map(|&u| u.into()).collect();
        match k.checked_sub(n) {
            None => dx[k].eps[0] = 1.0,
            Some(input) => u[input].eps[0] = 1.0,
        }
        let moved = start.integrate(simulator.model(), &dx);
        sensors.read(simulator, &moved, &u).map(|y| y.eps[0])
    };
    (0..n + u.len()).map(along).collect()
}

fn check(what: &str, simulator: &Simulator, state: &State, u: &[f64]) {
    let sensors = all_sensors(simulator.model());
    let at = sensors.linearize(simulator, state, u);
    assert_eq!(at.reading, sensors.read(simulator, state, u), "{what}");
    assert_eq!(at.step, simulator.linearize(state, u), "{what}");
    let (names, n) = (sensors.names(), simulator.n_tangent());
    let mut largest: f64 = 0.0;
    let through_solver = over_duals(&sensors, simulator, state, u);
    for (k, expected) in through_solver.iter().enumerate() {
        for (row, &expected) in expected.iter().enumerate() {
            let got = if k < n {
                at.c[(row, k)]
            } else {
                at.d[(row, k - n)]
            };
            let error = (got - expected).abs() / (1.0 + expected.abs());
            assert!(
                error < 1e-8,
                "{what}: {} along {k}: {got}, over dual numbers {expected}",
                names[row]
            );
        }
    }
    for (k, expected) in differences(&sensors, simulator, state, u)
        .iter()
        .enumerate()
    {
        let own = if k < n {
            at.c.column(k)
        } else {
            at.d.column(k - n)
        };
        for (row, (got, expected)) in own.iter().zip(expected).enumerate() {
            let error = (got - expected).abs() / (1.0 + expected.abs());
            assert!(
                error < 2e-5,
                "{what}: {} along {k}: {got}, by differences {expected}",
                names[row]
            );
            largest = largest.max(got.abs());
        }
    }
    assert!(largest > 0.1, "{what}: nothing depends on anything");
}

#[test]
fn slopes_of_an_arm_and_a_random_tree_equal_differences() {
    for (what, model) in [
        ("arm", samples::arm()),
        ("tree", samples::random_tree(6, 11)),
    ] {
        for integrator in [Integrator::SemiImplicitEuler, Integrator::RungeKutta4] {
            let simulator = Simulator::new(model.clone()).with_integrator(integrator);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
            let state = State::random(&model, &mut rng, 1.0);
            let u: Vec<f64> = (0..simulator.nu()).map(|k| 0.3 - 0.1 * k as f64).collect();
            check(what, &simulator, &state, &u);
        }
    }
}

#[test]
fn slopes_in_contact_equal_differences() {
    for (what, law) in [
        ("rigid", ContactLaw::Rigid(Rigid::default())),
        (
            "soft",
            ContactLaw::Soft(SoftContact::estimate(1.0, 8, 1e-3)),
        ),
    ] {
        let model = asset("box.urdf");
        let contacts = Contacts::new(&model, Terrain::incline(0.05), law);
        let simulator = Simulator::new(model)
            .with_time_step(2e-3)
            .with_integrator(Integrator::ImplicitVelocity)
            .with_contacts(contacts);
        let mut state = simulator.neutral_state();
        // Pressed in, and sliding.
        state.q[2] = 0.0575;
        state.v[0] = 0.3;
        state.v[4] = 0.02;
        let sensors = all_sensors(simulator.model());
        let touch = sensors.range("touch").expect("a sensor").start;
        let y = sensors.read(&simulator, &state, &[]);
        assert!(y[touch] > 0.1, "{what}: {} N", y[touch]);
        check(what, &simulator, &state, &[]);
    }
}

#[test]
fn slopes_of_a_closed_loop_equal_differences() {
    let simulator = four_bar();
    let start = simulator
        .assemble(&simulator.neutral_state())
        .expect("a start")
        .state;
    let u = vec![0.2; simulator.nu()];
    check("four-bar", &simulator, &start, &u);
}

/// A box on the floor with a ball on it and an arm, driven by a servo on a site and by a motor behind a filter; all contact has torsional and rolling friction.
const SCENE: &str = r#"<mujoco model="scene">
  <option timestep="0.002"/>
  <default><geom condim="6" friction="0.8 0.02 0.01"/></default>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <site name="anchor" pos="0.3 0 0.4"/>
    <body name="box">
      <freejoint name="box"/>
      <geom type="box" size="0.1 0.1 0.1" mass="2"/>
      <site name="thrust" pos="0.02 0.01 0.1"/>
      <body name="arm" pos="-0.1 0 0.1">
        <joint name="hinge" axis="0 1 0" damping="0.1" limited="true" range="-10 90"/>
        <geom type="capsule" fromto="0 0 0 -0.2 0 0.1" size="0.02" mass="0.3" contype="0" conaffinity="0"/>
      </body>
    </body>
    <body name="ball">
      <freejoint name="ball"/>
      <geom type="sphere" size="0.05" mass="0.4"/>
    </body>
  </worldbody>
  <actuator>
    <position name="pull" site="thrust" refsite="anchor" kp="40" kv="2" gear="1 0 0 0 0 0" forcelimited="true" forcerange="-30 30"/>
    <general name="filtered" joint="hinge" dyntype="filter" dynprm="0.05" gear="3"/>
  </actuator>
</mujoco>"#;

// What a solver finds for points with the ground and between bodies, with their moments, and for servos on frames; activations are states.
#[test]
fn slopes_in_a_scene_with_servos_equal_differences() {
    let scene = Simulator::from_mjcf_str(SCENE).expect("a scene");
    for height in [0.0, 2.0] {
        let mut state = scene.neutral_state();
        for (name, position) in [
            ("box", [0.0, 0.0, 0.0997 + height]),
            ("ball", [0.02, 0.03, 0.2491 + 2.0 * height]),
        ] {
            let joint = scene.model().find_joint(name).expect("a joint");
            let first = scene.model().joint_q(joint).start;
            state.q.as_mut_slice()[first..first + 3].copy_from_slice(&position);
        }
        // No speed is zero, and no depth half the width of an impedance, where derivatives of laws jump.
        for (k, v) in state.v.iter_mut().enumerate() {
            *v = 0.03 * (1.0 + k as f64).sin();
        }
        state.activation[0] = 0.2;
        let sensors = all_sensors(scene.model());
        let y = sensors.read(&scene, &state, &[0.1, 0.5]);
        let touch = y[sensors.range("touch").expect("a sensor").start];
        assert_eq!(touch > 0.1, height == 0.0, "{touch} N on the ball");
        check("scene", &scene, &state, &[0.1, 0.5]);
    }
}

// Light links in fast rotation have their velocity forces in the middle of the step.
#[test]
fn slopes_in_fast_rotation_equal_differences() {
    let model = samples::random_tree(5, 3);
    let simulator = Simulator::new(model.clone()).with_time_step(2e-3);
    let mut state = State::random(&model, &mut Xoshiro256PlusPlus::seed_from_u64(9), 1.0);
    let last = state.v.len() - 1;
    state.v[last] = 180.0;
    check("fast", &simulator, &state, &vec![0.1; simulator.nu()]);
}
