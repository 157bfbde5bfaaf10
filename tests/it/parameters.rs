//! Derivatives in the robot's parameters; dynamics as linear functions of the inertial ones.

use std::collections::HashSet;

use dualbody::autodiff::{VectorFunction, finite_difference, gradient, jacobian};
use dualbody::dynamics::{
    elastic_energy, forward_dynamics, inverse_dynamics, joint_torque_regressor, kinetic_energy,
    kinetic_energy_regressor, potential_energy, potential_energy_regressor,
};
use dualbody::model::ParameterGroup;
use dualbody::spatial::{INERTIAL_PARAMETERS, Inertia};
use dualbody::{Model, Scalar, Simulator, State};
use nalgebra::{DMatrix, DVector};

use crate::common::{
    FINITE_DIFFERENCE, Point, SAME_ALGEBRA, assert_close, assert_close_vector, gripper,
    random_point, robots,
};

/// The inertial parameters of all bodies.
fn inertial_parameters(model: &Model) -> DVector<f64> {
    let inertial = model.parameter_layout().inertial();
    model.parameters().rows(0, inertial.end).into()
}

/// The robot with other inertial parameters.
fn with_inertial_parameters<T: Scalar>(model: &Model, inertial: &[T]) -> Model<T> {
    let indices: Vec<usize> = model.parameter_layout().inertial().collect();
    model.with_some_parameters(&indices, inertial)
}

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
        let model = with_inertial_parameters(self.model, &parameters);
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

/// Results for a robot at a point, as a function of all its parameters: their nominal values and `SCALE` times the
/// argument.
struct Behaviour<'a>(&'a Model, &'a Point);

/// Small against the least mass and inertia of the robots, so that finite steps keep them positive.
const SCALE: f64 = 1e-2;

impl VectorFunction for Behaviour<'_> {
    fn n_outputs(&self) -> usize {
        self.0.nq() + 3 * self.0.nv() + 3
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let nominal = self.0.parameters();
        let parameters: Vec<T> = (x.iter().zip(&nominal))
            .map(|(&x, &p)| x * SCALE + p)
            .collect();
        let model = self.0.with_parameters(&parameters);
        let lift = |x: &DVector<f64>| x.iter().map(|&x| T::constant(x)).collect::<Vec<T>>();
        let (q, v, w) = (lift(&self.1.q), lift(&self.1.v), lift(&self.1.w));
        let simulator = Simulator::new(model.clone()).with_time_step(0.01);
        let u: Vec<T> = simulator.actuated().iter().map(|&k| w[k]).collect();
        let next = simulator.step(&State::new(&q, &v), &u);
        let energies = [
            kinetic_energy(&model, &q, &v),
            potential_energy(&model, &q),
            elastic_energy(&model, &q),
        ];
        let forces = inverse_dynamics(&model, &q, &v, &w);
        let accelerations = forward_dynamics(&model, &q, &v, &w);
        let all = [&forces, &accelerations, &next.q, &next.v];
        let all = all.into_iter().flatten().copied().chain(energies);
        y.iter_mut().zip(all).for_each(|(y, x)| *y = x);
    }
}

#[test]
fn derivative_of_forces_accelerations_step_and_energies_in_all_parameters_equals_finite_differences()
 {
    for model in robots() {
        let point = random_point(&model, 4);
        let f = Behaviour(&model, &point);
        let x = vec![0.0; model.parameters().len()];
        let (exact, numeric) = (jacobian(&f, &x), finite_difference::jacobian(&f, &x));
        let layout = model.parameter_layout();
        for (k, name) in layout.names().iter().enumerate() {
            let column = |j: &DMatrix<f64>| DMatrix::from_columns(&[j.column(k)]);
            let what = format!("{}, {name}", model.name());
            assert_close(&column(&exact), &column(&numeric), FINITE_DIFFERENCE, &what);
        }
    }
}

#[test]
fn derivative_of_torques_in_inertial_parameters_equals_the_regressor() {
    for model in robots() {
        let point = random_point(&model, 5);
        let (q, v, a) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        let x = vec![0.0; model.parameters().len()];
        let exact = jacobian(&Behaviour(&model, &point), &x) / SCALE;
        let inertial = model.parameter_layout().inertial();
        assert_close(
            &exact.view((0, 0), (model.nv(), inertial.len())).into(),
            &joint_torque_regressor(&model, q, v, a),
            SAME_ALGEBRA,
            model.name(),
        );
    }
}

#[test]
fn robot_with_its_own_parameters_equals_itself() {
    for model in robots() {
        let parameters = model.parameters();
        let same = model.with_parameters(parameters.as_slice());
        let numbers = |model: &Model| {
            let (bodies, springs) = (model.bodies(), model.springs());
            let (damping, armature) = (model.damping(), model.armature());
            format!(
                "{bodies:?} {:?} {damping:?} {armature:?} {springs:?}",
                model.gravity()
            )
        };
        assert_eq!(numbers(&same), numbers(&model));
        for (same, frame) in same.frames().iter().zip(model.frames()) {
            assert_eq!(same.placement, frame.placement, "{}", frame.name);
        }
        // All but the increments come back as they were set.
        let other = parameters.map(|p| 1.1 * p + 0.01);
        let changed = model.with_parameters(other.as_slice()).parameters();
        let layout = model.parameter_layout();
        for (group, range) in layout.groups() {
            for k in range.clone() {
                let is_increment = matches!(
                    group,
                    ParameterGroup::Placement(_) | ParameterGroup::Frame(_)
                );
                let expected = if is_increment { 0.0 } else { other[k] };
                assert_eq!(
                    changed[k],
                    expected,
                    "{}, {}",
                    model.name(),
                    layout.names()[k]
                );
            }
        }
    }
}

#[test]
fn named_parameters_equal_the_data_that_the_setters_set() {
    let model = gripper()
        .build()
        .expect("a robot that is known to be right");
    let layout = model.parameter_layout();
    let changed = |name: &str, value: f64| {
        let k = layout.find(name).expect("a name of the layout");
        model.with_some_parameters(&[k], &[value])
    };
    let (elbow, left) = (
        model.joint("elbow_joint").unwrap(),
        model.joint("left_joint").unwrap(),
    );
    assert_eq!(
        changed("elbow_joint: damping", 7.0).damping()[model.joint_v(elbow).start],
        7.0
    );
    assert_eq!(
        changed("left_joint: armature", 7.0).armature()[model.joint_v(left).start],
        7.0
    );
    assert_eq!(
        changed("left_joint: rest", 7.0).springs()[model.joint_v(left).start].rest,
        7.0
    );
    assert_eq!(changed("world: gravity y", 7.0).gravity().y, 7.0);
    let thumb = model.joint_body(model.joint("thumb_joint").unwrap());
    assert_eq!(changed("thumb: mass", 7.0).body(thumb).inertia.mass, 7.0);
    // A shift along the joint's own z axis, and a turn about it.
    let nominal = model.body(thumb).placement;
    let shifted = changed("thumb_joint: shift z", 0.5).body(thumb).placement;
    let along = shifted.translation - nominal.translation;
    assert_eq!(along, nominal.rotation.column(2) * 0.5);
    let turned = changed("thumb_joint: turn z", 0.5).body(thumb).placement;
    let turn = nominal.rotation.transpose() * turned.rotation;
    assert!(
        (turn[(1, 0)] - 0.5_f64.sin()).abs() < SAME_ALGEBRA,
        "{turn}"
    );
    // So does a frame, along its own axes.
    let thumb = model.frame("thumb").expect("a link");
    let nominal = model.frames()[thumb.0].placement;
    let shifted = changed("frame thumb: shift y", 0.5).frames()[thumb.0].placement;
    let along = shifted.translation - nominal.translation;
    assert!((along - nominal.rotation.column(1) * 0.5).amax() < SAME_ALGEBRA);
    // Followers have no spring, damping or rotor of their own.
    assert!(layout.find("thumb_joint: damping").is_err());
    // The message has the first forty names.
    let error = layout.find("elbow: dampign").unwrap_err().to_string();
    let more = format!(" and {} more", layout.names().len() - 40);
    for part in ["elbow: dampign", "elbow: mass", &more] {
        assert!(error.contains(part), "{part} is not in: {error}");
    }
}

#[test]
fn names_of_all_parameters_differ_and_their_ranges_fill_the_vector() {
    for model in robots() {
        let layout = model.parameter_layout();
        let names: HashSet<&String> = layout.names().iter().collect();
        assert_eq!(
            (names.len(), layout.names().len()),
            (layout.names().len(), model.parameters().len())
        );
        let ends = layout.groups().iter().scan(0, |at, (group, range)| {
            assert_eq!(range.start, *at, "{group:?}");
            assert_eq!(layout.range(*group), Some(range.clone()));
            *at = range.end;
            Some(*at)
        });
        assert_eq!(ends.last(), Some(layout.names().len()), "{}", model.name());
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
