//! Every derivative by dual numbers against its finite-difference twin, in tangent space.

use dualbody::autodiff::{VectorFunction, finite_difference, gradient, hessian, jacobian};
use dualbody::dynamics::{forward_dynamics, inverse_dynamics, mass_matrix};
use dualbody::joint::JointKind;
use dualbody::model::{BodyId, samples};
use dualbody::spatial::{Inertia, Symmetric3};
use dualbody::{Model, Scalar, Simulator, State};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::common::everything::{EverythingAt, INTEGRATORS, everything};
use crate::common::{
    FINITE_DIFFERENCE, OTHER_ALGORITHM, SAME_ALGEBRA, assert_close, random_point, robots,
};

/// Changes of eight inputs at once, each up or down: an eighth of the differences, each as sensitive to one wrong derivative as before.
struct Grouped<'a, F> {
    f: &'a F,
    x: &'a [f64],
}

impl<F> Grouped<'_, F> {
    const SIZE: usize = 8;

    fn n_groups(&self) -> usize {
        self.x.len().div_ceil(Self::SIZE)
    }

    /// The group of an input, and the sign of its change.
    fn group(&self, k: usize) -> (usize, f64) {
        let sign = if (k * k / 3).is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
        (k % self.n_groups(), sign)
    }
}

impl<F: VectorFunction> VectorFunction for Grouped<'_, F> {
    fn n_outputs(&self) -> usize {
        self.f.n_outputs()
    }

    fn eval<T: Scalar>(&self, s: &[T], y: &mut [T]) {
        let moved = |(k, &x): (usize, &f64)| {
            let (group, sign) = self.group(k);
            s[group] * sign + x
        };
        let x: Vec<T> = self.x.iter().enumerate().map(moved).collect();
        self.f.eval(&x, y);
    }
}

/// Compares the Jacobian of a function with differences, row by row, so that the message names the quantity.
fn assert_jacobian<F: VectorFunction>(names: &[&str], f: &F, x: &[f64], what: &str) {
    let (exact, grouped) = (jacobian(f, x), Grouped { f, x });
    let all_finite = exact.iter().all(|x| x.is_finite());
    assert!(all_finite, "{what}: a derivative is not finite");
    let mut sums = DMatrix::zeros(exact.nrows(), grouped.n_groups());
    for (k, column) in exact.column_iter().enumerate() {
        let (group, sign) = grouped.group(k);
        sums.column_mut(group).axpy(sign, &column, 1.0);
    }
    let numeric = finite_difference::jacobian(&grouped, &vec![0.0; grouped.n_groups()]);
    for (i, name) in names.iter().enumerate() {
        // Of the derivatives, which are smaller than their sums.
        let bound = FINITE_DIFFERENCE * exact.row(i).amax().max(1.0);
        for k in 0..sums.ncols() {
            let (a, e) = (sums[(i, k)], numeric[(i, k)]);
            let is_close = (a - e).abs() <= bound;
            assert!(is_close, "{what}, {name}, group {k}: {a} against {e}");
        }
    }
}

#[test]
fn jacobian_of_everything_in_q_v_a_equals_finite_differences() {
    for model in robots() {
        let point = random_point(&model, 7);
        let f = EverythingAt {
            model: &model,
            q: point.q.as_slice(),
        };
        let x: Vec<f64> = std::iter::repeat_n(0.0, model.nv())
            .chain(point.v.iter().copied())
            .chain(point.w.iter().copied())
            .collect();
        assert_jacobian(&f.names(), &f, &x, model.name());
    }
}

#[test]
fn jacobian_of_everything_at_the_neutral_configuration_at_rest_equals_finite_differences() {
    for model in robots() {
        let q = model.neutral();
        let f = EverythingAt {
            model: &model,
            q: q.as_slice(),
        };
        assert_jacobian(&f.names(), &f, &vec![0.0; 3 * model.nv()], model.name());
    }
}

/// Everything as a function of the model's own data: inertias, gravity, damping; with more damping than the model's, as
/// differences step down as well and damping is not negative.
struct OfModel<'a> {
    model: &'a Model,
    point: &'a crate::common::Point,
}

impl OfModel<'_> {
    const PER_BODY: usize = 10;

    /// The parameters, each with the size of a change that leaves the robot well-conditioned.
    fn parameters(&self) -> Vec<(f64, f64)> {
        let mut out = Vec::new();
        for body in self.model.bodies() {
            let Inertia {
                mass,
                first_moment: h,
                rotational: j,
            } = body.inertia;
            let least = body
                .inertia
                .about_com()
                .to_matrix()
                .symmetric_eigenvalues()
                .min()
                .max(1e-3);
            let moment = (mass * least).sqrt();
            out.push((mass, mass));
            out.extend(h.iter().map(|&h| (h, moment)));
            out.extend([j.xx, j.xy, j.xz, j.yy, j.yz, j.zz].map(|j| (j, least)));
        }
        out.extend(self.model.gravity().iter().map(|&g| (g, 1.0)));
        out.extend(self.model.damping().iter().map(|&d| (d + 0.5, 1.0)));
        out
    }

    /// The robot with each parameter changed by `x` times its size.
    fn build<T: Scalar>(&self, x: &[T]) -> Model<T> {
        let x: Vec<T> = x
            .iter()
            .zip(self.parameters())
            .map(|(&x, (p, size))| x * size + p)
            .collect();
        let mut model = self.model.cast::<T>();
        let (bodies, rest) = x.split_at(Self::PER_BODY * model.n_bodies());
        for (i, p) in bodies.chunks(Self::PER_BODY).enumerate() {
            let inertia = Inertia {
                mass: p[0],
                first_moment: Vector3::new(p[1], p[2], p[3]),
                rotational: Symmetric3::new(p[4], p[5], p[6], p[7], p[8], p[9]),
            };
            model = model.with_inertia(BodyId(i), inertia);
        }
        model = model.with_gravity(Vector3::new(rest[0], rest[1], rest[2]));
        for (k, &damping) in rest[3..].iter().enumerate() {
            model = model.with_damping(k, damping);
        }
        model
    }
}

impl VectorFunction for OfModel<'_> {
    fn n_outputs(&self) -> usize {
        EverythingAt {
            model: self.model,
            q: self.point.q.as_slice(),
        }
        .n_outputs()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let lift = |x: &DVector<f64>| x.iter().map(|&x| T::constant(x)).collect::<Vec<T>>();
        let (q, v, w) = (
            lift(&self.point.q),
            lift(&self.point.v),
            lift(&self.point.w),
        );
        y.copy_from_slice(&everything(&self.build(x), &q, &v, &w).numbers);
    }
}

#[test]
fn jacobian_of_everything_in_inertia_gravity_and_damping_equals_finite_differences() {
    for model in robots() {
        let point = random_point(&model, 11);
        let f = OfModel {
            model: &model,
            point: &point,
        };
        let names = EverythingAt {
            model: &model,
            q: point.q.as_slice(),
        }
        .names();
        assert_jacobian(&names, &f, &vec![0.0; f.parameters().len()], model.name());
    }
}

#[test]
fn step_jacobians_equal_finite_differences_for_both_integrators() {
    for model in robots() {
        for integrator in INTEGRATORS {
            let simulator = Simulator::new(model.clone())
                .with_time_step(0.01)
                .with_integrator(integrator);
            let point = random_point(&model, 5);
            let u: Vec<f64> = simulator.actuated().iter().map(|&k| point.w[k]).collect();
            let state = State::new(point.q.as_slice(), point.v.as_slice());
            let exact = simulator.linearize(&state, &u);
            let numeric = simulator
                .estimate_linearization(&state, &u, &finite_difference::Options::default())
                .linearization;
            let what = format!("{}, {integrator:?}", model.name());
            assert_close(&exact.a, &numeric.a, FINITE_DIFFERENCE, &what);
            assert_close(&exact.b, &numeric.b, FINITE_DIFFERENCE, &what);
        }
    }
}

// (M + Δt D + Δt² K) (v⁺ − v) = Δt (u − …) with dampers D and springs K, which act with the velocity at the end of the
// step: with every coordinate actuated, ∂v⁺/∂u = Δt (M + Δt D + Δt² K)⁻¹. The linear velocities of floating and planar
// joints, which turn with the body, are left out.
#[test]
fn input_jacobian_of_semi_implicit_euler_equals_the_inverse_mass_matrix() {
    let dt = 0.01;
    for model in robots() {
        let point = random_point(&model, 13);
        let simulator = Simulator::new(model.clone()).with_time_step(dt);
        let state = State::new(point.q.as_slice(), point.v.as_slice());
        let b = simulator.linearize(&state, &vec![0.0; simulator.nu()]).b;
        let nv = model.nv();
        let mut resistance = mass_matrix(&model, point.q.as_slice());
        for k in 0..nv {
            resistance[(k, k)] += dt * (model.damping()[k] + dt * model.springs()[k].stiffness);
        }
        let inverse = resistance
            .try_inverse()
            .expect("a positive definite matrix");
        let expected = DMatrix::from_fn(nv, simulator.nu(), |i, k| {
            dt * inverse[(i, simulator.actuated()[k])]
        });
        let mut turning = vec![false; nv];
        for body in model.bodies() {
            match body.joint {
                JointKind::Floating => turning[body.v..body.v + 3].fill(true),
                JointKind::Planar => turning[body.v..body.v + 2].fill(true),
                _ => {}
            }
        }
        let still: Vec<usize> = (0..nv).filter(|&i| !turning[i]).collect();
        assert_close(
            &b.rows(nv, nv).select_rows(&still),
            &expected.select_rows(&still),
            OTHER_ALGORITHM,
            model.name(),
        );
    }
}

/// Forward dynamics at a fixed configuration offset, as a function of (δq, v, τ).
struct Forward<'a>(&'a Model, &'a DVector<f64>);
/// Inverse dynamics, as a function of (δq, v, a).
struct Inverse<'a>(&'a Model, &'a DVector<f64>);

fn moved<T: Scalar>(model: &Model, q: &DVector<f64>, dq: &[T]) -> DVector<T> {
    model.integrate(q.map(T::constant).as_slice(), dq)
}

impl VectorFunction for Forward<'_> {
    fn n_outputs(&self) -> usize {
        self.0.nv()
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let nv = self.0.nv();
        let q = moved(self.0, self.1, &x[..nv]);
        y.copy_from_slice(
            forward_dynamics(self.0, q.as_slice(), &x[nv..2 * nv], &x[2 * nv..]).as_slice(),
        );
    }
}

impl VectorFunction for Inverse<'_> {
    fn n_outputs(&self) -> usize {
        self.0.nv()
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let nv = self.0.nv();
        let q = moved(self.0, self.1, &x[..nv]);
        y.copy_from_slice(
            inverse_dynamics(self.0, q.as_slice(), &x[nv..2 * nv], &x[2 * nv..]).as_slice(),
        );
    }
}

// ∂FD/∂(q, v) = −M⁻¹ ∂ID/∂(q, v) at a = FD(q, v, τ); ∂FD/∂τ = M⁻¹; ∂ID/∂a = M.
#[test]
fn forward_dynamics_derivatives_equal_the_implicit_function_theorem_of_the_inverse() {
    for model in robots() {
        let (point, nv) = (random_point(&model, 17), model.nv());
        let a = forward_dynamics(
            &model,
            point.q.as_slice(),
            point.v.as_slice(),
            point.w.as_slice(),
        );
        let at = |w: &DVector<f64>| {
            [
                vec![0.0; nv],
                point.v.as_slice().to_vec(),
                w.as_slice().to_vec(),
            ]
            .concat()
        };
        let forward = jacobian(&Forward(&model, &point.q), &at(&point.w));
        let inverse = jacobian(&Inverse(&model, &point.q), &at(&a));
        let m = mass_matrix(&model, point.q.as_slice());
        assert_close(
            &inverse.columns(2 * nv, nv).into(),
            &m,
            SAME_ALGEBRA,
            model.name(),
        );
        let expected =
            -m.try_inverse().expect("a positive definite matrix") * inverse.columns(0, 2 * nv);
        assert_close(
            &forward.columns(0, 2 * nv).into(),
            &expected,
            OTHER_ALGORITHM,
            model.name(),
        );
    }
}

/// Rosenbrock's valley: f = Σ (1 − xᵢ)² + 100 (xᵢ₊₁ − xᵢ²)².
struct Valley;
impl VectorFunction for Valley {
    fn n_outputs(&self) -> usize {
        1
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        y[0] = x.windows(2).fold(T::zero(), |sum, x| {
            let (a, b) = (-x[0] + 1.0, x[1] - x[0] * x[0]);
            sum + a * a + b * b * 100.0
        });
    }
}

// With x = (1.2, −0.5): ∂₁ = −2 (1 − x₁) − 400 x₁ (x₂ − x₁²), ∂₂ = 200 (x₂ − x₁²);
// ∂₁₁ = 2 − 400 x₂ + 1200 x₁², ∂₁₂ = −400 x₁, ∂₂₂ = 200.
#[test]
fn gradient_and_hessian_equal_the_closed_form() {
    let second = hessian(&Valley, &[1.2, -0.5]);
    let expected = DVector::from_vec(vec![0.4 - 480.0 * (-0.5 - 1.44), 200.0 * (-0.5 - 1.44)]);
    assert!((gradient(&Valley, &[1.2, -0.5]) - &expected).amax() < SAME_ALGEBRA);
    assert!((second.gradient - expected).amax() < SAME_ALGEBRA);
    let hessian =
        DMatrix::from_row_slice(2, 2, &[2.0 + 200.0 + 1200.0 * 1.44, -480.0, -480.0, 200.0]);
    assert!((second.hessian - hessian).amax() < SAME_ALGEBRA);
    assert!((second.value - (0.04 + 100.0 * 1.94 * 1.94)).abs() < SAME_ALGEBRA);
}

/// A squared norm of the forward dynamics, to have second derivatives through a whole algorithm.
struct SquaredAcceleration<'a>(Forward<'a>);
impl VectorFunction for SquaredAcceleration<'_> {
    fn n_outputs(&self) -> usize {
        1
    }
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let mut a = vec![T::zero(); self.0.n_outputs()];
        self.0.eval(x, &mut a);
        y[0] = a.iter().fold(T::zero(), |sum, &a| sum + a * a);
    }
}

/// The gradient of a function, itself as a function of `f64` only: differentiated by hand below.
fn numeric_hessian<F: VectorFunction>(f: &F, x: &[f64]) -> DMatrix<f64> {
    const STEP: f64 = 1e-5;
    let mut moved = x.to_vec();
    DMatrix::from_columns(
        &(0..x.len())
            .map(|i| {
                moved[i] = x[i] + STEP;
                let plus = gradient(f, &moved);
                moved[i] = x[i] - STEP;
                let minus = gradient(f, &moved);
                moved[i] = x[i];
                (plus - minus) / (2.0 * STEP)
            })
            .collect::<Vec<_>>(),
    )
}

#[test]
fn hessian_through_forward_dynamics_equals_differences_of_the_gradient() {
    for model in [
        samples::double_pendulum(),
        crate::common::free_body(),
        samples::random_tree(3, 4),
    ] {
        let point = random_point(&model, 3);
        let f = SquaredAcceleration(Forward(&model, &point.q));
        let x = [
            vec![0.0; model.nv()],
            point.v.as_slice().to_vec(),
            point.w.as_slice().to_vec(),
        ]
        .concat();
        // Second-order differences of the gradient: h² ≈ 1e-10 of its third derivatives.
        assert_close(
            &hessian(&f, &x).hessian,
            &numeric_hessian(&f, &x),
            1e-6,
            model.name(),
        );
    }
}
