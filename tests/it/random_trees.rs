//! Trees of any size and seed, with every joint kind.

use dualbody::autodiff::finite_difference;
use dualbody::dynamics::{
    bias_forces, coriolis_matrix, forward_dynamics, gravity_forces, inverse_dynamics,
    kinetic_energy, mass_matrix, mass_matrix_inverse,
};
use dualbody::model::samples;
use dualbody::{Integrator, Simulator, State};
use nalgebra::DMatrix;
use proptest::prelude::*;

use crate::common::{
    FINITE_DIFFERENCE, OTHER_ALGORITHM, SAME_ALGEBRA, random_point, relative_error,
};

fn column(x: &nalgebra::DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_column_slice(x.len(), 1, x.as_slice())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn dynamics_of_any_tree_obey_their_identities(n in 0_usize..20, tree: u64, seed: u64) {
        let model = samples::random_tree(n, tree);
        let point = random_point(&model, seed);
        let (q, v, a) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        let m = mass_matrix(&model, q);
        let tau = inverse_dynamics(&model, q, v, a);
        let bias = bias_forces(&model, q, v);
        prop_assert!(relative_error(&column(&(&m * &point.w + &bias)), &column(&tau)) < SAME_ALGEBRA);
        prop_assert!(relative_error(&column(&forward_dynamics(&model, q, v, tau.as_slice())), &column(&point.w)) < OTHER_ALGORITHM);
        prop_assert!((kinetic_energy(&model, q, v) - 0.5 * point.v.dot(&(&m * &point.v))).abs() < SAME_ALGEBRA * m.amax().max(1.0));
        let velocity_forces = coriolis_matrix(&model, q, v) * &point.v + gravity_forces(&model, q);
        prop_assert!(relative_error(&column(&velocity_forces), &column(&bias)) < SAME_ALGEBRA);
        let identity = DMatrix::identity(model.nv(), model.nv());
        prop_assert!(relative_error(&(mass_matrix_inverse(&model, q) * m), &identity) < OTHER_ALGORITHM);
    }

    #[test]
    fn step_jacobians_of_any_tree_equal_finite_differences(n in 0_usize..6, tree: u64, seed: u64, euler: bool) {
        let model = samples::random_tree(n, tree);
        let integrator = if euler { Integrator::SemiImplicitEuler } else { Integrator::RungeKutta4 };
        let simulator = Simulator::new(model.clone()).with_time_step(5e-3).with_integrator(integrator);
        let point = random_point(&model, seed);
        let u: Vec<f64> = simulator.actuated().iter().map(|&k| point.w[k]).collect();
        let state = State::new(point.q.as_slice(), point.v.as_slice());
        let exact = simulator.linearize(&state, &u);
        let numeric = simulator.estimate_linearization(&state, &u, &finite_difference::Options::default()).linearization;
        prop_assert!(relative_error(&exact.a, &numeric.a) < FINITE_DIFFERENCE);
        prop_assert!(relative_error(&exact.b, &numeric.b) < FINITE_DIFFERENCE);
    }
}
