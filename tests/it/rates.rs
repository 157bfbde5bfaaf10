//! Jacobian rates, accelerations, momentum, each against the derivative in time of the quantity whose rate it is.

use dualbody::autodiff::{VectorFunction, jacobian};
use dualbody::dynamics::{
    AbaScratch, MomentumFrame, add_frame_force, average_velocity, average_velocity_jacobian,
    center_of_mass, center_of_mass_acceleration, center_of_mass_jacobian, center_of_mass_velocity,
    centroidal_momentum, centroidal_momentum_matrix, centroidal_momentum_matrix_derivative,
    centroidal_momentum_rate, forward_dynamics, forward_dynamics_into, forward_kinematics,
    frame_acceleration, frame_bias_acceleration, frame_jacobian, frame_jacobian_derivative,
    frame_pose, frame_velocity, kinetic_energy, locked_inertia, mass_matrix, momentum,
    momentum_matrix, potential_energy,
};
use dualbody::model::FrameId;
use dualbody::spatial::Force;
use dualbody::{Model, Scalar};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::common::everything::{MOMENTUM_FRAMES, REPRESENTATIONS};
use crate::common::{
    OTHER_ALGORITHM, Point, ROUNDING, SAME_ALGEBRA, assert_close, assert_close_vector,
    floating_robot, free_body, random_point, robots,
};

/// A function of time t on the motion q ⊕ (t v + ½ t² a), v + t a through a state.
struct InTime<'a, F> {
    model: &'a Model,
    point: &'a Point,
    n: usize,
    f: F,
}

/// The quantity that is differentiated in time.
enum Quantity {
    Jacobian(FrameId, dualbody::spatial::Representation),
    Velocity(FrameId, dualbody::spatial::Representation),
    CenterOfMass,
    Momentum(MomentumFrame),
    Energy,
}

impl VectorFunction for InTime<'_, Quantity> {
    fn n_outputs(&self) -> usize {
        self.n
    }

    fn eval<T: Scalar>(&self, t: &[T], y: &mut [T]) {
        let (model, t) = (self.model, t[0]);
        let dq: Vec<T> = self.point.v.iter().map(|&v| t * v).collect();
        let q = model.integrate(self.point.q.map(T::constant).as_slice(), &dq);
        let v: Vec<T> = self
            .point
            .v
            .iter()
            .zip(&self.point.w)
            .map(|(&v, &a)| t * a + v)
            .collect();
        let (q, v) = (q.as_slice(), v.as_slice());
        match self.f {
            Quantity::Jacobian(frame, representation) => {
                y.copy_from_slice(frame_jacobian(model, q, frame, representation).as_slice());
            }
            Quantity::Velocity(frame, representation) => {
                y.copy_from_slice(&frame_velocity(model, q, v, frame, representation).to_array());
            }
            Quantity::CenterOfMass => y.copy_from_slice(center_of_mass(model, q).as_slice()),
            Quantity::Energy => y[0] = kinetic_energy(model, q, v) + potential_energy(model, q),
            Quantity::Momentum(frame) => {
                y.copy_from_slice(&momentum(model, q, v, frame).to_array());
            }
        }
    }
}

/// d/dt of a quantity at the state with velocity v and acceleration w.
fn rate(model: &Model, point: &Point, n: usize, f: Quantity) -> DVector<f64> {
    jacobian(&InTime { model, point, n, f }, &[0.0])
        .column(0)
        .into()
}

fn for_all(check: impl Fn(&Model, &Point, &str)) {
    for model in robots() {
        for seed in 0..2 {
            check(
                &model,
                &random_point(&model, seed),
                &format!("{}, seed {seed}", model.name()),
            );
        }
    }
}

fn vector(x: &[f64]) -> DVector<f64> {
    DVector::from_column_slice(x)
}

#[test]
fn frame_jacobian_derivative_equals_the_rate_of_the_jacobian() {
    for_all(|model, point, what| {
        let last = FrameId(model.frames().len() - 1);
        for representation in REPRESENTATIONS {
            let actual = frame_jacobian_derivative(
                model,
                point.q.as_slice(),
                point.v.as_slice(),
                last,
                representation,
            );
            let expected = rate(
                model,
                point,
                6 * model.nv(),
                Quantity::Jacobian(last, representation),
            );
            let what = format!("{what}, {representation:?}");
            assert_close(
                &actual,
                &DMatrix::from_column_slice(6, model.nv(), expected.as_slice()),
                SAME_ALGEBRA,
                &what,
            );
        }
    });
}

#[test]
fn frame_acceleration_equals_the_rate_of_the_velocity() {
    for_all(|model, point, what| {
        let (q, v, a) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        for frame in (0..model.frames().len()).map(FrameId) {
            for representation in REPRESENTATIONS {
                let actual = frame_acceleration(model, q, v, a, frame, representation).to_array();
                let expected = rate(model, point, 6, Quantity::Velocity(frame, representation));
                assert_close_vector(
                    &vector(&actual),
                    &expected,
                    SAME_ALGEBRA,
                    &format!("{what}, {representation:?}"),
                );
            }
        }
    });
}

#[test]
fn bias_acceleration_equals_jacobian_rate_times_velocity() {
    for_all(|model, point, what| {
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        let last = FrameId(model.frames().len() - 1);
        for representation in REPRESENTATIONS {
            let bias =
                vector(&frame_bias_acceleration(model, q, v, last, representation).to_array());
            let expected = frame_jacobian_derivative(model, q, v, last, representation) * &point.v;
            assert_close_vector(&bias, &expected, SAME_ALGEBRA, what);
            let with_a = frame_acceleration(model, q, v, point.w.as_slice(), last, representation)
                .to_array();
            let expected = frame_jacobian(model, q, last, representation) * &point.w + bias;
            assert_close_vector(&vector(&with_a), &expected, SAME_ALGEBRA, what);
        }
    });
}

// p̈ of a frame is the second derivative of its position: the mixed acceleration of a point that circles at radius r is
// −ω² r.
#[test]
fn mixed_acceleration_of_a_circling_frame_is_centripetal() {
    let model = dualbody::model::samples::pendulum();
    let mut builder = dualbody::model::ModelBuilder::new("circle");
    builder.add_link(dualbody::model::LinkSpec::new("world"));
    builder.add_link(dualbody::model::LinkSpec::new("arm").with_mass(1.0, [0.0; 3], [1.0; 3]));
    builder.add_joint(dualbody::model::JointSpec::new(
        "hinge",
        dualbody::joint::JointKind::Revolute,
        "world",
        "arm",
    ));
    builder.add_frame(
        "tip",
        "arm",
        dualbody::spatial::Transform::from_translation(Vector3::new(0.0, 2.0, 0.0)),
    );
    let circle = builder.build().expect("an arm");
    let tip = circle.frame("tip").expect("the tip");
    let a = frame_bias_acceleration(
        &circle,
        &[0.0],
        &[3.0],
        tip,
        dualbody::spatial::Representation::Mixed,
    );
    assert!(
        (a.linear - Vector3::new(0.0, -18.0, 0.0)).norm() < 1e-13,
        "{:?} on {}",
        a,
        model.name()
    );
}

#[test]
fn center_of_mass_velocity_and_jacobian_equal_the_rate_of_its_position() {
    for_all(|model, point, what| {
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        let expected = rate(model, point, 3, Quantity::CenterOfMass);
        let actual = center_of_mass_velocity(model, q, v);
        assert_close_vector(&vector(actual.as_slice()), &expected, SAME_ALGEBRA, what);
        assert_close_vector(
            &(center_of_mass_jacobian(model, q) * &point.v),
            &expected,
            SAME_ALGEBRA,
            what,
        );
    });
}

#[test]
fn momentum_matrix_times_velocity_equals_momentum_in_every_frame() {
    for_all(|model, point, what| {
        for frame in MOMENTUM_FRAMES {
            let actual = momentum_matrix(model, point.q.as_slice(), frame) * &point.v;
            let expected =
                momentum(model, point.q.as_slice(), point.v.as_slice(), frame).to_array();
            assert_close_vector(
                &actual,
                &vector(&expected),
                SAME_ALGEBRA,
                &format!("{what}, {frame:?}"),
            );
        }
    });
}

#[test]
fn centroidal_momentum_rate_equals_the_rate_of_the_momentum() {
    for_all(|model, point, what| {
        let actual = centroidal_momentum_rate(
            model,
            point.q.as_slice(),
            point.v.as_slice(),
            point.w.as_slice(),
        );
        let expected = rate(
            model,
            point,
            6,
            Quantity::Momentum(MomentumFrame::Centroidal),
        );
        assert_close_vector(&vector(&actual.to_array()), &expected, SAME_ALGEBRA, what);
        let com = center_of_mass_acceleration(
            model,
            point.q.as_slice(),
            point.v.as_slice(),
            point.w.as_slice(),
        );
        assert!(
            (com * model.total_mass() - actual.linear).norm() < OTHER_ALGORITHM,
            "{what}"
        );
    });
}

#[test]
fn momentum_matrix_and_its_rate_make_the_momentum_rate() {
    for_all(|model, point, what| {
        let (q, v, a) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        let rate = centroidal_momentum_matrix_derivative(model, q, v) * &point.v;
        let actual = centroidal_momentum_matrix(model, q) * &point.w + rate;
        let expected = centroidal_momentum_rate(model, q, v, a).to_array();
        assert_close_vector(&actual, &vector(&expected), SAME_ALGEBRA, what);
    });
}

// d(T + U)/dt = vᵀ τ + Σ V · F for the accelerations that τ and the external forces produce.
#[test]
fn energy_rate_equals_the_power_of_joint_and_external_forces() {
    for_all(|model, point, what| {
        let (q, v, tau) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        let kinematics = forward_kinematics(model, q, v);
        let last = FrameId(model.frames().len() - 1);
        let force = Force::from_array([0.3, -1.0, 0.7, 2.0, 0.1, -0.4]);
        for representation in REPRESENTATIONS {
            let mut external = vec![Force::zero(); model.n_bodies()];
            add_frame_force(
                model,
                &kinematics,
                last,
                &force,
                representation,
                &mut external,
            );
            let mut a = DVector::zeros(model.nv());
            forward_dynamics_into(
                model,
                q,
                v,
                tau,
                &external,
                &mut AbaScratch::new(model),
                a.as_mut_slice(),
            );
            let at = Point {
                q: point.q.clone(),
                v: point.v.clone(),
                w: a,
            };
            let energy_rate = rate(model, &at, 1, Quantity::Energy)[0];
            let power = point.v.dot(&point.w)
                + frame_velocity(model, q, v, last, representation).power(&force);
            assert!(
                (energy_rate - power).abs() < OTHER_ALGORITHM * power.abs().max(1.0),
                "{what}: {energy_rate} against {power}"
            );
        }
    });
}

// A free robot: ḣ = m g at the centre of mass, no moment, for any motion of its joints.
#[test]
fn momentum_rate_of_a_free_robot_equals_its_weight() {
    for model in [free_body(), floating_robot()] {
        let point = random_point(&model, 8);
        let mut tau = point.w.clone();
        tau.rows_mut(0, 6).fill(0.0);
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        let a = forward_dynamics(&model, q, v, tau.as_slice());
        let rate = centroidal_momentum_rate(&model, q, v, a.as_slice());
        assert!(
            (rate.linear - model.gravity() * model.total_mass()).norm() < 1e-10,
            "{}",
            model.name()
        );
        assert!(
            rate.angular.norm() < 1e-10,
            "{}: {}",
            model.name(),
            rate.angular
        );
    }
}

// With every joint locked the robot is one body: in the base frame its inertia is the top left block of the mass
// matrix.
#[test]
fn locked_inertia_in_the_base_equals_the_base_block_of_the_mass_matrix() {
    for model in [free_body(), floating_robot()] {
        let point = random_point(&model, 9);
        let m = mass_matrix(&model, point.q.as_slice());
        let locked = locked_inertia(&model, point.q.as_slice(), MomentumFrame::Base).to_matrix();
        assert_close(
            &m.view((0, 0), (6, 6)).into(),
            &DMatrix::from_column_slice(6, 6, locked.as_slice()),
            SAME_ALGEBRA,
            model.name(),
        );
        let matrix = momentum_matrix(&model, point.q.as_slice(), MomentumFrame::Base);
        assert_close(&m.rows(0, 6).into(), &matrix, SAME_ALGEBRA, model.name());
    }
}

// The mean motion carries the whole momentum: I V̄ = h; the rest of the kinetic energy is internal, and never negative.
#[test]
fn average_velocity_carries_the_momentum() {
    for model in [
        free_body(),
        floating_robot(),
        dualbody::model::samples::random_tree(8, 1),
    ] {
        let point = random_point(&model, 10);
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        for frame in MOMENTUM_FRAMES {
            let (mean, inertia) = (
                average_velocity(&model, q, v, frame),
                locked_inertia(&model, q, frame),
            );
            let h: Force<f64> = inertia.times(&mean);
            let expected = momentum(&model, q, v, frame);
            assert_close_vector(
                &vector(&h.to_array()),
                &vector(&expected.to_array()),
                OTHER_ALGORITHM,
                model.name(),
            );
            assert!(
                0.5 * mean.power(&h) <= kinetic_energy(&model, q, v) + 1e-12,
                "{}",
                model.name()
            );
            let from_jacobian = average_velocity_jacobian(&model, q, frame) * &point.v;
            assert_close_vector(
                &from_jacobian,
                &vector(&mean.to_array()),
                OTHER_ALGORITHM,
                model.name(),
            );
        }
    }
}

#[test]
fn centroidal_functions_are_those_of_the_centroidal_frame() {
    let model = floating_robot();
    let point = random_point(&model, 11);
    let (q, v) = (point.q.as_slice(), point.v.as_slice());
    assert_eq!(
        centroidal_momentum(&model, q, v),
        momentum(&model, q, v, MomentumFrame::Centroidal)
    );
    assert_eq!(
        centroidal_momentum_matrix(&model, q),
        momentum_matrix(&model, q, MomentumFrame::Centroidal)
    );
    let com = locked_inertia(&model, q, MomentumFrame::Centroidal).com();
    assert!(com.norm() < 10.0 * ROUNDING, "{com}");
    assert!(frame_pose(&model, q, FrameId(0)).translation.norm() > 0.0);
}
