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

import dualbody.ray as dr  # noqa: E402


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
