//! Readings of sensors against closed forms, and against the balance of forces of the step that they belong to.

use std::f64::consts::FRAC_PI_2;

use dualbody::constraint::Anchor;
use dualbody::contact::{
    ContactLaw, Contacts, HeightFunction, Rigid, SoftContact, Terrain, TerrainFunction,
};
use dualbody::dynamics::{frame_acceleration, frame_pose, frame_velocity};
use dualbody::joint::JointKind;
use dualbody::model::{
    Base, Collision, Geometry, JointSpec, LinkSpec, Model, ModelBuilder, samples,
};
use dualbody::sim::{
    Actuation, Actuator, CoulombFriction, ExternalForce, FrameActuator, Sensor, SensorScratch,
    Sensors, StepScratch,
};
use dualbody::spatial::{Force, Representation, Transform};
use dualbody::{Integrator, Scalar, Simulator, State};
use nalgebra::{Vector3, vector};
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

use crate::common::asset;
use crate::constraints::four_bar;

const G: f64 = 9.81;

fn frame(model: &Model, name: &str) -> dualbody::model::FrameId {
    model.find_frame(name).expect("a frame of the model")
}

/// The reading of one sensor.
fn read(simulator: &Simulator, sensor: Sensor, state: &State, u: &[f64]) -> Vec<f64> {
    let sensors = Sensors::new(simulator.model(), [("one", sensor)]);
    sensors.read(simulator, state, u).as_slice().to_vec()
}

fn assert_near(what: &str, got: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(got.len(), expected.len(), "{what}");
    for (got, expected) in got.iter().zip(expected) {
        let error = (got - expected).abs();
        assert!(
            error <= tolerance,
            "{what}: {got} is not {expected}, {error:e}"
        );
    }
}

/// A free box, or another robot on the ground, with each point pressed in by its contact model.
fn on_ground(model: Model, law: ContactLaw) -> Simulator {
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    Simulator::new(model)
        .with_time_step(2e-3)
        .with_integrator(Integrator::ImplicitVelocity)
        .with_contacts(contacts)
}

#[test]
fn accelerometer_at_rest_shows_gravity_from_its_tilt() {
    let simulator = Simulator::new(samples::pendulum());
    let rod = frame(simulator.model(), "rod");
    for q in [0.0_f64, 0.7, -2.5, FRAC_PI_2] {
        let (sin, cos) = q.sin_cos();
        let held = [0.5 * G * sin];
        let state = State::new(&[q], &[0.0]);
        let y = read(&simulator, Sensor::Accelerometer(rod), &state, &held);
        assert_near("tilt", &y, &[0.0, G * sin, G * cos], 1e-12);
    }
}

#[test]
fn accelerometer_in_free_fall_reads_zero_and_on_a_carousel_the_centripetal_acceleration() {
    let falling = Simulator::new(asset("box.urdf"));
    let state = falling.neutral_state();
    let link = falling.model().link_frames()[0];
    let y = read(&falling, Sensor::Accelerometer(link), &state, &[]);
    assert_near("free fall", &y, &[0.0; 3], 1e-12);

    let model = samples::pendulum().with_gravity(Vector3::zeros());
    let mut builder = model.to_builder();
    builder.add_frame(
        "tip",
        "rod",
        Transform::from_translation(vector![0.0, 0.0, -1.0]),
    );
    let simulator = Simulator::new(builder.build().expect("a robot"));
    let tip = frame(simulator.model(), "tip");
    let spinning = State::new(&[0.3], &[4.0]);
    let y = read(&simulator, Sensor::Accelerometer(tip), &spinning, &[0.0]);
    assert_near("carousel", &y, &[0.0, 0.0, 16.0], 1e-12); // ω² r towards the pivot
    let gyro = read(&simulator, Sensor::Gyro(tip), &spinning, &[0.0]);
    assert_near("gyroscope", &gyro, &[4.0, 0.0, 0.0], 1e-14);
}

#[test]
fn magnetometer_and_pose_follow_the_turn_of_the_frame() {
    let simulator = Simulator::new(samples::pendulum());
    let rod = frame(simulator.model(), "rod");
    let (sin, cos) = 0.4_f64.sin_cos();
    let state = State::new(&[0.4], &[2.0]);
    let field = Sensor::Magnetometer {
        frame: rod,
        field: [0.2, 0.0, -0.5],
    };
    let y = read(&simulator, field, &state, &[0.0]);
    assert_near("field", &y, &[0.2, -0.5 * sin, -0.5 * cos], 1e-15);
    let pose = read(&simulator, Sensor::FramePose(rod), &state, &[0.0]);
    let half = [0.2_f64.cos(), 0.2_f64.sin()];
    assert_near(
        "pose",
        &pose,
        &[0.0, 0.0, 0.0, half[0], half[1], 0.0, 0.0],
        1e-15,
    );
}

// F = m (a − g) of the centre of mass, in axes of the rod: (0, ½ α l + g sin q, ½ ω² l + g cos q) m.
#[test]
fn pivot_of_a_swinging_pendulum_bears_the_closed_form() {
    let simulator = Simulator::new(samples::pendulum());
    let rod = frame(simulator.model(), "rod");
    for (q, v, u) in [(0.0_f64, 0.0, 0.0), (0.8, -3.0, 0.0), (-2.0, 1.0, 0.7)] {
        let (sin, cos) = q.sin_cos();
        let alpha = 3.0 * u - 1.5 * G * sin;
        let state = State::new(&[q], &[v]);
        let y = read(&simulator, Sensor::Wrench(rod), &state, &[u]);
        let force = [0.0, 0.5 * alpha + G * sin, 0.5 * v * v + G * cos];
        assert_near("force", &y[..3], &force, 1e-12);
        assert_near("torque", &y[3..], &[u, 0.0, 0.0], 1e-12);
        let pivot = simulator.model().find_joint("pivot").expect("a joint");
        let torque = read(&simulator, Sensor::JointForce(pivot), &state, &[u]);
        assert_near("torque along the axis", &torque, &[u], 1e-12);
    }
}

// The torque that accelerates a rotor does not pass the joint: τ = u − I_r α.
#[test]
fn torque_behind_a_rotor_is_that_of_the_motor_less_its_inertia() {
    let simulator = Simulator::new(samples::pendulum().with_armature(0, 0.2));
    let pivot = simulator.model().find_joint("pivot").expect("a joint");
    let y = read(
        &simulator,
        Sensor::JointForce(pivot),
        &State::new(&[0.0], &[0.0]),
        &[1.0],
    );
    assert_near("torque", &y, &[1.0 - 0.2 / (1.0 / 3.0 + 0.2)], 1e-12);
}

/// A forearm on a hinge, with a sensor plate and a tool fixed to it, which carries a finger on a hinge; the stand is fixed to the world.
fn tool() -> Model {
    let mut builder = ModelBuilder::new("tool");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("stand").with_mass(5.0, [0.1, 0.0, 0.2], [0.1; 3]));
    builder.add_link(LinkSpec::new("forearm").with_mass(2.0, [0.2, 0.0, 0.0], [0.01, 0.05, 0.05]));
    builder.add_link(LinkSpec::new("plate"));
    builder.add_link(LinkSpec::new("tool").with_mass(0.3, [0.05, 0.02, 0.0], [1e-3, 2e-3, 2e-3]));
    builder.add_link(LinkSpec::new("finger").with_mass(0.1, [0.0, 0.0, 0.03], [1e-4, 1e-4, 2e-5]));
    let fixed = |name: &str, parent: &str, child: &str| {
        JointSpec::new(name, JointKind::Fixed, parent, child)
    };
    builder.add_joint(fixed("foot", "world", "stand"));
    builder.add_joint(
        JointSpec::new("elbow", JointKind::Continuous, "stand", "forearm")
            .with_axis([0.0, 1.0, 0.3])
            .with_translation([0.0, 0.0, 0.5]),
    );
    builder.add_joint(fixed("flange", "forearm", "plate").with_translation([0.4, 0.0, 0.0]));
    builder.add_joint(fixed("mount", "plate", "tool").with_translation([0.0, 0.01, 0.05]));
    builder.add_joint(
        JointSpec::new("knuckle", JointKind::Continuous, "tool", "finger")
            .with_axis([1.0, 0.0, 0.0])
            .with_translation([0.1, 0.0, 0.0]),
    );
    builder.build().expect("a robot that is known to be right")
}

#[test]
fn wrist_between_fixed_links_bears_what_accelerates_the_tool() {
    let model = tool();
    let [tool, finger] = ["tool", "finger"].map(|name| frame(&model, name));
    let simulator = Simulator::new(model.clone());
    let (q, v) = ([0.4, -1.1], [1.5, -2.0]);
    let (state, u) = (State::new(&q, &v), [0.6, 0.05]);
    let a = simulator.acceleration(&state, &u);
    let y = read(&simulator, Sensor::Wrench(tool), &state, &u);
    // Σ m (a_c − g) of tool and finger, along the axes of the tool
    let mut force = Vector3::zeros();
    for (link, mass, com) in [
        (tool, 0.3, [0.05, 0.02, 0.0]),
        (finger, 0.1, [0.0, 0.0, 0.03]),
    ] {
        let a = frame_acceleration(&model, &q, &v, a.as_slice(), link, Representation::Mixed);
        let v = frame_velocity(&model, &q, &v, link, Representation::Mixed);
        let r = frame_pose(&model, &q, link).rotation * Vector3::from(com);
        let of_com = a.linear + a.angular.cross(&r) + v.angular.cross(&v.angular.cross(&r));
        force += (of_com + vector![0.0, 0.0, G]) * mass;
    }
    let seen = frame_pose(&model, &q, tool).rotation.transpose() * force;
    assert_near("wrist", &y[..3], seen.as_slice(), 1e-12);
    // The plate has no mass: it transmits the wrench of the tool, in its own frame.
    let plate = read(
        &simulator,
        Sensor::Wrench(frame(&model, "plate")),
        &state,
        &u,
    );
    let arm = vector![0.0, 0.01, 0.05];
    let moment = Vector3::from_column_slice(&y[3..]) + arm.cross(&seen);
    assert_near("plate", &plate[..3], seen.as_slice(), 1e-12);
    assert_near("plate", &plate[3..], moment.as_slice(), 1e-12);
}

#[test]
fn foundation_of_a_robot_at_rest_bears_its_weight() {
    let model = tool();
    let stand = frame(&model, "stand");
    let held = dualbody::dynamics::gravity_forces(&model, &[0.3, 0.2]);
    let simulator = Simulator::new(model);
    let state = State::new(&[0.3, 0.2], &[0.0; 2]);
    let y = read(&simulator, Sensor::Wrench(stand), &state, held.as_slice());
    assert_near(
        "weight",
        &y[..3],
        &[0.0, 0.0, (5.0 + 2.0 + 0.3 + 0.1) * G],
        1e-10,
    );
}

#[test]
fn push_on_the_tool_shows_between_tool_and_arm_and_not_behind_it() {
    let model = tool();
    let push = Force::new(vector![1.0, 2.0, 3.0], vector![0.1, 0.0, -0.2]);
    let place = Anchor::frame(&model, "tool").expect("a frame");
    let held = dualbody::dynamics::gravity_forces(&model, &[0.0; 2]);
    let plain = Simulator::new(model.clone()).with_integrator(Integrator::RungeKutta4);
    let pushed = plain
        .clone()
        .with_external_forces(vec![ExternalForce::constant(
            place,
            push,
            Representation::Body,
        )]);
    let state = State::new(&[0.0; 2], &[0.0; 2]);
    let all = Sensors::new(&model, [("tool", Sensor::Wrench(frame(&model, "tool")))]);
    // The same acceleration in both: the input balances the push along the joints.
    let tau = dualbody::dynamics::frame_jacobian(
        &model,
        &[0.0; 2],
        frame(&model, "tool"),
        Representation::Body,
    )
    .transpose()
        * nalgebra::DVector::from_row_slice(&push.to_array());
    let balanced = held.clone() - tau;
    let before = all.read(&plain, &state, held.as_slice());
    let after = all.read(&pushed, &state, balanced.as_slice());
    let difference: Vec<f64> = (before - after).as_slice().to_vec();
    assert_near("push", &difference, &push.to_array(), 1e-10);
}

#[test]
fn box_at_rest_is_touched_by_its_weight() {
    for law in [
        ContactLaw::Rigid(Rigid::default()),
        ContactLaw::Soft(SoftContact::estimate(1.0, 8, 1e-3)),
    ] {
        let simulator = on_ground(asset("box.urdf"), law);
        let model = simulator.model().clone();
        let weight = model.total_mass() * G;
        let link = model.link_frames()[0];
        let mut state = simulator.neutral_state();
        state.q[2] = 0.0605;
        let settled = simulator.rollout(&state, 1500, |_, _, _| {});
        let state = settled.last();
        let touch = read(&simulator, Sensor::Touch(link), state, &[]);
        assert_near("touch", &touch, &[weight], 1e-3 * weight);
        let wrench = read(&simulator, Sensor::ContactForce(link), state, &[]);
        assert_near("force", &wrench[..3], &[0.0, 0.0, weight], 2e-3 * weight);
    }
}

// A floating base is held by nothing: contact, pushes and the robot's own inertia balance.
#[test]
fn joint_of_a_floating_base_transmits_nothing() {
    let model = asset("quadruped.urdf");
    let base = model.link_frames()[0];
    let thruster = Anchor::frame(&model, model.link_names()[3]).expect("a link");
    let contacts = Contacts::new(
        &model,
        Terrain::incline(0.1),
        ContactLaw::Rigid(Rigid::default()),
    );
    let simulator = Simulator::new(model.clone())
        .with_time_step(1e-3)
        .with_contacts(contacts)
        .with_frame_actuators(vec![FrameActuator::thruster(
            "thruster",
            thruster,
            [0.0, 0.0, 1.0],
            0.1,
        )]);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut state = simulator.neutral_state();
    state.v = model.random_velocity(&mut rng, 0.5);
    state.q[2] = 0.1;
    let u = vec![0.4; simulator.nu()];
    let y = read(&simulator, Sensor::Wrench(base), &state, &u);
    let touched = read(&simulator, Sensor::ContactForce(base), &state, &u);
    assert!(touched.iter().any(|x| x.abs() > 1.0) || simulator.contacts().is_some());
    assert_near("base", &y, &[0.0; 6], 1e-6);
}

// In a closed loop the pins bear forces, and joints transmit the forces of motors along their axes.
#[test]
fn joints_of_a_closed_loop_transmit_what_motors_give() {
    let simulator = four_bar();
    let model = simulator.model();
    let start = simulator
        .assemble(&simulator.neutral_state())
        .expect("a start")
        .state;
    let names = model.joint_names();
    let sensors = Sensors::new(
        model,
        names.iter().map(|name| {
            (
                *name,
                Sensor::JointForce(model.find_joint(name).expect("a joint")),
            )
        }),
    );
    let u: Vec<f64> = (0..simulator.nu()).map(|k| 0.3 - 0.2 * k as f64).collect();
    let y = sensors.read(&simulator, &start, &u);
    let mut tau = vec![0.0; model.nv()];
    for (u, &k) in u.iter().zip(simulator.actuated()) {
        tau[k] = *u;
    }
    assert_near("loop", y.as_slice(), &tau, 1e-8);
}

#[test]
fn readings_of_a_step_equal_those_of_its_state_and_input() {
    let model = samples::arm();
    let tool = frame(&model, "tool");
    let mut sensors = vec![
        ("imu".to_owned(), Sensor::Accelerometer(tool)),
        ("wrench".to_owned(), Sensor::Wrench(model.link_frames()[3])),
        ("pose".to_owned(), Sensor::FramePose(tool)),
        ("momentum".to_owned(), Sensor::Momentum),
    ];
    for name in model.joint_names() {
        let joint = model.find_joint(name).expect("a joint");
        sensors.push((format!("{name} position"), Sensor::JointPosition(joint)));
        sensors.push((format!("{name} velocity"), Sensor::JointVelocity(joint)));
    }
    let sensors = Sensors::new(&model, sensors);
    assert_eq!(sensors.names().len(), sensors.units().len());
    for integrator in [
        Integrator::SemiImplicitEuler,
        Integrator::ImplicitVelocity,
        Integrator::RungeKutta4,
        Integrator::ImplicitMidpoint,
    ] {
        let simulator = Simulator::new(model.clone()).with_integrator(integrator);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let state = State::random(&model, &mut rng, 1.0);
        let u = [0.5, -1.0, 2.0, 0.1, 0.0, 0.2, -0.3];
        let (mut step, mut next) = (StepScratch::new(&simulator), state.clone());
        let mut scratch = SensorScratch::new(&simulator);
        let mut y = vec![0.0; sensors.len()];
        simulator.step_into(&state, &u, &mut step, &mut next);
        sensors.read_step_into(&simulator, &state, &u, &step, &mut scratch, &mut y);
        assert_eq!(y, sensors.read(&simulator, &state, &u).as_slice());
        let first = format!("{} position", model.joint_names()[0]);
        let at = sensors.range(&first).expect("a sensor").start;
        assert_eq!(
            y[at], state.q[0],
            "readings belong to the start of the step"
        );
    }
}

/// An arm that swings, that rotates fast, that is pushed against a limit, whose joints are held by dry friction; a loop.
fn arms() -> Vec<(&'static str, Simulator, f64)> {
    let arm = || Simulator::new(asset("ur5.urdf")).with_time_step(1e-3);
    let held = |k: usize| Actuator {
        friction: Some(CoulombFriction::exact([0.1, 200.0][k % 2])),
        ..Actuator::default()
    };
    let held: Vec<Actuator> = (0..arm().model().nv()).map(held).collect();
    let held = Actuation::ideal(arm().model()).with_actuators(&held);
    let limited = Actuation::from_model(arm().model());
    vec![
        ("arm", arm(), 1.0),
        ("fast arm", arm(), 400.0),
        (
            "implicit arm",
            arm().with_integrator(Integrator::ImplicitVelocity),
            1.0,
        ),
        ("arm against limits", arm().with_actuation(limited), 40.0),
        ("arm with dry friction", arm().with_actuation(held), 1.0),
        ("loop", four_bar().with_time_step(1e-3), 0.0),
    ]
}

/// Poses, velocities and accelerations that a step has left are taken over: those of this step, not of another one with the same memory.
#[test]
fn readings_of_steps_in_a_row_are_those_of_their_changes_of_velocity() {
    for (name, simulator, speed) in arms() {
        let model = simulator.model();
        let last = *model.link_frames().last().expect("a link");
        let mixed = Representation::Mixed;
        let acceleration = Sensor::FrameAcceleration {
            frame: last,
            representation: mixed,
        };
        let all = [("a", acceleration), ("w", Sensor::Gyro(last))];
        let sensors = Sensors::new(model, all);
        let (mut step, mut scratch) =
            (StepScratch::new(&simulator), SensorScratch::new(&simulator));
        let mut state = simulator.neutral_state();
        for k in 0..model.nv() {
            state.v[k] = speed * (k as f64 + 1.0) / model.nv() as f64;
        }
        let (u, mut y) = (vec![0.5; simulator.nu()], vec![0.0; sensors.len()]);
        for k in 0..300 {
            let mut next = state.clone();
            simulator.step_into(&state, &u, &mut step, &mut next);
            sensors.read_step_into(&simulator, &state, &u, &step, &mut scratch, &mut y);
            let (q, v) = (state.q.as_slice(), state.v.as_slice());
            let a = (&next.v - &state.v) / 1e-3;
            let expected = frame_acceleration(model, q, v, a.as_slice(), last, mixed);
            let turning = frame_velocity(model, q, v, last, Representation::Body).angular;
            let expected = [&expected.to_array()[..], turning.as_slice()].concat();
            let largest = expected.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
            for (y, expected) in y.iter().zip(&expected) {
                let error = (y - expected).abs() / largest;
                assert!(error < 1e-7, "{name}, step {k}: {y}, expected {expected}");
            }
            state = next;
        }
    }
}

#[test]
fn momentum_and_centre_of_mass_of_a_pendulum_equal_the_closed_forms() {
    let simulator = Simulator::new(samples::pendulum());
    let (q, v) = (0.4_f64, 6.0);
    let (sin, cos) = q.sin_cos();
    let state = State::new(&[q], &[v]);
    let com = read(&simulator, Sensor::CenterOfMass, &state, &[0.0]);
    assert_near("centre", &com, &[0.0, 0.5 * sin, -0.5 * cos], 1e-14);
    let velocity = read(&simulator, Sensor::CenterOfMassVelocity, &state, &[0.0]);
    assert_near("velocity", &velocity, &[0.0, 3.0 * cos, 3.0 * sin], 1e-14);
    let momentum = read(&simulator, Sensor::Momentum, &state, &[0.0]);
    let expected = [0.0, 3.0 * cos, 3.0 * sin, 0.5, 0.0, 0.0];
    assert_near("momentum", &momentum, &expected, 1e-14);
}

/// Waves of 0.2 m.
struct Waves;

impl HeightFunction for Waves {
    fn height<T: Scalar>(&self, x: T, _: T, _: &[T]) -> T {
        (x * 1.5).sin_cos().0 * 0.2
    }
}

/// A range finder that looks along a direction from a height, above terrain.
fn range_to(terrain: Terrain, direction: [f64; 3], height: f64) -> f64 {
    let model = asset("sphere.urdf");
    let link = model.link_frames()[0];
    let contacts = Contacts::new(&model, terrain, ContactLaw::Rigid(Rigid::default()));
    let simulator = Simulator::new(model).with_contacts(contacts);
    let mut state = simulator.neutral_state();
    state.q[2] = height;
    let finder = Sensor::RangeFinder {
        frame: link,
        direction,
        range: 20.0,
    };
    read(&simulator, finder, &state, &[])[0]
}

#[test]
fn range_to_terrain_equals_the_closed_form() {
    let flat = || Terrain::flat(0.5);
    assert_near(
        "down",
        &[range_to(flat(), [0.0, 0.0, -3.0], 2.0)],
        &[1.5],
        1e-12,
    );
    let slant = range_to(flat(), [1.0, 0.0, -1.0], 2.0);
    assert_near("slant", &[slant], &[1.5 * 2.0_f64.sqrt()], 1e-12);
    assert_eq!(range_to(flat(), [1.0, 0.0, 0.1], 2.0), 20.0, "into the sky");
    assert_eq!(
        range_to(flat(), [1.0, 0.0, 0.0], 2.0),
        20.0,
        "along the ground"
    );
    assert_eq!(
        range_to(flat(), [0.0, 0.0, -1.0], 0.0),
        0.0,
        "below the ground"
    );
    let incline = range_to(Terrain::incline(0.3), [-1.0, 0.0, 0.0], 2.0);
    assert_eq!(incline, 20.0, "downhill");
    let uphill = range_to(Terrain::incline(0.3), [1.0, 0.0, 0.0], 2.0);
    assert_near("uphill", &[uphill], &[2.0 / 0.3_f64.tan()], 1e-12);
    let waves = || Terrain::Function(TerrainFunction::new(Waves, &[]));
    let across = range_to(waves(), [1.0, 0.0, -1.0], 2.0);
    let x = across / 2.0_f64.sqrt();
    assert_near("waves", &[2.0 - x], &[0.2 * (1.5 * x).sin()], 1e-12);
    assert_eq!(
        range_to(waves(), [1.0, 0.0, 0.2], 2.0),
        20.0,
        "over the waves"
    );
}

/// The distance from the origin along x to a shape at a place, turned about y.
fn range_to_shape(geometry: Geometry, placement: Transform<f64>) -> f64 {
    let mut builder = ModelBuilder::new("wall").with_base(Base::Fixed);
    builder.add_link(LinkSpec::new("world").with_collision(Collision {
        name: None,
        placement,
        geometry,
    }));
    builder.add_link(LinkSpec::new("eye").with_mass(1.0, [0.0; 3], [1.0; 3]));
    builder.add_joint(JointSpec::new(
        "turn",
        JointKind::Continuous,
        "world",
        "eye",
    ));
    let simulator = Simulator::new(builder.build().expect("a robot"));
    let eye = Sensor::RangeFinder {
        frame: frame(simulator.model(), "eye"),
        direction: [1.0, 0.0, 0.0],
        range: 50.0,
    };
    read(&simulator, eye, &State::new(&[0.0], &[0.0]), &[0.0])[0]
}

#[test]
fn range_to_shapes_equals_the_closed_form() {
    let at = |x: f64, y: f64| Transform::from_translation(vector![x, y, 0.0]);
    let sphere = Geometry::Sphere { radius: 1.0 };
    assert_near(
        "sphere",
        &[range_to_shape(sphere.clone(), at(3.0, 0.6))],
        &[2.2],
        1e-12,
    );
    assert_eq!(
        range_to_shape(sphere.clone(), at(3.0, 1.1)),
        50.0,
        "past the sphere"
    );
    assert_eq!(
        range_to_shape(sphere.clone(), at(-3.0, 0.0)),
        50.0,
        "behind"
    );
    assert_near(
        "inside",
        &[range_to_shape(sphere, at(0.5, 0.0))],
        &[1.5],
        1e-12,
    );
    let cube = Geometry::Box {
        size: [2.0, 4.0, 6.0],
    };
    assert_near(
        "box",
        &[range_to_shape(cube.clone(), at(5.0, 1.9))],
        &[4.0],
        1e-12,
    );
    assert_eq!(range_to_shape(cube, at(5.0, 2.1)), 50.0, "past the box");
    let (radius, length) = (0.5, 2.0);
    let cylinder = Geometry::Cylinder { radius, length };
    assert_near(
        "side",
        &[range_to_shape(cylinder.clone(), at(3.0, 0.3))],
        &[2.6],
        1e-12,
    );
    let lying = Transform::new(
        dualbody::spatial::Quaternion::exp(&vector![0.0, FRAC_PI_2, 0.0]).to_matrix(),
        vector![3.0, 0.3, 0.0],
    );
    assert_near("lid", &[range_to_shape(cylinder, lying)], &[2.0], 1e-9);
    let capsule = Geometry::Capsule { radius, length };
    assert_near(
        "end",
        &[range_to_shape(capsule.clone(), lying)],
        &[3.0 - 1.0 - 0.4],
        1e-9,
    );
    assert_near(
        "side",
        &[range_to_shape(capsule, at(3.0, 0.3))],
        &[2.6],
        1e-12,
    );
}

#[test]
#[should_panic(expected = "have the name \"imu\"")]
fn names_that_are_given_twice_are_refused() {
    let model = samples::pendulum();
    let rod = frame(&model, "rod");
    let _ = Sensors::new(
        &model,
        [("imu", Sensor::Gyro(rod)), ("imu", Sensor::Gyro(rod))],
    );
}

#[test]
#[should_panic(expected = "belong to another robot")]
fn another_robot_is_refused() {
    let sensors = Sensors::new(&samples::pendulum(), [("com", Sensor::CenterOfMass)]);
    let other = Simulator::new(samples::cartpole());
    let _ = sensors.read(&other, &other.neutral_state(), &[0.0; 2]);
}
