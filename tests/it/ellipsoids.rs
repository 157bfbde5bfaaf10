//! Ellipsoids on the ground, on other bodies, before range finders and in files, against closed forms and finite differences.

use dualbody::contact::{CollisionOptions, ContactLaw, Contacts, RelaxedRigid, Terrain};
use dualbody::io::{ImportReport, MjcfScene};
use dualbody::model::{Collision, Geometry, LinkSpec, Mass, Model};
use dualbody::sim::{Sensor, Sensors};
use dualbody::spatial::{Quaternion, Transform};
use dualbody::{ModelOptions, Simulator, State};
use nalgebra::{Matrix3, Vector3, vector};

use crate::common::generator;
use crate::common::ground::{assert_derivatives, body, hills, rolling_on, run, sticky_laws};
use crate::common::{OTHER_ALGORITHM, SAME_ALGEBRA};

/// Semi-axes, m.
const HALF: [f64; 3] = [0.1, 0.2, 0.3];

fn shape() -> Geometry {
    Geometry::Ellipsoid {
        size: HALF.map(|half| 2.0 * half),
    }
}

/// An ellipsoid of 1 kg about its link.
fn egg() -> Model {
    let inertia = shape().inertia(Mass::Kilograms(1.0)).expect("a solid");
    body(
        LinkSpec::new("egg")
            .with_inertia(inertia)
            .with_collision(Collision {
                name: None,
                placement: Transform::identity(),
                geometry: shape(),
            }),
    )
}

fn random_state(simulator: &Simulator, seed: u64) -> State {
    let any = State::random(simulator.model(), &mut generator(seed), 1.0);
    simulator.state(any.q.as_slice(), any.v.as_slice())
}

// The support of an ellipsoid along n is √(nᵀ R S² Rᵀ n), and there the surface is across n.
#[test]
fn lowest_point_is_that_of_the_support_function() {
    let simulator = rolling_on(&egg(), Terrain::flat(0.0), sticky_laws(1e-4)[2]);
    let (model, contacts) = (simulator.model(), simulator.contacts().expect("contacts"));
    for seed in 0..20 {
        let state = random_state(&simulator, seed);
        let q = state.q.as_slice();
        let found = contacts.states(model, q, state.v.as_slice())[0].position;
        let rotation = Quaternion::from_slice(&q[3..]).to_matrix();
        let squares = Matrix3::from_diagonal(&Vector3::from(HALF.map(|half| half * half)));
        let matrix = rotation * squares * rotation.transpose();
        let expected = q[2] - matrix[(2, 2)].sqrt();
        assert!((found.z - expected).abs() < SAME_ALGEBRA, "{seed}");
        let at = matrix.try_inverse().expect("a matrix") * (found - vector![q[0], q[1], q[2]]);
        assert!(
            (at.xy().norm() / at.norm()) < OTHER_ALGORITHM,
            "{seed}: {at}"
        );
    }
}

#[test]
fn it_comes_to_rest_on_its_flat_side() {
    let law = ContactLaw::RelaxedRigid(RelaxedRigid {
        friction: 1.0,
        ..RelaxedRigid::default()
    });
    let simulator = rolling_on(&egg(), Terrain::flat(0.0), law).with_time_step(2e-3);
    // On the shortest semi-axis, which is x of the body, there and tilted it would roll back.
    let up = std::f64::consts::FRAC_PI_4.sin_cos();
    let start = simulator.state(&[0.0, 0.0, 0.12, up.1, 0.0, up.0, 0.0], &[0.0; 6]);
    let end = run(&simulator, &start, 2.0);
    assert!((end.q[2] - HALF[0]).abs() < 1e-3, "{}", end.q);
    assert!(end.v.amax() < 1e-6, "{}", end.v);
}

#[test]
fn jacobians_of_steps_in_contact_equal_finite_differences() {
    for terrain in [Terrain::flat(0.0), hills()] {
        for law in sticky_laws(1e-3) {
            let simulator = rolling_on(&egg(), terrain.clone(), law);
            let contacts = simulator.contacts().expect("contacts");
            for seed in 0..3 {
                let mut state = random_state(&simulator, seed);
                // 0.4 mm deep: at half of the width of the impedance its curvature jumps.
                let points =
                    contacts.states(simulator.model(), state.q.as_slice(), state.v.as_slice());
                state.q[2] += points[0].depth - 4e-4;
                state.v *= 0.1;
                assert_derivatives(&simulator, &state, &format!("{law:?}, {seed}"));
            }
        }
    }
}

fn text(xml: &str) -> (MjcfScene, ImportReport) {
    let loaded = ModelOptions::default().load_mjcf_scene_str(xml);
    loaded.unwrap_or_else(|error| panic!("{error}"))
}

/// An ellipsoid that falls on a fixed box.
const ON_A_BOX: &str = "<mujoco><worldbody><geom name='table' type='box' size='1 1 0.1' pos='0 0 0.4'/>
     <body name='egg' pos='0 0 0.6'><freejoint name='f'/><geom name='shell' type='ellipsoid' size='0.3 0.2 0.1' rgba='1 0 0 1'/></body></worldbody></mujoco>";

// From 0.5 m: an ellipsoid, whose shortest semi-axis is 0.1 m, rests at 0.6 m on the box. Its mass is 1000 · 4 π / 3 · 0.006 kg.
#[test]
fn ellipsoids_of_files_touch_bodies_and_are_shown() {
    let (scene, report) = text(ON_A_BOX);
    assert!(report.ignored.is_empty(), "{report}");
    let mass = 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.006;
    assert!((scene.model.total_mass() - mass).abs() < SAME_ALGEBRA * mass);
    let simulator = scene.simulator();
    let end = simulator
        .rollout(&scene.reference, 1000, |_, _, _| {})
        .last()
        .clone();
    assert!((end.q[2] - 0.6).abs() < 1e-3, "{}", end.q);
    assert!(end.v.amax() < 1e-6, "{}", end.v);
}

#[test]
fn ellipsoids_survive_mjcf_and_are_named_by_urdf() {
    let (scene, _) = text(ON_A_BOX);
    let written = scene.model.to_mjcf().expect("a file");
    let (again, _) = text(&written);
    let find = |model: &Model| {
        let links = model.links().iter();
        let all = links.flat_map(|link| link.collisions.iter().map(|own| own.geometry.clone()));
        all.filter(|own| matches!(own, Geometry::Ellipsoid { .. }))
            .collect::<Vec<_>>()
    };
    assert_eq!(find(&scene.model).len(), 1);
    assert_eq!(find(&again.model), find(&scene.model));
    let urdf = scene.model.to_urdf().expect("a file");
    assert!(urdf.contains("2 ellipsoids of link egg"), "{urdf}");
}

// Along x from 1 m beside the centre the surface is 0.9 m away; from above its end at z = 0.15 m, where x = 0.1 √(1 − ¼).
#[test]
fn rays_meet_the_surface() {
    let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let (scene, _) = text(
        "<mujoco><worldbody><geom type='ellipsoid' size='0.1 0.2 0.3'/>
         <body name='eye' pos='1 0 0'><joint name='lift' type='slide' axis='0 0 1'/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body></worldbody></mujoco>",
    );
    let model = scene.model.clone();
    let contacts = Contacts::new(&model, Terrain::flat(-5.0), law);
    let contacts = contacts.with_collisions(&model, law, &CollisionOptions::default());
    let simulator = Simulator::new(model.clone()).with_contacts(contacts.expect("shapes"));
    let eye = Sensor::RangeFinder {
        frame: model.frame("eye").expect("a link"),
        direction: [-1.0, 0.0, 0.0],
        range: 10.0,
    };
    let sensors = Sensors::new(&model, [("eye", eye)]);
    for (z, x) in [(0.0, 0.1), (0.15, 0.1 * 0.75_f64.sqrt())] {
        let state = simulator.state(&[z], &[0.0]);
        let found = sensors.read(&simulator, &state, &[0.0])[0];
        assert!((found - (1.0 - x)).abs() < SAME_ALGEBRA, "{found}");
    }
}
