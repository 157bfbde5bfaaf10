//! The step that is implicit in velocity against closed forms: stiff damping, friction, stops and soft contact at any
//! step.

use dualbody::cone::Mode;
use dualbody::contact::{ContactLaw, HuntCrossley, SoftContact, Terrain};
use dualbody::joint::JointKind;
use dualbody::model::{JointSpec, LinkSpec, Model, ModelBuilder, samples};
use dualbody::sim::{Actuation, Actuator, CoulombFriction, PositionLimits, VelocityLimit};
use dualbody::spatial::Quaternion;
use dualbody::{Integrator, Simulator, State};
use nalgebra::{Vector3, vector};

use crate::common::ground::{self, differences, free};
use crate::common::quadruped::{crouching, on_feet};
use crate::common::{SAME_ALGEBRA, asset, random_point};

/// A carriage of 2 kg on a horizontal rail, with a damper and a spring.
fn carriage(damping: f64, stiffness: f64) -> Model {
    let mut builder = ModelBuilder::new("carriage");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("carriage").with_mass(2.0, [0.0; 3], [1.0; 3]));
    builder.add_joint(
        JointSpec::new("rail", JointKind::Prismatic, "world", "carriage")
            .with_axis([1.0, 0.0, 0.0])
            .with_damping(damping)
            .with_spring(stiffness, 0.0),
    );
    builder.build().expect("a robot that is known to be right")
}

fn implicit(model: Model, dt: f64) -> Simulator {
    Simulator::new(model)
        .with_integrator(Integrator::ImplicitVelocity)
        .with_time_step(dt)
}

#[test]
fn damper_and_spring_are_those_of_implicit_euler() {
    // m (v⁺ − v) / Δt = −d v⁺ − k (q + Δt v⁺) + u
    for (d, k, dt) in [
        (3.0, 0.0, 0.01),
        (1e5, 0.0, 0.1),
        (2.0, 1e6, 0.1),
        (0.0, 50.0, 0.02),
    ] {
        let simulator = implicit(carriage(d, k), dt);
        let next = simulator.step(&State::new(&[0.3], &[-1.2]), &[4.0]);
        let expected = (2.0 * -1.2 + dt * (4.0 - k * 0.3)) / (2.0 + dt * d + dt * dt * k);
        assert!((next.v[0] - expected).abs() < SAME_ALGEBRA * expected.abs().max(1.0));
        assert!((next.q[0] - (0.3 + dt * next.v[0])).abs() < SAME_ALGEBRA);
    }
}

#[test]
fn without_anything_stiff_it_is_semi_implicit_euler_from_rest() {
    for robot in [
        samples::arm(),
        samples::cartpole(),
        crate::common::free_body(),
    ] {
        let point = random_point(&robot, 3);
        let state = State::new(point.q.as_slice(), &vec![0.0; robot.nv()]);
        let explicit = Simulator::new(robot.clone());
        let u = vec![0.3; explicit.nu()];
        let (one, two) = (
            explicit.step(&state, &u),
            implicit(robot, 1e-3).step(&state, &u),
        );
        assert!(two.deviation(explicit.model(), &one).amax() < SAME_ALGEBRA);
    }
}

#[test]
fn friction_and_speed_limit_of_any_strength_bring_to_rest_and_no_further() {
    let model = carriage(0.0, 0.0);
    let strong = Actuator {
        friction: Some(CoulombFriction::smoothed(30.0, 1e-6)),
        velocity: Some(VelocityLimit {
            speed: 1.0,
            damping: 1e8,
        }),
        ..Actuator::default()
    };
    let actuation = Actuation::ideal(&model)
        .with_actuator(&model, "rail", strong)
        .expect("a joint");
    let simulator = implicit(model, 0.01).with_actuation(actuation);
    let mut state = State::new(&[0.0], &[3.0]);
    let mut last = 3.0;
    for k in 0..200 {
        state = simulator.step(&state, &[5.0]);
        assert!(
            state.v[0] <= last && state.v[0] >= 0.0,
            "step {k}: {}",
            state.v[0]
        );
        last = state.v[0];
        assert!(k < 1 || last < 1.0 + 1e-6, "step {k}: {last}");
    }
    // Held, it creeps by v_s τ / √(f² − τ²).
    assert!(last < 2e-7, "{last:e}");
}

/// A stop that is far too stiff for the step to resolve.
fn stopped(stiffness: f64, dt: f64) -> Simulator {
    let model = carriage(0.0, 0.0);
    let stop = HuntCrossley {
        stiffness,
        damping: 1e-2 * stiffness,
        stiffness_exponent: 0.0,
        damping_exponent: 0.0,
    };
    let ends = PositionLimits {
        lower: Some(-1.0),
        upper: Some(1.0),
        stop,
    };
    let actuator = Actuator {
        position: Some(ends),
        ..Actuator::default()
    };
    let actuation = Actuation::ideal(&model)
        .with_actuator(&model, "rail", actuator)
        .expect("a joint");
    implicit(model, dt).with_actuation(actuation)
}

#[test]
fn stops_of_any_stiffness_hold_from_both_sides_never_pull_and_never_add_energy() {
    for stiffness in [1e3, 1e6, 1e12] {
        for side in [1.0, -1.0] {
            let simulator = stopped(stiffness, 0.01);
            let mut state = State::new(&[0.9 * side], &[2.0 * side]);
            let stored = |s: &State| {
                let depth = (s.q[0].abs() - 1.0).max(0.0);
                s.v[0] * s.v[0] + 0.5 * stiffness * depth * depth
            };
            for _ in 0..300 {
                let next = simulator.step(&state, &[0.0]);
                let change = (next.v[0] - state.v[0]) * side;
                let pulled = change > 0.0 && state.q[0] * side > 0.0;
                assert!(!pulled, "outwards: {change:e}");
                let (before, after) = (stored(&state), stored(&next));
                assert!(after <= before * (1.0 + 1e-12), "{before} becomes {after}");
                state = next;
            }
            // Driven against it, it rests at the depth at which the stop carries the force.
            let driven = simulator.rollout(&state, 3000, |_, _, u| u[0] = 8.0 * side);
            let last = driven.last();
            assert!(
                (last.q[0] * side - 1.0 - 8.0 / stiffness).abs() < 1e-6,
                "{}",
                last.q[0]
            );
            assert!(last.v[0].abs() < 1e-6);
        }
    }
}

fn soft(mu: f64) -> SoftContact {
    SoftContact {
        friction: mu,
        ..ground::square_root_law(1.0, 4, 1e-3)
    }
}

fn on(model: Model, terrain: Terrain, law: SoftContact) -> Simulator {
    ground::on(model, terrain, ContactLaw::Soft(law)).with_integrator(Integrator::ImplicitVelocity)
}

// The law at the end of the step: f_n = max(0, K δᵖ (δ + Δt δ̇⁺) + D δ^q δ̇⁺), and the bristle's force within its cone.
#[test]
fn forces_are_those_of_the_law_at_the_end_of_the_step() {
    let law = soft(0.4);
    let simulator = on(asset("box.urdf"), Terrain::flat(0.0), law).with_time_step(5e-3);
    for (v, mode) in [
        ([0.01, 0.0, 0.0], Mode::Sticking),
        ([1.0, 0.4, -0.1], Mode::Sliding),
        ([0.0, 0.0, 3.0], Mode::Separated),
    ] {
        let mut start = free(
            &simulator,
            [0.0, 0.0, 0.058],
            0.0,
            [v[0], v[1], v[2], 0.0, 0.0, 0.0],
        );
        start.contact.fill(1e-5);
        let (report, next) = (
            simulator.contact_report(&start, &[]),
            simulator.step(&start, &[]),
        );
        // The velocity after the step in the axes of before it.
        let dt = simulator.time_step();
        let turn = Quaternion::exp(&(next.v.fixed_rows::<3>(3) * dt)).to_matrix();
        let mut v = next.v.clone();
        v.rows_mut(0, 3)
            .copy_from(&(turn * next.v.fixed_rows::<3>(0)));
        let contacts = simulator.contacts().expect("contacts");
        let at_end = contacts.states(simulator.model(), start.q.as_slice(), v.as_slice());
        for (i, (point, force)) in report.points.iter().zip(&report.forces).enumerate() {
            if point.depth <= 0.0 {
                assert_eq!(force.norm(), 0.0);
                continue;
            }
            assert_eq!(report.modes[i], mode);
            let v_end = at_end[i].velocity;
            let ahead = point.depth - dt * point.velocity.z;
            let spring = law.normal.stiffness * ahead.max(0.0).sqrt();
            let damper = law.normal.damping * point.depth.sqrt();
            let normal = (spring * (point.depth - dt * v_end.z) - damper * v_end.z).max(0.0);
            assert!(
                (force.z - normal).abs() < 1e-6 * normal.max(1.0),
                "{} not {normal}",
                force.z
            );
            let m = Vector3::new(1e-5, 1e-5, 0.0);
            let across = vector![v_end.x, v_end.y, 0.0];
            let wanted = -(m + across * dt) * spring - across * damper;
            let allowed = (0.4 * normal / wanted.norm()).min(1.0);
            let apart = (force.xy() - wanted.xy() * allowed).norm();
            assert!(apart < 1e-6 * normal.max(1.0), "{mode:?}: {apart:e}");
        }
    }
}

#[test]
fn box_sticks_on_an_incline_if_and_only_if_its_slope_is_below_friction() {
    for (slope, mu) in [(0.28_f64, 0.3), (0.32, 0.3), (0.7, 0.6)] {
        for dt in [1e-3, 5e-3] {
            let terrain = Terrain::incline(slope.atan());
            let simulator = on(asset("box.urdf"), terrain, soft(mu)).with_time_step(dt);
            ground::assert_sticks_or_slides(&simulator, slope, mu);
        }
    }
}

#[test]
fn contact_far_stiffer_than_the_step_resolves_comes_to_rest_and_loses_energy() {
    let hard = ground::square_root_law(1.0, 4, 1e-5);
    let simulator = on(asset("box.urdf"), Terrain::flat(0.0), hard).with_time_step(2e-3);
    let start = free(
        &simulator,
        [0.0, 0.0, 0.3],
        0.7,
        [1.0, 0.5, 0.0, 2.0, 3.0, -1.0],
    );
    let energy = |s: &State| ground::energy(simulator.model(), s);
    let states = simulator.rollout(&start, 2500, |_, _, _| {}).states;
    let mut last = energy(&states[0]);
    for (k, state) in states.iter().enumerate() {
        let now = energy(state);
        // A turn moves a corner by ½ ω² l Δt² off its line, and the next step puts it back to the surface at once.
        assert!(now < last + 3e-4, "step {k}: {last} becomes {now}");
        last = now;
    }
    let rest = states.last().expect("states");
    assert!(rest.v.amax() < 1e-6, "{}", rest.v);
}

#[test]
fn quadruped_on_light_feet_stands_at_steps_that_are_too_long_for_others() {
    let model = asset("quadruped.urdf");
    let law = ContactLaw::Soft(SoftContact::estimate(model.total_mass(), 4, 2e-3));
    let contacts = on_feet(&model, Terrain::flat(0.0), law);
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(2e-3);
    let start = crouching(&simulator, 0.4);
    let last = |integrator| {
        let simulator = simulator.clone().with_integrator(integrator);
        let wanted = start.q.rows(7, 12).into_owned();
        let caught = simulator.rollout(&start, 3000, |_, state, u| {
            for k in 0..12 {
                u[k] = 60.0 * (wanted[k] - state.q[7 + k]) - 2.0 * state.v[6 + k];
            }
        });
        caught.last().clone()
    };
    let (explicit, implicit) = (
        last(Integrator::SemiImplicitEuler),
        last(Integrator::ImplicitVelocity),
    );
    assert!(
        implicit.v.amax() < 1e-3 && implicit.q[2] > 0.2,
        "{}",
        implicit.v
    );
    assert!(
        !explicit.is_finite() || explicit.v.amax() > 0.1,
        "the test is too easy"
    );
}

#[test]
fn jacobians_of_the_step_equal_finite_differences_in_every_mode() {
    let simulator = on(asset("box.urdf"), Terrain::incline(0.05), soft(0.5));
    let at = |z, v| free(&simulator, [0.1, -0.2, z], 0.02, v);
    let fast = [1.0, 0.4, -0.1, 0.2, 0.1, 0.5];
    for (name, state) in [
        ("flight", at(0.5, fast)),
        ("sticking", at(0.05, [1e-3, 0.0, 0.0, 0.0, 0.0, 1e-3])),
        ("sliding", at(0.05, fast)),
        ("at zero velocity", at(0.05, [0.0; 6])),
    ] {
        let exact = simulator.linearize(&state, &[]).a;
        let numeric = differences(&simulator, &state, 1e-7);
        let error = (&exact - &numeric).amax() / numeric.amax();
        assert!(error < 1e-6, "{name}: {error:e}");
    }
    // A joint with everything that is implicit, beyond its end.
    let simulator = stopped(1e4, 0.01);
    for (q, v) in [(1.01, 0.5), (-1.02, 0.1), (0.3, 2.0)] {
        let state = State::new(&[q], &[v]);
        let (exact, numeric) = (
            simulator.linearize(&state, &[0.0]).a,
            differences(&simulator, &state, 1e-7),
        );
        assert!(
            (&exact - &numeric).amax() < 1e-6 * numeric.amax(),
            "{q}: {exact} not {numeric}"
        );
    }
}
