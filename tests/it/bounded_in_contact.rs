//! Servos with limits and dry friction of a robot in contact. Given their forces as inputs, a robot without them takes the same semi-implicit Euler steps: so
//! contact does not depend on which piece of their law they are on. Derivatives against differences; batches against single steps.

use dualbody::contact::{ContactLaw, RelaxedRigid, Rigid, Terrain};
use dualbody::sim::{Actuation, Actuator, BatchSimulator, CoulombFriction, Servo, StepScratch};
use dualbody::{Integrator, Simulator, State};
use nalgebra::{DMatrix, DVector};

use crate::common::OTHER_ALGORITHM;
use crate::common::quadruped::{crouching, quadruped};

const EULER: [Integrator; 2] = [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity];
const KP: f64 = 60.0;
const KV: f64 = 2.0;
/// N·m; the upper one is reached often, the lower one by hard landings.
const RANGE: [f64; 2] = [-14.0, 9.0];
const FRICTION: f64 = 0.6;
/// First coordinate of the legs.
const LEGS: usize = 6;
const STEPS: usize = 120;

fn laws() -> [ContactLaw; 2] {
    [
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        ContactLaw::Rigid(Rigid::default()),
    ]
}

/// A quadruped with joint limits, with other motors in its legs.
fn driven(law: ContactLaw, integrator: Integrator, dt: f64, motor: Actuator) -> Simulator {
    let plain = quadruped(|_| law, Terrain::flat(0.0));
    let model = plain.model();
    let actuation = Actuation::from_model(model);
    let mut actuators = actuation.actuators().to_vec();
    for own in &mut actuators[LEGS..] {
        let position = own.position;
        *own = Actuator { position, ..motor };
    }
    let actuation = actuation.with_actuators(&actuators);
    (plain.with_actuation(actuation))
        .with_integrator(integrator)
        .with_time_step(dt)
}

fn motor(friction: f64) -> Actuator {
    let [lower, upper] = RANGE;
    Actuator {
        servo: Some(Servo::position(KP, KV).with_force_range(lower, upper)),
        friction: (friction > 0.0).then(|| CoulombFriction::exact(friction)),
        ..Actuator::default()
    }
}

/// Targets that swing, some of them beyond the limits of the joints.
fn targets(step: usize, dt: f64) -> DVector<f64> {
    let phase = |k: usize| 9.0 * step as f64 * dt + k as f64;
    let rest = [0.0, 0.8, -1.6];
    DVector::from_fn(12, |k, _| rest[k % 3] + 0.35 * phase(k).sin())
}

fn fall(simulator: &Simulator, dt: f64) -> Vec<(State, DVector<f64>)> {
    let start = crouching(simulator, 0.33);
    let rollout = simulator.rollout(&start, STEPS, |time, _, u| {
        let step = (time / dt).round() as usize;
        u.copy_from_slice(targets(step, dt).as_slice());
    });
    let inputs = (0..STEPS).map(|step| targets(step, dt));
    rollout.states.into_iter().zip(inputs).collect()
}

/// Forces of the servos after a step, and how many are at the end of their range.
fn servo_forces(state: &State, next: &State, u: &DVector<f64>, dt: f64) -> (DVector<f64>, usize) {
    let [lower, upper] = RANGE;
    let free = DVector::from_fn(12, |k, _| {
        let v = next.v[LEGS + k];
        KP * (u[k] - state.q[7 + k] - dt * v) - KV * v
    });
    let at_end = free.iter().filter(|f| !(lower..=upper).contains(*f));
    (free.map(|f| f.clamp(lower, upper)), at_end.count())
}

#[test]
fn steps_equal_those_of_a_robot_that_gets_the_forces_as_inputs() {
    let (mut limited, mut within, mut at_stops, mut touching) = (0, 0, 0, [0; 5]);
    for law in laws() {
        for dt in [1e-3, 1e-2] {
            let integrator = Integrator::SemiImplicitEuler;
            let own = driven(law, integrator, dt, motor(0.0));
            let plain = driven(law, integrator, dt, Actuator::default());
            let mut scratch = StepScratch::new(&own);
            for (step, (state, u)) in fall(&own, dt).into_iter().enumerate() {
                let mut next = state.clone();
                own.step_into(&state, u.as_slice(), &mut scratch, &mut next);
                let (tau, count) = servo_forces(&state, &next, &u, dt);
                limited += count;
                within += 12 - count;
                let report = own.contact_report(&state, u.as_slice());
                touching[report.forces.iter().filter(|f| f.norm() > 0.0).count()] += 1;
                at_stops += usize::from(beyond_a_limit(&own, &next));
                let expected = plain.step(&state, tau.as_slice());
                let error = (&next.v - &expected.v).amax() / (1.0 + expected.v.amax());
                assert!(
                    error < OTHER_ALGORITHM,
                    "{law:?}, {dt}, step {step}: {error:e}"
                );
            }
        }
    }
    assert!(
        limited > 100 && within > 1000 && at_stops > 5,
        "{limited}, {within}, {at_stops}"
    );
    assert!(touching[0] > 20 && touching[4] > 20, "{touching:?}");
}

fn beyond_a_limit(simulator: &Simulator, state: &State) -> bool {
    let actuators = simulator.actuation().expect("motors").actuators();
    (0..12).any(|k| {
        let limits = actuators[LEGS + k].position.expect("limits");
        let (q, inner) = (state.q[7 + k], |end: Option<f64>| end.expect("an end"));
        q < inner(limits.lower) || q > inner(limits.upper)
    })
}

// The friction of a joint that sticks is found from where the robot without friction has to be pushed to stick.
#[test]
fn dry_friction_obeys_its_law_in_contact() {
    let (mut stuck, mut slipping) = (0, 0);
    for law in laws() {
        for dt in [1e-3, 5e-3] {
            let integrator = Integrator::SemiImplicitEuler;
            let own = driven(law, integrator, dt, motor(FRICTION));
            let plain = driven(law, integrator, dt, Actuator::default());
            for (step, (state, u)) in fall(&own, dt).into_iter().enumerate().step_by(3) {
                let next = own.step(&state, u.as_slice());
                let (mut tau, _) = servo_forces(&state, &next, &u, dt);
                let sticks: Vec<usize> =
                    (0..12).filter(|k| next.v[LEGS + k].abs() < 1e-12).collect();
                for k in (0..12).filter(|k| !sticks.contains(k)) {
                    tau[k] -= FRICTION * next.v[LEGS + k].signum();
                }
                let before = tau.clone();
                for _ in 0..6 {
                    stop(&plain, &state, &sticks, &mut tau);
                }
                let largest = (&tau - before).amax();
                assert!(largest < FRICTION * (1.0 + 1e-6), "{step}: {largest}");
                let expected = plain.step(&state, tau.as_slice());
                let error = (&next.v - &expected.v).amax() / (1.0 + expected.v.amax());
                assert!(error < 1e-8, "{law:?}, {dt}, step {step}: {error:e}");
                stuck += sticks.len();
                slipping += 12 - sticks.len();
            }
        }
    }
    assert!(stuck > 20 && slipping > 200, "{stuck}, {slipping}");
}

/// Newton's step for the forces after which some joints are at rest.
fn stop(plain: &Simulator, state: &State, joints: &[usize], tau: &mut DVector<f64>) {
    if joints.is_empty() {
        return;
    }
    let next = plain.step(state, tau.as_slice());
    let b = plain.linearize(state, tau.as_slice()).b;
    let n = joints.len();
    let nv = plain.model().nv();
    let own = DMatrix::from_fn(n, n, |i, j| b[(nv + LEGS + joints[i], joints[j])]);
    let rest = DVector::from_fn(n, |i, _| next.v[LEGS + joints[i]]);
    let change = own.lu().solve(&rest).expect("joints that can be moved");
    joints.iter().zip(&change).for_each(|(&k, x)| tau[k] -= x);
}

/// The numbers of a step along tangents, from those of another state.
fn tangent(simulator: &Simulator, from: &State, to: &State) -> DVector<f64> {
    let dq = (simulator.model()).difference(from.q.as_slice(), to.q.as_slice());
    DVector::from_iterator(
        2 * dq.len(),
        dq.iter().chain((&to.v - &from.v).iter()).copied(),
    )
}

#[test]
fn jacobians_and_gradients_equal_differences_at_limits_and_in_contact() {
    const SIZE: f64 = 1e-6;
    let (mut columns, mut switches) = (0, 0);
    for law in laws() {
        for friction in [0.0, FRICTION] {
            for (dt, integrator) in [1e-3, 1e-2].into_iter().zip(EULER) {
                let own = driven(law, integrator, dt, motor(friction));
                let nv = own.model().nv();
                for (state, u) in fall(&own, dt).into_iter().step_by(23) {
                    let next = own.step(&state, u.as_slice());
                    let found = own.linearize(&state, u.as_slice());
                    let moved = |column: usize, by: f64| {
                        let (mut at, mut u) = (state.clone(), u.clone());
                        match column {
                            k if k < nv => {
                                let mut dv = vec![0.0; nv];
                                dv[k] = by;
                                at.q = own.model().integrate(state.q.as_slice(), &dv);
                            }
                            k if k < 2 * nv => at.v[k - nv] += by,
                            k => u[k - 2 * nv] += by,
                        }
                        tangent(&own, &next, &own.step(&at, u.as_slice()))
                    };
                    for column in 0..2 * nv + 12 {
                        let (up, down) = (moved(column, SIZE), moved(column, -SIZE));
                        let size = 1.0 + up.amax() / SIZE;
                        // Between two pieces of a law the sides differ.
                        if (&up + &down).amax() > 1e-4 * SIZE * size {
                            switches += 1;
                            continue;
                        }
                        let expected = (up - down) / (2.0 * SIZE);
                        let own = match column < 2 * nv {
                            true => found.a.column(column).rows(0, 2 * nv).clone_owned(),
                            false => found
                                .b
                                .column(column - 2 * nv)
                                .rows(0, 2 * nv)
                                .clone_owned(),
                        };
                        let error = (own - expected).amax() / size;
                        assert!(
                            error < 2e-5,
                            "{law:?}, {friction}, {dt}, {column}: {error:e}"
                        );
                        columns += 1;
                    }
                    assert_gradient(&own, &state, &u);
                }
            }
        }
    }
    assert!(columns > 20 * switches, "{columns}, {switches}");
}

/// Forward against adjoint, and the adjoint in the parameters of motors and in the time step against differences.
fn assert_gradient(simulator: &Simulator, state: &State, u: &DVector<f64>) {
    let found = simulator.linearize(state, u.as_slice());
    let weights = DVector::from_fn(found.a.nrows(), |k, _| (1.3 * k as f64).sin());
    let gradient = simulator.vjp(state, u.as_slice(), weights.as_slice());
    let by_state = found.a.tr_mul(&weights);
    let by_input = found.b.tr_mul(&weights);
    let pairs = [(&gradient.state, by_state), (&gradient.input, by_input)];
    for (k, (&x, expected)) in pairs
        .iter()
        .flat_map(|(own, by)| own.iter().zip(by.iter().copied()))
        .enumerate()
    {
        let error = (x - expected).abs() / (1.0 + expected.abs());
        assert!(error < 1e-8, "{k}: {x}, not {expected}");
    }
    let next = simulator.step(state, u.as_slice());
    let parameters = simulator.parameters();
    let along = |k: usize, by: f64| {
        let mut changed = parameters.clone();
        changed[k] += by;
        let moved = (simulator.with_parameters(changed.as_slice())).step(state, u.as_slice());
        let n = 2 * simulator.model().nv();
        tangent(simulator, &next, &moved).dot(&weights.rows(0, n))
    };
    // Some of the parameters of links, contact points and motors, which are alike, and the time step.
    let last = parameters.len() - 1;
    for k in (0..last).step_by(17).chain([last]) {
        // Parameters that are not negative, and absent ones, stay.
        if parameters[k] == 0.0 {
            continue;
        }
        let size = 1e-4 * parameters[k].abs();
        let [up, down] = [along(k, size), along(k, -size)];
        if (up + down).abs() > 1e-3 * (up.abs() + down.abs()) + 1e-13 {
            continue;
        }
        let (x, expected) = (gradient.parameters[k], (up - down) / (2.0 * size));
        assert!(
            (x - expected).abs() < 1e-4 * (1.0 + expected.abs()) + 1e-11 / size,
            "parameter {k}, {}: {x}, not {expected}, {up:e}, {down:e}",
            parameters[k]
        );
    }
}

#[test]
fn batches_of_robots_at_different_limits_give_the_bits_of_single_steps() {
    for law in laws() {
        for integrator in EULER {
            for friction in [0.0, FRICTION] {
                assert_same_bits(&driven(law, integrator, 5e-3, motor(friction)));
            }
        }
    }
}

/// A batch of states in flight, of landing and on the ground, beside single steps.
fn assert_same_bits(own: &Simulator) {
    let states: Vec<_> = fall(own, 5e-3).into_iter().step_by(7).collect();
    let mut batch = BatchSimulator::new(own.clone(), states.len());
    let starts: Vec<State> = states.iter().map(|(state, _)| state.clone()).collect();
    let inputs: Vec<f64> = states.iter().flat_map(|(_, u)| u.iter().copied()).collect();
    let mut together = batch.states(&starts);
    batch.step(&mut together, &inputs);
    for (k, (state, u)) in states.iter().enumerate() {
        let alone = own.step(state, u.as_slice());
        let bits = |state: &State| -> Vec<u64> { state.numbers().map(|x| x.to_bits()).collect() };
        let name = own.integrator();
        assert_eq!(
            bits(&together.state(k)),
            bits(&alone),
            "{name:?}, state {k}"
        );
    }
}
