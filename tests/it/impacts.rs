//! Impacts in soft contact: restitution, gradients through them, and remarks on steps that do not resolve them.

use dualbody::contact::{ContactLaw, HuntCrossley, SoftContact, Terrain};
use dualbody::linearize::RolloutCost;
use dualbody::{Integrator, Scalar, Simulator, State};
use nalgebra::{DVector, Vector3};

use crate::common::asset;
use crate::common::ground::on;

const SPEED: f64 = 2.0;
const RESTITUTION: f64 = 0.6;

/// A ball of 1 kg and 0.1 m, without gravity.
fn ball(law: SoftContact, dt: f64) -> Simulator {
    let ball = asset("sphere.urdf").with_gravity(Vector3::zeros());
    on(ball, Terrain::flat(0.0), ContactLaw::Soft(law)).with_time_step(dt)
}

/// It comes down to the ground from a height of its centre.
fn falling(simulator: &Simulator, height: f64) -> State {
    let mut state = simulator.neutral_state();
    state.q[2] = height;
    state.v[2] = -SPEED;
    state
}

/// Height at the end.
struct Height;

impl RolloutCost for Height {
    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        last.q[2]
    }
}

// A ball that starts higher arrives later: h(T) falls by e for each metre.
#[test]
fn gradient_through_an_impact_is_that_of_the_motion() {
    let law = SoftContact::estimate(1.0, 1, 0.01).with_restitution(RESTITUTION, SPEED);
    let simulator = ball(law, 1e-3);
    // The contact lasts some fifty steps.
    let lasts = law.normal.impact_time(1.0, SPEED);
    assert!((40e-3..60e-3).contains(&lasts), "{lasts}");
    let slopes: Vec<f64> = (0..11)
        .map(|k| {
            let start = falling(&simulator, 1.0 + 1.37e-3 * f64::from(k));
            let inputs = vec![DVector::zeros(0); 1000];
            let found = simulator.rollout_gradient(&start, &inputs, &Height);
            let speed = found.last.v[2];
            assert!((speed - RESTITUTION * SPEED).abs() < 2e-3, "{speed}");
            found.start[2]
        })
        .collect();
    let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
    assert!((mean + RESTITUTION).abs() < 1e-3, "{mean}");
    for slope in slopes {
        assert!((slope + RESTITUTION).abs() < 5e-3, "{slope}");
    }
}

// The force at touch-down, and its slope, are those of no contact.
#[test]
fn derivatives_of_a_step_at_touch_down_are_those_of_free_motion() {
    for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
        let law = SoftContact::estimate(1.0, 1, 1e-3);
        let simulator = ball(law, 1e-3).with_integrator(integrator);
        let a = |height: f64| {
            let mut state = falling(&simulator, height);
            state.v[2] = -1e-9;
            // Of pose and velocity: a bristle straightens without contact, and bends with it.
            let a = simulator.linearize(&state, &[]).a;
            a.view((0, 0), (12, 12)).into_owned()
        };
        let (above, below) = (a(0.1 + 1e-6), a(0.1 - 1e-12));
        assert!((above - below).amax() < 1e-3, "{integrator:?}");
    }
}

#[test]
fn steps_too_long_for_soft_contact_are_remarked_and_shorter_ones_are_not() {
    let law = SoftContact::estimate(1.0, 1, 1e-3);
    let said = |simulator: &Simulator| {
        let remarks = simulator.remarks(simulator.model().neutral().as_slice());
        remarks.first().map(ToString::to_string)
    };
    let long = said(&ball(law, 5e-3)).expect("a remark");
    let expected = "steps of 0.005 s are too long for soft contact of \"sphere\"";
    assert!(long.starts_with(expected), "{long}");
    assert_eq!(said(&ball(law, 2e-4)), None);
    let implicit = |dt| ball(law, dt).with_integrator(Integrator::ImplicitVelocity);
    let short = said(&implicit(5e-3)).expect("a remark");
    assert!(short.contains("steps"), "{short}");
    assert_eq!(said(&implicit(5e-4)), None);
    assert_eq!(said(&Simulator::new(asset("sphere.urdf"))), None);
}

// A step of the longest length that is stable stays bounded, one of four times that does not: a linear spring and damper, pressed on the ground by gravity.
#[test]
fn longest_step_of_a_remark_is_where_semi_implicit_euler_becomes_unstable() {
    let law = SoftContact {
        normal: HuntCrossley::linear(1e4, 60.0),
        friction: 0.0,
    };
    let simulator = |dt| {
        on(
            asset("sphere.urdf"),
            Terrain::flat(0.0),
            ContactLaw::Soft(law),
        )
        .with_time_step(dt)
    };
    // Δt² K + 2 Δt D = 4 m
    let longest = (-60.0 + (3600.0 + 4e4_f64).sqrt()) / 1e4;
    let remarks = |dt| {
        let simulator = simulator(dt);
        simulator.remarks(simulator.model().neutral().as_slice())
    };
    assert!(remarks(0.999 * longest).is_empty());
    assert_eq!(remarks(1.001 * longest).len(), 1);
    let moved = |dt| {
        let simulator = simulator(dt);
        let mut start = simulator.neutral_state();
        start.q[2] = 0.1 - 9.81 / 1e4 + 1e-6;
        let rollout = simulator.rollout(&start, 200, |_, _, _| {});
        (rollout.last().q[2] - (0.1 - 9.81 / 1e4)).abs()
    };
    assert!(moved(0.95 * longest) < 2e-6);
    assert!(moved(1.05 * longest) > 1e-5);
}
