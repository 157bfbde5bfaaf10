//! The quantities of `table.py` in Rust, which runs this program: lines of a name and nanoseconds.
//!
//! `cargo build --release --example rust`

use std::hint::black_box;
use std::time::Instant;

use dualbody::dynamics::{
    AbaScratch, CrbaScratch, RneaScratch, forward_dynamics_into, inverse_dynamics_into,
    mass_matrix_into,
};
use dualbody::linearize::LinearizeScratch;
use dualbody::sim::{BatchSimulator, StepScratch};
use dualbody::{Base, Linearization, Model, ModelOptions, Simulator, State};
use nalgebra::DMatrix;

const ASSETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/");
/// Runs of which the shortest counts, of so few calls that nothing else comes between.
const RUNS: usize = 2000;
/// Runs of a batch.
const BATCHES: usize = 150;

/// Prints the least time of a call, ns.
fn least(name: &str, number: usize, mut call: impl FnMut()) {
    let run = |_| {
        let begin = Instant::now();
        (0..number).for_each(|_| call());
        begin.elapsed().as_secs_f64() / number as f64
    };
    let best = (0..RUNS).map(run).fold(f64::INFINITY, f64::min);
    println!("{name} {:.2}", best * 1e9);
}

fn dynamics(model: &Model) {
    let n = model.nv();
    let x: Vec<Vec<f64>> = (0..3)
        .map(|k| (0..n).map(|i| ((3 * i + k) as f64).sin()).collect())
        .collect();
    let mut out = vec![0.0; n];
    let mut rnea = RneaScratch::new(model);
    least("rnea", 100, || {
        let [q, v, a] = [&x[0], &x[1], &x[2]].map(black_box);
        inverse_dynamics_into(model, q, v, a, &[], &mut rnea, &mut out);
        black_box(&mut out);
    });
    let mut aba = AbaScratch::new(model);
    least("aba", 100, || {
        let [q, v, a] = [&x[0], &x[1], &x[2]].map(black_box);
        forward_dynamics_into(model, q, v, a, &[], &mut aba, &mut out);
        black_box(&mut out);
    });
    let (mut crba, mut matrix) = (CrbaScratch::new(model), DMatrix::zeros(n, n));
    least("crba", 100, || {
        mass_matrix_into(model, black_box(&x[0]), &mut crba, &mut matrix);
        black_box(&mut matrix);
    });
}

fn cartpole(simulator: &Simulator) {
    let state = State::new(&[0.1, 0.2], &[0.3, 0.4]);
    let (mut next, u) = (state.clone(), [0.0, 0.0]);
    let mut scratch = StepScratch::new(simulator);
    least("step", 100, || {
        simulator.step_into(black_box(&state), &u, &mut scratch, &mut next);
        black_box(&mut next);
    });
    let mut scratch = LinearizeScratch::new(simulator);
    let mut linear = Linearization::zeros(simulator);
    least("linearize", 100, || {
        simulator.linearize_into(black_box(&state), &u, &mut scratch, &mut linear);
        black_box(&mut linear);
    });
}

fn batch(simulator: &Simulator) {
    let (n, steps) = (1024, 100);
    let start = |i: usize| State::new(&[(i as f64).sin(), (2.0 * i as f64).sin()], &[0.0; 2]);
    let starts: Vec<State> = (0..n).map(start).collect();
    let inputs: Vec<f64> = (0..n * steps * 2).map(|k| (k as f64).sin()).collect();
    let mut batch = BatchSimulator::new(simulator.clone(), n);
    let runs = |run: &mut dyn FnMut()| {
        let one = |_| {
            let begin = Instant::now();
            run();
            begin.elapsed().as_secs_f64()
        };
        (0..BATCHES).map(one).fold(f64::INFINITY, f64::min) * 1e9 / (n * steps) as f64
    };
    let time = runs(&mut || drop(black_box(batch.rollout(&starts, steps, |_, _, _| {}))));
    println!("rollout {time:.2}");
    let time = runs(&mut || drop(black_box(batch.rollout_inputs(&starts, steps, &inputs))));
    println!("rollout_of_inputs {time:.2}");
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let options = ModelOptions::default()
        .with_base(Base::Fixed)
        .with_independent_mimic_joints();
    dynamics(&options.load_urdf_file(format!("{ASSETS}panda.urdf"))?.0);
    let cartpole_model = Model::from_urdf_file(format!("{ASSETS}cartpole.urdf"))?;
    let simulator = Simulator::new(cartpole_model).with_time_step(0.01);
    cartpole(&simulator);
    batch(&simulator);
    Ok(())
}
