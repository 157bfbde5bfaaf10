"""Graphs and C."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import SAME_ALGEBRA

import dualbody as db
from dualbody import codegen


def random(seed: int, *shape: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1, 1, shape)


def close(actual, expected) -> None:  # type: ignore[no-untyped-def]
    scale = max(1.0, np.abs(expected).max(initial=0))
    np.testing.assert_allclose(actual, expected, rtol=0, atol=SAME_ALGEBRA * scale)


ARM = db.samples.arm()
POLE = db.Simulator(db.samples.cartpole(), time_step=0.01)


def test_graphs_of_the_dynamics_evaluate_to_the_dynamics() -> None:
    x = random(0, 4, 21)
    q, v, a = x[:, :7], x[:, 7:14], x[:, 14:]
    close(codegen.inverse_dynamics(ARM).evaluate(x), db.inverse_dynamics(ARM, q, v, a))
    close(codegen.forward_dynamics(ARM).evaluate(x), db.forward_dynamics(ARM, q, v, a))
    close(codegen.mass_matrix(ARM).evaluate(q).reshape(4, 7, 7), db.mass_matrix(ARM, q))
    slopes = codegen.inverse_dynamics_derivatives(ARM).evaluate(x).reshape(4, 3, 7, 7)
    for k, expected in enumerate(db.inverse_dynamics_derivatives(ARM, q, v, a)):
        close(slopes[:, k], np.swapaxes(expected, -1, -2))


def test_graphs_of_a_step_evaluate_to_the_step_and_its_jacobians() -> None:
    x = random(1, 6)
    graph = codegen.step(POLE)
    assert [port[0] for port in graph.inputs] == ["q", "v", "u"] and [port[0] for port in graph.outputs] == ["q_next", "v_next"]
    close(graph.evaluate(x), np.concatenate(POLE.step(x[:2], x[2:4], x[4:])))
    jacobians = graph.jacobian(["v_next"], ["q", "v", "u"]).evaluate(x).reshape(6, 2).T
    a, b = POLE.linearize(x[:2], x[2:4], x[4:])
    close(jacobians, np.hstack([a[2:], b[2:]]))


def test_graphs_differentiate() -> None:
    x = random(2, 21)
    graph = codegen.inverse_dynamics(ARM)
    slopes = graph.jacobian(["tau"], ["a"]).evaluate(x).reshape(7, 7).T
    close(slopes, db.mass_matrix(ARM, x[:7]))
    weight = random(3, 7)
    adjoint = graph.adjoint(["a"])
    assert [port[0] for port in adjoint.inputs] == ["q", "v", "a", "tau_weight"]
    close(adjoint.evaluate(np.concatenate([x, weight])), db.mass_matrix(ARM, x[:7]) @ weight)
    with pytest.raises(KeyError, match="force"):
        graph.jacobian(["force"], ["a"])
    with pytest.raises(ValueError, match="^inputs has the shape"):
        graph.evaluate(x[:3])
    with pytest.raises(ValueError, match="one number"):
        graph.gradient("tau", ["a"])


def test_a_graph_knows_its_robot() -> None:
    graph = codegen.mass_matrix(ARM)
    graph.check_origin(ARM)
    with pytest.raises(ValueError, match="trace it again"):
        graph.check_origin(ARM.with_armature(0, 0.1))


def test_the_text_compiles_and_gives_the_same_numbers(tmp_path: Path) -> None:
    text = codegen.step(POLE).to_c("pole_step")
    assert "int pole_step(const pole_step_real *in, pole_step_real *out);" in text.header
    assert "#define POLE_STEP_IN_U 4" in text.header and text.name == "pole_step"
    text.save(tmp_path / "code")
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler `cc` here")
    library = tmp_path / "pole.so"
    command = [compiler, "-O1", "-shared", "-fPIC", "-o", str(library), str(tmp_path / "code" / "pole_step.c"), "-lm"]
    subprocess.run(command, check=True)
    function = ctypes.CDLL(str(library)).pole_step
    x, out = random(4, 6), np.empty(4)
    pointer = ctypes.POINTER(ctypes.c_double)
    assert function(x.ctypes.data_as(pointer), out.ctypes.data_as(pointer)) == 0
    close(out, np.concatenate(POLE.step(x[:2], x[2:4], x[4:])))


def stack() -> tuple[db.Simulator, np.ndarray]:
    """A ball over a box, with a state in which it is one millimetre deep."""
    world = db.World()
    world.add_box("box", (0.3, 0.2, 0.4), mass=2.0, position=(0, 0, 0))
    world.add_sphere("ball", 0.15, mass=1.0, position=(0.02, 0.01, 0.349))
    model = world.build()
    law = db.contact.SoftContact.estimate(1.0, 1, 1e-3)
    contacts = db.contact.Contacts(db.contact.Terrain.flat(-5.0), law, collisions=True)
    simulator = db.Simulator(model, time_step=1e-3, contacts=contacts)
    return simulator, random(4, model.nv)


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_bodies_that_touch_in_c_move_as_those_of_the_simulator(tmp_path: Path) -> None:
    simulator, v = stack()
    q = simulator.model.neutral()
    assert len(simulator.contact_report(q, v).pairs) == 1
    graph = codegen.step(simulator)
    contact = np.zeros(simulator.n_contact)
    expected = np.concatenate(simulator.step(q, v, contact=contact))
    state = np.concatenate([q, v, contact, np.zeros(simulator.nu)])
    close(graph.evaluate(state), expected)
    graph.to_c("stack").save(tmp_path)
    library = tmp_path / "stack.so"
    subprocess.run(["cc", "-O1", "-shared", "-fPIC", tmp_path / "stack.c", "-o", library, "-lm"], check=True)
    function = ctypes.CDLL(str(library)).stack
    own = np.zeros(len(expected))
    pointers = [x.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for x in (state, own)]
    assert function(*pointers) == 0
    close(own, expected)


def test_names_that_are_no_names_in_c_are_errors() -> None:
    graph = codegen.mass_matrix(db.samples.pendulum())
    with pytest.raises(ValueError, match="not an identifier of C"):
        graph.to_c("1st")
    with pytest.raises(ValueError, match="precision is \"half\", not \"double\" or \"single\""):
        graph.to_c("m", "half")  # type: ignore[arg-type]
    assert "float" in graph.to_c("m", "single").header
