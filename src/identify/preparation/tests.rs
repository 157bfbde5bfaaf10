//! Gaps, derivatives, units and refusals of logs.

use super::*;
use crate::identify::Unit;
use crate::joint::JointKind;
use crate::model::{JointSpec, LinkSpec, ModelBuilder, samples};
use crate::{Simulator, State};
use nalgebra::{DVector, Vector3};

const RATE: f64 = 200.0;

fn polynomial() -> SavitzkyGolay {
    SavitzkyGolay::new(6, 4).unwrap()
}

fn swing(n: usize) -> Vec<f64> {
    (0..n).map(|k| (1.5 * k as f64 / RATE).sin()).collect()
}

fn pendulum(angles: &[f64]) -> Experiment {
    Experiment::at_rate("swing", RATE)
        .with_channel("pivot", Quantity::Position, Unit::Si, angles)
        .with_passive_joint("pivot")
}

fn prepare(experiment: Experiment) -> Result<Dataset, IdentifyError> {
    Preparation::new(polynomial()).prepare(&samples::pendulum(), &[experiment])
}

#[test]
fn gaps_of_samples_and_of_times_part_the_data() {
    let mut angles = swing(400);
    angles[100] = f64::NAN;
    angles[300..305].fill(f64::NAN);
    let data = prepare(pendulum(&angles)).unwrap();
    let lengths: Vec<_> = data.segments.iter().map(Segment::len).collect();
    assert_eq!(lengths, [100 - 12, 199 - 12, 95 - 12]);
    assert_eq!(data.segments.iter().map(Segment::len).sum::<usize>(), 358);
    assert!((data.segments[1].start - (101.0 + 6.0) / RATE).abs() < 1e-12);

    // The same without the samples, at times.
    let kept = |k: &usize| angles[*k].is_finite();
    let times: Vec<f64> = (0..400).filter(kept).map(|k| k as f64 / RATE).collect();
    let values: Vec<f64> = (0..400).filter(kept).map(|k| angles[k]).collect();
    let by_times = Experiment::at_times("swing", &times)
        .with_channel("pivot", Quantity::Position, Unit::Si, &values)
        .with_passive_joint("pivot");
    let same = prepare(by_times).unwrap();
    assert_eq!(same.segments.len(), 3);
    for (a, b) in data.segments.iter().zip(&same.segments) {
        assert!((&a.a - &b.a).amax() < 1e-7 && (a.start - b.start).abs() < 1e-9);
    }
}

#[test]
fn derivatives_of_a_swing_equal_the_closed_form_in_any_unit() {
    let degrees: Vec<f64> = swing(300).iter().map(|x| x.to_degrees()).collect();
    let experiment = Experiment::at_rate("swing", RATE)
        .with_channel("pivot", Quantity::Position, Unit::Degree, &degrees)
        .with_channel("pivot", Quantity::Force, Unit::Scale(2.0), &vec![0.25; 300]);
    let data = prepare(experiment).unwrap();
    let segment = &data.segments[0];
    for k in 0..segment.len() {
        let angle = 1.5 * segment.time(k);
        assert!((segment.q[(0, k)] - angle.sin()).abs() < 1e-9);
        assert!((segment.v[(0, k)] - 1.5 * angle.cos()).abs() < 1e-6);
        assert!((segment.a[(0, k)] + 2.25 * angle.sin()).abs() < 1e-5);
        assert_eq!(segment.tau[(0, k)], 0.5);
    }
}

#[test]
fn wrapped_angles_of_a_continuous_joint_are_unwrapped() {
    let turning: Vec<f64> = (0..300).map(|k| 6.0 * f64::from(k) / RATE).collect();
    let wrapped: Vec<f64> = turning.iter().map(|x| x.sin().atan2(x.cos())).collect();
    let data = prepare(pendulum(&wrapped)).unwrap();
    assert_eq!(data.segments.len(), 1);
    assert!(data.segments[0].v.iter().all(|v| (v - 6.0).abs() < 1e-9));
}

// A free body in flight: its own acceleration is constant in the world, where its angular velocity is that of a precession.
#[test]
fn velocities_and_accelerations_of_a_free_body_equal_those_of_its_simulation() {
    let mut builder = ModelBuilder::new("stone");
    builder.add_link(LinkSpec::new("stone").with_mass(2.0, [0.1, 0.0, -0.05], [0.02, 0.03, 0.04]));
    let model = builder.build().unwrap();
    let simulator = Simulator::new(model.clone())
        .with_time_step(1e-3)
        .with_integrator(crate::Integrator::RungeKutta4);
    let q = model.integrate(model.neutral().as_slice(), &[0.1, 0.2, 0.3, 0.5, -0.4, 0.2]);
    let start = State::new(q.as_slice(), &[1.0, 0.5, 2.0, 2.0, -3.0, 1.0]);
    let flight = simulator.rollout(&start, 400, |_, _, _| {});
    let positions: Vec<f64> = flight
        .states
        .iter()
        .flat_map(|s| s.q.iter().copied())
        .collect();
    let experiment = Experiment::at_rate("flight", 1000.0)
        .with_channel("floating base", Quantity::Position, Unit::Si, &positions)
        .with_passive_joint("floating base");
    let data = Preparation::new(SavitzkyGolay::new(10, 4).unwrap())
        .prepare(&model, &[experiment])
        .unwrap();
    let segment = &data.segments[0];
    for k in 0..segment.len() {
        let state = &flight.states[k + 10];
        let a = crate::dynamics::forward_dynamics(
            &model,
            state.q.as_slice(),
            state.v.as_slice(),
            &[0.0; 6],
        );
        assert!((segment.v.column(k) - &state.v).amax() < 1e-5);
        assert!((segment.a.column(k) - &a).amax() < 5e-3 * a.amax(), "{k}");
        let moved = model.difference(state.q.as_slice(), &segment.q.as_slice()[k * 7..k * 7 + 7]);
        assert!(moved.amax() < 1e-7);
    }
}

#[test]
fn low_pass_and_decimation_keep_a_slow_swing() {
    let preparation = Preparation::new(polynomial())
        .with_low_pass(LowPass {
            order: 3,
            cutoff: 20.0,
        })
        .with_decimation(5);
    let data = preparation
        .prepare(&samples::pendulum(), &[pendulum(&swing(600))])
        .unwrap();
    let segment = &data.segments[0];
    assert_eq!(segment.len(), (600 - 12_usize).div_ceil(5));
    assert_eq!(segment.rate, RATE / 5.0);
    for k in 10..segment.len() - 10 {
        let expected = (1.5 * segment.time(k)).sin();
        assert!((segment.q[(0, k)] - expected).abs() < 1e-5);
    }
}

#[test]
fn rollout_becomes_the_data_that_it_is() {
    let simulator = Simulator::new(samples::cartpole())
        .with_time_step(1e-3)
        .with_actuated_joints(&["linear"])
        .unwrap();
    let rollout = simulator.rollout(&State::new(&[0.0, 0.3], &[0.0; 2]), 100, |t, _, u| u[0] = t);
    let experiment =
        Experiment::from_rollout("push", simulator.model(), &rollout, simulator.actuated());
    let data = Preparation::new(polynomial())
        .prepare(simulator.model(), &[experiment])
        .unwrap();
    let segment = &data.segments[0];
    assert_eq!(segment.len(), 100 - 12);
    let tau: Vec<f64> = segment.tau.column(3).iter().copied().collect();
    assert_eq!(tau.iter().map(|x| (x * 1e9).round()).sum::<f64>(), 9e6);
    assert!((segment.v.column(3) - &rollout.states[9].v).amax() < 1e-6);
}

#[test]
fn broken_data_are_refused_by_name() {
    let angles = swing(100);
    let good = || {
        Experiment::at_rate("swing", RATE).with_channel(
            "pivot",
            Quantity::Position,
            Unit::Si,
            &angles,
        )
    };
    let with = |mut broken: Vec<f64>, at: usize, x: f64| {
        broken[at] = x;
        broken
    };
    let times: Vec<f64> = (0..100).map(|k| k as f64 / RATE).collect();
    let cases = [
        (good(), "no force of \"pivot\""),
        (
            good().with_passive_joint("pivto"),
            "no joint with coordinates of its own \"pivto\"",
        ),
        (
            good().with_passive_joint("pivot").with_channel(
                "pivot",
                Quantity::Force,
                Unit::Si,
                &angles,
            ),
            "passive",
        ),
        (
            good().with_channel("pivot", Quantity::Force, Unit::Si, &angles[1..]),
            "99 numbers, 1 a sample, and 100 samples of the position",
        ),
        (
            good().with_channel("pivot", Quantity::Force, Unit::Degree, &angles),
            "force of \"pivot\": Degree is not a unit of force",
        ),
        (
            good().with_channel("pivot", Quantity::Position, Unit::Si, &angles),
            "there are two of them",
        ),
        (
            pendulum(&with(angles.clone(), 7, f64::INFINITY)),
            "number 7 is inf",
        ),
        (
            pendulum(&angles[..10]),
            "of its 10 samples at most 10 follow each other",
        ),
        (pendulum(&[]), "of its 0 samples"),
        (
            Experiment::at_rate("swing", 0.0)
                .with_channel("pivot", Quantity::Position, Unit::Si, &angles)
                .with_passive_joint("pivot"),
            "0 samples a second",
        ),
        (
            Experiment::at_times("swing", &with(times.clone(), 50, 0.247))
                .with_channel("pivot", Quantity::Position, Unit::Si, &angles)
                .with_passive_joint("pivot"),
            "sample 50 comes",
        ),
        (
            Experiment::at_times("swing", &vec![1.0; 100])
                .with_channel("pivot", Quantity::Position, Unit::Si, &angles)
                .with_passive_joint("pivot"),
            "sample 1 comes 0 s after",
        ),
    ];
    for (experiment, expected) in cases {
        let error = prepare(experiment).unwrap_err().to_string();
        assert!(
            error.contains(expected),
            "{error}\ndoes not say: {expected}"
        );
        assert!(
            error.contains("swing") || error.contains("pivto"),
            "{error}"
        );
    }
}

#[test]
fn quaternions_that_are_none_and_low_passes_of_them_are_refused() {
    let mut builder = ModelBuilder::new("ball");
    builder
        .add_link(LinkSpec::new("world"))
        .add_link(LinkSpec::new("ball").with_mass(1.0, [0.0; 3], [1.0; 3]));
    builder.add_joint(JointSpec::new(
        "socket",
        JointKind::Spherical,
        "world",
        "ball",
    ));
    let model = builder.build().unwrap();
    let turn = |speed: f64| -> Vec<f64> {
        let q = |k: usize| {
            let phi = Vector3::new(0.0, 0.0, speed * k as f64 / RATE);
            model.integrate(model.neutral().as_slice(), phi.as_slice())
        };
        (0..50).flat_map(|k| q(k).as_slice().to_vec()).collect()
    };
    let of = |values: &[f64]| {
        Experiment::at_rate("spin", RATE)
            .with_channel("socket", Quantity::Position, Unit::Si, values)
            .with_passive_joint("socket")
    };
    let data = Preparation::new(polynomial())
        .prepare(&model, &[of(&turn(3.0))])
        .unwrap();
    let expected = DVector::from_column_slice(&[0.0, 0.0, 3.0]);
    assert!((data.segments[0].v.column(0) - expected).amax() < 1e-9);
    let halves: Vec<f64> = turn(3.0).iter().map(|x| 0.5 * x).collect();
    let error = Preparation::new(polynomial())
        .prepare(&model, &[of(&halves)])
        .unwrap_err();
    assert!(error.to_string().contains("the norm 0.5"), "{error}");
    let low = Preparation::new(polynomial()).with_low_pass(LowPass {
        order: 2,
        cutoff: 5.0,
    });
    assert!(low.prepare(&model, &[of(&turn(3.0))]).is_err());
}
