//! One iteration of trajectory optimisation, by robot and number of nodes: `iteration/<robot>/<nodes>`; its time should grow linearly in the
//! nodes. With the feature `transcription` also whole solutions by it: `transcription/<robot>/<nodes>`.

mod common;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use dualbody::model::FrameId;
use dualbody::trajopt::{
    Activation, Cost, Ddp, DdpOptions, FramePosition, InputError, Problem, Robot, StateError,
    Trajectory,
};
use dualbody::{Model, Simulator, State};

const ROBOTS: [&str; 5] = ["cartpole", "acrobot", "panda", "quadruped", "humanoid"];
const NODES: [usize; 3] = [50, 100, 200];

/// The last frame to a point, state and input small.
fn problem(model: Model, nodes: usize) -> Problem<Simulator> {
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

fn bench(c: &mut Criterion) {
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
            let guess = Trajectory::resting(&problem);
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
        let (solver, guess) = (Transcription::new(), Trajectory::resting(&problem));
        assert!(solver.solve(&problem, &guess).is_converged());
        group.bench_function(BenchmarkId::new(robot, nodes), |b| {
            b.iter(|| black_box(solver.solve(&problem, &guess).cost));
        });
    }
}

#[cfg(not(feature = "transcription"))]
fn bench_transcription(_: &mut Criterion) {}

criterion_group! {
    name = benches;
    config = common::criterion();
    targets = bench, bench_transcription
}
criterion_main!(benches);
