//! Jacobians against differences, and both modes against each other.

use nalgebra::{DMatrix, DVector};

use super::*;
use crate::identify::shooting::slopes::Derivatives;
use crate::numbers::Domain;
use crate::sim::{StepPoint, StepScratch};

#[test]
fn jacobian_equals_differences_with_starts_as_variables() {
    let data = logged(
        &cartpole(),
        &State::new(&[0.0, 2.0], &[0.0; 2]),
        12,
        [0.0; 2],
    );
    let nominal = wrong();
    let options = ShootingOptions {
        samples: 5,
        starts: Starts::Free,
        ..Default::default()
    };
    check_jacobian(Shooting::new(&nominal, &data, &adjustable(), &options).unwrap());
}

pub(super) fn check_jacobian(mut problem: Shooting<'_>) {
    let mut x = problem.start();
    for (x, domain) in x.iter_mut().zip(&problem.variables.domains) {
        // Away from the least values, beyond which parameters are not those of a robot.
        *x += if *domain == Domain::Finite { 0.0 } else { 0.1 };
    }
    let (m, n) = (problem.n_residuals(), problem.n_directions(&x));
    let mut jacobian = DMatrix::zeros(m, n);
    problem.jacobian(&x, &mut jacobian);
    for k in 0..n {
        /// A hundredth of the least moment of the pole, of fourth order.
        const STEP: f64 = 2e-6;
        let mut at = |by: f64| {
            let (mut d, mut moved) = (vec![0.0; n], x.clone());
            d[k] = by;
            problem.retract(&x, &d, &mut moved);
            let mut out = DVector::zeros(m);
            problem.residuals(&moved, out.as_mut_slice());
            out
        };
        let near = (at(STEP) - at(-STEP)) / (2.0 * STEP);
        let far = (at(2.0 * STEP) - at(-2.0 * STEP)) / (4.0 * STEP);
        let difference = (near * 4.0 - far) / 3.0;
        let error = (difference - jacobian.column(k)).amax() / (1.0 + jacobian.column(k).amax());
        assert!(error < 1e-6, "{k}: {error}");
    }
}

// All at once they come by vector-Jacobian products, one by one over dual numbers.
#[test]
fn slopes_are_the_same_in_both_modes() {
    let simulator = cartpole();
    let state = State::new(&[0.1, 2.0], &[0.3, -0.4]);
    let u = [1.0, 0.2];
    let (mut scratch, mut next) = (StepScratch::new(&simulator), simulator.neutral_state());
    simulator.step_into(&state, &u, &mut scratch, &mut next);
    let at = StepPoint {
        state: &state,
        u: &u,
        acceleration: Some(&scratch.acceleration().a),
    };
    // The last parameter, the time step, is none that is adjusted.
    let adjustable = 0..simulator.parameters().len() - 1;
    let targets: Vec<_> = adjustable.map(|k| vec![(k, 1.0)]).collect();
    let of = |targets: &[Vec<(usize, f64)>]| {
        let mut slopes = Derivatives::new(&simulator, targets);
        slopes.update(&simulator, &at, &next);
        (slopes.by_state, slopes.by_number)
    };
    let (by_state, by_number) = of(&targets);
    for (k, target) in targets.iter().enumerate() {
        let (own_state, own) = of(std::slice::from_ref(target));
        assert!((own_state - &by_state).amax() < 1e-13);
        assert!((own - by_number.columns(k, 1)).amax() < 1e-13, "{k}");
    }
}
