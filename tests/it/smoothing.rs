//! Smoothed rigid contact in the simulator: closed forms, derivatives before touch-down, its limit, and batches.

use dualbody::cone::Mode;
use dualbody::contact::{
    ContactLaw, Contacts, RelaxedRigid, Rigid, Smoothing, SoftContact, Terrain,
};
use dualbody::sim::{Actuation, BatchSimulator};
use dualbody::{Integrator, Simulator, State};

use crate::common::ground::{differences, free, on, run};
use crate::common::{OTHER_ALGORITHM, SAME_ALGEBRA, asset};

const GRAVITY: f64 = 9.81;
const DT: f64 = 1e-3;
/// Force and derivatives of the path are found to the tolerance of its equations.
const ON_THE_PATH: f64 = 1e-8;

fn laws() -> [ContactLaw; 2] {
    [
        ContactLaw::Rigid(Rigid::default()),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
    ]
}

fn smoothed(model: &str, terrain: Terrain, law: ContactLaw, smoothing: Smoothing) -> Simulator {
    let exact = on(asset(model), terrain, law);
    let contacts = exact.contacts().expect("contacts").clone();
    exact.with_contacts(contacts.with_smoothing(smoothing))
}

/// A ball of 1 kg and 0.1 m at a height above flat ground.
fn ball(law: ContactLaw, kappa: f64) -> Simulator {
    smoothed(
        "sphere.urdf",
        Terrain::flat(0.0),
        law,
        Smoothing::new(kappa),
    )
}

fn above(simulator: &Simulator, height: f64, v: f64) -> State {
    free(
        simulator,
        [0.0, 0.0, 0.1 + height],
        0.0,
        [0.0, 0.0, v, 0.0, 0.0, 0.0],
    )
}

// f (a f + c) = κ
fn root(a: f64, c: f64, kappa: f64) -> f64 {
    2.0 * kappa / (c + (c * c + 4.0 * a * kappa).sqrt())
}

// Rigid: f (v⁺ + h / Δt) = κ with v⁺ = v + Δt (f − g).
#[test]
fn smoothed_rigid_force_above_the_ground_equals_its_closed_form() {
    let law = ContactLaw::Rigid(Rigid::default());
    for (kappa, height, v) in [(1.0, 0.01, 0.0), (0.1, 0.002, -1.0), (10.0, 0.09, -3.0)] {
        let simulator = ball(law, kappa);
        let report = simulator.contact_report(&above(&simulator, height, v), &[]);
        let expected = root(DT, v - DT * GRAVITY + height / DT, kappa);
        let error = (report.forces[0].z - expected).abs() / expected;
        assert!(error < ON_THE_PATH, "κ {kappa}: {error:e} of {expected}");
        assert_eq!(report.modes, [Mode::Smoothed]);
        assert!(report.certificate.is_converged());
    }
}

// Relaxed: f ((G + R) f − g + k d h + b v) = κ / Δt with R = (1 − d) / d G + Δt (k d h)² / κ, and the numbers of the
// default law.
#[test]
fn smoothed_relaxed_force_above_the_ground_equals_its_closed_form() {
    let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let (d, largest, time) = (0.9, 0.95, 0.02);
    let (b, k) = (
        2.0 / (largest * time),
        1.0 / (largest * time) / (largest * time),
    );
    for (kappa, height, v) in [(1.0, 0.01, 0.0), (0.1, 0.002, -1.0), (10.0, 0.09, -3.0)] {
        let simulator = ball(law, kappa);
        let report = simulator.contact_report(&above(&simulator, height, v), &[]);
        let pull: f64 = k * d * height;
        let kappa = kappa / DT;
        let give = 1.0 + (1.0 - d) / d + pull * pull / kappa;
        let expected = root(give, pull + b * v - GRAVITY, kappa);
        let error = (report.forces[0].z - expected).abs() / expected;
        assert!(error < ON_THE_PATH, "κ {kappa}: {error:e} of {expected}");
    }
}

// Four corners carry the box: m g / 4 = κ Δt / h at rest.
#[test]
fn smoothed_box_hovers_where_its_weight_balances() {
    let law = ContactLaw::Rigid(Rigid::default());
    let simulator = smoothed("box.urdf", Terrain::flat(0.0), law, Smoothing::new(1.0));
    let start = free(&simulator, [0.0, 0.0, 0.061], 0.0, [0.0; 6]);
    let rest = run(&simulator, &start, 2.0);
    let expected = DT / (GRAVITY / 4.0);
    assert!(rest.v.amax() < OTHER_ALGORITHM, "{}", rest.v);
    let height = rest.q[2] - 0.06;
    assert!(
        (height - expected).abs() < 1e-6 * expected,
        "{height:e} not {expected:e}"
    );
}

#[test]
fn derivatives_before_touch_down_are_zero_without_smoothing_and_finite_differences_with_it() {
    for law in laws() {
        let exact = on(asset("sphere.urdf"), Terrain::flat(0.0), law);
        let state = above(&exact, 0.01, -1.0);
        let ballistic = exact.linearize(&state, &[]).a;
        assert_eq!(
            (ballistic[(8, 2)], ballistic[(8, 8)]),
            (0.0, 1.0),
            "{law:?}"
        );
        let simulator = ball(law, 1.0);
        let smooth = simulator.linearize(&state, &[]).a;
        assert!(smooth[(8, 2)] < -1e-3, "{law:?}: {}", smooth[(8, 2)]);
        assert!(smooth[(8, 8)] < 1.0 - 1e-6, "{law:?}: {}", smooth[(8, 8)]);
        let numeric = differences(&simulator, &state, 1e-6);
        for (row, column) in [(8, 2), (8, 8)] {
            let free = ballistic[(row, column)];
            let (a, n) = (smooth[(row, column)] - free, numeric[(row, column)] - free);
            assert!((a - n).abs() < 1e-3 * n.abs(), "{law:?}: {a:e} not {n:e}");
        }
    }
}

#[test]
fn smoothed_jacobians_equal_finite_differences_in_every_mode() {
    for law in laws() {
        let terrain = Terrain::incline(0.1);
        let simulator = smoothed("box.urdf", terrain, law, Smoothing::new(0.1));
        let at = |gap: f64, v| {
            let (sin, cos) = 0.1_f64.sin_cos();
            free(
                &simulator,
                [-sin * (0.06 + gap), 0.0, cos * (0.06 + gap)],
                -0.1,
                v,
            )
        };
        for (name, state) in [
            ("flight", at(0.05, [1.0, 0.4, -0.1, 0.2, 0.1, 0.5])),
            ("sticking", at(-1e-4, [0.0; 6])),
            ("sliding", at(-1e-4, [1.0, 0.4, -1.0, 0.2, 0.1, 0.5])),
            ("landing", at(2e-4, [0.2, 0.1, -1.0, 0.2, 0.1, 0.5])),
        ] {
            let exact = simulator.linearize(&state, &[]).a;
            let numeric = differences(&simulator, &state, 1e-7);
            let error = (&exact - &numeric).amax() / numeric.amax();
            assert!(error < 1e-5, "{law:?} {name}: {error:e}");
        }
    }
}

#[test]
fn smoothed_forces_tend_to_the_exact_ones() {
    for law in laws() {
        let terrain = Terrain::incline(0.1);
        let exact = on(asset("sphere.urdf"), terrain.clone(), law);
        for (height, v) in [(0.01, -1.0), (5e-4, -1.0), (-1e-4, -0.3), (-1e-3, 0.0)] {
            let state = free(
                &exact,
                [
                    -0.1_f64.sin() * (0.1 + height),
                    0.0,
                    0.1_f64.cos() * (0.1 + height),
                ],
                0.0,
                [0.4, 0.1, v, 0.0, 0.0, 0.0],
            );
            let expected = exact.contact_report(&state, &[]).forces[0];
            let error = |kappa| {
                let smoothing = Smoothing::new(kappa);
                let simulator = smoothed("sphere.urdf", terrain.clone(), law, smoothing);
                let report = simulator.contact_report(&state, &[]);
                assert!(
                    report.certificate.is_converged(),
                    "{:?}",
                    report.certificate
                );
                (report.forces[0] - expected).norm()
            };
            let errors = [error(1e-1), error(1e-4), error(1e-8)];
            assert!(
                errors[2] < 1e-3 && errors[2] < errors[1] && errors[1] < errors[0],
                "{law:?} at {height}: {errors:?} beside {expected}"
            );
        }
    }
}

// Within a batch, points that are out of reach in one state take part with those that are not in another.
#[test]
fn smoothed_batch_equals_single_runs() {
    for law in laws() {
        let smoothing = Smoothing::new(0.1).with_reach(0.02);
        let simulator = smoothed("box.urdf", Terrain::incline(0.1), law, smoothing);
        let start = |k: usize| {
            let z = 0.07 + 0.02 * k as f64;
            free(
                &simulator,
                [0.0, 0.0, z],
                0.3,
                [0.1 * k as f64, 0.0, 0.0, 0.0, 0.0, 0.0],
            )
        };
        let starts: Vec<State> = (0..9).map(start).collect();
        let mut batch = BatchSimulator::new(simulator.clone(), 9);
        let rollout = batch.rollout(&starts, 50, |_, _, _| {});
        for (i, start) in starts.iter().enumerate() {
            let alone = run(&simulator, start, 0.05);
            let error = (&rollout.last(i).q - &alone.q).amax();
            assert!(error < 1e3 * SAME_ALGEBRA, "{law:?} {i}: {error:e}");
        }
        let jacobians = batch.linearize(&starts, &[]);
        assert_eq!(jacobians[2], simulator.linearize(&starts[2], &[]));
    }
}

#[test]
fn points_out_of_reach_feel_nothing() {
    for law in laws() {
        let smoothing = Smoothing::new(1.0).with_reach(0.02);
        let simulator = smoothed("sphere.urdf", Terrain::flat(0.0), law, smoothing);
        let force = |height| {
            simulator
                .contact_report(&above(&simulator, height, 0.0), &[])
                .forces[0]
                .z
        };
        assert!(force(0.019) > 0.0 && force(0.021) == 0.0, "{law:?}");
        // A body that it does not reach, but that arrives within the step, is stopped by the exact law's horizon.
        let fast = above(&simulator, 0.03, -100.0);
        let hit = simulator.step(&fast, &[]).v[2];
        assert_eq!(
            hit > -90.0,
            matches!(law, ContactLaw::Rigid(_)),
            "{law:?}: {hit}"
        );
    }
}

// Stops keep their law, so that a joint that nears its end is not pushed before it is there.
#[test]
fn stops_beside_smoothed_contact_keep_their_law() {
    let model = asset("quadruped.urdf");
    let actuation = Actuation::from_model(&model);
    let law = ContactLaw::Rigid(Rigid::default());
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
        .with_links(&model, &["FR_foot", "FL_foot", "RR_foot", "RL_foot"])
        .expect("feet");
    let air = Simulator::new(model)
        .with_actuation(actuation)
        .with_integrator(Integrator::ImplicitVelocity);
    let smoothing = Smoothing::new(1e-2);
    let ground = air
        .clone()
        .with_contacts(contacts.with_smoothing(smoothing));
    let mut state = air.neutral_state();
    // A knee beyond its end, and the feet out of reach.
    state.q[2] = 3.0;
    let input = [0.0; 12];
    let (a, b) = (air.step(&state, &input), ground.step(&state, &input));
    assert!(a.v.amax() > 0.1, "{}", a.v);
    assert!((&a.v - &b.v).amax() < OTHER_ALGORITHM * a.v.amax());
    // The feet above the ground and within reach: forces, derivatives.
    state.q[2] = 0.48;
    let report = ground.contact_report(&state, &input);
    assert!(
        report.certificate.is_converged(),
        "{:?}",
        report.certificate
    );
    assert!(
        report.forces.iter().all(|f| f.z > 0.0),
        "{:?}",
        report.points
    );
    let error = {
        let exact = ground.linearize(&state, &input).a;
        let numeric = differences(&ground, &state, 1e-7);
        (&exact - &numeric).amax() / numeric.amax()
    };
    assert!(error < 1e-5, "{error:e}");
}

#[test]
#[should_panic(expected = "soft contact is smooth from touch-down on")]
fn smoothing_of_soft_contact_is_refused() {
    let law = ContactLaw::Soft(SoftContact::estimate(1.0, 1, 1e-3));
    let _ = ball(law, 1.0);
}

#[test]
#[should_panic(expected = "κ of -1 W is negative or not finite")]
fn negative_smoothing_is_refused() {
    let _ = Smoothing::new(-1.0);
}
