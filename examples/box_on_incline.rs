//! A box on an incline sticks if its slope is below the coefficient of friction, and slides with g (sin α − μ cos α) if
//! not.
//!
//! `cargo run --release --example box_on_incline` – writes `out/box_on_incline/rollout.csv` of the sliding box, and a
//! page with both.

use std::error::Error;
use std::fs::File;

use dualbody::contact::{ContactLaw, Contacts, SoftContact, Terrain};
use dualbody::model::Geometry;
use dualbody::sim::Rollout;
use dualbody::spatial::{Quaternion, Transform};
use dualbody::view::Recording;
use dualbody::{Integrator, Model, Simulator};
use nalgebra::Vector3;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/box.urdf");
const ANGLE: f64 = 0.4;
const HALF_HEIGHT: f64 = 0.06;
const DEPTH: f64 = 1e-3;
const STEPS: usize = 1000;
const RAMP_COLOR: [f64; 4] = [0.5, 0.55, 0.6, 1.0];

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    println!("tan α = {:.3}", ANGLE.tan());
    let sticking = slide(&model, 0.5)?;
    let sliding = slide(&model, 0.3)?;

    let travelled = |rollout: &Rollout| {
        let q = |k: usize| rollout.states[k].q.fixed_rows::<3>(0).into_owned();
        (q(STEPS) - q(0)).norm()
    };
    let expected = 0.5 * 9.81 * (ANGLE.sin() - 0.3 * ANGLE.cos()); // ½ a t², after a second
    println!(
        "μ = 0.5: the box moves by {:.1e} m in a second",
        travelled(&sticking)
    );
    println!(
        "μ = 0.3: it slides {:.4} m, g (sin α − μ cos α) / 2 = {expected:.4} m",
        travelled(&sliding)
    );
    assert!(travelled(&sticking) < 1e-3);
    assert!((travelled(&sliding) - expected).abs() < 2e-2 * expected);

    std::fs::create_dir_all("out/box_on_incline")?;
    sliding.write_csv(&model, File::create("out/box_on_incline/rollout.csv")?)?;
    let mut recording = Recording::of_robots(&[&model, &model]).with_title("box on incline");
    for (k, (a, b)) in sticking.states.iter().zip(&sliding.states).enumerate() {
        recording.push_all(k as f64 * 1e-3, &[(a, &[]), (b, &[])]);
    }
    draw_ramp(&mut recording);
    for (i, aside) in [(0, 0.3), (1, -0.3)] {
        recording
            .robot_mut(i)
            .place(Transform::from_translation(Vector3::y() * aside));
    }
    Ok(recording.save_html("out/box_on_incline/index.html")?)
}

/// A second on the incline, from rest.
fn slide(model: &Model, friction: f64) -> Result<Rollout, Box<dyn Error>> {
    let law = SoftContact {
        friction,
        ..SoftContact::estimate(model.total_mass(), 4, DEPTH)
    };
    let contacts = Contacts::new(model, Terrain::incline(ANGLE), ContactLaw::Soft(law));
    let simulator = Simulator::new(model.clone())
        .with_contacts(contacts)
        .with_integrator(Integrator::ImplicitVelocity)
        .with_time_step(1e-3);
    let height = HALF_HEIGHT - DEPTH;
    let (sin, cos) = (0.5 * ANGLE).sin_cos();
    let q = [
        -ANGLE.sin() * height,
        0.0,
        ANGLE.cos() * height,
        cos,
        0.0,
        -sin,
        0.0,
    ];
    Ok(simulator.rollout(&simulator.state(&q, &[0.0; 6]), STEPS, |_, _, _| {}))
}

/// Draws the ground as the page shows it.
fn draw_ramp(recording: &mut Recording) {
    let turn = Quaternion::exp(&Vector3::new(0.0, -ANGLE, 0.0)).to_matrix();
    let place = Transform::new(turn, turn * Vector3::new(-0.4, 0.0, -0.01));
    let size = [1.6, 1.2, 0.02];
    recording.add_shape("incline", Geometry::Box { size }, place, RAMP_COLOR);
}
