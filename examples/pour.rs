//! Boxes and spheres are poured into a bin. At the end all are in the bin, nearly at rest, and none has passed through a wall.
//!
//! `cargo run --release --example pour` – writes `out/pour/index.html`, a page that opens in any browser.

use std::error::Error;

use dualbody::contact::{CollisionOptions, ContactLaw, RelaxedRigid, Terrain};
use dualbody::dynamics::kinetic_energy;
use dualbody::model::{Mass, Object, World};
use dualbody::sim::RolloutStatus;
use dualbody::spatial::Transform;
use dualbody::{Contacts, Recording, Simulator, State};

const COUNT: usize = 30;
/// Half width of a box and radius of a sphere, m.
const HALF: f64 = 0.03;
/// Half width of the bin inside, height and thickness of its walls, m.
const BIN: f64 = 0.15;
const HEIGHT: f64 = 0.25;
const WALL: f64 = 0.02;
const DT: f64 = 0.005;
const STEPS: usize = 400;

fn main() -> Result<(), Box<dyn Error>> {
    let mut world = World::new("pour");
    add_bin(&mut world)?;
    for k in 0..COUNT {
        add_object(&mut world, k)?;
    }
    let model = world.build()?;
    let law = ContactLaw::RelaxedRigid(RelaxedRigid {
        friction: 0.5,
        ..RelaxedRigid::default()
    });
    let options = CollisionOptions::default();
    let contacts =
        Contacts::new(&model, Terrain::flat(0.0), law).with_collisions(&model, law, &options)?;
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(DT);
    let rollout = simulator.rollout(&simulator.neutral_state(), STEPS, |_, _, _| {});

    let end = rollout.last();
    let (mut widest, mut lowest): (f64, f64) = (0.0, f64::INFINITY);
    for k in 0..COUNT {
        let at = end.free_pose(simulator.model(), &name(k))?.translation;
        widest = widest.max(at.x.abs()).max(at.y.abs());
        lowest = lowest.min(at.z);
    }
    let energy =
        |state: &State| kinetic_energy(simulator.model(), state.q.as_slice(), state.v.as_slice());
    let most = rollout.states.iter().map(energy).fold(0.0, f64::max);
    let left = energy(end) / most;
    println!(
        "{COUNT} objects: at most {widest:.3} m from the middle, at least {lowest:.3} m above the ground"
    );
    println!("{left:.1e} of the kinetic energy remains");
    assert_eq!(rollout.status, RolloutStatus::Completed);
    assert!(widest < BIN - 0.9 * HALF && lowest > 0.9 * HALF && left < 0.02);

    std::fs::create_dir_all("out/pour")?;
    let recording = Recording::of_simulation(&simulator, &rollout).with_title("pour");
    Ok(recording.save_html("out/pour/index.html")?)
}

fn name(k: usize) -> String {
    format!("object {k}")
}

/// Four walls on the ground.
fn add_bin(world: &mut World) -> Result<(), Box<dyn Error>> {
    let (out, long) = (BIN + WALL / 2.0, 2.0 * (BIN + WALL));
    for (name, at, size) in [
        ("left", [-out, 0.0], [WALL, long, HEIGHT]),
        ("right", [out, 0.0], [WALL, long, HEIGHT]),
        ("front", [0.0, -out], [long, WALL, HEIGHT]),
        ("back", [0.0, out], [long, WALL, HEIGHT]),
    ] {
        let at = Transform::from_translation([at[0], at[1], HEIGHT / 2.0].into());
        let glass = Object::fixed().with_color([0.6, 0.75, 0.85, 0.3]);
        world.add_box(name, size, &glass.at(at))?;
    }
    Ok(())
}

/// Layers of three by three, each a little askew so that nothing falls straight onto the layer below.
fn add_object(world: &mut World, k: usize) -> Result<(), Box<dyn Error>> {
    let (layer, place) = (k / 9, k % 9);
    let skew = 0.01 * (layer as f64).sin();
    let x = 0.08 * (place % 3) as f64 - 0.08 + skew;
    let y = 0.08 * (place / 3) as f64 - 0.08 - skew;
    let z = 0.1 + 0.09 * layer as f64;
    let hue = k as f64 / COUNT as f64;
    let object = Object::free(Mass::Density(500.0))
        .at(Transform::from_translation([x, y, z].into()))
        .with_color([0.3 + 0.6 * hue, 0.6 - 0.3 * hue, 0.8 - 0.6 * hue, 1.0]);
    match k % 2 {
        0 => world.add_box(&name(k), [2.0 * HALF; 3], &object)?,
        _ => world.add_sphere(&name(k), HALF, &object)?,
    };
    Ok(())
}
