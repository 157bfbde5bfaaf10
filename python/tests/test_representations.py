"""Every quantity with the base velocity in body, mixed and inertial representation: by identities, and beside Pinocchio where it is installed."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from conftest import OTHER_ALGORITHM, asset

import dualbody as db

REPRESENTATIONS = ("body", "mixed", "inertial")


def state(model: db.Model, seed: int) -> tuple[Any, Any, Any]:
    rng = np.random.default_rng(seed)
    return model.random_configuration(seed), rng.uniform(-1, 1, model.nv), rng.uniform(-1, 1, model.nv)


def close(actual: Any, expected: Any) -> None:
    np.testing.assert_allclose(actual, expected, atol=OTHER_ALGORITHM, rtol=OTHER_ALGORITHM)


@pytest.fixture(scope="module")
def frame(quadruped: db.Model) -> str:
    return quadruped.link_names[-1]


@pytest.mark.parametrize("representation", REPRESENTATIONS)
def test_equations_of_motion_hold_in_each_representation(quadruped: db.Model, representation: Any) -> None:
    base = db.BaseVelocity(quadruped, representation)
    q, v, a = state(quadruped, 3)
    mass, bias = base.mass_matrix(q), base.bias_forces(q, v)
    tau = base.inverse_dynamics(q, v, a)
    close(tau, mass @ a + bias)
    close(base.forward_dynamics(q, v, tau), a)
    close(base.coriolis_matrix(q, v) @ v, bias - base.gravity_forces(q))
    close(base.mass_matrix_inverse(q) @ mass, np.eye(quadruped.nv))
    own = db.velocity_from_representation(quadruped, q, v, representation)
    assert 0.5 * v @ mass @ v == pytest.approx(float(db.kinetic_energy(quadruped, q, own)), rel=1e-10)
    close(base.momentum_matrix(q) @ v, db.centroidal_momentum(quadruped, q, own))
    close(base.momentum(q, v), db.centroidal_momentum(quadruped, q, own))
    close(
        base.centroidal_momentum_rate(q, v, a),
        base.momentum_matrix(q) @ a + base.centroidal_momentum_matrix_derivative(q, v) @ v,
    )
    close(base.center_of_mass_jacobian(q) @ v, base.center_of_mass_velocity(q, v))
    close(base.average_velocity_jacobian(q) @ v, db.average_velocity(quadruped, q, own))


@pytest.mark.parametrize("representation", REPRESENTATIONS)
@pytest.mark.parametrize("of_frame", REPRESENTATIONS)
def test_frames_move_by_their_jacobians(quadruped: db.Model, frame: str, representation: Any, of_frame: Any) -> None:
    base = db.BaseVelocity(quadruped, representation)
    q, v, a = state(quadruped, 4)
    jacobian = base.frame_jacobian(q, frame, of_frame)
    rate = base.frame_jacobian_derivative(q, v, frame, of_frame)
    close(base.frame_velocity(q, v, frame, of_frame), jacobian @ v)
    close(base.frame_bias_acceleration(q, v, frame, of_frame), rate @ v)
    close(base.frame_acceleration(q, v, a, frame, of_frame), jacobian @ a + rate @ v)


@pytest.mark.parametrize("representation", REPRESENTATIONS)
def test_jacobians_of_steps_equal_differences_of_converted_states(quadruped: db.Model, representation: Any) -> None:
    base, simulator = db.BaseVelocity(quadruped, representation), db.Simulator(quadruped, time_step=1e-2)
    q, v, _ = state(quadruped, 5)
    u, nv = np.random.default_rng(5).uniform(-1, 1, simulator.nu), quadruped.nv
    a, b = base.linearize(simulator, q, v, u)
    to, back = base.state_tangent(q, v)
    close(to @ back, np.eye(2 * nv))
    own = db.velocity_from_representation(quadruped, q, v, representation)
    dx, du = np.random.default_rng(6).uniform(-1, 1, 2 * nv), np.random.default_rng(7).uniform(-1, 1, simulator.nu)

    def tangent(q0: Any, v0: Any, q1: Any, v1: Any) -> Any:
        """Of the state 1 from 0, both of the package, in the representation."""
        moved = quadruped.difference(q0, q1)
        dq = db.velocity_to_representation(quadruped, q0, moved, representation)
        converted = [db.velocity_to_representation(quadruped, q, v, representation) for q, v in ((q0, v0), (q1, v1))]
        return np.concatenate([dq, converted[1] - converted[0]])

    def after(h: float) -> tuple[Any, Any]:
        start = quadruped.integrate(q, h * dx[:nv]), own + h * dx[nv:]
        following = simulator.step(*start, u + h * du)
        return tangent(q, own, *start), tangent(*simulator.step(q, own, u), *following)

    h = 1e-5
    before, following = ((plus - minus) / (2 * h) for plus, minus in zip(after(h), after(-h)))
    np.testing.assert_allclose(to @ dx, before, atol=1e-7)
    np.testing.assert_allclose(a @ before + b @ du, following, atol=1e-6)


def test_batches_equal_single_states_and_a_fixed_base_has_one_representation(quadruped: db.Model, panda: db.Model) -> None:
    states = [state(quadruped, seed) for seed in range(3)]
    q, v, _ = (np.stack(x) for x in zip(*states))
    base = db.BaseVelocity(quadruped, "mixed")
    for many, one in (
        (base.bias_forces(q, v), base.bias_forces),
        (base.coriolis_matrix(q, v), base.coriolis_matrix),
    ):
        np.testing.assert_array_equal(many, np.stack([one(*x[:2]) for x in states]))
    to, _ = base.state_tangent(q, v)
    assert to.shape == (3, 2 * quadruped.nv, 2 * quadruped.nv)
    simulator = db.Simulator(quadruped)
    a, b = base.linearize(simulator, q, v)
    np.testing.assert_allclose(a[1], base.linearize(simulator, *states[1][:2])[0], atol=1e-12)
    assert b.shape == (3, 2 * quadruped.nv, simulator.nu)
    q, v, _ = state(panda, 9)
    for representation in REPRESENTATIONS:
        fixed = db.BaseVelocity(panda, representation)  # type: ignore[arg-type]
        np.testing.assert_array_equal(fixed.mass_matrix(q), db.mass_matrix(panda, q))
        np.testing.assert_array_equal(fixed.coriolis_matrix(q, v), db.coriolis_matrix(panda, q, v))


def test_a_representation_that_there_is_not_is_an_error(quadruped: db.Model) -> None:
    with pytest.raises(ValueError, match="inertial"):
        db.BaseVelocity(quadruped, "world").mass_matrix(quadruped.neutral())  # type: ignore[arg-type]
    base = db.BaseVelocity(quadruped, "body")
    assert pickle.loads(pickle.dumps(base)).representation == "body" and "body" in repr(base)


@pytest.fixture(scope="module")
def peer(quadruped: db.Model) -> Any:
    """The same robot in Pinocchio at the same state, with the matrix from tangents here to tangents there."""
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromUrdf(asset("quadruped"), pin.JointModelFreeFlyer())
    data, (q, v, _), names = model.createData(), state(quadruped, 8), list(model.names)
    there = quadruped.to_engine("pinocchio", q, v, names)
    order = np.column_stack([quadruped.to_engine("pinocchio", q, unit, names)[1] for unit in np.eye(quadruped.nv)])
    pin.computeAllTerms(model, data, *there)
    pin.computeJointJacobiansTimeVariation(model, data, *there)
    pin.updateFramePlacements(model, data)
    return pin, model, data, q, v, order


@pytest.mark.parametrize("representation", REPRESENTATIONS)
def test_representations_agree_with_pinocchio(quadruped: db.Model, frame: str, peer: Any, representation: Any) -> None:
    pin, model, data, q, own, order = peer
    axes = {"body": pin.LOCAL, "mixed": pin.LOCAL_WORLD_ALIGNED, "inertial": pin.WORLD}

    def of_frame(name: str, r: str) -> tuple[Any, Any]:
        index = model.getFrameId(name)
        jacobian = pin.getFrameJacobian(model, data, index, axes[r])
        return jacobian @ order, pin.getFrameJacobianTimeVariation(model, data, index, axes[r]) @ order

    # The velocity of the base in the representation is the Jacobian of its frame there.
    to, rate = np.eye(quadruped.nv), np.zeros((quadruped.nv, quadruped.nv))
    to[:6], rate[:6] = of_frame("root_joint", representation)
    back = np.linalg.inv(to)
    turn = back @ rate
    mass, bias = order.T @ data.M @ order, order.T @ data.nle
    v = to @ own
    base = db.BaseVelocity(quadruped, representation)
    close(base.mass_matrix(q), back.T @ mass @ back)
    close(base.mass_matrix_inverse(q), to @ np.linalg.inv(mass) @ to.T)
    close(base.bias_forces(q, v), back.T @ (bias - mass @ turn @ own))
    gravity = order.T @ pin.computeGeneralizedGravity(model, model.createData(), quadruped.to_engine("pinocchio", q, own, list(model.names))[0])
    close(base.gravity_forces(q), back.T @ gravity)
    close(base.coriolis_matrix(q, v) @ v, back.T @ (bias - mass @ turn @ own - gravity))
    for r in REPRESENTATIONS:
        jacobian, derivative = of_frame(frame, r)
        close(base.frame_jacobian(q, frame, r), jacobian @ back)  # type: ignore[arg-type]
        close(base.frame_jacobian_derivative(q, v, frame, r), (derivative - jacobian @ turn) @ back)  # type: ignore[arg-type]
