//! Episodes over lanes: they do not depend on their number.

use dualbody::model::samples;
use dualbody::sim::{
    AutoReset, BATCH_WIDTH, BatchScalar, BatchSimulator, Environment, Environments, Episode,
};
use dualbody::{Simulator, State};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{Rng, RngExt, SeedableRng};

/// A pole is kept up; each episode has a wind of its own, that begins after a while.
struct Windy;

const REACH: f64 = 0.3;
const DECIMATION: usize = 3;
const TIME_STEP: f64 = 0.01;
const WIND_BEGINS: f64 = 0.1;

impl Environment for Windy {
    fn n_actions(&self) -> usize {
        1
    }

    fn n_observations(&self) -> usize {
        3
    }

    fn n_drawn(&self) -> usize {
        1
    }

    fn start(&self, rng: &mut dyn Rng, state: &mut State, drawn: &mut [f64]) {
        assert!(state.v.norm() == 0.0 && drawn == [0.0]);
        state.q[1] = rng.random_range(-0.1..0.1);
        drawn[0] = rng.random_range(-1.0..1.0);
    }

    fn act(&self, now: &Episode<'_>, action: &[BatchScalar], u: &mut [BatchScalar]) {
        for lane in 0..BATCH_WIDTH {
            let blows = now.time.0[lane] > WIND_BEGINS;
            let wind = if blows { now.drawn[0].0[lane] } else { 0.0 };
            u[0].0[lane] = action[0].0[lane] + wind;
        }
    }

    fn observe(&self, now: &Episode<'_>, out: &mut [BatchScalar]) {
        out.copy_from_slice(&[now.state.q[0], now.state.q[1], now.time]);
    }

    fn reward(&self, now: &Episode<'_>, action: &[BatchScalar]) -> BatchScalar {
        now.state.q[1] * 2.0 + action[0]
    }

    fn is_over(&self, now: &Episode<'_>) -> [bool; BATCH_WIDTH] {
        now.state.q[1].0.map(|q| q.abs() > REACH)
    }
}

fn simulator() -> Simulator {
    let simulator = Simulator::new(samples::cartpole()).with_time_step(TIME_STEP);
    simulator
        .with_actuated_joints(&["linear"])
        .expect("a joint")
}

fn environments(len: usize, seed: u64, auto_reset: AutoReset) -> Environments<Windy> {
    let batch = BatchSimulator::new(simulator(), len);
    Environments::new(Windy, batch, seed)
        .with_decimation(DECIMATION)
        .with_max_length(25)
        .with_auto_reset(auto_reset)
}

/// An action that depends on the state's seed, not on its place.
fn action(seed: usize, step: usize) -> f64 {
    (1.3 * seed as f64 + 0.7 * step as f64).sin()
}

/// One episode after the other, as a loop over one state.
fn alone(seed: usize, auto_reset: AutoReset, steps: usize) -> Vec<(Vec<f64>, f64, bool, bool)> {
    let mut one = environments(1, seed as u64, auto_reset);
    let mut next = one.transitions();
    one.reset(&mut next.observations);
    let take = |step| {
        one.step(&[action(seed, step)], &mut next);
        let ends = (next.terminated[0], next.truncated[0]);
        (next.observations.clone(), next.rewards[0], ends.0, ends.1)
    };
    (0..steps).map(take).collect()
}

#[test]
fn an_episode_depends_on_its_seed_and_its_actions_only() {
    let (steps, len) = (80, 2 * BATCH_WIDTH + 3);
    for auto_reset in [AutoReset::NextStep, AutoReset::SameStep] {
        for threads in [1, 2] {
            let mut all = environments(len, 40, auto_reset).with_threads(threads);
            let mut next = all.transitions();
            all.reset(&mut next.observations);
            let expected: Vec<_> = (0..len).map(|i| alone(40 + i, auto_reset, steps)).collect();
            let mut ends = [0, 0];
            for step in 0..steps {
                let actions: Vec<f64> = (0..len).map(|i| action(40 + i, step)).collect();
                all.step(&actions, &mut next);
                for (i, expected) in expected.iter().enumerate() {
                    let (observed, reward, over, cut) = &expected[step];
                    assert_eq!(
                        next.observations[3 * i..3 * i + 3],
                        observed[..],
                        "{i}, {step}"
                    );
                    let own = (next.rewards[i], next.terminated[i], next.truncated[i]);
                    assert_eq!(own, (*reward, *over, *cut), "{i}, {step}");
                    ends[0] += usize::from(*over);
                    ends[1] += usize::from(*cut);
                }
            }
            assert!(ends[0] > len && ends[1] > 0, "{ends:?}");
        }
    }
}

/// The same task by steps of one simulator.
#[test]
fn an_episode_is_what_steps_of_a_simulator_give() {
    let mut one = environments(1, 3, AutoReset::NextStep);
    let mut next = one.transitions();
    one.reset(&mut next.observations);
    // An episode began with the environment, another one with the reset.
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let (mut state, mut wind) = (simulator().neutral_state(), [0.0]);
    for _ in 0..2 {
        (state, wind) = (simulator().neutral_state(), [0.0]);
        Windy.start(&mut rng, &mut state, &mut wind);
    }
    assert_eq!(next.observations, [state.q[0], state.q[1], 0.0]);
    for step in 0..25 {
        let u = action(3, step);
        one.step(&[u], &mut next);
        for k in 0..DECIMATION {
            let time = (step * DECIMATION + k) as f64 * TIME_STEP;
            let blows = time > WIND_BEGINS + 1e-9;
            state = simulator().step(&state, &[u + if blows { wind[0] } else { 0.0 }]);
        }
        assert_eq!(next.observations[..2], *state.q.as_slice(), "{step}");
        assert_eq!(next.rewards[0], 2.0 * state.q[1] + u);
        assert_eq!(next.terminated[0], state.q[1].abs() > REACH);
        if next.terminated[0] {
            break;
        }
    }
    assert!(next.terminated[0] || next.truncated[0]);
    // The step after an end begins another episode, for any action.
    one.step(&[1e3], &mut next);
    assert_eq!(
        (next.rewards[0], next.terminated[0], next.truncated[0]),
        (0.0, false, false)
    );
    assert!(next.observations[0] == 0.0 && next.observations[2] == 0.0 && one.length(0) == 0);
}

// Each thread has a part of the groups; a robot of its own shows whether a state has stayed in its place.
#[test]
fn variants_on_any_number_of_threads_equal_single_environments() {
    const N: usize = 45;
    let damped = |k: usize| samples::cartpole().with_damping(1, 0.1 * k as f64);
    let run = |batch: BatchSimulator, first: usize, threads: usize| {
        let len = batch.len();
        let all = Environments::new(Windy, batch, first as u64).with_max_length(7);
        let mut all = all.with_auto_reset(AutoReset::SameStep);
        let (mut next, mut rows) = (all.transitions(), Vec::new());
        for step in 0..20 {
            // In the middle, as where it turns out that more threads pay.
            if step == 5 {
                all = all.with_threads(threads);
            }
            let actions: Vec<f64> = (first..first + len).map(|i| action(i, step)).collect();
            all.step(&actions, &mut next);
            rows.push(next.clone());
        }
        rows
    };
    let variants = |all: std::ops::Range<usize>| {
        BatchSimulator::of_variants(&simulator(), all.map(damped).collect()).expect("one robot")
    };
    let one = run(variants(0..N), 0, 1);
    for threads in [2, 3, 5, 100] {
        assert_eq!(run(variants(0..N), 0, threads), one, "{threads} threads");
    }
    for i in [0, 17, N - 1] {
        for (all, own) in one.iter().zip(run(variants(i..i + 1), i, 1)) {
            assert_eq!(all.observations[3 * i..3 * (i + 1)], own.observations);
            assert_eq!(
                all.final_observations[3 * i..3 * (i + 1)],
                own.final_observations
            );
            let ends = [all.terminated[i], all.truncated[i]];
            assert_eq!(ends, [own.terminated[0], own.truncated[0]]);
            assert_eq!(all.rewards[i], own.rewards[0]);
        }
    }
}

#[test]
fn the_last_observation_is_kept_where_an_episode_begins_in_the_step_of_an_end() {
    let mut all = environments(5, 9, AutoReset::SameStep);
    let mut next = all.transitions();
    all.reset(&mut next.observations);
    let mut ends = 0;
    for step in 0..60 {
        all.step(&[action(0, step); 5], &mut next);
        for i in 0..5 {
            let row = 3 * i..3 * i + 3;
            let (last, first) = (
                &next.final_observations[row.clone()],
                &next.observations[row],
            );
            if next.terminated[i] {
                assert!(last[1].abs() > REACH && first[1].abs() <= 0.1 && first[2] == 0.0);
                ends += 1;
            }
            assert!(!(next.terminated[i] && next.truncated[i]));
        }
    }
    assert!(ends > 5);
}

#[test]
fn without_automatic_reset_a_mask_begins_episodes() {
    let mut all = environments(11, 1, AutoReset::Never);
    let mut next = all.transitions();
    all.reset(&mut next.observations);
    while !all.needs_reset() {
        all.step(&[0.5; 11], &mut next);
    }
    let over: Vec<bool> = (0..11)
        .map(|i| next.terminated[i] || next.truncated[i])
        .collect();
    let mut again = vec![0.0; 33];
    all.reset_where(&over, &mut again);
    assert!(!all.needs_reset());
    for i in 0..11 {
        let row = 3 * i..3 * i + 3;
        match over[i] {
            true => assert!(again[3 * i + 2] == 0.0 && all.length(i) == 0),
            false => assert_eq!(again[row.clone()], next.observations[row]),
        }
    }
    // Seeded again, a state repeats its first draws.
    all.seed(10, 5);
    all.seed(2, 5);
    all.reset(&mut again);
    assert_eq!(again[30..33], again[6..9]);
}

#[test]
#[should_panic(expected = "an episode is over")]
fn an_episode_that_is_over_takes_no_step_without_automatic_reset() {
    let mut all = environments(2, 1, AutoReset::Never).with_max_length(2);
    let mut next = all.transitions();
    (0..3).for_each(|_| all.step(&[0.0; 2], &mut next));
}

#[test]
fn a_state_that_diverges_ends_its_episode_only() {
    let batch = BatchSimulator::new(simulator().with_divergence_bound(20.0), 3);
    let mut all = Environments::new(Windy, batch, 0).with_auto_reset(AutoReset::SameStep);
    let mut next = all.transitions();
    all.step(&[0.0, 1e6, 0.0], &mut next);
    assert_eq!(next.terminated, [false, true, false]);
    assert!(
        next.observations
            .iter()
            .chain(&next.final_observations)
            .all(|x| x.is_finite())
    );
    all.step(&[0.0; 3], &mut next);
    assert_eq!(next.terminated, [false; 3]);
}

#[test]
fn no_states_have_no_episodes() {
    let mut none = environments(0, 0, AutoReset::NextStep);
    let mut next = none.transitions();
    none.reset(&mut next.observations);
    none.step(&[], &mut next);
    assert!(next.rewards.is_empty() && !none.needs_reset());
}
