//! Dry friction that holds: closed forms of a slider, the law itself on random robots, rows of a solver beside the active set, gradients.

use dualbody::autodiff::Dual;
use dualbody::codegen::{linearization, step};
use dualbody::cone::Status;
use dualbody::contact::HuntCrossley;
use dualbody::dynamics::inverse_dynamics;
use dualbody::joint::JointKind;
use dualbody::linearize::{StepGradient, VjpScratch};
use dualbody::model::{Body, JointSpec, LinkSpec, ModelBuilder, samples};
use dualbody::sim::{
    Actuation, Actuator, BatchSimulator, CoulombFriction, FrictionLaw, PositionLimits,
    SimulatorRemark, StepScratch,
};
use dualbody::{Cast, Integrator, Model, Simulator, State};

use crate::common::{OTHER_ALGORITHM, random_point, with_solver};

const EULER: [Integrator; 2] = [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity];

/// A slider of 2 kg on a horizontal rail, with 0.6 N of friction that its description states.
fn slider(dt: f64, integrator: Integrator) -> Simulator {
    let mut builder = ModelBuilder::new("slider");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("slider").with_mass(2.0, [0.0; 3], [1.0; 3]));
    let rail = JointSpec::new("rail", JointKind::Prismatic, "world", "slider");
    builder.add_joint(rail.with_axis([1.0, 0.0, 0.0]).with_friction(0.6));
    let model = builder.build().expect("a slider");
    let actuation = Actuation::from_model(&model);
    Simulator::new(model)
        .with_actuation(actuation)
        .with_time_step(dt)
        .with_integrator(integrator)
}

fn sliders() -> impl Iterator<Item = (f64, Simulator)> {
    let steps = [1e-3, 1e-2].into_iter();
    steps.flat_map(|dt| EULER.map(|integrator| (dt, slider(dt, integrator))))
}

fn steps(time: f64, dt: f64) -> usize {
    (time / dt).round() as usize
}

#[test]
fn push_below_friction_moves_nothing() {
    for (dt, simulator) in sliders() {
        for push in [0.5, -0.5, 0.6, -0.6, 0.0] {
            let start = State::new(&[0.25], &[0.0]);
            let held = simulator.rollout(&start, steps(10.0, dt), |_, _, u| u[0] = push);
            let still = held.states.iter().all(|s| s.q[0] == 0.25 && s.v[0] == 0.0);
            assert!(still, "{push} N: {:?}", held.last());
        }
        // More than it holds: a = (0.8 − 0.6) / 2.
        let pushed = simulator.rollout(&State::new(&[0.0], &[0.0]), 10, |_, _, u| u[0] = -0.8);
        assert!((pushed.last().v[0] + 0.1 * 10.0 * dt).abs() < 1e-12);
    }
}

// v₀ / a = 5 s and v₀² / 2 a = 3.75 m with a = f / m; ∂x/∂f = −m v₀² / 2 f², ∂x/∂v₀ = m v₀ / f.
#[test]
fn slider_stops_as_in_closed_form_with_its_derivatives_and_without_chatter() {
    for (dt, simulator) in sliders() {
        let count = steps(7.0, dt);
        let rollout = simulator.rollout(&State::new(&[0.0], &[1.5]), count, |_, _, _| {});
        let moving = rollout.states.iter().take_while(|s| s.v[0] > 0.0).count();
        assert!((moving as f64 * dt - 5.0).abs() < 2.0 * dt, "{moving}");
        let x = rollout.last().q[0];
        assert!((x - 3.75).abs() < 2.0 * dt, "{x}");
        let rest = &rollout.states[moving + 2..];
        assert!(rest.iter().all(|s| s.v[0].abs() < 1e-30 && s.q[0] == x));

        let gradient = adjoint(&simulator, &rollout.states, &[1.0, 0.0]);
        let f = simulator.parameter_layout().find("rail: Coulomb friction");
        let by_f = gradient.parameters[f.expect("a parameter")];
        assert!((by_f + 6.25).abs() < 4.0 * dt, "{by_f}");
        assert!((gradient.v[0] - 5.0).abs() < 4.0 * dt, "{}", gradient.v[0]);
        let forward = rollout.states[..count]
            .iter()
            .fold([0.0, 1.0], |[q, v], state| {
                let a = simulator.linearize(state, &[0.0]).a;
                [a[(0, 0)] * q + a[(0, 1)] * v, a[(1, 0)] * q + a[(1, 1)] * v]
            });
        assert!((forward[0] - gradient.v[0]).abs() < 1e-9);
    }
}

struct Gradient {
    v: Vec<f64>,
    parameters: Vec<f64>,
}

/// Gradient of a weighted last state, in the first velocity and in all parameters, by vector-Jacobian products.
fn adjoint(simulator: &Simulator, states: &[State], weights: &[f64]) -> Gradient {
    let (nv, u) = (simulator.model().nv(), vec![0.0; simulator.nu()]);
    let mut scratch = VjpScratch::new(simulator);
    let mut weights = weights.to_vec();
    let mut parameters = vec![0.0; simulator.parameters().len()];
    for state in states[..states.len() - 1].iter().rev() {
        let mut out = StepGradient::zeros(simulator);
        simulator.vjp_into(state, &u, &weights, &mut scratch, &mut out);
        weights = out.state.as_slice().to_vec();
        let all = parameters.iter_mut().zip(out.parameters.iter());
        all.for_each(|(sum, slope)| *sum += slope);
    }
    Gradient {
        v: weights[nv..].to_vec(),
        parameters,
    }
}

/// Whether the axes of a joint turn with its body.
fn turns(body: &Body<f64>) -> bool {
    matches!(body.joint, JointKind::Planar | JointKind::Floating)
}

/// Exact friction in all joints but planar and floating ones.
fn with_friction(model: Model, integrator: Integrator) -> Simulator {
    let mut actuators = vec![Actuator::default(); model.nv()];
    let bodies = model.bodies().iter().filter(|body| body.coupling.is_none());
    for body in bodies.filter(|body| !turns(body)) {
        for k in body.v..body.v + body.joint.nv() {
            let force = 0.3 + 0.2 * (k as f64).cos();
            actuators[k].friction = Some(CoulombFriction::exact(force));
        }
    }
    let actuation = Actuation::ideal(&model).with_actuators(&actuators);
    Simulator::new(model)
        .with_actuation(actuation)
        .with_time_step(5e-3)
        .with_integrator(integrator)
}

/// Robots, and inputs under which some joints stick and some slide.
fn trees() -> Vec<(Simulator, State, Vec<f64>)> {
    let mut out = Vec::new();
    for seed in 0..8 {
        for integrator in EULER {
            let model = match seed {
                0 => samples::arm(),
                1 => crate::common::gripper().build().expect("a gripper"),
                _ => samples::random_tree(10, seed),
            };
            let simulator = with_friction(model, integrator);
            let point = random_point(simulator.model(), seed);
            let v = point
                .v
                .map_with_location(|k, _, v| if k % 3 == 0 { 0.0 } else { 0.2 * v });
            let u = (0..simulator.nu()).map(|k| 0.4 * (2.0 * k as f64).sin());
            let state = State::new(point.q.as_slice(), v.as_slice());
            out.push((simulator.clone(), state, u.collect()));
        }
    }
    out
}

fn exact(simulator: &Simulator) -> Vec<(usize, f64)> {
    let actuators = simulator.actuation().expect("friction").actuators();
    let friction = actuators.iter().enumerate();
    let friction = friction.filter_map(|(k, own)| Some((k, own.friction?)));
    friction
        .filter(|(_, own)| own.law == FrictionLaw::Exact)
        .map(|(k, own)| (k, own.force))
        .collect()
}

// Newton–Euler gives the joint forces of the step; the part that is not the input is friction.
#[test]
fn friction_of_an_arm_obeys_its_law_in_every_step() {
    let (mut sticking, mut sliding, mut arriving) = (0, 0, 0);
    // An arm. In other trees axes turn, so that the acceleration here is not that of the step, or springs and dampers of mimic joints act too.
    for (simulator, start, u) in trees() {
        let is_other = |body: &Body<f64>| turns(body) || body.coupling.is_some();
        if simulator.model().bodies().iter().any(is_other) {
            continue;
        }
        // Velocity forces of the middle of the step are not those of Newton and Euler.
        let simulator = simulator.with_integrator(Integrator::SemiImplicitEuler);
        let model = simulator.model();
        let states = simulator
            .rollout(&start, 60, |_, _, to| to.copy_from_slice(&u))
            .states;
        for pair in states.windows(2) {
            let (q, v) = (pair[0].q.as_slice(), pair[0].v.as_slice());
            let a = (&pair[1].v - &pair[0].v) / simulator.time_step();
            let tau = inverse_dynamics(model, q, v, a.as_slice());
            for (k, bound) in exact(&simulator) {
                let input = simulator.actuated().iter().position(|&own| own == k);
                let damper = model.damping()[k] * pair[1].v[k];
                let friction = tau[k] + damper - input.map_or(0.0, |input| u[input]);
                let (before, after) = (v[k], pair[1].v[k]);
                if after.abs() < 1e-14 {
                    assert!(friction.abs() <= bound * (1.0 + 1e-6), "{friction} {bound}");
                    sticking += 1;
                    arriving += usize::from(before.abs() > 1e-9);
                } else {
                    let error = (friction + bound * after.signum()).abs();
                    assert!(
                        error < 1e-8 * (1.0 + tau.amax()),
                        "{k}: {friction} of {bound} at {after}"
                    );
                    sliding += 1;
                }
            }
        }
    }
    assert!(
        sticking > 20 && sliding > 20 && arriving > 2,
        "{sticking} {sliding} {arriving}"
    );
}

#[test]
fn rows_of_a_solver_find_what_the_active_set_finds() {
    for (simulator, start, u) in trees() {
        let simulator = simulator.with_integrator(Integrator::ImplicitVelocity);
        let solved = with_solver(&simulator);
        let mut state = start;
        for step in 0..20 {
            let (one, two) = (simulator.step(&state, &u), solved.step(&state, &u));
            let error = (&one.v - &two.v).amax();
            let name = simulator.model().name();
            assert!(error < OTHER_ALGORITHM, "{name}, step {step}: {error:e}");
            state = one;
        }
        let (one, two) = (
            simulator.linearize(&state, &u),
            solved.linearize(&state, &u),
        );
        let error = (one.a - two.a).amax().max((one.b - two.b).amax());
        assert!(error < 1e-8, "{error:e}");
    }
}

/// Joints without friction and with none, little, much and endless friction side by side; resting, creeping, and moving fast; some at their limits. Trees of
/// few bodies, and bushes whose branches are packed.
fn near_switches(seed: u64, limited: bool) -> (Simulator, State, Vec<f64>) {
    const FRICTION: [Option<f64>; 7] = [
        Some(0.4),
        None,
        Some(5.0),
        Some(1e-3),
        Some(0.0),
        Some(1e6),
        Some(60.0),
    ];
    const SPEED: [f64; 5] = [1.0, 0.0, 1e-3, 0.1, 1e-7];
    let model = samples::random_tree(if seed.is_multiple_of(2) { 7 } else { 25 }, seed);
    let point = random_point(&model, seed);
    let mut actuators = vec![Actuator::default(); model.nv()];
    for body in model.bodies().iter().filter(|body| !turns(body)) {
        for k in body.v..body.v + body.joint.nv() {
            let friction = FRICTION[(k + seed as usize) % FRICTION.len()];
            actuators[k].friction = friction.map(CoulombFriction::exact);
        }
        if limited && body.v % 3 == 0 && body.joint.nq() == 1 {
            let q = point.q[body.q];
            actuators[body.v].position = Some(PositionLimits {
                lower: Some(q - 1.0),
                upper: Some(q - 1e-3),
                stop: HuntCrossley::linear(300.0, 2.0),
            });
        }
    }
    let v = point
        .v
        .map_with_location(|k, _, v| v * SPEED[(2 * k + seed as usize) % SPEED.len()]);
    let actuation = Actuation::ideal(&model).with_actuators(&actuators);
    let simulator = Simulator::new(model)
        .with_actuation(actuation)
        .with_time_step(2e-3)
        .with_integrator(Integrator::ImplicitVelocity);
    let u = (0..simulator.nu())
        .map(|k| (2.0 * k as f64).sin())
        .collect();
    (simulator, State::new(point.q.as_slice(), v.as_slice()), u)
}

// Dual numbers and the solver decide by other rules: by rounds of whole solutions, and by the active set of its rows.
#[test]
fn decisions_of_forward_dynamics_are_those_of_other_ways_near_switches() {
    let mut solutions = 0;
    for (seed, limited) in (0..10).flat_map(|seed| [(seed, true), (seed, false)]) {
        let (simulator, mut state, u) = near_switches(seed, limited);
        let solved = with_solver(&simulator);
        let mut scratch = StepScratch::new(&solved);
        let lifted: Vec<Dual<f64, 1>> = u.iter().map(|&u| u.into()).collect();
        for step in 0..10 {
            let next = simulator.step(&state, &u);
            let dual = simulator.step(&state.cast::<Dual<f64, 1>>(), &lifted);
            let mut by_rows = state.clone();
            solved.step_into(&state, &u, &mut scratch, &mut by_rows);
            let scale = next.v.amax().max(1.0);
            let error = (&next.v - dual.v.map(|v| v.re)).amax() / scale;
            assert!(error < 1e-10, "tree {seed}, step {step}: {error:e}");
            if scratch.solver_status(0) == Status::Converged {
                let error = (&next.v - &by_rows.v).amax() / scale;
                assert!(error < 1e-10, "tree {seed}, step {step}, rows: {error:e}");
                solutions += 1;
            }
            state = next;
        }
    }
    assert!(solutions > 150, "{solutions}");
}

#[test]
fn batches_give_the_bits_of_single_steps() {
    const STEPS: usize = 30;
    for (simulator, start, u) in trees() {
        let scale = [1.0, 0.0, -0.05, 3.0, 1e-3];
        let states: Vec<State> = (scale.iter())
            .map(|scale| State::new(start.q.as_slice(), (&start.v * *scale).as_slice()))
            .collect();
        let input = |of: usize| u.iter().map(move |u| u * of as f64);
        let all = (0..scale.len()).flat_map(|of| (0..STEPS).flat_map(move |_| input(of)));
        let mut batch = BatchSimulator::new(simulator.clone(), scale.len());
        let found = batch.rollout_inputs(&states, STEPS, &all.collect::<Vec<_>>());
        for (of, state) in states.iter().enumerate() {
            let own: Vec<f64> = input(of).collect();
            let single = simulator.rollout(state, STEPS, |_, _, to| to.copy_from_slice(&own));
            assert_eq!(
                found.last(of),
                *single.last(),
                "{}",
                simulator.model().name()
            );
        }
    }
}

#[test]
fn other_integrators_smooth_it_and_remark_on_that() {
    for integrator in [Integrator::RungeKutta4, Integrator::ImplicitMidpoint] {
        let simulator = slider(1e-3, integrator);
        let said = simulator.remarks(&[0.0]);
        let smoothed = said
            .iter()
            .any(|remark| matches!(remark, SimulatorRemark::SmoothedFriction { .. }));
        assert!(smoothed, "{said:?}");
        // It creeps at v_s r / √(1 − r²) with r = 5/6.
        let pushed = simulator.rollout(&State::new(&[0.0], &[0.0]), 2000, |_, _, u| u[0] = 0.5);
        let creep = 1e-2 * 5.0 / 11.0_f64.sqrt();
        assert!(
            (pushed.last().v[0] - creep).abs() < 1e-5,
            "{}",
            pushed.last().v[0]
        );
    }
    let exact = slider(1e-3, Integrator::SemiImplicitEuler);
    assert!(exact.remarks(&[0.0]).is_empty());
}

#[test]
fn graphs_give_steps_and_jacobians_of_joints_that_stick_slide_and_arrive() {
    for integrator in EULER {
        for simulator in [
            slider(0.01, integrator),
            with_friction(samples::double_pendulum(), integrator),
        ] {
            let graphs = [step(&simulator), linearization(&simulator)];
            let n = simulator.model().nv();
            for (v, u) in [(1.5, 0.2), (0.0, 0.1), (1e-4, 0.1), (-1e-4, 0.0)] {
                let state = State::new(&vec![0.0; n], &vec![v; n]);
                let u = vec![u; n];
                let inputs: Vec<f64> = state.numbers().chain(&u).copied().collect();
                let (next, slopes) = (simulator.step(&state, &u), simulator.linearize(&state, &u));
                let expected: [Vec<f64>; 2] = [
                    next.numbers().copied().collect(),
                    slopes.a.iter().chain(&slopes.b).copied().collect(),
                ];
                for (graph, expected) in graphs.iter().zip(expected) {
                    let found = graph.evaluate(&inputs).expect("few rounds");
                    for (found, expected) in found.iter().zip(&expected) {
                        let error = (found - expected).abs();
                        assert!(error < 1e-9, "{integrator:?}, {v}: {found}, not {expected}");
                    }
                }
            }
        }
    }
}
