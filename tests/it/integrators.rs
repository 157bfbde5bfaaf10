//! What each integrator conserves, and how well: spinning bodies and closed loops, whose energy nothing but the method can change.

use std::time::Instant;

use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::{ContactLaw, Contacts, SoftContact, Terrain};
use dualbody::dynamics::{bias_forces, mass_matrix};
use dualbody::joint::JointKind;
use dualbody::model::{JointSpec, LinkSpec, ModelBuilder, samples};
use dualbody::sim::RolloutStatus;
use dualbody::spatial::Quaternion;
use dualbody::{Integrator, Model, Simulator, State};
use nalgebra::{DVector, Vector3, vector};

use crate::common::everything::INTEGRATORS;
use crate::common::ground::energy;
use crate::common::{asset, generator};
use crate::constraints::slider_crank;

use Integrator::{ImplicitVelocity, RungeKutta4, SemiImplicitEuler};

/// A free body of 1 kg without gravity.
fn body(inertia: [f64; 3]) -> Model {
    let mut builder = ModelBuilder::new("body");
    builder.add_link(LinkSpec::new("body").with_mass(1.0, [0.0; 3], inertia));
    let model = builder.build().expect("a robot that is known to be right");
    model.with_gravity(Vector3::zeros())
}

fn spinning(omega: [f64; 3]) -> State {
    let [x, y, z] = omega;
    let neutral = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    State::new(&neutral, &[0.0, 0.0, 0.0, x, y, z])
}

/// A top of 1 kg on a point, its centre of mass 0.1 m above it.
fn top() -> Model {
    let mut builder = ModelBuilder::new("top");
    builder.add_link(LinkSpec::new("world"));
    let top = LinkSpec::new("top").with_mass(1.0, [0.0, 0.0, 0.1], [1e-3, 1e-3, 2e-3]);
    builder.add_link(top);
    builder.add_joint(JointSpec::new(
        "point",
        JointKind::Spherical,
        "world",
        "top",
    ));
    builder.build().expect("a robot that is known to be right")
}

/// Three arms of 0.2 m, and a platform on six rods of 0.4 m without mass, which are constraints.
fn delta() -> Simulator {
    const ARM: f64 = 0.2;
    let mut builder = ModelBuilder::new("delta");
    builder.add_link(LinkSpec::new("world"));
    let directions = [0.0_f64, 2.0, 4.0].map(|k| (k * std::f64::consts::FRAC_PI_3).sin_cos());
    for (k, (sin, cos)) in directions.into_iter().enumerate() {
        let (name, centre) = (format!("arm{k}"), [0.5 * ARM * cos, 0.5 * ARM * sin, 0.0]);
        builder.add_link(LinkSpec::new(&name).with_mass(0.3, centre, [1e-3; 3]));
        builder.add_joint(
            JointSpec::new(format!("motor{k}"), JointKind::Continuous, "world", name)
                .with_axis([-sin, cos, 0.0])
                .with_translation([0.15 * cos, 0.15 * sin, 0.0]),
        );
    }
    builder.add_link(LinkSpec::new("platform").with_mass(0.5, [0.0; 3], [5e-4, 5e-4, 1e-3]));
    builder.add_joint(JointSpec::new(
        "free",
        JointKind::Floating,
        "world",
        "platform",
    ));
    let model = builder.build().expect("a robot that is known to be right");
    let anchor = |name: &str| Anchor::frame(&model, name).expect("a frame");
    let mut rods = Vec::new();
    for (k, (sin, cos)) in directions.into_iter().enumerate() {
        for side in [-0.04, 0.04] {
            let across = |r: f64| [r * cos - side * sin, r * sin + side * cos, 0.0];
            let elbow = anchor(&format!("arm{k}")).moved(across(ARM));
            let corner = anchor("platform").moved(across(0.05));
            rods.push(Constraint::distance([elbow, corner], 0.4));
        }
    }
    Simulator::new(model).with_constraints(rods)
}

/// By how much the energy leaves that of the start, as a part of the kinetic energy that there is: the least, the largest.
#[derive(Debug)]
struct Drift {
    least: f64,
    largest: f64,
    status: RolloutStatus,
}

fn drift(simulator: &Simulator, start: &State, seconds: f64, scale: f64) -> Drift {
    let steps = (seconds / simulator.time_step()).round() as usize;
    let rollout = simulator.rollout(start, steps, |_, _, _| {});
    let first = energy(simulator.model(), start);
    let changes = rollout.states.iter();
    let changes: Vec<f64> = changes
        .map(|state| (energy(simulator.model(), state) - first) / scale)
        .collect();
    Drift {
        least: changes.iter().copied().fold(0.0, f64::min),
        largest: changes.iter().copied().fold(0.0, f64::max),
        status: rollout.status,
    }
}

/// The largest loss and gain of energy that an integrator is allowed.
fn assert_drift(what: &str, drift: &Drift, loss: f64, gain: f64) {
    println!("{what}: {drift:?}");
    assert_eq!(drift.status, RolloutStatus::Completed, "{what}");
    let within = drift.least >= -loss && drift.largest <= gain;
    assert!(within, "{what}: {drift:?}");
}

fn with(model: &Model, integrator: Integrator, dt: f64) -> Simulator {
    Simulator::new(model.clone())
        .with_integrator(integrator)
        .with_time_step(dt)
}

/// Angular momentum of a free body in the world.
fn momentum(inertia: [f64; 3], state: &State) -> Vector3<f64> {
    let turn = Quaternion::from_slice(&state.q.as_slice()[3..7]).to_matrix();
    turn * vector![
        inertia[0] * state.v[3],
        inertia[1] * state.v[4],
        inertia[2] * state.v[5]
    ]
}

#[test]
fn energy_and_momentum_of_a_flywheel_drift_as_documented() {
    const INERTIA: [f64; 3] = [0.01, 0.01, 0.019];
    let (model, start) = (body(INERTIA), spinning([0.5, 0.0, 30.0]));
    let kinetic = energy(&model, &start);
    for (integrator, dt, loss, gain) in [
        (SemiImplicitEuler, 1e-3, 1e-9, 0.3),
        (ImplicitVelocity, 5e-3, 1e-12, 1e-12),
        (ImplicitVelocity, 1e-3, 1e-12, 1e-12),
        (RungeKutta4, 5e-3, 1e-7, 1e-9),
        (RungeKutta4, 1e-3, 1e-10, 1e-10),
    ] {
        let simulator = with(&model, integrator, dt);
        let drift = drift(&simulator, &start, 10.0, kinetic);
        assert_drift(&format!("flywheel {integrator:?} {dt}"), &drift, loss, gain);
        if integrator == ImplicitVelocity {
            let steps = (10.0 / dt) as usize;
            let end = simulator.rollout(&start, steps, |_, _, _| {});
            let (before, after) = (momentum(INERTIA, &start), momentum(INERTIA, end.last()));
            println!("momentum {dt}: {:e}", after.norm() / before.norm() - 1.0);
            assert!((after.norm() / before.norm() - 1.0).abs() < 1e-11);
        }
    }
}

#[test]
fn energy_of_a_heavy_top_drifts_as_documented() {
    let model = top();
    let start = State::new(
        &[0.15_f64.cos(), 0.15_f64.sin(), 0.0, 0.0],
        &[0.0, 0.0, 300.0],
    );
    let kinetic = energy(&model, &start);
    for (integrator, dt, loss, gain) in [
        (SemiImplicitEuler, 1e-3, 3e-6, 3e-6),
        (ImplicitVelocity, 1e-3, 3e-6, 3e-6),
        (ImplicitVelocity, 5e-3, 1e-5, 1e-5),
        (RungeKutta4, 1e-3, 3e-6, 1e-9),
        (RungeKutta4, 5e-3, 2e-2, 1e-9),
    ] {
        let drift = drift(&with(&model, integrator, dt), &start, 5.0, kinetic);
        assert_drift(&format!("top {integrator:?} {dt}"), &drift, loss, gain);
    }
}

#[test]
fn wing_nut_flips_and_its_energy_drifts_as_documented() {
    let (model, start) = (body([0.01, 0.02, 0.03]), spinning([1e-3, 6.0, 0.0]));
    let kinetic = energy(&model, &start);
    for (integrator, dt, loss, gain) in [
        (SemiImplicitEuler, 1e-3, 1e-9, 0.3),
        (SemiImplicitEuler, 1e-2, 1e-9, 8.0),
        (ImplicitVelocity, 1e-3, 1e-9, 1e-5),
        (ImplicitVelocity, 1e-2, 1e-9, 1e-3),
        (RungeKutta4, 1e-3, 1e-9, 1e-9),
    ] {
        let simulator = with(&model, integrator, dt);
        let drift = drift(&simulator, &start, 100.0, kinetic);
        assert_drift(&format!("wing nut {integrator:?} {dt}"), &drift, loss, gain);
        let steps = (100.0 / dt) as usize;
        let states = simulator.rollout(&start, steps, |_, _, _| {}).states;
        let ways = states.windows(2);
        let flips = ways.filter(|w| w[0].v[4] * w[1].v[4] < 0.0).count();
        println!("wing nut {integrator:?} {dt}: {flips} flips");
        assert!(flips > 5, "{integrator:?} {dt}: {flips} flips");
    }
}

#[test]
fn energy_of_a_slider_crank_drifts_as_documented() {
    let free = slider_crank();
    let model = free.model().clone().with_gravity(Vector3::zeros());
    let constraints = free.constraints().to_vec();
    for (integrator, dt, loss, gain) in [
        (SemiImplicitEuler, 1e-3, 0.02, 6.0),
        (ImplicitVelocity, 1e-3, 0.02, 6.0),
        (RungeKutta4, 1e-3, 1e-5, 1e-5),
        (RungeKutta4, 1e-2, 0.3, 1e-3),
    ] {
        let simulator = with(&model, integrator, dt).with_constraints(constraints.clone());
        let start = State::new(&[0.7, -0.9, 0.35], &[33.8, -33.8, 0.0]);
        let start = simulator.assemble(&start).expect("in reach").state;
        let kinetic = energy(&model, &start);
        let drift = drift(&simulator, &start, 10.0, kinetic);
        let what = format!("slider-crank {integrator:?} {dt}, {kinetic} J");
        assert_drift(&what, &drift, loss, gain);
    }
}

#[test]
fn energy_of_a_free_delta_robot_drifts_as_documented() {
    let delta = delta();
    let start = State::new(
        &[0.1, 0.2, 0.3, 0.0, 0.0, -0.35, 1.0, 0.0, 0.0, 0.0],
        &[0.0; 9],
    );
    let start = delta.assemble(&start).expect("in reach").state;
    for (integrator, dt, loss, gain) in [
        (SemiImplicitEuler, 1e-3, 0.02, 3.0),
        (SemiImplicitEuler, 1e-2, 4.0, 6.0),
        (ImplicitVelocity, 1e-3, 0.02, 3.0),
        (ImplicitVelocity, 1e-2, 4.0, 6.0),
        (RungeKutta4, 1e-3, 1e-3, 1e-3),
    ] {
        let simulator = delta.clone().with_integrator(integrator).with_time_step(dt);
        let drift = drift(&simulator, &start, 10.0, 1.0);
        let what = format!("delta {integrator:?} {dt}");
        assert_drift(&what, &drift, loss, gain);
    }
}

// M a + c(v) + ½ (c(v + ½ Δt a) − c(v − ½ Δt a)) + g = τ:  c is quadratic, so the difference is ½ Δt ∂c/∂v a.
#[test]
fn implicit_step_obeys_the_linear_rule_of_the_midpoint() {
    const DT: f64 = 0.01;
    for model in [
        samples::arm(),
        samples::double_pendulum(),
        asset("ur5.urdf"),
    ] {
        let simulator = with(&model, ImplicitVelocity, DT);
        let mut rng = generator(5);
        let state = State::random(&model, &mut rng, 3.0);
        let u = DVector::from_fn(simulator.nu(), |k, _| (k as f64).sin());
        let next = simulator.step(&state, u.as_slice());
        let a = (&next.v - &state.v) / DT;
        let (q, half) = (state.q.as_slice(), &a * (0.5 * DT));
        let forces = |v: DVector<f64>| bias_forces(&model, q, v.as_slice());
        let middle = (forces(&state.v + &half) - forces(&state.v - &half)) * 0.5;
        let residual = mass_matrix(&model, q) * &a + forces(state.v.clone()) + &middle - u;
        assert!(
            middle.amax() > 1e-3 && residual.amax() < 1e-10,
            "{residual}"
        );
    }
}

/// The table in the documentation of `Integrator`: errors against steps of a hundredth, and times of a step.
///
/// `cargo test --release --test it -- --ignored --nocapture table_of_integrators`
#[test]
#[ignore = "prints a table"]
fn table_of_integrators() {
    let mut rng = generator(3);
    let arm = (0..6).fold(asset("ur5.urdf"), |arm, k| arm.with_damping(k, 2.0));
    let arm_start = State::random(&arm, &mut rng, 1.0);
    let quadruped = asset("quadruped.urdf");
    let law = ContactLaw::Soft(SoftContact::estimate(quadruped.total_mass(), 4, 5e-3));
    let feet = ["FR_foot", "FL_foot", "RR_foot", "RL_foot"];
    let contacts = Contacts::new(&quadruped, Terrain::flat(0.0), law);
    let contacts = contacts.with_links(&quadruped, &feet).expect("feet");
    let quadruped = (6..18).fold(quadruped, |robot, k| robot.with_damping(k, 0.5));
    let quadruped = Simulator::new(quadruped).with_contacts(contacts);
    let mut stand: State = quadruped.neutral_state();
    stand.q[2] = 0.33;
    for leg in 0..4 {
        stand.q[7 + 3 * leg + 1] = 0.8;
        stand.q[7 + 3 * leg + 2] = -1.6;
    }
    let crank = slider_crank();
    let turning = State::new(&[0.7, -0.9, 0.35], &[10.0, -10.0, 0.0]);
    let turning = crank.assemble(&turning).expect("in reach").state;
    let flywheel = Simulator::new(body([0.01, 0.02, 0.03]));
    let cases = [
        ("damped arm", Simulator::new(arm), arm_start),
        ("quadruped in contact", quadruped, stand),
        ("spinning body", flywheel, spinning([1.0, 20.0, 1.0])),
        ("closed loop", crank, turning),
    ];
    for (name, simulator, start) in cases {
        let end = |integrator, dt: f64| {
            let simulator = simulator
                .clone()
                .with_integrator(integrator)
                .with_time_step(dt);
            let begun = Instant::now();
            let steps = (0.5 / dt).round() as usize;
            let rollout = simulator.rollout(&start, steps, |_, _, _| {});
            let time = begun.elapsed().as_secs_f64() / steps as f64;
            (rollout.last().clone(), time, rollout.status)
        };
        let (reference, ..) = end(ImplicitVelocity, 1e-5);
        for integrator in INTEGRATORS {
            for dt in [1e-3, 5e-3, 1e-2] {
                let (last, time, status) = end(integrator, dt);
                let error = last.deviation(simulator.model(), &reference);
                let error = error.rows(0, simulator.model().nv()).amax();
                println!(
                    "{name:22} {integrator:?} {dt}: error {error:.1e}, {:.2} µs, {status:?}",
                    time * 1e6
                );
            }
        }
    }
}
