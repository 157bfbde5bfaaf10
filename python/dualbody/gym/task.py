"""Tasks of reinforcement learning."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from ..sim import Simulator
from .draws import Draws

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Bounds = tuple[ArrayLike, ArrayLike]


def _space(bounds: Bounds) -> spaces.Box:
    low, high = (np.asarray(bound, np.float32) for bound in bounds)
    return spaces.Box(low, high, dtype=np.float32)


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
        return _space(self.simulator.effort_bounds if self.bounds is None else self.bounds)

    def observation_space(self) -> spaces.Box:
        """The observations, within their bounds."""
        q, v = self.start(np.random.default_rng(0))
        size = self.observe(q[None], v[None]).shape[1]
        return _space(self.observation_bounds or (np.full(size, -np.inf), np.full(size, np.inf)))


@dataclass(frozen=True)
class Balance:
    """A task that is data, and runs without a function of Python: the state is kept within bounds, one point for each action. Observed is the state, q and v in a row."""

    simulator: Simulator
    #: Least and largest start (2 nv,), uniform between them: a way from the neutral configuration along the directions of v, then v
    start: Bounds
    #: Least and largest q and v in a row (nq + nv,), outside of which an episode is over; infinite where nothing is bounded
    within: Bounds
    #: Steps after which an episode is cut off
    max_steps: int = 1000
    #: Steps of the simulator for each action
    steps_per_action: int = 1
    #: Least and largest input; the effort limits of the joints if they are left out
    bounds: Bounds | None = None

    def action_space(self) -> spaces.Box:
        """The inputs, within their bounds."""
        return _space(self.simulator.effort_bounds if self.bounds is None else self.bounds)

    def observation_space(self) -> spaces.Box:
        """All states: those that end an episode are observed too."""
        size = self.simulator.model.nq + self.simulator.model.nv
        return _space((np.full(size, -np.inf), np.full(size, np.inf)))
