//! Steps a second of batches: `batch_rollout/<robot>`, trajectories written down, into memory that is used again, on two threads;
//! `batch_steps/<precision>/<robot>`, states alone, on one.
//!
//! The robots are also written to `target/tmp/<robot>.xml`, so that `benches/peers/rollout.py` can measure `MuJoCo` on them.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use dualbody::sim::{BatchSimulator, RolloutStatus, SingleBatch};
use dualbody::{Model, Simulator, State};

const THREADS: usize = 2;
const STATES: usize = 1024;
const STEPS: usize = 100;

fn robots() -> Vec<(&'static str, Model)> {
    let load = |name: &'static str| {
        let file = format!("{}/../assets/{name}.urdf", env!("CARGO_MANIFEST_DIR"));
        (name, Model::from_urdf_file(file).expect("an asset"))
    };
    ["cartpole", "ur5", "humanoid"].map(load).to_vec()
}

/// All coordinates of the k-th start a little off the neutral configuration.
fn start(model: &Model, k: usize) -> State {
    let small = |j: usize| 0.2 * ((1 + k * (2 * j + 3)) as f64).sin();
    let dv: Vec<f64> = (0..model.nv()).map(small).collect();
    let q = model.integrate(model.neutral().as_slice(), &dv);
    State::new(q.as_slice(), &vec![0.0; model.nv()])
}

fn bench(c: &mut Criterion) {
    let mut group = c.benchmark_group("batch_rollout");
    group.throughput(Throughput::Elements((STATES * STEPS) as u64));
    for (robot, model) in robots() {
        let file = format!("{}/{robot}.xml", env!("CARGO_TARGET_TMPDIR"));
        let xml = model.to_mjcf().expect("a robot that MJCF can hold");
        std::fs::write(file, xml).expect("a folder to write to");
        let starts: Vec<State> = (0..STATES).map(|k| start(&model, k)).collect();
        let simulator = Simulator::new(model).with_time_step(1e-3);
        let mut batch = BatchSimulator::new(simulator, STATES).with_threads(THREADS);
        let mut rollout = batch.rollout(&starts, STEPS, |_, _, _| {});
        assert!((0..STATES).all(|i| rollout.status(i) == RolloutStatus::Completed));
        group.bench_function(robot, |b| {
            b.iter(|| batch.rollout_into(&starts, STEPS, |_, _, _| {}, &mut rollout));
        });
    }
}

/// Steps of an arm in single precision beside those in double.
fn bench_precisions(c: &mut Criterion) {
    let mut group = c.benchmark_group("batch_steps");
    group.throughput(Throughput::Elements((STATES * STEPS) as u64));
    let arm = robots().into_iter().find(|(robot, _)| *robot == "ur5");
    let (_, model) = arm.expect("one of the robots");
    let starts: Vec<State> = (0..STATES).map(|k| start(&model, k)).collect();
    let simulator = Simulator::new(model).with_time_step(1e-3);
    let inputs = vec![0.0; simulator.nu() * STATES];
    let mut double = BatchSimulator::new(simulator.clone(), STATES).with_threads(1);
    group.bench_function("double/ur5", |b| {
        b.iter(|| {
            let mut states = double.states(&starts);
            (0..STEPS).for_each(|_| double.step(&mut states, &inputs));
        });
    });
    let mut single = SingleBatch::new(simulator, &starts).with_threads(1);
    group.bench_function("single/ur5", |b| {
        b.iter(|| {
            (0..STATES).for_each(|i| single.set(i, &starts[i]));
            (0..STEPS).for_each(|_| single.step(&inputs));
        });
    });
}

criterion_group!(benches, bench, bench_precisions);
criterion_main!(benches);
