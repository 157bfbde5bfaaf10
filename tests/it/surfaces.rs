//! Meshes of triangles as ground, beside boxes of the same form.

use std::time::{Duration, Instant};

use dualbody::collision::Surface;
use dualbody::contact::{CollisionOptions, ContactLaw, Contacts, Rigid, Terrain};
use dualbody::joint::JointKind;
use dualbody::model::{Base, JointSpec, LinkSpec, Mass, ModelBuilder};
use dualbody::sim::StepScratch;
use dualbody::{Simulator, State};
use nalgebra::{DVector, UnitQuaternion, Vector3};

/// Steps of 0.3 m along y with heights of 0.1 m, each a box, from which the same is made of triangles.
const STEP: [f64; 2] = [0.3, 0.1];

/// A floor of 5 × 5 points over 4 m × 4 m at z = 0, with its inner points shaken in the plane.
fn shaken_floor() -> Surface {
    let flat = Surface::grid([-2.0, -2.0], [1.0, 1.0], [5, 5], &[0.0; 25]).expect("a grid");
    let shake = |(k, v): (usize, &Vector3<f64>)| {
        let (i, j) = (k % 5, k / 5);
        let inner = (1..4).contains(&i) && (1..4).contains(&j);
        let by = if inner { 0.3 } else { 0.0 };
        let angle = 2.4 * k as f64;
        v + Vector3::new(by * angle.sin(), by * angle.cos(), 0.0)
    };
    let vertices = flat.vertices().iter().enumerate().map(shake).collect();
    Surface::new(vertices, flat.triangles().to_vec()).expect("a mesh")
}

/// One free thing above the link `world`, which has a surface, or a box below z = 0.
fn simulator(thing: &LinkSpec, surface: Option<Surface>) -> Simulator {
    let mut builder = ModelBuilder::new("one").with_base(Base::Fixed);
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("ground"));
    builder.add_joint(JointSpec::new("held", JointKind::Fixed, "world", "ground"));
    if surface.is_none() {
        let slab = LinkSpec::solid_box("slab", [4.0, 4.0, 0.5], Mass::Kilograms(1.0));
        builder.add_link(slab);
        let below = JointSpec::new("low", JointKind::Fixed, "ground", "slab");
        builder.add_joint(below.with_translation([0.0, 0.0, -0.25]));
    }
    builder.add_link(thing.clone());
    let name = thing.name.clone();
    builder.add_joint(JointSpec::new("free", JointKind::Floating, "world", name));
    let model = builder.build().expect("a model");
    let law = ContactLaw::Rigid(Rigid::default());
    let options = CollisionOptions::default();
    let options = match surface {
        Some(surface) => options.with_surface("ground", surface),
        None => options,
    };
    let contacts = Contacts::new(&model, Terrain::flat(-20.0), law)
        .with_collisions(&model, law, &options)
        .expect("links");
    Simulator::new(model)
        .with_actuated_joints(&[])
        .expect("joints")
        .with_contacts(contacts)
        .with_time_step(5e-3)
}

fn start(simulator: &Simulator, at: [f64; 3], turn: [f64; 3], v: [f64; 6]) -> State {
    let mut state = simulator.neutral_state();
    let turn = UnitQuaternion::from_scaled_axis(Vector3::from(turn));
    let q = at.into_iter().chain([turn.w, turn.i, turn.j, turn.k]);
    state.q.iter_mut().zip(q).for_each(|(q, x)| *q = x);
    state.v.copy_from_slice(&v);
    state
}

fn ball() -> LinkSpec {
    LinkSpec::solid_sphere("ball", 0.1, Mass::Kilograms(1.0))
}

fn crate_of(size: [f64; 3]) -> LinkSpec {
    LinkSpec::solid_box("crate", size, Mass::Kilograms(1.0))
}

// A body that rolls, slides or falls over the sides of a flat mesh moves as on one box. (A flat body that spins need not: where its pressure is, more points decide
// otherwise.)
#[test]
fn a_flat_mesh_equals_a_box() {
    let capsule = LinkSpec::solid_capsule("capsule", 0.08, 0.3, Mass::Kilograms(1.0));
    let (flat, cube) = (crate_of([0.5, 0.4, 0.2]), crate_of([0.2; 3]));
    let (still, tilted) = ([0.0; 3], [0.4, 0.3, 0.2]);
    for (thing, height, turn, v, steps) in [
        (ball(), 0.1, tilted, [1.5, 1.1, 0.0, 0.0, 0.0, 0.0], 160),
        (flat, 0.1, still, [3.0, 2.0, 0.0, 0.0, 0.0, 0.0], 80),
        (cube, 0.3, tilted, [1.0, 0.5, -2.0, 2.0, 3.0, 1.0], 25),
        (capsule, 0.3, tilted, [1.0, -0.5, -2.0, 1.0, 2.0, 0.0], 25),
    ] {
        let [mut on_mesh, mut on_box] = [Some(shaken_floor()), None].map(|surface| {
            let simulator = simulator(&thing, surface);
            let state = start(&simulator, [-0.9, -0.8, height], turn, v);
            (simulator, state)
        });
        for k in 0..steps {
            for (simulator, state) in [&mut on_mesh, &mut on_box] {
                *state = simulator.step(state, &[]);
            }
            let error = (&on_mesh.1.q - &on_box.1.q).amax();
            assert!(error < 1e-6, "{} {k}: {error}", thing.name);
        }
        let [free, touched] = [v[2] - 9.81 * 5e-3 * f64::from(steps), on_mesh.1.v[2]];
        assert!(touched > free + 0.3, "{}: {touched} {free}", thing.name);
    }
}

/// Steps downwards along y.
fn stairs() -> Surface {
    let [depth, height] = STEP;
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    let mut quad = |corners: [[f64; 2]; 2]| {
        let first = vertices.len() as u32;
        for [y, z] in corners {
            vertices.extend([Vector3::new(-1.0, y, z), Vector3::new(1.0, y, z)]);
        }
        triangles.extend([[0, 1, 3], [0, 3, 2]].map(|own: [u32; 3]| own.map(|k| first + k)));
    };
    for k in 0..6 {
        let [y, z] = [depth * f64::from(k), -height * f64::from(k)];
        quad([[y, z], [y + depth, z]]);
        quad([[y + depth, z], [y + depth, z - height]]);
    }
    Surface::new(vertices, triangles).expect("a mesh")
}

// A ball rolls down the stairs and is never below the step that it is over, nor in front of a wall.
#[test]
fn a_ball_that_rolls_down_stairs_stays_on_them() {
    let simulator = simulator(&ball(), Some(stairs()));
    let v = [0.0, 0.7, 0.0, 0.0, 0.0, 0.0];
    let mut state = start(&simulator, [0.1, 0.15, 0.1], [0.0; 3], v);
    for _ in 0..400 {
        state = simulator.step(&state, &[]);
        let (y, z) = (state.q[1], state.q[2]);
        let step = (y / STEP[0]).floor().clamp(0.0, 5.0);
        assert!(
            z > 0.1 - STEP[1] * step - 1e-3 || y > 6.0 * STEP[0],
            "{y} {z}"
        );
    }
    assert!(state.q[1] > 1.0, "{}", state.q[1]);
}

// In a trough with walls of 45°, a ball of radius r rests at r √2 over the bottom, on both.
#[test]
fn a_ball_in_a_trough_touches_both_walls() {
    let heights = [1.0, 0.0, 1.0, 1.0, 0.0, 1.0];
    let trough = Surface::grid([-1.0, -1.0], [1.0, 2.0], [3, 2], &heights).expect("a grid");
    let simulator = simulator(&ball(), Some(trough));
    let mut state = start(&simulator, [0.02, 0.3, 0.2], [0.0; 3], [0.0; 6]);
    for _ in 0..400 {
        state = simulator.step(&state, &[]);
    }
    assert!(
        (state.q[2] - 0.1 * 2.0_f64.sqrt()).abs() < 1e-6,
        "{}",
        state.q[2]
    );
    let pairs = simulator.contact_report(&state, &[]).pairs;
    let sides = pairs.iter().filter(|pair| pair.force.norm() > 0.1);
    let mut sides: Vec<f64> = sides.map(|pair| pair.point.normal.x).collect();
    sides.sort_by(f64::total_cmp);
    assert!(sides[0] < -0.7 && sides[sides.len() - 1] > 0.7, "{sides:?}");
}

#[test]
fn jacobians_on_a_mesh_equal_finite_differences() {
    let waves: Vec<f64> = (0..49).map(|k| 0.03 * (2.3 * f64::from(k)).sin()).collect();
    let ground = Surface::grid([-0.9, -0.9], [0.3, 0.3], [7, 7], &waves).expect("a grid");
    let simulator = simulator(&crate_of([0.5, 0.4, 0.2]), Some(ground));
    let v = [0.3, -0.2, -0.5, 0.4, 0.2, 0.3];
    let mut state = start(&simulator, [0.1, 0.05, 0.14], [0.1, 0.05, 0.3], v);
    for _ in 0..6 {
        state = simulator.step(&state, &[]);
    }
    let a = simulator.linearize(&state, &[]).a;
    assert!(
        simulator
            .contact_report(&state, &[])
            .pairs
            .iter()
            .any(|p| p.force.norm() > 1.0)
    );
    let model = simulator.model();
    for k in 0..6 {
        let [after, before] = [1e-6, -1e-6].map(|by| {
            let mut moved = state.clone();
            let mut dq = vec![0.0; 6];
            dq[k] = by;
            moved.q = DVector::from(model.integrate(state.q.as_slice(), &dq));
            simulator.step(&moved, &[])
        });
        for i in 0..6 {
            let expected = (after.v[i] - before.v[i]) / 2e-6;
            let found = a[(6 + i, k)];
            assert!(
                (found - expected).abs() < 1e-6 * a.amax(),
                "{i} {k}: {found} {expected}"
            );
        }
    }
}

/// A wavy grid of n × n cells over 40 m × 40 m.
fn waves(n: usize) -> Surface {
    let heights: Vec<f64> = (0..(n + 1) * (n + 1))
        .map(|k| 0.02 * (0.7 * k as f64).sin())
        .collect();
    Surface::grid([-20.0; 2], [40.0 / n as f64; 2], [n + 1; 2], &heights).expect("a grid")
}

// A body is near as many triangles on a mesh of twice as many far away from it. Of times the least counts, which other work on the machine does not change.
#[test]
fn a_step_on_a_hundred_times_the_triangles_takes_about_as_long() {
    let fine = waves(150);
    let near = |v: &Vector3<f64>| v.x.abs() < 0.8 && v.y.abs() < 0.8;
    let triangles: Vec<[u32; 3]> = fine.triangles().to_vec();
    let few = triangles.iter().filter(|own| {
        let mut corners = own.iter();
        corners.all(|&k| near(&fine.vertices()[k as usize]))
    });
    let few = Surface::new(fine.vertices().to_vec(), few.copied().collect()).expect("a mesh");
    assert!(100 * few.triangles().len() < triangles.len());
    let thing = crate_of([0.5, 0.4, 0.2]);
    let times = [few, fine].map(|surface| {
        let simulator = simulator(&thing, Some(surface));
        let mut scratch = StepScratch::new(&simulator);
        let mut state = start(&simulator, [0.0, 0.0, 0.12], [0.0; 3], [0.0; 6]);
        let mut next = state.clone();
        let mut least = Duration::MAX;
        for _ in 0..30 {
            let begin = Instant::now();
            simulator.step_into(&state, &[], &mut scratch, &mut next);
            least = least.min(begin.elapsed());
            std::mem::swap(&mut state, &mut next);
        }
        (least, state.q)
    });
    let [(few, q), (all, same)] = times;
    assert_eq!(q, same);
    assert!(all < 3 * few, "{all:?} {few:?}");
}

#[test]
fn the_order_of_triangles_does_not_change_a_step() {
    let mesh = waves(80);
    let mut turned = mesh.triangles().to_vec();
    turned.reverse();
    let turned = Surface::new(mesh.vertices().to_vec(), turned).expect("a mesh");
    let ends = [mesh, turned].map(|surface| {
        let simulator = simulator(&ball(), Some(surface));
        let v = [0.4, 0.3, 0.0, 0.0, 0.0, 0.0];
        let mut state = start(&simulator, [0.1, 0.15, 0.13], [0.0; 3], v);
        for _ in 0..100 {
            state = simulator.step(&state, &[]);
        }
        assert!(!simulator.contact_report(&state, &[]).pairs.is_empty());
        state.q
    });
    assert!((&ends[0] - &ends[1]).amax() < 1e-9);
}

#[test]
#[should_panic(expected = "its link \"ball\" moves")]
fn a_surface_on_a_link_that_moves_is_refused() {
    let mut builder = ModelBuilder::new("one").with_base(Base::Fixed);
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(ball());
    builder.add_joint(JointSpec::new("free", JointKind::Floating, "world", "ball"));
    let model = builder.build().expect("a model");
    let law = ContactLaw::Rigid(Rigid::default());
    let options = CollisionOptions::default().with_surface("ball", stairs());
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let _ = contacts.with_collisions(&model, law, &options);
}
