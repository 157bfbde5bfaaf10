//! Two stacks of five bricks, each brick shifted along x relative to the one below. A stack stands if for each brick the centre of mass of the bricks
//! above is over that brick: five bricks topple if the shift exceeds a fifth of the length of a brick.
//!
//! `cargo run --release --example stack` – writes `out/stack/index.html`, a page that opens in any browser.

use std::error::Error;

use dualbody::contact::{CollisionOptions, ContactLaw, Rigid, Terrain};
use dualbody::model::{Mass, Object, World};
use dualbody::sim::Rollout;
use dualbody::spatial::Transform;
use dualbody::{Contacts, Recording, Simulator};

const BRICKS: usize = 5;
const SIZE: [f64; 3] = [0.4, 0.2, 0.1];
const STEPS: usize = 400;

/// The largest shift s under which a stack of n bricks of length l stands, m. The centre of those above the lowest one, n s / 2 beside its centre, is then over
/// the edge at l / 2.
fn limit() -> f64 {
    SIZE[0] / BRICKS as f64
}

fn main() -> Result<(), Box<dyn Error>> {
    let (stands, _) = fall(0.95 * limit())?;
    let (topples, simulator) = fall(1.05 * limit())?;
    let (first, last) = (
        drop_of(&stands, &simulator)?,
        drop_of(&topples, &simulator)?,
    );
    println!(
        "shifted by 95 % of the limit, the top brick sinks by {:.1e} m",
        first
    );
    println!("shifted by 105 % of it, by {last:.3} m");
    assert!(first < 1e-6 && last > 0.1);

    std::fs::create_dir_all("out/stack")?;
    let recording = Recording::of_simulation(&simulator, &topples).with_title("stack");
    Ok(recording.save_html("out/stack/index.html")?)
}

/// Two seconds of a stack that is let go.
fn fall(shift: f64) -> Result<(Rollout, Simulator), Box<dyn Error>> {
    let mut world = World::new("stack");
    for k in 0..BRICKS {
        let at = [shift * k as f64, 0.0, SIZE[2] * (k as f64 + 0.5)];
        let gray = 0.4 + 0.1 * k as f64;
        let brick = Object::free(Mass::Kilograms(1.0))
            .at(Transform::from_translation(at.into()))
            .with_color([gray, gray, 0.9, 1.0]);
        world.add_box(&format!("brick {k}"), SIZE, &brick)?;
    }
    let model = world.build()?;
    let law = ContactLaw::Rigid(Rigid {
        friction: 0.8,
        restitution: 0.0,
        ..Rigid::default()
    });
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law).with_collisions(
        &model,
        law,
        &CollisionOptions::default(),
    )?;
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(0.005);
    let rollout = simulator.rollout(&simulator.neutral_state(), STEPS, |_, _, _| {});
    Ok((rollout, simulator))
}

/// By how much the top brick has sunk, m.
fn drop_of(rollout: &Rollout, simulator: &Simulator) -> Result<f64, Box<dyn Error>> {
    let top = format!("brick {}", BRICKS - 1);
    let end = rollout.last().free_pose(simulator.model(), &top)?;
    Ok(SIZE[2] * (BRICKS as f64 - 0.5) - end.translation.z)
}
