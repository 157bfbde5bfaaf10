"""Environments over one state, and over a batch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from ..view import Pictures, Recording
from .episodes import Episodes, TaskEpisodes, episodes
from .task import Array, Balance, Task

#: "html" is the page of the episode so far, "rgb_array" a picture of the state, (height, width, 3).
RENDER_MODES = ["html", "rgb_array"]


class _Film:
    """The episode of the first state, where it is to be shown."""

    def __init__(self, task: Task | Balance, mode: str | None) -> None:
        self._task, self._mode = task, mode
        self._states: list[tuple[Array, Array]] = []
        #: Draws the state, with the start of the first episode in the middle; made with the first picture
        self._pictures: Pictures | None = None

    def note(self, all_: Episodes) -> None:
        """Adds the state after a step, or that of a start."""
        if self._mode is not None:
            q, v, steps = all_.first()
            if steps == 0:
                self._states = []
            self._states.append((q, v))

    def render(self) -> Any:
        """The page, or a picture of the last state; None before the first reset, and without a mode."""
        if not self._states:
            return None
        if self._mode == "rgb_array":
            if self._pictures is None:
                self._pictures = Pictures(self._recording(self._states[:1]))
            return self._pictures.of(self._states[-1][0])
        return self._recording(self._states).to_html()

    def _recording(self, states: list[tuple[Array, Array]]) -> Recording:
        task = self._task
        recording = Recording(task.simulator.model)
        for k, state in enumerate(states):
            recording.push(k * task.steps_per_action * task.simulator.time_step, state)
        return recording


class SingleEnv(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """A task on one state."""

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": 50}

    def __init__(self, task: Task | Balance, render_mode: str | None = None) -> None:
        self.task, self.render_mode = task, render_mode
        both: tuple[Any, Any] = task.action_space(), task.observation_space()
        self.action_space, self.observation_space = both
        self._episodes: Episodes | None = None
        self._film = _Film(task, render_mode)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode: the observation, and an empty info. seed: of its random numbers from now on."""
        super().reset(seed=seed)
        task = self.task
        if isinstance(task, Task) and task.starts is None:
            self._episodes = TaskEpisodes(task, 1, AutoresetMode.DISABLED, [self.np_random])
        elif self._episodes is None or seed is not None:
            self._episodes = self._episodes or episodes(task, 1, AutoresetMode.DISABLED)
            self._episodes.seed([seed if seed is not None else int(self.np_random.integers(2**63))])
        observations = self._episodes.reset()
        self._film.note(self._episodes)
        return observations[0], {}

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Takes a step with an action (nu,): the observation, the reward, whether the episode is terminated, whether it is truncated, and an empty info."""
        if self._episodes is None:
            raise RuntimeError("reset the environment before its first step")
        observations, reward, over, cut, _ = self._episodes.step(np.asarray(action)[None])
        self._film.note(self._episodes)
        return observations[0], float(reward[0]), bool(over[0]), bool(cut[0]), {}

    def render(self) -> Any:
        """The HTML viewer of the episode so far; in the mode "rgb_array" a picture of the state."""
        return self._film.render()


class BatchEnv(gymnasium.vector.VectorEnv[NDArray[np.float32], NDArray[np.float32], NDArray[Any]]):
    """A task on a batch of states, each with its own random numbers: state i of seed s starts as a `SingleEnv` of seed s + i does.

    autoreset_mode: NEXT_STEP (the step after an end starts a new episode), SAME_STEP (the step of the end does, and info holds
    "final_obs"), or DISABLED (`reset(options={"reset_mask": flags})`).
    """

    def __init__(
        self, task: Task | Balance, num_envs: int = 1, autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP, render_mode: str | None = None
    ) -> None:
        self.task, self.num_envs, self.render_mode = task, num_envs, render_mode
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {"render_modes": RENDER_MODES, "render_fps": 50, "autoreset_mode": self.autoreset_mode}
        self.single_action_space, self.single_observation_space = task.action_space(), task.observation_space()
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._episodes: Episodes | None = None
        self._film = _Film(task, render_mode)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins episodes: an observation for each state, and an empty info. seed: one for all, or one for each state; options: "reset_mask"
        (num_envs,) selects the states to reset, all by default."""
        mask = (options or {}).get("reset_mask") if self._episodes is not None else None
        seeds: Sequence[int | None]
        if seed is None or isinstance(seed, (int, np.integer)):
            seeds = [None if seed is None else int(seed) + i for i in range(self.num_envs)]
        else:
            seeds = list(seed)
        if len(seeds) != self.num_envs:
            raise ValueError(f"{len(seeds)} seeds for {self.num_envs} states")
        is_first = self._episodes is None
        all_ = self._episodes = self._episodes or episodes(self.task, self.num_envs, self.autoreset_mode)
        if is_first or (mask is None and any(s is not None for s in seeds)):
            all_.seed(seeds)
        observations = all_.reset(None if mask is None else np.asarray(mask, np.bool_))
        self._film.note(all_)
        return observations, {}

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Takes a step with each action (num_envs, nu): observations, rewards, terminated and truncated episodes, and "final_obs" of
        those that end if the next one begins in the same step."""
        if self._episodes is None:
            raise RuntimeError("reset the environment before its first step")
        observations, reward, over, cut, last = self._episodes.step(actions)
        if self.render_mode is not None:
            self._film.note(self._episodes)
        if last is None:
            return observations, reward, over, cut, {}
        ended = over | cut
        final = np.empty(self.num_envs, object)
        for i in np.flatnonzero(ended):
            final[i] = last[i]
        info = {"final_obs": final, "_final_obs": ended, "final_info": {}, "_final_info": ended}
        return observations, reward, over, cut, info

    def render(self) -> Any:
        """The HTML viewer of the first state's episode so far; in the mode "rgb_array" a picture of that state."""
        return self._film.render()
