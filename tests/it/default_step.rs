//! Defaults of the simulator: integrator and step stay finite on robots whose dampers, friction, joint limits and
//! fast wrists make a step of explicit forces diverge; and the report of a rollout that fails.

use std::path::{Path, PathBuf};

use dualbody::autodiff::{VectorFunction, finite_difference, jacobian};
use dualbody::cone::Status;
use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::HuntCrossley;
use dualbody::dynamics::{kinetic_energy, mass_matrix_inverse};
use dualbody::joint::JointKind;
use dualbody::model::{JointSpec, Limits, LinkSpec, ModelBuilder, samples};
use dualbody::sim::{Actuation, Actuator, BatchSimulator, PositionLimits, RolloutStatus};
use dualbody::{Integrator, Model, Scalar, Simulator, State};
use nalgebra::{DMatrix, Vector3};

use crate::common::{FINITE_DIFFERENCE, SAME_ALGEBRA, asset, generator, gripper, robots};

/// As many steps as robots are left to themselves.
const STEPS: usize = 2000;

/// A heavy arm with a wrist of three light links of so much inertia about each axis, kg·m², with dampers and friction.
fn wrist(inertia: f64, damping: f64, friction: f64) -> Model {
    let mut builder = ModelBuilder::new("wrist");
    builder.add_link(LinkSpec::new("world"));
    let axes = [
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
    ];
    let mut parent = "world".to_owned();
    for (k, axis) in axes.into_iter().enumerate() {
        let name = format!("link{k}");
        let link = LinkSpec::new(&name);
        builder.add_link(if k == 0 {
            link.with_mass(2.0, [0.0, 0.0, 0.2], [0.02, 0.02, 0.01])
        } else {
            link.with_mass(
                0.02,
                [1e-3, 2e-3, 5e-3],
                [inertia, 2.0 * inertia, 0.4 * inertia],
            )
        });
        let limits = Limits {
            lower: Some(-2.0),
            upper: Some(2.0),
            velocity: Some(20.0),
            ..Limits::default()
        };
        builder.add_joint(
            JointSpec::new(format!("joint{k}"), JointKind::Revolute, parent, &name)
                .with_axis(axis)
                .with_translation([0.0, 0.0, if k == 1 { 0.4 } else { 0.01 }])
                .with_limits(limits)
                .with_damping(damping)
                .with_friction(friction),
        );
        parent = name;
    }
    builder.build().expect("a robot that is known to be right")
}

/// Largest Δt eig(M⁻¹ D): explicit damping is stable below 2.
fn stiffness_of_damping(model: &Model, dt: f64) -> f64 {
    let inverse = mass_matrix_inverse(model, model.neutral().as_slice());
    let damping = DMatrix::from_diagonal(&nalgebra::DVector::from_column_slice(model.damping()));
    let values = (inverse * damping).complex_eigenvalues();
    dt * values.iter().map(|x| x.re).fold(0.0, f64::max)
}

/// Steps of the default simulator from random states, without and with the limits and friction of the model; the first
/// that diverges.
fn divergence(model: &Model, seeds: u64) -> Option<(u64, bool, RolloutStatus)> {
    let plain = Simulator::new(model.clone());
    let limited = plain.clone().with_actuation(Actuation::from_model(model));
    for seed in 0..seeds {
        let start = State::random(model, &mut generator(seed), 1.0);
        for (simulator, with_limits) in [(&plain, false), (&limited, true)] {
            let rollout = simulator.rollout(&start, STEPS, |_, _, _| {});
            if rollout.status != RolloutStatus::Completed {
                return Some((seed, with_limits, rollout.status));
            }
        }
    }
    None
}

#[test]
fn default_step_stays_finite_on_light_links_with_dampers_and_friction_of_any_strength() {
    let damped = wrist(1e-6, 1.0, 0.0);
    let stiffness = stiffness_of_damping(&damped, 1e-3);
    assert!(stiffness > 500.0, "{stiffness}");
    let robots = [
        damped,
        wrist(1e-6, 0.0, 0.5),
        wrist(1e-5, 0.01, 0.1),
        wrist(1e-6, 0.0, 0.0),
        gripper().build().expect("followers"),
    ];
    for model in robots {
        let failed = divergence(&model, 5);
        assert!(failed.is_none(), "{}: {failed:?}", model.name());
    }
}

#[test]
fn default_step_stays_finite_on_all_robots_at_hand() {
    let files = ["panda", "ur5", "quadruped", "humanoid", "hopper", "acrobot"];
    let loaded = files.map(|name| asset(&format!("{name}.urdf")));
    for model in robots().into_iter().chain(loaded) {
        let failed = divergence(&model, 2);
        assert!(failed.is_none(), "{}: {failed:?}", model.name());
    }
}

/// Descriptions in a folder and those below it.
fn descriptions(folder: &Path, out: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            descriptions(&path, out);
        } else if path.extension().is_some_and(|kind| kind == "urdf") {
            out.push(path);
        }
    }
}

/// `DUALBODY_ROBOTS=<folder> cargo test --release --test it -- --ignored --nocapture default_step_stays_finite_on_every_robot_of_a_folder`
#[test]
#[ignore = "needs a folder of descriptions in DUALBODY_ROBOTS"]
fn default_step_stays_finite_on_every_robot_of_a_folder() {
    let folder = std::env::var_os("DUALBODY_ROBOTS").expect("a folder");
    let mut paths = Vec::new();
    descriptions(Path::new(&folder), &mut paths);
    paths.sort();
    let (mut loaded, mut singular, mut failed) = (0, 0, Vec::new());
    for path in &paths {
        let Ok(model) = Model::from_urdf_file(path) else {
            println!("{} does not load", path.display());
            continue;
        };
        loaded += 1;
        if let Err(error) = model.check_mass_matrix() {
            println!("{}: {error}", path.display());
            singular += 1;
            continue;
        }
        if let Some(failure) = divergence(&model, 3) {
            println!("{}: {failure:?}", path.display());
            failed.push(path);
        }
    }
    println!(
        "{} files, {loaded} load, {singular} of them cannot be simulated, {} diverge",
        paths.len(),
        failed.len()
    );
    assert!(loaded > 0 && failed.is_empty(), "{failed:?}");
}

// Without gravity only the method can change the energy of a wrist that turns by 0.3 rad in a step.
#[test]
fn whirling_wrist_keeps_its_energy_where_explicit_forces_would_multiply_it() {
    let model = wrist(1e-5, 0.0, 0.0).with_gravity(Vector3::zeros());
    let simulator = Simulator::new(model.clone());
    let start = State::new(&[0.1, 0.2, 0.7, -0.4], &[0.5, 250.0, 100.0, 300.0]);
    let energy = |s: &State| kinetic_energy(&model, s.q.as_slice(), s.v.as_slice());
    let rollout = simulator.rollout(&start, STEPS, |_, _, _| {});
    assert_eq!(rollout.status, RolloutStatus::Completed);
    let first = energy(&start);
    let largest = rollout.states.iter().map(energy).fold(0.0, f64::max);
    println!("whirling wrist: {first} J, at most {largest} J");
    assert!(largest < 3.0 * first, "{first} J becomes {largest} J");
}

// The share of the middle of the step grows as 3 x² − 2 x³ from one speed to twice it: neither value nor slope of the
// step jump.
#[test]
fn step_and_its_slope_are_continuous_where_whirling_begins_and_ends() {
    const WHIRLING: usize = 2;
    let model = wrist(1e-5, 0.0, 0.0);
    for (dt, slow) in [(2e-4, 500.0), (1e-3, 100.0), (5e-3, 100.0)] {
        let simulator = Simulator::new(model.clone()).with_time_step(dt);
        for speed in [0.9 * slow, slow, 1.5 * slow, 2.0 * slow, 2.1 * slow] {
            let at = |speed: f64| {
                let v = [0.5, 0.3 * slow, -speed, 0.2 * slow];
                State::new(&[0.1, 0.2, 0.7, -0.4], &v)
            };
            let small = 1e-5 * slow;
            let [below, here, above] =
                [-small, 0.0, small].map(|by| simulator.step(&at(speed + by), &[0.0; 4]));
            let exact = simulator.linearize(&at(speed), &[0.0; 4]).a;
            let exact = -exact.column(4 + WHIRLING);
            let sides = [(&above, &here), (&here, &below)];
            for (one, other) in sides {
                let slope = one.deviation(&model, other) / small;
                let error = (slope - &exact).amax() / exact.amax();
                assert!(error < 1e-3, "{dt} s, {speed} rad/s: {error:e}");
            }
        }
    }
}

// m (v⁺ − v) / Δt = −d v⁺ − k (q + Δt v⁺) + u,  as in MuJoCo's Euler for the damper.
#[test]
fn default_step_takes_dampers_and_springs_at_its_end() {
    let pendulum = samples::pendulum().with_gravity(Vector3::zeros());
    let spring = dualbody::model::Spring {
        stiffness: 40.0,
        rest: 0.0,
    };
    for (d, dt) in [(0.1, 1e-3), (1e4, 1e-2)] {
        let model = pendulum.clone().with_damping(0, d).with_spring(0, spring);
        let simulator = Simulator::new(model).with_time_step(dt);
        let next = simulator.step(&State::new(&[0.3], &[-1.2]), &[4.0]);
        let inertia = 1.0 / 3.0;
        let expected = (inertia * -1.2 + dt * (4.0 - 40.0 * 0.3))
            / (inertia + dt * d + dt * dt * spring.stiffness);
        assert!((next.v[0] - expected).abs() < SAME_ALGEBRA);
    }
}

/// A robot with narrow, hard stops in all joints of one axis.
fn stopped(model: Model) -> Simulator {
    let stop = HuntCrossley::linear(1e7, 1e4);
    let ends = PositionLimits {
        lower: Some(-0.3),
        upper: Some(0.4),
        stop,
    };
    let mut actuation = Actuation::ideal(&model);
    for joint in model.joints() {
        let own = Actuator {
            position: Some(ends),
            ..Actuator::default()
        };
        if model.body(joint.body).joint.nq() == 1 && model.body(joint.body).coupling.is_none() {
            actuation = actuation
                .with_actuator(&model, &joint.name, own)
                .expect("a joint");
        }
    }
    Simulator::new(model).with_actuation(actuation)
}

#[test]
fn stops_of_the_default_step_hold_at_any_stiffness_and_never_pull() {
    let model = wrist(1e-6, 0.0, 0.0).with_gravity(Vector3::zeros());
    let simulator = stopped(model.clone());
    let stop_free = Simulator::new(model);
    for seed in 0..5 {
        let mut state = State::random(simulator.model(), &mut generator(seed), 1.0);
        state.q *= 0.15;
        for step in 0..STEPS {
            let next = simulator.step(&state, &[0.0; 4]);
            let out = next.q.iter().map(|&q| (q - 0.4).max(-0.3 - q).max(0.0));
            let deepest = out.fold(0.0, f64::max);
            assert!(deepest < 0.02, "seed {seed}, step {step}: {deepest} beyond");
            // Where every joint is on its way out of the stops or within them, they do nothing.
            let dt = simulator.time_step();
            let leaving = (0..4).all(|k| {
                let ahead = state.q[k] + dt * state.v[k];
                (-0.3..=0.4).contains(&ahead) && (-0.3..=0.4).contains(&state.q[k])
            });
            if leaving {
                assert_eq!(next, stop_free.step(&state, &[0.0; 4]), "step {step}");
            }
            state = next;
        }
    }
}

#[test]
fn batches_with_stops_dampers_and_whirling_lanes_equal_single_simulators_bit_for_bit() {
    let floating = {
        let mut builder = ModelBuilder::new("body");
        builder.add_link(LinkSpec::new("body").with_mass(1.0, [0.01; 3], [0.01, 0.02, 0.03]));
        builder.build().expect("a robot that is known to be right")
    };
    let simulators = [
        stopped(wrist(1e-6, 1.0, 0.0)),
        stopped(wrist(1e-6, 0.0, 0.0)),
        Simulator::new(wrist(1e-6, 0.0, 0.0)),
        Simulator::new(floating),
        Simulator::new(gripper().build().expect("followers")),
    ];
    for simulator in simulators {
        for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
            let simulator = simulator.clone().with_integrator(integrator);
            let starts: Vec<State> = (0..11)
                .map(|k| {
                    let mut start = State::random(simulator.model(), &mut generator(k), 1.0);
                    start.v *= 40.0 * k as f64; // some whirl, some do not
                    start
                })
                .collect();
            let batch = BatchSimulator::new(simulator.clone(), starts.len());
            let all = batch.with_threads(1).rollout(&starts, 60, |_, _, _| {});
            for (i, start) in starts.iter().enumerate() {
                let single = simulator.rollout(start, 60, |_, _, _| {});
                let name = simulator.model().name();
                assert_eq!(all.status(i), single.status, "{name} {integrator:?} {i}");
                assert_eq!(all.last(i), *single.last(), "{name} {integrator:?} {i}");
            }
        }
    }
}

#[test]
fn rollouts_end_where_the_bound_on_speed_is_passed_alone_and_in_batches() {
    // v⁺ = v + Δt u / J with J = 1/3 kg·m²: 0.3 rad/s more with each step.
    let model = samples::pendulum().with_gravity(Vector3::zeros());
    let simulator = Simulator::new(model)
        .with_time_step(0.01)
        .with_divergence_bound(2.0);
    let start = State::new(&[0.0], &[0.0]);
    let pushed = simulator.rollout(&start, 100, |_, _, u| u[0] = 10.0);
    assert_eq!(pushed.status, RolloutStatus::Diverged { step: 6 });
    assert_eq!(pushed.states.len(), 7);
    let mut batch = BatchSimulator::new(simulator.clone(), 3);
    let starts = vec![start; 3];
    let all = batch.rollout(&starts, 100, |moment, _, u| {
        u[0] = moment.gather(|i| [0.0, 10.0, -5.0][i]);
    });
    let expected = [
        RolloutStatus::Completed,
        RolloutStatus::Diverged { step: 6 },
        RolloutStatus::Diverged { step: 13 },
    ];
    assert_eq!([0, 1, 2].map(|i| all.status(i)), expected);
    // A velocity far out of the physical ends a rollout long before it overflows.
    let unbounded = simulator.clone().with_divergence_bound(f64::INFINITY);
    let huge = State::new(&[0.0], &[1e7]);
    let statuses = [Simulator::new(samples::pendulum()), unbounded]
        .map(|simulator| simulator.rollout(&huge, 3, |_, _, _| {}).status);
    let expected = [
        RolloutStatus::Diverged { step: 0 },
        RolloutStatus::Completed,
    ];
    assert_eq!(statuses, expected);
}

#[test]
#[should_panic(
    expected = "a speed of NaN rad/s or m/s at which a rollout diverges is not positive"
)]
fn bound_on_speed_that_is_no_number_is_refused() {
    let _ = Simulator::new(samples::pendulum()).with_divergence_bound(f64::NAN);
}

#[test]
fn failure_of_the_solver_is_reported_with_its_step_alone_and_in_batches() {
    // A ball cannot be at 1 m and at 1.2 m from the same place.
    let mut builder = ModelBuilder::new("ball");
    builder.add_link(LinkSpec::new("ball").with_mass(2.0, [0.0; 3], [0.01; 3]));
    let model = builder.build().expect("a robot that is known to be right");
    let rod = |length| {
        let ball = Anchor::frame(&model, "ball").expect("a frame");
        Constraint::distance([Anchor::world(), ball], length)
    };
    let start = State::new(&[1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], &[0.0; 6]);
    let held = Simulator::new(model.clone()).with_constraints(vec![rod(1.0)]);
    let torn = Simulator::new(model.clone()).with_constraints(vec![rod(1.0), rod(1.2)]);
    let good = held.rollout(&start, 10, |_, _, _| {});
    assert_eq!(
        (good.status, good.solver_failure),
        (RolloutStatus::Completed, None)
    );
    let bad = torn.rollout(&start, 10, |_, _, _| {});
    let failure = bad.solver_failure.expect("a contradiction");
    assert_eq!((failure.step, bad.status), (0, RolloutStatus::Completed));
    assert_ne!(failure.status, Status::Converged);
    let mut batch = BatchSimulator::new(torn.clone(), 3);
    let starts = vec![start.clone(); 3];
    let all = batch.rollout(&starts, 10, |_, _, _| {});
    let mut states = batch.states(&starts);
    batch.step(&mut states, &[]);
    for i in 0..3 {
        assert_eq!(all.solver_failure(i), Some(failure));
        assert_eq!(states.solver_failure(i), Some(failure));
    }
    states.set(1, &start);
    assert_eq!(states.solver_failure(1), None);
}

/// The last velocity of a rollout as a function of the damping, the initial angle and an input.
struct InEverything;

impl VectorFunction for InEverything {
    fn n_outputs(&self) -> usize {
        2
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let simulator = Simulator::new(samples::double_pendulum()).with_time_step(0.01);
        let damped = simulator.model().cast::<T>().with_damping(1, x[0]);
        let simulator = simulator.with_model(damped).expect("the same structure");
        let zero = T::zero();
        let start = State::new(&[x[1], zero], &[zero, zero]);
        let rollout = simulator.rollout_over(&start, 50, |_, _, u| u[0] = x[2]);
        assert_eq!(rollout.status, RolloutStatus::Completed);
        y.copy_from_slice(rollout.last().v.as_slice());
    }
}

#[test]
fn derivatives_of_a_rollout_equal_finite_differences() {
    let x = [0.3, 0.8, 0.5];
    let exact = jacobian(&InEverything, &x);
    let numeric = finite_difference::jacobian(&InEverything, &x);
    let error = (&exact - &numeric).amax();
    assert!(exact.amin() > 0.0 || exact.amax() > 0.01, "{exact}");
    assert!(error < FINITE_DIFFERENCE, "{error:e}: {exact}{numeric}");
}

#[test]
fn simulator_of_a_variant_keeps_all_settings_and_refuses_another_structure() {
    let model = asset("panda.urdf");
    let simulator = Simulator::new(model.clone())
        .with_actuation(Actuation::from_model(&model))
        .with_time_step(5e-3)
        .with_integrator(Integrator::ImplicitVelocity)
        .with_divergence_bound(50.0);
    let heavier = model.clone().with_armature(0, 3.0);
    let variant = simulator.with_model(heavier).expect("the same structure");
    assert_eq!(
        (variant.time_step(), variant.divergence_bound()),
        (5e-3, 50.0)
    );
    assert_eq!(variant.actuation(), simulator.actuation());
    assert_eq!(variant.integrator(), Integrator::ImplicitVelocity);
    assert_eq!(variant.model().armature()[0], 3.0);
    let other = simulator.with_model(samples::pendulum());
    let message = other.expect_err("another robot").to_string();
    assert!(message.contains("\"pendulum\""), "{message}");
}
