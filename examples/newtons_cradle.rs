//! Newton's cradle: five balls on strings. The first ball is released at 40° and stops at the impact; the last ball rises to the same height.
//!
//! `cargo run --release --example newtons_cradle` – writes `out/newtons_cradle/index.html`, a page that opens in any browser.

use std::error::Error;

use dualbody::contact::{CollisionOptions, ContactLaw, Rigid, Terrain};
use dualbody::joint::JointKind;
use dualbody::model::{Collision, Geometry, JointSpec, LinkSpec, ModelBuilder, Visual};
use dualbody::spatial::Transform;
use dualbody::{Base, Contacts, Model, Recording, Simulator};
use nalgebra::Vector3;

const BALLS: usize = 5;
const RADIUS: f64 = 0.05;
const LENGTH: f64 = 0.5;
const MASS: f64 = 0.2;
/// Distance between the balls at rest, m: so each impact is one of two balls.
const GAP: f64 = 1e-3;
const DT: f64 = 1e-4;
const ANGLE: f64 = 0.7;

fn main() -> Result<(), Box<dyn Error>> {
    let model = cradle()?;
    let law = ContactLaw::Rigid(Rigid {
        friction: 0.0,
        restitution: 1.0,
        ..Rigid::default()
    });
    // The ground is far below.
    let contacts = Contacts::new(&model, Terrain::flat(-2.0), law).with_collisions(
        &model,
        law,
        &CollisionOptions::default(),
    )?;
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(DT);
    let mut state = simulator.neutral_state();
    state.q[0] = ANGLE;
    let rollout = simulator.rollout(&state, (1.6 / DT) as usize, |_, _, _| {});

    let angles = |ball: usize| rollout.states.iter().map(move |state| state.q[ball]);
    let highest = -angles(BALLS - 1).fold(0.0, f64::min);
    let energy = |k: usize| {
        let state = &rollout.states[k];
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        let model = simulator.model();
        dualbody::dynamics::kinetic_energy(model, q, v)
            + dualbody::dynamics::potential_energy(model, q)
    };
    let (start, end) = (energy(0), energy(rollout.states.len() - 1));
    let size = MASS * 9.81 * LENGTH * (1.0 - ANGLE.cos());
    println!("the last ball rises to {highest:.4} rad, the first one fell from {ANGLE} rad");
    println!(
        "energy changes by {:.1e} of the initial potential energy",
        (end - start) / size
    );
    assert!((highest - ANGLE).abs() < 0.01);
    assert!((end - start).abs() < 5e-3 * size);

    std::fs::create_dir_all("out/newtons_cradle")?;
    let recording = Recording::of_simulation(&simulator, &rollout).with_title("Newton's cradle");
    Ok(recording.save_html("out/newtons_cradle/index.html")?)
}

/// Pendulums about y, side by side along x.
fn cradle() -> Result<Model, Box<dyn Error>> {
    let mut builder = ModelBuilder::new("cradle").with_base(Base::Fixed);
    builder.add_link(LinkSpec::new("world"));
    for k in 0..BALLS {
        let (name, inertia) = (format!("ball {k}"), 0.4 * MASS * RADIUS * RADIUS);
        let low = Transform::from_translation(Vector3::new(0.0, 0.0, -LENGTH));
        let ball = Geometry::Sphere { radius: RADIUS };
        let string = Geometry::Cylinder {
            radius: 0.003,
            length: LENGTH,
        };
        let half = Transform::from_translation(Vector3::new(0.0, 0.0, -0.5 * LENGTH));
        let shown = |placement, geometry| Visual {
            name: None,
            placement,
            geometry,
            color: None,
        };
        builder.add_link(
            LinkSpec::new(&name)
                .with_mass(MASS, [0.0, 0.0, -LENGTH], [inertia; 3])
                .with_visual(shown(low, ball.clone()))
                .with_visual(shown(half, string))
                .with_collision(Collision {
                    name: None,
                    placement: low,
                    geometry: ball,
                }),
        );
        let x = (2.0 * RADIUS + GAP) * k as f64;
        let joint = JointSpec::new(format!("pivot {k}"), JointKind::Continuous, "world", &name);
        builder.add_joint(
            joint
                .with_axis([0.0, 1.0, 0.0])
                .with_translation([x, 0.0, 1.0]),
        );
    }
    Ok(builder.build()?)
}
