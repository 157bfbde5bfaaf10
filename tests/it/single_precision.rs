//! A batch in single precision against the simulator in double.

use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, SoftContact, Terrain};
use dualbody::model::samples;
use dualbody::sim::{RolloutStatus, SINGLE_WIDTH, SingleBatch};
use dualbody::{Simulator, State};

use crate::common::asset;

/// Steps of a motion.
const STEPS: usize = 1000;

/// Largest differences of coordinates and velocities, beside the largest coordinate or velocity on the way: after a step, and after all.
fn errors(simulator: &Simulator, starts: &[State]) -> [f64; 2] {
    let nu = simulator.nu();
    let mut batch = SingleBatch::new(simulator.clone(), starts);
    let inputs = vec![0.0; nu * starts.len()];
    let exact: Vec<_> = starts
        .iter()
        .map(|start| simulator.rollout(start, STEPS, |_, _, _| {}))
        .collect();
    let mut out = [0.0_f64; 2];
    for step in 1..=STEPS {
        batch.step(&inputs);
        for (i, exact) in exact.iter().enumerate() {
            assert_eq!(batch.status(i), RolloutStatus::Completed);
            let (own, exact) = (batch.state(i), &exact.states[step]);
            let size = exact.numbers().fold(1.0_f64, |most, x| most.max(x.abs()));
            let off = own.numbers().zip(exact.numbers());
            let off = off.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            if step == 1 {
                out[0] = out[0].max(off / size);
            }
            out[1] = out[1].max(off / size);
        }
    }
    out
}

/// States around one, moved along their first coordinates and velocities; as many as leave the last group not full.
fn around(simulator: &Simulator, state: &State, by: f64) -> Vec<State> {
    let of = |k: usize| {
        let mut own = state.clone();
        own.v[0] += by * (k as f64).sin();
        own.v[simulator.model().nv() - 1] += by * (k as f64).cos();
        own
    };
    (0..SINGLE_WIDTH + 3).map(of).collect()
}

#[track_caller]
fn assert_errors(what: &str, simulator: &Simulator, starts: &[State], most: [f64; 2]) {
    let found = errors(simulator, starts);
    println!("{what}: {found:?}");
    assert!(
        found[0] < most[0] && found[1] < most[1],
        "{what}: {found:?}"
    );
}

#[test]
fn single_precision_stays_near_double_in_dynamics() {
    let arm = Simulator::new(samples::arm()).with_time_step(1e-3);
    let start = arm.state(&[0.3; 7], &[0.2; 7]);
    assert_errors("arm", &arm, &around(&arm, &start, 0.1), [1e-6, 2e-3]);
    let robot = Simulator::new(asset("quadruped.urdf")).with_time_step(1e-3);
    let mut start = robot.neutral_state();
    start.v[3] = 0.5;
    assert_errors(
        "quadruped",
        &robot,
        &around(&robot, &start, 0.1),
        [1e-6, 2e-3],
    );
}

#[test]
fn single_precision_stays_near_double_in_contact() {
    let model = asset("box.urdf");
    let soft = ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3));
    let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    for (what, law) in [("relaxed", relaxed), ("soft", soft)] {
        let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
        let brick = Simulator::new(model.clone())
            .with_contacts(contacts)
            .with_time_step(1e-3);
        let mut start = brick.neutral_state();
        start.q[2] = 0.06;
        start.v[0] = 0.5;
        assert_errors(what, &brick, &around(&brick, &start, 0.05), [1e-4, 2e-3]);
    }
}

#[test]
fn a_state_that_diverges_stops_alone() {
    let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.01);
    let starts: Vec<State> = (0..20)
        .map(|k| pendulum.state(&[0.1 * f64::from(k)], &[0.0]))
        .collect();
    let mut batch = SingleBatch::new(pendulum.clone(), &starts);
    let mut inputs = [0.0; 20];
    inputs[7] = f64::NAN;
    batch.step(&inputs);
    assert_eq!(batch.status(7), RolloutStatus::Diverged { step: 0 });
    assert!((batch.state(7).q[0] - 0.7).abs() < 1e-7);
    let next = pendulum.step(&starts[8], &[0.0]);
    assert!((batch.state(8).q[0] - next.q[0]).abs() < 1e-6);
    batch.set(7, &starts[0]);
    assert_eq!(batch.status(7), RolloutStatus::Completed);
}
