"""Every function of the table on NumPy's arrays, under JAX and under PyTorch: values against each other, derivatives against differences of NumPy's values.

`python tests/test_table.py` prints the table of what was compared.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import dualbody as db
from dualbody import _dualbody
from dualbody.contact import Contacts, SoftContact

#: A floating base that stands on a ball, with two joints.
URDF = """<robot name="leaning">
  <link name="base"><inertial><origin xyz="0.01 0.02 0.03"/><mass value="2"/><inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0.001" ixz="0" iyz="0.002"/></inertial>
    <collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="upper"><inertial><origin xyz="0 0 0.1"/><mass value="0.7"/><inertia ixx="0.01" iyy="0.012" izz="0.003" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="hand"><inertial><origin xyz="0.05 0 0"/><mass value="0.3"/><inertia ixx="0.001" iyy="0.002" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0.05 0.1" rpy="0.3 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="10" velocity="10"/><dynamics damping="0.2"/></joint>
  <joint name="wrist" type="prismatic"><parent link="upper"/><child link="hand"/><origin xyz="0 0 0.2"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="10"/></joint>
</robot>"""
MODEL = db.Model.from_urdf(URDF, base="floating")
SIMULATOR = db.Simulator(MODEL, time_step=1e-3, contacts=Contacts(law=SoftContact(0.5, 1e4, 1e2)))
SAME, DIFFERENCES = 1e-9, 2e-6

#: Values of what functions take by name.
NAMES = {"frame": "hand", "representation": "mixed", "base": "mixed"}

#: Functions without derivatives.
VALUES_ONLY = {"_integrate_jacobian", "_difference_jacobian", "inverse_dynamics_second_derivatives"}

ENTRIES = [entry for entry in _dualbody._table() if entry[0] not in ("step", "rollout")]
STEPS = [entry for entry in _dualbody._table() if entry[0] in ("step", "rollout")]


def random(seed: int, *shape: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1, 1, shape)


def is_configuration(name: str) -> bool:
    return name in ("q", "q0", "q1")


def vectors(entry: Any, seed: int) -> list[np.ndarray]:
    """A row of each vector of a function."""
    of = SIMULATOR if entry[4] else MODEL
    names = [*entry[1], *([entry[2]] if entry[2] else [])]
    shapes, _ = _dualbody._signature(of, entry[0], len(names), False, 3)
    out = []
    for k, (name, shape) in enumerate(zip(names, shapes, strict=True)):
        x = random(seed + k, *shape)
        if is_configuration(name):
            x = MODEL.random_configuration(seed + k)
            x[:3] = [0.1 * x[0], 0.1 * x[1], 0.098]
        if name == "contact":
            x = 1e-4 * x
        out.append(x)
    return out


def keywords(entry: Any) -> dict[str, str]:
    momentum = {"frame": "world"} if entry[0].endswith(("momentum", "momentum_matrix", "inertia", "average_velocity", "velocity_jacobian")) else {}
    if "_frame_" in entry[0] or entry[0].startswith("frame_"):
        momentum = {}
    return {name: (NAMES | momentum)[name] for name, _ in entry[3]}


def on_numpy(entry: Any, x: list[np.ndarray], parameters: np.ndarray | None = None) -> list[np.ndarray]:
    """The function of the package on one row, of the robot or of one with other parameters."""
    model, simulator = MODEL, SIMULATOR
    if parameters is not None and entry[4]:
        simulator = SIMULATOR.with_parameters(np.concatenate([parameters, SIMULATOR.parameters[len(parameters) :]]))
    elif parameters is not None:
        model = MODEL.with_parameters(parameters)
    name, arguments, option, *_ = entry
    options = {} if option is None else {option: x[len(arguments)]}
    named = keywords(entry)
    if name in ("integrate", "difference"):
        return [getattr(model, name)(*x)]
    if not entry[4]:
        return [getattr(_dualbody, name)(model, *x[: len(arguments)], **options, **named)]
    if name == "rollout":
        out = simulator.rollout(x[0], x[1], inputs=x[2], **options)
        return [out.q, out.v, out.contact]
    if name == "contact_forces":
        return [simulator.contact_report(*x[: len(arguments)], **options).forces]
    found = getattr(simulator, name)(*x[: len(arguments)], **options, **named)
    return list(found) if name == "step" else [found]


def directions(entry: Any, x: list[np.ndarray], seed: int) -> tuple[list[np.ndarray], Callable[[float], list[np.ndarray]]]:
    """Changes of the vectors, and the vectors moved along them."""
    names = [*entry[1], *([entry[2]] if entry[2] else [])]
    along = [random(seed + k, MODEL.nv) if is_configuration(name) else random(seed + k, *own.shape) for k, (name, own) in enumerate(zip(names, x, strict=True))]
    scale = [1e-4 if name == "contact" else 1.0 for name in names]
    changes = [
        _dualbody._integrate_jacobian(MODEL, own) @ dx if is_configuration(name) else s * dx
        for name, own, dx, s in zip(names, x, along, scale, strict=True)
    ]

    def moved(h: float) -> list[np.ndarray]:
        return [
            MODEL.integrate(own, h * dx) if is_configuration(name) else own + h * s * dx
            for name, own, dx, s in zip(names, x, along, scale, strict=True)
        ]

    return changes, moved


def close(actual: Any, expected: Any, tolerance: float) -> None:
    for one, other in zip(actual, expected, strict=True):
        one, other = np.asarray(one), np.asarray(other)
        np.testing.assert_allclose(one, other, rtol=0, atol=tolerance * max(1.0, np.abs(other).max(initial=0)))


class Jax:
    def __init__(self) -> None:
        jax = pytest.importorskip("jax")
        jax.config.update("jax_enable_x64", True)
        jax.config.update("jax_platforms", "cpu")
        import dualbody.jax as own

        self.own, self.array, self.vmap = own, jax.numpy.asarray, jax.vmap
        self.jvp = lambda f, x, dx: jax.jit(lambda x, dx: jax.jvp(f, tuple(x), tuple(dx)))(x, dx)
        self.slopes = lambda f, x, w: jax.jit(lambda x: jax.vjp(f, *x)[1](tuple(w)))(x)
        self.jacobians = lambda f, x: [jax.jit(of(f, argnums=tuple(range(len(x)))))(*x) for of in (jax.jacfwd, jax.jacrev)]


class Torch:
    def __init__(self) -> None:
        torch = pytest.importorskip("torch")
        import dualbody.torch as own

        self.own, self.array, self.vmap = own, torch.as_tensor, torch.func.vmap
        self.jvp = lambda f, x, dx: torch.func.jvp(f, tuple(x), tuple(dx))
        self.slopes = lambda f, x, w: torch.func.vjp(f, *x)[1](tuple(w))
        self.jacobians = lambda f, x: [of(f, argnums=tuple(range(len(x))))(*x) for of in (torch.func.jacfwd, torch.func.jacrev)]


def function(library: Any, entry: Any) -> Callable[..., Any]:
    """A function of vectors, and of parameters that come last if there are more; a tuple."""
    name, arguments, option, _, is_of_simulator = entry
    call = getattr(library.own, name)
    names = [*arguments, *([option] if option else []), "parameters"]

    def f(*x: Any) -> Any:
        out = call(SIMULATOR if is_of_simulator else MODEL, **dict(zip(names, x)), **keywords(entry))
        return out if isinstance(out, tuple) else (out,)

    return f


def compare(library: Any, entry: Any) -> None:
    """Values and a batch of them, changes, slopes."""
    f, x = function(library, entry), vectors(entry, 10)
    given = [library.array(own) for own in x]
    close(f(*given), on_numpy(entry, x), SAME)
    rows = [vectors(entry, seed) for seed in (10, 30, 50)]
    batch = [np.stack(all_rows) for all_rows in zip(*rows, strict=True)]
    together = library.vmap(f)(*map(library.array, batch))
    close(together, f(*map(library.array, batch)), SAME)
    for k, row in enumerate(rows):
        close([own[k] for own in together], on_numpy(entry, row), SAME)
    if entry[0] in VALUES_ONLY:
        return
    changes, moved = directions(entry, x, 70)
    h = 1e-6
    own = [(a - b) / (2 * h) for a, b in zip(on_numpy(entry, moved(h)), on_numpy(entry, moved(-h)), strict=True)]
    dx = [library.array(change) for change in changes]
    _, found = library.jvp(f, given, dx)
    close(found, own, DIFFERENCES)
    weights = [library.array(random(90 + k, *np.asarray(y).shape)) for k, y in enumerate(found)]
    slopes = library.slopes(f, given, weights)
    one = sum(float((np.asarray(w) * np.asarray(y)).sum()) for w, y in zip(weights, found, strict=True))
    other = sum(float((np.asarray(s) * np.asarray(d)).sum()) for s, d in zip(slopes, dx, strict=True))
    assert abs(one - other) < SAME * max(1.0, abs(one))


def compare_parameters(library: Any, entry: Any) -> None:
    """Changes and slopes in parameters of the robot, alone and with those in the vectors."""
    f, x = function(library, entry), vectors(entry, 10)
    p, dp = MODEL.parameters, 0.1 * random(7, len(MODEL.parameters))
    if entry[2] is None or entry[2] == "contact":
        vectors_given = x
    else:
        # An option may be left out.
        vectors_given = x[:-1]
        inner = getattr(library.own, entry[0])
        f = lambda *y: (inner(MODEL, *y[:-1], parameters=y[-1]),)  # noqa: E731
        entry = (entry[0], entry[1], None, *entry[3:])
    given = [library.array(own) for own in (*vectors_given, p)]
    close(f(*given), on_numpy(entry, vectors_given), SAME)
    if entry[0] in VALUES_ONLY:
        return
    h = 1e-6
    after, before = (on_numpy(entry, vectors_given, p + s * h * dp) for s in (1, -1))
    own = [(a - b) / (2 * h) for a, b in zip(after, before, strict=True)]
    _, found = library.jvp(lambda p: f(*given[:-1], p), given[-1:], [library.array(dp)])
    close(found, own, 2 * DIFFERENCES)
    weights = [library.array(random(90 + k, *np.asarray(y).shape)) for k, y in enumerate(found)]
    slopes = library.slopes(f, given, weights)
    one = sum(float((np.asarray(w) * np.asarray(y)).sum()) for w, y in zip(weights, found, strict=True))
    other = float((np.asarray(slopes[-1]) * dp).sum())
    assert abs(one - other) < 1e-8 * max(1.0, abs(one))


@pytest.fixture(scope="module", params=[Jax, Torch])
def library(request: pytest.FixtureRequest) -> Any:
    return request.param()


@pytest.mark.parametrize("entry", [*ENTRIES, *STEPS], ids=lambda entry: entry[0])
def test_values_and_derivatives_are_those_of_numpy(library: Any, entry: Any) -> None:
    compare(library, entry)


@pytest.mark.parametrize("entry", [*ENTRIES, *STEPS], ids=lambda entry: entry[0])
def test_derivatives_in_parameters_are_those_of_numpy(library: Any, entry: Any) -> None:
    compare_parameters(library, entry)


@pytest.mark.parametrize("name", ["frame_pose", "kinetic_energy", "inverse_dynamics", "step"])
def test_jacobians_in_both_directions_are_equal(library: Any, name: str) -> None:
    entry = next(entry for entry in [*ENTRIES, *STEPS] if entry[0] == name)
    f, x = function(library, entry), [library.array(own) for own in vectors(entry, 20)]
    if name != "inverse_dynamics":
        x.append(library.array(MODEL.parameters))
    forward, reverse = library.jacobians(f, x)
    for one, other in zip(forward, reverse, strict=True):
        close(one, other, SAME)


def test_each_row_of_a_batch_may_have_parameters_of_its_own(library: Any) -> None:
    entry = next(entry for entry in ENTRIES if entry[0] == "mass_matrix")
    q = vectors(entry, 3)[0]
    all_parameters = MODEL.parameters * np.array([1.0, 1.1, 0.9])[:, None]
    batch = library.vmap(lambda p: library.own.mass_matrix(MODEL, library.array(q), parameters=p))(library.array(all_parameters))
    for k in range(3):
        close([batch[k]], [db.mass_matrix(MODEL.with_parameters(all_parameters[k]), q)], SAME)


def test_functions_that_are_made_of_others(library: Any) -> None:
    q, v, a = MODEL.random_configuration(1), random(2, MODEL.nv), random(3, MODEL.nv)
    own, array = library.own, library.array
    x = [array(own) for own in (q, v, a)]
    for name in ("inverse_dynamics_derivatives", "forward_dynamics_derivatives"):
        found, expected = getattr(own, name)(MODEL, *x), getattr(db, name)(MODEL, q, v, a)
        close(found, expected, SAME)
        assert type(found) is type(expected)
    close(own.frame_velocity_derivatives(MODEL, *x[:2], "hand"), db.frame_velocity_derivatives(MODEL, q, v, "hand"), SAME)
    close(own.centroidal_momentum_derivatives(MODEL, *x[:2]), db.centroidal_momentum_derivatives(MODEL, q, v), SAME)
    jacobian = db.frame_jacobian(MODEL, q, "hand")
    close([own.jacobian_to_representation(MODEL, x[0], array(jacobian), "mixed")], [db.jacobian_to_representation(MODEL, q, jacobian, "mixed")], SAME)
    forces = {"hand": random(4, 6), "base": random(5, 6)}
    named = {name: array(force) for name, force in forces.items()}
    close([own.external_forces(MODEL, x[0], named)], [db.external_forces(MODEL, q, forces)], SAME)
    close([own.joint_forces(MODEL, {"wrist": array(2.0)})], [db.joint_forces(MODEL, {"wrist": 2.0})], SAME)
    close(own.contact_kinematics(SIMULATOR, *x[:2]), db.sim.contact_kinematics(SIMULATOR, q, v), SAME)
    mixed, expected = own.BaseVelocity(MODEL, "mixed"), db.BaseVelocity(MODEL, "mixed")
    close([mixed.inverse_dynamics(*x), mixed.frame_jacobian(x[0], "hand")], [expected.inverse_dynamics(q, v, a), expected.frame_jacobian(q, "hand")], SAME)


def test_what_makes_no_sense_is_refused(library: Any) -> None:
    own, q = library.own, library.array(MODEL.neutral())
    with pytest.raises(ValueError, match=r"q has the shape \(3,\)"):
        own.mass_matrix(MODEL, library.array(np.zeros(3)))
    with pytest.raises(TypeError, match="each once"):
        own.mass_matrix(MODEL, q, q=q)
    with pytest.raises(TypeError, match="needs q, frame"):
        own.frame_pose(MODEL, q)
    with pytest.raises(KeyError, match="no frame"):
        own.frame_pose(MODEL, q, "nothing")
    with pytest.raises(ValueError, match="line break"):
        own.frame_pose(MODEL, q, "nothing\n")
    with pytest.raises(TypeError, match="^q holds .*complex"):
        own.mass_matrix(MODEL, library.array(MODEL.neutral()) * 1j)
    batches = [library.array(np.zeros((n, width))) for n, width in ((2, MODEL.nq), (3, MODEL.nv))]
    with pytest.raises(ValueError, match=r"the batches of kinetic_energy do not fit: q \(2,\), v \(3,\)"):
        own.kinetic_energy(MODEL, *batches)


def main() -> None:
    libraries = [("JAX", Jax()), ("PyTorch", Torch())]
    print("| function | NumPy |" + "".join(f" {name}: values, state | parameters |" for name, _ in libraries))
    print("|---|---|" + "---|---|" * len(libraries))
    for entry in [*ENTRIES, *STEPS]:
        cells = []
        for _, own in libraries:
            for compared in (compare, compare_parameters):
                compared(own, entry)
                cells.append("values" if entry[0] in VALUES_ONLY else "yes")
        print(f"| `{entry[0]}` | yes | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
