//! Forces and frames by name, against Jacobians and forward kinematics.

use dualbody::dynamics::{
    NamedForces, RneaScratch, external_forces, forward_dynamics, forward_kinematics,
    frame_jacobian, frame_velocity, inverse_dynamics, inverse_dynamics_into, joint_forces,
};
use dualbody::model::{BodyId, JointId, samples};
use dualbody::spatial::{Force, Representation};
use dualbody::{Simulator, State};
use nalgebra::{DVector, Vector6};

use crate::common::{OTHER_ALGORITHM, assert_close_vector, gripper, random_point, robots};

const FORCE: [f64; 6] = [0.3, -1.0, 0.7, 2.0, 0.1, -0.4];

// τ = M a + h − Σ Jᵀ F
#[test]
fn torques_with_forces_on_named_frames_equal_those_without_less_transposed_jacobians() {
    for model in robots() {
        let point = random_point(&model, 41);
        let (q, v, a) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        for representation in Representation::ALL {
            let mut forces = NamedForces::default();
            let mut expected = inverse_dynamics(&model, q, v, a);
            for (k, name) in model.frame_names().into_iter().enumerate() {
                let force = FORCE.map(|x| x * (1.0 + k as f64));
                let on_frame = Force::from_array(force);
                forces
                    .add_frame_force(&model, name, &on_frame, representation)
                    .expect("a frame of the model");
                let frame = model.find_frame(name).expect("a frame of the model");
                let jacobian = frame_jacobian(&model, q, frame, representation);
                expected -= jacobian.transpose() * Vector6::from(force);
            }
            let kinematics = forward_kinematics(&model, q, v);
            let external = external_forces(&model, &kinematics, &forces);
            let mut tau = DVector::zeros(model.nv());
            let mut scratch = RneaScratch::new(&model);
            inverse_dynamics_into(&model, q, v, a, &external, &mut scratch, tau.as_mut_slice());
            let what = format!("{}, {representation:?}", model.name());
            assert_close_vector(&tau, &expected, OTHER_ALGORITHM, &what);
        }
    }
}

#[test]
fn forces_on_frames_of_a_body_sum_up() {
    let model = samples::arm();
    let point = random_point(&model, 42);
    let kinematics = forward_kinematics(&model, point.q.as_slice(), point.v.as_slice());
    let (last, r) = (model.n_bodies() - 1, Representation::Mixed);
    let on_last = |forces: &NamedForces| {
        DVector::from_column_slice(&external_forces(&model, &kinematics, forces)[last].to_array())
    };
    let link = model.body_name(BodyId(last));
    let force = Force::from_array(FORCE);
    let mut forces = NamedForces::default();
    forces
        .add_frame_force(&model, link, &force, r)
        .expect("a link");
    let once = on_last(&forces);
    forces
        .add_frame_force(&model, link, &force, Representation::Mixed)
        .expect("a link");
    assert_close_vector(&on_last(&forces), &(&once * 2.0), OTHER_ALGORITHM, "added");
    forces
        .add_frame_force(&model, "tool", &force, r)
        .expect("a frame");
    let with_tool = on_last(&forces);
    let mut tool = NamedForces::default();
    tool.add_frame_force(&model, "tool", &force, r)
        .expect("a frame");
    let expected = once * 2.0 + on_last(&tool);
    assert_close_vector(&with_tool, &expected, OTHER_ALGORITHM, "on two frames");
    let before = forces.clone();
    let error = forces
        .add_frame_force(&model, "tol", &force, r)
        .expect_err("no frame");
    assert!(error.to_string().contains("\"tol\"") && error.known.contains(&"tool".to_owned()));
    assert_eq!(forces, before);
}

// τᵀ v = Σ τ_j q̇_j, where mimic joints turn with their ratio: the thumb with −0.7 of the shoulder, the tip with twice
// that.
#[test]
fn power_of_named_joint_forces_equals_that_of_their_sum_on_the_leaders() {
    let model = gripper()
        .build()
        .expect("a robot that is known to be right");
    let mut forces = NamedForces::default();
    let by_joint: [(&str, &[f64]); 3] = [
        ("thumb_joint", &[3.0]),
        ("tip_joint", &[5.0]),
        ("left_joint", &[7.0]),
    ];
    forces.set_joint_forces(&model, &by_joint).expect("joints");
    forces
        .set_joint_forces(&model, &[("left_joint", &[2.0])])
        .expect("a joint");
    let tau = joint_forces(&model, &forces);
    let at = |name| {
        model
            .joint_v(model.find_joint(name).expect("a joint"))
            .start
    };
    assert!((tau[at("shoulder_joint")] - (3.0 * -0.7 + 5.0 * -1.4)).abs() < OTHER_ALGORITHM);
    assert_eq!((tau[at("left_joint")], tau[at("elbow_joint")]), (2.0, 0.0));
    let before = forces.clone();
    let wrong: [(&str, &[f64]); 2] = [("elbow_joint", &[1.0]), ("knee", &[1.0])];
    let error = forces
        .set_joint_forces(&model, &wrong)
        .expect_err("no joint");
    assert!(error.to_string().contains("\"knee\""), "{error}");
    assert_eq!(forces, before);
}

#[test]
fn velocity_of_each_body_by_its_frame_and_by_its_name_equals_that_of_forward_kinematics() {
    for model in robots() {
        let point = random_point(&model, 17);
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        let kinematics = forward_kinematics(&model, q, v);
        for body in (0..model.n_bodies()).map(BodyId) {
            let frame = model.body_frame(body);
            assert_eq!(model.find_frame(model.body_name(body)), Ok(frame));
            // Seen from the world's origin, all frames of a body move alike.
            let by_frame = frame_velocity(&model, q, v, frame, Representation::Inertial);
            let X_WB = kinematics.pose(Some(body));
            let by_body = X_WB.motion(&kinematics.velocity(Some(body)));
            let [by_frame, by_body] =
                [by_frame, by_body].map(|V| DVector::from_column_slice(&V.to_array()));
            assert_close_vector(&by_frame, &by_body, OTHER_ALGORITHM, model.name());
        }
        for joint in (0..model.n_joints()).map(JointId) {
            assert_eq!(model.body_joint(model.joint_body(joint)), Some(joint));
        }
        let error = model.find_frame("nowhere").expect_err("no such frame");
        assert!(error.to_string().contains("\"nowhere\""), "{error}");
    }
}

// One step of semi-implicit Euler: v⁺ = v + Δt M⁻¹ (τ − h + Jᵀ F) for joints that are not rotations.
#[test]
fn step_with_named_forces_equals_forward_dynamics_under_them() {
    let model = samples::arm();
    let simulator = Simulator::new(model.clone()).with_time_step(1e-3);
    let point = random_point(&model, 43);
    let state = State::new(point.q.as_slice(), point.v.as_slice());
    let (joint, tool) = (model.joint_names()[2], "tool");
    let force = Force::from_array(FORCE);
    for r in Representation::ALL {
        let mut forces = NamedForces::default();
        let set = forces.set_joint_forces(&model, &[(joint, &[3.0])]);
        set.and(forces.add_frame_force(&model, tool, &force, r))
            .expect("names of the arm");
        let next = simulator.step_with_forces(&state, &forces).expect("inputs");
        let frame = model.find_frame(tool).expect("a frame");
        let J = frame_jacobian(&model, point.q.as_slice(), frame, r);
        let tau = joint_forces(&model, &forces) + J.transpose() * Vector6::from(FORCE);
        let a = forward_dynamics(
            &model,
            point.q.as_slice(),
            point.v.as_slice(),
            tau.as_slice(),
        );
        assert_close_vector(&next.v, &(&point.v + a * 1e-3), OTHER_ALGORITHM, "velocity");
    }
}

#[test]
fn named_force_along_a_joint_without_input_is_refused() {
    let model = samples::cartpole();
    let simulator = Simulator::new(model.clone())
        .with_actuated_joints(&["linear"])
        .expect("a joint");
    let mut forces = NamedForces::default();
    let on = |forces: &mut NamedForces, name: &str| {
        let set = forces.set_joint_forces(&model, &[(name, &[2.0])]);
        set.expect("a joint");
    };
    on(&mut forces, "linear");
    let u = simulator.inputs_of(&forces).expect("inputs");
    assert_eq!(u.as_slice(), [2.0]);
    on(&mut forces, "pivot");
    let error = simulator.inputs_of(&forces).expect_err("no input there");
    assert!(error.to_string().contains("pivot"), "{error}");
    let state: State = State::neutral(&model);
    assert!(simulator.step_with_forces(&state, &forces).is_err());
}
