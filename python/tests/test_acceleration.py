"""Accelerations of a simulator at a moment."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import OTHER_ALGORITHM, SAME_ALGEBRA, asset

import dualbody as db
from dualbody.contact import Contacts, Rigid, SoftContact, Terrain
from dualbody.sim import Actuation, Actuator, Anchor, ExternalForce


def states(model: db.Model, n: int) -> tuple[np.ndarray, np.ndarray]:
    q = np.stack([model.random_configuration(k) for k in range(n)])
    return q, np.stack([model.random_velocity(100 + k) for k in range(n)])


def test_an_acceleration_is_forward_dynamics(quadruped: db.Model) -> None:
    simulator = db.Simulator(quadruped)
    q, v = states(quadruped, 5)
    u = np.random.default_rng(3).normal(size=(5, simulator.nu))
    tau = np.zeros((5, quadruped.nv))
    tau[:, simulator.actuated] = u
    a = simulator.acceleration(q, v, u)
    expected = db.forward_dynamics(quadruped, q, v, tau)
    assert a.shape == (5, quadruped.nv)
    np.testing.assert_allclose(a, expected, atol=OTHER_ALGORITHM * np.abs(expected).max())
    np.testing.assert_array_equal(simulator.acceleration(q[2], v[2], u[2]), a[2])
    np.testing.assert_array_equal(simulator.acceleration(q[2], v), simulator.acceleration(np.stack([q[2]] * 5), v, 0 * u))
    assert simulator.acceleration(q[:4].reshape(2, 2, -1), v[0]).shape == (2, 2, quadruped.nv)
    assert simulator.acceleration(q[:0], v[:0]).shape == (0, quadruped.nv)


@pytest.mark.parametrize("integrator", ["semi_implicit_euler", "runge_kutta_4"])
def test_an_acceleration_is_the_rate_of_short_steps(panda: db.Model, integrator: db.sim.IntegratorName) -> None:
    # 2 D(h / 2) - D(h) with D(h) = (v(h) - v) / h is v̇ up to h². Steps of Euler take friction at their end.
    simulator = db.Simulator(panda, integrator=integrator, actuation="model")
    q, v = panda.random_configuration(4), 0.1 * panda.random_velocity(5)
    u = np.random.default_rng(6).normal(size=simulator.nu)
    h = 1e-5
    whole, half = ((simulator.replace(time_step=dt).step(q, v, u)[1] - v) / dt for dt in (h, h / 2))
    a = simulator.acceleration(q, v, u)
    np.testing.assert_allclose(2 * half - whole, a, atol=1e-5 * np.abs(a).max())


def test_an_acceleration_has_motors_and_contact() -> None:
    pendulum = db.samples.pendulum()
    weak = db.Simulator(pendulum, actuation=Actuation("ideal", {pendulum.joint_names[0]: Actuator(effort=1.0)}))
    # v̇ = 3 u / (m l²) with 1 kg and 1 m
    np.testing.assert_allclose(weak.acceleration([0.0], [0.0], [50.0]), [3.0], atol=SAME_ALGEBRA)
    box = db.Model.from_urdf(asset("box"))
    law = SoftContact.estimate(box.total_mass, 4, 1e-3)
    soft = db.Simulator(box, contacts=Contacts(Terrain.flat(), law))
    q, v = box.neutral(), np.zeros(6)
    q[2] = 1.0
    np.testing.assert_allclose(soft.acceleration(q, v), [0, 0, -9.81, 0, 0, 0], atol=SAME_ALGEBRA)
    q[2] = 0.0595  # half a millimetre deep
    force = soft.contact_report(q, v).forces[:, 2].sum()
    assert force > 1.0
    up = soft.acceleration(q, v, contact=soft.neutral_contact())[2]
    assert up == pytest.approx(force / box.total_mass - 9.81, rel=OTHER_ALGORITHM)


def test_rigid_contact_accelerates_by_its_mean_over_a_step() -> None:
    box = db.Model.from_urdf(asset("box"))
    simulator = db.Simulator(box, time_step=1e-3, contacts=Contacts(law=Rigid()))
    q, v = box.neutral(), np.array([0.1, 0.0, -1.0, 0.0, 0.0, 0.0])
    q[2] = 0.0599  # the box is 0.12 m high
    a = simulator.acceleration(q, v)
    assert a[2] > 100.0
    np.testing.assert_allclose(v + 1e-3 * a, simulator.step(q, v)[1], atol=OTHER_ALGORITHM)


def test_forces_by_name_accelerate_as_external_forces(quadruped: db.Model) -> None:
    simulator, link = db.Simulator(quadruped), quadruped.link_names[-1]
    q, v = states(quadruped, 3)
    force = (1.0, -2.0, 3.0, 0.1, 0.2, -0.3)
    external = simulator.replace(external_forces=[ExternalForce(Anchor(link), force, "body")])
    expected = external.acceleration(q, v)
    a = simulator.acceleration(q, v, forces={link: force}, representation="body")
    np.testing.assert_allclose(a, expected, atol=OTHER_ALGORITHM * np.abs(expected).max())
    np.testing.assert_array_equal(simulator.acceleration(q, v, forces={}), simulator.acceleration(q, v))
    with pytest.raises(ValueError, match="not both"):
        simulator.acceleration(q, v, forces={link: force}, models=[quadruped] * 3)


def test_each_state_of_a_batch_may_have_a_robot_of_its_own() -> None:
    pendulum = db.samples.pendulum()
    heavy = pendulum.with_link_mass(pendulum.link_names[-1], 2.0)
    simulator = db.Simulator(pendulum)
    own = simulator.acceleration([[0.4]] * 2, [[0.0]] * 2, [[1.0]] * 2, models=[pendulum, heavy])
    for a, model in zip(own, (pendulum, heavy)):
        np.testing.assert_allclose(a, db.forward_dynamics(model, [0.4], [0.0], [1.0]), atol=SAME_ALGEBRA)
    with pytest.raises(ValueError, match="models are for a batch"):
        simulator.acceleration([0.4], [0.0], models=[heavy])
    with pytest.raises(ValueError, match="1 models for 2 states"):
        simulator.acceleration([[0.4]] * 2, [0.0], models=[heavy])


def test_an_acceleration_is_written_to_out() -> None:
    simulator = db.Simulator(db.samples.cartpole())
    q, v = np.array([[0.1, 0.2], [0.3, 0.4]]), np.array([[1.0, 2.0], [3.0, 4.0]])
    expected = simulator.acceleration(q, v)
    assert simulator.acceleration(q, v, out=v) is v
    np.testing.assert_array_equal(v, expected)
    with pytest.raises(ValueError, match="^out has the shape"):
        simulator.acceleration(q, v, out=np.zeros(2))
    with pytest.raises(ValueError, match=r"^u has the shape \[3\]"):
        simulator.acceleration(q, v, [0, 0, 0])
    with pytest.raises(ValueError, match="pivot"):
        simulator.acceleration([0, np.nan], [0, 0])
