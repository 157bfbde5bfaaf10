"""Episodes of tasks on the states of a batch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from .._dualbody import _Balance
from ..sim import BatchSimulator
from .draws import Draws, keys, whole
from .task import Array, Balance, Flags, Task

Observations = NDArray[np.float32]
Seeds = Sequence[int | None]
#: Observations, rewards, ends, cuts; the last observations of episodes that ended if others began in their places
Step = tuple[Observations, Array, Flags, Flags, Observations | None]
OVER = "an episode is over: reset it (in a batch with options={'reset_mask': flags})"


class Episodes(Protocol):
    """Episodes of a task, a row for each."""

    def seed(self, seeds: Seeds) -> None:
        """Seeds the environments whose seed is not None, from their next episodes on; at first all."""

    def reset(self, mask: Flags | None = None) -> Observations:
        """Begins episodes, those of a mask or all."""
        ...

    def step(self, actions: Any) -> Step:
        """Takes a step with each action. A state that diverges stays where it was, and its episode is over."""
        ...

    def first(self) -> tuple[Array, Array, int]:
        """The first state, and the number of steps of its episode so far."""
        ...


def episodes(task: Task | Balance, n: int, mode: AutoresetMode) -> Episodes:
    """Episodes of a task, to be seeded and reset."""
    return BalanceEpisodes(task, n, mode) if isinstance(task, Balance) else TaskEpisodes(task, n, mode)


class BalanceEpisodes:
    """Episodes of a task that is data: all of a step is native."""

    def __init__(self, task: Balance, n: int, mode: AutoresetMode) -> None:
        self._native = _Balance(task.simulator, n, task.start, task.within, task.max_steps, task.steps_per_action, mode.value)
        self._is_seeded = False
        self.reset, self.step, self.first = self._native.reset, self._native.step, self._native.first

    def seed(self, seeds: Seeds) -> None:
        own = whole(seeds)
        self._native.seed([word if s is not None or not self._is_seeded else None for s, word in zip(seeds, own, strict=True)])
        self._is_seeded = True


class TaskEpisodes:
    """Episodes of a task of NumPy functions. They start by `Task.starts` on random numbers of all at once, or by `Task.start` on a generator each."""

    def __init__(self, task: Task, n: int, mode: AutoresetMode, generators: Sequence[np.random.Generator] | None = None) -> None:
        self.task, self.n, self.mode = task, n, mode
        self._batch = BatchSimulator(task.simulator, n)
        self.q, self.v = self._batch.q, self._batch.v
        self._steps, self._ended = np.zeros(n, np.int64), np.zeros(n, np.bool_)
        self._keys, self._generators = np.zeros(n, np.uint64), list(generators or [])

    def seed(self, seeds: Seeds) -> None:
        if self.task.starts is not None:
            given = np.array([s is not None for s in seeds]) | (self._keys == 0)
            self._keys = np.where(given, keys(seeds), self._keys)
        else:
            known = self._generators
            self._generators = [known[i] if s is None and known else seeding.np_random(s)[0] for i, s in enumerate(seeds)]

    def reset(self, mask: Flags | None = None) -> Observations:
        if mask is not None and mask.shape != (self.n,):
            raise ValueError(f"reset_mask has the shape {mask.shape}, expected ({self.n},)")
        self._begin(np.ones(self.n, np.bool_) if mask is None else mask)
        return self._observe()

    def _begin(self, which: Flags) -> None:
        begins = np.flatnonzero(which)
        if not len(begins):
            return
        if self.task.starts is not None:
            own = self._keys[begins]
            self.q[begins], self.v[begins] = self.task.starts(Draws(own))
            self._keys[begins] = own
        else:
            for i in begins:
                self.q[i], self.v[i] = self.task.start(self._generators[i])
        self._batch.set(self.q, self.v, mask=which)
        self._steps[begins], self._ended[begins] = 0, False

    def step(self, actions: Any) -> Step:
        task, again = self.task, self._ended
        u = self._inputs(actions)
        if self.mode is AutoresetMode.DISABLED and again.any():
            raise RuntimeError(OVER)
        self._batch.step(u, steps=task.steps_per_action)
        self.q, self.v = self._batch.q, self._batch.v
        self._steps += 1
        over = (task.is_over(self.q, self.v) | ~self._batch.running) & ~again
        cut = (self._steps >= task.max_steps) & ~over & ~again
        reward = np.where(again, 0.0, task.reward(self.q, self.v, u))
        final = None
        if self.mode is AutoresetMode.SAME_STEP:
            again = over | cut
            final = self._observe() if again.any() else None
        self._ended = over | cut
        self._begin(again)
        return self._observe(), reward, over, cut, final

    def _inputs(self, actions: Any) -> Array:
        u = np.asarray(actions, np.float64)
        expected = (self.n, self.task.simulator.nu)
        if u.shape != expected:
            raise ValueError(f"actions has the shape {u.shape}, expected {expected}")
        if not np.isfinite(u).all():
            i = int(np.flatnonzero(~np.isfinite(u).all(axis=1))[0])
            raise ValueError(f"the action of environment {i} is not finite: {u[i]}")
        return u

    def _observe(self) -> Observations:
        return self.task.observe(self.q, self.v).astype(np.float32, copy=False)

    def first(self) -> tuple[Array, Array, int]:
        return self.q[0].copy(), self.v[0].copy(), int(self._steps[0])
