"""Rollouts over a local Ray of two workers."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest

ray = pytest.importorskip("ray")

os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
sys.path.insert(0, str(EXAMPLES))

import ray_domain_randomisation as example  # noqa: E402

import dualbody as db  # noqa: E402
import dualbody.ray as dr  # noqa: E402
from dualbody import identify  # noqa: E402


@pytest.fixture(scope="module", autouse=True)
def cluster():  # type: ignore[no-untyped-def]
    paths = os.pathsep.join([str(EXAMPLES), *(p for p in sys.path if p)])
    ray.init(
        num_cpus=2, include_dashboard=False, log_to_driver=False, runtime_env={"env_vars": {"PYTHONPATH": paths}}
    )
    yield
    ray.shutdown()


def last(rollout) -> np.ndarray:  # type: ignore[no-untyped-def]
    return rollout.q[:, -1].copy()


def uncontrolled() -> dr.Work:
    given = example.work()
    return dr.Work(given.simulator, 60, example.start, None, example.randomised, last)


def test_results_depend_on_the_seed_only() -> None:
    def all_of(**options) -> np.ndarray:  # type: ignore[no-untyped-def]
        parts = list(dr.rollouts(uncontrolled(), 100, **options))
        assert [first for first, _ in parts] == list(range(0, 100, options["shard"]))
        return np.concatenate([part for _, part in parts])

    one = all_of(seed=1, shard=40)
    np.testing.assert_allclose(all_of(seed=1, shard=16, in_flight=1), one, atol=1e-10)
    assert not np.allclose(all_of(seed=2, shard=40), one)
    here = dr._run(uncontrolled(), 1, 40, 40, None, 1)
    np.testing.assert_array_equal(here, one[40:80])


def test_whole_rollouts_come_back_and_progress_is_told() -> None:
    work = dr.Work(example.work().simulator, 10, example.start)
    seen: list[int] = []
    ((_, rollout), (first, _)) = dr.rollouts(work, 30, shard=20, progress=seen.append)
    assert rollout.q.shape == (20, 11, 2) and first == 20 and seen == [20, 30]
    with pytest.raises(ValueError, match="parameters has 3 rows"):
        list(dr.rollouts(work, 4, parameters=np.zeros((3, 1))))


def end(rollout):  # type: ignore[no-untyped-def]
    """Square of where the cart ends, with its slopes."""
    slopes = np.zeros_like(rollout.q)
    slopes[..., -1, 0] = 2 * rollout.q[..., -1, 0]
    return rollout.q[..., -1, 0] ** 2, {"q": slopes}


@pytest.mark.parametrize("model", [None, example.randomised])
def test_gradients_are_those_of_one_process(model) -> None:  # type: ignore[no-untyped-def]
    simulator = example.work().simulator
    work = dr.Work(simulator, 0, example.start, model=model)
    inputs = np.random.default_rng(0).normal(size=(10, 25, 1))
    parts = list(dr.gradients(work, end, inputs, seed=3, shard=4))
    assert [first for first, _ in parts] == [0, 4, 8]
    for k in (0, 5, 9):
        own = dr.generator(3, k)
        q, v = example.start(own)
        robot = simulator if model is None else simulator.replace(model=model(simulator.model, own))
        expected = db.sim.rollout_gradient(robot, q, v, inputs[k], end)
        found = parts[k // 4][1]
        np.testing.assert_allclose(found.inputs[k % 4], expected.inputs, atol=1e-10)
        np.testing.assert_allclose(found.start[k % 4], expected.start, atol=1e-10)
        np.testing.assert_allclose(found.parameters[k % 4], expected.parameters, atol=1e-9)
    with pytest.raises(ValueError, match="expected \\(count, steps, nu\\)"):
        dr.gradients(work, end, inputs[0])


def identified(mass: float) -> identify.Estimate:
    """A pendulum's numbers from its own motion."""
    model = db.samples.pendulum()
    robot = model.with_link_mass(model.link_names[-1], mass)
    t = 0.05 * np.arange(200.0)[:, None]
    q, v, a = np.sin(t), np.cos(t), -np.sin(t)
    segment = identify.Segment("swing", 0.0, 20.0, q, v, a, db.inverse_dynamics(robot, q, v, a))
    return identify.estimate(identify.Regressor(model), identify.Dataset([segment]))


def test_identification_of_many_robots_comes_back_in_order() -> None:
    masses = [0.5, 1.0, 2.0, 4.0]
    found = list(dr.each(identified, masses, in_flight=2))
    for mass, own in zip(masses, found, strict=True):
        np.testing.assert_allclose(np.sort(np.abs(own.values)), [0.0, mass / 3, mass / 2], rtol=1e-9, atol=1e-9)


def dies_once(generator: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Kills its worker the first time that it is called."""
    marker = Path(os.environ["DUALBODY_MARKER"])
    try:
        marker.touch(exist_ok=False)
    except FileExistsError:
        return example.start(generator)
    os._exit(1)


def test_work_of_a_lost_worker_is_done_again(tmp_path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    marker = str(tmp_path / "died")

    def start(generator: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        os.environ["DUALBODY_MARKER"] = marker
        return dies_once(generator)

    work = dr.Work(example.work().simulator, 20, start, None, None, last)
    parts = [part for _, part in dr.rollouts(work, 24, seed=5, shard=8)]
    assert Path(marker).exists() and len(np.concatenate(parts)) == 24
    plain = dr.Work(work.simulator, 20, example.start, None, None, last)
    expected = [part for _, part in dr.rollouts(plain, 24, seed=5, shard=8)]
    np.testing.assert_array_equal(np.concatenate(parts), np.concatenate(expected))


def test_the_example_finds_a_regulator_for_all_masses() -> None:
    found = example.main(["--robots", "256"])
    assert found.history[-1] > found.history[0]
