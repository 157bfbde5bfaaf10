//! Many joint limits at once over a step: each pushes by its law at the end of the step, and none pulls. Robots without rows against inverse dynamics and
//! against the solver of rows; derivatives against those of the solver; lanes against single steps.

use dualbody::cone::Status;
use dualbody::contact::HuntCrossley;
use dualbody::dynamics::inverse_dynamics;
use dualbody::joint::JointKind;
use dualbody::model::samples;
use dualbody::sim::{
    Actuation, Actuator, BatchSimulator, CoulombFriction, PositionLimits, StepScratch,
};
use dualbody::{Integrator, Simulator, State};
use nalgebra::DVector;

use crate::common::{
    OTHER_ALGORITHM, SAME_ALGEBRA, generator, random_tangent, relative_error, with_solver,
};

const DT: f64 = 5e-3;
const STIFFNESS: f64 = 3e3;
const DAMPING: f64 = 20.0;
const ROBOTS: u64 = 6;

/// A tree of joints of one degree of freedom, whose ranges of at most 0.04 rad or m begin or end near the neutral position.
///
/// * `friction` – exact friction of every second joint, N·m or N
fn narrow(robot: u64, friction: Option<f64>) -> Simulator {
    let kinds = [
        JointKind::Revolute,
        JointKind::Revolute,
        JointKind::Prismatic,
    ];
    let model = samples::random_tree_of(&kinds, 8 + 2 * robot as usize, robot);
    let mut actuators = vec![Actuator::default(); model.nv()];
    for (k, own) in actuators.iter_mut().enumerate() {
        let lower = 0.02 * (k as f64).sin() - 0.02;
        own.position = Some(PositionLimits {
            lower: Some(lower),
            upper: Some(lower + 0.01 * (k % 5) as f64),
            stop: HuntCrossley::linear(STIFFNESS, DAMPING),
        });
        own.friction = friction.filter(|_| k % 2 == 0).map(CoulombFriction::exact);
    }
    let actuation = Actuation::ideal(&model).with_actuators(&actuators);
    Simulator::new(model)
        .with_actuation(actuation)
        .with_time_step(DT)
}

/// A state with most joints beyond an end of their range, or on the way there, and an input.
fn near_limits(simulator: &Simulator, seed: u64) -> (State, DVector<f64>) {
    let model = simulator.model();
    let rng = &mut generator(seed);
    let mut random = |size: f64| random_tangent(model, rng) * size;
    let (q, v, u) = (random(0.04), random(4.0), random(30.0));
    (State::new(q.as_slice(), v.as_slice()), u)
}

fn all(
    friction: Option<f64>,
    seeds: u64,
) -> impl Iterator<Item = (Simulator, State, DVector<f64>)> {
    let robots = (0..ROBOTS).map(move |robot| (robot, narrow(robot, friction)));
    robots.flat_map(move |(robot, simulator)| {
        (0..seeds).map(move |seed| {
            let (state, u) = near_limits(&simulator, 1000 * robot + seed);
            (simulator.clone(), state, u)
        })
    })
}

/// The push of an end whose joint moves out of it with `before` at the start of the step, and with `after` at its end.
fn push(depth: f64, before: f64, after: f64) -> f64 {
    let spring = if depth > DT * before { STIFFNESS } else { 0.0 };
    let damper = if depth > 0.0 { DAMPING } else { 0.0 };
    (spring * (depth - DT * after) - damper * after).max(0.0)
}

/// Forces of the limits of all joints, and how many ends push and how many within reach do not.
fn limit_forces(
    simulator: &Simulator,
    state: &State,
    v: &DVector<f64>,
) -> (DVector<f64>, [usize; 2]) {
    let actuators = simulator.actuation().expect("limits").actuators();
    let (mut sum, mut counts) = (DVector::zeros(v.len()), [0; 2]);
    for (k, own) in actuators.iter().enumerate() {
        let limits = own.position.expect("limits");
        let ends = [(limits.lower, 1.0), (limits.upper, -1.0)];
        for (end, inward) in ends {
            let depth = inward * (end.expect("an end") - state.q[k]);
            let before = inward * state.v[k];
            let force = push(depth, before, inward * v[k]);
            sum[k] += inward * force;
            let within_reach = depth.max(depth - DT * before) > 0.0;
            counts[usize::from(force == 0.0)] += usize::from(within_reach);
        }
    }
    (sum, counts)
}

/// The forces that are left of those that the motion needs, those of dry friction.
fn friction_forces(
    simulator: &Simulator,
    state: &State,
    v: &DVector<f64>,
    u: &DVector<f64>,
) -> (DVector<f64>, [usize; 2]) {
    let model = simulator.model();
    let a = (v - &state.v) / DT;
    let (q, before) = (state.q.as_slice(), state.v.as_slice());
    let needed = inverse_dynamics(model, q, before, a.as_slice());
    let (limits, counts) = limit_forces(simulator, state, v);
    let damping = DVector::from_column_slice(model.damping()).component_mul(v);
    (needed - u - limits + damping, counts)
}

#[test]
fn each_limit_pushes_by_its_law_and_none_pulls() {
    let mut counts = [0; 2];
    for (simulator, state, u) in all(None, 60) {
        let next = simulator.step(&state, u.as_slice());
        let (rest, own) = friction_forces(&simulator, &state, &next.v, &u);
        let scale = 1.0 + STIFFNESS * DT * next.v.amax();
        assert!(rest.amax() < OTHER_ALGORITHM * scale, "{rest}");
        (counts[0], counts[1]) = (counts[0] + own[0], counts[1] + own[1]);
    }
    assert!(counts.iter().all(|&n| n > 500), "{counts:?}");
}

#[test]
fn limits_and_dry_friction_obey_their_laws_together() {
    const BOUND: f64 = 40.0;
    let (mut sticking, mut sliding) = (0, 0);
    for (simulator, state, u) in all(Some(BOUND), 40) {
        let next = simulator.step(&state, u.as_slice());
        let (force, _) = friction_forces(&simulator, &state, &next.v, &u);
        let tolerance = OTHER_ALGORITHM * (1.0 + STIFFNESS * DT * next.v.amax());
        for (k, (&force, &v)) in force.iter().zip(&next.v).enumerate() {
            let bound = if k % 2 == 0 { BOUND } else { 0.0 };
            assert!(force.abs() < bound + tolerance, "{k}: {force} N at {v} m/s");
            if bound > 0.0 && v.abs() > 1e-9 {
                assert!(
                    (force + bound.copysign(v)).abs() < tolerance,
                    "{k}: {force} N"
                );
                sliding += 1;
            } else {
                sticking += usize::from(bound > 0.0);
            }
        }
    }
    assert!(sticking > 100 && sliding > 100, "{sticking}, {sliding}");
}

// Semi-implicit Euler has velocity forces of the middle of the step beside constraints alone.
#[test]
fn motion_and_derivatives_are_those_of_the_solver_of_rows() {
    let mut compared = 0;
    for (simulator, state, u) in all(None, 24) {
        let simulator = simulator.with_integrator(Integrator::ImplicitVelocity);
        let solved = with_solver(&simulator);
        let (mut scratch, mut by_rows) = (StepScratch::new(&solved), state.clone());
        solved.step_into(&state, u.as_slice(), &mut scratch, &mut by_rows);
        if scratch.solver_status(0) != Status::Converged {
            continue;
        }
        compared += 1;
        let next = simulator.step(&state, u.as_slice());
        let error = (&next.v - &by_rows.v).amax() / (1.0 + by_rows.v.amax());
        assert!(error < OTHER_ALGORITHM, "{error:e}");
        let own = simulator.linearize(&state, u.as_slice());
        let other = solved.linearize(&state, u.as_slice());
        let error = relative_error(&own.a, &other.a).max(relative_error(&own.b, &other.b));
        assert!(error < 1e-8, "{error:e}");
        let weights = DVector::from_fn(own.a.nrows(), |k, _| (1.3 * k as f64).sin());
        let gradient = simulator.vjp(&state, u.as_slice(), weights.as_slice());
        let error = gradient.state - own.a.tr_mul(&weights);
        assert!(
            error.amax() < SAME_ALGEBRA * (1.0 + own.a.amax()) * 10.0,
            "{error}"
        );
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn lanes_with_other_limits_give_the_bits_of_single_steps() {
    for simulator in (0..ROBOTS).map(|robot| narrow(robot, Some(1.0))) {
        let all: Vec<_> = (0..11).map(|seed| near_limits(&simulator, seed)).collect();
        let starts: Vec<State> = all.iter().map(|(state, _)| state.clone()).collect();
        let inputs: Vec<f64> = all.iter().flat_map(|(_, u)| u.iter().copied()).collect();
        let mut batch = BatchSimulator::new(simulator.clone(), starts.len());
        let mut states = batch.states(&starts);
        let mut scratch = StepScratch::new(&simulator);
        let mut before = starts;
        for step in 0..5 {
            batch.step(&mut states, &inputs);
            for (k, (state, (_, u))) in before.iter_mut().zip(&all).enumerate() {
                let mut next = simulator.neutral_state();
                simulator.step_into(state, u.as_slice(), &mut scratch, &mut next);
                let bits = |state: &State| state.numbers().map(|x| x.to_bits()).collect::<Vec<_>>();
                assert_eq!(
                    bits(&states.state(k)),
                    bits(&next),
                    "state {k}, step {step}"
                );
                *state = next;
            }
        }
    }
}
