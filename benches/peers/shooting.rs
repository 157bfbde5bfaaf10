//! Our side of the comparison of identification through the simulator with `MuJoCo`'s toolbox; `shooting.py` runs it.
//!
//! ```sh
//! shooting mjcf              # the nominal robot
//! shooting fit LOG SAMPLES   # each row of LOG: q, v, u; shots of so many samples
//! ```
//!
//! A UR5 of which damping and armature of each joint and the inertia of the forearm are unknown.

#[path = "../common/mod.rs"]
mod common;

use std::time::Instant;

use common::clock::{arguments, is_test};
use dualbody::identify::{Adjustable, Dataset, Segment, ShootingOptions, shoot};
use dualbody::{Model, Simulator, State};
use nalgebra::{DMatrix, DVector};

const LINK: &str = "forearm_link";
const TIME_STEP: f64 = 1e-3;
/// Of the nominal robot, N·m·s/rad and kg·m².
const DAMPING: f64 = 1.0;
const ARMATURE: f64 = 0.1;
/// Standard deviations of the errors of the log, rad and rad/s.
const DEVIATIONS: [f64; 2] = [1e-4, 1e-3];

fn main() {
    let arguments = arguments();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        [] if is_test() => fit(&moving(), 10),
        ["mjcf"] => println!("{}", nominal().to_mjcf().expect("a robot for MuJoCo")),
        ["fit", file, samples] => fit(&read(file), samples.parse().expect("a number")),
        _ => println!("usage: see benches/peers/shooting.py"),
    }
}

fn nominal() -> Model {
    let path = format!("{}/../assets/ur5.urdf", env!("CARGO_MANIFEST_DIR"));
    let model = Model::from_urdf_file(path).expect("a robot of assets/");
    (0..model.nv()).fold(model, |model, v| {
        model.with_damping(v, DAMPING).with_armature(v, ARMATURE)
    })
}

/// A log without errors, of the nominal robot under sines.
fn moving() -> Vec<Vec<f64>> {
    let simulator = Simulator::new(nominal()).with_time_step(TIME_STEP);
    let start = State::neutral(simulator.model());
    let rollout = simulator.rollout(&start, 21, |time, _, u| {
        u.iter_mut()
            .enumerate()
            .for_each(|(k, u)| *u = 20.0 * (9.0 * time + k as f64).sin());
    });
    let rows = rollout.states.iter().zip(&rollout.inputs);
    let row = |(state, u): (&State, &DVector<f64>)| {
        let numbers = state.q.iter().chain(&state.v).chain(u);
        numbers.copied().collect()
    };
    rows.map(row).collect()
}

fn read(file: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(file).expect("a log");
    let row = |line: &str| {
        let numbers = line.split_whitespace();
        numbers.map(|x| x.parse().expect("a number")).collect()
    };
    text.lines().map(row).collect()
}

fn fit(rows: &[Vec<f64>], samples: usize) {
    let simulator = Simulator::new(nominal()).with_time_step(TIME_STEP);
    let nv = simulator.model().nv();
    let columns = |first: usize| DMatrix::from_fn(nv, rows.len(), |i, k| rows[k][first + i]);
    let data = Dataset::new(vec![Segment {
        experiment: "log".into(),
        start: 0.0,
        rate: TIME_STEP.recip(),
        q: columns(0),
        v: columns(nv),
        a: DMatrix::zeros(nv, rows.len()),
        tau: columns(2 * nv),
    }]);
    let names = simulator.model().joint_names();
    let of = |what: &'static str| {
        names
            .iter()
            .map(move |name| Adjustable::Parameter(format!("{name}: {what}")))
    };
    let mut adjustable: Vec<_> = of("damping").chain(of("armature")).collect();
    adjustable.push(Adjustable::Inertia(LINK.into()));
    let options = ShootingOptions {
        samples,
        position_deviation: DEVIATIONS[0],
        velocity_deviation: DEVIATIONS[1],
        ..Default::default()
    };
    let start = Instant::now();
    let found = shoot(&simulator, &data, &adjustable, 0.95, &options).expect("a log of this robot");
    let seconds = start.elapsed().as_secs_f64();
    println!("{seconds} {} {}", found.deviation, found.iterations);
    let values: Vec<String> = found.values.iter().map(f64::to_string).collect();
    println!("{}", values.join(" "));
}
