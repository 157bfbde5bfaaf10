//! A quadruped with servos keeps standing while its trunk is pushed; the motion is written as an animated picture, without a browser.
//!
//! `cargo run --release --features render --example quadruped_pushed` – writes `out/quadruped_pushed/index.gif` and a page beside it.

#[path = "common/quadruped.rs"]
mod quadruped;

use std::error::Error;

use dualbody::sim::{Rollout, RolloutStatus};
use dualbody::view::{Camera, PictureOptions, Recording};
use dualbody::{Simulator, State};

const TIME_STEP: f64 = 2e-3;
/// Stiffness and damping of the servos, N·m/rad and N·m·s/rad.
const GAINS: [f64; 2] = [60.0, 2.0];
/// Beginning of each push, s, how long it lasts, s, and its force, N.
const PUSHES: [(f64, [f64; 3]); 3] = [
    (0.4, [0.0, 70.0, 0.0]),
    (1.4, [-80.0, 0.0, 0.0]),
    (2.4, [50.0, -60.0, 0.0]),
];
const PUSH: f64 = 0.15;
const DURATION: f64 = 3.6;

fn main() -> Result<(), Box<dyn Error>> {
    let simulator = quadruped::on_servos(GAINS, TIME_STEP)?;
    let start = settle(&simulator);
    let rollout = simulator.rollout(&start, steps(DURATION), |time, _, u| control(time, u));
    assert!(rollout.status == RolloutStatus::Completed);
    let tilt = |state: &State| 2.0 * state.q.rows(4, 2).norm().asin();
    let most = rollout.states.iter().map(tilt).fold(0.0, f64::max);
    let last = tilt(rollout.last());
    println!(
        "pushed by up to 80 N, the trunk tilts by up to {most:.2} rad, and by {last:.3} rad at the end"
    );
    assert!(most > 0.05 && last < 0.05);
    save(&simulator, &rollout)
}

/// The push at a time, N.
fn push(time: f64) -> [f64; 3] {
    let acts = PUSHES
        .iter()
        .find(|(begin, _)| (*begin..*begin + PUSH).contains(&time));
    acts.map_or([0.0; 3], |(_, force)| *force)
}

/// Targets of the servos, legs bent, and the hand.
fn control(time: f64, u: &mut [f64]) {
    for leg in 0..4 {
        u[3 * leg..3 * leg + 3].copy_from_slice(&[0.0, 0.8, -1.6]);
    }
    u[12..15].copy_from_slice(&push(time));
}

/// The robot let down on bent legs, at rest.
fn settle(simulator: &Simulator) -> State {
    let mut state: State = simulator.neutral_state();
    state.q[2] = 0.32;
    let mut u = [0.0; 18];
    control(-1.0, &mut u);
    state.q.as_mut_slice()[7..].copy_from_slice(&u[..12]);
    let settled = simulator.rollout(&state, steps(1.0), |_, _, out| out.copy_from_slice(&u));
    settled.last().clone()
}

fn save(simulator: &Simulator, rollout: &Rollout) -> Result<(), Box<dyn Error>> {
    let camera = Camera {
        look_at: [0.0, 0.0, 0.2],
        distance: 1.3,
        azimuth: 40.0,
        elevation: 14.0,
    };
    let mut recording = Recording::of_simulation(simulator, rollout)
        .with_title("quadruped pushed")
        .with_camera(camera);
    let times: Vec<f64> = recording.times().to_vec();
    let forces = times.iter().map(|&time| push(time).into());
    recording.robot_mut(0).add_force("trunk", forces)?;
    std::fs::create_dir_all("out/quadruped_pushed")?;
    recording.save_html("out/quadruped_pushed/index.html")?;
    let options = PictureOptions {
        width: 480,
        height: 300,
        ..PictureOptions::default()
    };
    Ok(recording.save_gif("out/quadruped_pushed/index.gif", options)?)
}

fn steps(seconds: f64) -> usize {
    (seconds / TIME_STEP) as usize
}
