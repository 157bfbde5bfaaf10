"""Direct transcription: curves that obey the dynamics, warm starts, and what cannot be transcribed."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import dualbody as db
from dualbody.trajopt import Constraint, Curve, Dynamics, InputError, Problem, StateError, Term, Transcription

INTERVAL, HORIZON = 0.1, 12


def swing(time_step: float = INTERVAL, horizon: int = HORIZON) -> Problem:
    """A pendulum goes from rest to one radian with the least effort."""
    pendulum = db.Simulator(db.samples.pendulum(), time_step=time_step)
    arrive = Constraint(StateError([1.0, 0.0]))
    return Problem(pendulum, horizon, [0.0, 0.0], [Term(1.0, InputError())], final_constraints=[arrive])


def error_of(curve: Curve) -> float:
    """How far a curve is from the motion under its inputs: another integrator, small steps, inputs that are held over each."""
    steps = 1200
    times = np.arange(steps + 1) * (INTERVAL * HORIZON / steps)
    middles = curve.at(times[:-1] + 0.5 * times[1])[1]
    fine = db.Simulator(db.samples.pendulum(), time_step=float(times[1]), integrator="runge_kutta_4")
    rollout = fine.rollout([0.0], [0.0], inputs=middles)
    return float(np.abs(curve.at(times)[0] - np.concatenate([rollout.q, rollout.v], axis=1)).max())


def test_curve_is_the_motion_under_its_inputs_to_fourth_order() -> None:
    told: list[float] = []
    found = Transcription(swing()).solve(report=lambda iteration, cost, violation, gap: told.append(gap))
    assert found.is_converged and found.violation < 1e-6 and told[-1] < 1e-7
    np.testing.assert_allclose(found.x[[0, -1]], [[0.0, 0.0], [1.0, 0.0]], atol=1e-6)
    finer = Transcription(swing(INTERVAL / 2, 2 * HORIZON)).solve()
    assert error_of(found.curve) < 1e-3
    assert error_of(finer.curve) < error_of(found.curve) / 12
    # The integral of the costs, by another rule.
    middles = found.curve.at(np.arange(600) * 0.002 + 0.001)[1]
    np.testing.assert_allclose(found.cost, 0.5 * np.sum(middles**2) * 0.002, rtol=1e-4)
    x, u = found.curve.at(np.zeros((2, 3)))
    assert x.shape == (2, 3, 2) and u.shape == (2, 3, 1)
    x, u = found.curve.at([])
    assert x.shape == (0, 2) and u.shape == (0, 1)
    np.testing.assert_array_equal(found.curve.at(INTERVAL)[0], found.x[1])
    np.testing.assert_allclose(found.curve.at([[-1.0, 99.0]])[0], [[found.x[0], found.x[-1]]], atol=1e-12)


def test_a_curve_starts_further_runs_and_crosses_processes() -> None:
    first = Transcription(swing()).solve()
    kept: Curve = pickle.loads(pickle.dumps(first.curve))
    times = np.linspace(0.0, 1.2, 7)
    np.testing.assert_array_equal(kept.at(times)[0], first.curve.at(times)[0])
    again = Transcription(swing()).solve(kept)
    assert again.is_converged and again.iterations < first.iterations
    np.testing.assert_allclose(again.cost, first.cost, rtol=1e-7)
    x, u = first.curve.held()
    assert x.shape == (HORIZON + 1, 2) and u.shape == (HORIZON, 1)
    from_guess = Transcription(swing()).solve((x, u))
    np.testing.assert_allclose(from_guess.cost, first.cost, rtol=1e-6)


def test_errors_name_what_does_not_fit() -> None:
    def step(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return x + u

    decay = Dynamics(1, 1, step, lambda x, u: (np.eye(1), np.eye(1)))
    with pytest.raises(ValueError, match="rate"):
        Transcription(Problem(decay, 2, [0.0])).solve()
    with pytest.raises(TypeError, match="radius"):
        Transcription(swing(), radius=1.0)  # type: ignore[call-arg]
    curve = Transcription(swing()).solve().curve
    with pytest.raises(ValueError, match="states has 13 rows, expected 6"):
        Transcription(swing(horizon=5)).solve(curve)
    with pytest.raises(ValueError, match="times"):
        curve.at([0.1, np.nan])
