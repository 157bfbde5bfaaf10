//! Integrators: quantities that each conserves, and how well, with spinning bodies and closed loops, whose energy
//! nothing but the method can change.

use std::time::Instant;

use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::{ContactLaw, Terrain};
use dualbody::dynamics::{bias_forces, mass_matrix};
use dualbody::joint::JointKind;
use dualbody::model::{JointSpec, LinkSpec, ModelBuilder, samples};
use dualbody::sim::{Rollout, RolloutStatus};
use dualbody::spatial::Quaternion;
use dualbody::{Integrator, Model, Simulator, State};
use nalgebra::{DVector, Vector3, vector};

use crate::common::everything::INTEGRATORS;
use crate::common::ground::{energy, square_root_law};
use crate::common::quadruped::{crouching, on_feet};
use crate::common::{asset, generator};
use crate::constraints::slider_crank;

use Integrator::{ImplicitMidpoint, ImplicitVelocity, RungeKutta4, SemiImplicitEuler};

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

/// By how much the energy leaves that of the start, as a part of the kinetic energy that there is: the least, the
/// largest.
#[derive(Debug)]
struct Drift {
    least: f64,
    largest: f64,
    status: RolloutStatus,
}

fn drift(simulator: &Simulator, start: &State, seconds: f64, scale: f64) -> Drift {
    drift_of(simulator, &motion(simulator, start, seconds), scale)
}

fn motion(simulator: &Simulator, start: &State, seconds: f64) -> Rollout {
    let steps = (seconds / simulator.time_step()).round() as usize;
    simulator.rollout(start, steps, |_, _, _| {})
}

fn drift_of(simulator: &Simulator, rollout: &Rollout, scale: f64) -> Drift {
    let first = energy(simulator.model(), &rollout.states[0]);
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

/// An integrator and its step (s), and the largest loss and gain of energy that it is allowed.
type Allowed = (Integrator, f64, f64, f64);

fn assert_drifts(what: &str, cases: &[Allowed], measure: impl Fn(Integrator, f64) -> Drift) {
    let drifts = cases.iter().map(|&(integrator, dt, ..)| {
        let drift = measure(integrator, dt);
        println!("{what} {integrator:?} {dt}: {drift:?}");
        drift
    });
    let drifts: Vec<Drift> = drifts.collect();
    for (drift, (integrator, dt, loss, gain)) in drifts.iter().zip(cases) {
        let what = format!("{what} {integrator:?} {dt}: {drift:?}");
        assert_eq!(drift.status, RolloutStatus::Completed, "{what}");
        let within = drift.least >= -loss && drift.largest <= *gain;
        assert!(within, "{what}");
    }
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
    let cases = [
        (SemiImplicitEuler, 1e-3, 1e-9, 0.3),
        (SemiImplicitEuler, 5e-3, 1e-9, 50.0),
        (ImplicitVelocity, 1e-3, 1e-12, 1e-12),
        (ImplicitVelocity, 5e-3, 1e-12, 1e-12),
        (RungeKutta4, 1e-3, 1e-10, 1e-10),
        (RungeKutta4, 5e-3, 1e-7, 1e-9),
        (ImplicitMidpoint, 1e-3, 2e-12, 2e-12),
        (ImplicitMidpoint, 5e-3, 2e-12, 2e-12),
    ];
    assert_drifts("flywheel", &cases, |integrator, dt| {
        drift(&with(&model, integrator, dt), &start, 10.0, kinetic)
    });
    for dt in [1e-3, 5e-3] {
        let simulator = with(&model, ImplicitVelocity, dt);
        let steps = (10.0 / dt) as usize;
        let end = simulator.rollout(&start, steps, |_, _, _| {});
        let (before, after) = (momentum(INERTIA, &start), momentum(INERTIA, end.last()));
        let change = after.norm() / before.norm() - 1.0;
        println!("momentum {dt}: {change:e}");
        assert!(change.abs() < 1e-11);
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
    let cases = [
        (SemiImplicitEuler, 1e-3, 3e-6, 3e-6),
        (SemiImplicitEuler, 5e-3, 1e-5, 1e-5),
        (ImplicitVelocity, 1e-3, 3e-6, 3e-6),
        (ImplicitVelocity, 5e-3, 1e-5, 1e-5),
        (RungeKutta4, 1e-3, 3e-6, 1e-9),
        (RungeKutta4, 5e-3, 2e-2, 1e-9),
        (ImplicitMidpoint, 1e-3, 1e-9, 1e-6),
        (ImplicitMidpoint, 5e-3, 1e-9, 3e-5),
    ];
    assert_drifts("heavy top", &cases, |integrator, dt| {
        drift(&with(&model, integrator, dt), &start, 5.0, kinetic)
    });
}

#[test]
fn wing_nut_flips_and_its_energy_drifts_as_documented() {
    let (model, start) = (body([0.01, 0.02, 0.03]), spinning([1e-3, 6.0, 0.0]));
    let kinetic = energy(&model, &start);
    let cases = [
        (SemiImplicitEuler, 1e-3, 1e-9, 0.3),
        (SemiImplicitEuler, 1e-2, 1e-9, 8.0),
        (ImplicitVelocity, 1e-3, 1e-9, 1e-5),
        (ImplicitVelocity, 1e-2, 1e-9, 1e-3),
        (RungeKutta4, 1e-3, 1e-9, 1e-9),
        (RungeKutta4, 1e-2, 1e-6, 1e-9),
        (ImplicitMidpoint, 1e-3, 1e-9, 2e-6),
        (ImplicitMidpoint, 1e-2, 1e-9, 2e-4),
    ];
    assert_drifts("wing nut", &cases, |integrator, dt| {
        let simulator = with(&model, integrator, dt);
        let motion = motion(&simulator, &start, 100.0);
        let pairs = motion.states.windows(2);
        let flips = pairs.filter(|w| w[0].v[4] * w[1].v[4] < 0.0);
        let flips = flips.count();
        println!("wing nut {integrator:?} {dt}: {flips} flips");
        assert!(flips > 5, "{integrator:?} {dt}: {flips} flips");
        drift_of(&simulator, &motion, kinetic)
    });
}

/// The slider-crank without gravity, its crank at 15 rad/s.
pub(crate) fn turning_crank() -> (Simulator, State) {
    let crank = slider_crank();
    let weightless = crank.model().clone().with_gravity(Vector3::zeros());
    let crank = crank.with_model(weightless).expect("the same structure");
    let start = State::new(&[0.7, -0.9, 0.35], &[33.8, -33.8, 0.0]);
    let start = crank.assemble(&start).expect("in reach").state;
    (crank, start)
}

#[test]
fn energy_of_a_slider_crank_drifts_as_documented() {
    let (crank, start) = turning_crank();
    let kinetic = energy(crank.model(), &start);
    println!("{kinetic} J at {}", start.v);
    let cases = [
        (SemiImplicitEuler, 1e-3, 0.02, 0.02),
        (SemiImplicitEuler, 1e-2, 0.6, 0.3),
        (ImplicitVelocity, 1e-3, 0.02, 0.02),
        (ImplicitVelocity, 1e-2, 0.6, 0.3),
        (RungeKutta4, 1e-3, 1e-5, 1e-5),
        (RungeKutta4, 1e-2, 0.3, 1e-3),
        (ImplicitMidpoint, 1e-3, 2e-3, 1e-3),
        (ImplicitMidpoint, 1e-2, 5e-3, 5e-3),
    ];
    assert_drifts("slider-crank", &cases, |integrator, dt| {
        let simulator = crank.clone().with_integrator(integrator);
        drift(&simulator.with_time_step(dt), &start, 10.0, kinetic)
    });
}

#[test]
fn energy_of_a_free_delta_robot_drifts_as_documented() {
    let delta = delta();
    let start = State::new(
        &[0.1, 0.2, 0.3, 0.0, 0.0, -0.35, 1.0, 0.0, 0.0, 0.0],
        &[0.0; 9],
    );
    let start = delta.assemble(&start).expect("in reach").state;
    let cases = [
        (SemiImplicitEuler, 1e-3, 0.8, 0.8),
        (SemiImplicitEuler, 1e-2, 2.1, 0.5),
        (ImplicitVelocity, 2.5e-4, 0.03, 0.02),
        (ImplicitVelocity, 5e-4, 0.15, 0.1),
        (ImplicitVelocity, 1e-3, 0.8, 0.8),
        (ImplicitVelocity, 1e-2, 2.1, 0.5),
        (RungeKutta4, 1e-3, 1e-3, 1e-3),
        (ImplicitMidpoint, 1e-3, 0.01, 0.01),
        (ImplicitMidpoint, 1e-2, 0.03, 0.03),
    ];
    let of = |rods: Vec<Constraint>| {
        let (delta, start) = (delta.clone().with_constraints(rods), &start);
        move |integrator, dt| {
            let delta = delta.clone().with_integrator(integrator);
            drift(&delta.with_time_step(dt), start, 10.0, 1.0)
        }
    };
    let rods = delta.constraints();
    assert_drifts("delta", &cases, of(rods.to_vec()));
    let tight = rods.iter().map(|rod| rod.clone().with_time_constant(2e-3));
    let cases = [(ImplicitVelocity, 1e-3, 0.15, 0.15)];
    assert_drifts("delta, tight", &cases, of(tight.collect()));
}

// The change of velocity in a step is the same backward in time: at q, −v⁺ becomes −v. Without constraints exactly;
// with them to the third order, as their biases are at the velocity after the step to the second.
#[test]
fn steps_lead_from_the_reversed_velocity_back_to_that_before() {
    let defect = |simulator: &Simulator, start: &State| {
        let next = simulator.step(start, &vec![0.0; simulator.nu()]);
        let turned = State::new(start.q.as_slice(), (-&next.v).as_slice());
        let back = simulator.step(&turned, &vec![0.0; simulator.nu()]);
        (back.v + &start.v).amax()
    };
    for model in [samples::arm(), samples::double_pendulum()] {
        let start = State::random(&model, &mut generator(2), 3.0);
        let free = with(&model, ImplicitVelocity, 1e-2);
        let off = defect(&free, &start);
        assert!(off < 1e-10, "{}: {off:e}", model.name());
    }
    let (crank, start) = turning_crank();
    let gentle = crank.constraints().iter().cloned();
    let gentle = gentle.map(|pin| pin.with_time_constant(1e9)).collect();
    let crank = crank.clone().with_constraints(gentle);
    for integrator in [SemiImplicitEuler, ImplicitVelocity] {
        let crank = crank.clone().with_integrator(integrator);
        let [long, short] =
            [2e-3, 1e-3].map(|dt| defect(&crank.clone().with_time_step(dt), &start));
        println!("{integrator:?}: {long:e}, then {short:e}");
        assert!(
            short < long / 7.0,
            "{integrator:?}: {long:e}, then {short:e}"
        );
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

/// A cell of the table of errors in the documentation of `Integrator`.
#[derive(Clone, Copy, Debug)]
enum Cell {
    /// Completes, and is off by at most this.
    Within(f64),
    /// Completes, and is off by more than this.
    Beyond(f64),
    Diverges,
}

use Cell::{Beyond, Diverges, Within};

/// A robot at a state, with its documented errors: for each integrator, at steps of 1, 5 and 10 ms.
struct Documented {
    name: &'static str,
    simulator: Simulator,
    start: State,
    cells: [[Cell; 3]; 3],
}

fn documented() -> [Documented; 4] {
    let arm = (0..6).fold(asset("ur5.urdf"), |arm, k| arm.with_damping(k, 2.0));
    let arm_start = State::random(&arm, &mut generator(3), 1.0);
    let quadruped = asset("quadruped.urdf");
    let law = ContactLaw::Soft(square_root_law(quadruped.total_mass(), 4, 5e-3));
    let contacts = on_feet(&quadruped, Terrain::flat(0.0), law);
    let quadruped = (6..18).fold(quadruped, |robot, k| robot.with_damping(k, 0.5));
    let quadruped = Simulator::new(quadruped).with_contacts(contacts);
    let stand = crouching(&quadruped, 0.33);
    let crank = slider_crank();
    let turning = State::new(&[0.7, -0.9, 0.35], &[10.0, -10.0, 0.0]);
    let turning = crank.assemble(&turning).expect("in reach").state;
    let damped = [5e-4, 3e-3, 5e-3].map(Within);
    let looped = [2e-3, 1e-2, 3e-2].map(Within);
    [
        Documented {
            name: "damped arm",
            simulator: Simulator::new(arm),
            start: arm_start,
            cells: [damped, damped, [Diverges; 3]],
        },
        Documented {
            name: "quadruped in contact",
            simulator: quadruped,
            start: stand,
            cells: [
                [Within(1e-2), Beyond(0.5), Beyond(0.5)],
                [5e-3, 2e-2, 3e-2].map(Within),
                [1e-4, 0.3, 2.0].map(Within),
            ],
        },
        Documented {
            name: "spinning body",
            simulator: Simulator::new(body([0.01, 0.02, 0.03])),
            start: spinning([1.0, 20.0, 1.0]),
            cells: [
                [3e-2, 0.15, 0.3].map(Within),
                [5e-3, 2e-2, 5e-2].map(Within),
                [6e-5; 3].map(Within),
            ],
        },
        Documented {
            name: "closed loop",
            simulator: crank,
            start: turning,
            cells: [looped, looped, [3e-5; 3].map(Within)],
        },
    ]
}

// Against steps of a hundredth; prints the times of a step as well.
#[test]
fn errors_after_half_a_second_are_as_documented() {
    for case in documented() {
        let end = |integrator, dt: f64| {
            let simulator = case.simulator.clone().with_integrator(integrator);
            let simulator = simulator.with_time_step(dt);
            let begun = Instant::now();
            let steps = (0.5 / dt).round() as usize;
            let rollout = simulator.rollout(&case.start, steps, |_, _, _| {});
            (rollout, begun.elapsed().as_secs_f64() / steps as f64)
        };
        let model = case.simulator.model();
        let (reference, _) = end(ImplicitVelocity, 1e-5);
        for (integrator, cells) in INTEGRATORS.into_iter().zip(case.cells) {
            for (dt, cell) in [1e-3, 5e-3, 1e-2].into_iter().zip(cells) {
                let (rollout, time) = end(integrator, dt);
                let error = rollout.last().deviation(model, reference.last());
                let error = error.rows(0, model.nv()).amax();
                let completed = rollout.status == RolloutStatus::Completed;
                let what = format!("{:22} {integrator:?} {dt}: {error:.1e}", case.name);
                println!("{what}, {:.2} µs, {:?}", time * 1e6, rollout.status);
                let holds = match cell {
                    Within(most) => completed && error <= most,
                    Beyond(least) => completed && error > least,
                    Diverges => matches!(rollout.status, RolloutStatus::Diverged { .. }),
                };
                assert!(holds, "{what} is not {cell:?}");
            }
        }
    }
}
