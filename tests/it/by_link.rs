//! Masses link by link, Jacobians of all links, pose and velocity of the base, bounds of random states.

use dualbody::dynamics::{
    center_of_mass, frame_jacobian, frame_jacobian_derivative, frame_jacobian_derivatives,
    frame_jacobians, frame_pose, frame_velocity,
};
use dualbody::model::{BodyId, FrameId, JointSpec, LinkSpec, ModelBuilder, samples};
use dualbody::sim::StateBounds;
use dualbody::spatial::{Inertia, Motion, Quaternion, Representation, Transform};
use dualbody::{Model, State};
use nalgebra::{DMatrix, Vector3};

use crate::common::{
    OTHER_ALGORITHM, ROUNDING, SAME_ALGEBRA, floating_robot, generator, random_point, robots,
};

/// Name of the joint of a floating base.
const BASE: &str = "floating_base";

/// A board with a lamp fixed to it, turned and set off.
fn board() -> Model {
    let mut builder = ModelBuilder::new("board");
    builder.add_link(LinkSpec::new("board").with_mass(2.0, [0.1, 0.0, 0.0], [0.1, 0.2, 0.3]));
    builder.add_link(LinkSpec::new("lamp").with_mass(0.5, [0.0, 0.0, 0.2], [0.01, 0.01, 0.002]));
    let joint = JointSpec::new("screws", dualbody::joint::JointKind::Fixed, "board", "lamp");
    builder.add_joint(joint.with_translation([0.0, 0.3, 0.1]));
    builder.build().expect("a board")
}

#[test]
fn inertia_of_a_link_is_its_own_where_links_are_merged() {
    let model = board();
    assert_eq!(model.n_bodies(), 1);
    let lamp = model.link_inertia("lamp").expect("a link");
    assert_eq!((lamp.mass, lamp.com().z), (0.5, 0.2));
    let error = model.link_inertia("bord").expect_err("a misspelt link");
    assert!(error.to_string().contains("board"), "{error}");
    // All of it is the first link's after a change of the body.
    let changed = model.clone().with_inertia(BodyId(0), Inertia::zero());
    assert_eq!(changed.link_inertias()[1], Inertia::zero());
}

#[test]
fn inertias_of_links_add_up_to_those_of_bodies() {
    for model in robots().into_iter().chain([board()]) {
        let mut bodies = vec![DMatrix::zeros(6, 6); model.n_bodies()];
        for (link, inertia) in model.links().iter().zip(model.link_inertias()) {
            let frame = &model.frames()[link.frame.0];
            if let Some(body) = frame.body {
                bodies[body.0] += frame.placement.inertia(&inertia).to_matrix();
            }
        }
        for (body, sum) in model.bodies().iter().zip(bodies) {
            let off = sum - DMatrix::from_column_slice(6, 6, body.inertia.to_matrix().as_slice());
            assert!(off.amax() < SAME_ALGEBRA, "{}", model.name());
        }
    }
}

#[test]
fn centre_of_mass_is_the_mean_of_those_of_the_links() {
    let model = floating_robot();
    let point = random_point(&model, 91);
    let q = point.q.as_slice();
    let (mut mass, mut moment) = (0.0, Vector3::zeros());
    for (link, inertia) in model.links().iter().zip(model.link_inertias()) {
        mass += inertia.mass;
        moment += frame_pose(&model, q, link.frame).point(&inertia.com()) * inertia.mass;
    }
    assert!((moment / mass - center_of_mass(&model, q)).amax() < SAME_ALGEBRA);
}

#[test]
fn jacobians_of_all_links_equal_those_of_each() {
    for model in robots() {
        let point = random_point(&model, 92);
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        for r in Representation::ALL {
            let frames = model.link_frames();
            let all = frame_jacobians(&model, q, &frames, r);
            let rates = frame_jacobian_derivatives(&model, q, v, &frames, r);
            assert_eq!(all.len(), model.links().len());
            for (k, &frame) in frames.iter().enumerate() {
                assert_eq!(all[k], frame_jacobian(&model, q, frame, r));
                assert_eq!(rates[k], frame_jacobian_derivative(&model, q, v, frame, r));
            }
        }
    }
}

#[test]
fn pose_and_velocity_of_the_base_come_back_as_they_were_set() {
    let model = floating_robot();
    let point = random_point(&model, 93);
    let mut state = State::new(point.q.as_slice(), point.v.as_slice());
    let pose = Transform::new(
        Quaternion::exp(&Vector3::new(0.4, -1.0, 0.6)).to_matrix(),
        Vector3::new(1.0, -2.0, 0.5),
    );
    state
        .set_free_pose(&model, BASE, &pose)
        .expect("a floating base");
    let back = state.free_pose(&model, BASE).expect("a floating base");
    assert!((back.rotation - pose.rotation).amax() < 10.0 * ROUNDING);
    assert_eq!(back.translation, pose.translation);
    let velocity = Motion::from_array([0.3, -1.0, 0.7, 2.0, 0.1, -0.4]);
    for r in Representation::ALL {
        let set = state.set_free_velocity(&model, BASE, &velocity, r);
        set.expect("a floating base");
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        let of_frame = frame_velocity(&model, q, v, FrameId(0), r);
        let own = state
            .free_velocity(&model, BASE, r)
            .expect("a floating base");
        for k in 0..6 {
            let (a, b, c) = (
                own.to_array()[k],
                of_frame.to_array()[k],
                velocity.to_array()[k],
            );
            assert!(
                (a - c).abs() < SAME_ALGEBRA && (b - c).abs() < SAME_ALGEBRA,
                "{r:?}"
            );
        }
    }
    assert_eq!(
        state.v.rows(6, model.nv() - 6),
        point.v.rows(6, model.nv() - 6)
    );
}

#[test]
fn a_fixed_base_has_no_pose_to_read_or_set() {
    let model = samples::arm();
    let state: State = State::neutral(&model);
    let error = state.free_pose(&model, BASE).expect_err("no floating base");
    assert!(
        error.to_string().contains(BASE) && error.known.is_empty(),
        "{error}"
    );
    let mut state = state;
    assert!(
        state
            .set_free_pose(&model, BASE, &Transform::identity())
            .is_err()
    );
}

#[test]
fn random_states_are_within_their_bounds_and_reach_them() {
    let model = floating_robot();
    let mut rng = generator(94);
    let bounds = StateBounds {
        base_position: [[1.0, 2.0], [-3.0, -2.0], [0.5, 0.5]],
        base_roll_pitch_yaw: Some([[0.0, 0.0], [0.0, 0.0], [-0.5, 0.5]]),
        base_linear_velocity: [[0.0, 0.1], [0.0, 0.0], [-1.0, 0.0]],
        base_angular_velocity: [[2.0, 3.0]; 3],
        joint_position: [-0.1, 0.3],
        joint_velocity: [0.2, 0.4],
    };
    let hinge = model
        .joint_q(model.find_joint("hinge_joint").expect("a joint"))
        .start;
    let (mut least, mut largest) = (f64::MAX, f64::MIN);
    for _ in 0..500 {
        let state = State::random_within(&model, &mut rng, &bounds);
        let pose = state.free_pose(&model, BASE).expect("a floating base");
        let p = pose.translation;
        assert!((1.0..=2.0).contains(&p.x) && (-3.0..=-2.0).contains(&p.y) && p.z == 0.5);
        let [roll, pitch, yaw] = Quaternion::from_matrix(&pose.rotation).to_roll_pitch_yaw();
        assert!(roll.abs() + pitch.abs() < OTHER_ALGORITHM && yaw.abs() <= 0.5 + OTHER_ALGORITHM);
        let V = state
            .free_velocity(&model, BASE, Representation::Mixed)
            .expect("a floating base");
        assert!(V.linear.y.abs() < SAME_ALGEBRA && V.linear.z < SAME_ALGEBRA);
        assert!(V.angular.iter().all(|w| (1.999..=3.001).contains(w)));
        let joints = state.v.rows(6, model.nv() - 6);
        assert!(joints.iter().all(|v| (0.2..=0.4).contains(v)));
        least = least.min(state.q[hinge]);
        largest = largest.max(state.q[hinge]);
    }
    assert!((-0.1..-0.09).contains(&least) && (0.29..=0.3).contains(&largest));
}

#[test]
fn default_bounds_of_random_states_keep_joint_limits() {
    let model = samples::cartpole();
    let mut rng = generator(95);
    for _ in 0..100 {
        let state = State::random_within(&model, &mut rng, &StateBounds::default());
        assert!(state.q[0].abs() <= 2.4 && state.v.amax() <= 1.0);
    }
}

#[test]
#[should_panic(expected = "above the upper bound")]
fn bounds_of_random_states_in_the_wrong_order_are_refused() {
    let bounds = StateBounds {
        joint_velocity: [1.0, -1.0],
        ..StateBounds::default()
    };
    State::random_within(&samples::cartpole(), &mut generator(96), &bounds);
}

// q̇ = J v: J dv is the change of the coordinates by a small motion dv, and the inverse maps it back.
#[test]
fn jacobians_of_moves_equal_differences() {
    const STEP: f64 = 1e-6;
    for model in robots() {
        let point = random_point(&model, 97);
        let q = point.q.as_slice();
        let moved = |h: f64| model.integrate(q, (&point.v * h).as_slice());
        let rate = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
        let own = model.integrate_jacobian(q) * &point.v;
        assert!(
            rate.is_empty() || (rate - &own).amax() < 1e-8,
            "{}",
            model.name()
        );
        let back = model.difference_jacobian(q) * own;
        assert!(
            back.is_empty() || (back - &point.v).amax() < 1e-12,
            "{}",
            model.name()
        );
    }
}
