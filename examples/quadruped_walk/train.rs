//! Training by augmented random search (Mania, Guy, Recht, "Simple random search of static policies is competitive for reinforcement learning", 2018): the policy goes along
//! random directions in proportion to the gain by each.

use dualbody::Simulator;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use super::policy::{KNOWN, NUMBERS};
use super::task::Walk;
use super::walk::{Outcome, walk};

/// Seed of the directions; the seeds of episodes of the training begin here too, and those of the test are others.
const SEED: u64 = 1_000_000;
/// Directions of an iteration, episodes of each of its two policies, how many of the best directions count, iterations.
const DIRECTIONS: usize = 8;
const EPISODES: usize = 4;
const BEST: usize = 4;
const ITERATIONS: usize = 6;
/// Length of an episode of the training, s.
const TRAINED: f64 = 6.0;
/// Size of a step in directions, which change stride, lift, and the offset of a foot for each thing that is known by about so much, m.
const STEP: f64 = 0.5;
const CHANGES: [f64; 3] = [0.004, 0.002, 0.004];
/// Sizes of the observations.
const SIZES: [f64; KNOWN] = [1.0, 0.15, 0.15, 1.0, 1.0, 1.0, 0.3, 0.3, 0.3];

/// The first guess: a trot that puts its feet down ahead of a trunk that is too fast or moves sideways. Strides are shorter on the side to which it turns.
fn first_guess() -> Vec<f64> {
    let mut out = vec![0.0; NUMBERS];
    (out[0], out[1]) = (0.185, 0.07);
    for leg in 0..2 {
        // Numbers of a row: 5 is the turning speed, 6 the speed along x, 7 that along y, 8 the direction.
        let [ground, air] = [0, 2].map(|half| 2 + 3 * KNOWN * (half + leg));
        (out[air + 6], out[air + KNOWN + 7]) = (0.03, 0.1);
        (out[ground + 5], out[ground + 8]) = (0.02, 0.08);
        (out[air + 5], out[air + 8]) = (-0.02, -0.08);
    }
    out
}

/// Trains a policy, and prints its progress.
///
/// * `keep` – is handed the policy after each iteration, as text
pub(crate) fn train(simulator: &Simulator, mut keep: impl FnMut(String)) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(SEED);
    let mut mean = first_guess();
    for iteration in 0..ITERATIONS {
        let directions: Vec<Vec<f64>> = (0..DIRECTIONS).map(|_| direction(&mut rng)).collect();
        let outcomes = outcomes(simulator, iteration, &mean, &directions);
        let points = outcomes
            .chunks(EPISODES)
            .map(average_points)
            .collect::<Vec<f64>>();
        climb(&mut mean, &directions, &points);
        keep(to_text(&mean));
        let falls = outcomes.iter().filter(|own| own.fell).count();
        let average = average_points(&outcomes);
        println!(
            "{iteration}: {average:.1} points, {falls} of {} fall",
            outcomes.len()
        );
    }
}

/// How episodes go forward and backward along each direction, on the same robots under the same pushes.
fn outcomes(
    simulator: &Simulator,
    iteration: usize,
    mean: &[f64],
    directions: &[Vec<f64>],
) -> Vec<Outcome> {
    let both = |direction: &Vec<f64>| [1.0, -1.0].map(|by| moved(mean, by, direction));
    let candidates: Vec<Vec<f64>> = directions.iter().flat_map(both).collect();
    let first = SEED + (iteration * EPISODES) as u64;
    let seed = |i: usize| first + (i % EPISODES) as u64;
    let seeds: Vec<u64> = (0..candidates.len() * EPISODES).map(seed).collect();
    let mut all = Walk::episodes(simulator, &seeds);
    walk(&mut all, TRAINED, |i| &candidates[i / EPISODES], |_, _| {})
}

fn average_points(all: &[Outcome]) -> f64 {
    all.iter().map(|own| own.points).sum::<f64>() / all.len() as f64
}

fn direction(rng: &mut Xoshiro256PlusPlus) -> Vec<f64> {
    let mut normal = || {
        let [a, b]: [f64; 2] = [
            rng.random_range(f64::MIN_POSITIVE..1.0),
            rng.random_range(0.0..1.0),
        ];
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    };
    let change = |j: usize| match j {
        0 | 1 => CHANGES[j],
        _ => CHANGES[2] / SIZES[(j - 2) % KNOWN],
    };
    (0..NUMBERS).map(|j| change(j) * normal()).collect()
}

fn moved(mean: &[f64], by: f64, direction: &[f64]) -> Vec<f64> {
    mean.iter()
        .zip(direction)
        .map(|(x, d)| x + by * d)
        .collect()
}

/// Goes along the best directions.
fn climb(mean: &mut Vec<f64>, directions: &[Vec<f64>], points: &[f64]) {
    let mut order: Vec<usize> = (0..directions.len()).collect();
    let best = |k: &usize| points[2 * k].max(points[2 * k + 1]);
    order.sort_by(|a, b| best(b).total_cmp(&best(a)));
    order.truncate(BEST);
    let used: Vec<f64> = order
        .iter()
        .flat_map(|k| [points[2 * k], points[2 * k + 1]])
        .collect();
    let average = used.iter().sum::<f64>() / used.len() as f64;
    let variance = used.iter().map(|x| (x - average).powi(2)).sum::<f64>() / used.len() as f64;
    let scale = STEP / (BEST as f64 * variance.sqrt().max(1e-9));
    for k in order {
        *mean = moved(
            mean,
            scale * (points[2 * k] - points[2 * k + 1]),
            &directions[k],
        );
    }
}

/// A policy as text, as [`policy::of_text`] reads it: stride and lift, then a line for each row.
fn to_text(numbers: &[f64]) -> String {
    let (gait, rows) = numbers.split_at(2);
    let line = |row: &[f64]| {
        let words: Vec<String> = row.iter().map(|x| format!("{x:.4}")).collect();
        words.join(" ") + "\n"
    };
    line(gait) + &rows.chunks_exact(KNOWN).map(line).collect::<String>()
}
