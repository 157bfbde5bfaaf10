//! Identification of an arm from a noisy log, from raw channels to a physically consistent robot, with intervals; and its errors on another motion beside those of the
//! true robot.
//!
//! ```sh
//! cargo bench --features full --bench identify                       # the arm of the samples
//! cargo bench --features full --bench identify -- path/to/ur10.urdf  # any arm of one's own, such as the UR10 of example-robot-data
//! ```
//!
//! 10,000 samples at 1 kHz of a Fourier series; errors of 0.1 mrad in positions, 1 mrad/s in velocities, and of 0.3 % of the largest force of each joint. Unknown
//! are all inertial parameters, damping and dry friction; the nominal robot is a third heavier than the true one, without friction.

use std::time::Instant;

use dualbody::Model;
use dualbody::ModelOptions;
use dualbody::identify::{
    ConsistencyOptions, Dataset, DryFriction, Excitation, Experiment, Preparation, Quantity,
    Regressor, Robot, SavitzkyGolay, Unit, estimate,
};
use dualbody::model::{Base, samples};
use nalgebra::{DMatrix, DVector};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

const SAMPLES: usize = 10_000;
/// Samples a second.
const RATE: f64 = 1000.0;
/// Standard deviations of measured positions and velocities, rad and rad/s.
const POSITION_ERROR: f64 = 1e-4;
const VELOCITY_ERROR: f64 = 1e-3;
/// Standard deviation of a measured force beside the largest one.
const FORCE_ERROR: f64 = 3e-3;
const FRICTION: DryFriction = DryFriction::Smooth {
    slip_velocity: 0.05,
};

fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
    let (u, w): (f64, f64) = (
        rng.random_range(f64::EPSILON..1.0),
        rng.random_range(0.0..1.0),
    );
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * w).cos()
}

/// A motion of random phases with five harmonics of 0.1 Hz.
fn motion(n: usize, seed: u64) -> Excitation {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    Excitation {
        period: 10.0,
        center: vec![0.0; n],
        coefficients: DMatrix::from_fn(n, 10, |_, k| {
            rng.random_range(-0.6..0.6) / (1.0 + (k / 2) as f64)
        }),
        condition: f64::NAN,
        start_condition: f64::NAN,
    }
}

/// The true robot, with dampers and friction of the size of its joints.
fn truth(model: &Model) -> Robot {
    let nv = model.nv();
    let size = |k: usize| 8.0 / (1.0 + k as f64);
    let damped = (0..nv).fold(model.clone(), |model, k| model.with_damping(k, size(k)));
    Robot {
        model: damped,
        shape: Some(FRICTION),
        dry_friction: (0..nv).map(|k| 0.6 * size(k)).collect(),
        offsets: vec![0.0; nv],
    }
}

/// A log of a motion.
fn log(robot: &Robot, motion: &Excitation, seed: u64) -> Experiment {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let at = |k: usize| motion.at(k as f64 / RATE);
    let forces: Vec<DVector<f64>> = (0..SAMPLES)
        .map(|k| {
            let at = at(k);
            robot.predict(at.q.as_slice(), at.v.as_slice(), at.a.as_slice())
        })
        .collect();
    let largest = |i: usize| forces.iter().map(|tau| tau[i].abs()).fold(0.0, f64::max);
    let mut out = Experiment::at_rate(format!("motion {seed}"), RATE);
    for (i, name) in robot.model.joint_names().into_iter().enumerate() {
        let q: Vec<f64> = (0..SAMPLES)
            .map(|k| at(k).q[i] + POSITION_ERROR * normal(&mut rng))
            .collect();
        let v: Vec<f64> = (0..SAMPLES)
            .map(|k| at(k).v[i] + VELOCITY_ERROR * normal(&mut rng))
            .collect();
        let size = FORCE_ERROR * largest(i);
        let tau: Vec<f64> = (0..SAMPLES)
            .map(|k| forces[k][i] + size * normal(&mut rng))
            .collect();
        out = out
            .with_channel(name, Quantity::Position, Unit::Si, &q)
            .with_channel(name, Quantity::Velocity, Unit::Si, &v)
            .with_channel(name, Quantity::Force, Unit::Si, &tau);
    }
    out
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args()
        .skip(1)
        .find(|argument| !argument.starts_with('-'));
    let model = match path {
        Some(path) => {
            ModelOptions::default()
                .with_base(Base::Fixed)
                .load_urdf_file(path)?
                .0
        }
        None => samples::arm(),
    };
    let robot = truth(&model);
    let learn = log(&robot, &motion(model.nv(), 1), 11);
    let held = log(&robot, &motion(model.nv(), 2), 12);
    let nominal = model.scaled(1.0, 4.0 / 3.0)?;

    let preparation = Preparation::new(SavitzkyGolay::new(40, 4)?);
    let start = Instant::now();
    let learn: Dataset = preparation.prepare(&nominal, &[learn])?;
    let prepared = start.elapsed();
    let regressor = Regressor::new(&nominal)
        .with_damping()
        .with_dry_friction(FRICTION)?;
    let found = estimate(&regressor, &learn)?;
    let estimated = start.elapsed();
    let consistent = found.consistent(&ConsistencyOptions::default())?;
    let intervals = found.intervals(0.95);
    let all = start.elapsed();

    println!(
        "{}: {} unknowns, {} base parameters, condition {:.0}",
        model.name(),
        regressor.unknowns().len(),
        intervals.len(),
        found.condition
    );
    println!(
        "filters {:.1} ms, least squares {:.1} ms, consistent inertias {:.1} ms: {:.1} ms in all",
        1e3 * prepared.as_secs_f64(),
        1e3 * (estimated - prepared).as_secs_f64(),
        1e3 * (all - estimated).as_secs_f64(),
        1e3 * all.as_secs_f64()
    );
    println!(
        "bodies that cannot be: {} by least squares, {} made consistent; excess {:.1}, {} iterations",
        found.robot().model.inertia_flaws().len(),
        consistent.robot.model.inertia_flaws().len(),
        consistent.excess,
        consistent.iterations
    );
    let held = preparation.prepare(&nominal, &[held])?;
    let check = consistent.robot.validate(&held)?;
    let floor = robot.validate(&held)?;
    println!("error on another motion, beside that of the true robot on the same data, N·m:");
    for (i, (own, floor)) in check.coordinates.iter().zip(&floor.coordinates).enumerate() {
        let joint = model.joint_names()[i];
        println!(
            "  {joint:>24} {:.4} / {:.4} = {:.4}",
            own.rms,
            floor.rms,
            own.rms / floor.rms
        );
    }
    Ok(())
}
