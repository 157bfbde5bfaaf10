//! Solutions of random problems satisfy their laws, and equal those of slow methods.

use super::*;

/// Distance allowed to the surfaces and products, beside the size of forces and velocities.
const OPTIMAL: f64 = 1e-8;
pub(super) const OTHER_METHOD: f64 = 1e-7;
/// Tolerance on single forces that only count in sum: rounding divided by the ridge.
const REDUNDANT: f64 = 1e-6;

/// The nearest point of the cone, by its two faces.
fn project(a: [f64; 3], mu: f64) -> [f64; 3] {
    let slip = a[1].hypot(a[2]);
    if slip <= mu * a[0] {
        return a;
    }
    // The nearest point of the ray (1, μ d).
    let t = ((a[0] + mu * slip) / (1.0 + mu * mu)).max(0.0);
    let along = if slip > 0.0 { mu * t / slip } else { 0.0 };
    [t, along * a[1], along * a[2]]
}

/// ŷ, with De Saxcé's correction for Coulomb's law.
fn corrected(law: Law, y: [f64; 3], mu: f64) -> [f64; 3] {
    let raise = if law == Law::Coulomb {
        mu * y[1].hypot(y[2])
    } else {
        0.0
    };
    [y[0] + raise, y[1], y[2]]
}

/// f ← Π(f − ŷ / L), very many times.
pub(super) fn projected_iteration(case: &Case, sweeps: usize) -> DVector<f64> {
    let step = 1.0 / case.matrix.norm();
    let mut f = DVector::zeros(case.free_velocity.len());
    for _ in 0..sweeps {
        let y = case.velocity(&f);
        let mut row = 0;
        for (block, &mu) in case.blocks.iter().zip(&case.friction) {
            match *block {
                Block::Free(rows) => (row..row + rows).for_each(|i| f[i] -= step * y[i]),
                Block::Ray => f[row] = (f[row] - step * y[row]).max(0.0),
                Block::Interval => f[row] = (f[row] - step * y[row]).clamp(-mu, mu),
                Block::Spin | Block::Roll => panic!("these cases have no moments"),
                Block::Cone => {
                    let y = corrected(case.law, [y[row], y[row + 1], y[row + 2]], mu);
                    let a = std::array::from_fn(|i| f[row + i] - step * y[i]);
                    f.as_mut_slice()[row..row + 3].copy_from_slice(&project(a, mu));
                }
            }
            row += block.rows();
        }
    }
    f
}

#[track_caller]
pub(super) fn assert_optimal(name: &str, case: &Case, f: &DVector<f64>) {
    let y = case.velocity(f);
    let (force, velocity) = (
        f.amax(),
        case.free_velocity.amax() + case.matrix.amax() * f.amax(),
    );
    let mut row = 0;
    for (block, &mu) in case.blocks.iter().zip(&case.friction) {
        match *block {
            Block::Free(rows) => {
                let largest = y.rows(row, rows).amax();
                assert!(
                    largest <= OPTIMAL * velocity,
                    "{name}: bilateral {largest:e}"
                );
            }
            Block::Ray => {
                assert!(
                    f[row] >= 0.0 && y[row] >= -OPTIMAL * velocity,
                    "{name}: ray"
                );
                assert!(f[row] * y[row] <= OPTIMAL * force * velocity, "{name}: ray");
            }
            Block::Interval => {
                let (f, y) = (f[row], y[row]);
                assert!(f.abs() <= mu * (1.0 + 1e-12), "{name}: interval {f}");
                let room = if y > 0.0 { mu + f } else { mu - f };
                let product = room.min(force) * y.abs();
                assert!(product <= OPTIMAL * force * velocity, "{name}: interval");
            }
            Block::Spin | Block::Roll => panic!("{name}: these cases have no moments"),
            Block::Cone => {
                let y = corrected(case.law, [y[row], y[row + 1], y[row + 2]], mu);
                let f = [f[row], f[row + 1], f[row + 2]];
                let outside = f[1].hypot(f[2]) - mu * f[0];
                assert!(
                    outside <= 1e-9 * force && f[0] >= 0.0,
                    "{name}: cone {outside:e}"
                );
                let dual = mu * y[1].hypot(y[2]) - y[0];
                assert!(dual <= OPTIMAL * velocity, "{name}: dual cone {dual:e}");
                let product = f[0] * y[0] + f[1] * y[1] + f[2] * y[2];
                assert!(
                    product.abs() <= OPTIMAL * force * velocity,
                    "{name}: product {product:e}"
                );
            }
        }
        row += block.rows();
    }
}

/// Bilateral rows, rays, cones; coordinates; decades of mass.
const SHAPES: [([usize; 3], usize, f64); 6] = [
    ([0, 0, 1], 3, 0.0),
    ([0, 0, 4], 14, 0.0),
    ([0, 0, 4], 8, 0.0),
    ([4, 3, 3], 30, 0.0),
    ([2, 3, 3], 10, 2.0),
    ([0, 0, 4], 12, 4.0),
];

#[test]
fn solutions_of_random_problems_satisfy_their_laws() {
    for law in LAWS {
        for (shape, (counts, dof, decades)) in SHAPES.into_iter().enumerate() {
            let mut random = Random(1000.0 * shape as f64);
            for seed in 0..100 {
                let case = random.case(law, counts, dof, decades);
                let solution = case.solve();
                let name = format!("{law:?}, shape {shape}, seed {seed}");
                assert!(
                    solution.certificate.is_converged(),
                    "{name}: {:?}",
                    solution.certificate
                );
                assert_optimal(&name, &case, &solution.f);
            }
        }
    }
}

#[test]
fn certificates_hold_their_targets() {
    let mut random = Random(77.0);
    for law in LAWS {
        for _ in 0..50 {
            let certificate = random.case(law, [2, 2, 4], 12, 1.0).solve().certificate;
            assert!(certificate.cone_violation <= 1e-9, "{certificate:?}");
            assert!(certificate.complementarity <= 1e-8, "{certificate:?}");
            assert!(certificate.residual <= 1e-9 && certificate.dual_violation <= 1e-9);
            assert!(certificate.iterations > 0);
        }
    }
}

#[test]
fn solutions_equal_those_of_very_many_projections() {
    for law in LAWS {
        let mut random = Random(5.0);
        for counts in [[0, 0, 1], [0, 0, 3], [2, 2, 2], [0, 1, 4]] {
            let rows = counts[0] + counts[1] + 3 * counts[2];
            let mut case = random.case(law, counts, rows, 0.0);
            case.regularization.fill(0.5);
            let (actual, expected) = (case.solve().f, projected_iteration(&case, 20_000));
            assert_near(
                "forces",
                actual.as_slice(),
                expected.as_slice(),
                OTHER_METHOD,
            );
        }
    }
}

/// A tower of particles, alternately of mass 1 and of mass `ratio`, each on the one below.
fn tower(law: Law, height: usize, ratio: f64, random: &mut Random) -> Case {
    let n = 3 * height;
    let j = DMatrix::from_fn(n, n, |i, k| f64::from(i == k) - f64::from(i == k + 3));
    let m = DVector::from_fn(n, |i, _| if (i / 3) % 2 == 0 { 1.0 } else { 1.0 / ratio });
    let v = DVector::from_fn(n, |i, _| {
        if i % 3 == 0 {
            -0.01
        } else {
            0.01 * random.next()
        }
    });
    Case::of_jacobian(law, &vec![Block::Cone; height], &j, &m, &v)
}

#[test]
fn tower_of_heavy_on_light_carries_its_weight() {
    let mut random = Random(3.0);
    for law in LAWS {
        for height in [2, 10, 20] {
            let case = tower(law, height, 1e4, &mut random);
            let solution = case.solve();
            let name = format!("{law:?}, height {height}");
            assert!(
                solution.certificate.is_converged(),
                "{name}: {:?}",
                solution.certificate
            );
            assert_optimal(&name, &case, &solution.f);
            if law == Law::Coulomb {
                // Nothing lifts, so that the ground stops everything above it.
                let weight = 0.01 * (height / 2) as f64 * (1.0 + 1e4);
                assert_near(&name, &[solution.f[0]], &[weight], 1e-7);
            }
        }
    }
}

#[test]
fn warm_start_at_the_solution_takes_no_step() {
    for law in LAWS {
        let case = Random(9.0).case(law, [1, 1, 4], 20, 0.0);
        let mut f = case.solve().f;
        let again = case.solver(0.0).solve(&case.problem(), f.as_mut_slice());
        assert_eq!((again.iterations, again.is_converged()), (0, true));
    }
}

// Redundant rows: the least change that solves the problem, the same at each corner.
#[test]
fn redundant_forces_stay_near_the_start() {
    let case = box_on_corners(Law::Coulomb, [0.0, 0.0, -0.2, 0.0, 0.0, 0.0]);
    let along_the_diagonal = |a: f64, b: f64| [a, 0.0, 0.0, b, 0.0, 0.0, b, 0.0, 0.0, a, 0.0, 0.0];
    let mut f = along_the_diagonal(0.07, 0.01);
    let certificate = case.solver(0.0).solve(&case.problem(), &mut f);
    assert!(certificate.is_converged());
    assert_near("forces", &f, &along_the_diagonal(0.08, 0.02), REDUNDANT);
}

// The corners of a box would stick, if that did not stretch the rigid box by a hair; far from them something flies off fast. The
// forces between the corners grow until some of them slip, slowly.
#[test]
fn slow_slip_between_redundant_contacts_beside_fast_ones_is_found() {
    for stretch in [1e-3, 1e-5, 1e-6] {
        let of_box = box_on_corners(Law::Coulomb, [0.0, 0.0, -1.0, 0.0, 0.0, 0.0]);
        let mut case = Case::new(
            Law::Coulomb,
            &[Block::Cone; 5],
            0.5,
            DMatrix::identity(15, 15),
            &[0.0; 15],
        );
        case.matrix
            .view_mut((0, 0), (12, 12))
            .copy_from(&of_box.matrix);
        case.free_velocity
            .rows_mut(0, 12)
            .copy_from(&of_box.free_velocity);
        case.free_velocity[12] = 400.0;
        for (corner, [x, y]) in [[1.0, 0.4], [0.9, -1.1], [-1.0, 0.8], [-0.7, -1.0]]
            .iter()
            .enumerate()
        {
            case.free_velocity[3 * corner + 1] += stretch * x;
            case.free_velocity[3 * corner + 2] += stretch * y;
        }
        let solution = case.solve();
        assert!(
            solution.certificate.is_converged(),
            "{stretch}: {:?}",
            solution.certificate
        );
        let (f, y) = (&solution.f, case.velocity(&solution.f));
        let mut slipping = 0;
        for cone in (0..15).step_by(3) {
            let (rho, slip) = (f.rows(cone + 1, 2), y.rows(cone + 1, 2));
            assert!(rho.norm() <= 0.5 * f[cone] + 1e-9 && y[cone] > -1e-9);
            assert!((f[cone] * y[cone]).abs() < 1e-9);
            // Friction takes all the power out of the slip that it can.
            let power = rho.dot(&slip) + 0.5 * f[cone] * slip.norm();
            assert!(
                power.abs() < 1e-9 * slip.norm() + 1e-13,
                "{stretch}: {power:e}"
            );
            slipping += usize::from(f[cone] > 0.0 && slip.norm() > 1e-2 * stretch);
        }
        assert!(slipping > 0, "{stretch}");
    }
}
