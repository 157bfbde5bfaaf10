"""Compiled steps beside the library's own."""

from __future__ import annotations

import os
import pickle
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import SAME_ALGEBRA, asset

import dualbody as db
from dualbody import codegen
from dualbody.contact import Contacts, Rigid
from dualbody.native import Compiler, NativeFunction, NativeSimulator

needs_compiler = pytest.mark.skipif(shutil.which(os.environ.get("CC", "cc").split()[0]) is None, reason="there is no C compiler here")
POLE = db.Simulator(db.samples.cartpole(), time_step=0.01)


@pytest.fixture
def compiler(tmp_path: Path) -> Compiler:
    return Compiler(flags=["-O1"], cache=tmp_path / "cache")


def close(actual: object, expected: object) -> None:
    scale = max(1.0, float(np.abs(np.asarray(expected)).max(initial=0)))
    np.testing.assert_allclose(actual, expected, rtol=0, atol=10 * SAME_ALGEBRA * scale)  # type: ignore[arg-type]


@needs_compiler
def test_steps_and_jacobians_are_those_of_the_simulator(compiler: Compiler) -> None:
    native = NativeSimulator(POLE, compiler)
    assert native.reason is None and native.simulator is POLE and "NativeSimulator" in repr(native)
    x = np.random.default_rng(0).normal(size=(70, 6))
    q, v, u = x[:, :2], x[:, 2:4], x[:, 4:]
    for given in ((q, v, u), (q[0], v[0], u[0]), (q[0], v[0])):
        for one, other in zip(native.step(*given), POLE.step(*given), strict=True):
            close(one, other)
        for one, other in zip(native.linearize(*given), POLE.linearize(*given), strict=True):
            np.testing.assert_array_equal(one, other)
    out = np.empty(2), np.empty(2)
    assert native.step(q[0], v[0], u[0], out=out)[0] is out[0]
    close(out[1], POLE.step(q[0], v[0], u[0])[1])
    assert native.step(np.empty((0, 2)), np.empty((0, 2)))[0].shape == (0, 2)
    with pytest.raises(ValueError, match="^q has the shape"):
        native.step([0.0], [0.0, 0.0])


@needs_compiler
def test_a_robot_with_a_floating_base_and_threads(compiler: Compiler) -> None:
    simulator = db.Simulator(db.Model.from_urdf(asset("quadruped")), time_step=1e-3)
    native, model = NativeSimulator(simulator, compiler), simulator.model
    states = [(model.random_configuration(k), model.random_velocity(k)) for k in range(4)]
    found: dict[int, tuple[np.ndarray, ...]] = {}

    def work(k: int) -> None:
        for _ in range(50):
            found[k] = native.step(*states[k])

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k in range(4):
        for one, other in zip(found[k], simulator.step(*states[k]), strict=True):
            close(one, other)


@needs_compiler
def test_rollouts_are_those_of_the_simulator(compiler: Compiler) -> None:
    native = NativeSimulator(POLE, compiler)
    inputs = np.random.default_rng(3).normal(size=(50, 2))
    for steps in (50, 2000):
        given = np.resize(inputs, (steps, 2))
        one, other = (own.rollout([0.1, 0.2], [0.3, 0.4], inputs=given) for own in (native, POLE))
        assert one.status.is_completed and one.q.shape == (steps + 1, 2)
        np.testing.assert_allclose(one.q[:51], other.q[:51], rtol=0, atol=1e-11)
        np.testing.assert_array_equal(one.u, given)
    seen: list[int] = []

    def control(k: int, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        seen.append(k)
        return -3.0 * q - v

    one, other = (own.rollout([0.1, 0.2], [0.3, 0.4], 20, control=control) for own in (native, POLE))
    assert seen == 2 * list(range(20))
    np.testing.assert_allclose(one.u, other.u, rtol=0, atol=1e-11)
    for q in ([[0.1, 0.2]], np.zeros((3, 2))):
        with pytest.raises(ValueError, match="one state"):
            native.rollout(q, np.zeros_like(q), 5)
    with pytest.raises(ValueError, match="both given"):
        native.rollout([0.0, 0.0], [0.0, 0.0], inputs=inputs, control=control)
    with pytest.raises(ValueError, match="steps"):
        native.rollout([0.0, 0.0], [0.0, 0.0])


@needs_compiler
def test_it_pickles_and_nothing_is_compiled_twice(compiler: Compiler) -> None:
    native = NativeSimulator(POLE, compiler)
    kept = sorted(Path(str(compiler.cache)).iterdir())
    again = pickle.loads(pickle.dumps(native))
    assert sorted(Path(str(compiler.cache)).iterdir()) == kept and len(kept) == 1
    for one, other in zip(again.step([0.1, 0.2], [0.3, 0.4]), native.step([0.1, 0.2], [0.3, 0.4]), strict=True):
        np.testing.assert_array_equal(one, other)


@needs_compiler
def test_graphs_become_functions(compiler: Compiler) -> None:
    graph = codegen.step(POLE)
    function = NativeFunction(graph, "pole", compiler)
    x = np.random.default_rng(1).normal(size=(2, 3, 6))
    assert (function.n_inputs, function.n_outputs) == (6, 4)
    close(function(x), graph.evaluate(x))
    with pytest.raises(ValueError, match="^inputs has the shape"):
        function(x[..., :3])
    with pytest.raises(ValueError, match="not an identifier of C"):
        NativeFunction(graph, "1st", compiler)
    with pytest.raises(OSError, match="refuses its flags"):
        NativeFunction(graph, "pole", Compiler(flags=["-fno-such-thing-at-all"], cache=compiler.cache))


def test_without_a_compiler_it_says_so(tmp_path: Path) -> None:
    none = Compiler("no-such-compiler", cache=tmp_path)
    with pytest.raises(FileNotFoundError, match='the C compiler "no-such-compiler" does not run'):
        NativeSimulator(POLE, none)
    own = NativeSimulator.or_own(POLE, none)
    assert own.reason is not None and "no-such-compiler" in own.reason and "not compiled" in repr(own)
    for one, other in zip(own.step([0.1, 0.2], [0.3, 0.4]), POLE.step([0.1, 0.2], [0.3, 0.4]), strict=True):
        np.testing.assert_array_equal(one, other)
    again = pickle.loads(pickle.dumps(own))
    assert again.reason == own.reason
    with pytest.raises(ValueError, match="empty"):
        NativeSimulator(POLE, Compiler(""))


def test_a_step_that_decides_on_values_is_an_error(tmp_path: Path) -> None:
    touching = db.Simulator(db.Model.from_urdf(asset("quadruped")), time_step=1e-3, contacts=Contacts(law=Rigid()))
    with pytest.raises(ValueError):
        NativeSimulator.or_own(touching, Compiler(cache=tmp_path))


#: A compiler that starts a process, as compilers do, which writes into a file for ever.
ENDLESS = """#!/bin/sh
case "$*" in *-dM*) exit 0;; esac
: > half.o
while :; do echo tick >> '{ticks}'; sleep 0.02; done &
wait
"""

COMPILE = """
import dualbody as db
from dualbody import codegen
from dualbody.native import Compiler, NativeFunction, NativeSimulator
pole = db.Simulator(db.samples.cartpole(), time_step=0.01)
compiler = Compiler({command!r}, cache={cache!r})
try:
    {make}
    print("finished")
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="sends a signal")
@pytest.mark.parametrize(
    ("make", "end"),
    [
        ("NativeFunction(codegen.step(pole), 'pole', compiler)", signal.SIGINT),
        ("NativeSimulator(pole, compiler)", signal.SIGINT),
        ("NativeSimulator.or_own(pole, compiler)", signal.SIGINT),
        ("NativeSimulator(pole, compiler)", signal.SIGKILL),
    ],
)
def test_ctrl_c_and_the_end_of_the_program_end_compilers(tmp_path: Path, make: str, end: signal.Signals) -> None:
    script, ticks, cache = (tmp_path / name for name in ("cc", "ticks", "cache"))
    script.write_text(ENDLESS.format(ticks=ticks))
    script.chmod(0o700)
    code = COMPILE.format(command=str(script), cache=str(cache), make=make)
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env={**os.environ})
    while not ticks.exists() and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(end)
    started = time.monotonic()
    said = process.communicate(timeout=60)[0]
    # Much less on a machine that does nothing else.
    assert time.monotonic() - started < 10
    if end == signal.SIGINT:
        assert said == "interrupted\n" and list(cache.iterdir()) == []
    else:
        time.sleep(1.0)
    left = ticks.stat().st_size
    time.sleep(0.3)
    assert ticks.stat().st_size == left > 0
