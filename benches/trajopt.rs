//! Trajectory optimisation: one iteration of differential dynamic programming by robot and number of nodes,
//! `iteration/<robot>/<nodes>`, whose time should grow linearly in the nodes; whole solutions by every method,
//! `solve/<method>/<robot>`, which also prints how each ended; with the feature `transcription` also by it,
//! `transcription/<robot>/<nodes>`.

mod common;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use dualbody::model::FrameId;
use dualbody::trajopt::{
    Activation, Cost, Ddp, DdpOptions, FramePosition, InputError, Minimizer, Problem, Robot,
    ShootingOptions, SingleShooting, StateError, Status, Trajectory,
};
use dualbody::{Model, Simulator, State};

const ROBOTS: [&str; 5] = ["cartpole", "acrobot", "panda", "quadruped", "humanoid"];
const NODES: [usize; 3] = [50, 100, 200];

/// The last frame to a point, state and input small.
fn problem(model: Model, nodes: usize) -> Problem {
    let frame = FrameId(model.frames().len() - 1);
    let simulator = Simulator::new(model).with_time_step(0.01);
    let start = simulator.pack(&State::neutral(simulator.model()));
    let target = || FramePosition::new(frame, [0.4, 0.3, 0.5]);
    let running = Cost::new()
        .with(1.0, Activation::Quadratic, target())
        .with(
            1e-2,
            Activation::Quadratic,
            StateError::to(start.as_slice()),
        )
        .with(1e-2, Activation::Quadratic, InputError::to_zero(&simulator));
    Problem::new(simulator, nodes, start.as_slice())
        .with_stage_cost(running)
        .with_final_cost(Cost::new().with(10.0, Activation::Quadratic, target()))
}

fn iteration(c: &mut Criterion) {
    let mut group = c.benchmark_group("iteration");
    group.throughput(Throughput::Elements(1));
    for robot in ROBOTS {
        for nodes in NODES {
            let problem = problem(common::robots::asset(robot), nodes);
            let options = DdpOptions {
                max_iterations: 1,
                ..DdpOptions::default()
            };
            let mut ddp = Ddp::with_options(&problem, options);
            let guess = Trajectory::zero_input(&problem);
            group.bench_function(BenchmarkId::new(robot, nodes), |b| {
                b.iter(|| black_box(ddp.solve(&problem, &guess).cost));
            });
        }
    }
}

/// Every joint some way from rest to rest in 1 s, with the least effort.
#[cfg(feature = "transcription")]
fn bench_transcription(c: &mut Criterion) {
    use dualbody::trajopt::{Constraint, Transcription};

    /// How far each joint goes, rad or m.
    const FAR: f64 = 0.5;
    let mut group = c.benchmark_group("transcription");
    for (robot, nodes) in [("cartpole", 20), ("cartpole", 40)] {
        let simulator = Simulator::new(common::robots::asset(robot));
        let simulator = simulator.with_time_step(1.0 / nodes as f64);
        let start = simulator.pack(&State::neutral(simulator.model()));
        let mut goal = start.clone();
        goal.rows_mut(0, simulator.model().nq()).add_scalar_mut(FAR);
        let effort = Cost::new().with(1e-2, Activation::Quadratic, InputError::to_zero(&simulator));
        let arrive = Constraint::equal_to_zero(&simulator, StateError::to(goal.as_slice()));
        let problem = Problem::new(simulator, nodes, start.as_slice())
            .with_stage_cost(effort)
            .with_final_constraint(arrive);
        let (solver, guess) = (Transcription::new(), Trajectory::zero_input(&problem));
        assert!(solver.solve(&problem, &guess).is_converged());
        group.bench_function(BenchmarkId::new(robot, nodes), |b| {
            b.iter(|| black_box(solver.solve(&problem, &guess).cost));
        });
    }
}

#[cfg(not(feature = "transcription"))]
fn bench_transcription(_: &mut Criterion) {}

/// Robots whose reach every method solves.
const SOLVED: [&str; 2] = ["acrobot", "panda"];
/// Nodes of that reach.
const HORIZON: usize = 50;
/// Solutions that are timed, of which the slowest methods need seconds.
const SAMPLES: usize = 10;

fn solve(c: &mut Criterion) {
    let mut group = c.benchmark_group("solve");
    group.sample_size(SAMPLES);
    for robot in SOLVED {
        let problem = problem(common::robots::asset(robot), HORIZON);
        let guess = Trajectory::zero_input(&problem);
        let mut ddp = Ddp::new(&problem);
        let found = ddp.solve(&problem, &guess);
        print("Ddp", robot, (found.status, found.iterations, found.cost));
        group.bench_function(BenchmarkId::new("Ddp", robot), |b| {
            b.iter(|| black_box(ddp.solve(&problem, &guess).cost));
        });
        for minimizer in Minimizer::ALL {
            let name = format!("{minimizer:?}");
            let mut shooting = SingleShooting::with_options(&problem, ShootingOptions::default());
            let found = shooting.solve(&guess, minimizer);
            print(&name, robot, (found.status, found.iterations, found.cost));
            group.bench_function(BenchmarkId::new(name, robot), |b| {
                b.iter(|| black_box(shooting.solve(&guess, minimizer).cost));
            });
        }
    }
}

fn print(method: &str, robot: &str, (status, iterations, cost): (Status, usize, f64)) {
    println!("{method} on {robot}: {status}, {iterations} iterations, cost {cost:.9}");
}

criterion_group! {
    name = benches;
    config = common::criterion();
    targets = iteration, bench_transcription, solve
}
criterion_main!(benches);
