//! Our side of the comparison with Crocoddyl: iterations, cost and time per iteration of a reach; `reach.py` runs it in turn with
//! theirs.
//!
//! ```sh
//! reach panda.urdf [SHARE]
//! ```
//!
//! SHARE bounds the inputs to this share of the efforts that the file allows.

#[path = "../common/mod.rs"]
mod common;

use std::time::Instant;

use common::clock::is_test;
use dualbody::model::Base;
use dualbody::trajopt::{
    Activation, Cost, Ddp, DdpOptions, FramePosition, InputError, Problem, StateError, Trajectory,
};
use dualbody::{ModelOptions, Simulator};

/// Solutions whose fastest counts: the first ones fill the caches.
const ROUNDS: usize = 3;
/// More than either side needs.
const ITERATIONS: usize = 2000;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().filter(|file| !file.starts_with("--"));
    let share = arguments.next().and_then(|share| share.parse().ok());
    match file {
        Some(file) => report(&file, share, ROUNDS),
        None if is_test() => {
            let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/panda.urdf");
            for share in [None, Some(1.0), Some(0.5), Some(0.3)] {
                report(file, share, 1);
            }
        }
        None => println!("usage: reach panda.urdf [SHARE]; see benches/peers/reach.py"),
    }
}

fn report(file: &str, share: Option<f64>, rounds: usize) {
    let (mut problem, limits) = reach(file);
    if let Some(share) = share {
        let upper: Vec<f64> = limits.iter().map(|limit| share * limit).collect();
        let lower: Vec<f64> = upper.iter().map(|limit| -limit).collect();
        problem = problem.with_input_bounds(&lower, &upper);
    }
    let guess = Trajectory::zero_input(&problem);
    let options = DdpOptions {
        max_iterations: ITERATIONS,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(&problem, options);
    let mut fastest = f64::INFINITY;
    for _ in 0..rounds {
        let start = Instant::now();
        let solution = ddp.solve(&problem, &guess);
        let seconds = start.elapsed().as_secs_f64();
        fastest = fastest.min(seconds / solution.iterations as f64);
    }
    let solution = ddp.solution();
    assert!(solution.is_converged(), "{}", solution.status);
    println!("iterations {}", solution.iterations);
    println!("cost {:.9}", solution.cost);
    println!("ms_per_iteration {:.6}", fastest * 1e3);
}

/// The problem, and the largest efforts of the joints, N·m.
fn reach(file: &str) -> (Problem, Vec<f64>) {
    let options = ModelOptions::default()
        .with_base(Base::Fixed)
        .with_independent_mimic_joints();
    let (model, _) = options
        .load_urdf_file(file)
        .unwrap_or_else(|error| panic!("{error}"));
    // Crocoddyl's free dynamics have no damping.
    let model = (0..model.nv()).fold(model, |model, k| model.with_damping(k, 0.0));
    let hand = model.frame("panda_hand").expect("a hand");
    let simulator = Simulator::new(model).with_time_step(0.01);
    let target = FramePosition::new(hand, [0.4, 0.3, 0.5]);
    let quadratic = || Activation::Quadratic;
    let running = Cost::new()
        .with(1.0, quadratic(), target.clone())
        .with(1e-4, quadratic(), StateError::to_neutral(&simulator))
        .with(1e-4, quadratic(), InputError::to_zero(&simulator));
    let last = Cost::new().with(1e3, quadratic(), target);
    let start = vec![0.0; 2 * simulator.model().nv()];
    let (_, limits) = simulator.effort_bounds();
    let problem = Problem::new(simulator, 100, &start)
        .with_stage_cost(running)
        .with_final_cost(last);
    (problem, limits)
}
