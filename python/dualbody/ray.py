"""Many machines: rollouts and the evolution of policies over a Ray cluster.

States go out in shards, and results come back one shard after the other, in the order of the states. Each state has random numbers of its own,
by its index: results do not depend on shards or workers. Workers that are lost are replaced (Ray's retries); at most `in_flight` shards are
away at a time, so that memory is bounded however many states there are.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import ray
from numpy.typing import NDArray

from ._dualbody import Model, Simulator, set_threads
from .sim import Rollout

__all__ = ["Evolution", "Work", "evolve", "generator", "rollouts"]

Array = NDArray[np.float64]


def generator(seed: int, index: int) -> np.random.Generator:
    """The random numbers of a state: the same wherever it is computed."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index,)))


@dataclass(frozen=True)
class Work:
    """What is done with each state. The functions are called on workers; each state brings its own generator."""

    simulator: Simulator
    steps: int
    #: State (nq,), (nv,) from which a trajectory starts
    start: Callable[[np.random.Generator], tuple[Array, Array]]
    #: Input (n, nu) of step k in the states q (n, nq), v (n, nv); with parameters (n, p) if there are any: control(k, q, v, parameters)
    control: Callable[..., Array] | None = None
    #: A robot of its own for a state, of the same structure
    model: Callable[[Model, np.random.Generator], Model] | None = None
    #: What is sent back of the rollout of a shard; all of it if nothing is said
    keep: Callable[[Rollout], Any] | None = None


def _run(work: Work, seed: int, first: int, count: int, parameters: Array | None, threads: int) -> Any:
    """The states of one shard."""
    set_threads(threads)
    generators = [generator(seed, first + i) for i in range(count)]
    starts = [work.start(own) for own in generators]
    q, v = (np.array([start[k] for start in starts]) for k in (0, 1))
    simulator, models = work.simulator, None
    if work.model is not None:
        models = [work.model(simulator.model, own) for own in generators]
    contact = simulator.neutral_contact() if simulator.n_contact else None
    given, control = work.control, work.control
    if given is not None and parameters is not None:

        def with_parameters(k: int, q: Array, v: Array) -> Array:
            return given(k, q, v, parameters)

        control = with_parameters
    rollout = simulator.rollout(q, v, steps=work.steps, control=control, contact=contact, models=models)
    return rollout if work.keep is None else work.keep(rollout)


def rollouts(
    work: Work,
    count: int,
    *,
    seed: int = 0,
    parameters: Array | None = None,
    shard: int = 256,
    in_flight: int | None = None,
    threads: int = 1,
    retries: int = 3,
    progress: Callable[[int], object] | None = None,
) -> Iterator[tuple[int, Any]]:
    """Rollouts of `count` states: (index of the first state, what is kept) of one shard after the other.

    parameters (count, p): of the control, a row for each state. shard: states of a task; in_flight: tasks that are away at most, twice the
    cluster's cores by default; threads: cores of a task; retries: of a task whose worker is lost; progress(states done).
    """
    if count < 0 or shard < 1:
        raise ValueError(f"count is {count} and shard is {shard}")
    if parameters is not None and len(parameters) != count:
        raise ValueError(f"parameters has {len(parameters)} rows, expected {count}")
    if not ray.is_initialized():
        ray.init()
    if in_flight is None:
        resources: Any = ray.cluster_resources  # which has no types
        in_flight = max(2, 2 * int(resources().get("CPU", 1)) // threads)
    task = ray.remote(num_cpus=threads, max_retries=retries)(_run)
    shared = ray.put(work)
    waiting: list[tuple[int, Any]] = []
    firsts = iter(range(0, count, shard))
    done = 0

    def send() -> None:
        first = next(firsts, None)
        if first is not None:
            own = min(shard, count - first)
            rows = None if parameters is None else parameters[first : first + own]
            waiting.append((first, task.remote(shared, seed, first, own, rows, threads)))

    for _ in range(in_flight):
        send()
    while waiting:
        first, reference = waiting.pop(0)
        result = ray.get(reference)
        del reference
        send()
        done += min(shard, count - first)
        if progress is not None:
            progress(done)
        yield first, result


@dataclass(frozen=True)
class Evolution:
    """How a policy evolved: mean (p,) and spread (p,) of its parameters, best points of each generation."""

    mean: Array
    spread: Array
    history: list[float]


def evolve(
    work: Work,
    points: Callable[[Rollout], Array],
    mean: Sequence[float],
    spread: Sequence[float],
    *,
    generations: int,
    candidates: int = 128,
    elite: int = 16,
    least_spread: float = 1e-3,
    seed: int = 0,
    shard: int = 64,
    threads: int = 1,
    enough: float = float("inf"),
) -> Evolution:
    """Cross-entropy search for the parameters of `work.control(k, q, v, parameters)`, one state for each candidate.

    points(rollout) (n,) tells how well the candidates of a shard did; the next generation is drawn around the mean of the elite. It ends when
    the mean of the elite's points is enough. The result depends on the seed only, not on shards or workers.
    """
    scored = Work(work.simulator, work.steps, work.start, work.control, work.model, points)
    center, width, history = np.asarray(mean, float), np.asarray(spread, float), []
    for k in range(generations):
        draws = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(k, 0)))
        parameters = center + width * draws.standard_normal((candidates, len(center)))
        # All candidates of a generation start from random states of that generation.
        parts = rollouts(scored, candidates, seed=seed + k, parameters=parameters, shard=shard, threads=threads)
        scores = np.concatenate([part for _, part in parts])
        order = np.argsort(-scores, kind="stable")[:elite]
        best = parameters[order]
        center, width = best.mean(axis=0), best.std(axis=0) + least_spread
        history.append(float(scores[order].mean()))
        if history[-1] >= enough:
            break
    return Evolution(center, width, history)


def efficiency(work: Work, count: int, workers: int, shard: int = 256) -> tuple[float, float, float]:
    """Seconds of `count` states in this process on one thread, over Ray on so many workers of one thread, and the efficiency between them."""
    import time

    for _ in rollouts(work, workers * shard, shard=shard):
        pass  # workers are there, and have imported what they need
    begin = time.perf_counter()
    for first in range(0, count, shard):
        _run(work, 0, first, min(shard, count - first), None, 1)
    alone = time.perf_counter() - begin
    set_threads(0)
    begin = time.perf_counter()
    for _ in rollouts(work, count, shard=shard):
        pass
    together = time.perf_counter() - begin
    return alone, together, alone / together / min(workers, os.cpu_count() or 1)
