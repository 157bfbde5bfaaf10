"""JAX: values and derivatives are the library's own."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import SAME_ALGEBRA, asset

jax = pytest.importorskip("jax")
jax.config.update("jax_enable_x64", True)
jax.config.update("jax_platforms", "cpu")

import jax.numpy as jnp  # noqa: E402

import dualbody as db  # noqa: E402
import dualbody.jax as dj  # noqa: E402
from dualbody.contact import Contacts, Rigid, SoftContact  # noqa: E402

ARM = db.samples.arm()


def close(actual, expected, tolerance: float = SAME_ALGEBRA) -> None:  # type: ignore[no-untyped-def]
    expected = np.asarray(expected)
    scale = max(1.0, np.abs(expected).max(initial=0))
    np.testing.assert_allclose(np.asarray(actual), expected, rtol=0, atol=tolerance * scale)


def random(seed: int, *shape: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1, 1, shape)


def test_dynamics_and_their_derivatives_are_those_of_the_library() -> None:
    q, v, a = random(0, 7), random(1, 7), random(2, 7)
    close(jax.jit(lambda *x: dj.inverse_dynamics(ARM, *x))(q, v, a), db.inverse_dynamics(ARM, q, v, a))
    jacobians = jax.jacfwd(lambda *x: dj.inverse_dynamics(ARM, *x), argnums=(0, 1, 2))(q, v, a)
    for actual, expected in zip(jacobians, db.inverse_dynamics_derivatives(ARM, q, v, a), strict=True):
        close(actual, expected)
    jacobians = jax.jit(jax.jacrev(lambda *x: dj.forward_dynamics(ARM, *x), argnums=(0, 1, 2)))(q, v, a)
    for actual, expected in zip(jacobians, db.forward_dynamics_derivatives(ARM, q, v, a), strict=True):
        close(actual, expected)
    close(dj.mass_matrix(ARM, q), db.mass_matrix(ARM, q), 1e-11)
    close(dj.bias_forces(ARM, q, v), db.bias_forces(ARM, q, v))


def test_vmap_is_a_batch() -> None:
    q, v, a = random(0, 90, 7), random(1, 90, 7), random(2, 7)
    together = jax.vmap(lambda q, v: dj.inverse_dynamics(ARM, q, v, a))(q, v)
    close(together, db.inverse_dynamics(ARM, q, v, a))
    close(dj.inverse_dynamics(ARM, q, v, a), together)
    twice = jax.jit(jax.vmap(jax.vmap(lambda q, v: dj.forward_dynamics(ARM, q, v, a))))
    close(twice(q.reshape(9, 10, 7), v.reshape(9, 10, 7)), db.forward_dynamics(ARM, q, v, a).reshape(9, 10, 7), 1e-10)


def floating() -> tuple[db.Simulator, np.ndarray, np.ndarray, np.ndarray]:
    model = db.Model.from_urdf(asset("quadruped"))
    simulator = db.Simulator(model, time_step=2e-3)
    return simulator, model.random_configuration(3), model.random_velocity(4), random(5, simulator.nu)


def test_the_jacobian_of_a_step_is_linearize_in_tangent_coordinates() -> None:
    simulator, q, v, u = floating()
    model, nv = simulator.model, simulator.model.nv
    a, b = simulator.linearize(q, v, u)

    def local(dx, u):  # type: ignore[no-untyped-def]
        # Coordinates of the base turn with it: dq = integrate(q, dx) to first order.
        q1, v1 = dj.step(simulator, q + integrate @ dx[:nv], v + dx[nv:], u)
        return jnp.concatenate([difference @ q1, v1])

    from dualbody._dualbody import _difference_jacobian, _integrate_jacobian

    integrate = _integrate_jacobian(model, q)
    difference = _difference_jacobian(model, simulator.step(q, v, u)[0])
    by_x, by_u = jax.jacfwd(local, argnums=(0, 1))(jnp.zeros(2 * nv), u)
    close(by_x, a)
    close(by_u, b)
    close(difference @ _integrate_jacobian(model, simulator.step(q, v, u)[0]), np.eye(nv))
    dx = 1e-6 * np.eye(nv)
    differences = (model.integrate(q, dx) - model.integrate(q, -dx)).T / 2e-6
    close(integrate, differences, 1e-9)


def test_the_gradient_of_a_rollout_equals_that_of_its_steps_and_differences() -> None:
    simulator, q, v, _ = floating()
    inputs = random(6, 20, simulator.nu)

    def cost(q, v, inputs):  # type: ignore[no-untyped-def]
        qs, vs = dj.rollout(simulator, q, v, inputs)
        return (qs[-1] ** 2).sum() + (vs**2).sum()

    def by_steps(q, v, inputs):  # type: ignore[no-untyped-def]
        total = (v**2).sum()
        for u in inputs:
            q, v = dj.step(simulator, q, v, u)
            total += (v**2).sum()
        return (q**2).sum() + total

    close(cost(q, v, inputs), by_steps(q, v, inputs))
    one, other = (jax.jit(jax.grad(f, argnums=(1, 2)))(q, v, inputs) for f in (cost, by_steps))
    close(one[0], other[0], 1e-10)
    close(one[1], other[1], 1e-10)
    h, direction = 1e-5, random(7, 20, simulator.nu)
    difference = (cost(q, v, inputs + h * direction) - cost(q, v, inputs - h * direction)) / (2 * h)
    close((one[1] * direction).sum(), difference, 1e-7)
    many = jax.vmap(jax.grad(cost, argnums=2), in_axes=(None, None, 0))(q, v, np.stack([inputs, 2 * inputs]))
    close(many[0], one[1], 1e-10)


def test_steps_in_contact_differentiate() -> None:
    model = db.Model.from_urdf(asset("sphere"))
    simulator = db.Simulator(model, time_step=1e-3, contacts=Contacts(law=Rigid()))
    q, v = model.neutral(), np.array([0.1, 0, 0, 0, 0, 0])
    q[2] = 0.1
    by_v = jax.jacfwd(lambda v: dj.step(simulator, q, v, jnp.zeros(0))[1])(v)
    close(by_v, simulator.linearize(q, v).a[6:, 6:])
    soft = simulator.replace(contacts=Contacts(law=SoftContact(0.5, 1e4, 1e2)))
    contact = 1e-4 * random(8, soft.n_contact)
    close(jnp.concatenate(dj.step(soft, q, v, contact=contact)), np.concatenate(soft.step(q, v, contact=contact)))
    by_contact = jax.jacfwd(lambda contact: dj.step(soft, q, v, contact=contact)[2])(contact)
    close(by_contact, soft.linearize(q, v, contact=contact).a[12:, 12:])


def test_single_precision_is_what_jax_says() -> None:
    jax.config.update("jax_enable_x64", False)
    try:
        tau = dj.gravity_forces(ARM, np.zeros(7))
        assert tau.dtype == jnp.float32
        close(tau, db.gravity_forces(ARM, np.zeros(7)), 1e-6)
    finally:
        jax.config.update("jax_enable_x64", True)


def test_compiled_programs_call_the_library_without_the_interpreter() -> None:
    assert dj._is_foreign()
    program = jax.jit(lambda q: dj.gravity_forces(ARM, q)).lower(np.zeros(7)).as_text()
    assert "callback" not in program and "custom_call" in program
    # The same robot, made twice, is one robot in programs; another is another.
    arm = db.samples.arm()
    name = db._dualbody._foreign_name
    assert name(arm) == name(db.samples.arm()) == name(ARM) != name(arm.with_gravity((0, 0, -1)))
    with pytest.raises(TypeError, match="Model or a Simulator"):
        name(3)  # type: ignore[arg-type]


def test_callbacks_give_the_same_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    simulator, q, v, _ = floating()
    inputs = random(8, 3, 12, simulator.nu)

    def both(*x):  # type: ignore[no-untyped-def]
        def cost(inputs):  # type: ignore[no-untyped-def]
            qs, vs = jax.vmap(lambda u: dj.rollout(simulator, q, v, u))(inputs)
            return (qs[:, -1] ** 2).sum() + (vs**2).sum()

        dynamics = jax.jacfwd(lambda *x: dj.forward_dynamics(ARM, *x), argnums=(0, 1, 2))
        return jax.jit(jax.value_and_grad(cost))(inputs), jax.jit(dynamics)(*x)

    x = random(0, 7), random(1, 7), random(2, 7)
    foreign = both(*x)
    monkeypatch.setattr(dj, "_is_foreign", lambda: False)
    for one, other in zip(jax.tree.leaves(foreign), jax.tree.leaves(both(*x)), strict=True):
        close(one, other)


def test_errors_of_the_library_are_errors_of_programs() -> None:
    fast = db.Simulator(db.samples.cartpole(), time_step=0.01, divergence_bound=1.0)
    with pytest.raises(jax.errors.JaxRuntimeError, match="the step diverged"):
        jax.block_until_ready(dj.step(fast, np.zeros(2), np.full(2, 1e200), np.zeros(2)))
    many = jax.jit(jax.vmap(lambda v: dj.step(fast, np.zeros(2), v, np.zeros(2))))
    with pytest.raises(jax.errors.JaxRuntimeError, match="state 1 of the batch diverged"):
        jax.block_until_ready(many(np.array([[0.0, 0.0], [1e3, 0.0], [0.0, 0.1]])))
    with pytest.raises(jax.errors.JaxRuntimeError, match=r"u\[0\] is NaN"):
        jax.block_until_ready(dj.step(fast, np.zeros(2), np.zeros(2), np.array([np.nan, 0.0])))


def test_large_batches_spread_over_threads_of_the_library() -> None:
    simulator, q, v, u = floating()
    model, n = simulator.model, 300
    qs = np.stack([model.random_configuration(k) for k in range(n)])
    step = jax.jit(jax.vmap(lambda q: dj.step(simulator, q, v, u)))
    vs, us = (np.broadcast_to(x, (n, len(x))) for x in (v, u))
    for one, other in zip(step(qs), simulator.step(qs, vs, us), strict=True):
        close(one, other)
    a = jax.jit(jax.vmap(lambda q, v, a: dj.inverse_dynamics(model, q, v, a)))(qs, vs, vs)
    close(a, db.inverse_dynamics(model, qs, vs, vs))
    assert dj.rollout(simulator, q, v, np.zeros((0, simulator.nu)))[0].shape == (1, model.nq)
