"""Times of the package: what a call costs beside Rust and beside other engines.

    python benches/table.py [--pinocchio PYTHON] [--rust FILE]

--pinocchio: an interpreter that has Pinocchio; --rust: a file with lines "name nanoseconds" that the example of the same quantities in Rust
printed (see rust.rs beside this file). Each figure is the least of several runs.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PANDA = ROOT / "assets" / "panda.urdf"

OTHER_ENGINE = """
import json, sys, time
import numpy as np, pinocchio as pin
model = pin.buildModelFromUrdf(sys.argv[1])
data = model.createData()
rng = np.random.default_rng(0)
q, v, a = pin.randomConfiguration(model), rng.normal(size=model.nv), rng.normal(size=model.nv)
best = {}
for name, call in (("rnea", lambda: pin.rnea(model, data, q, v, a)), ("aba", lambda: pin.aba(model, data, q, v, a)), ("crba", lambda: pin.crba(model, data, q))):
    times = []
    for _ in range(60):
        begin = time.perf_counter()
        for _ in range(5000): call()
        times.append((time.perf_counter() - begin) / 5000)
    best[name] = min(times) * 1e9
print(json.dumps({"version": pin.__version__, "nv": model.nv, **best}))
"""


def least(call, number: int, repeat: int = 60) -> float:  # type: ignore[no-untyped-def]
    """Nanoseconds of a call."""
    times = []
    for _ in range(repeat):
        begin = time.perf_counter()
        for _ in range(number):
            call()
        times.append((time.perf_counter() - begin) / number)
    return min(times) * 1e9


def imported() -> tuple[float, float, float]:
    """Milliseconds in a new process: of `import dualbody`, of `import numpy` after it, and of loading and simulating the cart-pole for 5 s."""
    code = f"""
import time
t0 = time.perf_counter()
import dualbody as db
t1 = time.perf_counter()
import numpy
t2 = time.perf_counter()
model = db.Model.from_urdf({str(ROOT / "assets" / "cartpole.urdf")!r})
rollout = db.Simulator(model, time_step=0.01).rollout([0.0, 0.1], [0.0, 0.0], steps=500)
assert rollout.is_completed
print((t1 - t0) * 1e3, (t2 - t1) * 1e3, (time.perf_counter() - t2) * 1e3)
"""
    runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(15)]
    times = [tuple(map(float, run.stdout.split())) for run in runs]
    load, other, simulate = (min(t[k] for t in times) for k in range(3))
    return load, other, simulate


def main() -> None:
    import numpy as np

    import dualbody as db

    parser = argparse.ArgumentParser()
    parser.add_argument("--pinocchio")
    parser.add_argument("--rust", type=Path)
    options = parser.parse_args()
    rust = dict(line.split() for line in options.rust.read_text().splitlines()) if options.rust else {}

    model = db.Model.from_urdf(PANDA, base="fixed", independent_mimic_joints=True)
    rng = np.random.default_rng(0)
    q, v, a = model.random_configuration(0), rng.normal(size=model.nv), rng.normal(size=model.nv)
    out, matrix = np.empty(model.nv), np.empty((model.nv, model.nv))
    calls = {
        "rnea": lambda: db.inverse_dynamics(model, q, v, a),
        "rnea, out": lambda: db.inverse_dynamics(model, q, v, a, out=out),
        "aba": lambda: db.forward_dynamics(model, q, v, a),
        "crba": lambda: db.mass_matrix(model, q),
        "crba, out": lambda: db.mass_matrix(model, q, out=matrix),
    }
    print(f"panda, nv = {model.nv}; dualbody {db.__version__}, {db.threads()} threads, load {Path('/proc/loadavg').read_text().strip()}")
    ours = {name: least(call, 5000) for name, call in calls.items()}
    for name, time_ns in ours.items():
        own = float(rust.get(name.split(",")[0], "nan"))
        print(f"{name:12} {time_ns:9.0f} ns; Rust {own:7.0f} ns, overhead {time_ns - own:7.0f} ns")
    if options.pinocchio:
        run = subprocess.run([options.pinocchio, "-c", OTHER_ENGINE, str(PANDA)], capture_output=True, text=True, check=True)
        other = json.loads(run.stdout)
        for name in ("rnea", "aba", "crba"):
            print(f"{name:12} beside pinocchio {other['version']} (nv {other['nv']}): {other[name]:.0f} ns, ratio {ours[name] / other[name]:.2f}")

    cartpole = db.Model.from_urdf(ROOT / "assets" / "cartpole.urdf")
    simulator = db.Simulator(cartpole, time_step=0.01)
    x, w, u = np.array([0.1, 0.2]), np.array([0.3, 0.4]), np.zeros(2)
    print(f"step of the cart-pole {least(lambda: simulator.step(x, w, u), 5000):.0f} ns, Rust {rust.get('step', 'nan')} ns")
    print(f"linearize of the cart-pole {least(lambda: simulator.linearize(x, w, u), 2000):.0f} ns, Rust {rust.get('linearize', 'nan')} ns")

    n, steps = 4096, 200
    starts, zeros = rng.uniform(-1, 1, (n, 2)), np.zeros((n, 2))
    inputs = rng.normal(size=(n, steps, 2))
    for name, given in (("rollout", {"steps": steps}), ("rollout of inputs", {"inputs": inputs})):
        best = min(timed(lambda given=given: simulator.rollout(starts, zeros, **given)) for _ in range(25))
        own = float(rust.get(name.replace(" ", "_"), "nan"))
        print(f"{name} of {n} cart-poles, {steps} steps: {best / n / steps:.1f} ns a step; Rust {own:.1f} ns, ratio {own / (best / n / steps):.2f}")
    load, other, simulate = imported()
    print(f"import {load:.0f} ms, of NumPy {other:.0f} ms more; load and simulate the cart-pole for 5 s {simulate:.1f} ms")


def timed(call) -> float:  # type: ignore[no-untyped-def]
    begin = time.perf_counter()
    call()
    return (time.perf_counter() - begin) * 1e9


if __name__ == "__main__":
    main()
