"""Pickling, threads, processes, leaks, interrupts."""

from __future__ import annotations

import gc
import multiprocessing
import os
import pickle
import resource
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import ASSETS, asset

import dualbody as db
from dualbody.contact import Contacts, Rigid, Terrain
from dualbody.sim import Actuation


def quadruped_on_ground() -> db.Simulator:
    model = db.Model.from_urdf(asset("quadruped"))
    return db.Simulator(
        model, time_step=2e-3, contacts=Contacts(Terrain.flat(), Rigid(0.7)), actuation=Actuation("model")
    )


def standing(simulator: db.Simulator, n: int) -> tuple[np.ndarray, np.ndarray]:
    q = np.tile(simulator.model.neutral(), (n, 1))
    q[:, 2] = np.linspace(0.3, 0.6, n)
    return q, np.zeros((n, simulator.model.nv))


def test_models_pickle_with_all_that_was_changed() -> None:
    model = db.Model.from_urdf(asset("panda"), base="floating", gravity=(0, 0, -1.6), independent_mimic_joints=True)
    model = model.with_link_mass("panda_hand", 2.0).with_damping(7, 0.3).with_locked_joints({"panda_joint7": 0.2})
    model = model.with_attached(db.samples.pendulum(), "panda_hand", "p/").with_frame("tip", "p/world" if "p/world" in db.Model.frame_names.__get__(model) else model.frame_names[-1], (0, 0, 0.1))
    again = pickle.loads(pickle.dumps(model))
    np.testing.assert_array_equal(again.parameters, model.parameters)
    assert again.frame_names == model.frame_names and repr(again) == repr(model)
    q, v = model.random_configuration(1), model.random_velocity(2)
    np.testing.assert_array_equal(db.bias_forces(again, q, v), db.bias_forces(model, q, v))


def test_pickled_simulators_step_to_the_same_bits() -> None:
    simulator = quadruped_on_ground()
    again = pickle.loads(pickle.dumps(simulator))
    assert again.contact_points == simulator.contact_points and repr(again) == repr(simulator)
    q, v = standing(simulator, 3)
    one, other = simulator.rollout(q, v, steps=300), again.rollout(q, v, steps=300)
    np.testing.assert_array_equal(one.q, other.q)
    np.testing.assert_array_equal(one.v, other.v)


def test_rollouts_pickle_without_copies() -> None:
    rollout = quadruped_on_ground().rollout(*standing(quadruped_on_ground(), 9), steps=10)
    buffers: list[pickle.PickleBuffer] = []
    data = pickle.dumps(rollout, protocol=5, buffer_callback=buffers.append)
    again = pickle.loads(data, buffers=buffers)
    np.testing.assert_array_equal(again.q, rollout.q)
    assert again.status == rollout.status


def work(seed: int) -> bytes:
    model = db.Model.from_urdf(asset("cartpole"))
    simulator = db.Simulator(model, time_step=0.01)
    q = np.random.default_rng(seed).uniform(-1, 1, (200, 2))
    return simulator.rollout(q, np.zeros((200, 2)), steps=50).q.tobytes()


@pytest.mark.parametrize("method", ["fork", "spawn"])
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_processes_give_the_same_bits(method: str) -> None:
    expected = [work(seed) for seed in range(2)]  # the parent's threads exist when it forks
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map_async(work, range(2)).get(timeout=120) == expected


def test_simulators_are_shared_and_separate_in_threads() -> None:
    shared = quadruped_on_ground()
    q, v = standing(shared, 16)
    expected = shared.rollout(q, v, steps=60).q
    results: dict[int, list[bool]] = {}

    def run(k: int) -> None:
        own = quadruped_on_ground()
        same = []
        for simulator in (shared, own) * 2:
            same.append(np.array_equal(simulator.rollout(q, v, steps=60).q, expected))
            same.append(np.array_equal(simulator.step(q, v)[0], shared.rollout(q, v, steps=1).q[:, 1]))
        results[k] = same

    threads = [threading.Thread(target=run, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=120)
    assert len(results) == 4 and all(all(same) for same in results.values())


def test_rollouts_release_the_interpreter_lock() -> None:
    simulator = quadruped_on_ground()
    q, v = standing(simulator, 8)
    done = threading.Event()

    def run() -> None:
        simulator.rollout(q, v, steps=4000)
        done.set()

    thread = threading.Thread(target=run)
    thread.start()
    ticks = 0
    while not done.is_set():
        time.sleep(0.001)
        ticks += 1
    thread.join()
    assert ticks > 20, "Python runs while the rollout does"


def memory() -> int:
    """Memory of this process that is resident, bytes."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_a_million_calls_leak_nothing() -> None:
    model = db.samples.arm()
    simulator = db.Simulator(model)
    q, v = np.zeros(7), np.ones(7)
    as_list = [0.0] * 7

    def calls(n: int) -> None:
        for k in range(n):
            db.inverse_dynamics(model, q, v, v)
            if k % 10 == 0:
                simulator.step(q, v, v)
                db.gravity_forces(model, as_list)
            if k % 100 == 0:
                try:
                    db.mass_matrix(model, q[:3])
                except ValueError:
                    pass
            if k % 10_000 == 0:
                db.gravity_forces(db.samples.arm(), q)

    calls(100_000)
    gc.collect()
    before = memory()
    calls(900_000)
    gc.collect()
    assert memory() - before < 4_000_000


@pytest.mark.skipif(sys.platform != "linux", reason="sends a signal")
def test_ctrl_c_ends_a_long_rollout() -> None:
    code = f"""
import dualbody as db, numpy as np
model = db.Model.from_urdf({asset("cartpole")!r})
simulator = db.Simulator(model, time_step=1e-3)
print("go", flush=True)
try:
    simulator.rollout(np.zeros((8, 2)), np.zeros((8, 2)), steps=20_000_000 // 10)
    print("finished")
except KeyboardInterrupt:
    print("interrupted")
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env={**os.environ})
    assert process.stdout is not None
    assert process.stdout.readline() == "go\n"
    time.sleep(0.15)
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=60)[0] in ("interrupted\n", "finished\n")


SWING = """
import dualbody as db, numpy as np
from dualbody.trajopt import Ddp, Problem, SingleShooting, Term, StateError, Transcription
simulator = db.Simulator(db.Model.from_urdf({path!r}), time_step=1e-3)
# A cost that falls for ever, by little.
terms = [Term(1.0, StateError([0.3, 3.0, 0.0, 0.0]))]
problem = Problem(simulator, 400, [0, 0, 0, 0], stage_cost=terms, final_cost=terms)
endless = dict(max_iterations=10**9, tolerance=0.0)
print("go", flush=True)
try:
    {solve}
    print("finished")
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="sends a signal")
@pytest.mark.parametrize(
    "solve",
    [
        "Ddp(problem, **endless).solve()",
        "SingleShooting(problem, **endless).solve()",
        "SingleShooting(problem, **endless).solve(report=lambda *numbers: None)",
        "Transcription(problem, **endless).solve()",
    ],
)
def test_ctrl_c_ends_solvers(solve: str) -> None:
    code = SWING.format(path=asset("cartpole"), solve=solve)
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env={**os.environ})
    assert process.stdout is not None
    assert process.stdout.readline() == "go\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    started = time.monotonic()
    assert process.communicate(timeout=60)[0] in ("interrupted\n", "finished\n")
    # Much less on a machine that does nothing else.
    assert time.monotonic() - started < 10


def test_threads_can_be_chosen() -> None:
    before = db.threads()
    try:
        db.set_threads(1)
        assert db.threads() == 1
        one = work(3)
        db.set_threads(3)
        assert db.threads() == 3 and work(3) == one
    finally:
        db.set_threads(0)
    assert db.threads() == before
    assert ASSETS.exists()
