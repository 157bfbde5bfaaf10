"""Results of the compiled module as objects, and progress of what takes long."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._rollout import Rollout, Status

if TYPE_CHECKING:
    from collections.abc import Callable

    from ._dualbody import Array, Simulator

#: Of all trajectories that came to their end: there may be very many.
_COMPLETED = Status("completed")

#: Trajectories that did not come to their end, by index, with kind and step.
Stopped = list[tuple[int, tuple[str, int | None]]]


def _statuses(count: int, stopped: Stopped, is_batch: bool) -> Status | list[Status]:
    """The status of a trajectory, or a list of those of a batch."""
    every = [_COMPLETED] * count
    for k, status in stopped:
        every[k] = Status(*status)
    return every if is_batch else every[0]


def _rollout(
    simulator: Simulator,
    batch: list[int],
    arrays: tuple[Array, Array | None, Array | None],
    ends: tuple[int, Stopped, list[tuple[int, tuple[int, str]]]],
    bar: Any,
) -> Rollout:
    """The rollout of a simulator's numbers."""
    rows, controlled, given = arrays
    count, stopped, failed = ends
    nq, nv = simulator.model.nq, simulator.model.nv
    steps = rows.shape[1] - 1
    rows = rows[:count].reshape((*batch, steps + 1, rows.shape[2]))
    if controlled is not None:
        u = controlled.reshape((*batch, steps, simulator.nu))
    elif given is not None:
        # A copy: what the caller does to its array later is not what was simulated.
        u = np.broadcast_to(given.copy(), (*batch, *given.shape[-2:]))
    else:
        u = np.broadcast_to(np.zeros(simulator.nu), (*batch, steps, simulator.nu))
    if bar is not None:
        bar.close()
    failures: list[tuple[int, str] | None] = [None] * count
    for k, failure in failed:
        failures[k] = failure
    return Rollout(
        rows[..., :nq],
        rows[..., nq : nq + nv],
        u,
        rows[..., nq + nv :],
        _statuses(count, stopped, bool(batch)),
        failures if batch else failures[0],
        simulator.time_step,
        simulator.input_names,
    )


class _Progress:
    """Calls a function, or moves a bar, by the steps that were taken."""

    def __init__(self, show: Callable[[int], object], close: Callable[[], object], scale: float, total: int) -> None:
        self._show, self._close, self._scale, self._total = show, close, scale, total

    def __call__(self, done: int) -> None:
        self._show(min(int(done * self._scale), self._total))

    def close(self) -> None:
        self._show(self._total)
        self._close()


def _progress(progress: Any, sizes: tuple[int, int], controlled: bool, width: int) -> _Progress | None:
    """What shows how far a rollout has come. A batch counts the steps of groups of `width` states."""
    if progress is None or progress is False:
        return None
    steps, count = sizes
    groups = 1 if controlled else -(-count // width)
    if not callable(progress) and progress is not True:
        raise TypeError(f"progress is {progress!r}, expected True or a function of the number of steps")
    if callable(progress):
        return _Progress(progress, lambda: None, 1.0 / groups, steps)
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped, unused-ignore]
    except ImportError:
        return None
    bar = tqdm(total=steps, unit="step")

    def show(done: int) -> None:
        bar.update(done - bar.n)

    return _Progress(show, bar.close, 1.0 / groups, steps)
