"""What a newcomer may get wrong: each mistake is an exception that names it, and nothing hangs, aborts, or is lost without a word."""

from __future__ import annotations

import copy
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import dualbody as db
from dualbody import codegen, trajopt
from dualbody.contact import HeightField
from dualbody.model import JointSpec, Sphere
from dualbody.sim import Activation, Anchor
from dualbody.trajopt import Ddp, Dynamics, Problem, RecedingHorizon, Residual, Term

PENDULUM = db.samples.pendulum()
ACTUATED = db.Simulator(PENDULUM, time_step=0.01)
PASSIVE = db.Simulator(PENDULUM, time_step=0.01, actuated=[])
HUGE = 10**15


def fails(*_: Any) -> Any:
    raise RuntimeError("a mistake")


def problem(*terms: Term) -> Problem:
    return Problem(ACTUATED, 10, [0.1, 0.0], terms)


NUMBER = np.zeros(1)
MASKED = np.ma.masked_array([1.0], mask=[True])
ARM = db.samples.arm()


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda: db.gravity_forces(PENDULUM, None), TypeError, "^q is of the type NoneType, expected an array of numbers"),
        (lambda: db.gravity_forces(PENDULUM, {0: 1.0}), TypeError, "^q is of the type dict"),
        (lambda: db.gravity_forces(PENDULUM, MASKED), ValueError, "^q has masked entries"),
        (lambda: ACTUATED.step(MASKED, [0.0]), ValueError, "^q has masked entries"),
        (lambda: ACTUATED.step([0.0], [0.0], out=(NUMBER, NUMBER)), ValueError, r"^out\[1\] overlaps another"),
        (lambda: ACTUATED.step([0.0], [0.0], forces=[1.0]), TypeError, "^forces is of the type list"),
        (lambda: db.EngineCoordinates(ARM, "mujoco").jacobian_to(ARM.neutral(), np.zeros((2, 6))), ValueError, "^jacobian has the shape"),
        (lambda: codegen.mass_matrix(ARM).gradient("M", ["q"]), ValueError, "^a gradient is that of an output of one number$"),
        (lambda: db.sim.set_threads(10**9), ValueError, "^threads is 1000000000, expected at most"),
        (lambda: Ddp(problem(Term(1.0, Residual(HUGE, fails, fails)))).solve(), MemoryError, "^Jacobians of a residual"),
        (lambda: Ddp(problem(Term(1.0, trajopt.InputError(), trajopt.Activation.weighted([1, 2, 3])))).solve(), ValueError, "activation 3"),
        (lambda: Ddp(Problem(Dynamics(1, 2**62, fails, fails), 5, [0.0])).solve(), MemoryError, "set_memory_limit"),
        (lambda: Ddp(Problem(Dynamics(0, 1, fails, fails), 5, [])).solve(), ValueError, "^nx is 0"),
        (lambda: Ddp(Problem(ACTUATED, 5, [np.nan, 0.0])).solve(), ValueError, r"^start\[0\] is NaN"),
        (lambda: db.identify.excite(db.identify.Regressor(PENDULUM), harmonics=HUGE), ValueError, "limit is .*: set_memory_limit changes it"),
    ],
)
def test_mistakes_are_exceptions_that_name_them(call: Callable[[], Any], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        call()


def test_arrays_of_subclasses_are_their_numbers() -> None:
    expected = db.gravity_forces(PENDULUM, [0.3])
    for q in (np.ma.masked_array([0.3]), np.array([0.3]).view(np.recarray), np.array([0.3], ">f8"), np.array([0.3, 9.0])[::2]):
        np.testing.assert_array_equal(db.gravity_forces(PENDULUM, q), expected)
    assert db.EngineCoordinates(ARM, "mujoco").jacobian_to(ARM.neutral(), np.zeros((0, 7))).shape == (0, 7)


@pytest.mark.parametrize("name", [entry[0] for entry in db._dualbody._table() if not entry[4]])
def test_no_mistake_in_an_argument_is_a_panic(name: str) -> None:
    function = getattr(db._dualbody, name)
    _, vectors, option, keywords, _ = next(entry for entry in db._dualbody._table() if entry[0] == name)
    right = dict.fromkeys(vectors, np.zeros(7)) | {key: default or {"frame": "tool"}.get(key, "mixed") for key, default in keywords}
    if name == "mass_matrix_to_representation":
        right["mass_matrix"] = np.eye(7)
    wrong = (None, "x", 1j, np.zeros(3), np.zeros((0, 9)), [[0.0], [0.0, 1.0]], np.full(7, np.nan), np.full(7, 1e308), object(), -1, HUGE)
    for argument in (*vectors, option, *(key for key, _ in keywords)):
        for value in wrong if argument else ():
            try:
                function(ARM, **(right | {argument: value}))
            except (ValueError, TypeError, KeyError):
                pass


def test_exceptions_of_a_control_end_the_rollout_at_once() -> None:
    for simulator in (ACTUATED, PASSIVE):
        asked: list[int] = []

        def control(k: int, q: Any, v: Any, asked: list[int] = asked) -> Any:
            asked.append(k)
            return fails()

        with pytest.raises(RuntimeError, match="a mistake"):
            simulator.rollout([0.0], [0.0], 100_000, control=control)
        assert asked == [0]


INTERRUPTED = """
import sys, numpy as np, dualbody as db
simulator = db.Simulator(db.samples.pendulum(), time_step=1e-3, actuated=[])
q = np.zeros({shape})
try:
    print("begins", flush=True)
    simulator.rollout(q, q, {steps})
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.parametrize(("shape", "steps"), [((1,), 5_000_000), ((16, 1), 500_000)])
def test_control_c_ends_rollouts_without_inputs(shape: tuple[int, ...], steps: int) -> None:
    code = INTERRUPTED.format(shape=shape, steps=steps)
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "begins\n"
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=60)[0] == "interrupted\n"


def test_control_c_while_arrays_are_first_used_is_an_interrupt() -> None:
    """The crate of arrays looks for NumPy at its first array; an interrupt in there was a `ValueError`."""
    code = (
        "import dualbody as db, numpy\n"
        "from numpy.lib import NumpyVersion\n"
        "def interrupt(*_):\n    raise KeyboardInterrupt\n"
        "NumpyVersion.__init__ = interrupt\n"
        "try:\n    db.mass_matrix(db.samples.pendulum(), [0.3])\n"
        "except KeyboardInterrupt:\n    print('interrupted')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout == "interrupted\n", done.stderr


RECEDING = """
import dualbody as db
from dualbody.trajopt import Problem, RecedingHorizon, Residual, Term
residual = Residual(1, lambda x, u: [x[0]], lambda x, u: ([[1.0, 0.0]], [[0.0]]))
simulator = db.Simulator(db.samples.pendulum(), time_step=0.01)
controller = RecedingHorizon(Problem(simulator, 20, [0.1, 0.0], [Term(1.0, residual)]), max_iterations=2, threads=4)
print(controller.control([0.1], [0.0]).shape)
"""


def test_receding_horizons_call_functions_of_python_from_threads() -> None:
    done = subprocess.run([sys.executable, "-c", RECEDING], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout == "(1,)\n"


def test_a_controller_that_is_asked_by_its_own_residual_says_so() -> None:
    def asks(x: Any, u: Any) -> Any:
        return controllers[0].control([0.1], [0.0])

    controllers: list[RecedingHorizon] = []
    terms = [Term(1.0, Residual(1, lambda x, u: asks(x, u) if controllers else [0.0], lambda x, u: ([[0.0, 0.0]], [[0.0]])))]
    controllers.append(RecedingHorizon(problem(*terms), threads=1))
    with pytest.raises(RuntimeError, match="in use by another call"):
        controllers[0].control([0.1], [0.0])


@pytest.mark.parametrize(
    "value",
    [
        HeightField((0.0, 0.0), (1.0, 1.0), np.zeros((3, 3))),
        Anchor("hand", np.eye(4)),
        Sphere(0.1, placement=np.eye(4)),
        JointSpec("joint", "revolute", "a", "b", np.eye(4)),
        trajopt.StateError(np.zeros(2)),
        db.Lqr.discrete(np.eye(2), np.eye(2), np.eye(2), np.eye(2)),
        ACTUATED.rollout([0.1], [0.0], 3, control=lambda k, q, v: [np.nan]),
    ],
    ids=lambda value: type(value).__name__,
)
def test_values_with_arrays_are_equal_to_their_copies(value: Any) -> None:
    for again in (copy.deepcopy(value), pickle.loads(pickle.dumps(value))):
        assert value == again and not value != again
    assert value != 1 and value != None and not value == np.zeros(3)  # noqa: E711


def test_worlds_pickle() -> None:
    world = db.World("cell")
    world.add(ARM, prefix="left/", position=(-0.4, 0, 0.7))
    world.add_sphere("ball", 0.05, mass=0.2, position=(0, 0, 1))
    again = pickle.loads(pickle.dumps(world))
    assert again.members == world.members and again.build() == copy.deepcopy(world).build() == world.build()
    again.remove("ball")
    assert len(world.members) == 2


def test_jax_takes_the_states_of_activations() -> None:
    pytest.importorskip("jax").config.update("jax_enable_x64", True)
    from dualbody import jax

    simulator = ACTUATED.replace(activations={ACTUATED.input_names[0]: Activation("filter", 0.1)})
    x = [np.array([0.3]), np.array([0.1]), np.array([2.0])]
    for state in ([0.0], [0.7]):
        expected = simulator.acceleration(*x, contact=state)
        np.testing.assert_allclose(jax.acceleration(simulator, *x, contact=np.array(state)), expected, atol=1e-12)
    assert not np.allclose(jax.acceleration(simulator, *x), expected)
