//! Problems whose matrix is a product by blocks, beside the same problems in one piece.

use super::super::{BlockProblem, Columns, Status};
use super::*;

/// A chain of bodies with two contacts between neighbours: X by blocks and G.
fn chain(bodies: usize) -> (Columns, Vec<f64>, usize) {
    let rows = 6 * (bodies - 1);
    let entry = |row: usize, k: usize| (1.3 * row as f64 + 0.9 * (row * k) as f64 + 0.4).sin();
    let mut columns = Columns::default();
    columns.start((0..bodies).map(|_| 6));
    let mut dense = vec![vec![0.0; 6 * bodies]; rows];
    for (row, dense) in dense.iter_mut().enumerate() {
        columns.push_row();
        for node in [row / 6, row / 6 + 1] {
            columns.push_part(node, (0..6).map(|k| entry(row, 6 * node + k)));
            (0..6).for_each(|k| dense[6 * node + k] = entry(row, 6 * node + k));
        }
    }
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum();
    let matrix = dense
        .iter()
        .flat_map(|a| dense.iter().map(move |b| product(a, b)))
        .collect();
    (columns, matrix, rows)
}

// With compliance there is one solution, which both ways find.
#[test]
fn forces_by_blocks_equal_those_in_one_piece() {
    let (columns, matrix, rows) = chain(9);
    let free_velocity: Vec<f64> = (0..rows).map(|k| (0.7 * k as f64).cos() - 0.4).collect();
    let blocks = vec![Block::Cone; rows / 3];
    let friction: Vec<f64> = (0..blocks.len())
        .map(|k| 0.3 + 0.1 * (k % 4) as f64)
        .collect();
    for (law, compliance) in [(Law::Convex, 0.2), (Law::Coulomb, 0.2), (Law::Convex, 1e-2)] {
        let regularization = vec![compliance; rows];
        let whole = ConeProblem {
            law,
            blocks: &blocks,
            friction: &friction,
            matrix: &matrix,
            regularization: &regularization,
            free_velocity: &free_velocity,
        };
        let by_blocks = BlockProblem {
            law,
            blocks: &blocks,
            friction: &friction,
            columns: &columns,
            regularization: &regularization,
            free_velocity: &free_velocity,
        };
        let (mut solver, mut f, mut expected) = (
            ConeSolver::<f64>::new(0, 0),
            vec![0.0; rows],
            vec![0.0; rows],
        );
        assert!(
            solver.solve_blocks(&by_blocks, &mut f).is_converged(),
            "{law:?}"
        );
        assert!(
            solver.solve(&whole, &mut expected).is_converged(),
            "{law:?}"
        );
        for (f, expected) in f.iter().zip(&expected) {
            assert!(
                (f - expected).abs() < 1e-8,
                "{law:?} {compliance}: {f} {expected}"
            );
        }
    }
}

#[test]
fn what_is_not_finite_has_no_forces() {
    let (columns, _, rows) = chain(3);
    let problem = BlockProblem {
        law: Law::Coulomb,
        blocks: &vec![Block::Cone; rows / 3],
        friction: &vec![0.5; rows / 3],
        columns: &columns,
        regularization: &vec![0.0; rows],
        free_velocity: &vec![f64::NAN; rows],
    };
    let mut f = vec![1.0; rows];
    let certificate = ConeSolver::<f64>::new(0, 0).solve_blocks(&problem, &mut f);
    assert_eq!(certificate.status, Status::NotFinite);
    assert!(f.iter().all(|&f| f == 0.0));
}
