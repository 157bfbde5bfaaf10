//! Problems that can be solved by hand.

use super::*;

const SAME_ALGEBRA: f64 = 1e-11;

/// A particle on a plane, in (normal, down the slope, across).
fn particle(law: Law, mass: f64, mu: f64, free_velocity: [f64; 3]) -> Case {
    Case::new(
        law,
        &[Block::Cone],
        mu,
        DMatrix::identity(3, 3) / mass,
        &free_velocity,
    )
}

// Free velocity g Δt (−cos α, sin α, 0): it stays iff tan α ≤ μ; else it slides with y = g Δt (sin α − μ cos α).
#[test]
fn particle_on_a_slope_sticks_iff_the_slope_is_below_the_friction() {
    let (mass, dt_gravity, mu) = (2.0, 0.0981, 0.5);
    for degrees in [0.0, 10.0, 26.5, 26.6, 45.0, 80.0_f64] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let case = particle(
            Law::Coulomb,
            mass,
            mu,
            [-dt_gravity * cos, dt_gravity * sin, 0.0],
        );
        let solution = case.solve();
        assert!(solution.certificate.is_converged());
        let weight = mass * dt_gravity;
        let friction = f64::min(sin, mu * cos);
        let expected = [weight * cos, -weight * friction, 0.0];
        assert_near("forces", solution.f.as_slice(), &expected, SAME_ALGEBRA);
        let mode = if sin <= mu * cos {
            Mode::Sticking
        } else {
            Mode::Sliding
        };
        assert_eq!(solution.modes, [mode], "at {degrees}°");
    }
}

#[test]
fn sliding_friction_opposes_slip_and_coulomb_does_not_lift() {
    let case = particle(Law::Coulomb, 1.0, 0.3, [-2.0, 3.0, -4.0]);
    let solution = case.solve();
    assert_near(
        "forces",
        solution.f.as_slice(),
        &[2.0, -0.36, 0.48],
        SAME_ALGEBRA,
    );
    assert_near(
        "velocity",
        case.velocity(&solution.f).as_slice(),
        &[0.0, 2.64, -3.52],
        SAME_ALGEBRA,
    );
}

// For G = 1 the convex law is the projection of −g on the cone: p (1, μ d), p = (−gₙ + μ ‖gₜ‖) / (1 + μ²).
#[test]
fn convex_law_lifts_while_sliding_by_friction_times_slip() {
    let case = particle(Law::Convex, 1.0, 0.3, [-2.0, 3.0, -4.0]);
    let solution = case.solve();
    let p = (2.0 + 0.3 * 5.0) / 1.09;
    assert_near(
        "forces",
        solution.f.as_slice(),
        &[p, -0.18 * p, 0.24 * p],
        SAME_ALGEBRA,
    );
    let y = case.velocity(&solution.f);
    assert_near("lift", &[y[0]], &[0.3 * y[1].hypot(y[2])], SAME_ALGEBRA);
    assert!(y[0] > 1.0);
    assert_eq!(solution.modes, [Mode::Sliding]);
}

#[test]
fn contact_that_opens_has_no_force() {
    for law in LAWS {
        let solution = particle(law, 1.0, 0.5, [3.0, 1.0, 1.0]).solve();
        assert_eq!(
            (solution.f.as_slice(), &solution.modes[..]),
            (&[0.0; 3][..], &[Mode::Separated][..])
        );
    }
}

#[test]
fn without_friction_only_the_normal_force_is_left() {
    for law in LAWS {
        for slip in [0.0, 3.0] {
            let solution = particle(law, 2.0, 0.0, [-1.0, slip, 0.0]).solve();
            assert!(solution.certificate.is_converged());
            assert_near(
                "forces",
                solution.f.as_slice(),
                &[2.0, 0.0, 0.0],
                SAME_ALGEBRA,
            );
            assert_eq!(solution.modes, [Mode::Sliding]);
        }
    }
}

#[test]
fn regularisation_gives_way_like_a_spring() {
    let mut case = particle(Law::Convex, 1.0, 0.5, [-3.0, 0.0, 0.0]);
    case.regularization[0] = 0.5;
    assert_near(
        "forces",
        case.solve().f.as_slice(),
        &[2.0, 0.0, 0.0],
        SAME_ALGEBRA,
    );
}

#[test]
fn two_symmetric_contacts_share_the_load() {
    // A bar of mass 1 and inertia 1 on two feet at ±1: coordinates z, x, angle.
    let j = DMatrix::from_row_slice(
        6,
        3,
        &[
            1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, //
            1.0, 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0,
        ],
    );
    let v = DVector::from_column_slice(&[-1.0, 0.2, 0.0]);
    for law in LAWS {
        let case = Case::of_jacobian(
            law,
            &[Block::Cone; 2],
            &j,
            &DVector::from_element(3, 1.0),
            &v,
        );
        let expected = [0.5, -0.1, 0.0, 0.5, -0.1, 0.0];
        assert_near("forces", case.solve().f.as_slice(), &expected, SAME_ALGEBRA);
    }
}

#[test]
fn normal_forces_on_redundant_corners_sum_to_the_weight() {
    for law in LAWS {
        let still = box_on_corners(law, [0.0, 0.0, -0.2, 0.0, 0.0, 0.0]).solve();
        let corners: Vec<f64> = [0.05, 0.0, 0.0].repeat(4);
        assert_near("equal corners", still.f.as_slice(), &corners, 1e-6);
        assert!(still.certificate.is_converged());

        let pushed = box_on_corners(law, [0.03, -0.02, -0.2, 0.01, 0.02, 0.0]).solve();
        let sum = |row: usize| (0..4).map(|corner| pushed.f[3 * corner + row]).sum::<f64>();
        assert_near("sums", &[sum(0), sum(1), sum(2)], &[0.2, -0.03, 0.02], 1e-9);
        assert_eq!(pushed.modes, [Mode::Sticking; 4]);
    }
}

#[test]
fn sliding_box_is_slowed_by_friction_times_weight() {
    let case = box_on_corners(Law::Coulomb, [3.0, 0.0, -0.2, 0.0, 0.0, 0.0]);
    let solution = case.solve();
    let y = case.velocity(&solution.f);
    let sum: f64 = (0..4).map(|corner| solution.f[3 * corner + 1]).sum();
    assert!(solution.certificate.is_converged());
    let normal: f64 = (0..4).map(|corner| solution.f[3 * corner]).sum();
    assert_near("friction", &[sum], &[-0.5 * normal], 1e-9);
    assert!((0..4).all(|corner| y[3 * corner].abs() < 1e-9 || solution.f[3 * corner] < 1e-12));
}

// A joint at its limit: with f₁ bilateral and f₂ ≥ 0,  2 f₁ + f₂ = 1,  f₁ + 2 f₂ = g₂.
#[test]
fn ray_holds_only_what_presses() {
    let matrix = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
    let case = |g| {
        Case::new(
            Law::Convex,
            &[Block::Free(1), Block::Ray],
            0.0,
            matrix.clone(),
            &[-1.0, g],
        )
    };
    let pressing = case(-2.0).solve();
    assert_near("pressing", pressing.f.as_slice(), &[0.0, 1.0], SAME_ALGEBRA);
    assert_eq!(pressing.modes, [Mode::Bilateral, Mode::Pressing]);
    let open = case(0.0).solve();
    assert_near("open", open.f.as_slice(), &[0.5, 0.0], SAME_ALGEBRA);
    assert_eq!(open.modes, [Mode::Bilateral, Mode::Separated]);
}

#[test]
fn bilateral_rows_equal_the_linear_solution() {
    let case = Random(0.0).case(Law::Convex, [7, 0, 0], 9, 2.0);
    let expected = -case
        .matrix
        .clone()
        .lu()
        .solve(&case.free_velocity)
        .expect("regular");
    assert_near(
        "forces",
        case.solve().f.as_slice(),
        expected.as_slice(),
        1e-9,
    );
}

#[test]
fn modes_between_modes_are_named() {
    for law in LAWS {
        assert_eq!(
            particle(law, 1.0, 0.5, [0.0; 3]).solve().modes,
            [Mode::Touching]
        );
        assert_eq!(
            particle(law, 1.0, 0.5, [-1.0, 0.5, 0.0]).solve().modes,
            [Mode::Impending]
        );
    }
}

// A block that gives way without a force does not affect others, however large its own entries are.
#[test]
fn block_that_gives_way_has_no_force_and_does_not_swamp_the_others() {
    for law in [Law::Convex, Law::Coulomb] {
        let blocks = [Block::Cone, Block::Ray, Block::Cone];
        let mut matrix = DMatrix::identity(7, 7) * 0.5;
        for (i, j) in [(0, 3), (0, 4), (3, 6)] {
            matrix[(i, j)] = 0.2;
            matrix[(j, i)] = 0.2;
        }
        let free_velocity = [-3.0, 0.5, 0.1, 1e12, -1e12, 1e12, 1e12];
        let mut case = Case::new(law, &blocks, 0.4, matrix, &free_velocity);
        for row in 3..7 {
            case.regularization[row] = f64::INFINITY;
        }
        let solution = case.solve();
        let alone = particle(law, 2.0, 0.4, [-3.0, 0.5, 0.1]).solve();
        assert!(solution.certificate.is_converged());
        assert_near(
            "forces",
            &solution.f.as_slice()[..3],
            alone.f.as_slice(),
            SAME_ALGEBRA,
        );
        assert!(
            solution.f.iter().skip(3).all(|&f| f == 0.0),
            "{}",
            solution.f
        );
        assert_eq!(solution.modes[1..], [Mode::Separated; 2]);
    }
}
