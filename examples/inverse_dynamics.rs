//! Inverse dynamics of a 7-joint arm: the torques of a given motion, and a simulation that reproduces the motion with them.
//!
//! `cargo run --release --example inverse_dynamics` – writes a page of the movement to `out/inverse_dynamics/`.

use std::error::Error;

use dualbody::dynamics::{
    bias_forces, forward_dynamics, frame_pose, gravity_forces, inverse_dynamics, mass_matrix,
};
use dualbody::model::samples;
use dualbody::view::Recording;
use dualbody::{Model, State};

const OUT: &str = "out/inverse_dynamics/index.html";

fn main() -> Result<(), Box<dyn Error>> {
    let model = samples::arm();
    let q = [0.3, 0.6, -0.2, 1.1, 0.4, -0.7, 0.2];
    let v = [0.5, -0.4, 0.3, 0.8, -0.2, 0.6, -0.1];
    let a = [1.0, 0.5, -0.5, 2.0, 0.3, -1.0, 0.7];

    let tool = model.frame("tool").expect("the arm has a tool frame");
    println!("tool at{:.4}", frame_pose(&model, &q, tool).translation);

    let tau = inverse_dynamics(&model, &q, &v, &a);
    let (inertia, bias, gravity) = (
        mass_matrix(&model, &q),
        bias_forces(&model, &q, &v),
        gravity_forces(&model, &q),
    );
    println!(
        "{:<8} {:>10} {:>10} {:>10} {:>10}",
        "joint", "τ / N·m", "M a", "velocity", "gravity"
    );
    let needed = &inertia * nalgebra::DVector::from_column_slice(&a);
    for (k, name) in model.joint_names().into_iter().enumerate() {
        println!(
            "{name:<8} {:>10.4} {:>10.4} {:>10.4} {:>10.4}",
            tau[k],
            needed[k],
            bias[k] - gravity[k],
            gravity[k]
        );
    }
    let parts = needed + bias;
    assert!((&tau - parts).amax() < 1e-12, "τ = M a + h");

    let back = forward_dynamics(&model, &q, &v, tau.as_slice());
    let error = back
        .iter()
        .zip(&a)
        .fold(0.0_f64, |max, (x, y)| max.max((x - y).abs()));
    println!("\nforward dynamics gives the accelerations back within {error:.1e}");
    assert!(error < 1e-9);
    save(&model, &q, &v, &a)
}

/// Writes a page of the arm over two seconds of the movement with these accelerations, with the torques that it needs.
fn save(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> Result<(), Box<dyn Error>> {
    const STEP: f64 = 0.01;
    let mut recording = Recording::new(model);
    for k in -100..=100 {
        let t = STEP * f64::from(k);
        let along = |i: usize| q[i] + v[i] * t + 0.5 * a[i] * t * t;
        let q: Vec<f64> = (0..q.len()).map(along).collect();
        let v: Vec<f64> = v.iter().zip(a).map(|(v, a)| v + a * t).collect();
        let tau = inverse_dynamics(model, &q, &v, a);
        recording.push(t, &State::new(&q, &v), tau.as_slice());
    }
    recording.robot_mut(0).trace("tool")?.show_frame("tool")?;
    Ok(recording.save_html(OUT)?)
}
