"""Single shooting, dynamics and costs that are functions, rates in continuous time."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import asset

import dualbody as db
from dualbody.contact import Contacts, Rigid
from dualbody.trajopt import Activation, CenterOfMass, Ddp, Dynamics, InputError, Problem, Residual, SingleShooting, StateError, Term

POLE = db.Simulator(db.samples.cartpole(), time_step=0.02, actuated=["linear"])


def problem(simulator: db.Simulator | Dynamics = POLE, horizon: int = 12) -> Problem:
    goal = Activation.weighted([1.0, 5.0, 0.1, 0.1])
    stage = [Term(1.0, StateError([0.0] * 4), goal), Term(0.01, InputError())]
    return Problem(simulator, horizon, [0.1, 0.2, 0.0, 0.0], stage, [Term(10.0, StateError([0.0] * 4))])


def test_second_derivatives_of_a_rollout_equal_differences_of_the_gradient() -> None:
    shooting = SingleShooting(problem(), exact_curvature=True)
    z = np.random.default_rng(0).normal(size=12)
    hessian, gradient = shooting.hessian(z), shooting.gradient(z)
    h = 1e-6
    for k in range(3):
        d = h * np.eye(12)[4 * k]
        slope = (shooting.gradient(z + d) - shooting.gradient(z - d)) / (2 * h)
        np.testing.assert_allclose(hessian[4 * k], slope, atol=1e-6 * np.abs(hessian).max())
        np.testing.assert_allclose((shooting.value(z + d) - shooting.value(z - d)) / (2 * h), gradient[4 * k], rtol=1e-5)
    np.testing.assert_allclose(hessian, hessian.T, atol=1e-12 * np.abs(hessian).max())
    gauss_newton = SingleShooting(problem()).hessian(z)
    assert np.linalg.eigvalsh(gauss_newton)[0] > 0 and not np.allclose(gauss_newton, hessian, rtol=1e-3)


def test_single_shooting_finds_what_ddp_finds() -> None:
    costs: list[float] = []
    shooting = SingleShooting(problem(), minimizer="newton_cg")
    found = shooting.solve(report=lambda iteration, cost, violation, gap: costs.append(cost))
    first = shooting.solve(report=lambda iteration, cost, violation, gap: iteration == 1)
    assert (first.iterations, first.status) == (1, "stopped by a signal") and first.cost >= found.cost
    with pytest.raises(ZeroDivisionError):
        shooting.solve(report=lambda *numbers: 1 / 0)
    other = Ddp(problem(), tolerance=1e-12).solve()
    assert found.is_converged and costs
    np.testing.assert_allclose(found.cost, other.cost, rtol=1e-8)
    # Flat to first order: inputs agree to the root of what costs do.
    np.testing.assert_allclose(found.u, other.u, rtol=0, atol=1e-4 * np.abs(other.u).max())
    x, u = shooting.trajectory(found.variables)
    np.testing.assert_array_equal(x, found.x)
    np.testing.assert_allclose(shooting.variables((None, u)), found.variables)
    with pytest.raises(ValueError, match="minimizer"):
        SingleShooting(problem(), minimizer="simplex").solve()  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="radios"):
        SingleShooting(problem(), radios=1.0)  # type: ignore[call-arg]


def user(**changes: object) -> Dynamics:
    """The cart-pole again, as functions."""

    def step(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.concatenate(POLE.step(x[:2], x[2:], u))

    def jacobians(x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        a, b = POLE.linearize(x[:2], x[2:], u)
        return a, b

    return Dynamics(**{"nx": 4, "nu": 1, "step": step, "jacobians": jacobians, "time_step": 0.02, **changes})  # type: ignore[arg-type]


def test_dynamics_that_are_functions_give_the_same_plan() -> None:
    one, other = Ddp(problem(user())).solve(), Ddp(problem()).solve()
    assert one.is_converged and one.iterations == other.iterations
    np.testing.assert_allclose(one.x, other.x, atol=1e-10)
    np.testing.assert_allclose(one.gains, other.gains, atol=1e-8)
    assert problem(user()).cost(one.x, one.u) == pytest.approx(one.cost, rel=1e-12)


def test_a_residual_that_is_a_function_is_one_of_the_librarys() -> None:
    same = Residual(4, lambda x, u: x, lambda x, u: (np.eye(4), np.zeros((4, 1))))
    given = problem()
    goal = Activation.weighted([1.0, 5.0, 0.1, 0.1])
    stage = [Term(1.0, same, goal), Term(0.01, InputError())]
    mine = Problem(POLE, given.horizon, given.start, stage, [Term(10.0, same)])
    one, other = Ddp(mine).solve(), Ddp(given).solve()
    np.testing.assert_allclose(one.cost, other.cost, rtol=1e-12)
    np.testing.assert_allclose(one.u, other.u, atol=1e-9)


def test_what_functions_raise_or_get_wrong_comes_through() -> None:
    def fails(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        raise RuntimeError("out of order")

    with pytest.raises(RuntimeError, match="out of order"):
        Ddp(problem(user(step=fails))).solve()
    with pytest.raises(ValueError, match="next state"):
        Ddp(problem(user(step=lambda x, u: x[:3]))).solve()
    with pytest.raises(ValueError, match="Jacobian in u"):
        Ddp(problem(user(jacobians=lambda x, u: (np.eye(4), np.eye(4))))).solve()
    with pytest.raises(ValueError, match="exact_curvature"):
        Ddp(problem(user()), exact_curvature=True).solve()
    with pytest.raises(ValueError, match="one of robots"):
        Ddp(Problem(user(), 3, [0.0] * 4, [Term(1.0, CenterOfMass([0.0, 0.0, 0.0]))])).solve()


def test_rates_in_continuous_time() -> None:
    simulator = db.Simulator(db.Model.from_urdf(asset("quadruped")), time_step=1e-3)
    model, nv = simulator.model, simulator.model.nv
    q, v = model.random_configuration(1), model.random_velocity(2)
    u = np.random.default_rng(3).normal(size=simulator.nu)
    a, b = simulator.linearize_rate(q, v, u)
    tau = np.zeros(nv)
    tau[simulator.actuated] = u
    slopes = db.forward_dynamics_derivatives(model, q, v, tau)
    scale = np.abs(a).max()
    np.testing.assert_allclose(a[nv:, :nv], slopes.dq, atol=1e-11 * scale)
    np.testing.assert_allclose(a[nv:, nv:], slopes.dv, atol=1e-11 * scale)
    np.testing.assert_allclose(b[nv:], slopes.dtau[:, simulator.actuated], atol=1e-11 * np.abs(b).max())
    np.testing.assert_array_equal(a[:nv], np.eye(2 * nv)[nv:])
    many = simulator.linearize_rate(np.stack([q, q]), np.stack([v, 2 * v]), u)
    np.testing.assert_allclose(many.a[0], a, atol=1e-12 * scale)
    with pytest.raises(ValueError, match="over a step"):
        simulator.replace(contacts=Contacts(law=Rigid())).linearize_rate(q, v, u)
