//! Robots with known numbers, identified.

use nalgebra::{DMatrix, DVector};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use super::*;
use crate::joint::JointKind;
use crate::model::{BodyId, JointSpec, LinkSpec, Model, ModelBuilder, samples};

pub(super) fn rng(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

/// A normally distributed number, by Box and Muller.
pub(super) fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
    let (u, w): (f64, f64) = (
        rng.random_range(f64::EPSILON..1.0),
        rng.random_range(0.0..1.0),
    );
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * w).cos()
}

const SMOOTH: DryFriction = DryFriction::Smooth {
    slip_velocity: 0.05,
};

/// Rotors and dampers on all joints.
fn dressed(mut model: Model) -> Model {
    for k in 0..model.nv() {
        model = model
            .with_damping(k, 0.5 + 0.1 * k as f64)
            .with_armature(k, 0.05 + 0.01 * k as f64);
    }
    model
}

/// The robot itself, with dry friction.
fn truth(model: &Model, shape: DryFriction) -> Robot {
    Robot {
        model: model.clone(),
        shape: Some(shape),
        dry_friction: (0..model.nv()).map(|k| 0.3 + 0.1 * k as f64).collect(),
        offsets: vec![0.0; model.nv()],
    }
}

/// Samples of random motions, and the forces of a robot with errors of these standard deviations.
pub(super) fn random_segment(
    robot: &Robot,
    samples: usize,
    deviations: &[f64],
    seed: u64,
) -> Segment {
    let (model, mut rng) = (&robot.model, rng(seed));
    let mut out = Segment {
        experiment: "random".into(),
        start: 0.0,
        rate: 1000.0,
        q: DMatrix::zeros(model.nq(), samples),
        v: DMatrix::zeros(model.nv(), samples),
        a: DMatrix::zeros(model.nv(), samples),
        tau: DMatrix::zeros(model.nv(), samples),
    };
    for k in 0..samples {
        out.q.set_column(k, &model.random_configuration(&mut rng));
        let mut vector =
            |size: f64| DVector::from_fn(model.nv(), |_, _| rng.random_range(-size..size));
        let (v, a) = (vector(2.0), vector(5.0));
        let tau = robot.predict(out.q.column(k).as_slice(), v.as_slice(), a.as_slice());
        let error = DVector::from_fn(model.nv(), |i, _| deviations[i] * normal(&mut rng));
        out.v.set_column(k, &v);
        out.a.set_column(k, &a);
        out.tau.set_column(k, &(tau + error));
    }
    out
}

fn everything(model: &Model, shape: DryFriction) -> Regressor {
    Regressor::new(model)
        .with_damping()
        .with_armature()
        .with_dry_friction(shape)
        .unwrap()
        .with_offsets()
}

/// Values of the unknowns of a robot.
fn values(regressor: &Regressor, robot: &Robot) -> DVector<f64> {
    let of = |(unknown, nominal): (&Unknown, &f64)| match *unknown {
        Unknown::DryFriction(k) => robot.dry_friction[k],
        Unknown::Offset(k) => robot.offsets[k],
        _ => *nominal,
    };
    let all = regressor.unknowns().iter().zip(regressor.nominal()).map(of);
    DVector::from_vec(all.collect())
}

#[test]
fn regressor_times_values_equals_inverse_dynamics_with_everything() {
    for model in [dressed(samples::arm()), samples::random_tree(10, 4)] {
        let robot = truth(&model, SMOOTH);
        let regressor = everything(&model, SMOOTH);
        let segment = random_segment(&robot, 5, &vec![0.0; model.nv()], 3);
        let x = values(&regressor, &robot);
        // Springs are known; these robots have none.
        for k in 0..segment.len() {
            let column = |m: &DMatrix<f64>| m.column(k).iter().copied().collect::<Vec<_>>();
            let y = regressor.matrix(
                &column(&segment.q),
                &column(&segment.v),
                &column(&segment.a),
            );
            let tau = segment.tau.column(k);
            let error = (y * &x - tau).amax() / (1.0 + tau.amax());
            assert!(error < 1e-12, "{}: {error}", model.name());
        }
        assert!((robot.predict_segment(&segment) - &segment.tau).amax() < 1e-10);
    }
}

// Serial arms: 7 for each revolute joint, less 4 of the first and 2 for its axis along gravity, where frames are in general position
// [Gautier 1991]: 36 for six joints, 43 for the seven of a KUKA LWR. A free body has 10, a revolute joint after it 7 more.
#[test]
fn numbers_of_base_parameters_equal_those_of_the_literature() {
    let count = |model: &Model| BaseParameters::new(&Regressor::new(model)).len();
    assert_eq!(count(&samples::pendulum()), 3);
    assert_eq!(count(&samples::arm()), 43);
    let mut builder = ModelBuilder::new("free");
    builder.add_link(LinkSpec::new("base").with_mass(2.0, [0.1; 3], [0.1; 3]));
    for (name, parent, axis) in [("a", "base", [1.0, 0.0, 0.0]), ("b", "a", [0.0, 0.6, 0.8])] {
        builder.add_link(LinkSpec::new(name).with_mass(1.0, [0.1; 3], [0.1; 3]));
        let joint = JointSpec::new(format!("joint_{name}"), JointKind::Revolute, parent, name);
        builder.add_joint(joint.with_axis(axis).with_translation([0.1, 0.2, 0.3]));
    }
    assert_eq!(count(&builder.build().unwrap()), 24);
}

#[test]
fn robots_with_equal_base_parameters_have_equal_forces() {
    let model = dressed(samples::arm());
    let regressor = everything(&model, SMOOTH);
    let base = BaseParameters::new(&regressor);
    let mut rng = rng(8);
    let mut random = || {
        DVector::from_fn(regressor.unknowns().len(), |_, _| {
            rng.random_range(-1.0..1.0)
        })
    };
    let (x, other) = (random(), random());
    let twin = base.unknowns(&base.of(&x), &other);
    assert!((base.of(&twin) - base.of(&x)).amax() < 1e-12);
    assert!((&x - &twin).amax() > 0.1);
    let segment = random_segment(&truth(&model, SMOOTH), 20, &[0.0; 7], 5);
    let forces = [&x, &twin].map(|x| Robot::of(&regressor, x).predict_segment(&segment));
    let error = (&forces[0] - &forces[1]).amax() / forces[0].amax();
    assert!(error < 1e-11, "{error}");
}

// Two rods of 1 m that swing about parallel axes: the first carries the mass of the second at its tip.
#[test]
fn meaning_of_base_parameters_equals_the_mechanics_of_a_double_pendulum() {
    let regressor = Regressor::new(&samples::double_pendulum());
    let base = BaseParameters::new(&regressor);
    let meanings: Vec<String> = (0..base.len()).map(|k| base.meaning(k)).collect();
    // J + m l² and h + m l with l = 1 m; the body's x axis is along the rod, z about the joint.
    assert!(
        meanings.contains(&"upper: Jzz + lower: mass".to_owned()),
        "{meanings:?}"
    );
    assert!(meanings.contains(&"lower: Jzz".to_owned()), "{meanings:?}");
    let first = meanings
        .iter()
        .find(|own| own.starts_with("upper: h") && own.contains("lower: mass"));
    assert!(first.is_some(), "{meanings:?}");
    let text = base.to_string();
    assert!(
        text.contains("no force depends on:") && text.contains("upper: Jxy"),
        "{text}"
    );
}

#[test]
fn forces_without_errors_give_back_the_base_parameters() {
    for model in [
        samples::pendulum(),
        dressed(samples::cartpole()),
        dressed(samples::arm()),
        samples::random_tree(9, 7),
    ] {
        for shape in [SMOOTH, DryFriction::Sign { dead_zone: 0.02 }] {
            let robot = truth(&model, shape);
            let mut named = robot.clone();
            let regressor = everything(&model, shape);
            let is_named = |k: usize| regressor.unknowns().contains(&Unknown::Offset(k));
            (0..model.nv())
                .filter(|&k| !is_named(k))
                .for_each(|k| named.dry_friction[k] = 0.0);
            let segment = random_segment(&named, 600, &vec![0.0; model.nv()], 1);
            let found = estimate(&regressor, &Dataset::new(vec![segment])).unwrap();
            let expected = found.base.of(&values(&regressor, &named));
            for (k, expected) in expected.iter().enumerate() {
                let error = (found.values[k] - expected).abs() / (1.0 + expected.abs());
                assert!(
                    error < 1e-8,
                    "{}: {}: {error}",
                    model.name(),
                    found.base.meaning(k)
                );
            }
        }
    }
}

fn deviations() -> Vec<f64> {
    vec![0.5, 0.4, 0.3, 0.2, 0.1, 0.05, 0.02]
}

#[test]
fn intervals_hold_the_truth_as_often_as_they_say_and_weights_equal_the_errors() {
    const SEEDS: u64 = 40;
    let model = dressed(samples::arm());
    let (robot, regressor) = (truth(&model, SMOOTH), everything(&model, SMOOTH));
    let (mut inside, mut all) = (0, 0);
    for seed in 0..SEEDS {
        let data = Dataset::new(vec![random_segment(&robot, 200, &deviations(), 100 + seed)]);
        let found = estimate(&regressor, &data).unwrap();
        let expected = found.base.of(&values(&regressor, &robot));
        let intervals = found.intervals(0.95);
        inside += intervals
            .iter()
            .zip(&expected)
            .filter(|(own, x)| (own.lower..=own.upper).contains(*x))
            .count();
        all += intervals.len();
        for (found, expected) in found.force_deviations.iter().zip(deviations()) {
            // Of 200 samples: 5 % standard deviation.
            assert!((found / expected - 1.0).abs() < 0.25, "{found} {expected}");
        }
    }
    let share = inside as f64 / all as f64;
    assert!(
        (share - 0.95).abs() < 0.02,
        "{share} of {all} intervals hold the truth"
    );
}

#[test]
fn validation_on_other_data_finds_the_errors_of_the_measurement() {
    let model = dressed(samples::arm());
    let (robot, regressor) = (truth(&model, SMOOTH), everything(&model, SMOOTH));
    let learn = Dataset::new(vec![random_segment(&robot, 4000, &deviations(), 1)]);
    let held = Dataset::new(vec![random_segment(&robot, 4000, &deviations(), 2)]);
    let found = estimate(&regressor, &learn).unwrap();
    let consistent = found.consistent(&ConsistencyOptions::default()).unwrap();
    let floor = robot.validate(&held).unwrap();
    for robot in [found.robot(), consistent.robot] {
        let check = robot.validate(&held).unwrap();
        for (own, floor) in check.coordinates.iter().zip(&floor.coordinates) {
            assert!(own.rms < 1.02 * floor.rms, "{own:?} against {floor:?}");
        }
    }
}

#[test]
fn estimate_of_no_body_becomes_one_of_bodies_at_hardly_any_cost() {
    let model = dressed(samples::arm());
    let (robot, regressor) = (truth(&model, SMOOTH), everything(&model, SMOOTH));
    // The nominal robot is another one.
    let scaled = model.scaled(1.0, 1.4).unwrap();
    let nominal = everything(&dressed(scaled), SMOOTH);
    for seed in 0..3 {
        let data = Dataset::new(vec![random_segment(&robot, 150, &deviations(), seed)]);
        let found = estimate(&nominal, &data).unwrap();
        assert_ne!(found.robot().model.inertia_flaws(), [], "nothing to mend");
        let mended = found.consistent(&ConsistencyOptions::default()).unwrap();
        assert_eq!(mended.robot.model.inertia_flaws(), [], "{seed}");
        assert!(mended.robot.dry_friction.iter().all(|&f| f >= 0.0));
        assert!(mended.robot.model.armature().iter().all(|&x| x >= 0.0));
        // As far as chance goes: the truth itself is physically consistent, at a distance of χ² of as many degrees.
        let truth = found.base.of(&values(&regressor, &robot)) - &found.values;
        let distance = truth.dot(&(&found.information * &truth));
        assert!(
            mended.excess < 1.02 * distance + 0.1,
            "{} {distance}",
            mended.excess
        );
    }
}

#[test]
fn data_and_options_of_no_use_are_refused_by_name() {
    let model = samples::arm();
    let (robot, regressor) = (truth(&model, SMOOTH), everything(&model, SMOOTH));
    let says = |error: IdentifyError, expected: &str| {
        let text = error.to_string();
        assert!(text.contains(expected), "{text}\ndoes not say: {expected}");
    };
    let segment = random_segment(&robot, 5, &deviations(), 1);
    says(
        estimate(&regressor, &Dataset::new(vec![segment])).unwrap_err(),
        "35 equations for",
    );
    says(
        estimate(&regressor, &Dataset::default()).unwrap_err(),
        "0 equations for",
    );
    let other = random_segment(&truth(&samples::pendulum(), SMOOTH), 5, &[0.0], 1);
    says(
        estimate(&regressor, &Dataset::new(vec![other])).unwrap_err(),
        "configurations of 1 numbers, and \"arm\" has 7",
    );
    let mut broken = random_segment(&robot, 50, &deviations(), 1);
    broken.tau[(3, 7)] = f64::NAN;
    says(
        estimate(&regressor, &Dataset::new(vec![broken])).unwrap_err(),
        "force: number 3 of sample 7 is NaN",
    );
    let mut still = random_segment(&robot, 100, &deviations(), 1);
    still.v.row_mut(4).fill(0.0);
    says(
        estimate(&regressor, &Dataset::new(vec![still])).unwrap_err(),
        "joint5: damping",
    );
    says(
        Regressor::new(&model)
            .with_known_links(&["link9"])
            .unwrap_err(),
        "link9",
    );
    let friction = DryFriction::Smooth { slip_velocity: 0.0 };
    says(
        Regressor::new(&model)
            .with_dry_friction(friction)
            .unwrap_err(),
        "slip velocity of dry friction: 0",
    );
    let data = Dataset::new(vec![random_segment(&robot, 200, &deviations(), 1)]);
    let options = ConsistencyOptions {
        regularization: -1.0,
        ..Default::default()
    };
    says(
        estimate(&regressor, &data)
            .unwrap()
            .consistent(&options)
            .unwrap_err(),
        "regularization: -1",
    );
}

#[test]
fn friction_in_a_simulator_equals_that_of_the_prediction() {
    let robot = truth(&samples::arm(), SMOOTH);
    let actuation = robot.actuation(&crate::sim::Actuation::ideal(&robot.model));
    for (actuator, force) in actuation.actuators().iter().zip(&robot.dry_friction) {
        for v in [-1.0, 0.0, 0.03] {
            let expected = 1.0 - force * SMOOTH.shape(v);
            assert!((actuator.force(0.0, v, 1.0) - expected).abs() < 1e-14);
        }
    }
}

#[test]
fn known_links_keep_their_inertia() {
    let model = samples::arm();
    let robot = Robot {
        shape: None,
        ..truth(&model, SMOOTH)
    };
    let regressor = Regressor::new(&model)
        .with_known_links(&["link1", "link2", "link3", "link4", "link5"])
        .unwrap();
    assert_eq!(regressor.unknowns().len(), 20);
    let data = Dataset::new(vec![random_segment(&robot, 100, &[0.0; 7], 1)]);
    let found = estimate(&regressor, &data).unwrap();
    let expected = found.base.of(regressor.nominal());
    assert!((&found.values - expected).amax() < 1e-9);
    let kept = found.robot().model.body(BodyId(2)).inertia;
    assert_eq!(kept, model.body(BodyId(2)).inertia);
}

#[test]
fn report_says_what_was_found() {
    let model = dressed(samples::arm());
    let (robot, regressor) = (truth(&model, SMOOTH), everything(&model, SMOOTH));
    let data = Dataset::new(vec![random_segment(&robot, 1000, &deviations(), 1)]);
    let (learn, held) = data.hold_back(0.25);
    let count = |data: &Dataset| data.segments.iter().map(Segment::len).sum::<usize>();
    assert_eq!((count(&learn), count(&held)), (750, 250));
    let found = estimate(&regressor, &learn).unwrap();
    let mended = found.consistent(&ConsistencyOptions::default()).unwrap();
    let report = Report::new(&found, &mended.robot, &held, 0.95).unwrap();
    let text = report.to_string();
    for part in [
        "arm: ",
        "joint7: dry friction",
        "all inertias are physically consistent",
        "± half the interval of 95 %",
    ] {
        assert!(text.contains(part), "{text}");
    }
    assert_eq!(report.traces[0].times.len(), 250);
    assert!((report.traces[0].times[0] - 0.75).abs() < 1e-9);
}
