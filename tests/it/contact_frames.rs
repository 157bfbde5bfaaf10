//! Frames at the points of contact against frames of the robot at the same places.

use dualbody::contact::{ContactLaw, Contacts, SoftContact, Terrain};
use dualbody::dynamics::{frame_jacobian, frame_jacobian_derivative, frame_pose};
use dualbody::model::FrameId;
use dualbody::spatial::{Representation, Transform};
use dualbody::{Model, Simulator, State};
use nalgebra::{DVector, Vector3};

use crate::common::{OTHER_ALGORITHM, SAME_ALGEBRA, assert_close, asset, random_point};

fn contacts_of(model: &Model) -> Contacts {
    let law = ContactLaw::Soft(SoftContact::estimate(10.0, 4, 0.01));
    Contacts::new(model, Terrain::flat(0.0), law)
}

/// The robot with a frame at each point of contact, where it is now, in the axes of its link.
fn with_frames(model: &Model, contacts: &Contacts, q: &[f64]) -> Model {
    let v = vec![0.0; model.nv()];
    let mut builder = model.to_builder();
    for (k, (point, state)) in contacts
        .points()
        .iter()
        .zip(contacts.states(model, q, &v))
        .enumerate()
    {
        let link = &model.frames()[point.link.0];
        let in_link = link.placement.inverse().point(&state.in_body);
        builder.add_frame(
            format!("point {k}"),
            link.name.clone(),
            Transform::from_translation(in_link),
        );
    }
    builder.build().expect("frames at points of contact")
}

#[test]
fn frames_of_points_equal_frames_of_the_robot_at_the_same_places() {
    for name in ["quadruped.urdf", "sphere.urdf", "box.urdf"] {
        let model = asset(name);
        let contacts = contacts_of(&model);
        let point = random_point(&model, 81);
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        let marked = with_frames(&model, &contacts, q);
        let frames = contacts.frames(&model, q);
        assert!(!frames.is_empty(), "{name}");
        for r in Representation::ALL {
            let jacobians = contacts.frame_jacobians(&model, q, r);
            let rates = contacts.frame_jacobian_derivatives(&model, q, v, r);
            for (k, X) in frames.iter().enumerate() {
                let what = format!("{name}, point {k}, {r:?}");
                let frame: FrameId = marked.frame(&format!("point {k}")).expect("a frame");
                let expected = frame_pose(&marked, q, frame);
                assert!(
                    (X.rotation - expected.rotation).amax() < SAME_ALGEBRA,
                    "{what}"
                );
                assert!(
                    (X.translation - expected.translation).amax() < SAME_ALGEBRA,
                    "{what}"
                );
                let J = frame_jacobian(&marked, q, frame, r);
                assert_close(&jacobians[k], &J, OTHER_ALGORITHM, &what);
                let rate = frame_jacobian_derivative(&marked, q, v, frame, r);
                assert_close(&rates[k], &rate, OTHER_ALGORITHM, &what);
            }
        }
    }
}

#[test]
fn mixed_jacobian_of_a_point_times_the_velocity_is_its_velocity() {
    let model = asset("quadruped.urdf");
    let contacts = contacts_of(&model);
    let point = random_point(&model, 82);
    let (q, v) = (point.q.as_slice(), point.v.as_slice());
    let jacobians = contacts.frame_jacobians(&model, q, Representation::Mixed);
    for (k, state) in contacts.states(&model, q, v).iter().enumerate() {
        let velocity: DVector<f64> = &jacobians[k] * &point.v;
        let error = velocity.rows(0, 3) - state.velocity;
        assert!(error.amax() < SAME_ALGEBRA * 10.0, "point {k}");
        let three = contacts.jacobian(&model, q, k);
        assert_close(
            &jacobians[k].rows(0, 3).into(),
            &three,
            SAME_ALGEBRA * 10.0,
            "rows",
        );
    }
}

#[test]
fn links_are_in_contact_where_a_point_is_below_the_ground() {
    let model = asset("quadruped.urdf");
    let contacts = contacts_of(&model);
    let mut state = State::neutral(&model);
    state.q[2] = 10.0;
    let flags = contacts.links_in_contact(&model, state.q.as_slice());
    assert_eq!(flags.len(), model.links().len());
    assert!(!flags.contains(&true), "high above the ground");
    let points = contacts.states(&model, state.q.as_slice(), state.v.as_slice());
    let deepest = points.iter().map(|p| p.depth).fold(f64::MIN, f64::max);
    state.q[2] = 10.0 + deepest - 1e-6;
    let flags = contacts.links_in_contact(&model, state.q.as_slice());
    let points = contacts.states(&model, state.q.as_slice(), state.v.as_slice());
    for (link, flag) in model.links().iter().zip(&flags) {
        let mut own = contacts.points().iter().zip(&points);
        let expected = own.any(|(p, s)| p.link == link.frame && s.position.z < 0.0);
        assert_eq!(*flag, expected);
    }
    assert!(flags.contains(&true) && flags.contains(&false));
}

#[test]
fn contacts_without_points_have_no_frames_and_touch_nothing() {
    let model = asset("box.urdf");
    let contacts = contacts_of(&model).with_selection(|_| false);
    let q = model.neutral();
    assert!(contacts.frames(&model, q.as_slice()).is_empty());
    let flags = contacts.links_in_contact(&model, q.as_slice());
    assert!(!flags.is_empty() && !flags.contains(&true));
    let simulator = Simulator::new(model.clone()).with_contacts(contacts);
    let start = simulator.neutral_state::<f64>();
    let falling = Simulator::new(model).step(&start, &[]);
    assert_eq!(simulator.step(&start, &[]), falling);
    assert!((falling.v.rows(0, 3) - Vector3::new(0.0, 0.0, falling.v[2])).amax() < 1e-12);
}
