//! Controllers on the robots that they are made for.

use dualbody::control::{ComputedTorque, FiniteHorizonLqr, Lqr, LqrStage, LqrStatus};
use dualbody::model::samples;
use dualbody::{Integrator, Simulator, State};
use nalgebra::DMatrix;

use crate::common::everything::INTEGRATORS;
use crate::common::{assert_close, floating_robot, random_point};

fn cartpole() -> Simulator {
    Simulator::new(samples::cartpole())
        .with_time_step(0.01)
        .with_actuated_joints(&["linear"])
        .expect("a known joint")
}

#[test]
fn lqr_on_the_step_jacobians_balances_the_pole_with_both_integrators() {
    for integrator in INTEGRATORS {
        let simulator = cartpole().with_integrator(integrator);
        let upright = State::neutral(simulator.model());
        let step = simulator.linearize(&upright, &[0.0]);
        let lqr = Lqr::discrete(
            &step.a,
            &step.b,
            &DMatrix::identity(4, 4),
            &DMatrix::from_element(1, 1, 0.01),
        );
        assert_eq!(lqr.status, LqrStatus::Stabilized);
        let rollout = simulator.rollout(
            &State::new(&[0.3, 0.4], &[0.0, 0.5]),
            1500,
            |_, state, u| {
                u.copy_from_slice(
                    lqr.control(&state.deviation(simulator.model(), &upright))
                        .as_slice(),
                );
            },
        );
        assert!(
            rollout.last().deviation(simulator.model(), &upright).norm() < 1e-4,
            "{integrator:?}"
        );
    }
}

// The cost-to-go of the linear regulator is the cost that the nonlinear robot pays, to second order in the start.
#[test]
fn cost_to_go_equals_the_cost_of_a_small_rollout() {
    let simulator = cartpole();
    let upright = State::neutral(simulator.model());
    let step = simulator.linearize(&upright, &[0.0]);
    let (q, r) = (DMatrix::identity(4, 4), DMatrix::from_element(1, 1, 0.01));
    let lqr = Lqr::discrete(&step.a, &step.b, &q, &r);
    let start = State::new(&[1e-3, 2e-3], &[-1e-3, 1e-3]);
    let rollout = simulator.rollout(&start, 3000, |_, state, u| {
        u.copy_from_slice(
            lqr.control(&state.deviation(simulator.model(), &upright))
                .as_slice(),
        );
    });
    let cost: f64 = rollout
        .states
        .iter()
        .zip(&rollout.inputs)
        .map(|(s, u)| {
            s.deviation(simulator.model(), &upright).norm_squared() + 0.01 * u.norm_squared()
        })
        .sum();
    let x = start.deviation(simulator.model(), &upright);
    let expected = x.dot(&(&lqr.cost_to_go * &x));
    assert!(
        (cost - expected).abs() < 1e-4 * expected,
        "{cost} against {expected}"
    );
}

#[test]
fn pole_without_input_is_not_stabilizable_and_its_mode_is_named() {
    let simulator = cartpole();
    let step = simulator.linearize(&State::neutral(simulator.model()), &[0.0]);
    let lqr = Lqr::discrete(
        &step.a,
        &(step.b * 0.0),
        &DMatrix::identity(4, 4),
        &DMatrix::identity(1, 1),
    );
    let LqrStatus::NotStabilizable { eigenvalue } = lqr.status else {
        panic!("{}", lqr.status)
    };
    // The falling pole: s² (J + m l² − m² l² / (m_c + m_p)) = m g l, per step of 10 ms about 1 + 0.01 s.
    let inertia: f64 = 0.041_669_791_666_666_67 + 0.125 - 0.0625 / 1.5;
    let growth = 1.0 + 0.01 * (0.25 * 9.81 / inertia).sqrt();
    assert!(
        (eigenvalue.re - growth).abs() < 2e-3 && eigenvalue.im == 0.0,
        "{eigenvalue}"
    );
}

#[test]
fn floating_robot_with_all_joints_and_a_free_base_is_reported_as_not_stabilizable() {
    // Nothing holds the base against gravity, and no joint reaches the momentum of the whole.
    let simulator = Simulator::new(floating_robot()).with_time_step(0.01);
    let n = 2 * simulator.model().nv();
    let step = simulator.linearize(
        &State::neutral(simulator.model()),
        &vec![0.0; simulator.nu()],
    );
    let lqr = Lqr::discrete(
        &step.a,
        &step.b,
        &DMatrix::identity(n, n),
        &DMatrix::identity(simulator.nu(), simulator.nu()),
    );
    assert!(
        matches!(lqr.status, LqrStatus::NotStabilizable { .. }),
        "{}",
        lqr.status
    );
}

#[test]
fn time_varying_gains_along_a_fixed_point_approach_the_stationary_gain() {
    let simulator = cartpole();
    let step = simulator.linearize(&State::neutral(simulator.model()), &[0.0]);
    let (q, r) = (DMatrix::identity(4, 4), DMatrix::identity(1, 1));
    let stage = LqrStage {
        a: step.a.clone(),
        b: step.b.clone(),
        q: q.clone(),
        r: r.clone(),
    };
    let finite = FiniteHorizonLqr::discrete(&vec![stage; 3000], &q);
    assert!(finite.is_solved());
    assert_close(
        &finite.gains[0],
        &Lqr::discrete(&step.a, &step.b, &q, &r).gain,
        1e-9,
        "gain",
    );
}

#[test]
fn computed_torque_reaches_its_target_on_every_fully_actuated_sample() {
    for model in [
        samples::pendulum(),
        samples::double_pendulum(),
        samples::cartpole(),
        samples::arm(),
    ] {
        let simulator = Simulator::new(model.clone())
            .with_time_step(1e-3)
            .with_integrator(Integrator::RungeKutta4);
        let controller = ComputedTorque::new(&model, 100.0, 20.0);
        let (start, end) = (random_point(&model, 1), random_point(&model, 2));
        let target = State::new(end.q.as_slice(), &vec![0.0; model.nv()]);
        let rollout = simulator.rollout(
            &State::new(start.q.as_slice(), start.v.as_slice()),
            2000,
            |_, state, u| {
                u.copy_from_slice(controller.torque(&model, state, &target).as_slice());
            },
        );
        assert!(
            rollout.last().deviation(&model, &target).norm() < 1e-5,
            "{}",
            model.name()
        );
    }
}
