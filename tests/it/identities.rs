//! Laws of mechanics that hold for every robot.

use dualbody::autodiff::{VectorFunction, gradient, jacobian};
use dualbody::dynamics::{
    AbaScratch, Kinematics, MassMatrixFactor, RneaScratch, add_frame_force, bias_forces,
    bias_forces_into, center_of_mass, coriolis_matrix, forward_dynamics, forward_dynamics_into,
    forward_kinematics, frame_jacobian, frame_pose, frame_velocity, gravity_forces,
    inverse_dynamics, inverse_dynamics_into, kinetic_energy, mass_matrix, mass_matrix_inverse,
    potential_energy,
};
use dualbody::model::{BodyId, FrameId, samples};
use dualbody::spatial::{Force, Motion, Representation};
use dualbody::{Integrator, Model, Scalar, Simulator, State};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::common::everything::REPRESENTATIONS;
use crate::common::{
    OTHER_ALGORITHM, Point, SAME_ALGEBRA, assert_close, assert_close_vector, floating_robot,
    free_body, random_point, robots,
};

const SEEDS: std::ops::Range<u64> = 0..3;

/// Runs a check on every robot at several random points.
fn for_all(check: impl Fn(&Model, &Point, &str)) {
    for model in robots() {
        for seed in SEEDS {
            check(
                &model,
                &random_point(&model, seed),
                &format!("{}, seed {seed}", model.name()),
            );
        }
    }
}

/// A scalar function of δq at a configuration.
struct OfConfiguration<'a, F> {
    model: &'a Model,
    q: &'a DVector<f64>,
    f: F,
}

/// The energy that a test differentiates.
enum Energy<'a> {
    Potential,
    Kinetic(&'a DVector<f64>),
}

impl VectorFunction for OfConfiguration<'_, Energy<'_>> {
    fn n_outputs(&self) -> usize {
        1
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let q = self.model.integrate(self.q.map(T::constant).as_slice(), x);
        y[0] = match self.f {
            Energy::Potential => potential_energy(self.model, q.as_slice()),
            Energy::Kinetic(v) => {
                kinetic_energy(self.model, q.as_slice(), v.map(T::constant).as_slice())
            }
        };
    }
}

#[test]
fn mass_matrix_columns_equal_inverse_dynamics_of_unit_accelerations() {
    for_all(|model, point, what| {
        let (q, zero) = (point.q.as_slice(), DVector::zeros(model.nv()));
        let still = model.clone().with_gravity(Vector3::zeros());
        let columns: Vec<_> = (0..model.nv())
            .map(|k| {
                let mut unit = zero.clone();
                unit[k] = 1.0;
                inverse_dynamics(&still, q, zero.as_slice(), unit.as_slice())
            })
            .collect();
        let expected = if columns.is_empty() {
            DMatrix::zeros(0, 0)
        } else {
            DMatrix::from_columns(&columns)
        };
        assert_close(&mass_matrix(model, q), &expected, SAME_ALGEBRA, what);
    });
}

#[test]
fn mass_matrix_is_symmetric_and_positive_definite() {
    for_all(|model, point, what| {
        let m = mass_matrix(model, point.q.as_slice());
        assert_eq!(m, m.transpose(), "{what}");
        assert!(m.cholesky().is_some(), "{what}");
    });
}

#[test]
fn kinetic_energy_equals_half_v_m_v() {
    for_all(|model, point, what| {
        let (q, v) = (point.q.as_slice(), &point.v);
        let expected = 0.5 * v.dot(&(mass_matrix(model, q) * v));
        let actual = kinetic_energy(model, q, v.as_slice());
        assert!(
            (actual - expected).abs() <= SAME_ALGEBRA * expected.max(1.0),
            "{what}: {actual} against {expected}"
        );
    });
}

#[test]
fn gravity_forces_equal_the_gradient_of_the_potential_energy() {
    for_all(|model, point, what| {
        let energy = OfConfiguration {
            model,
            q: &point.q,
            f: Energy::Potential,
        };
        let expected = gradient(&energy, &vec![0.0; model.nv()]);
        assert_close_vector(
            &gravity_forces(model, point.q.as_slice()),
            &expected,
            SAME_ALGEBRA,
            what,
        );
    });
}

#[test]
fn bias_forces_at_rest_equal_gravity_forces() {
    for_all(|model, point, what| {
        let (q, zero) = (point.q.as_slice(), vec![0.0; model.nv()]);
        assert_close_vector(
            &bias_forces(model, q, &zero),
            &gravity_forces(model, q),
            SAME_ALGEBRA,
            what,
        );
    });
}

#[test]
fn forward_dynamics_inverts_inverse_dynamics() {
    for_all(|model, point, what| {
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        let tau = inverse_dynamics(model, q, v, point.w.as_slice());
        assert_close_vector(
            &forward_dynamics(model, q, v, tau.as_slice()),
            &point.w,
            OTHER_ALGORITHM,
            what,
        );
    });
}

#[test]
fn articulated_body_algorithm_equals_solving_with_the_mass_matrix() {
    for_all(|model, point, what| {
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        let free = &point.w - bias_forces(model, q, v);
        let expected = mass_matrix(model, q)
            .cholesky()
            .expect("positive definite")
            .solve(&free);
        assert_close_vector(
            &forward_dynamics(model, q, v, point.w.as_slice()),
            &expected,
            OTHER_ALGORITHM,
            what,
        );
    });
}

// With constant v along q ⊕ t v, dT/dt = ½ vᵀ Ṁ v; and Ṁ − 2C is skew-symmetric: vᵀ (h − g) = ½ vᵀ Ṁ v.
#[test]
fn power_of_velocity_forces_equals_half_v_mdot_v() {
    for_all(|model, point, what| {
        let (q, v) = (point.q.as_slice(), &point.v);
        let energy = OfConfiguration {
            model,
            q: &point.q,
            f: Energy::Kinetic(v),
        };
        let rate = gradient(&energy, &vec![0.0; model.nv()]).dot(v);
        let power = v.dot(&(bias_forces(model, q, v.as_slice()) - gravity_forces(model, q)));
        assert!(
            (power - rate).abs() < OTHER_ALGORITHM * rate.abs().max(1.0),
            "{what}: {power} against {rate}"
        );
    });
}

/// The mass matrix as a function of δq, column by column.
struct MassMatrix<'a>(&'a Model, &'a DVector<f64>);
impl VectorFunction for MassMatrix<'_> {
    fn n_outputs(&self) -> usize {
        self.0.nv() * self.0.nv()
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let q = self.0.integrate(self.1.map(T::constant).as_slice(), x);
        y.copy_from_slice(mass_matrix(self.0, q.as_slice()).as_slice());
    }
}

#[test]
fn coriolis_matrix_times_velocity_equals_bias_without_gravity() {
    for_all(|model, point, what| {
        let (q, v) = (point.q.as_slice(), &point.v);
        let expected = bias_forces(model, q, v.as_slice()) - gravity_forces(model, q);
        assert_close_vector(
            &(coriolis_matrix(model, q, v.as_slice()) * v),
            &expected,
            SAME_ALGEBRA,
            what,
        );
    });
}

#[test]
fn mass_matrix_rate_minus_twice_coriolis_is_skew_symmetric() {
    for_all(|model, point, what| {
        let nv = model.nv();
        let rate = jacobian(&MassMatrix(model, &point.q), &vec![0.0; nv]) * &point.v;
        let rate = DMatrix::from_column_slice(nv, nv, rate.as_slice());
        let skew = rate - coriolis_matrix(model, point.q.as_slice(), point.v.as_slice()) * 2.0;
        assert_close(&skew, &-skew.transpose(), SAME_ALGEBRA, what);
    });
}

#[test]
fn direct_inverse_times_mass_matrix_is_the_identity() {
    for_all(|model, point, what| {
        let q = point.q.as_slice();
        let product = mass_matrix_inverse(model, q) * mass_matrix(model, q);
        assert_close(
            &product,
            &DMatrix::identity(model.nv(), model.nv()),
            OTHER_ALGORITHM,
            what,
        );
    });
}

#[test]
fn tree_sparse_solve_equals_dense_cholesky() {
    for_all(|model, point, what| {
        let m = mass_matrix(model, point.q.as_slice());
        let mut x = point.w.clone();
        MassMatrixFactor::new(model, &m).solve(x.as_mut_slice());
        assert_close_vector(
            &x,
            &m.cholesky().expect("positive definite").solve(&point.w),
            OTHER_ALGORITHM,
            what,
        );
    });
}

#[test]
fn external_force_acts_as_the_transposed_jacobian() {
    let force = Force::from_array([0.3, -1.0, 0.7, 2.0, 0.1, -0.4]);
    for_all(|model, point, what| {
        let (q, v, a) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        let kinematics = forward_kinematics(model, q, v);
        for frame in (0..model.frames().len()).map(FrameId) {
            for representation in REPRESENTATIONS {
                let mut external = vec![Force::zero(); model.n_bodies()];
                add_frame_force(
                    model,
                    &kinematics,
                    frame,
                    &force,
                    representation,
                    &mut external,
                );
                let mut tau = DVector::zeros(model.nv());
                inverse_dynamics_into(
                    model,
                    q,
                    v,
                    a,
                    &external,
                    &mut RneaScratch::new(model),
                    tau.as_mut_slice(),
                );
                let jacobian = frame_jacobian(model, q, frame, representation);
                let f = DVector::from_column_slice(&force.to_array());
                let expected = inverse_dynamics(model, q, v, a) - jacobian.transpose() * f;
                assert_close_vector(
                    &tau,
                    &expected,
                    SAME_ALGEBRA,
                    &format!("{what}, {frame:?}, {representation:?}"),
                );
            }
        }
    });
}

#[test]
fn forward_dynamics_inverts_inverse_dynamics_with_external_forces() {
    for_all(|model, point, what| {
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        let external: Vec<_> = (0..model.n_bodies())
            .map(|k| Force::from_array([0.3, -1.0, 0.7, 2.0, 0.1, k as f64]))
            .collect();
        let (mut tau, mut a, mut bias) = (
            DVector::zeros(model.nv()),
            DVector::zeros(model.nv()),
            DVector::zeros(model.nv()),
        );
        let mut scratch = RneaScratch::new(model);
        inverse_dynamics_into(
            model,
            q,
            v,
            point.w.as_slice(),
            &external,
            &mut scratch,
            tau.as_mut_slice(),
        );
        forward_dynamics_into(
            model,
            q,
            v,
            tau.as_slice(),
            &external,
            &mut AbaScratch::new(model),
            a.as_mut_slice(),
        );
        assert_close_vector(&a, &point.w, OTHER_ALGORITHM, what);
        bias_forces_into(model, q, v, &external, &mut scratch, bias.as_mut_slice());
        assert_close_vector(
            &(tau - bias),
            &(mass_matrix(model, q) * &point.w),
            SAME_ALGEBRA,
            what,
        );
    });
}

#[test]
fn frame_jacobian_times_velocity_equals_frame_velocity_in_every_representation() {
    for_all(|model, point, what| {
        let (q, v) = (point.q.as_slice(), &point.v);
        for frame in (0..model.frames().len()).map(FrameId) {
            for representation in REPRESENTATIONS {
                let actual = frame_jacobian(model, q, frame, representation) * v;
                let expected =
                    frame_velocity(model, q, v.as_slice(), frame, representation).to_array();
                assert_close_vector(
                    &actual,
                    &DVector::from_column_slice(&expected),
                    SAME_ALGEBRA,
                    what,
                );
            }
        }
    });
}

/// The pose of the last frame as a function of δq: columns of the rotation, then the translation.
struct LastPose<'a>(&'a Model, &'a DVector<f64>);
impl VectorFunction for LastPose<'_> {
    fn n_outputs(&self) -> usize {
        12
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let q = self.0.integrate(self.1.map(T::constant).as_slice(), x);
        let pose = frame_pose(self.0, q.as_slice(), FrameId(self.0.frames().len() - 1));
        y[..9].copy_from_slice(pose.rotation.as_slice());
        y[9..].copy_from_slice(pose.translation.as_slice());
    }
}

// Mixed: (ṗ, ω) with Ṙ = [ω] R. Body: Rᵀ of it. Inertial: linear part ṗ − ω × p, the point at the world's origin.
#[test]
fn frame_velocity_equals_the_rate_of_the_pose_in_every_representation() {
    for_all(|model, point, what| {
        let (q, v) = (point.q.as_slice(), &point.v);
        let last = FrameId(model.frames().len() - 1);
        let rate = jacobian(&LastPose(model, &point.q), &vec![0.0; model.nv()]) * v;
        let pose = frame_pose(model, q, last);
        let r_dot = Matrix3::from_column_slice(&rate.as_slice()[..9]) * pose.rotation.transpose();
        let (p_dot, omega) = (
            Vector3::from_column_slice(&rate.as_slice()[9..]),
            Vector3::new(r_dot.m32, r_dot.m13, r_dot.m21),
        );
        let to_body = pose.rotation.transpose();
        for (representation, expected) in [
            (Representation::Mixed, Motion::new(p_dot, omega)),
            (
                Representation::Body,
                Motion::new(to_body * p_dot, to_body * omega),
            ),
            (
                Representation::Inertial,
                Motion::new(p_dot - omega.cross(&pose.translation), omega),
            ),
        ] {
            let actual = frame_velocity(model, q, v.as_slice(), last, representation);
            let error = (actual - expected)
                .to_array()
                .iter()
                .fold(0.0_f64, |max, x| max.max(x.abs()));
            assert!(
                error < SAME_ALGEBRA,
                "{what}, {representation:?}: {actual:?} against {expected:?}"
            );
        }
    });
}

#[test]
fn kinematics_of_bodies_agree_with_those_of_frames() {
    for_all(|model, point, what| {
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        let kinematics: Kinematics<f64> = forward_kinematics(model, q, v);
        for (i, frame) in model.frames().iter().enumerate() {
            let expected = kinematics.pose(frame.body) * frame.placement;
            assert!(
                (frame_pose(model, q, FrameId(i)).translation - expected.translation).norm()
                    < SAME_ALGEBRA,
                "{what}"
            );
            let V_F = frame
                .placement
                .motion_inverse(&kinematics.velocity(frame.body));
            let error = frame_velocity(model, q, v, FrameId(i), Representation::Body) - V_F;
            assert!(
                error.to_array().iter().all(|x| x.abs() < SAME_ALGEBRA),
                "{what}"
            );
        }
    });
}

/// Linear momentum and moment of momentum about the world's origin.
fn momentum(model: &Model, state: &State) -> Force<f64> {
    let kinematics = forward_kinematics(model, state.q.as_slice(), state.v.as_slice());
    let of_body = |i: usize| {
        let id = Some(BodyId(i));
        kinematics
            .pose(id)
            .force(&model.bodies()[i].inertia.times(&kinematics.velocity(id)))
    };
    (0..model.n_bodies())
        .map(of_body)
        .fold(Force::zero(), |sum, h| sum + h)
}

#[test]
fn momentum_of_a_floating_robot_changes_by_gravity_alone() {
    for model in [free_body(), floating_robot()] {
        let point = random_point(&model, 1);
        let simulator = Simulator::new(model)
            .with_time_step(1e-3)
            .with_integrator(Integrator::RungeKutta4);
        let start = State::new(point.q.as_slice(), point.v.as_slice());
        let steps = 500;
        let rollout = simulator.rollout(&start, steps, |time, _, u| {
            u.iter_mut()
                .enumerate()
                .for_each(|(k, u)| *u = (3.0 * time + k as f64).sin());
        });
        let model = simulator.model();
        let (before, after) = (momentum(model, &start), momentum(model, rollout.last()));
        let impulse = model.gravity() * (model.total_mass() * steps as f64 * simulator.time_step());
        assert!(
            (after.linear - before.linear - impulse).norm() < OTHER_ALGORITHM,
            "{}",
            model.name()
        );
        // The moment of gravity about the centre of mass is zero: the spin about it stays.
        let spin = |h: &Force<f64>, q: &DVector<f64>| {
            h.angular - center_of_mass(model, q.as_slice()).cross(&h.linear)
        };
        let change = spin(&after, &rollout.last().q) - spin(&before, &start.q);
        assert!(
            change.norm() < OTHER_ALGORITHM,
            "{}: {change}",
            model.name()
        );
    }
}

// d(T + U)/dt = vᵀ (u − d v), over a short step against its midpoint.
#[test]
fn energy_changes_by_the_power_of_inputs_and_damping() {
    for model in [
        samples::cartpole(),
        floating_robot(),
        samples::random_tree(7, 1),
    ] {
        let point = random_point(&model, 2);
        let h = 1e-5;
        let simulator = Simulator::new(model)
            .with_time_step(h)
            .with_integrator(Integrator::RungeKutta4);
        let model = simulator.model();
        let u: Vec<f64> = simulator.actuated().iter().map(|&k| point.w[k]).collect();
        let states = simulator
            .rollout(
                &State::new(point.q.as_slice(), point.v.as_slice()),
                2,
                |_, _, input| input.copy_from_slice(&u),
            )
            .states;
        let energy = |s: &State| {
            kinetic_energy(model, s.q.as_slice(), s.v.as_slice())
                + potential_energy(model, s.q.as_slice())
        };
        let v = &states[1].v;
        let mut tau = DVector::from_fn(model.nv(), |k, _| -model.damping()[k] * v[k]);
        simulator
            .actuated()
            .iter()
            .zip(&u)
            .for_each(|(&k, u)| tau[k] += u);
        let rate = (energy(&states[2]) - energy(&states[0])) / (2.0 * h);
        let power = v.dot(&tau);
        assert!(
            (rate - power).abs() < 1e-5 * power.abs().max(1.0),
            "{}: {rate} against {power}",
            model.name()
        );
    }
}
