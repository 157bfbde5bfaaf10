"""Vector-Jacobian products of steps, gradients of rollouts."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import SAME_ALGEBRA, asset

import dualbody as db
from dualbody._dualbody import _integrate_jacobian
from dualbody.contact import Contacts, Rigid, SoftContact
from dualbody.sim import Anchor, Distance, rollout_gradient

#: Central differences of steps of 1e-5 to 1e-6.
DIFFERENCES = 1e-6


def random(seed: int, *shape: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1, 1, shape)


def close(actual, expected, tolerance: float = SAME_ALGEBRA) -> None:  # type: ignore[no-untyped-def]
    expected = np.asarray(expected)
    scale = max(1.0, np.abs(expected).max(initial=0))
    np.testing.assert_allclose(actual, expected, rtol=0, atol=tolerance * scale)


@pytest.fixture(scope="module")
def flying() -> db.Simulator:
    return db.Simulator(db.Model.from_urdf(asset("quadruped")), time_step=2e-3)


def states(model: db.Model, n: int) -> tuple[np.ndarray, np.ndarray]:
    q = np.array([model.random_configuration(k) for k in range(n)])
    return q, np.array([model.random_velocity(k) for k in range(n)])


def test_a_vjp_is_the_transposed_linearization(flying: db.Simulator) -> None:
    q, v = states(flying.model, 6)
    u, adjoint = random(1, 6, flying.nu), random(2, 6, flying.n_tangent)
    gradient = flying.vjp(q, v, u, adjoint)
    a, b = flying.linearize(q, v, u)
    close(gradient.state, np.einsum("kij,ki->kj", a, adjoint), 1e-10)
    close(gradient.input, np.einsum("kij,ki->kj", b, adjoint), 1e-10)
    assert gradient.parameters.shape == (6, len(flying.model.parameter_names)) and gradient.friction.shape == (6, 0)
    one = flying.vjp(q[3], v[3], u[3], adjoint[3], parameters=False)
    np.testing.assert_array_equal(one.state, gradient.state[3])
    assert one.parameters.shape == (0,)
    spread = flying.vjp(q[0], v[0], u[0], adjoint)
    assert spread.state.shape == adjoint.shape
    np.testing.assert_array_equal(spread.input[0], gradient.input[0])


def held() -> db.Simulator:
    """A double pendulum whose lower end a rod keeps at 1.5 m from its hinge."""
    two = db.samples.double_pendulum()
    rod = Distance(Anchor(two.link_names[-1], (0, 0, -1)), Anchor(), 1.5)
    return db.Simulator(two, time_step=0.01, constraints=[rod])


@pytest.mark.parametrize("simulator", [db.Simulator(db.samples.arm(), time_step=0.01), held()], ids=["arm", "held"])
def test_the_slope_of_a_step_in_parameters_equals_differences(simulator: db.Simulator) -> None:
    n = simulator.model.nv
    (q, v, u), adjoint = (random(k, n) for k in (3, 4, 5)), random(6, 2 * n)
    theta = simulator.model.parameters
    # In proportion: the wrist's inertias are small.
    direction = theta * random(7, len(theta))
    h = 1e-6

    def weight(parameters: np.ndarray) -> float:
        q1, v1 = simulator.replace(model=simulator.model.with_parameters(parameters)).step(q, v, u)
        return float(adjoint @ np.concatenate([q1, v1]))

    difference = (weight(theta + h * direction) - weight(theta - h * direction)) / (2 * h)
    close(simulator.vjp(q, v, u, adjoint).parameters @ direction, difference, DIFFERENCES)


def test_a_rollout_without_forces_has_the_gradient_of_uniform_motion() -> None:
    # q(T) = q₀ + v₀ T without gravity, with T = 0.5 s: J = (0.1 + 0.5 · 2)²
    simulator = db.Simulator(db.samples.pendulum().with_gravity((0, 0, 0)), time_step=0.01)

    def cost(rollout: db.Rollout):  # type: ignore[no-untyped-def]
        by_q = np.zeros_like(rollout.q)
        by_q[-1] = 2 * rollout.q[-1]
        return float(rollout.q[-1, 0] ** 2), {"q": by_q}

    swing = rollout_gradient(simulator, [0.1], [2.0], np.zeros((50, 1)), cost)
    assert swing.cost == pytest.approx(1.21, abs=1e-12)
    close(swing.start, [2.2, 1.1])
    assert swing.inputs.shape == (50, 1) and swing.status.is_completed


def test_the_gradient_of_a_rollout_equals_that_of_its_steps(flying: db.Simulator) -> None:
    (q,), (v,) = states(flying.model, 1)
    steps = 12
    inputs = random(8, steps, flying.nu)
    rollout = flying.rollout(q, v, inputs=inputs)
    by_q, by_v, by_u = random(9, *rollout.q.shape), random(10, *rollout.v.shape), random(11, *inputs.shape)
    whole = flying.rollout_vjp(q, v, inputs, by_q=by_q, by_v=by_v, by_u=by_u)
    weights = np.concatenate([np.einsum("...i,...ij->...j", by_q, _integrate_jacobian(flying.model, rollout.q)), by_v], axis=-1)
    adjoint, parameters = weights[-1], 0.0
    for k in reversed(range(steps)):
        step = flying.vjp(rollout.q[k], rollout.v[k], inputs[k], adjoint)
        close(whole.inputs[k], step.input + by_u[k], 1e-11)
        adjoint, parameters = weights[k] + step.state, parameters + step.parameters
    close(whole.start, adjoint, 1e-11)
    close(whole.parameters, parameters, 1e-11)
    for checkpoints in ("square_root", 5):
        again = flying.rollout_vjp(q, v, inputs, by_q=by_q, by_v=by_v, by_u=by_u, checkpoints=checkpoints)
        close(again.parameters, whole.parameters)
        close(again.start, whole.start)


def test_gradients_of_a_batch_are_those_of_its_states(flying: db.Simulator) -> None:
    q, v = states(flying.model, 9)
    inputs, by_v = random(12, 9, 5, flying.nu), random(13, 6, flying.model.nv)
    together = flying.rollout_vjp(q.reshape(3, 3, -1), v.reshape(3, 3, -1), inputs.reshape(3, 3, 5, -1), by_v=by_v)
    assert together.start.shape == (3, 3, flying.n_tangent) and together.inputs.shape == (3, 3, 5, flying.nu)
    assert len(together.status) == 9 and all(status.is_completed for status in together.status)
    alone = flying.rollout_vjp(q[4], v[4], inputs[4], by_v=by_v)
    np.testing.assert_array_equal(together.start[1, 1], alone.start)
    np.testing.assert_array_equal(together.parameters[1, 1], alone.parameters)


def test_slopes_in_contact_and_friction_equal_differences() -> None:
    model = db.Model.from_urdf(asset("sphere"))

    def sliding(friction: float) -> db.Simulator:
        return db.Simulator(model, time_step=1e-3, contacts=Contacts(law=Rigid(friction)))

    q, v = model.neutral(), np.array([1.0, 0, 0, 0, 0, 0])
    q[2] = 0.1
    by_v = np.zeros((21, 6))
    by_v[-1, 0] = 1.0
    gradient = sliding(0.3).rollout_vjp(q, v, np.zeros((20, 0)), by_v=by_v)
    ends = [sliding(mu).rollout(q, v, steps=20).v[-1, 0] for mu in (0.3 + 1e-5, 0.3 - 1e-5)]
    assert abs(gradient.friction.sum()) > 1e-3
    close(gradient.friction.sum(), (ends[0] - ends[1]) / 2e-5, DIFFERENCES)


def test_a_diverged_rollout_has_no_slopes_and_says_so() -> None:
    simulator = db.Simulator(db.samples.pendulum(), time_step=0.01, divergence_bound=10.0)
    by_q = np.ones((6, 1))
    ends = simulator.rollout_vjp([[0.0], [0.0]], [[0.0], [9.9]], np.full((5, 1), 100.0), by_q=by_q)
    assert [status.kind for status in ends.status] == ["diverged"] * 2 and not ends.start.any()
    with pytest.raises(ValueError, match=r"by_q\[2\] is NaN"):
        simulator.rollout_vjp([0.0], [0.0], np.zeros((2, 1)), by_q=[[0.0], [0.0], [np.nan]])


def test_wrong_slopes_are_errors_that_name_them(flying: db.Simulator) -> None:
    (q,), (v,) = states(flying.model, 1)
    inputs = np.zeros((3, flying.nu))
    with pytest.raises(ValueError, match="^by_v has the shape"):
        flying.rollout_vjp(q, v, inputs, by_v=np.zeros((3, flying.model.nv)))
    with pytest.raises(ValueError, match="^adjoint has the shape"):
        flying.vjp(q, v, inputs[0], np.zeros(3))
    with pytest.raises(ValueError, match="^checkpoints is not"):
        flying.rollout_vjp(q, v, inputs, checkpoints="some")
    with pytest.raises(KeyError, match="'w'"):
        rollout_gradient(flying, q, v, inputs, lambda rollout: (0.0, {"w": 1}))
    assert held().vjp(np.zeros(2), np.zeros(2), np.zeros(2), np.ones(4), parameters=False).state.shape == (4,)


def test_a_state_of_contact_is_part_of_the_gradient() -> None:
    simulator = db.Simulator(db.Model.from_urdf(asset("sphere")), time_step=1e-4, contacts=Contacts(law=SoftContact(0.5, 1e4, 1e2)))
    q, v = simulator.model.neutral(), np.array([0.1, 0, 0, 0, 0, 0])
    q[2] = 0.0999
    contact = simulator.neutral_contact()
    adjoint = random(14, simulator.n_tangent)
    gradient = simulator.vjp(q, v, np.zeros(0), adjoint, contact=contact)
    close(gradient.state, simulator.linearize(q, v, np.zeros(0), contact=contact).a.T @ adjoint, 1e-9)
