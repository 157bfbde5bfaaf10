//! Every quantity with the velocity of the base in body, mixed and inertial representation, by identities that hold in each.

use dualbody::autodiff::{VectorFunction, jacobian};
use dualbody::contact::{ContactLaw, SoftContact, Terrain};
use dualbody::dynamics::{
    BaseFrame, MomentumFrame, center_of_mass_jacobian, centroidal_momentum_matrix,
    centroidal_momentum_matrix_derivative, centroidal_momentum_rate, forward_dynamics,
    frame_acceleration, frame_jacobian, frame_jacobian_derivative, frame_velocity,
    inverse_dynamics, momentum, momentum_matrix,
};
use dualbody::model::{FrameId, LinkSpec, Mass, samples};
use dualbody::spatial::Representation;
use dualbody::{Cast, Linearization, Model, Scalar, Simulator, State};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::common::base::{
    acceleration_from, acceleration_to, deviation_from, deviation_to, force_to, gradient_from,
    gradient_to, velocity_from, velocity_to,
};
use crate::common::ground::{body, on};
use crate::common::{
    FINITE_DIFFERENCE, OTHER_ALGORITHM, Point, SAME_ALGEBRA, assert_close, assert_close_vector,
    floating_robot, free_body, generator, random_point, random_tangent, robots,
};

/// A robot at a state, with its base in a representation.
struct Case<'a> {
    model: &'a Model,
    base: BaseFrame<'a>,
    r: Representation,
    /// `v` and `w` are in the crate's own representation.
    point: Point,
    /// The velocity in the representation.
    v: DVector<f64>,
    what: String,
}

impl Case<'_> {
    fn q(&self) -> &[f64] {
        self.point.q.as_slice()
    }

    fn v(&self) -> &[f64] {
        self.v.as_slice()
    }

    /// The motion in the crate's own representation of an acceleration in that of the base.
    fn own(&self, a: &[f64]) -> (DVector<f64>, DVector<f64>) {
        let v = velocity_from(self.model, self.q(), self.v(), self.r);
        let a = acceleration_from(self.model, self.q(), v.as_slice(), a, self.r);
        (v, a)
    }

    fn last_frame(&self) -> FrameId {
        FrameId(self.model.frames().len() - 1)
    }
}

fn for_all(check: impl Fn(&Case<'_>)) {
    for model in robots() {
        for r in Representation::ALL {
            let point = random_point(&model, 71);
            let v = velocity_to(&model, point.q.as_slice(), point.v.as_slice(), r);
            check(&Case {
                base: BaseFrame::new(&model, r),
                r,
                what: format!("{}, {r:?}", model.name()),
                model: &model,
                point,
                v,
            });
        }
    }
}

/// Matrices of a case at the configuration q ⊕ t v, as functions of time.
#[derive(Clone, Copy)]
enum Matrix {
    Mass,
    Frame(Representation),
    Momentum,
}

struct InTime<'a>(&'a Case<'a>, Matrix);

impl InTime<'_> {
    fn at<T: Scalar>(&self, q: &[T]) -> DMatrix<T> {
        let Case { base, model, .. } = self.0;
        match self.1 {
            Matrix::Mass => base.mass_matrix(q),
            Matrix::Frame(r) => base.jacobian(q, &frame_jacobian(model, q, self.0.last_frame(), r)),
            Matrix::Momentum => base.jacobian(q, &centroidal_momentum_matrix(model, q)),
        }
    }

    fn rate(&self) -> DMatrix<f64> {
        let shape = self.at::<f64>(self.0.q()).shape();
        let rate = jacobian(self, &[0.0]);
        DMatrix::from_column_slice(shape.0, shape.1, rate.as_slice())
    }
}

impl VectorFunction for InTime<'_> {
    fn n_outputs(&self) -> usize {
        self.at::<f64>(self.0.q()).len()
    }

    fn eval<T: Scalar>(&self, t: &[T], y: &mut [T]) {
        let dq: Vec<T> = self.0.point.v.iter().map(|&v| t[0] * v).collect();
        let q = self.0.point.q.map(T::constant);
        let q = self.0.model.integrate(q.as_slice(), &dq);
        y.copy_from_slice(self.at(q.as_slice()).as_slice());
    }
}

#[test]
fn forces_of_inverse_dynamics_equal_mass_matrix_times_acceleration_plus_bias() {
    for_all(|case| {
        let (q, v, a) = (case.q(), case.v(), case.point.w.as_slice());
        let tau = case.base.inverse_dynamics(q, v, a);
        let expected = case.base.mass_matrix(q) * &case.point.w + case.base.bias_forces(q, v);
        assert_close_vector(&tau, &expected, OTHER_ALGORITHM, &case.what);
        let back = case.base.forward_dynamics(q, v, tau.as_slice());
        assert_close_vector(&back, &case.point.w, OTHER_ALGORITHM, &case.what);
    });
}

#[test]
fn coriolis_matrix_times_velocity_is_the_bias_without_gravity() {
    for_all(|case| {
        let (q, v) = (case.q(), case.v());
        let left = case.base.coriolis_matrix(q, v) * &case.v;
        let right = case.base.bias_forces(q, v) - case.base.gravity_forces(q);
        assert_close_vector(&left, &right, OTHER_ALGORITHM, &case.what);
    });
}

#[test]
fn rate_of_the_mass_matrix_is_the_coriolis_matrix_plus_its_transpose() {
    for_all(|case| {
        let C = case.base.coriolis_matrix(case.q(), case.v());
        let sum = &C + C.transpose();
        let rate = InTime(case, Matrix::Mass).rate();
        assert_close(&rate, &sum, OTHER_ALGORITHM, &case.what);
    });
}

#[test]
fn inverse_of_the_mass_matrix_is_its_inverse() {
    for_all(|case| {
        let product = case.base.mass_matrix_inverse(case.q()) * case.base.mass_matrix(case.q());
        let n = case.model.nv();
        assert_close(
            &product,
            &DMatrix::identity(n, n),
            OTHER_ALGORITHM,
            &case.what,
        );
    });
}

#[test]
fn rate_of_a_jacobian_equals_its_derivative_in_time() {
    for_all(|case| {
        let (model, q, frame) = (case.model, case.q(), case.last_frame());
        let (v, still) = case.own(&vec![0.0; model.nv()]);
        let (v, still) = (v.as_slice(), still.as_slice());
        for r in Representation::ALL {
            let rate = InTime(case, Matrix::Frame(r)).rate();
            let J = frame_jacobian(model, q, frame, r);
            let own = frame_jacobian_derivative(model, q, v, frame, r);
            let own = case.base.jacobian_derivative(q, v, &J, &own);
            assert_close(&own, &rate, OTHER_ALGORITHM, &case.what);
            let bias = frame_acceleration(model, q, v, still, frame, r);
            let bias = DVector::from_column_slice(&bias.to_array());
            assert_close_vector(&bias, &(own * &case.v), OTHER_ALGORITHM, &case.what);
        }
        let rate = InTime(case, Matrix::Momentum).rate();
        let A = centroidal_momentum_matrix(model, q);
        let own = centroidal_momentum_matrix_derivative(model, q, v);
        let own = case.base.jacobian_derivative(q, v, &A, &own);
        assert_close(&own, &rate, OTHER_ALGORITHM, &case.what);
        let bias = centroidal_momentum_rate(model, q, v, still);
        let bias = DVector::from_column_slice(&bias.to_array());
        assert_close_vector(&bias, &(own * &case.v), OTHER_ALGORITHM, &case.what);
    });
}

// The motion is the same in every representation: frames, momentum and centre of mass do not depend on it.
#[test]
fn motion_of_frames_and_momentum_does_not_depend_on_the_representation() {
    for_all(|case| {
        let (q, own, a) = (case.q(), case.point.v.as_slice(), case.point.w.as_slice());
        let (frame, r) = (case.last_frame(), Representation::Mixed);
        let rate = acceleration_to(case.model, q, own, a, case.r);
        let column = |x: [f64; 6]| DVector::from_column_slice(&x);
        let same = |x: [f64; 6], y: [f64; 6]| {
            assert_close_vector(&column(x), &column(y), OTHER_ALGORITHM, &case.what);
        };
        let (back, back_rate) = case.own(rate.as_slice());
        let (back, back_rate) = (back.as_slice(), back_rate.as_slice());
        same(
            frame_velocity(case.model, q, back, frame, r).to_array(),
            frame_velocity(case.model, q, own, frame, r).to_array(),
        );
        same(
            frame_acceleration(case.model, q, back, back_rate, frame, r).to_array(),
            frame_acceleration(case.model, q, own, a, frame, r).to_array(),
        );
        let world = MomentumFrame::World;
        let h = momentum(case.model, q, own, world).to_array();
        same(momentum(case.model, q, back, world).to_array(), h);
        let A = momentum_matrix(case.model, q, world);
        let by_matrix = case.base.jacobian(q, &A) * &case.v;
        assert_close_vector(&by_matrix, &column(h), OTHER_ALGORITHM, &case.what);
        let J = center_of_mass_jacobian(case.model, q);
        let velocity = case.base.jacobian(q, &J) * &case.v;
        let expected = J * &case.point.v;
        assert_close_vector(&velocity, &expected, SAME_ALGEBRA * 10.0, &case.what);
    });
}

#[test]
fn power_of_joint_forces_does_not_depend_on_the_representation() {
    for_all(|case| {
        let (q, own, a) = (case.q(), case.point.v.as_slice(), case.point.w.as_slice());
        let rate = acceleration_to(case.model, q, own, a, case.r);
        let tau = case.base.inverse_dynamics(q, case.v(), rate.as_slice());
        let expected = inverse_dynamics(case.model, q, own, a).dot(&case.point.v);
        let error = (tau.dot(&case.v) - expected).abs();
        assert!(error < OTHER_ALGORITHM * 100.0, "{}: {error:e}", case.what);
    });
}

// Newton and Euler for a body that moves with p̈ = 0 and ω̇ = 0, about the origin of its frame: with c the centre of mass,
// f = m (ω × (ω × c) − g),  n = ω × (I ω) − m c × g.
#[test]
fn mixed_bias_forces_of_a_free_body_equal_newton_and_euler() {
    let model = free_body();
    let point = random_point(&model, 72);
    let q = point.q.as_slice();
    let body = &model.bodies()[0];
    let R = body.place(q).rotation;
    let (m, c) = (body.inertia.mass, R * body.inertia.com());
    let about_com = body.inertia.about_com();
    let I_com = R * about_com.to_matrix() * R.transpose();
    let v = velocity_to(&model, q, point.v.as_slice(), Representation::Mixed);
    let omega = Vector3::new(v[3], v[4], v[5]);
    let g = model.gravity();
    let f = m * (omega.cross(&omega.cross(&c)) - g);
    let n = omega.cross(&(I_com * omega)) + c.cross(&f);
    let h = BaseFrame::new(&model, Representation::Mixed).bias_forces(q, v.as_slice());
    let expected = DVector::from_iterator(6, f.iter().chain(&n).copied());
    assert_close_vector(&h, &expected, OTHER_ALGORITHM, "free body");
}

/// The state after the tangent t d, or after a step from there, in the representation: its tangent from the state at t = 0.
struct Moved<'a> {
    simulator: &'a Simulator,
    state: State,
    dx: DVector<f64>,
    du: DVector<f64>,
    u: DVector<f64>,
    steps: bool,
    r: Representation,
}

impl Moved<'_> {
    fn state<T: Scalar>(&self, t: T) -> State<T> {
        let model = self.simulator.model();
        let dx: Vec<T> = self.dx.iter().map(|&x| t * x).collect();
        let state = self.state.cast::<T>().integrate(model, &dx);
        let u = self.u.iter().zip(&self.du).map(|(&u, &du)| t * du + u);
        match self.steps {
            true => self.simulator.step(&state, &u.collect::<Vec<T>>()),
            false => state,
        }
    }
}

impl VectorFunction for Moved<'_> {
    fn n_outputs(&self) -> usize {
        self.simulator.n_tangent()
    }

    fn eval<T: Scalar>(&self, t: &[T], y: &mut [T]) {
        let model = self.simulator.model();
        let (here, there) = (self.state::<f64>(0.0), self.state(t[0]));
        let (q0, q) = (here.q.map(T::constant), there.q.as_slice());
        let dq = model.difference(q0.as_slice(), q);
        let dq = velocity_to(model, q0.as_slice(), dq.as_slice(), self.r);
        let v = velocity_to(model, q, there.v.as_slice(), self.r);
        let numbers = dq.iter().chain(&v).chain(&there.contact);
        y.iter_mut().zip(numbers).for_each(|(y, &x)| *y = x);
    }
}

#[test]
fn converted_step_jacobians_map_tangents_of_converted_states() {
    let free = [floating_robot(), free_body(), samples::arm()];
    let free = free.map(|model| Simulator::new(model).with_time_step(0.01));
    for simulator in free.into_iter().chain([in_the_ground()]) {
        let mut rng = generator(73);
        let (model, contact) = (simulator.model(), simulator.n_contact() > 0);
        let Point { q, v, .. } = random_point(model, 74);
        let mut state = simulator.state(q.as_slice(), v.as_slice());
        if contact {
            state
                .q
                .as_mut_slice()
                .copy_from_slice(&[0.3, 0.1, 0.02, 0.8, 0.0, 0.6, 0.0]);
        }
        let mut random = |n: usize| {
            let rounds = n.div_ceil(model.nv());
            let all: Vec<f64> = (0..rounds)
                .flat_map(|_| random_tangent(model, &mut rng).as_slice().to_vec())
                .collect();
            DVector::from_column_slice(&all[..n])
        };
        let (u, du) = (random(simulator.nu()), random(simulator.nu()));
        let dx = random(simulator.n_tangent());
        let own = simulator.linearize(&state, u.as_slice());
        let next = simulator.step(&state, u.as_slice());
        for r in Representation::ALL {
            let what = format!("{}, {r:?}, contact: {contact}", model.name());
            let Linearization { a, b } = own.to_representation(model, &state, &next, r);
            let mut moved = Moved {
                simulator: &simulator,
                state: state.clone(),
                dx: dx.clone(),
                du: du.clone(),
                u: u.clone(),
                steps: false,
                r,
            };
            let before = jacobian(&moved, &[0.0]).column(0).into_owned();
            let (q, v) = (state.q.as_slice(), state.v.as_slice());
            let converted = deviation_to(model, q, v, dx.as_slice(), r);
            assert_close_vector(&converted, &before, OTHER_ALGORITHM, &what);
            let back = deviation_from(model, q, v, converted.as_slice(), r);
            assert_close_vector(&back, &dx, OTHER_ALGORITHM, &what);
            moved.steps = true;
            let after = jacobian(&moved, &[0.0]).column(0).into_owned();
            assert_close_vector(&(a * before + b * &du), &after, FINITE_DIFFERENCE, &what);
        }
    }
}

/// A box that has sunk into the ground, with bristles.
fn in_the_ground() -> Simulator {
    let model = body(LinkSpec::solid_box(
        "box",
        [0.2, 0.3, 0.1],
        Mass::Kilograms(1.0),
    ));
    let law = ContactLaw::Soft(SoftContact::estimate(1.0, 4, 0.01));
    on(model, Terrain::flat(0.0), law)
}

#[test]
fn gradient_times_tangent_does_not_depend_on_the_representation() {
    let model = floating_robot();
    let (x, y) = (random_point(&model, 75), random_point(&model, 76));
    let (q, v) = (x.q.as_slice(), x.v.as_slice());
    let join = |a: &DVector<f64>, b: &DVector<f64>| {
        DVector::from_iterator(2 * model.nv() + 1, a.iter().chain(b).copied().chain([0.7]))
    };
    let (dx, g) = (join(&x.w, &y.w), join(&y.v, &x.v));
    for r in Representation::ALL {
        let dx_r = deviation_to(&model, q, v, dx.as_slice(), r);
        let g_r = gradient_to(&model, q, v, g.as_slice(), r);
        assert!((g_r.dot(&dx_r) - g.dot(&dx)).abs() < 1e-11, "{r:?}");
        let back = gradient_from(&model, q, v, g_r.as_slice(), r);
        assert_close_vector(&back, &g, OTHER_ALGORITHM, &format!("{r:?}"));
    }
}

#[test]
fn forward_dynamics_of_each_representation_is_the_same_motion() {
    for_all(|case| {
        let (q, own, tau) = (case.q(), case.point.v.as_slice(), case.point.w.as_slice());
        let r = case.r;
        let a = forward_dynamics(case.model, q, own, tau);
        let expected = acceleration_to(case.model, q, own, a.as_slice(), r);
        let force = force_to(case.model, q, tau, r);
        let actual = case.base.forward_dynamics(q, case.v(), force.as_slice());
        assert_close_vector(&actual, &expected, OTHER_ALGORITHM, &case.what);
    });
}
