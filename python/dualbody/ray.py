"""Distributed work over a Ray cluster: rollouts, gradients, the evolution of policies, and any other function.

States go out in shards, and results return shard by shard, in the order of the states. Each state has its own random numbers, by its index, so results do
not depend on the number of workers; with different robots, the size of shards changes the last digits. Lost workers are replaced (Ray's retries). At most
`in_flight` shards are in progress, which bounds the memory.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
import ray
from numpy.typing import NDArray

from ._dualbody import Model, Simulator, set_threads
from .sim import Rollout, RolloutGradient, rollout_gradient
from ._value import Value

__all__ = ["Evolution", "Work", "each", "evolve", "generator", "gradients", "rollouts"]

Array = NDArray[np.float64]


def generator(seed: int, index: int) -> np.random.Generator:
    """The random numbers of a state, independent of the worker."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index,)))


@dataclass(frozen=True)
class Work:
    """The work for each state. The functions are called on workers; each state has its own generator."""

    simulator: Simulator
    steps: int
    #: State (nq,), (nv,) from which a trajectory starts
    start: Callable[[np.random.Generator], tuple[Array, Array]]
    #: Input (n, nu) of step k in the states q (n, nq), v (n, nv); with parameters (n, p) if there are any: control(k, q, v, parameters)
    control: Callable[..., Array] | None = None
    #: A robot of its own for a state, of the same structure
    model: Callable[[Model, np.random.Generator], Model] | None = None
    #: The part of a shard's rollout that is returned; all of it if left out
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


def _start() -> None:
    if not ray.is_initialized():
        ray.init()


def _streamed(function: Callable[..., Any], jobs: Iterator[tuple[Any, ...]], in_flight: int | None, threads: int, retries: int) -> Iterator[Any]:
    """What a function gives for each job's arguments, in their order; so many jobs are away at most."""
    _start()
    if in_flight is None:
        resources: Any = ray.cluster_resources  # which has no types
        in_flight = max(2, 2 * int(resources().get("CPU", 1)) // threads)
    task = ray.remote(num_cpus=threads, max_retries=retries)(function)
    waiting = deque(task.remote(*job) for job in islice(jobs, in_flight))
    while waiting:
        result = ray.get(waiting.popleft())
        waiting.extend(task.remote(*job) for job in islice(jobs, 1))
        yield result


def _shards(
    function: Callable[..., Any], count: int, shard: int, arguments: Callable[[int, int], tuple[Any, ...]], in_flight: int | None, threads: int,
    retries: int, progress: Callable[[int], object] | None
) -> Iterator[tuple[int, Any]]:
    """(index of the first state, result) of one shard after the other; arguments(first, number) are those of a shard."""
    if count < 0 or shard < 1:
        raise ValueError(f"count is {count} and shard is {shard}")
    firsts = range(0, count, shard)
    jobs = (arguments(first, min(shard, count - first)) for first in firsts)
    for first, result in zip(firsts, _streamed(function, jobs, in_flight, threads, retries), strict=True):
        if progress is not None:
            progress(min(first + shard, count))
        yield first, result


def rollouts(
    work: Work, count: int, *, seed: int = 0, parameters: Array | None = None, shard: int = 256, in_flight: int | None = None, threads: int = 1,
    retries: int = 3, progress: Callable[[int], object] | None = None
) -> Iterator[tuple[int, Any]]:
    """Rollouts of `count` states: (index of the first state, kept part) of one shard after the other.

    parameters (count, p): of the control, one row per state. shard: states of a task; in_flight: maximum number of tasks in progress, twice the cores of
    the cluster by default; threads: cores of a task; retries: of a task whose worker is lost; progress(states done).
    """
    if parameters is not None and len(parameters) != count:
        raise ValueError(f"parameters has {len(parameters)} rows, expected {count}")
    _start()
    shared = ray.put(work)

    def arguments(first: int, number: int) -> tuple[Any, ...]:
        rows = None if parameters is None else parameters[first : first + number]
        return shared, seed, first, number, rows, threads

    return _shards(_run, count, shard, arguments, in_flight, threads, retries, progress)


#: Value (...) of a cost of a rollout, and its slopes, as `sim.rollout_gradient` takes it.
Cost = Callable[[Rollout], tuple[Any, Mapping[str, Any]]]


def _differentiate(work: Work, cost: Cost, seed: int, first: int, inputs: Array, threads: int) -> RolloutGradient:
    """Gradients of the states of one shard."""
    set_threads(threads)
    generators = [generator(seed, first + i) for i in range(len(inputs))]
    q, v = (np.array(own) for own in zip(*(work.start(own) for own in generators), strict=True))
    simulator = work.simulator
    contact = simulator.neutral_contact() if simulator.n_contact else None
    if work.model is None:
        return rollout_gradient(simulator, q, v, inputs, cost, contact=contact)
    robots = [simulator.replace(model=work.model(simulator.model, own)) for own in generators]
    found = [rollout_gradient(*own, cost, contact=contact) for own in zip(robots, q, v, inputs, strict=True)]
    names = ("start", "inputs", "parameters", "friction", "cost", "simulator_parameters")
    numbers = {name: np.stack([getattr(own, name) for own in found]) for name in names}
    ends: Any = [own.status for own in found]
    return RolloutGradient(status=ends, **numbers)


def gradients(
    work: Work, cost: Cost, inputs: Array, *, seed: int = 0, shard: int = 256, in_flight: int | None = None, threads: int = 1, retries: int = 3,
    progress: Callable[[int], object] | None = None
) -> Iterator[tuple[int, RolloutGradient]]:
    """Gradients of a cost of the rollout of each state under its inputs (count, steps, nu), a RolloutGradient of one shard after the other.

    cost(rollout) returns the value and the gradient, as for `sim.rollout_gradient`; steps, control and keep of the work are not used. The other
    arguments are those of `rollouts`.
    """
    inputs = np.asarray(inputs, np.float64)
    if inputs.ndim != 3:
        raise ValueError(f"inputs has the shape {inputs.shape}, expected (count, steps, nu)")
    _start()
    shared, own = ray.put(work), ray.put(cost)

    def arguments(first: int, number: int) -> tuple[Any, ...]:
        return shared, own, seed, first, inputs[first : first + number], threads

    return _shards(_differentiate, len(inputs), shard, arguments, in_flight, threads, retries, progress)


def _apply(function: Callable[[Any], Any], item: Any, threads: int) -> Any:
    set_threads(threads)
    return function(item)


def each(
    function: Callable[[Any], Any], items: Iterable[Any], *, in_flight: int | None = None, threads: int = 1, retries: int = 3
) -> Iterator[Any]:
    """function(item) for each item, on workers, in the order of the items: identification of many robots or from many starts, sweeps, plans.

    Items are read lazily, so memory is bounded for any number of items. The other arguments are those of `rollouts`.
    """
    _start()
    shared = ray.put(function)
    return _streamed(_apply, ((shared, item, threads) for item in items), in_flight, threads, retries)


@dataclass(frozen=True, eq=False)
class Evolution(Value):
    """Result of `evolve`: mean (p,) and spread (p,) of the parameters, best score of each generation."""

    mean: Array
    spread: Array
    history: list[float]


def evolve(
    work: Work, points: Callable[[Rollout], Array], mean: Sequence[float], spread: Sequence[float], *, generations: int, candidates: int = 128,
    elite: int = 16, least_spread: float = 1e-3, seed: int = 0, shard: int = 64, threads: int = 1, enough: float = float("inf")
) -> Evolution:
    """Cross-entropy search for the parameters of `work.control(k, q, v, parameters)`, one state for each candidate.

    points(rollout) (n,) returns the scores of the candidates of a shard; the next generation is drawn around the mean of the elite. It ends when the mean
    score of the elite reaches `enough`. The result depends on the seed only, not on shards or workers.
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
