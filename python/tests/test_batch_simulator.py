"""States that stay in lanes between steps."""

from __future__ import annotations

import numpy as np
import pytest

import dualbody as db
from dualbody.sim import BatchSimulator

N = 11


def test_steps_are_those_of_single_states() -> None:
    simulator = db.Simulator(db.samples.cartpole(), time_step=0.01)
    rng = np.random.default_rng(0)
    q, v, u = rng.normal(size=(N, 2)), rng.normal(size=(N, 2)), rng.normal(size=(N, 2))
    batch = BatchSimulator(simulator, N)
    assert len(batch) == N and batch.simulator is simulator and "BatchSimulator" in repr(batch)
    np.testing.assert_array_equal(batch.q, np.zeros((N, 2)))
    batch.set(q, v)
    batch.step(u, steps=3)
    batch.step(u)
    for _ in range(4):
        q, v = simulator.step(q, v, u)
    np.testing.assert_array_equal(batch.q, q)
    np.testing.assert_array_equal(batch.v, v)
    assert batch.contact.shape == (N, 0) and batch.running.all()


def test_parameters_differ_from_state_to_state() -> None:
    # A bar falls: v̇ = 3 g / 2 l sin q, whatever its mass, and slower with a heavier rotor.
    simulator = db.Simulator(db.samples.pendulum(), time_step=1e-3)
    name = next(name for name in simulator.parameter_names if "armature" in name)
    armature = np.linspace(0.0, 1.0, N)
    batch = BatchSimulator(simulator, N, parameters={name: armature})
    batch.set([np.pi / 2], [0.0])
    batch.step()
    np.testing.assert_allclose(batch.v[:, 0], -1e-3 * 9.81 * 0.5 / (1 / 3 + armature), rtol=1e-12)


def test_a_mask_sets_its_states_only() -> None:
    simulator = db.Simulator(db.samples.pendulum(), divergence_bound=5.0)
    batch = BatchSimulator(simulator, 3)
    batch.step([[0.0], [1e6], [0.0]])
    np.testing.assert_array_equal(batch.running, [True, False, True])
    before = batch.q
    batch.set(np.full((3, 1), 0.5), np.zeros((3, 1)), mask=np.array([False, True, False]))
    np.testing.assert_array_equal(batch.q[[0, 2]], before[[0, 2]])
    assert batch.q[1, 0] == 0.5 and batch.running.all()


def test_what_does_not_fit_is_refused() -> None:
    simulator = db.Simulator(db.samples.pendulum())
    batch = BatchSimulator(simulator, 3)
    for arguments, text in (
        ((np.zeros((2, 1)), np.zeros((2, 1))), r"batch of shape \[2\], expected \(3,\)"),
        (([np.nan], [0.0]), "state 0 of the batch"),
    ):
        with pytest.raises(ValueError, match=text):
            batch.set(*arguments)
    with pytest.raises(ValueError, match="mask has 2 entries, expected 3"):
        batch.set([0.0], [0.0], mask=[True, False])
    with pytest.raises(ValueError, match="u is a batch of shape"):
        batch.step(np.zeros((2, 1)))
    with pytest.raises(ValueError, match="steps"):
        batch.step(steps=-1)
    with pytest.raises(KeyError, match="no such"):
        BatchSimulator(simulator, 3, parameters={"no such": np.ones(3)})
    with pytest.raises(ValueError, match="parameters"):
        BatchSimulator(simulator, 3, parameters={simulator.parameter_names[0]: np.ones(2)})
    with pytest.raises(MemoryError):
        BatchSimulator(simulator, 10**15)
    assert len(BatchSimulator(simulator, 0)) == 0
