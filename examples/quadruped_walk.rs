//! A quadruped with position servos walks by a trained policy, under pushes, with masses and friction that differ from their nominal values.
//!
//! `cargo run --release --example quadruped_walk` – 100 robots walk for 10 s; writes the first one to `out/quadruped_walk/index.html`. With `-- train` after it, the
//! policy is trained first, and written to `examples/quadruped_walk/policy.txt`.

#[path = "quadruped_walk/leg.rs"]
mod leg;
#[path = "quadruped_walk/policy.rs"]
mod policy;
#[path = "common/quadruped.rs"]
mod quadruped;
#[path = "quadruped_walk/task.rs"]
mod task;
#[path = "quadruped_walk/train.rs"]
mod train;
#[path = "quadruped_walk/walk.rs"]
mod walk;

use std::error::Error;
use std::time::Instant;

use dualbody::contact::Terrain;
use dualbody::view::Recording;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/quadruped_walk");
const ROBOTS: usize = 100;

fn main() -> Result<(), Box<dyn Error>> {
    let (simulator, file) = (task::robot()?, format!("{FOLDER}/policy.txt"));
    if std::env::args().nth(1).as_deref() == Some("train") {
        let began = Instant::now();
        train::train(&simulator, |text| {
            std::fs::write(&file, text).expect("a file to write to");
        });
        println!("trained in {:.0} s", began.elapsed().as_secs_f64());
    }
    let numbers = policy::of_text(&std::fs::read_to_string(&file)?);
    let seeds: Vec<u64> = (0..ROBOTS as u64).collect();
    let mut all = task::Walk::episodes(&simulator, &seeds);
    let mut recording = Recording::new(simulator.model()).with_title("quadruped walk");
    recording.show_ground(&Terrain::flat(0.0));
    let outcomes = walk::walk(
        &mut all,
        task::DURATION,
        |_| &numbers,
        |time, state| recording.push(time, state, &[]),
    );
    let mut ways: Vec<f64> = outcomes.iter().map(|own| own.way).collect();
    ways.sort_by(f64::total_cmp);
    let falls = outcomes.iter().filter(|own| own.fell).count();
    let walked = outcomes.iter().filter(|own| own.has_walked(task::DURATION));
    let walked = walked.count();
    println!(
        "{walked} of {ROBOTS} walk at 0.5 m/s or more for 10 s, {falls} fall; half of them go {:.1} m or more",
        ways[ROBOTS / 2]
    );
    assert!(walked >= 90);
    std::fs::create_dir_all("out/quadruped_walk")?;
    Ok(recording.save_html("out/quadruped_walk/index.html")?)
}
