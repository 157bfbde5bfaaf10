//! Derivatives of rigid contact at rest, where the law is nonsmooth, and a regulator that uses them.

use dualbody::autodiff::Dual;
use dualbody::contact::{ContactLaw, Rigid, Terrain};
use dualbody::control::Lqr;
use dualbody::sim::{ContactReason, RolloutStatus};
use dualbody::{Simulator, State};
use nalgebra::{DMatrix, DVector};

use crate::common::asset;
use crate::common::ground::{differences, free, on};
use crate::common::quadruped::{FEET, crouching, quadruped};

const DT: f64 = 2e-3;
/// Time constant of `Rigid::default()`, s.
const RECOVERY: f64 = 0.02;
/// Half the height of the box, m.
const HALF: f64 = 0.06;

/// The box at rest on an incline, moved off it by a height.
fn box_at_rest(incline: f64, height: f64) -> (Simulator, State) {
    let law = ContactLaw::Rigid(Rigid::default());
    let simulator = on(asset("box.urdf"), Terrain::incline(incline), law).with_time_step(DT);
    let up = HALF + height;
    let at = [-incline.sin() * up, 0.0, incline.cos() * up];
    let state = free(&simulator, at, -incline, [0.0; 6]);
    (simulator, state)
}

// The stated rule: (1 / Δt + 1 / T) / 2 = 275 1/s, on either side on which rounding places the box. Seen from the corners a
// roll moves two of them up and two down, so that −275 is its exact slope on both sides as well.
#[test]
fn slopes_of_a_resting_box_are_the_means_of_both_sides() {
    let expected = -0.5 * (1.0 / DT + 1.0 / RECOVERY);
    for incline in [0.0, 0.1] {
        for height in [0.0, 1e-17, -1e-17, 1e-12, -1e-12] {
            let (simulator, state) = box_at_rest(incline, height);
            let a = simulator.linearize(&state, &[]).a;
            // Height along the normal, roll and pitch, each with its own velocity.
            for k in [2, 3, 4] {
                let slope = a[(6 + k, k)];
                assert!(
                    (slope - expected).abs() < 1e-6 * expected.abs(),
                    "incline {incline}, {height} m high, coordinate {k}: {slope}"
                );
            }
            let reasons = simulator.contact_report(&state, &[]).reasons;
            let resting = reasons.iter().filter(|r| **r == ContactReason::Resting);
            assert_eq!(resting.count(), 4, "{reasons:?}");
        }
    }
}

// Off the surface, by more than a nanometre, each side has its own.
#[test]
fn slopes_beside_the_surface_are_those_of_the_side() {
    for (height, expected) in [(1e-6, -1.0 / DT), (-1e-6, -1.0 / RECOVERY)] {
        let (simulator, state) = box_at_rest(0.0, height);
        let slope = simulator.linearize(&state, &[]).a[(8, 2)];
        assert!((slope / expected - 1.0).abs() < 1e-6, "{height}: {slope}");
    }
}

#[test]
fn jacobian_of_a_resting_box_equals_central_differences() {
    for incline in [0.0, 0.1] {
        let (simulator, state) = box_at_rest(incline, 0.0);
        let exact = simulator.linearize(&state, &[]).a;
        let numeric = differences(&simulator, &state, 1e-6);
        for k in [2, 3, 4] {
            let error = (exact[(6 + k, k)] - numeric[(6 + k, k)]).abs();
            assert!(error < 1e-2, "incline {incline}, coordinate {k}: {error}");
        }
    }
}

// A step over dual numbers has the same slopes as `linearize`, and the same value as one over plain ones, bit for bit.
#[test]
fn dual_step_of_a_resting_box_has_the_slopes_of_the_jacobian() {
    let (simulator, state) = box_at_rest(0.1, 0.0);
    let a = simulator.linearize(&state, &[]).a;
    let plain = simulator.step(&state, &[]);
    let constant = |x: &DVector<f64>| x.map(Dual::<f64, 1>::from);
    let (mut q, v) = (constant(&state.q), constant(&state.v));
    // Along the normal of the incline, the third axis of the box.
    q[0].eps[0] = -(0.1_f64.sin());
    q[2].eps[0] = 0.1_f64.cos();
    let next = simulator.step(&simulator.state(q.as_slice(), v.as_slice()), &[]);
    for (k, v) in next.v.iter().enumerate() {
        assert_eq!(v.re, plain.v[k], "velocity {k}");
        let error = (v.eps[0] - a[(6 + k, 2)]).abs();
        assert!(error < 1e-6, "velocity {k}: {} {}", v.eps[0], a[(6 + k, 2)]);
    }
}

/// The pose in which springs and dampers at the joints bring it to rest, and their torques there.
fn caught(simulator: &Simulator) -> (State, DVector<f64>) {
    let start = crouching(simulator, 0.4);
    let wanted = start.q.rows(7, 12).into_owned();
    let caught = simulator.rollout(&start, 4000, |_, state, u| {
        for k in 0..12 {
            u[k] = 60.0 * (wanted[k] - state.q[7 + k]) - 2.0 * state.v[6 + k];
        }
    });
    let held = caught.inputs[caught.inputs.len() - 1].clone();
    (caught.last().clone(), held)
}

/// An orthonormal basis of the motions in which no foot moves along the ground: all others are none that inputs could
/// cause.
fn on_stuck_feet(simulator: &Simulator, at: &State) -> DMatrix<f64> {
    let (model, nv) = (simulator.model(), simulator.model().nv());
    let contacts = simulator.contacts().expect("feet on the ground");
    let mut square = DMatrix::zeros(nv, nv);
    for foot in 0..FEET.len() {
        let jacobian = contacts.jacobian(model, at.q.as_slice(), foot);
        let across = jacobian.rows(0, 2);
        square += across.transpose() * across;
    }
    let eigen = square.symmetric_eigen();
    let free: Vec<usize> = (0..nv).filter(|&k| eigen.eigenvalues[k] < 1e-9).collect();
    let basis = eigen.eigenvectors.select_columns(&free);
    let mut both = DMatrix::zeros(2 * nv, 2 * free.len());
    for part in 0..2 {
        both.view_mut((part * nv, part * free.len()), (nv, free.len()))
            .copy_from(&basis);
    }
    both
}

// The regulator is designed on the Jacobian at rest, each foot at its nonsmooth point, and brings the simulated robot back.
#[test]
fn regulator_designed_at_rest_stabilizes_the_quadruped_on_rigid_ground() {
    let simulator = quadruped(|_| ContactLaw::Rigid(Rigid::default()), Terrain::flat(0.0));
    let (rest, held) = caught(&simulator);
    assert!(rest.v.amax() < 1e-6, "{}", rest.v.amax());
    let reasons = simulator.contact_report(&rest, held.as_slice()).reasons;
    assert_eq!(reasons, [ContactReason::Resting; 4]);
    let step = simulator.linearize(&rest, held.as_slice());
    let basis = on_stuck_feet(&simulator, &rest);
    assert_eq!(basis.ncols(), 2 * (18 - 8));
    let (a, b) = (
        basis.transpose() * &step.a * &basis,
        basis.transpose() * &step.b,
    );
    let weight = |k: usize| match k {
        k if k < 6 => 100.0,
        k if k < 18 => 1.0,
        _ => 0.1,
    };
    let q = DMatrix::from_diagonal(&DVector::from_fn(36, |k, _| weight(k)));
    let q = basis.transpose() * q * &basis;
    let lqr = Lqr::discrete(&a, &b, &q, &DMatrix::identity(12, 12).scale(0.1));
    assert!(lqr.is_stabilized(), "{}", lqr.spectral_radius());
    let gain = lqr.gain * basis.transpose();
    let mut pushed = rest.clone();
    pushed.v[1] += 0.05;
    pushed.v[3] += 0.1;
    let stood = simulator.rollout(&pushed, 1500, |_, state, u| {
        let off = state.deviation(simulator.model(), &rest);
        u.copy_from_slice((&held - &gain * off).as_slice());
    });
    assert_eq!(stood.status, RolloutStatus::Completed);
    let left = stood.last().deviation(simulator.model(), &rest);
    assert!(left.amax() < 1e-2, "{left}");
}
