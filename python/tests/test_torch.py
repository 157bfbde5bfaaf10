"""PyTorch: values and slopes are the library's own."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import SAME_ALGEBRA, asset

torch = pytest.importorskip("torch", reason="torch is not installed: dualbody.torch is not tested here")

import dualbody as db  # noqa: E402
import dualbody.torch as dt  # noqa: E402
from dualbody._dualbody import _difference_jacobian, _integrate_jacobian  # noqa: E402
from dualbody.contact import Contacts, SoftContact  # noqa: E402

ARM = db.samples.arm()


def close(actual, expected, tolerance: float = SAME_ALGEBRA) -> None:  # type: ignore[no-untyped-def]
    expected = np.asarray(expected)
    scale = max(1.0, np.abs(expected).max(initial=0))
    np.testing.assert_allclose(np.asarray(actual), expected, rtol=0, atol=tolerance * scale)


def random(seed: int, *shape: int):  # type: ignore[no-untyped-def]
    return torch.from_numpy(np.random.default_rng(seed).uniform(-1, 1, shape))


def floating() -> tuple:  # type: ignore[type-arg]
    model = db.Model.from_urdf(asset("quadruped"))
    simulator = db.Simulator(model, time_step=2e-3)
    q, v = (torch.from_numpy(x) for x in (model.random_configuration(3), model.random_velocity(4)))
    return simulator, q, v, random(5, simulator.nu)


def test_dynamics_and_their_derivatives_are_those_of_the_library() -> None:
    q, v, a = random(0, 7), random(1, 7), random(2, 7)
    pairs = [
        (dt.inverse_dynamics, db.inverse_dynamics, db.inverse_dynamics_derivatives),
        (dt.forward_dynamics, db.forward_dynamics, db.forward_dynamics_derivatives),
    ]
    for own, function, derivatives in pairs:
        close(own(ARM, q, v, a), function(ARM, q, v, a))
        jacobians = torch.func.jacrev(lambda *x, own=own: own(ARM, *x), argnums=(0, 1, 2))(q, v, a)
        for actual, expected in zip(jacobians, derivatives(ARM, q, v, a), strict=True):
            close(actual, expected)
    close(dt.mass_matrix(ARM, q), db.mass_matrix(ARM, q), 1e-11)
    close(dt.bias_forces(ARM, q, v), db.bias_forces(ARM, q, v))
    close(dt.gravity_forces(ARM, q), db.gravity_forces(ARM, q))


def test_autograd_of_a_batch_is_that_of_its_states() -> None:
    q, v, a = (random(k, 70, 7).requires_grad_() for k in range(3))
    weight = random(3, 70, 7)
    (dt.inverse_dynamics(ARM, q, v, a) * weight).sum().backward()
    by_q, by_v, by_a = db.inverse_dynamics_derivatives(ARM, *(x.detach().numpy() for x in (q, v, a)))
    for x, block in zip((q, v, a), (by_q, by_v, by_a), strict=True):
        close(x.grad, np.einsum("ki,kij->kj", weight.numpy(), block))
    one = random(4, 7).requires_grad_()
    dt.inverse_dynamics(ARM, q.detach(), one, a.detach()).sum().backward()
    assert one.grad.shape == (7,)


def test_vmap_is_a_batch() -> None:
    q, v, a = random(0, 9, 7), random(1, 9, 7), random(2, 7)
    together = torch.func.vmap(lambda q, v: dt.inverse_dynamics(ARM, q, v, a))(q, v)
    close(together, db.inverse_dynamics(ARM, q, v, a))
    turned = torch.func.vmap(lambda q, v: dt.inverse_dynamics(ARM, q, v, a), in_dims=(1, 0))(q.T.contiguous(), v)
    close(turned, together)
    slopes = torch.func.vmap(torch.func.grad(lambda q, v: dt.forward_dynamics(ARM, q, v, a).sum()))(q, v)
    close(slopes, db.forward_dynamics_derivatives(ARM, q, v, a).dq.sum(axis=-2), 1e-11)
    nested = torch.func.vmap(torch.func.vmap(lambda q: dt.gravity_forces(ARM, q)))(q.reshape(3, 3, 7))
    close(nested, db.gravity_forces(ARM, q.numpy().reshape(3, 3, 7)))


def test_the_jacobian_of_a_step_is_linearize_in_tangent_coordinates() -> None:
    simulator, q, v, u = floating()
    model, nv = simulator.model, simulator.model.nv
    a, b = simulator.linearize(q, v, u)
    integrate = torch.from_numpy(_integrate_jacobian(model, q))
    difference = torch.from_numpy(_difference_jacobian(model, simulator.step(q, v, u)[0]))

    def local(dx, u):  # type: ignore[no-untyped-def]
        q1, v1 = dt.step(simulator, q + integrate @ dx[:nv], v + dx[nv:], u)
        return torch.cat([difference @ q1, v1])

    by_x, by_u = torch.func.jacrev(local, argnums=(0, 1))(torch.zeros(2 * nv, dtype=torch.float64), u)
    close(by_x, a)
    close(by_u, b)


def test_the_gradient_of_a_rollout_is_the_librarys_and_that_of_its_steps() -> None:
    simulator, q, v, _ = floating()
    inputs, theta = random(6, 20, simulator.nu), torch.from_numpy(simulator.model.parameters)

    def cost(q, v, inputs, theta):  # type: ignore[no-untyped-def]
        qs, vs = dt.rollout(simulator, q, v, inputs, theta)
        return (qs[-1] ** 2).sum() + (vs**2).sum()

    def by_steps(q, v, inputs, theta):  # type: ignore[no-untyped-def]
        total = (v**2).sum()
        for u in inputs:
            q, v = dt.step(simulator, q, v, u, theta)
            total = total + (v**2).sum()
        return (q**2).sum() + total

    slopes, others = (torch.func.grad(f, argnums=(0, 1, 2, 3))(q, v, inputs, theta) for f in (cost, by_steps))
    for one, other in zip(slopes[1:], others[1:], strict=True):
        close(one, other, 1e-10)
    rollout = simulator.rollout(q, v, inputs=inputs)
    by_q, by_v = np.zeros_like(rollout.q), 2 * rollout.v
    by_q[-1] = 2 * rollout.q[-1]
    own = simulator.rollout_vjp(q, v, inputs, by_q=by_q, by_v=by_v)
    nv = simulator.model.nv
    close(slopes[0], own.start[:nv] @ _difference_jacobian(simulator.model, q.numpy()))
    close(slopes[1], own.start[nv:])
    close(slopes[2], own.inputs)
    close(slopes[3], own.parameters)
    without = torch.func.grad(lambda v: (dt.rollout(simulator, q, v, inputs)[1] ** 2).sum())(v)
    assert torch.isfinite(without).all()


def test_each_state_may_have_parameters_of_its_own() -> None:
    simulator = db.Simulator(db.samples.pendulum(), time_step=0.01)
    theta = torch.from_numpy(simulator.model.parameters)
    many = theta * torch.tensor([1.0, 1.1, 1.0, 1.2], dtype=torch.float64)[:, None]
    inputs, zero = torch.zeros(4, 10, 1, dtype=torch.float64), torch.zeros(1, dtype=torch.float64)

    def end(theta, inputs):  # type: ignore[no-untyped-def]
        return dt.rollout(simulator, zero + 0.5, zero, inputs, theta)[0][-1, 0]

    slopes = torch.func.vmap(torch.func.grad(end))(many, inputs)
    for k in range(4):
        close(slopes[k], torch.func.grad(end)(many[k], inputs[k]), 1e-11)


def test_a_mass_is_found_by_gradients() -> None:
    truth = db.samples.cartpole()
    simulator = db.Simulator(truth, time_step=0.01)
    guess = db.Simulator(truth.with_link_mass("pole", 1.3 * truth.total_mass / 2), time_step=0.01)
    k = next(i for i, name in enumerate(truth.parameter_names) if name.startswith("pole") and "mass" in name)
    q, v, inputs = random(7, 2), random(8, 2), 3 * random(9, 60, 2)
    wanted = torch.from_numpy(simulator.rollout(q, v, inputs=inputs).q.copy())
    theta = torch.from_numpy(truth.parameters)
    start = theta[k].item()
    change = torch.tensor(0.3 * start, dtype=torch.float64, requires_grad=True)
    direction = torch.zeros_like(theta)
    direction[k] = 1.0
    search = torch.optim.LBFGS([change], max_iter=60, line_search_fn="strong_wolfe", tolerance_grad=1e-14, tolerance_change=1e-16)

    def loss():  # type: ignore[no-untyped-def]
        search.zero_grad()
        qs, _ = dt.rollout(guess, q, v, inputs, theta + change * direction)
        value = 1e3 * ((qs - wanted) ** 2).sum()
        value.backward()
        return value

    search.step(loss)
    assert abs(change.item()) < 1e-6 * start


def test_types_devices_and_what_is_refused() -> None:
    tau = dt.gravity_forces(ARM, torch.zeros(7))
    assert tau.dtype == torch.float32 and tau.device.type == "cpu"
    close(tau, db.gravity_forces(ARM, np.zeros(7)), 1e-6)
    close(dt.gravity_forces(ARM, np.zeros(7)), db.gravity_forces(ARM, np.zeros(7)))
    q = random(0, 7).requires_grad_()
    (slope,) = torch.autograd.grad(dt.gravity_forces(ARM, q).sum(), q, create_graph=True)
    with pytest.raises(NotImplementedError, match="first derivatives"):
        slope.sum().backward()
    model = db.Model.from_urdf(asset("sphere"))
    soft = db.Simulator(model, contacts=Contacts(law=SoftContact(0.5, 1e4, 1e2)))
    contact = random(9, soft.n_contact) * 1e-4
    found = dt.step(soft, model.neutral(), np.zeros(6), np.zeros(0), contact=contact)
    for one, other in zip(found, soft.step(model.neutral(), np.zeros(6), contact=contact.numpy()), strict=True):
        close(one, other)
