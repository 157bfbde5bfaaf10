//! Laws at the ends of their ranges: infinite friction, and springs without dampers.

use dualbody::contact::{
    ContactLaw, Contacts, HuntCrossley, Material, Materials, Reference, RelaxedRigid, SoftContact,
    Terrain,
};
use dualbody::model::{LinkSpec, Mass};
use dualbody::{Integrator, Model, Simulator, State};

use crate::common::ground::{
    base_velocity, body, differences, free, laws_with, rolling_on, run, square_root_law,
};
use crate::common::{OTHER_ALGORITHM, asset};

const INFINITY: f64 = f64::INFINITY;
/// Width and thickness of the plate, m.
const WIDTH: f64 = 0.5;
const THICKNESS: f64 = 0.05;

/// Laws with a friction for a box of 1 kg.
fn laws(friction: f64) -> [ContactLaw; 3] {
    laws_with(friction, square_root_law(1.0, 4, 1e-3))
}

/// Makes a plate of 1 kg.
fn plate() -> Model {
    let size = [WIDTH, WIDTH, THICKNESS];
    body(LinkSpec::solid_box("plate", size, Mass::Kilograms(1.0)))
}

/// The plate on an incline.
fn plate_on(simulator: &Simulator, angle: f64) -> State {
    let height = 0.5 * THICKNESS;
    let at = [-angle.sin() * height, 0.0, angle.cos() * height];
    free(simulator, at, -angle, [0.0; 6])
}

#[test]
fn nothing_slips_with_infinite_friction() {
    for angle in [0.3, 1.2_f64] {
        for law in laws(INFINITY) {
            let simulator = rolling_on(&plate(), Terrain::incline(angle), law);
            let start = plate_on(&simulator, angle);
            let end = run(&simulator, &start, 2.0);
            let slid = (end.q.rows(0, 3) - start.q.rows(0, 3)).norm();
            let speed = base_velocity(&end).norm();
            // Regularised contact creeps at the rate of its impedance.
            let is_relaxed = matches!(law, ContactLaw::RelaxedRigid(_));
            let most = if is_relaxed { 0.032 } else { 2e-3 };
            assert!(
                slid < most && speed < most,
                "{law:?}: {slid:e} at {speed:e}"
            );
            let a = simulator.linearize(&end, &[]).a;
            assert!(a.iter().all(|x| x.is_finite()), "{law:?}");
        }
    }
}

/// The plate on a slope of 1.2 rad under relaxed contact, after 2 s.
fn crept(law: RelaxedRigid) -> (Simulator, State) {
    let law = ContactLaw::RelaxedRigid(law);
    let simulator = rolling_on(&plate(), Terrain::incline(1.2), law);
    let end = run(&simulator, &plate_on(&simulator, 1.2), 2.0);
    (simulator, end)
}

// b v = Rₜ fₜ at each corner, with Rₜ = (1 − d) / d · Gₙₙ / ratio, and Gₙₙ of a plate at a corner 1 / m + (w / 2)²
// (1 / Ix + 1 / Iy).
#[test]
fn what_sticks_under_relaxed_contact_creeps_as_its_impedance_says() {
    let inertia = (WIDTH * WIDTH + THICKNESS * THICKNESS) / 12.0;
    let mobility = 1.0 + 2.0 * (0.5 * WIDTH).powi(2) / inertia;
    for ratio in [1.0, 10.0] {
        let law = RelaxedRigid {
            friction: INFINITY,
            friction_impedance_ratio: ratio,
            ..RelaxedRigid::default()
        };
        let Reference::TimeConstant { time_constant, .. } = law.reference else {
            panic!("the default is another one");
        };
        let damping = 2.0 / (law.impedance.largest * time_constant);
        let (simulator, end) = crept(law);
        let report = simulator.contact_report(&end, &[]);
        let mut sticking = 0;
        for (point, force) in report.points.iter().zip(&report.forces) {
            if force.norm() > 0.0 {
                let d = law.impedance.at(point.depth);
                let across = (force - point.normal * point.normal.dot(force)).norm();
                let expected = (1.0 - d) / d * mobility / ratio * across / damping;
                let error = point.velocity.norm() / expected - 1.0;
                assert!(error.abs() < 1e-3, "{point:?}: not {expected}, {error:e}");
                sticking += 1;
            }
        }
        assert_eq!(sticking, 4);
    }
}

#[test]
fn what_sticks_creeps_as_fast_with_friction_to_spare_as_with_infinite_friction() {
    let with = |friction| RelaxedRigid {
        friction,
        ..RelaxedRigid::default()
    };
    let [enough, much, infinite] = [10.0, 1e6, INFINITY].map(|mu| {
        let (_, end) = crept(with(mu));
        base_velocity(&end).norm()
    });
    assert!(
        (enough / infinite - 1.0).abs() < OTHER_ALGORITHM,
        "{enough} {infinite}"
    );
    assert!(
        (much / infinite - 1.0).abs() < OTHER_ALGORITHM,
        "{much} {infinite}"
    );
    // The figure in the documentation of the law.
    assert!((infinite - 0.0155).abs() < 1e-4, "{infinite}");
}

#[test]
fn derivatives_with_infinite_friction_equal_differences() {
    let model = asset("sphere.urdf");
    for law in laws(INFINITY) {
        let contacts = Contacts::new(&model, Terrain::incline(0.8), law);
        let simulator = Simulator::new(model.clone())
            .with_integrator(Integrator::ImplicitVelocity)
            .with_contacts(contacts);
        // Not at the middle of the sigmoid, where the law has a jump in its second derivative.
        let height = 0.0997;
        let at = [-f64::sin(0.8) * height, 0.0, f64::cos(0.8) * height];
        let state = free(&simulator, at, 0.3, [0.1, -0.2, -0.1, 0.3, -2.0, 0.4]);
        let a = simulator.linearize(&state, &[]).a;
        let expected = differences(&simulator, &state, 1e-7);
        let error = (&a - &expected).amax() / expected.amax();
        assert!(error < 1e-5, "{law:?}: {error:e}");
    }
}

#[test]
fn infinite_friction_of_a_material_leaves_that_of_the_other() {
    let material = |friction| Material {
        friction,
        ..Material::default()
    };
    let table = Materials::default()
        .with_material("glue", material(INFINITY))
        .with_material("wood", material(0.4))
        .with_material("ice", material(0.0));
    let between = |a, b| table.between(a, b).expect("materials").friction;
    assert_eq!(between("glue", "glue"), INFINITY);
    assert_eq!(between("glue", "wood"), 0.8);
    assert_eq!(between("glue", "ice"), 0.0);
}

#[test]
fn soft_contact_without_a_damper_is_a_spring() {
    let model = asset("sphere.urdf");
    let law = SoftContact {
        normal: HuntCrossley::linear(1e4, 0.0),
        friction: 0.5,
    };
    let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Soft(law));
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(1e-4);
    let start = free(
        &simulator,
        [0.0, 0.0, 0.15],
        0.0,
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    );
    let end = run(&simulator, &start, 1.0);
    assert!(
        end.q.iter().chain(end.v.iter()).all(|x| x.is_finite()),
        "{end:?}"
    );
    assert!(end.q[2] > 0.05, "{end:?}");
}
