//! A linear policy keeps a pole on a cart upright. The cross-entropy method learns it in less than a second: it simulates many candidates at once, and
//! draws the next candidates around the best ones.
//!
//! `cargo run --release --example cartpole_learned`

use dualbody::model::samples;
use dualbody::sim::{BATCH_WIDTH, BatchScalar, BatchSimulator, Environment, Environments, Episode};
use dualbody::{Simulator, State};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{Rng, RngExt, SeedableRng};

/// A cart within 2.4 m and a pole within 12°: one point for each step in which they are.
struct Upright;

impl Environment for Upright {
    fn n_actions(&self) -> usize {
        1
    }

    fn n_observations(&self) -> usize {
        4
    }

    fn start(&self, rng: &mut dyn Rng, state: &mut State, _: &mut [f64]) {
        state
            .numbers_mut()
            .for_each(|x| *x = rng.random_range(-0.05..0.05));
    }

    fn observe(&self, now: &Episode<'_>, out: &mut [BatchScalar]) {
        out.iter_mut()
            .zip(now.state.numbers())
            .for_each(|(out, x)| *out = *x);
    }

    fn is_over(&self, now: &Episode<'_>) -> [bool; BATCH_WIDTH] {
        let (cart, pole) = (now.state.q[0], now.state.q[1]);
        std::array::from_fn(|lane| cart.0[lane].abs() > 2.4 || pole.0[lane].abs() > 0.21)
    }
}

const CANDIDATES: usize = 256;
const BEST: usize = 24;
const STEPS: usize = 500;

/// Points of each gain in an episode.
fn points(all: &mut Environments<Upright>, gains: &[[f64; 4]]) -> Vec<usize> {
    let mut next = all.transitions();
    all.reset(&mut next.observations);
    let (mut points, mut runs) = (vec![0; gains.len()], vec![true; gains.len()]);
    for _ in 0..STEPS {
        let rows = gains.iter().zip(next.observations.chunks_exact(4));
        let force = rows.map(|(k, x)| k.iter().zip(x).map(|(k, x)| k * x).sum::<f64>());
        let forces: Vec<f64> = force.map(|force| force.clamp(-10.0, 10.0)).collect();
        all.step(&forces, &mut next);
        for (i, over) in next.terminated.iter().enumerate() {
            runs[i] &= !over;
            points[i] += usize::from(runs[i]);
        }
    }
    points
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let simulator = Simulator::new(samples::cartpole()).with_time_step(0.02);
    let simulator = simulator.with_actuated_joints(&["linear"])?;
    let batch = BatchSimulator::new(simulator, CANDIDATES);
    let mut all = Environments::new(Upright, batch, 1);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    let (mut mean, mut spread) = ([0.0; 4], [15.0; 4]);
    for generation in 0..30 {
        let mut draw = |j: usize| mean[j] + spread[j] * rng.random_range(-1.7..1.7);
        let mut gains = [[0.0; 4]; CANDIDATES];
        gains.fill_with(|| std::array::from_fn(&mut draw));
        let mut order: Vec<_> = points(&mut all, &gains).into_iter().zip(gains).collect();
        order.sort_by_key(|(points, _)| std::cmp::Reverse(*points));
        let average = |f: &dyn Fn([f64; 4]) -> f64| {
            order[..BEST]
                .iter()
                .map(|(_, gains)| f(*gains))
                .sum::<f64>()
                / BEST as f64
        };
        mean = std::array::from_fn(|j| average(&|gains| gains[j]));
        let variance = |j: usize| average(&|gains| (gains[j] - mean[j]).powi(2));
        spread = std::array::from_fn(|j| variance(j).sqrt() + 0.1);
        println!(
            "generation {generation}: the best reach {} steps",
            order[BEST - 1].0
        );
        if order[BEST - 1].0 == STEPS {
            break;
        }
    }
    let reached = points(&mut all, &[mean; CANDIDATES]);
    let kept = reached.iter().filter(|points| **points == STEPS).count();
    println!(
        "force = {mean:.1?} · (x, angle, speeds): {kept} of {CANDIDATES} starts are kept upright"
    );
    assert!(kept > CANDIDATES * 9 / 10);
    Ok(())
}
