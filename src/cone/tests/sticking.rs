//! The first guess: where it is accepted it is what Newton's method finds, in lanes as alone.

use super::*;
use crate::cone::sticking::Guess;
use crate::scalar::Lanes;

/// A regularised case of a ray and cones, which press more or less.
fn pressed(law: Law, seed: u32, cones: usize) -> Case {
    let mut random = Random(f64::from(100 * seed));
    let mut case = random.case(law, [0, 1, cones], 12, 0.0);
    let n = case.free_velocity.len();
    case.matrix += DMatrix::identity(n, n) * 5.0;
    case.regularization = (0..n).map(|k| 0.05 * case.matrix[(k, k)]).collect();
    for row in 0..n {
        let is_normal = row == 0 || row % 3 == 1;
        let g = &mut case.free_velocity[row];
        *g = if is_normal { *g - 1.5 } else { 0.2 * *g };
    }
    case
}

/// The forces by Newton's method, which starts with hardly any.
fn searched(case: &Case) -> DVector<f64> {
    let mut f = DVector::from_element(case.free_velocity.len(), 1e-200);
    let certificate = case.solver(0.0).solve(&case.problem(), f.as_mut_slice());
    assert!(certificate.is_converged());
    f
}

#[test]
fn accepted_guesses_are_the_forces_of_newtons_method() {
    let (mut accepted, mut separated, mut refused) = (0, 0, 0);
    for seed in 0..200 {
        let case = pressed(Law::Convex, seed, 3);
        let (expected, mut guess) = (searched(&case), Guess::new());
        let start = vec![0.0; expected.len()];
        if guess.solve(&case.problem(), &start, |x| *x) == 0.0 {
            refused += 1;
            continue;
        }
        let error = (DVector::from_vec(guess.f.clone()) - &expected).amax();
        assert!(error < 1e-9 * (1.0 + expected.amax()), "{seed}: {error:e}");
        let solution = case.solve();
        assert_eq!(solution.f.as_slice(), guess.f);
        assert!(solution.certificate.residual < 1e-12, "{seed}");
        accepted += 1;
        separated += usize::from(guess.f.contains(&0.0));
    }
    assert!(
        accepted > 20 && separated > 5 && refused > 20,
        "{accepted}, {separated}, {refused}"
    );
}

#[test]
fn guesses_of_lanes_are_those_of_single_problems() {
    const WIDTH: usize = 4;
    let mut same = 0;
    for (law, seed) in LAWS
        .into_iter()
        .flat_map(|law| (0..40).map(move |k| (law, k)))
    {
        let lanes: [Case; WIDTH] = std::array::from_fn(|k| pressed(law, 4 * seed + k as u32, 3));
        // The last cone takes part in every second lane.
        let few = |k: usize| k % 2 == 1;
        let n = lanes[0].free_velocity.len();
        let rows = |k: usize| if few(k) { n - 3 } else { n };
        let number = |of: &dyn Fn(usize) -> f64| Lanes::<WIDTH>(std::array::from_fn(of));
        let matrix: Vec<_> = (0..n * n)
            .map(|i| number(&|k| lanes[k].matrix[i]))
            .collect();
        let compliance = |i: usize, k: usize| match i < rows(k) {
            true => lanes[k].regularization[i],
            false => f64::INFINITY,
        };
        let regularization: Vec<_> = (0..n).map(|i| number(&|k| compliance(i, k))).collect();
        let free: Vec<_> = (0..n)
            .map(|i| number(&|k| lanes[k].free_velocity[i]))
            .collect();
        let problem = ConeProblem {
            law,
            blocks: &lanes[0].blocks,
            friction: &[Lanes([0.5; WIDTH]); 5],
            matrix: &matrix,
            regularization: &regularization,
            free_velocity: &free,
        };
        let mut solver = ConeSolver::new(n, 5);
        solver.options.measured = false;
        let mut f = vec![Lanes([0.0; WIDTH]); n];
        solver.solve(&problem, &mut f);
        for (k, case) in lanes.iter().enumerate() {
            let m = rows(k);
            let own = Case {
                blocks: case.blocks[..5 - usize::from(few(k))].to_vec(),
                friction: vec![0.5; 5 - usize::from(few(k))],
                matrix: case.matrix.view((0, 0), (m, m)).into_owned(),
                regularization: case.regularization[..m].to_vec(),
                free_velocity: case.free_velocity.rows(0, m).into_owned(),
                law,
            };
            let expected = own.solve().f;
            let found: Vec<f64> = f.iter().map(|f| f.0[k]).collect();
            assert_eq!(
                &found[..m],
                expected.as_slice(),
                "{law:?}, {seed}, lane {k}"
            );
            assert!(found[m..].iter().all(|&f| f == 0.0));
            same += 1;
        }
    }
    assert_eq!(same, 320);
}
