"""Learning: environments of Gymnasium over one state and over batches.

>>> import gymnasium, dualbody.gym
>>> envs = gymnasium.make_vec("dualbody/CartPole-v0", num_envs=64)

A `Task` is a simulator with NumPy functions of a batch's arrays: observations, rewards, ends. The step of all states is one call.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from . import samples
from .contact import Contacts, Rigid, Terrain
from .model import Box, JointSpec, Limits, LinkSpec, Model, ModelBuilder, Sphere
from .sim import Simulator
from .view import Recording

__all__ = ["BatchEnv", "SingleEnv", "Task", "cartpole", "quadruped", "quadruped_model"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Task:
    """What is to be learned. q (n, nq), v (n, nv), u (n, nu) are the states and inputs of a batch."""

    simulator: Simulator
    #: State (nq,), (nv,) from which an episode starts, by a generator of its own
    start: Callable[[np.random.Generator], tuple[Array, Array]]
    #: Observations (n, k)
    observe: Callable[[Array, Array], Array]
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


@dataclass
class _States:
    """The states of a task while they are stepped."""

    task: Task
    generators: list[np.random.Generator]
    q: Array = field(init=False)
    v: Array = field(init=False)
    contact: Array = field(init=False)
    steps: NDArray[np.int64] = field(init=False)
    #: What the first state has gone through since its start: for pictures.
    history: list[tuple[Array, Array]] = field(default_factory=list)

    def __post_init__(self) -> None:
        simulator, n = self.task.simulator, len(self.generators)
        self.q, self.v = np.zeros((n, simulator.model.nq)), np.zeros((n, simulator.model.nv))
        self.contact = np.zeros((n, simulator.n_contact))
        self.steps = np.zeros(n, np.int64)
        self.start(np.ones(n, np.bool_))

    def start(self, which: Flags) -> None:
        """Begins new episodes."""
        for i in np.flatnonzero(which):
            self.q[i], self.v[i] = self.task.start(self.generators[i])
        self.contact[which] = self.task.simulator.neutral_contact()
        self.steps[which] = 0
        if which[0]:
            self.history = [(self.q[0].copy(), self.v[0].copy())]

    def step(self, actions: Any) -> tuple[Array, Flags, Flags]:
        """Takes a step with each action: rewards, ends, cuts. A state that diverges stays where it was, and its episode is over."""
        task = self.task
        u = np.asarray(actions, np.float64)
        inputs = np.repeat(u[:, None], task.steps_per_action, axis=1)
        contact = self.contact if self.contact.shape[1] else None
        rollout = task.simulator.rollout(self.q, self.v, inputs=inputs, contact=contact)
        going = np.isfinite(rollout.v[:, -1]).all(axis=1) & np.isfinite(rollout.q[:, -1]).all(axis=1)
        for state, rows in ((self.q, rollout.q), (self.v, rollout.v), (self.contact, rollout.contact)):
            state[going] = rows[going, -1]
        self.steps += 1
        self.history.append((self.q[0].copy(), self.v[0].copy()))
        over = task.is_over(self.q, self.v) | ~going
        return task.reward(self.q, self.v, u), over, (self.steps >= task.max_steps) & ~over

    def observe(self) -> NDArray[np.float32]:
        return self.task.observe(self.q, self.v).astype(np.float32)

    def recording(self) -> Recording:
        """The episode of the first state."""
        task = self.task
        recording = Recording(task.simulator.model)
        for k, state in enumerate(self.history):
            recording.push(k * task.steps_per_action * task.simulator.time_step, state)
        return recording


class SingleEnv(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """A task on one state."""

    metadata: dict[str, Any] = {"render_modes": ["html"], "render_fps": 50}

    def __init__(self, task: Task, render_mode: str | None = None) -> None:
        self.task, self.render_mode = task, render_mode
        both: tuple[Any, Any] = task.action_space(), task.observation_space()
        self.action_space, self.observation_space = both
        self._states: _States | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        super().reset(seed=seed)
        self._states = _States(self.task, [self.np_random])
        return self._states.observe()[0], {}

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        if self._states is None:
            raise RuntimeError("reset the environment before its first step")
        reward, over, cut = self._states.step(np.asarray(action)[None])
        return self._states.observe()[0], float(reward[0]), bool(over[0]), bool(cut[0]), {}

    def render(self) -> Any:
        """The page of the episode so far, as HTML."""
        return None if self._states is None else self._states.recording().to_html()


class BatchEnv(gymnasium.vector.VectorEnv[NDArray[np.float32], NDArray[np.float32], NDArray[Any]]):
    """A task on a batch of states, each with its own generator: state i of seed s starts as a `SingleEnv` of seed s + i does.

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
        self.metadata = {"render_modes": ["html"], "render_fps": 50, "autoreset_mode": self.autoreset_mode}
        self.single_action_space, self.single_observation_space = task.action_space(), task.observation_space()
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._states: _States | None = None
        self._ended = np.zeros(num_envs, np.bool_)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
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
        if self._states is None or any(s is not None for s in seeds):
            known = [] if self._states is None else self._states.generators
            generators = [
                known[i] if s is None and known else seeding.np_random(s)[0] for i, s in enumerate(seeds)
            ]
            self._states = _States(self.task, generators)
        else:
            self._states.start(np.ones(self.num_envs, np.bool_))
        self._ended[:] = False
        return self._states.observe(), {}

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
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
        """The page of the first state's episode so far, as HTML."""
        return None if self._states is None else self._states.recording().to_html()


def cartpole() -> Task:
    """A pole is balanced by pushing its cart: one point for each of 500 steps in which the cart is within 2.4 m and the pole within 12°."""
    simulator = Simulator(samples.cartpole(), time_step=0.02, actuated=["linear"])
    angle, reach = np.radians(12), 2.4

    def start(generator: np.random.Generator) -> tuple[Array, Array]:
        x = generator.uniform(-0.05, 0.05, 4)
        return x[:2], x[2:]

    return Task(
        simulator,
        start,
        observe=lambda q, v: np.concatenate([q, v], axis=1),
        reward=lambda q, v, u: np.ones(len(q)),
        is_over=lambda q, v: (np.abs(q[:, 0]) > reach) | (np.abs(q[:, 1]) > angle),
        max_steps=500,
        bounds=([-10.0], [10.0]),
    )


def quadruped_model() -> Model:
    """A quadruped of 12 kg: a trunk, and four legs of three hinges with balls as feet."""
    builder = ModelBuilder("quadruped", base="floating")
    builder.add_link(LinkSpec.solid_box("trunk", (0.4, 0.2, 0.1), 8.0))
    for name, x, y in (("lf", 0.19, 0.1), ("rf", 0.19, -0.1), ("lh", -0.19, 0.1), ("rh", -0.19, -0.1)):
        side = 1.0 if y > 0 else -1.0
        rod = ((2e-3, 0.0, 0.0), (0.0, 2e-3, 0.0), (0.0, 0.0, 4e-4))
        middle = Box((0.03, 0.03, 0.2), placement=(0.0, 0.0, -0.1))
        builder.add_link(LinkSpec(f"{name}_hip", 0.4, inertia=((5e-4, 0.0, 0.0), (0.0, 5e-4, 0.0), (0.0, 0.0, 5e-4))))
        builder.add_link(LinkSpec(f"{name}_thigh", 0.4, (0.0, 0.0, -0.1), rod, [middle]))
        foot = Sphere(0.02, placement=(0.0, 0.0, -0.2))
        builder.add_link(LinkSpec(f"{name}_shank", 0.2, (0.0, 0.0, -0.1), rod, [middle, foot], [foot]))
        limits = Limits(effort=25.0, velocity=20.0)
        joints = (
            ("abduction", "trunk", f"{name}_hip", (x, y, 0.0), (1.0, 0.0, 0.0)),
            ("hip", f"{name}_hip", f"{name}_thigh", (0.0, 0.05 * side, 0.0), (0.0, 1.0, 0.0)),
            ("knee", f"{name}_thigh", f"{name}_shank", (0.0, 0.0, -0.2), (0.0, 1.0, 0.0)),
        )
        for joint, parent, child, placement, axis in joints:
            builder.add_joint(
                JointSpec(
                    f"{name}_{joint}", "revolute", parent, child, placement, axis, limits, damping=0.1, armature=0.01
                )
            )
    return builder.build()


def quadruped() -> Task:
    """A quadruped walks: speed along x less effort; over when the trunk falls or tips. Inputs are torques within ±25 N·m."""
    model = quadruped_model()
    contacts = Contacts(Terrain.flat(), Rigid(friction=0.8))
    simulator = Simulator(model, time_step=4e-3, contacts=contacts)
    stand = model.neutral()
    stand[2] = 0.345
    stand[7:] = np.tile([0.0, 0.6, -1.2], 4)

    def start(generator: np.random.Generator) -> tuple[Array, Array]:
        q = stand.copy()
        q[7:] += generator.uniform(-0.05, 0.05, 12)
        return q, generator.uniform(-0.05, 0.05, model.nv)

    def up(q: Array) -> Array:
        x, y = q[:, 4], q[:, 5]
        upright: Array = 1.0 - 2.0 * (x * x + y * y)
        return upright

    return Task(
        simulator,
        start,
        observe=lambda q, v: np.concatenate([q[:, 2:], v], axis=1),
        reward=lambda q, v, u: v[:, 0] - 1e-3 * np.square(u).sum(axis=1) + 0.5,
        is_over=lambda q, v: (q[:, 2] < 0.18) | (up(q) < 0.5),
        max_steps=500,
        steps_per_action=5,
    )


def _make_cartpole(render_mode: str | None = None) -> SingleEnv:
    return SingleEnv(cartpole(), render_mode)


def _make_cartpoles(num_envs: int = 1, **keywords: Any) -> BatchEnv:
    return BatchEnv(cartpole(), num_envs, **keywords)


def _make_quadruped(render_mode: str | None = None) -> SingleEnv:
    return SingleEnv(quadruped(), render_mode)


def _make_quadrupeds(num_envs: int = 1, **keywords: Any) -> BatchEnv:
    return BatchEnv(quadruped(), num_envs, **keywords)


_entries: list[tuple[str, Any, Any]] = [
    ("CartPole", _make_cartpole, _make_cartpoles),
    ("Quadruped", _make_quadruped, _make_quadrupeds),
]
for _name, _one, _many in _entries:
    if f"dualbody/{_name}-v0" not in gymnasium.registry:
        gymnasium.register(f"dualbody/{_name}-v0", entry_point=_one, vector_entry_point=_many)
