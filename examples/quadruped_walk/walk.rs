//! Robots walk by policies.

use dualbody::State;
use dualbody::sim::Environments;

use super::policy;
use super::task::{ACTIONS, DECIMATION, OBSERVED, TIME_STEP, Walk};

/// How an episode went.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outcome {
    /// Sum of the rewards.
    pub(crate) points: f64,
    /// Way along x, m.
    pub(crate) way: f64,
    /// Whether the robot fell.
    pub(crate) fell: bool,
}

impl Outcome {
    /// Whether the robot walked at 0.5 m/s or more on average, without a fall.
    pub(crate) fn has_walked(&self, seconds: f64) -> bool {
        !self.fell && self.way >= 0.5 * seconds
    }
}

/// Lets each robot walk by its policy, until it falls.
///
/// * `numbers` – the policy of a robot
/// * `seen` – is handed the first robot before each action, with the time in s
pub(crate) fn walk<'a>(
    all: &mut Environments<Walk>,
    seconds: f64,
    numbers: impl Fn(usize) -> &'a [f64],
    mut seen: impl FnMut(f64, &State),
) -> Vec<Outcome> {
    let mut next = all.transitions();
    all.reset(&mut next.observations);
    let nobody = Outcome {
        points: 0.0,
        way: 0.0,
        fell: false,
    };
    let mut out = vec![nobody; next.rewards.len()];
    let mut actions = vec![0.0; out.len() * ACTIONS];
    let action_time = TIME_STEP * DECIMATION as f64;
    for step in 0..(seconds / action_time).round() as usize {
        seen(step as f64 * action_time, &all.states().state(0));
        let rows = next.observations.chunks_exact(OBSERVED);
        for (i, (action, observed)) in actions.chunks_exact_mut(ACTIONS).zip(rows).enumerate() {
            policy::act(numbers(i), observed, action);
        }
        all.step(&actions, &mut next);
        for (i, own) in out.iter_mut().enumerate().filter(|(_, own)| !own.fell) {
            own.fell = next.terminated[i];
            own.points += next.rewards[i];
        }
    }
    let ways = all.states().to_vec();
    out.iter_mut()
        .zip(ways)
        .for_each(|(own, state)| own.way = state.q[0]);
    out
}
