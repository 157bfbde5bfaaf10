//! Lanes of a problem of which blocks take part in some only: each is solved as if it were alone, to the last bit.

use dualbody::Lanes;
use dualbody::cone::{Block, ConeProblem, ConeSolver, Law, Mode};

const LANES: usize = 4;
const BLOCKS: [Block; 5] = [
    Block::Cone,
    Block::Spin,
    Block::Ray,
    Block::Cone,
    Block::Roll,
];
const FRICTION: [f64; 5] = [0.6, 0.1, 0.0, 0.3, 0.2];
const ROWS: usize = 10;
const FREE: [f64; ROWS] = [-1.0, 0.4, 0.2, 0.3, -0.5, -2.0, 1.0, 0.7, 0.1, -0.3];
/// Blocks without a force: of its own accord in each lane; a moment with its cone.
const ABSENT: [&[usize]; LANES] = [&[], &[0, 1], &[2], &[2, 3, 4]];

/// G + R of the rows at hand, and G as it is.
fn entry(i: usize, j: usize) -> f64 {
    let x = |i: usize, k: usize| (((i + 1) * (k + 2)) as f64).sin();
    (0..12).map(|k| x(i, k) * x(j, k)).sum()
}

fn rows_of(block: usize) -> std::ops::Range<usize> {
    let first = BLOCKS[..block].iter().map(|own| own.rows()).sum();
    first..first + BLOCKS[block].rows()
}

/// Forces and modes of the blocks that take part in a lane, alone.
fn alone(law: Law, lane: usize) -> (Vec<f64>, Vec<Mode>) {
    let present = || (0..BLOCKS.len()).filter(|k| !ABSENT[lane].contains(k));
    let rows: Vec<usize> = present().flat_map(rows_of).collect();
    let each = |of: &[f64]| -> Vec<f64> { rows.iter().map(|&row| of[row]).collect() };
    let matrix: Vec<f64> = (rows.iter())
        .flat_map(|&j| rows.iter().map(move |&i| entry(i, j)))
        .collect();
    let (mut f, mut solver) = (vec![0.0; rows.len()], ConeSolver::new(0, 0));
    let problem = ConeProblem {
        law,
        blocks: &present().map(|k| BLOCKS[k]).collect::<Vec<_>>(),
        friction: &present().map(|k| FRICTION[k]).collect::<Vec<_>>(),
        matrix: &matrix,
        regularization: &each(&[1e-3; ROWS]),
        free_velocity: &each(&FREE),
    };
    assert!(solver.solve(&problem, &mut f).is_converged());
    (f, solver.modes().to_vec())
}

#[test]
fn lane_has_the_forces_that_its_blocks_have_alone() {
    for law in [Law::Convex, Law::Coulomb] {
        let is_absent = |row: usize, lane: usize| {
            let mut absent = ABSENT[lane].iter();
            // The moments of an absent cone are absent however soft they are.
            absent.any(|&k| rows_of(k).contains(&row) && BLOCKS[k] != Block::Spin)
        };
        let regularization: [Lanes<LANES>; ROWS] = std::array::from_fn(|row| {
            Lanes(std::array::from_fn(|lane| match is_absent(row, lane) {
                true => f64::INFINITY,
                false => 1e-3,
            }))
        });
        let all = |x: f64| Lanes([x; LANES]);
        let matrix: Vec<_> = (0..ROWS * ROWS)
            .map(|at| all(entry(at % ROWS, at / ROWS)))
            .collect();
        let problem = ConeProblem {
            law,
            blocks: &BLOCKS,
            friction: &FRICTION.map(all),
            matrix: &matrix,
            regularization: &regularization,
            free_velocity: &FREE.map(all),
        };
        // Forces from which a solution starts do not stay in lanes where a block has none.
        let mut f = [all(0.0); ROWS];
        (f[4], f[5]) = (Lanes([0.0, 0.0, 3.0, 3.0]), Lanes([0.0, 0.0, 0.0, 3.0]));
        let mut solver = ConeSolver::new(ROWS, BLOCKS.len());
        assert!(solver.solve(&problem, &mut f).is_converged());
        for lane in 0..LANES {
            let (mut forces, mut modes) = {
                let (forces, modes) = alone(law, lane);
                (forces.into_iter(), modes.into_iter())
            };
            for block in 0..BLOCKS.len() {
                let found = solver.modes()[BLOCKS.len() * lane + block];
                let is_absent = ABSENT[lane].contains(&block);
                let mode = if is_absent {
                    Mode::Separated
                } else {
                    modes.next().expect("a block")
                };
                assert_eq!(found, mode, "{law:?}, lane {lane}, block {block}");
                for row in rows_of(block) {
                    let force = if is_absent {
                        0.0
                    } else {
                        forces.next().expect("a row")
                    };
                    assert_eq!(f[row].0[lane], force, "{law:?}, lane {lane}, row {row}");
                }
            }
        }
    }
}
