"""Steps a second of vector environments beside Gymnasium's cart-pole in NumPy, in short runs in turn: `python benches/vector_environments.py [THREADS]`."""

from __future__ import annotations

import sys
import time
from typing import Any

import dualbody as db
import dualbody.gym as gym
import numpy as np
from gymnasium.envs.classic_control.cartpole import CartPoleVectorEnv


def run(env: Any, n: int, actions: list[Any]) -> float:
    """Steps a second of all n environments in a short run, resets included."""
    steps = max(2, 2048 // n)
    began = time.perf_counter()
    for k in range(steps):
        env.step(actions[k % 32])
    return n * steps / (time.perf_counter() - began)


def rates(n: int, seconds: float = 6.0) -> tuple[float, float]:
    """Medians of Gymnasium's and of ours, which run in turn."""
    both = CartPoleVectorEnv(num_envs=n), gym.BatchEnv(gym.cartpole(), n)
    actions = []
    for env in both:
        env.reset(seed=0)
        env.action_space.seed(0)
        actions.append([env.action_space.sample() for _ in range(32)])
    runs, end = [], time.perf_counter() + seconds
    while time.perf_counter() < end:
        runs.append([run(env, n, own) for env, own in zip(both, actions, strict=True)])
    theirs, ours = np.median(runs, axis=0)
    return float(theirs), float(ours)


if len(sys.argv) > 1:
    db.set_threads(int(sys.argv[1]))
for n in (1, 64, 1024, 4096, 16384):
    theirs, ours = rates(n)
    print(f"{n:6} environments, {db.threads()} threads, M steps/s: ours {ours / 1e6:7.3f}, Gymnasium {theirs / 1e6:7.3f}, ours / theirs {ours / theirs:.2f}")
