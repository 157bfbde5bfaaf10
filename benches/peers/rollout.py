"""Steps a second of MuJoCo's threaded rollout on the robots of `benches/batch.rs`, beside those of this crate.

    cargo bench --bench batch
    python benches/peers/rollout.py [TARGET]   # where cargo builds: target; needs the package mujoco, 4.0 or newer

Same robots (in the MJCF that this crate writes), time step, number of states, steps and threads; contacts, limits and friction
off, forward dynamics and semi-implicit Euler only; both keep all states, in memory that is used again. Best of many rounds against
criterion's fastest sample.
"""

import json
import math
import pathlib
import sys
import time

import mujoco
from mujoco import rollout
import numpy as np

STATES, STEPS, THREADS, ROUNDS = 1024, 100, 2, 10
TARGET = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2] / "target")
ROBOTS = ["cartpole", "ur5", "humanoid"]


def peer(path):
    """Best rate over some rounds, in steps a second."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep = 1e-3
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    # Damping is explicit with us: the implicit kind would be more work.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_EULERDAMP
    data = [mujoco.MjData(model) for _ in range(THREADS)]
    spec = mujoco.mjtState.mjSTATE_FULLPHYSICS
    initial = np.zeros((STATES, mujoco.mj_stateSize(model, spec)))
    for k in range(STATES):
        mujoco.mj_resetData(model, data[0])
        dv = np.array([0.2 * math.sin(1 + k * (2 * j + 3)) for j in range(model.nv)])
        mujoco.mj_integratePos(model, data[0].qpos, dv, 1.0)
        mujoco.mj_getState(model, data[0], initial[k], spec)
    out = np.zeros((STATES, STEPS, initial.shape[1]))
    best = math.inf
    with rollout.Rollout(nthread=THREADS) as threads:
        for _ in range(ROUNDS):
            start = time.perf_counter()
            threads.rollout(model, data, initial, nstep=STEPS, state=out, sensordata=None)
            best = min(best, time.perf_counter() - start)
    assert np.isfinite(out).all()
    return STATES * STEPS / best


def own(robot):
    """Rate of the fastest sample of the bench, in steps a second."""
    path = TARGET / "criterion" / "batch_rollout" / robot / "new" / "sample.json"
    sample = json.loads(path.read_text())
    best = min(t / n for t, n in zip(sample["times"], sample["iters"]))
    return STATES * STEPS / (best * 1e-9)


rates = [(own(robot), peer(TARGET / "tmp" / f"{robot}.xml")) for robot in ROBOTS]
print(f"{STATES} states × {STEPS} steps on {THREADS} threads, million steps/s ours / MuJoCo = **ratio**")
print()
print("| " + " | ".join(ROBOTS) + " |")
print("|---" * len(ROBOTS) + "|")
print("| " + " | ".join(f"{a * 1e-6:.3g} / {b * 1e-6:.3g} = **{a / b:.1f}**" for a, b in rates) + " |")
