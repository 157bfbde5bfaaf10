"""Finds one linear regulator that balances cart-poles of many masses, on a Ray cluster or on this machine.

    python examples/ray_domain_randomisation.py [--address auto] [--workers 2] [--robots 512]

Without an address, the program starts Ray with the given number of workers on this machine. On a cluster, start Ray on one machine with
`ray start --head`, on the others with `ray start --address HEAD:6379`, then run this program on any of them with `--address auto`.
"""

from __future__ import annotations

import argparse

import numpy as np
import ray

import dualbody as db
import dualbody.ray as dr

STEPS = 250
DT = 0.02


def start(generator: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A random position of the cart and angle of the pole, at rest."""
    return generator.uniform(-0.15, 0.15, 2), np.zeros(2)


def randomised(model: db.Model, generator: np.random.Generator) -> db.Model:
    """A pole of 0.5 to 1.5 times its mass, a cart likewise."""
    parameters = model.parameters
    masses = [k for k, name in enumerate(model.parameter_names) if name.endswith("mass")]
    factors = np.ones(len(parameters))
    width = 10  # mass, first moment, inertia: all scale with the mass
    for k in masses:
        factors[k : k + width] = generator.uniform(0.5, 1.5)
    return model.with_parameters(parameters * factors)


def control(k: int, q: np.ndarray, v: np.ndarray, parameters: np.ndarray) -> np.ndarray:
    """A linear law, of each candidate its own."""
    u = (parameters * np.concatenate([q, v], axis=1)).sum(axis=1, keepdims=True)
    return np.clip(u, -20.0, 20.0)


def points(rollout: db.Rollout) -> np.ndarray:
    """Less the mean deviation from upright at the origin; a fall counts as one."""
    deviation = np.abs(np.nan_to_num(rollout.q, nan=1.0)).clip(0.0, 1.0)
    return -deviation.max(axis=2).mean(axis=1)


def work() -> dr.Work:
    simulator = db.Simulator(db.samples.cartpole(), time_step=DT, actuated=["linear"])
    return dr.Work(simulator, STEPS, start, control, randomised)


def main(arguments: list[str] | None = None) -> dr.Evolution:
    parser = argparse.ArgumentParser()
    parser.add_argument("--address")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--robots", type=int, default=512)
    options = parser.parse_args(arguments)
    if not ray.is_initialized():
        here = {"num_cpus": options.workers, "include_dashboard": False} if options.address is None else {}
        ray.init(address=options.address, **here)
    found = dr.evolve(work(), points, [0.0] * 4, [10.0] * 4, generations=20, candidates=options.robots, elite=32, shard=128, enough=-0.03)
    print("points of the elite, generation by generation:", np.round(found.history, 3).tolist())

    gains = np.tile(found.mean, (options.robots, 1))
    kept = dr.Work(work().simulator, 2 * STEPS, start, control, randomised, keep=lambda r: np.abs(r.q[:, -1]).max(axis=1))
    ends = np.concatenate([end for _, end in dr.rollouts(kept, options.robots, seed=99, parameters=gains, shard=128)])
    print(f"gains {np.round(found.mean, 2).tolist()}; {np.mean(ends < 0.1):.1%} of {options.robots} new robots stand after {2 * STEPS * DT:.0f} s")
    assert np.mean(ends < 0.1) > 0.95
    return found


if __name__ == "__main__":
    main()
