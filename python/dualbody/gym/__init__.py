"""Learning: environments of Gymnasium over one state and over batches.

>>> import gymnasium, dualbody.gym
>>> envs = gymnasium.make_vec("dualbody/CartPole-v0", num_envs=64)

A `Task` is a simulator with NumPy functions of the arrays of a batch: observations, rewards, termination. All states are stepped in one call. A `Balance` is data, and is stepped
without functions of Python.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import gymnasium

from .draws import Draws
from .environments import BatchEnv, SingleEnv
from .push_block import push_block
from .robots import cartpole, quadruped, quadruped_model
from .task import Balance, Task

__all__ = ["Balance", "BatchEnv", "Draws", "SingleEnv", "Task", "cartpole", "push_block", "quadruped", "quadruped_model"]


def _one(task: Callable[[], Task | Balance], render_mode: str | None = None) -> SingleEnv:
    return SingleEnv(task(), render_mode)


def _many(task: Callable[[], Task | Balance], num_envs: int = 1, **keywords: Any) -> BatchEnv:
    return BatchEnv(task(), num_envs, **keywords)


_TASKS: dict[str, Callable[[], Task | Balance]] = {"CartPole": cartpole, "PushBlock": push_block, "Quadruped": quadruped}
for _name, _task in _TASKS.items():
    if f"dualbody/{_name}-v0" not in gymnasium.registry:
        _entries: dict[str, Any] = {"entry_point": partial(_one, _task), "vector_entry_point": partial(_many, _task)}
        gymnasium.register(f"dualbody/{_name}-v0", **_entries)
