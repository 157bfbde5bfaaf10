//! Each line of the conventions, as a number.

use std::f64::consts::{FRAC_PI_2, TAU};

use dualbody::State;
use dualbody::dynamics::{
    bias_forces, center_of_mass, forward_dynamics, frame_jacobian, frame_pose, frame_velocity,
    gravity_forces, potential_energy,
};
use dualbody::joint::JointKind;
use dualbody::model::{Base, JointSpec, LinkSpec, Model, ModelBuilder, samples};
use dualbody::sim::{Engine, EngineCoordinates};
use dualbody::spatial::{Motion, Quaternion, Representation, Transform};
use nalgebra::{DVector, Vector3};

use crate::common::{ROUNDING, SAME_ALGEBRA, floating_robot, free_body};

fn close(a: &Vector3<f64>, b: [f64; 3]) {
    assert!(
        (a - Vector3::from(b)).norm() < 10.0 * ROUNDING,
        "{a} against {b:?}"
    );
}

/// One link of 1 kg on one joint at the world's origin.
fn one_joint(kind: JointKind, axis: [f64; 3]) -> Model {
    let mut builder = ModelBuilder::new("one_joint");
    builder
        .add_link(LinkSpec::new("world"))
        .add_link(LinkSpec::new("link").with_mass(1.0, [0.3, 0.2, 0.1], [0.1; 3]));
    builder.add_joint(JointSpec::new("joint", kind, "world", "link").with_axis(axis));
    builder.build().expect("one joint")
}

#[test]
fn spatial_vectors_are_linear_then_angular() {
    assert_eq!(
        Motion::from_array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).angular,
        Vector3::new(4.0, 5.0, 6.0)
    );
    let model = one_joint(JointKind::Revolute, [0.0, 0.0, 1.0]);
    let jacobian = frame_jacobian(
        &model,
        &[0.0],
        model.frame("link").expect("link"),
        Representation::Body,
    );
    assert_eq!(jacobian.as_slice(), [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn quaternions_are_w_first() {
    let q = Quaternion::exp(&Vector3::new(0.0, 0.0, FRAC_PI_2));
    assert!((q.w - q.xyz.z).abs() < ROUNDING && q.w > 0.7);
    assert_eq!(
        one_joint(JointKind::Spherical, [1.0, 0.0, 0.0])
            .neutral()
            .as_slice(),
        [1.0, 0.0, 0.0, 0.0]
    );
}

#[test]
fn adjacent_letters_cancel() {
    let quarter = Quaternion::exp(&Vector3::new(0.0, 0.0, FRAC_PI_2)).to_matrix();
    let X_AB = Transform::new(quarter, Vector3::new(1.0, 0.0, 0.0));
    let X_BC = Transform::from_translation(Vector3::new(2.0, 0.0, 0.0));
    // C lies 2 m along B's x axis, which is A's y axis.
    close(&(X_AB * X_BC).translation, [1.0, 2.0, 0.0]);
}

#[test]
fn revolute_joints_turn_right_handed_about_the_axis_of_the_description() {
    for (axis, expected) in [
        ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
        ([0.0, 0.0, -2.0], [0.0, -1.0, 0.0]),
        ([0.0, 1.0, 0.0], [0.0, 0.0, -1.0]),
    ] {
        let model = one_joint(JointKind::Revolute, axis);
        let pose = frame_pose(&model, &[FRAC_PI_2], model.frame("link").expect("link"));
        close(&pose.rotation.column(0).into(), expected);
    }
}

#[test]
fn prismatic_joints_move_along_the_axis_of_the_description() {
    let model = one_joint(JointKind::Prismatic, [0.0, -3.0, 0.0]);
    close(
        &frame_pose(&model, &[0.5], model.frame("link").expect("link")).translation,
        [0.0, -0.5, 0.0],
    );
}

#[test]
fn angles_of_continuous_joints_are_not_wrapped() {
    let model = one_joint(JointKind::Continuous, [1.0, 0.0, 0.0]);
    assert_eq!(model.integrate(&[3.0], &[TAU])[0], 3.0 + TAU);
    assert_eq!(model.difference(&[0.0], &[3.0 * TAU])[0], 3.0 * TAU);
}

#[test]
fn planar_joints_move_in_the_plane_normal_to_the_axis_with_body_velocities() {
    let model = one_joint(JointKind::Planar, [0.0, 0.0, 1.0]);
    let link = model.frame("link").expect("link");
    let pose = frame_pose(&model, &[0.3, -0.2, FRAC_PI_2], link);
    close(&pose.translation, [0.3, -0.2, 0.0]);
    close(&pose.rotation.column(0).into(), [0.0, 1.0, 0.0]);
    // Moving along the body's x axis, which points along the world's y.
    let V = frame_velocity(
        &model,
        &[0.3, -0.2, FRAC_PI_2],
        &[1.0, 0.0, 0.0],
        link,
        Representation::Mixed,
    );
    close(&V.linear, [0.0, 1.0, 0.0]);
}

#[test]
fn floating_base_comes_first_with_its_velocity_in_the_base_frame() {
    let model = floating_robot();
    assert!(model.has_floating_base());
    assert_eq!(model.joint_names()[0], "ball_joint");
    assert_eq!(
        model.joint_q(model.joint("ball_joint").expect("a joint")),
        7..11
    );
    assert_eq!(
        model.joint_v(model.joint("ball_joint").expect("a joint")),
        6..9
    );
    let mut q = model.neutral();
    let mut v = DVector::zeros(model.nv());
    q.as_mut_slice()[..7].copy_from_slice(&[
        0.1,
        0.2,
        0.3,
        0.5_f64.sqrt(),
        0.0,
        0.0,
        0.5_f64.sqrt(),
    ]);
    v[0] = 1.0;
    let torso = model.frame("torso").expect("a link");
    close(
        &frame_pose(&model, q.as_slice(), torso).translation,
        [0.1, 0.2, 0.3],
    );
    // A quarter turn about z: the base's x axis is the world's y axis.
    close(
        &frame_velocity(
            &model,
            q.as_slice(),
            v.as_slice(),
            torso,
            Representation::Mixed,
        )
        .linear,
        [0.0, 1.0, 0.0],
    );
}

#[test]
fn representations_differ_by_origin_and_axes() {
    let model = free_body();
    let body = model.frame("body").expect("a link");
    let h = 0.5_f64.sqrt();
    let q = [2.0, 0.0, 0.0, h, 0.0, 0.0, h];
    let v = [0.0, 0.0, 0.0, 0.0, 0.0, 3.0];
    let of = |representation| frame_velocity(&model, &q, &v, body, representation);
    close(&of(Representation::Body).angular, [0.0, 0.0, 3.0]);
    close(&of(Representation::Mixed).linear, [0.0, 0.0, 0.0]);
    // The point of the body at the world's origin is 2 m to the left of the axis.
    close(&of(Representation::Inertial).linear, [0.0, -6.0, 0.0]);
}

#[test]
fn base_is_fixed_below_a_root_called_world_and_floats_otherwise() {
    assert!(!samples::cartpole().has_floating_base());
    assert!(free_body().has_floating_base());
    let of = |root: &str, base| {
        let mut builder = ModelBuilder::new("base").with_base(base);
        builder
            .add_link(LinkSpec::new(root))
            .add_link(LinkSpec::new("box").with_mass(1.0, [0.0; 3], [0.1; 3]));
        builder.add_joint(JointSpec::new("weld", JointKind::Fixed, root, "box"));
        builder.build().map(|model| model.nv())
    };
    assert_eq!(of("world", Base::Auto).ok(), Some(0));
    assert_eq!(of("anchor", Base::Auto).ok(), Some(6));
    assert_eq!(of("anchor", Base::Fixed).ok(), Some(0));
    assert_eq!(of("world", Base::Floating).ok(), Some(6));
}

#[test]
fn gravity_points_down_and_potential_energy_grows_with_height() {
    let model = one_joint(JointKind::Prismatic, [0.0, 0.0, 1.0]);
    assert_eq!(*model.gravity(), Vector3::new(0.0, 0.0, -9.81));
    assert!((forward_dynamics(&model, &[0.0], &[0.0], &[0.0])[0] + 9.81).abs() < 10.0 * ROUNDING);
    assert!((gravity_forces(&model, &[0.0])[0] - 9.81).abs() < 10.0 * ROUNDING);
    assert!((bias_forces(&model, &[0.0], &[2.0])[0] - 9.81).abs() < 10.0 * ROUNDING);
    assert!(
        (potential_energy(&model, &[2.0]) - potential_energy(&model, &[1.0]) - 9.81).abs() < 1e-13
    );
}

#[test]
fn mass_is_that_of_what_moves() {
    let mut builder = ModelBuilder::new("on_a_stone").with_base(Base::Fixed);
    builder.add_link(LinkSpec::new("stone").with_mass(100.0, [9.0, 9.0, 9.0], [1.0; 3]));
    builder.add_link(LinkSpec::new("arm").with_mass(2.0, [0.1, 0.0, 0.0], [0.1; 3]));
    builder.add_link(LinkSpec::new("tool").with_mass(1.0, [0.0; 3], [0.1; 3]));
    builder.add_joint(
        JointSpec::new("hinge", JointKind::Revolute, "stone", "arm").with_axis([0.0, 0.0, 1.0]),
    );
    builder.add_joint(
        JointSpec::new("weld", JointKind::Fixed, "arm", "tool").with_translation([0.4, 0.0, 0.0]),
    );
    let model = builder.build().expect("a model");
    assert_eq!((model.total_mass(), model.n_bodies()), (3.0, 1));
    close(&center_of_mass(&model, &[0.0]), [0.2, 0.0, 0.0]);
    assert_eq!(model.link_names(), ["stone", "arm", "tool"]);
    close(
        &frame_pose(&model, &[FRAC_PI_2], model.frame("tool").expect("a link")).translation,
        [0.0, 0.4, 0.0],
    );
}

// A quarter turn about z: the base's x axis is the world's y axis.
#[test]
fn states_of_other_engines_differ_as_the_table_says() {
    let model = free_body();
    let h = 0.5_f64.sqrt();
    let state = State::new(
        &[1.0, 2.0, 3.0, h, 0.0, 0.0, h],
        &[4.0, 0.0, 0.0, 5.0, 0.0, 6.0],
    );
    let close = |(q, v): (DVector<f64>, DVector<f64>), expected_q: &[f64], expected_v: &[f64]| {
        let same = |a: &DVector<f64>, b: &[f64]| {
            a.len() == b.len()
                && a.iter()
                    .zip(b)
                    .all(|(a, b)| (a - b).abs() < 10.0 * ROUNDING)
        };
        assert!(same(&q, expected_q) && same(&v, expected_v), "{q}{v}");
    };
    let wxyz = [1.0, 2.0, 3.0, h, 0.0, 0.0, h];
    close(
        EngineCoordinates::new(&model, Engine::Pinocchio).state_to(&state),
        &[1.0, 2.0, 3.0, 0.0, 0.0, h, h],
        &[4.0, 0.0, 0.0, 5.0, 0.0, 6.0],
    );
    close(
        EngineCoordinates::new(&model, Engine::MuJoCo).state_to(&state),
        &wxyz,
        &[0.0, 4.0, 0.0, 5.0, 0.0, 6.0],
    );
    close(
        EngineCoordinates::new(&model, Engine::JaxSim).state_to(&state),
        &wxyz,
        &[0.0, 4.0, 0.0, 0.0, 5.0, 6.0],
    );

    let planar = one_joint(JointKind::Planar, [0.0, 0.0, 1.0]);
    let state = State::new(&[1.0, 2.0, FRAC_PI_2], &[3.0, 0.0, 4.0]);
    close(
        EngineCoordinates::new(&planar, Engine::Pinocchio).state_to(&state),
        &[1.0, 2.0, 0.0, 1.0],
        &[3.0, 0.0, 4.0],
    );
    close(
        EngineCoordinates::new(&planar, Engine::MuJoCo).state_to(&state),
        &[1.0, 2.0, FRAC_PI_2],
        &[0.0, 3.0, 4.0],
    );
    let wheel = one_joint(JointKind::Continuous, [0.0, 0.0, 1.0]);
    close(
        EngineCoordinates::new(&wheel, Engine::Pinocchio)
            .state_to(&State::new(&[FRAC_PI_2], &[1.0])),
        &[0.0, 1.0],
        &[1.0],
    );
}

#[test]
fn states_come_back_from_every_engine() {
    for model in crate::common::robots() {
        let point = crate::common::random_point(&model, 41);
        let state = State::new(point.q.as_slice(), point.v.as_slice());
        for engine in [Engine::Pinocchio, Engine::MuJoCo, Engine::JaxSim] {
            let coordinates = EngineCoordinates::new(&model, engine);
            let (q, v) = coordinates.state_to(&state);
            let back = coordinates.state_from(q.as_slice(), v.as_slice());
            let error = back.deviation(&model, &state).norm();
            assert!(
                error < SAME_ALGEBRA,
                "{}, {engine:?}: {error}",
                model.name()
            );
        }
    }
}
