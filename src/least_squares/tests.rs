//! Known solutions: certified data, closed forms, conditions of optimality.

use nalgebra::{DMatrix, Quaternion as NalgebraQuaternion, UnitQuaternion, Vector3};

use super::*;
use crate::autodiff::VectorFunction;
use crate::scalar::Scalar;
use crate::tests::{OTHER_ALGORITHM, SAME_ALGEBRA};

/// y = b₁ (1 − exp(−b₂ x)): the problem Misra1a of NIST's Statistical Reference Datasets.
struct Misra1a;

const MISRA_X: [f64; 14] = [
    77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0,
];
const MISRA_Y: [f64; 14] = [
    10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47,
    81.78,
];

impl VectorFunction for Misra1a {
    fn n_outputs(&self) -> usize {
        MISRA_X.len()
    }
    fn eval<T: Scalar>(&self, b: &[T], r: &mut [T]) {
        for ((r, &x), &y) in r.iter_mut().zip(&MISRA_X).zip(&MISRA_Y) {
            *r = b[0] * (-(b[1] * -x).exp() + 1.0) - T::constant(y);
        }
    }
}

// Errors hide what further iterations would find.
#[test]
fn relative_offset_ends_where_errors_are_larger_than_what_is_left() {
    const OFFSET: f64 = 1e-3;
    let start = [500.0, 1e-4];
    let exact = solve(&mut ByDuals::new(Misra1a), &start, &Options::default());
    let options = Options {
        offset_tolerance: OFFSET,
        ..Options::default()
    };
    let found = solve(&mut ByDuals::new(Misra1a), &start, &options);
    assert!(
        found.is_converged() && found.iterations < exact.iterations,
        "{found:?}"
    );
    let deviations = found
        .covariance()
        .expect("more data than variables")
        .diagonal()
        .map(f64::sqrt);
    let missing = (0..2).map(|k| (found.x[k] - exact.x[k]) / deviations[k]);
    // The criterion bounds the root mean square along the axes of the ellipsoid.
    assert!(missing.map(f64::abs).fold(0.0, f64::max) < 2.0 * OFFSET);
}

#[test]
fn solution_and_deviations_equal_certified_ones() {
    for start in [[500.0, 1e-4], [250.0, 5e-4]] {
        let found = solve(&mut ByDuals::new(Misra1a), &start, &Options::default());
        assert!(found.is_converged(), "{found:?}");
        let certified = [2.389_421_291_8e2, 5.501_564_318_1e-4];
        let deviations = [2.707_007_524_1, 7.266_868_843_6e-6];
        let covariance = found.covariance().expect("more data than variables");
        for k in 0..2 {
            assert!((found.x[k] / certified[k] - 1.0).abs() < 1e-9, "{found:?}");
            let deviation = covariance[(k, k)].sqrt();
            assert!(
                (deviation / deviations[k] - 1.0).abs() < 1e-7,
                "{deviation:e}"
            );
        }
        assert!((2.0 * found.cost / 1.245_513_889_4e-1 - 1.0).abs() < 1e-9);
    }
}

/// Powell's singular function: zero at the origin, where its Jacobian has rank 2.
struct Powell;

impl VectorFunction for Powell {
    fn n_outputs(&self) -> usize {
        4
    }
    fn eval<T: Scalar>(&self, x: &[T], r: &mut [T]) {
        let (a, b) = (x[1] - x[2] * 2.0, x[0] - x[3]);
        r[0] = x[0] + x[1] * 10.0;
        r[1] = (x[2] - x[3]) * 5.0_f64.sqrt();
        r[2] = a * a;
        r[3] = b * b * 10.0_f64.sqrt();
    }
}

#[test]
fn zero_with_a_singular_jacobian_is_found() {
    let found = solve(
        &mut ByDuals::new(Powell),
        &[3.0, -1.0, 0.0, 1.0],
        &Options::default(),
    );
    // Towards a singular zero the method is linear, x by ½ an iteration, and the cosine falls as x does.
    assert!(found.is_converged() && found.cost < 1e-16, "{found:?}");
}

/// A line through points, two of which lie far off.
struct Line {
    outliers: f64,
}

impl VectorFunction for Line {
    fn n_outputs(&self) -> usize {
        20
    }
    fn eval<T: Scalar>(&self, x: &[T], r: &mut [T]) {
        for (i, r) in r.iter_mut().enumerate() {
            let t = i as f64;
            let noise = 0.01 * (7.0 * t).sin();
            let off = if i % 8 == 5 { self.outliers } else { 0.0 };
            *r = x[0] + x[1] * t - (2.0 - 0.3 * t + noise + off);
        }
    }
}

#[test]
fn robust_losses_find_the_line_that_outliers_hide() {
    let fit = |outliers: f64, loss: Loss| {
        let options = Options {
            loss,
            ..Options::default()
        };
        let found = solve(&mut ByDuals::new(Line { outliers }), &[0.0, 0.0], &options);
        assert!(found.is_converged(), "{loss:?}: {found:?}");
        found
    };
    let off = |found: &Solution| (found.x[0] - 2.0).hypot(found.x[1] + 0.3);
    assert!(off(&fit(0.0, Loss::Square)) < 0.01);
    assert!(off(&fit(8.0, Loss::Square)) > 0.3);
    for loss in [Loss::Huber(0.02), Loss::SoftL1(0.02), Loss::Cauchy(0.02)] {
        assert!(
            off(&fit(8.0, loss)) < 0.02,
            "{loss:?}: {:?}",
            fit(8.0, loss).x
        );
    }
    // The gradient of the robust cost vanishes, Σ ρ' r ∂r = 0: to the root of the change of the cost that counts.
    let found = fit(8.0, Loss::SoftL1(0.02));
    let weight = |r: &f64| Loss::SoftL1(0.02).weight(r * r);
    let sum = |of: &dyn Fn(&f64) -> f64| found.residuals.iter().map(of).sum::<f64>();
    let slope = sum(&|r| weight(r) * r);
    let size = (sum(&weight) * sum(&|r| weight(r) * r * r)).sqrt();
    assert!(slope.abs() <= 1e-7 * size, "{slope:e} of {size:e}");
}

#[test]
fn losses_and_weights_equal_value_and_slope_of_the_formula() {
    for loss in [
        Loss::Square,
        Loss::Huber(0.5),
        Loss::SoftL1(0.5),
        Loss::Cauchy(0.5),
    ] {
        for s in [1e-12, 0.01, 0.249_9, 0.3, 7.0, 1e6] {
            let h = 1e-6 * s;
            let slope = (loss.value(s + h) - loss.value(s - h)) / (2.0 * h);
            assert!(
                (slope / loss.weight(s) - 1.0).abs() < 1e-6,
                "{loss:?} at {s}"
            );
        }
        assert!((loss.value(1e-10) / 1e-10 - 1.0).abs() < 1e-8, "{loss:?}");
    }
}

/// Rosenbrock's valley, zero at (1, 1), in some unit of its residuals.
struct Valley(f64);

impl VectorFunction for Valley {
    fn n_outputs(&self) -> usize {
        2
    }
    fn eval<T: Scalar>(&self, x: &[T], r: &mut [T]) {
        r[0] = (x[1] - x[0] * x[0]) * (10.0 * self.0);
        r[1] = (-x[0] + 1.0) * self.0;
    }
}

#[test]
fn bounded_solution_satisfies_the_conditions_of_optimality() {
    // With x₀ ≤ ½ the least is at (½, ¼): there the slope of ½ (1 − x₀)² pushes against the bound.
    let options = Options::default().with_bounds(&[-2.0, -2.0], &[0.5, 2.0]);
    for start in [[-1.2, 1.0], [3.0, -7.0], [0.5, 0.25]] {
        let found = solve(&mut ByDuals::new(Valley(1.0)), &start, &options);
        assert!(found.is_converged(), "{found:?}");
        assert_eq!((found.x[0], &found.held[..]), (0.5, &[0][..]));
        assert!((found.x[1] - 0.25).abs() < OTHER_ALGORITHM, "{found:?}");
    }
    let fixed = Options::default().with_bounds(&[0.5, 0.5], &[0.5, 0.5]);
    let found = solve(&mut ByDuals::new(Valley(1.0)), &[0.0, 0.0], &fixed);
    assert!(found.is_converged() && found.x == [0.5, 0.5], "{found:?}");
}

/// The rotation that brings vectors onto others: a quaternion, three directions.
struct Wahba {
    from: Vec<Vector3<f64>>,
    to: Vec<Vector3<f64>>,
}

fn rotation(q: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(NalgebraQuaternion::new(q[0], q[1], q[2], q[3]))
}

impl Residuals for Wahba {
    fn n_residuals(&self) -> usize {
        3 * self.from.len()
    }
    fn residuals(&mut self, q: &[f64], out: &mut [f64]) {
        for ((out, a), b) in out.chunks_exact_mut(3).zip(&self.from).zip(&self.to) {
            out.copy_from_slice((rotation(q) * a - b).as_slice());
        }
    }
    fn jacobian(&mut self, q: &[f64], out: &mut DMatrix<f64>) {
        // R exp(d) a = R a + R (d × a) + …
        for (i, a) in self.from.iter().enumerate() {
            let block = -(rotation(q).to_rotation_matrix() * a.cross_matrix());
            out.view_mut((3 * i, 0), (3, 3)).copy_from(&block);
        }
    }
    fn n_directions(&self, _q: &[f64]) -> usize {
        3
    }
    fn retract(&self, q: &[f64], d: &[f64], out: &mut [f64]) {
        let turned = rotation(q) * UnitQuaternion::from_scaled_axis(Vector3::from_column_slice(d));
        out.copy_from_slice(&[turned.w, turned.i, turned.j, turned.k]);
    }
}

#[test]
fn rotation_between_vectors_equals_the_one_that_moved_them() {
    let truth = UnitQuaternion::from_euler_angles(2.0, -0.7, 1.1);
    let from: Vec<_> = (0..5)
        .map(|k| Vector3::new((k as f64).sin(), 0.3 * k as f64, (2.0 * k as f64).cos()))
        .collect();
    let to = from.iter().map(|a| truth * a).collect();
    let found = solve(
        &mut Wahba { from, to },
        &[1.0, 0.0, 0.0, 0.0],
        &Options::default(),
    );
    assert!(found.is_converged(), "{found:?}");
    let off = rotation(&found.x).angle_to(&truth);
    assert!(off < SAME_ALGEBRA.max(1e-7), "{off:e}"); // the angle between quaternions loses half of the digits
    assert!(found.cost < 1e-25, "{found:?}");
}

/// One residual with a pole beside the start, and none at all from 2 on.
struct Pole;

impl VectorFunction for Pole {
    fn n_outputs(&self) -> usize {
        1
    }
    fn eval<T: Scalar>(&self, x: &[T], r: &mut [T]) {
        r[0] = (-x[0] + 2.0).ln() - 1.0;
    }
}

#[test]
fn points_without_residuals_are_stepped_back_from_and_reported_at_the_start() {
    let found = solve(&mut ByDuals::new(Pole), &[1.9], &Options::default());
    assert!(found.is_converged(), "{found:?}");
    assert!((found.x[0] - (2.0 - std::f64::consts::E)).abs() < OTHER_ALGORITHM);
    let outside = solve(&mut ByDuals::new(Pole), &[3.0], &Options::default());
    assert_eq!(outside.status, Status::Diverged);
    assert_eq!(outside.x, [3.0]);
}

/// A Jacobian of the wrong sign.
struct Wrong;

impl Residuals for Wrong {
    fn n_residuals(&self) -> usize {
        1
    }
    fn residuals(&mut self, x: &[f64], out: &mut [f64]) {
        out[0] = x[0] - 1.0;
    }
    fn jacobian(&mut self, _x: &[f64], out: &mut DMatrix<f64>) {
        out[(0, 0)] = -1.0;
    }
}

#[test]
fn wrong_jacobian_ends_as_stalled() {
    let found = solve(&mut Wrong, &[5.0], &Options::default());
    assert_eq!(found.status, Status::Stalled, "{found:?}");
    assert_eq!(found.x, [5.0]);
}

#[test]
#[should_panic(expected = "the bounds 1 and 0 of variable 0 leave no value")]
fn bounds_that_leave_no_value_are_refused() {
    let options = Options::default().with_bounds(&[1.0], &[0.0]);
    solve(&mut Wrong, &[0.5], &options);
}

#[test]
fn units_of_residuals_do_not_matter() {
    let solve_in = |unit: f64| {
        let bounds = Options::default().with_bounds(&[-2.0, -1.0], &[2.0, 3.0]);
        solve(&mut ByDuals::new(Valley(unit)), &[-1.2, 1.0], &bounds)
    };
    // Powers of two, with which every rounding is the same.
    for unit in [1.0, 2_f64.powi(-60), 2_f64.powi(60)] {
        let found = solve_in(unit);
        assert!(found.is_converged(), "{unit:e}: {found:?}");
        assert_eq!(found.x, solve_in(1.0).x, "{unit:e}");
        let off = found.x.iter().map(|x| (x - 1.0).abs());
        assert!(
            off.fold(0.0, f64::max) < SAME_ALGEBRA,
            "{unit:e}: {found:?}"
        );
    }
}

#[test]
fn units_of_variables_do_not_matter() {
    /// [`Misra1a`] with its second variable in units of 1e-9.
    struct Scaled;
    impl VectorFunction for Scaled {
        fn n_outputs(&self) -> usize {
            MISRA_X.len()
        }
        fn eval<T: Scalar>(&self, b: &[T], r: &mut [T]) {
            Misra1a.eval(&[b[0], b[1] * 1e-9], r);
        }
    }
    let plain = solve(
        &mut ByDuals::new(Misra1a),
        &[250.0, 5e-4],
        &Options::default(),
    );
    let scaled = solve(
        &mut ByDuals::new(Scaled),
        &[250.0, 5e5],
        &Options::default(),
    );
    assert_eq!(plain.iterations, scaled.iterations);
    assert!((scaled.x[1] * 1e-9 / plain.x[1] - 1.0).abs() < 1e-9);
}
