//! Dynamics as linear functions of the inertial parameters.

use dualbody::autodiff::{VectorFunction, finite_difference, gradient, jacobian};
use dualbody::dynamics::{
    inertial_parameters, inverse_dynamics, joint_torque_regressor, kinetic_energy,
    kinetic_energy_regressor, potential_energy, potential_energy_regressor,
    with_inertial_parameters,
};
use dualbody::spatial::{INERTIAL_PARAMETERS, Inertia};
use dualbody::{Model, Scalar};
use nalgebra::DVector;

use crate::common::{
    FINITE_DIFFERENCE, Point, SAME_ALGEBRA, assert_close_vector, random_point, robots,
};

fn for_all(check: impl Fn(&Model, &Point, &DVector<f64>)) {
    for model in robots() {
        for seed in 0..2 {
            check(
                &model,
                &random_point(&model, seed),
                &inertial_parameters(&model),
            );
        }
    }
}

#[test]
fn torque_regressor_times_parameters_equals_inverse_dynamics_without_rotors() {
    for_all(|model, point, parameters| {
        let (q, v, a) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        let rotors = DVector::from_fn(model.nv(), |k, _| model.armature()[k] * a[k]);
        let actual = joint_torque_regressor(model, q, v, a) * parameters + rotors;
        assert_close_vector(
            &actual,
            &inverse_dynamics(model, q, v, a),
            SAME_ALGEBRA,
            model.name(),
        );
    });
}

#[test]
fn energy_regressors_times_parameters_equal_the_energies() {
    for_all(|model, point, parameters| {
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        let rotors: f64 = v
            .iter()
            .zip(model.armature())
            .map(|(v, a)| 0.5 * v * v * a)
            .sum();
        let kinetic = (kinetic_energy_regressor(model, q, v) * parameters)[0] + rotors;
        assert!(
            (kinetic - kinetic_energy(model, q, v)).abs() < SAME_ALGEBRA * kinetic.abs().max(1.0),
            "{}",
            model.name()
        );
        let potential = (potential_energy_regressor(model, q) * parameters)[0];
        assert!(
            (potential - potential_energy(model, q)).abs()
                < SAME_ALGEBRA * potential.abs().max(1.0),
            "{}",
            model.name()
        );
    });
}

// The regressor belongs to the structure: other parameters, the same Y.
#[test]
fn regressor_predicts_the_torques_of_another_body_set() {
    for_all(|model, point, parameters| {
        let (q, v, a) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        let other = parameters.map(|p| 1.3 * p + 0.01);
        let changed = with_inertial_parameters(model, other.as_slice());
        let difference = inverse_dynamics(&changed, q, v, a) - inverse_dynamics(model, q, v, a);
        let expected = joint_torque_regressor(model, q, v, a) * (&other - parameters);
        assert_close_vector(&difference, &expected, SAME_ALGEBRA, model.name());
        assert_close_vector(
            &inertial_parameters(&changed),
            &other,
            SAME_ALGEBRA,
            model.name(),
        );
    });
}

/// Squared torque error of a robot whose bodies have the given log-Cholesky parameters.
struct TorqueError<'a> {
    model: &'a Model,
    point: &'a Point,
    measured: &'a DVector<f64>,
}

impl VectorFunction for TorqueError<'_> {
    fn n_outputs(&self) -> usize {
        1
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let lift = |x: &DVector<f64>| x.iter().map(|&x| T::constant(x)).collect::<Vec<T>>();
        let bodies = x
            .chunks(INERTIAL_PARAMETERS)
            .map(|x| Inertia::from_log_cholesky(std::array::from_fn(|k| x[k])));
        let parameters: Vec<T> = bodies.flat_map(|inertia| inertia.to_parameters()).collect();
        let model = with_inertial_parameters(&self.model.cast::<T>(), &parameters);
        let tau = inverse_dynamics(
            &model,
            &lift(&self.point.q),
            &lift(&self.point.v),
            &lift(&self.point.w),
        );
        y[0] = tau
            .iter()
            .zip(self.measured)
            .fold(T::zero(), |sum, (&tau, &m)| {
                let error = tau - m;
                sum + error * error
            });
    }
}

// Gradient descent in log-Cholesky parameters lowers the error and every iterate is a possible body.
#[test]
fn identification_step_in_log_cholesky_parameters_descends_and_stays_physical() {
    let model = dualbody::model::samples::arm();
    let point = random_point(&model, 3);
    let measured = inverse_dynamics(
        &model,
        point.q.as_slice(),
        point.v.as_slice(),
        point.w.as_slice(),
    ) * 1.1;
    let f = TorqueError {
        model: &model,
        point: &point,
        measured: &measured,
    };
    let x: Vec<f64> = model
        .bodies()
        .iter()
        .flat_map(|body| body.inertia.to_log_cholesky())
        .collect();
    let error = |x: &[f64]| {
        let mut y = [0.0];
        f.eval(x, &mut y);
        y[0]
    };
    let slope = gradient(&f, &x);
    let stepped: Vec<f64> = x.iter().zip(&slope).map(|(x, g)| x - 1e-6 * g).collect();
    let expected = error(&x) - 1e-6 * slope.norm_squared();
    assert!(
        (error(&stepped) - expected).abs() < 1e-2 * (error(&x) - expected),
        "{} against {expected}",
        error(&stepped)
    );
    for body in stepped.chunks(INERTIAL_PARAMETERS) {
        let pseudo =
            Inertia::from_log_cholesky(std::array::from_fn(|k| body[k])).to_pseudo_inertia();
        assert!(pseudo.cholesky().is_some());
    }
}

/// Inverse dynamics as a function of a shift of every joint's origin along its parent's axes.
struct Shifted<'a>(&'a Model, &'a Point);

impl VectorFunction for Shifted<'_> {
    fn n_outputs(&self) -> usize {
        self.0.nv()
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let mut model = self.0.cast::<T>();
        for (joint, shift) in self.0.joints().iter().zip(x.chunks(3)) {
            let mut placement = model.body(joint.body).placement;
            placement.translation += nalgebra::Vector3::new(shift[0], shift[1], shift[2]);
            model = model.with_placement(joint.body, placement);
        }
        let lift = |x: &DVector<f64>| x.iter().map(|&x| T::constant(x)).collect::<Vec<T>>();
        let Point { q, v, w } = self.1;
        y.copy_from_slice(inverse_dynamics(&model, &lift(q), &lift(v), &lift(w)).as_slice());
    }
}

#[test]
fn derivative_of_torques_in_joint_placements_equals_finite_differences() {
    for model in robots() {
        let point = random_point(&model, 4);
        let f = Shifted(&model, &point);
        let x = vec![0.0; 3 * model.n_joints()];
        let (exact, numeric) = (jacobian(&f, &x), finite_difference::jacobian(&f, &x));
        crate::common::assert_close(&exact, &numeric, FINITE_DIFFERENCE, model.name());
    }
}

#[test]
fn moved_joint_survives_in_the_description() {
    for model in robots().into_iter().filter(|model| model.n_joints() > 0) {
        let joint = &model.joints()[model.n_joints() - 1];
        let mut placement = model.body(joint.body).placement;
        placement.translation.x += 0.25;
        let moved = model.clone().with_placement(joint.body, placement);
        let again = moved.to_builder().build().expect("the same robot");
        let error = again.body(joint.body).placement.translation - placement.translation;
        assert!(error.norm() < SAME_ALGEBRA, "{}: {error}", model.name());
    }
}
