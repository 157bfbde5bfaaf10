//! Single precision against double: dynamics, and motions of a batch. A program of its own, for it compiles the physics on another scalar.

#[path = "it/common/mod.rs"]
#[allow(dead_code, unused_imports, reason = "most of it serves other tests")]
mod common;

use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, Rigid, SoftContact, Terrain};
use dualbody::dynamics::{forward_dynamics, inverse_dynamics};
use dualbody::model::samples;
use dualbody::scalar::SingleLanes;
use dualbody::sim::{RolloutStatus, SINGLE_WIDTH, SingleBatch};
use dualbody::{Model, Scalar, Simulator, State};

use common::{asset, random_point};

/// Steps of a motion.
const STEPS: usize = 1000;

/// Points in the lanes.
const POINTS: usize = 4;

/// The k-th numbers of several vectors side by side.
fn side_by_side<'a>(n: usize, of: impl Fn(usize) -> &'a [f64]) -> Vec<SingleLanes<POINTS>> {
    let number = |k: usize| SingleLanes::from_values(|lane| of(lane)[k]);
    (0..n).map(number).collect()
}

/// Largest differences of joint forces and accelerations, relative to the largest one at the same point.
fn errors_of_dynamics(model: &Model) -> [f64; 2] {
    let mut out = [0.0_f64; 2];
    for seed in 0..10 {
        let points: [_; POINTS] =
            std::array::from_fn(|lane| random_point(model, 100 * seed + lane as u64));
        let q = side_by_side(model.nq(), |lane| points[lane].q.as_slice());
        let v = side_by_side(model.nv(), |lane| points[lane].v.as_slice());
        let w = side_by_side(model.nv(), |lane| points[lane].w.as_slice());
        let tau = inverse_dynamics(model, &q, &v, &w);
        let a = forward_dynamics(model, &q, &v, &w);
        for (lane, at) in points.iter().enumerate() {
            let (q, v, w) = (at.q.as_slice(), at.v.as_slice(), at.w.as_slice());
            let exact = [
                inverse_dynamics(model, q, v, w),
                forward_dynamics(model, q, v, w),
            ];
            for (k, (own, exact)) in [&tau, &a].into_iter().zip(&exact).enumerate() {
                let off = own.map(|x| x.value(lane)) - exact;
                out[k] = out[k].max(off.amax() / exact.amax());
            }
        }
    }
    out
}

/// Input of a motor that holds a joint at its zero, N·m: a spring and a damper.
struct Motors {
    stiffness: f64,
    damping: f64,
}

impl Motors {
    const NONE: Self = Self {
        stiffness: 0.0,
        damping: 0.0,
    };

    fn set(&self, state: &State, u: &mut [f64]) {
        for (i, u) in u.iter_mut().enumerate() {
            *u = -self.stiffness * state.q[i] - self.damping * state.v[i];
        }
    }
}

/// Largest differences of coordinates and velocities, relative to the largest of them at that time, or to one: after a step, and after any of all.
fn errors_of_motion(simulator: &Simulator, starts: &[State], motors: &Motors) -> [f64; 2] {
    let nu = simulator.nu();
    let mut batch = SingleBatch::new(simulator.clone(), starts);
    let mut inputs = vec![0.0; nu * starts.len()];
    let exact: Vec<_> = starts
        .iter()
        .map(|start| simulator.rollout(start, STEPS, |_, state, u| motors.set(state, u)))
        .collect();
    let mut out = [0.0_f64; 2];
    for step in 1..=STEPS {
        for i in 0..starts.len() {
            motors.set(&batch.state(i), &mut inputs[nu * i..][..nu]);
        }
        batch.step(&inputs);
        for (i, exact) in exact.iter().enumerate() {
            assert_eq!(batch.status(i), RolloutStatus::Completed);
            assert_eq!(batch.solver_failure(i), None);
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

/// So many states around one, with other velocities of their first and last coordinate.
fn around(simulator: &Simulator, state: &State, by: f64, count: usize) -> Vec<State> {
    let of = |k: usize| {
        let mut own = state.clone();
        own.v[0] += by * (k as f64).sin();
        own.v[simulator.model().nv() - 1] += by * (k as f64).cos();
        own
    };
    (0..count).map(of).collect()
}

#[track_caller]
fn assert_below(what: &str, found: [f64; 2], most: [f64; 2]) {
    println!("{what}: {found:?}");
    assert!(
        found[0] < most[0] && found[1] < most[1],
        "{what}: {found:?}"
    );
}

// Bounds here and below are three to seven times the measured errors.
#[test]
fn dynamics_in_single_precision_are_near_those_in_double() {
    for (robot, model) in [
        ("arm", samples::arm()),
        ("quadruped", asset("quadruped.urdf")),
        ("humanoid", asset("humanoid.urdf")),
    ] {
        assert_below(robot, errors_of_dynamics(&model), [2e-6, 2e-6]);
    }
}

#[test]
fn motions_in_single_precision_stay_near_those_in_double() {
    let arm = Simulator::new(samples::arm()).with_time_step(1e-3);
    let start = arm.state(&[0.3; 7], &[0.2; 7]);
    // As many as leave the last group not full.
    let starts = around(&arm, &start, 0.1, SINGLE_WIDTH + 3);
    let held = Motors {
        stiffness: 20.0,
        damping: 0.5,
    };
    let found = errors_of_motion(&arm, &starts, &held);
    assert_below("arm, held", found, [6e-7, 1.5e-5]);
    let found = errors_of_motion(&arm, &starts, &Motors::NONE);
    assert_below("arm, free", found, [1e-7, 0.5]);
    let robot = Simulator::new(asset("quadruped.urdf")).with_time_step(1e-3);
    let mut start = robot.neutral_state();
    start.v[3] = 0.5;
    let starts = around(&robot, &start, 0.1, SINGLE_WIDTH + 3);
    let found = errors_of_motion(&robot, &starts, &Motors::NONE);
    assert_below("quadruped in the air", found, [1e-7, 3e-5]);
}

#[test]
fn motions_in_contact_in_single_precision_stay_near_those_in_double() {
    let model = asset("box.urdf");
    let soft = ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3));
    let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let rigid = ContactLaw::Rigid(Rigid::default());
    for (what, law, most) in [
        ("relaxed", relaxed, [2e-8, 2e-6]),
        ("soft", soft, [2e-8, 4e-6]),
        ("rigid", rigid, [1e-7, 8e-5]),
    ] {
        let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
        let brick = Simulator::new(model.clone())
            .with_contacts(contacts)
            .with_time_step(1e-3);
        let mut start = brick.neutral_state();
        start.q[2] = 0.06;
        start.v[0] = 0.5;
        let starts = around(&brick, &start, 0.05, 5);
        let found = errors_of_motion(&brick, &starts, &Motors::NONE);
        assert_below(what, found, most);
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
    (inputs[7], inputs[19]) = (f64::NAN, 1e12);
    batch.step(&inputs);
    assert_eq!(batch.status(7), RolloutStatus::NonFiniteInput { step: 0 });
    assert_eq!(batch.status(19), RolloutStatus::Diverged { step: 0 });
    assert!((batch.state(7).q[0] - 0.7).abs() < 1e-7);
    let next = pendulum.step(&starts[8], &[0.0]);
    assert!((batch.state(8).q[0] - next.q[0]).abs() < 1e-6);
    batch.set(7, &starts[0]);
    assert_eq!(batch.status(7), RolloutStatus::Completed);
}
