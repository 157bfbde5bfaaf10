"""Environments over one state, and over a batch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from .task import States, Task


#: "html" is the page of the episode so far, "rgb_array" a picture of the state, (height, width, 3).
RENDER_MODES = ["html", "rgb_array"]


def _render(states: States | None, mode: str | None) -> Any:
    if states is None:
        return None
    return states.picture() if mode == "rgb_array" else states.recording().to_html()


class SingleEnv(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """A task on one state."""

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": 50}

    def __init__(self, task: Task, render_mode: str | None = None) -> None:
        self.task, self.render_mode = task, render_mode
        both: tuple[Any, Any] = task.action_space(), task.observation_space()
        self.action_space, self.observation_space = both
        self._states: States | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode: the observation, and an empty info. seed: of its random numbers from now on."""
        super().reset(seed=seed)
        if self.task.starts is None:
            self._states = States(self.task, [seed], [self.np_random])
        elif self._states is None or seed is not None:
            own = seed if seed is not None else int(self.np_random.integers(2**63))
            self._states = States(self.task, [own])
        else:
            self._states.start(np.ones(1, np.bool_))
        return self._states.observe()[0], {}

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Takes a step with an action (nu,): the observation, the reward, whether the episode is terminated, whether it is truncated, and an empty info."""
        if self._states is None:
            raise RuntimeError("reset the environment before its first step")
        reward, over, cut = self._states.step(np.asarray(action)[None])
        return self._states.observe()[0], float(reward[0]), bool(over[0]), bool(cut[0]), {}

    def render(self) -> Any:
        """The HTML viewer of the episode so far; in the mode "rgb_array" a picture of the state."""
        return _render(self._states, self.render_mode)


class BatchEnv(gymnasium.vector.VectorEnv[NDArray[np.float32], NDArray[np.float32], NDArray[Any]]):
    """A task on a batch of states, each with its own random numbers: state i of seed s starts as a `SingleEnv` of seed s + i does.

    autoreset_mode: NEXT_STEP (the step after an end starts a new episode), SAME_STEP (the step of the end does, and info holds
    "final_obs"), or DISABLED (`reset(options={"reset_mask": flags})`).
    """

    def __init__(
        self,
        task: Task,
        num_envs: int = 1,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
    ) -> None:
        self.task, self.num_envs, self.render_mode = task, num_envs, render_mode
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {"render_modes": RENDER_MODES, "render_fps": 50, "autoreset_mode": self.autoreset_mode}
        self.single_action_space, self.single_observation_space = task.action_space(), task.observation_space()
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._states: States | None = None
        self._ended = np.zeros(num_envs, np.bool_)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins episodes: an observation for each state, and an empty info. seed: one for all, or one for each state; options: "reset_mask"
        (num_envs,) selects the states to reset, all by default."""
        mask = (options or {}).get("reset_mask")
        if mask is not None and self._states is not None:
            which = np.asarray(mask, np.bool_)
            if which.shape != (self.num_envs,):
                raise ValueError(f"reset_mask has the shape {which.shape}, expected ({self.num_envs},)")
            self._states.start(which)
            self._ended &= ~which
            return self._states.observe(), {}
        seeds: Sequence[int | None]
        if seed is None or isinstance(seed, (int, np.integer)):
            seeds = [None if seed is None else int(seed) + i for i in range(self.num_envs)]
        else:
            seeds = list(seed)
        if len(seeds) != self.num_envs:
            raise ValueError(f"{len(seeds)} seeds for {self.num_envs} states")
        if self._states is None:
            self._states = States(self.task, seeds)
        else:
            if any(s is not None for s in seeds):
                self._states.seed(seeds)
            self._states.start(np.ones(self.num_envs, np.bool_))
        self._ended[:] = False
        return self._states.observe(), {}

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Takes a step with each action (num_envs, nu): observations, rewards, terminated and truncated episodes, and "final_obs" of
        those that end if the next one begins in the same step."""
        states = self._states
        if states is None:
            raise RuntimeError("reset the environment before its first step")
        if self.autoreset_mode is AutoresetMode.DISABLED and self._ended.any():
            raise RuntimeError("episodes are over: reset them with options={'reset_mask': flags}")
        again = self._ended.copy()
        reward, over, cut = states.step(actions)
        if again.any():
            states.start(again)
            reward, over, cut = reward.copy(), over.copy(), cut.copy()
            reward[again], over[again], cut[again] = 0.0, False, False
        info: dict[str, Any] = {}
        ended = over | cut
        if self.autoreset_mode is AutoresetMode.SAME_STEP and ended.any():
            final = np.empty(self.num_envs, object)
            for i, row in enumerate(states.observe()):
                final[i] = row if ended[i] else None
            info = {"final_obs": final, "_final_obs": ended, "final_info": {}, "_final_info": ended}
            states.start(ended)
            ended = np.zeros_like(ended)
        self._ended = ended
        return states.observe(), reward, over, cut, info

    def render(self) -> Any:
        """The HTML viewer of the first state's episode so far; in the mode "rgb_array" a picture of that state."""
        return _render(self._states, self.render_mode)
