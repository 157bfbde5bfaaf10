"""Times of the package: what a call costs beside Rust and beside other engines.

    cargo build --release --example rust
    python benches/table.py [--rust PROGRAM] [--pinocchio PYTHON] [--jaxsim PYTHON] [--ray]

--rust: the program that the command above builds, the same quantities in Rust; --pinocchio, --jaxsim: interpreters that have `pin` and `jaxsim`.
Each figure is the least of several runs; Rust and other engines run before and after, and the less of both counts.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from clock import least, seconds

import dualbody as db

HERE = Path(__file__).resolve().parent
ASSETS = HERE.parents[1] / "assets"
#: Cart-poles of a batch, and steps of each.
COUNT, STEPS = 1024, 100

LOAD_AND_SIMULATE = """
import sys, time
t0 = time.perf_counter()
import dualbody as db
t1 = time.perf_counter()
import numpy
t2 = time.perf_counter()
model = db.Model.from_urdf(sys.argv[1])
rollout = db.Simulator(model, time_step=0.01).rollout([0.0, 0.1], [0.0, 0.0], steps=500)
assert rollout.is_completed
print((t1 - t0) * 1e3, (t2 - t1) * 1e3, (time.perf_counter() - t2) * 1e3)
"""


def output(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def of_rust(program: str) -> dict[str, float]:
    lines = (line.split() for line in output(program).splitlines())
    return {name: float(time) for name, time in lines}


def of_peer(python: str, script: str, *arguments: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(output(python, str(HERE / script), *arguments))
    return found


def twice(measure: Callable[[], dict[str, Any]], between: Callable[[], dict[str, float]]) -> tuple[dict[str, Any], dict[str, float]]:
    """The less of a measurement before and after another, and that one."""
    first = measure()
    own, second = between(), measure()
    return {name: min(x, second[name]) if isinstance(x, float) else x for name, x in first.items()}, own


def arm() -> dict[str, float]:
    """Calls with arrays of one state of the Panda."""
    model = db.Model.from_urdf(ASSETS / "panda.urdf", base="fixed", independent_mimic_joints=True)
    rng = np.random.default_rng(0)
    q, v, a = model.random_configuration(0), rng.normal(size=model.nv), rng.normal(size=model.nv)
    out, matrix = np.empty(model.nv), np.empty((model.nv, model.nv))
    calls: dict[str, Callable[[], object]] = {
        "rnea": lambda: db.inverse_dynamics(model, q, v, a),
        "rnea, out": lambda: db.inverse_dynamics(model, q, v, a, out=out),
        "aba": lambda: db.forward_dynamics(model, q, v, a),
        "crba": lambda: db.mass_matrix(model, q),
        "crba, out": lambda: db.mass_matrix(model, q, out=matrix),
    }
    return {name: least(call, 50) for name, call in calls.items()}


def pole() -> db.Simulator:
    return db.Simulator(db.Model.from_urdf(ASSETS / "cartpole.urdf"), time_step=0.01)


def steps() -> dict[str, float]:
    simulator, q, v, u = pole(), np.array([0.1, 0.2]), np.array([0.3, 0.4]), np.zeros(2)
    return {
        "step": least(lambda: simulator.step(q, v, u), 50),
        "linearize": least(lambda: simulator.linearize(q, v, u), 50),
    }


def rollouts() -> dict[str, float]:
    """Nanoseconds a step of a batch."""
    simulator, rng = pole(), np.random.default_rng(0)
    starts, zeros = rng.uniform(-1, 1, (COUNT, 2)), np.zeros((COUNT, 2))
    inputs = rng.normal(size=(COUNT, STEPS, 2))

    def time(**given: Any) -> float:
        return min(seconds(lambda: simulator.rollout(starts, zeros, **given)) for _ in range(150)) * 1e9 / COUNT / STEPS

    return {"rollout": time(steps=STEPS), "rollout_of_inputs": time(inputs=inputs)}


def own() -> dict[str, float]:
    return arm() | steps() | rollouts()


def beside_rust(ours: dict[str, float], rust: dict[str, float]) -> None:
    for name, time in ours.items():
        other = rust[name.split(",")[0]]
        if name.startswith("rollout"):
            print(f"{name} of {COUNT} cart-poles, {STEPS} steps: {time:.2f} ns a step; Rust {other:.2f} ns, ratio {other / time:.2f}")
        else:
            print(f"{name:12} {time:9.0f} ns; Rust {other:7.0f} ns, overhead {time - other:7.0f} ns")


def beside_jaxsim(ours: dict[str, float], peer: dict[str, Any]) -> None:
    """Both engines compute the same numbers."""
    simulator = pole()
    np.testing.assert_allclose(np.concatenate(simulator.step([0.1, 0.2], [0.3, 0.4])), peer["next"], rtol=1e-6)
    a, b = simulator.linearize([0.1, 0.2], [0.3, 0.4])
    np.testing.assert_allclose(np.hstack([a, b]), np.hstack([peer["a"], peer["b"]]), rtol=1e-6, atol=1e-9)
    for name, other in (("step", "step"), ("linearize", "jacfwd")):
        ratio = ours[name] / peer[other]
        print(f"{name:12} beside jaxsim {peer['version']}, {other}: {ours[name]:.0f} / {peer[other]:.0f} ns, ratio {ratio:.5f}")


def start_up() -> str:
    """Least milliseconds in a new process: of the import, of NumPy's after it, of loading and simulating the cart-pole for 5 s."""
    runs = [output(sys.executable, "-c", LOAD_AND_SIMULATE, str(ASSETS / "cartpole.urdf")).split() for _ in range(15)]
    load, other, simulate = (min(float(run[k]) for run in runs) for k in range(3))
    return f"import {load:.0f} ms, of NumPy {other:.0f} ms more; load and simulate the cart-pole for 5 s {simulate:.1f} ms"


def regulated(k: int, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A linear law in Python, which the workers call at every step."""
    return np.clip(np.concatenate([q, v], axis=1) @ [[1.0], [60.0], [4.0], [12.0]], -20.0, 20.0)


def efficiency(work: Any, count: int, workers: int, shard: int = 256) -> tuple[float, float, float]:
    """Seconds of `count` states in this process on one thread, over Ray on so many workers of one thread, and the efficiency between them."""
    import dualbody.ray as dr

    for _ in dr.rollouts(work, workers * shard, shard=shard):
        pass  # workers are there, and have imported what they need
    begin = perf_counter()
    for first in range(0, count, shard):
        dr._run(work, 0, first, min(shard, count - first), None, 1)
    alone = perf_counter() - begin
    db.set_threads(0)
    begin = perf_counter()
    for _ in dr.rollouts(work, count, shard=shard):
        pass
    together = perf_counter() - begin
    return alone, together, alone / together / min(workers, os.cpu_count() or 1)


def over_ray() -> str:
    """Best of three: cart-poles of many masses under a control in Python, on two workers of one thread beside one process on one thread."""
    import ray

    sys.path.insert(0, str(HERE.parent / "examples"))
    import ray_domain_randomisation as example

    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, runtime_env={"env_vars": {"PYTHONPATH": ":".join(sys.path)}})
    work = replace(example.work(), control=regulated)
    runs = [efficiency(work, 8192, 2, 1024) for _ in range(3)]
    here, there, best = max(runs, key=lambda run: run[2])
    return f"ray: {here:.2f} s in one process on one thread, {there:.2f} s on two workers, efficiency {best:.2f}"


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--rust")
    parser.add_argument("--pinocchio")
    parser.add_argument("--jaxsim")
    parser.add_argument("--ray", action="store_true")
    options = parser.parse_args()
    print(f"dualbody {db.__version__}, {db.threads()} threads, load {Path('/proc/loadavg').read_text().strip()}")
    if options.rust:
        rust, ours = twice(lambda: of_rust(options.rust), own)
        beside_rust(ours, rust)
    if options.pinocchio:
        peer, ours = twice(lambda: of_peer(options.pinocchio, "peer_pinocchio.py", str(ASSETS / "panda.urdf")), arm)
        for name in ("rnea", "aba", "crba"):
            print(f"{name:12} beside pinocchio {peer['version']} (nv {peer['nv']}): {ours[name]:.0f} / {peer[name]:.0f} ns, ratio {ours[name] / peer[name]:.2f}")
    if options.jaxsim:
        peer, ours = twice(lambda: of_peer(options.jaxsim, "peer_jaxsim.py"), steps)
        beside_jaxsim(ours, peer)
    print(start_up())
    if options.ray:
        print(over_ray())


if __name__ == "__main__":
    main()
