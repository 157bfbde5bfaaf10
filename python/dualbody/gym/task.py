"""Tasks of reinforcement learning, and the states of a batch during episodes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from numpy.typing import NDArray

from ..sim import Simulator
from ..view import Pictures, Recording
from .draws import Draws, keys

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Task:
    """A task of reinforcement learning. q (n, nq), v (n, nv), u (n, nu) are the states and inputs of a batch."""

    simulator: Simulator
    #: State (nq,), (nv,) from which an episode starts, by a generator of its own
    start: Callable[[np.random.Generator], tuple[Array, Array]]
    #: Observations (n, k), in single or double precision
    observe: Callable[[Array, Array], NDArray[np.floating[Any]]]
    #: Rewards (n,) after a step with the inputs u
    reward: Callable[[Array, Array, Array], Array]
    #: Whether an episode is over (n,), for good
    is_over: Callable[[Array, Array], Flags]
    #: Steps after which an episode is cut off
    max_steps: int = 1000
    #: Steps of the simulator for each action
    steps_per_action: int = 1
    #: Least and largest input; the effort limits of the joints if they are left out
    bounds: tuple[Sequence[float], Sequence[float]] | None = None
    #: States (n, nq), (n, nv) from which n episodes start, in place of `start`: one call for all that begin, hundreds of times as fast
    starts: Callable[[Draws], tuple[Array, Array]] | None = None
    #: Least and largest observation; unbounded if they are left out
    observation_bounds: tuple[Sequence[float], Sequence[float]] | None = None

    def action_space(self) -> spaces.Box:
        """The inputs, within their bounds."""
        low, high = self.simulator.effort_bounds if self.bounds is None else self.bounds
        return spaces.Box(np.asarray(low, np.float32), np.asarray(high, np.float32), dtype=np.float32)

    def observation_space(self) -> spaces.Box:
        """The observations, within their bounds."""
        q, v = self.start(np.random.default_rng(0))
        size = self.observe(q[None], v[None]).shape[1]
        low, high = self.observation_bounds or (np.full(size, -np.inf), np.full(size, np.inf))
        return spaces.Box(np.asarray(low, np.float32), np.asarray(high, np.float32), dtype=np.float32)


class States:
    """The states of a task while they are stepped. They start by `Task.starts` on random numbers of all at once, or by `Task.start` on a generator each."""

    def __init__(self, task: Task, seeds: Sequence[int | None], generators: Sequence[np.random.Generator] | None = None) -> None:
        simulator, n = task.simulator, len(seeds)
        self.task, self.n = task, n
        #: Draws the first state; made with the first picture.
        self._pictures: Pictures | None = None
        self.q, self.v = np.zeros((n, simulator.model.nq)), np.zeros((n, simulator.model.nv))
        self._neutral = simulator.neutral_contact()
        self.contact = np.zeros((n, len(self._neutral)))
        self.steps = np.zeros(n, np.int64)
        #: History of the first state since its start, for pictures
        self.history: list[tuple[Array, Array]] = []
        self._keys = np.zeros(n, np.uint64)
        self._generators = list(generators or [])
        if not self._generators:
            self.seed(seeds)
        self.start(np.ones(n, np.bool_))

    def seed(self, seeds: Sequence[int | None]) -> None:
        """Seeds the environments whose seed is not None, and at first all."""
        if self.task.starts is not None:
            given = np.array([s is not None for s in seeds]) | (self._keys == 0)
            self._keys = np.where(given, keys(seeds), self._keys)
        else:
            known = self._generators
            new = [known[i] if s is None and known else seeding.np_random(s)[0] for i, s in enumerate(seeds)]
            self._generators = new

    def start(self, which: Flags) -> None:
        """Begins new episodes."""
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
        if len(self._neutral):
            self.contact[begins] = self._neutral
        self.steps[begins] = 0
        if begins[0] == 0:
            self.history = [(self.q[0].copy(), self.v[0].copy())]

    def step(self, actions: Any) -> tuple[Array, Flags, Flags]:
        """Takes a step with each action: rewards, termination, truncation. A state that diverges keeps its value, and its episode ends."""
        task = self.task
        u = np.asarray(actions, np.float64)
        expected = (self.n, task.simulator.nu)
        if u.shape != expected:
            raise ValueError(f"the actions have the shape {u.shape}, expected {expected}")
        if not np.isfinite(u).all():
            i = int(np.flatnonzero(~np.isfinite(u).all(axis=1))[0])
            raise ValueError(f"the action of environment {i} is not finite: {u[i]}")
        going = self._advance(u)
        self.steps += 1
        self.history.append((self.q[0].copy(), self.v[0].copy()))
        over = task.is_over(self.q, self.v) | ~going
        return task.reward(self.q, self.v, u), over, (self.steps >= task.max_steps) & ~over

    def _advance(self, u: Array) -> Flags:
        """Moves all states by the steps of an action; says which go on, and leaves those that diverge where they were."""
        state: tuple[Array, ...] = (self.q, self.v, self.contact)[: 3 if self.contact.shape[1] else 2]
        simulator = self.task.simulator
        try:
            # Steps are taken one by one: to set up a rollout takes as long as many of them.
            for _ in range(self.task.steps_per_action):
                state = simulator.step(state[0], state[1], u, contact=state[2] if len(state) > 2 else None)
        except FloatingPointError:
            return self._advance_each(u)
        self.q, self.v = state[:2]
        if len(state) > 2:
            self.contact = state[2]
        return np.ones(len(u), np.bool_)

    def _advance_each(self, u: Array) -> Flags:
        """`_advance` where some state diverges."""
        inputs = np.repeat(u[:, None], self.task.steps_per_action, axis=1)
        contact = self.contact if self.contact.shape[1] else None
        rollout = self.task.simulator.rollout(self.q, self.v, inputs=inputs, contact=contact)
        ends = np.concatenate([rollout.q[:, -1], rollout.v[:, -1]], axis=1)
        going: Flags = np.asarray(np.isfinite(ends).all(axis=1), dtype=np.bool_)
        for state, rows in ((self.q, rollout.q), (self.v, rollout.v), (self.contact, rollout.contact)):
            state[going] = rows[going, -1]
        return going

    def observe(self) -> NDArray[np.float32]:
        return self.task.observe(self.q, self.v).astype(np.float32, copy=False)

    def recording(self) -> Recording:
        """The episode of the first state."""
        task = self.task
        recording = Recording(task.simulator.model)
        for k, state in enumerate(self.history):
            recording.push(k * task.steps_per_action * task.simulator.time_step, state)
        return recording

    def picture(self) -> NDArray[np.uint8]:
        """The first state, from where its episode's start is in the middle: (height, width, 3)."""
        if self._pictures is None:
            recording = Recording(self.task.simulator.model)
            recording.push(0.0, self.history[0])
            self._pictures = Pictures(recording)
        return self._pictures.of(self.q[0])
