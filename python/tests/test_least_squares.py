"""Least squares of functions: certified data, closed forms, what goes wrong."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import OTHER_ALGORITHM

from dualbody.least_squares import Loss, solve

# The problem Misra1a of NIST's Statistical Reference Datasets, y = b1 (1 - exp(-b2 x)).
X = np.array([77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0])
Y = np.array([10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78])
CERTIFIED, DEVIATIONS = [2.3894212918e2, 5.5015643181e-4], [2.7070075241, 7.2668688436e-6]


def misra(b: np.ndarray) -> np.ndarray:
    return b[0] * -np.expm1(-b[1] * X) - Y


def misra_slopes(b: np.ndarray) -> np.ndarray:
    return np.stack([-np.expm1(-b[1] * X), b[0] * X * np.exp(-b[1] * X)], axis=1)


def valley(x: np.ndarray) -> list[float]:
    return [10 * (x[1] - x[0] ** 2), 1 - x[0]]


def valley_slopes(x: np.ndarray) -> list[list[float]]:
    return [[-20 * x[0], 10], [-1, 0]]


def test_solution_and_deviations_are_the_certified_ones() -> None:
    seen: list[tuple[int, float, float, float]] = []
    found = solve(misra, misra_slopes, [500.0, 1e-4], report=lambda *numbers: seen.append(numbers))
    assert found.is_converged and found.status == "converged" and len(found.history) == len(seen) + 1 == found.iterations + 1
    np.testing.assert_allclose(found.x, CERTIFIED, rtol=1e-9)
    assert found.covariance is not None and found.variance is not None
    np.testing.assert_allclose(np.sqrt(np.diag(found.covariance)), DEVIATIONS, rtol=1e-7)
    np.testing.assert_allclose(2 * found.cost, 1.2455138894e-1, rtol=1e-9)
    np.testing.assert_allclose(found.variance, 2 * found.cost / 12)
    np.testing.assert_allclose(found.residuals, misra(found.x))
    j = misra_slopes(found.x)
    np.testing.assert_allclose(found.normal_matrix, j.T @ j, rtol=1e-9)
    assert [cost for _, cost, _, _ in seen] == found.history[1:].tolist() and "converged" in repr(found)
    early = solve(misra, misra_slopes, [500.0, 1e-4], offset_tolerance=1e-3)
    assert early.is_converged and early.iterations < found.iterations
    short = solve(misra, misra_slopes, [500.0, 1e-4], max_iterations=2)
    assert not short.is_converged and short.iterations == 2 and short.status == "all iterations used"


def test_bounds_hold_back() -> None:
    found = solve(valley, valley_slopes, [-1.2, 1.0], bounds=([-2.0, -2.0], [0.5, 2.0]))
    assert found.is_converged and found.held == [0] and found.x[0] == 0.5
    np.testing.assert_allclose(found.x[1], 0.25, atol=OTHER_ALGORITHM)
    above = solve(valley, valley_slopes, [3.0, 3.0], bounds=([2.0, -np.inf], None))
    np.testing.assert_allclose(above.x, [2.0, 4.0], atol=OTHER_ALGORITHM)


def test_losses_find_the_line_that_outliers_hide() -> None:
    t = np.arange(20.0)
    y = 2 - 0.3 * t + 0.01 * np.sin(7 * t) + 8.0 * (t % 8 == 5)

    def fit(loss: Loss) -> float:
        found = solve(lambda x: x[0] + x[1] * t - y, lambda x: np.stack([np.ones(20), t], axis=1), [0.0, 0.0], loss=loss)
        assert found.is_converged
        return float(np.hypot(found.x[0] - 2, found.x[1] + 0.3))

    assert fit(Loss.square()) > 0.3
    assert max(fit(loss(0.02)) for loss in (Loss.huber, Loss.soft_l1, Loss.cauchy)) < 0.02
    s = np.array([1e-6, 0.2, 0.3, 7.0])
    np.testing.assert_allclose(Loss.cauchy(0.5).value(s), 0.25 * np.log1p(4 * s))
    for loss in (Loss(), Loss.huber(0.5), Loss.soft_l1(0.5), Loss.cauchy(0.5)):
        h = 1e-6 * s
        np.testing.assert_allclose((loss.value(s + h) - loss.value(s - h)) / (2 * h), loss.weight(s), rtol=1e-6)


def test_variables_may_be_points_of_a_circle() -> None:
    goal = np.array([0.6, -0.8])

    def retract(x: np.ndarray, d: np.ndarray) -> list[float]:
        c, s = np.cos(d[0]), np.sin(d[0])
        return [c * x[0] - s * x[1], s * x[0] + c * x[1]]

    found = solve(lambda x: x - goal, lambda x: [[-x[1]], [x[0]]], [1.0, 0.0], manifold=(1, retract))
    assert found.is_converged
    np.testing.assert_allclose(found.x, goal, atol=1e-9)


def test_what_functions_raise_or_get_wrong_comes_through() -> None:
    calls = 0

    def fails(x: np.ndarray) -> list[float]:
        nonlocal calls
        calls += 1
        if calls > 3:
            raise RuntimeError("out of order")
        return valley(x)

    with pytest.raises(RuntimeError, match="out of order"):
        solve(fails, valley_slopes, [-1.2, 1.0])
    assert calls == 4
    with pytest.raises(ValueError, match=r"jacobian\(x\) has the shape"):
        solve(valley, lambda x: np.eye(3), [-1.2, 1.0])
    with pytest.raises(TypeError, match="maximum"):
        solve(valley, valley_slopes, [-1.2, 1.0], maximum=3)  # type: ignore[call-arg]
    with pytest.raises(ValueError, match="leave no value"):
        solve(valley, valley_slopes, [-1.2, 1.0], bounds=([1.0, 0.0], [0.0, 0.0]))
    with pytest.raises(ValueError, match=r"upper bounds\[1\] is NaN"):
        solve(valley, valley_slopes, [-1.2, 1.0], bounds=(None, [1.0, np.nan]))
    with pytest.raises(ValueError, match="not positive"):
        solve(valley, valley_slopes, [-1.2, 1.0], loss=Loss.huber(0.0))
    with pytest.raises(ZeroDivisionError):
        solve(valley, valley_slopes, [-1.2, 1.0], report=lambda *numbers: 1 / 0)
    stopped = solve(valley, valley_slopes, [-1.2, 1.0], report=lambda iteration, *numbers: iteration == 2)
    assert (stopped.iterations, stopped.status) == (2, "stopped by a signal")
    assert solve(lambda x: [np.nan], lambda x: [[1.0]], [3.0]).status == "residuals or Jacobian are not finite"
    assert solve(lambda x: x - 1, lambda x: [[-1.0]], [5.0]).status == "no step lowers the cost"
