//! A row of dominoes: the first one is pushed, each one pushes over the next, and the wave has constant speed.
//!
//! `cargo run --release --example dominoes` – writes `out/dominoes/index.html`, a page that opens in any browser.

use std::error::Error;

use dualbody::contact::{CollisionOptions, ContactLaw, RelaxedRigid, Terrain};
use dualbody::model::{Mass, Object, World};
use dualbody::sim::Rollout;
use dualbody::spatial::Transform;
use dualbody::{Contacts, Recording, Simulator, State};

const COUNT: usize = 10;
/// Thickness, width, height, and the distance from one to the next, m.
const SIZE: [f64; 3] = [0.012, 0.05, 0.1];
const SPACING: f64 = 0.05;
const DT: f64 = 0.002;
const STEPS: usize = 700;
/// Speed with which the first one is let go, rad/s, about its lower edge.
const PUSH: f64 = 3.0;
/// A domino is falling from this angle on, rad.
const FALLING: f64 = 0.3;

fn main() -> Result<(), Box<dyn Error>> {
    let simulator = row()?;
    let mut start = simulator.neutral_state();
    let pushed = simulator
        .model()
        .joint_v(simulator.model().find_joint("domino 0")?);
    let velocity = [PUSH * SIZE[2] / 2.0, 0.0, 0.0, 0.0, PUSH, 0.0];
    start.v.rows_mut(pushed.start, 6).copy_from_slice(&velocity);
    let rollout = simulator.rollout(&start, STEPS, |_, _, _| {});

    let times = (0..COUNT).map(|k| falls_at(&simulator, &rollout, &format!("domino {k}")));
    let times = times.collect::<Result<Vec<f64>, _>>()?;
    // Once the wave is under way it takes the same time from one to the next.
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let late = &steps[COUNT / 2..];
    let mean = late.iter().sum::<f64>() / late.len() as f64;
    println!("the last of {COUNT} falls at {:.3} s", times[COUNT - 1]);
    println!("the wave runs at {:.2} m/s", SPACING / mean);
    assert!(steps.iter().all(|&step| step > 0.0), "{times:?}");
    assert!(
        late.iter().all(|step| (step / mean - 1.0).abs() < 0.25),
        "{steps:?}"
    );
    for k in 0..COUNT {
        let lies = tilt(&simulator, rollout.last(), &format!("domino {k}"))?;
        assert!(lies > 1.0, "domino {k} stands at {lies} rad");
    }

    std::fs::create_dir_all("out/dominoes")?;
    let recording = Recording::of_simulation(&simulator, &rollout).with_title("dominoes");
    Ok(recording.save_html("out/dominoes/index.html")?)
}

fn row() -> Result<Simulator, Box<dyn Error>> {
    let mut world = World::new("dominoes");
    for k in 0..COUNT {
        let at = [SPACING * k as f64, 0.0, SIZE[2] / 2.0];
        let domino = Object::free(Mass::Density(800.0))
            .at(Transform::from_translation(at.into()))
            .with_color([0.2, 0.3 + 0.05 * k as f64, 0.6, 1.0]);
        world.add_box(&format!("domino {k}"), SIZE, &domino)?;
    }
    let model = world.build()?;
    let law = ContactLaw::RelaxedRigid(RelaxedRigid {
        friction: 0.5,
        ..RelaxedRigid::default()
    });
    let options = CollisionOptions::default();
    let contacts =
        Contacts::new(&model, Terrain::flat(0.0), law).with_collisions(&model, law, &options)?;
    Ok(Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(DT))
}

/// Angle of a domino from the vertical, rad.
fn tilt(simulator: &Simulator, state: &State, name: &str) -> Result<f64, Box<dyn Error>> {
    let pose = state.free_pose(simulator.model(), name)?;
    Ok(pose.rotation[(2, 2)].clamp(-1.0, 1.0).acos())
}

/// Time at which a domino begins to fall, s.
fn falls_at(simulator: &Simulator, rollout: &Rollout, name: &str) -> Result<f64, Box<dyn Error>> {
    for (time, state) in rollout.times().zip(&rollout.states) {
        if tilt(simulator, state, name)? > FALLING {
            return Ok(time);
        }
    }
    Err(format!("{name} does not fall").into())
}
