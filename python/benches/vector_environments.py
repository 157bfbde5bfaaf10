"""Steps a second of vector environments beside Gymnasium's cart-pole in NumPy: `python benches/vector_environments.py [THREADS]`."""

from __future__ import annotations

import sys
import time
from typing import Any

import dualbody as db
import dualbody.gym as gym
from gymnasium.envs.classic_control.cartpole import CartPoleVectorEnv


def rate(env: Any, n: int) -> float:
    """Steps a second of all n environments, resets included: the best of many short runs, since other work disturbs long ones."""
    env.reset(seed=0)
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(32)]
    steps, best, end = max(2, 2048 // n), 0.0, time.perf_counter() + 4.0
    while time.perf_counter() < end:
        began = time.perf_counter()
        for k in range(steps):
            env.step(actions[k % 32])
        best = max(best, n * steps / (time.perf_counter() - began))
    return best


if len(sys.argv) > 1:
    db.set_threads(int(sys.argv[1]))
for n in (1, 64, 1024, 4096, 16384):
    theirs, ours = rate(CartPoleVectorEnv(num_envs=n), n), rate(gym.BatchEnv(gym.cartpole(), n), n)
    print(f"{n:6} environments, M steps/s: ours {ours / 1e6:7.3f}, Gymnasium {theirs / 1e6:7.3f}, ours / theirs {ours / theirs:.2f}")
