"""Learning: environments of Gymnasium over one state and over batches.

>>> import gymnasium, dualbody.gym
>>> envs = gymnasium.make_vec("dualbody/CartPole-v0", num_envs=64)

A `Task` is a simulator with NumPy functions of the arrays of a batch: observations, rewards, termination. All states are stepped in one call. A `Balance` is data, and is stepped
without functions of Python.
"""

from __future__ import annotations

from typing import Any

import gymnasium

from .draws import Draws
from .environments import BatchEnv, SingleEnv
from .push_block import push_block
from .robots import cartpole, quadruped, quadruped_model
from .task import Balance, Task

__all__ = ["Balance", "BatchEnv", "Draws", "SingleEnv", "Task", "cartpole", "push_block", "quadruped", "quadruped_model"]


def _make_cartpole(render_mode: str | None = None) -> SingleEnv:
    return SingleEnv(cartpole(), render_mode)


def _make_cartpoles(num_envs: int = 1, **keywords: Any) -> BatchEnv:
    return BatchEnv(cartpole(), num_envs, **keywords)


def _make_quadruped(render_mode: str | None = None) -> SingleEnv:
    return SingleEnv(quadruped(), render_mode)


def _make_quadrupeds(num_envs: int = 1, **keywords: Any) -> BatchEnv:
    return BatchEnv(quadruped(), num_envs, **keywords)


def _make_push_block(render_mode: str | None = None) -> SingleEnv:
    return SingleEnv(push_block(), render_mode)


def _make_push_blocks(num_envs: int = 1, **keywords: Any) -> BatchEnv:
    return BatchEnv(push_block(), num_envs, **keywords)


_entries: list[tuple[str, Any, Any]] = [
    ("CartPole", _make_cartpole, _make_cartpoles),
    ("PushBlock", _make_push_block, _make_push_blocks),
    ("Quadruped", _make_quadruped, _make_quadrupeds),
]
for _name, _one, _many in _entries:
    if f"dualbody/{_name}-v0" not in gymnasium.registry:
        gymnasium.register(f"dualbody/{_name}-v0", entry_point=_one, vector_entry_point=_many)
