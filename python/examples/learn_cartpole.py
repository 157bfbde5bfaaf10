"""Learns to balance the cart-pole of Gymnasium's registry, from a random policy, in some seconds on one core.

    pip install cma gymnasium
    python examples/learn_cartpole.py

The policy is a network with one hidden layer; CMA-ES, of the package `cma`, evolves its weights. Each candidate is one environment of a batch: the
step of all is one call. The learned policy is evaluated in new episodes; the mean must reach 475 of 500 points, the threshold of Gymnasium.
"""

from __future__ import annotations

import argparse
import time

import cma
import gymnasium
import numpy as np

import dualbody.gym

HIDDEN = 6
CANDIDATES = 64
#: Of 500 points, in the mean over new episodes
SOLVED = 475.0


def act(weights: np.ndarray, observations: np.ndarray) -> np.ndarray:
    """Pushes (n, 1), N, of policies (n, weights) that see observations (n, 4)."""
    n, k = observations.shape
    first, last = weights[:, : k * HIDDEN].reshape(n, HIDDEN, k), weights[:, k * HIDDEN :]
    hidden = np.tanh((first @ observations[:, :, None])[:, :, 0])
    return 10.0 * np.tanh((last * hidden).sum(axis=1, keepdims=True))


def points(weights: np.ndarray, seed: int) -> np.ndarray:
    """Points (n,) of an episode of each policy."""
    envs = gymnasium.make_vec("dualbody/CartPole-v0", num_envs=len(weights), vectorization_mode="vector_entry_point")
    observations, _ = envs.reset(seed=seed)
    total, alive = np.zeros(len(weights)), np.ones(len(weights), bool)
    while alive.any():
        observations, reward, over, cut, _ = envs.step(act(weights, observations).astype(np.float32))
        total += reward * alive
        alive &= ~(over | cut)
    return total


def main(arguments: list[str] | None = None) -> float:
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    begin = time.perf_counter()
    size = len(dualbody.gym.cartpole().observation_space().low)
    start = np.zeros(size * HIDDEN + HIDDEN)
    search = cma.CMAEvolutionStrategy(start, 0.5, {"popsize": CANDIDATES, "seed": options.seed, "verbose": -9})
    for generation in range(100):
        candidates = np.array(search.ask())
        found = points(candidates, seed=1000 * generation)
        search.tell(list(candidates), list(-found))
        print(f"generation {generation}: best {found.max():.0f}, mean {found.mean():.0f} points, {time.perf_counter() - begin:.1f} s")
        if np.median(found) >= SOLVED:
            break
    trials = points(np.broadcast_to(search.result.xfavorite, (100, len(start))).copy(), seed=10**6)
    print(f"100 new episodes: {trials.mean():.1f} points in the mean; {time.perf_counter() - begin:.1f} s in all")
    assert trials.mean() >= SOLVED
    return float(trials.mean())


if __name__ == "__main__":
    main()
