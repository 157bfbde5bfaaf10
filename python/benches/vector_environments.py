"""Steps a second of vector environments beside Gymnasium's cart-pole in NumPy: `python benches/vector_environments.py`."""

from __future__ import annotations

import time
from typing import Any

import dualbody.gym as gym
from gymnasium.envs.classic_control.cartpole import CartPoleVectorEnv


def rate(env: Any, n: int) -> float:
    """Steps a second of all n environments, resets included: the best of nine runs of some thousand steps each."""
    env.reset(seed=0)
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(32)]
    steps = max(32, 65536 // n)
    best = 0.0
    for _ in range(9):
        began = time.perf_counter()
        for k in range(steps):
            env.step(actions[k % 32])
        best = max(best, n * steps / (time.perf_counter() - began))
    return best


for n in (1, 64, 1024, 4096, 16384):
    theirs, ours = rate(CartPoleVectorEnv(num_envs=n), n), rate(gym.BatchEnv(gym.cartpole(), n), n)
    print(f"{n:6} environments, M steps/s: ours {ours / 1e6:7.3f}, Gymnasium {theirs / 1e6:7.3f}, ours / theirs {ours / theirs:.2f}")
