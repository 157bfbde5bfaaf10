//! Capsules and cylinders whose sides lie along one another touch at both ends of their overlap, so that logs rest on logs.

use dualbody::collision::{Manifold, Shape, features, witness};
use dualbody::contact::{CollisionOptions, ContactLaw, Contacts, RelaxedRigid, Rigid, Terrain};
use dualbody::model::{Mass, Object, World};
use dualbody::spatial::{Quaternion, Transform};
use dualbody::{Integrator, Simulator, State};
use nalgebra::Vector3;

use crate::common::ground::differences;

const RADIUS: f64 = 0.1;

/// A shape with its axis along x, of half the length.
fn shapes(half_length: f64) -> [Shape; 2] {
    let radius = RADIUS;
    let capsule = Shape::Capsule {
        radius,
        half_length,
    };
    let cylinder = Shape::Cylinder {
        radius,
        half_length,
    };
    [capsule, cylinder]
}

/// A pose whose z axis is x, turned up by `pitch` and about the vertical by `yaw`.
fn lying(at: [f64; 3], pitch: f64, yaw: f64) -> Transform<f64> {
    let turn = |v: Vector3<f64>| Quaternion::exp(&v).to_matrix();
    let along = turn(Vector3::y() * std::f64::consts::FRAC_PI_2);
    let rotation = turn(Vector3::z() * yaw) * turn(Vector3::y() * -pitch) * along;
    Transform::new(rotation, Vector3::from(at))
}

/// x and depth of the points of a shape of half length 0.3 at the origin with one of 0.2 above it, in ascending order of x.
fn points(a: &Shape, b: &Shape, X_B: &Transform<f64>) -> Vec<[f64; 2]> {
    let X_A = lying([0.0; 3], 0.0, 0.0);
    let mut found = Manifold::default();
    features(a, &X_A, b, X_B, 0.0, &mut found);
    let at = |pair| {
        let own = witness::<f64, f64>(pair, a, &X_A, b, X_B);
        [own.points[0].x, -own.distance]
    };
    let mut all: Vec<[f64; 2]> = found.pairs().iter().map(at).collect();
    all.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    all
}

fn assert_points(found: &[[f64; 2]], expected: &[[f64; 2]], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}: {found:?}");
    for (found, expected) in found.iter().zip(expected) {
        let error = (found[0] - expected[0])
            .abs()
            .max((found[1] - expected[1]).abs());
        assert!(error < 1e-9, "{what}: {found:?}, {expected:?}");
    }
}

#[test]
fn parallel_sides_touch_at_the_ends_of_their_overlap() {
    for a in shapes(0.3) {
        for (half_length, x, ends) in [
            (0.2, 0.05, [-0.15, 0.25]),
            (0.2, 0.2, [0.0, 0.3]),
            (0.3, 0.0, [-0.3, 0.3]),
            (0.5, -0.1, [-0.3, 0.3]),
        ] {
            for b in shapes(half_length) {
                let X_B = lying([x, 0.0, 0.19], 0.0, 0.0);
                let what = format!("{a:?} {b:?} {x}");
                assert_points(&points(&a, &b, &X_B), &ends.map(|x| [x, 0.01]), &what);
            }
        }
    }
}

// A pitch of φ lifts one end by 0.4 sin φ; a yaw leaves the crossing nearest, and both ends beside it.
#[test]
fn sides_at_a_small_angle_touch_at_several_points_and_others_at_one() {
    let ([a, _], [b, _]) = (shapes(0.3), shapes(0.2));
    let pitched = |pitch: f64| points(&a, &b, &lying([0.05, 0.0, 0.19], pitch, 0.0));
    let (sin, cos) = 0.02_f64.sin_cos();
    let ends = [-0.2, 0.2].map(|s| [0.05 + s * cos, 0.01 - s * sin]);
    assert_points(&pitched(0.02), &ends, "pitched");
    assert_eq!(pitched(0.06).len(), 1);
    let yawed = |yaw: f64| points(&a, &b, &lying([0.0, 0.0, 0.19], 0.0, yaw));
    let found = yawed(0.02);
    assert_eq!(found.len(), 3, "{found:?}");
    assert!(found[1][0].abs() < 1e-9 && (found[1][1] - 0.01).abs() < 1e-9);
    let aside = 0.2 * 0.02_f64.sin();
    let depth = 0.2 - aside.hypot(0.19);
    assert!((found[0][1] - depth).abs() < 1e-9 && (found[2][1] - depth).abs() < 1e-9);
    assert_eq!(yawed(0.06).len(), 1);
}

/// A log in the valley between two that lie on the ground.
fn logs(law: ContactLaw, cylinders: bool) -> Simulator {
    let mut world = World::default();
    for (k, (y, z)) in [(-0.101, 0.1), (0.101, 0.1), (0.0, 0.1 + 0.03_f64.sqrt())]
        .into_iter()
        .enumerate()
    {
        let pose = lying([0.02 * k as f64, y, z], 0.0, 0.0);
        let object = match k {
            2 => Object::free(Mass::Kilograms(1.0)).at(pose),
            _ => Object::fixed().at(pose),
        };
        let name = format!("log{k}");
        let half = if k == 2 { 0.2 } else { 0.3 };
        match cylinders {
            true => world.add_cylinder(&name, RADIUS, 2.0 * half, &object),
            false => world.add_capsule(&name, RADIUS, 2.0 * half, &object),
        }
        .expect("a log");
    }
    let model = world.build().expect("logs");
    let contacts = Contacts::new(&model, Terrain::flat(-10.0), law)
        .with_collisions(&model, law, &CollisionOptions::default())
        .expect("shapes");
    Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(1e-3)
}

fn laws() -> [ContactLaw; 2] {
    let friction = 0.5;
    let rigid = Rigid {
        friction,
        ..Rigid::default()
    };
    let relaxed = RelaxedRigid {
        friction,
        ..RelaxedRigid::default()
    };
    [ContactLaw::Rigid(rigid), ContactLaw::RelaxedRigid(relaxed)]
}

// With one point at an end it would turn by a degree and rattle.
#[test]
fn log_rests_between_two_others() {
    for law in laws() {
        for cylinders in [false, true] {
            let simulator = logs(law, cylinders);
            let start = simulator.neutral_state();
            let end = simulator.rollout(&start, 1500, |_, _, _| {}).last().clone();
            let what = format!("{law:?}, cylinders: {cylinders}");
            let moved = simulator
                .model()
                .difference(start.q.as_slice(), end.q.as_slice());
            assert!(end.v.amax() < 1e-4, "{what}: {:e}", end.v.amax());
            assert!(moved.amax() < 0.02, "{what}: {moved}");
            let turned = moved.rows(3, 3).amax();
            assert!(turned < 1e-4, "{what}: {turned:e}");
        }
    }
}

#[test]
fn jacobians_of_a_log_that_rolls_on_another_equal_finite_differences() {
    for law in laws() {
        for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
            let simulator = logs(law, false).with_integrator(integrator);
            let mut state: State = simulator.neutral_state();
            state.q[2] -= 1e-3;
            state.v[1] = 0.1;
            let exact = simulator.linearize(&state, &vec![0.0; simulator.nu()]).a;
            let numeric = differences(&simulator, &state, 1e-7);
            let error = (&exact - &numeric).amax() / numeric.amax();
            assert!(error < 1e-5, "{law:?} {integrator:?}: {error:e}");
        }
    }
}
