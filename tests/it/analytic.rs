//! Robots whose equations of motion can be written down.

use dualbody::dynamics::{
    bias_forces, forward_dynamics, kinetic_energy, mass_matrix, potential_energy,
};
use dualbody::model::samples;
use dualbody::{Model, Simulator, State};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::common::{
    OTHER_ALGORITHM, ROUNDING, SAME_ALGEBRA, assert_close, assert_close_vector, free_body,
    random_point,
};

const G: f64 = 9.81;

/// Compares mass matrix, bias forces and accelerations with a closed form  M(q), h(q, v).
fn assert_equations(
    model: &Model,
    closed_form: impl Fn(&[f64], &[f64]) -> (DMatrix<f64>, DVector<f64>),
) {
    for seed in 0..20 {
        let point = random_point(model, seed);
        let (q, v) = (point.q.as_slice(), (&point.v * 5.0));
        let (m, h) = closed_form(q, v.as_slice());
        let what = format!("{}, seed {seed}", model.name());
        assert_close(&mass_matrix(model, q), &m, SAME_ALGEBRA, &what);
        assert_close_vector(
            &bias_forces(model, q, v.as_slice()),
            &h,
            SAME_ALGEBRA,
            &what,
        );
        let expected = m.lu().solve(&(&point.w - h)).expect("a regular matrix");
        assert_close_vector(
            &forward_dynamics(model, q, v.as_slice(), point.w.as_slice()),
            &expected,
            OTHER_ALGORITHM,
            &what,
        );
    }
}

// The pole leans to −y for a positive angle about x: y_com = y − l sin θ, z_com = l cos θ.
// (m_c + m_p) ÿ − m_p l cos θ θ̈ + m_p l sin θ θ̇² = F,  −m_p l cos θ ÿ + (J + m_p l²) θ̈ − m_p g l sin θ = τ
#[test]
fn cartpole_equals_its_closed_form() {
    let (m_c, m_p, l, j) = (1.0, 0.5, 0.5, 0.041_669_791_666_666_67);
    assert_equations(&samples::cartpole(), |q, v| {
        let (sin, cos) = q[1].sin_cos();
        let coupling = -m_p * l * cos;
        let m = DMatrix::from_row_slice(2, 2, &[m_c + m_p, coupling, coupling, j + m_p * l * l]);
        (
            m,
            DVector::from_vec(vec![m_p * l * sin * v[1] * v[1], -m_p * G * l * sin]),
        )
    });
}

// Two uniform rods, q₂ relative to the first:
// M₁₁ = ⅓ + 1 + ⅓ + cos q₂, M₁₂ = ⅓ + ½ cos q₂, M₂₂ = ⅓;  s = ½ sin q₂
// h₁ = −s (2 v₁ v₂ + v₂²) + g (3/2 sin q₁ + ½ sin(q₁ + q₂)),  h₂ = s v₁² + ½ g sin(q₁ + q₂)
#[test]
fn double_pendulum_equals_its_closed_form() {
    let third = 1.0 / 3.0;
    assert_equations(&samples::double_pendulum(), |q, v| {
        let (s, c) = (0.5 * q[1].sin(), q[1].cos());
        let both = 0.5 * G * (q[0] + q[1]).sin();
        let off = third + 0.5 * c;
        let m = DMatrix::from_row_slice(2, 2, &[2.0 * third + 1.0 + c, off, off, third]);
        let h = [
            -s * (2.0 * v[0] * v[1] + v[1] * v[1]) + 1.5 * G * q[0].sin() + both,
            s * v[0] * v[0] + both,
        ];
        (m, DVector::from_column_slice(&h))
    });
}

// Newton–Euler about the centre of mass c of a free body, in body axes, at its own origin:
// f = m (v̇ + ω × v + ω̇ × c + ω × (ω × c)) − m Rᵀ g,  n = J_c ω̇ + ω × J_c ω + c × f
#[test]
fn free_body_equals_newton_and_euler() {
    let model = free_body();
    let (m, c, j) = (
        2.0,
        Vector3::new(0.1, -0.2, 0.05),
        Vector3::new(0.3, 0.2, 0.1),
    );
    for seed in 0..20 {
        let point = random_point(&model, seed);
        let part = |x: &DVector<f64>, at: usize| Vector3::new(x[at], x[at + 1], x[at + 2]);
        let (v, omega) = (part(&point.v, 0), part(&point.v, 3));
        let a = forward_dynamics(
            &model,
            point.q.as_slice(),
            point.v.as_slice(),
            point.w.as_slice(),
        );
        let (v_dot, omega_dot) = (part(&a, 0), part(&a, 3));
        let r = dualbody::spatial::Quaternion::from_slice(&point.q.as_slice()[3..]).to_matrix();
        let acceleration =
            v_dot + omega.cross(&v) + omega_dot.cross(&c) + omega.cross(&omega.cross(&c));
        let f = (acceleration - r.transpose() * Vector3::new(0.0, 0.0, -G)) * m;
        let n = j.component_mul(&omega_dot) + omega.cross(&j.component_mul(&omega)) + c.cross(&f);
        assert!(
            (f - part(&point.w, 0)).norm() < SAME_ALGEBRA
                && (n - part(&point.w, 3)).norm() < SAME_ALGEBRA,
            "seed {seed}"
        );
    }
}

// A body thrown without spin and with its centre of mass at c falls along a parabola, independent of the integrator's frame.
#[test]
fn thrown_body_equals_the_parabola() {
    let model = free_body();
    let simulator = Simulator::new(model)
        .with_time_step(1e-3)
        .with_integrator(dualbody::Integrator::RungeKutta4);
    let mut start = State::neutral(simulator.model());
    start.v[0] = 2.0;
    start.v[2] = 3.0;
    let end = simulator.rollout(&start, 1000, |_, _, _| {}).last().clone();
    let expected = [2.0, 0.0, 3.0 - 0.5 * G];
    for k in 0..3 {
        assert!(
            (end.q[k] - expected[k]).abs() < 1e-10,
            "coordinate {k}: {} against {}",
            end.q[k],
            expected[k]
        );
    }
}

// One rod at angle q: T = ½ ⅓ v², U = −½ g cos q.
#[test]
fn pendulum_energies_equal_their_closed_form() {
    let model = samples::pendulum();
    for (q, v) in [(0.0, 0.0), (0.3, -2.0), (-2.5, 1.0)] {
        assert!((kinetic_energy(&model, &[q], &[v]) - v * v / 6.0).abs() < ROUNDING);
        assert!((potential_energy(&model, &[q]) + 0.5 * G * f64::cos(q)).abs() < 10.0 * ROUNDING);
    }
}
