//! The base velocity in body, mixed and inertial representation.

use dualbody::dynamics::{
    BaseFrame, frame_acceleration, frame_jacobian, frame_velocity, inverse_dynamics, mass_matrix,
};
use dualbody::model::FrameId;
use dualbody::spatial::Representation;
use dualbody::{Model, dynamics::forward_dynamics};
use nalgebra::DVector;

use crate::common::base::{
    acceleration_from, acceleration_to, force_from, force_to, velocity_from, velocity_to,
};
use crate::common::{
    OTHER_ALGORITHM, Point, SAME_ALGEBRA, assert_close, assert_close_vector, free_body,
    random_point, robots,
};

fn for_all(check: impl Fn(&Model, &Point, Representation, &str)) {
    for model in robots() {
        for representation in Representation::ALL {
            let what = format!("{}, {representation:?}", model.name());
            check(&model, &random_point(&model, 31), representation, &what);
        }
    }
}

#[test]
fn conversions_there_and_back_change_nothing() {
    for_all(|model, point, r, what| {
        let (q, v, x) = (point.q.as_slice(), point.v.as_slice(), &point.w);
        let there = velocity_to(model, q, x.as_slice(), r);
        assert_close_vector(
            &velocity_from(model, q, there.as_slice(), r),
            x,
            SAME_ALGEBRA,
            what,
        );
        let there = force_to(model, q, x.as_slice(), r);
        assert_close_vector(
            &force_from(model, q, there.as_slice(), r),
            x,
            SAME_ALGEBRA,
            what,
        );
        let there = acceleration_to(model, q, v, x.as_slice(), r);
        assert_close_vector(
            &acceleration_from(model, q, v, there.as_slice(), r),
            x,
            SAME_ALGEBRA,
            what,
        );
    });
}

#[test]
fn power_and_kinetic_energy_do_not_depend_on_the_representation() {
    for_all(|model, point, r, what| {
        let q = point.q.as_slice();
        let v = velocity_to(model, q, point.v.as_slice(), r);
        let tau = force_to(model, q, point.w.as_slice(), r);
        assert!(
            (v.dot(&tau) - point.v.dot(&point.w)).abs() < SAME_ALGEBRA * 100.0,
            "{what}"
        );
        let m = mass_matrix(model, q);
        let converted = BaseFrame::new(model, r).mass_matrix(q);
        assert_close(&converted, &converted.transpose(), SAME_ALGEBRA, what);
        assert!(
            (v.dot(&(&converted * &v)) - point.v.dot(&(m * &point.v))).abs() < OTHER_ALGORITHM,
            "{what}"
        );
    });
}

#[test]
fn converted_jacobian_maps_converted_velocities() {
    for_all(|model, point, r, what| {
        let q = point.q.as_slice();
        let jacobian = frame_jacobian(
            model,
            q,
            FrameId(model.frames().len() - 1),
            Representation::Mixed,
        );
        let v = velocity_to(model, q, point.v.as_slice(), r);
        let actual = BaseFrame::new(model, r).jacobian(q, &jacobian) * v;
        assert_close_vector(&actual, &(jacobian * &point.v), SAME_ALGEBRA, what);
    });
}

// The base is a frame, too: its velocity and acceleration in every representation are those of the frame.
#[test]
fn converted_base_motion_equals_that_of_the_base_frame() {
    for model in [free_body(), crate::common::floating_robot()] {
        let point = random_point(&model, 32);
        let (q, v, a) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        for r in Representation::ALL {
            let first_six = |x: DVector<f64>| x.rows(0, 6).into_owned();
            let velocity = frame_velocity(&model, q, v, FrameId(0), r).to_array();
            let converted = first_six(velocity_to(&model, q, v, r));
            assert_close_vector(
                &converted,
                &DVector::from_column_slice(&velocity),
                SAME_ALGEBRA,
                "velocity",
            );
            let acceleration = frame_acceleration(&model, q, v, a, FrameId(0), r).to_array();
            let converted = first_six(acceleration_to(&model, q, v, a, r));
            assert_close_vector(
                &converted,
                &DVector::from_column_slice(&acceleration),
                SAME_ALGEBRA,
                "acceleration",
            );
        }
    }
}

// M' ν̇' + h' = τ' in every representation, with h' from the forces that keep ν̇' = 0.
#[test]
fn equation_of_motion_holds_in_every_representation() {
    for_all(|model, point, r, what| {
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        let a = forward_dynamics(model, q, v, point.w.as_slice());
        let converted = acceleration_to(model, q, v, a.as_slice(), r);
        let still = acceleration_from(model, q, v, &vec![0.0; model.nv()], r);
        let bias = force_to(
            model,
            q,
            inverse_dynamics(model, q, v, still.as_slice()).as_slice(),
            r,
        );
        let left = BaseFrame::new(model, r).mass_matrix(q) * converted + bias;
        assert_close_vector(
            &left,
            &force_to(model, q, point.w.as_slice(), r),
            OTHER_ALGORITHM,
            what,
        );
    });
}
