"""Masses by link, all links at once, the base and random states, contact frames, forces by name, spatial values."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from conftest import SAME_ALGEBRA, asset

import dualbody as db
from dualbody.contact import Contacts
from dualbody.sim import Anchor, ExternalForce, contact_kinematics, named_inputs
from dualbody.spatial import Quaternion, Transform
from dualbody.state import StateBounds, base_pose, base_velocity, random_state, with_base_pose, with_base_velocity


def close(actual: Any, expected: Any, tolerance: float = SAME_ALGEBRA) -> None:
    np.testing.assert_allclose(actual, expected, atol=tolerance)


def test_links_have_their_own_inertias(quadruped: db.Model) -> None:
    q = quadruped.random_configuration(1)
    masses, inertias, names = quadruped.link_masses, quadruped.link_inertias, quadruped.link_names
    assert masses.sum() == pytest.approx(quadruped.total_mass)
    poses = db.forward_kinematics(quadruped, q)
    moment = np.zeros(3)
    for k, name in enumerate(names):
        assert quadruped.link_mass(name) == masses[k]
        np.testing.assert_array_equal(quadruped.link_inertia(name), inertias[k])
        if masses[k] > 0.0:
            moment += masses[k] * (poses[k, :3, :3] @ quadruped.link_center_of_mass(name) + poses[k, :3, 3])
    close(moment / masses.sum(), db.center_of_mass(quadruped, q))
    with pytest.raises(KeyError, match="tunk"):
        quadruped.link_mass("tunk")


def test_all_links_move_as_each_does(quadruped: db.Model) -> None:
    q = np.stack([quadruped.random_configuration(k) for k in range(3)])
    v = np.random.default_rng(1).uniform(-1, 1, (3, quadruped.nv))
    a = np.random.default_rng(2).uniform(-1, 1, (3, quadruped.nv))
    names = quadruped.link_names
    for r in ("body", "mixed", "inertial"):
        jacobians, rates = db.link_jacobians(quadruped, q, r), db.link_jacobian_derivatives(quadruped, q, v, r)  # type: ignore[arg-type]
        assert jacobians.shape == (3, len(names), 6, quadruped.nv)
        for k, name in enumerate(names):
            np.testing.assert_array_equal(jacobians[:, k], db.frame_jacobian(quadruped, q, name, r))  # type: ignore[arg-type]
            np.testing.assert_array_equal(rates[:, k], db.frame_jacobian_derivative(quadruped, q, v, name, r))  # type: ignore[arg-type]
        close(db.link_velocities(quadruped, q, v, r), np.einsum("blij,bj->bli", jacobians, v))  # type: ignore[arg-type]
        expected = np.einsum("blij,bj->bli", jacobians, a) + np.einsum("blij,bj->bli", rates, v)
        close(db.link_accelerations(quadruped, q, v, a, r), expected, 1e-11)  # type: ignore[arg-type]


def test_moves_and_differences_have_jacobians(quadruped: db.Model) -> None:
    q, v = quadruped.random_configuration(2), quadruped.random_velocity(3)
    h = 1e-6
    moved = (quadruped.integrate(q, h * v) - quadruped.integrate(q, -h * v)) / (2 * h)
    close(quadruped.integrate_jacobian(q) @ v, moved, 1e-8)
    close(quadruped.difference_jacobian(q) @ quadruped.integrate_jacobian(q), np.eye(quadruped.nv))
    q1, v1 = quadruped.random_configuration(4), quadruped.random_velocity(5)
    dx = quadruped.deviation(q1, v1, q, v)
    close(dx, np.concatenate([quadruped.difference(q, q1), v1 - v]))
    assert quadruped.deviation(np.stack([q, q1]), v, q, v).shape == (2, 2 * quadruped.nv)


def test_the_base_is_where_it_was_put(quadruped: db.Model, panda: db.Model) -> None:
    q, v = quadruped.random_configuration(6), quadruped.random_velocity(7)
    pose = Transform(Quaternion.from_roll_pitch_yaw(0.3, -0.2, 2.0), (1.0, 2.0, 0.5))
    placed = with_base_pose(quadruped, q, pose)
    close(base_pose(quadruped, placed), pose.matrix)
    np.testing.assert_array_equal(placed[7:], q[7:])
    for r in ("body", "mixed", "inertial"):
        moving = with_base_velocity(quadruped, placed, v, [1, 2, 3, 4, 5, 6], r)  # type: ignore[arg-type]
        close(base_velocity(quadruped, placed, moving, r), [1, 2, 3, 4, 5, 6])  # type: ignore[arg-type]
        np.testing.assert_array_equal(moving[6:], v[6:])
    assert with_base_pose(quadruped, np.stack([q, q]), pose).shape == (2, quadruped.nq)
    with pytest.raises(ValueError, match="is fixed"):
        base_pose(panda, panda.neutral())


def test_random_states_keep_their_bounds(quadruped: db.Model) -> None:
    still, upright = ((0.0, 0.0),) * 3, ((0.0, 0.0),) * 3
    bounds = StateBounds(
        base_position=((0.0, 1.0), (0.0, 1.0), (0.5, 0.5)),
        base_roll_pitch_yaw=upright,  # type: ignore[arg-type]
        base_linear_velocity=still,  # type: ignore[arg-type]
        joint_velocity=(0.1, 0.2),
    )
    q, v = random_state(quadruped, 8, bounds)
    assert q[2] == 0.5 and (0 <= q[:2]).all() and (q[:2] <= 1).all()
    close(q[3:7], [1, 0, 0, 0])
    close(v[:3], 0)
    assert (v[6:] >= 0.1).all() and (v[6:] <= 0.2).all()
    np.testing.assert_array_equal(random_state(quadruped, 8, bounds)[0], q)
    with pytest.raises(ValueError, match="above the upper bound"):
        random_state(quadruped, 8, StateBounds(joint_velocity=(1.0, -1.0)))


@pytest.fixture(scope="module")
def on_ground() -> db.Simulator:
    return db.Simulator(db.Model.from_urdf(asset("box")), contacts=Contacts())


def test_points_of_contact_move_by_their_jacobians(on_ground: db.Simulator) -> None:
    model = on_ground.model
    q = np.stack([model.random_configuration(k) for k in range(4)])
    v = np.random.default_rng(9).uniform(-1, 1, (4, model.nv))
    points = contact_kinematics(on_ground, q, v)
    n = len(on_ground.contact_points)
    assert points.positions.shape == (4, n, 3) and points.depths.shape == (4, n)
    jacobians = on_ground.contact_jacobians(q)
    assert jacobians.shape == (4, n, 6, model.nv)
    close(np.einsum("bnij,bj->bni", jacobians[:, :, :3], v), points.velocities)
    frames = on_ground.contact_frames(q)
    close(frames[..., :3, 3], points.positions)
    link = on_ground.contact_points[0][0]
    close(frames[:, 0, :3, :3], db.frame_pose(model, q, link)[:, :3, :3])
    h = 1e-6
    ahead, behind = (on_ground.contact_jacobians(model.integrate(q, s * h * v)) for s in (1, -1))
    close(on_ground.contact_jacobian_derivatives(q, v), (ahead - behind) / (2 * h), 1e-8)


def test_links_below_the_ground_are_in_contact(on_ground: db.Simulator) -> None:
    q = np.stack([on_ground.model.neutral()] * 2)
    q[0, 2], q[1, 2] = 5.0, -0.01
    flags = on_ground.links_in_contact(q)
    assert flags.dtype == bool and not flags[0].any() and flags[1].any()
    with pytest.raises(ValueError, match="no contacts"):
        db.Simulator(on_ground.model).links_in_contact(q)


def test_joint_forces_and_inputs_go_by_name(quadruped: db.Model) -> None:
    name = quadruped.joint_names[2]
    tau = db.joint_forces(quadruped, {name: [1.0, 2.0]})
    assert tau.shape == (2, quadruped.nv) and tau[1, quadruped.joint_v(name)] == 2.0 and tau.sum() == 3.0
    with pytest.raises(KeyError, match="nobody"):
        db.joint_forces(quadruped, {"nobody": 1.0})
    simulator = db.Simulator(quadruped)
    u = named_inputs(simulator, {name: 3.0})
    assert u[simulator.input_names.index(name)] == 3.0 and u.sum() == 3.0
    with pytest.raises(KeyError, match="nobody"):
        named_inputs(simulator, {"nobody": 1.0})


def test_a_step_with_forces_by_name_equals_one_with_external_forces(quadruped: db.Model) -> None:
    simulator, link = db.Simulator(quadruped), quadruped.link_names[-1]
    q, v = quadruped.random_configuration(10), quadruped.random_velocity(11)
    u = np.random.default_rng(12).uniform(-1, 1, simulator.nu)
    force = (1.0, -2.0, 3.0, 0.1, 0.2, -0.3)
    for r in ("body", "mixed", "inertial"):
        external = simulator.replace(external_forces=[ExternalForce(Anchor(link), force, r)])  # type: ignore[arg-type]
        expected = external.step(q, v, u)
        for actual, part in zip(simulator.step(q, v, u, forces={link: force}, representation=r), expected):  # type: ignore[arg-type]
            close(actual, part)
    many = simulator.step(np.stack([q] * 3), v, forces={link: np.array([force] * 3)})
    close(many[1][2], simulator.step(q, v, forces={link: force})[1])
    for a, b in zip(simulator.step(q, v, u, forces={}), simulator.step(q, v, u)):
        np.testing.assert_array_equal(a, b)
    with pytest.raises(ValueError, match="shape"):
        simulator.step(q, v, forces={link: [1.0]})
    with pytest.raises(KeyError, match="nobody"):
        simulator.step(q, v, forces={"nobody": force})
    with pytest.raises(ValueError, match="inertial"):
        simulator.step(q, v, forces={link: force}, representation="wrold")  # type: ignore[arg-type]


def test_poses_compose_invert_and_pickle() -> None:
    a = Transform(Quaternion.from_roll_pitch_yaw(0.3, -0.2, 2.0), (1.0, 2.0, 0.5))
    b = Transform(Quaternion.exp([0.4, -1.0, 0.6]), (0.2, 0.7, -1.5))
    close((a @ b).matrix, a.matrix @ b.matrix)
    close((a @ a.inverse()).matrix, np.eye(4))
    close((a @ b).adjoint, a.adjoint @ b.adjoint)
    close(a.adjoint_inverse, np.linalg.inv(a.adjoint))
    close(a.force_adjoint, np.linalg.inv(a.adjoint).T)
    close(a.force_adjoint_inverse, a.adjoint.T)
    close(Transform.exp(a.log()).matrix, a.matrix)
    close(Transform.from_matrix(a.matrix).matrix, a.matrix)
    close(a.point([[1.0, 2.0, 3.0]])[0], a.matrix[:3, :3] @ [1, 2, 3] + a.matrix[:3, 3])
    close(np.asarray(a), a.matrix)
    assert pickle.loads(pickle.dumps(a)) == a and a != b and hash(a) == hash(pickle.loads(pickle.dumps(a)))
    assert eval(repr(a)) == a
    with pytest.raises(AttributeError):
        a.translation = (0.0, 0.0, 0.0)  # type: ignore[misc]


def test_rotations_have_angles_vectors_and_matrices() -> None:
    q = Quaternion.from_roll_pitch_yaw(0.3, -0.2, 2.0)
    close(q.roll_pitch_yaw, (0.3, -0.2, 2.0))
    x, y, z = (np.array(Quaternion.exp(axis).matrix) for axis in ([0.3, 0, 0], [0, -0.2, 0], [0, 0, 2.0]))
    close(q.matrix, z @ y @ x)
    close(Quaternion.exp(q.log()).matrix, q.matrix)
    close(Quaternion.from_matrix(q.matrix).numbers, q.numbers)
    close((q @ q.inverse()).numbers, Quaternion.identity().numbers)
    close(q.rotate([[1.0, 0.0, 0.0]])[0], q.matrix[:, 0])
    with pytest.raises(ValueError, match="norm"):
        Quaternion(1.0, 1.0, 0.0, 0.0)
    with pytest.raises(ValueError, match="not a rotation"):
        Quaternion.from_matrix(np.diag([1.0, 1.0, -1.0]))


# The motion of a frame through the adjoint is that of the dynamics: inertial = adjoint of the pose times body.
def test_adjoint_maps_velocities_of_frames(quadruped: db.Model) -> None:
    q, v, name = quadruped.random_configuration(13), quadruped.random_velocity(14), quadruped.link_names[-1]
    pose = Transform.from_matrix(db.frame_pose(quadruped, q, name))
    close(pose.adjoint @ db.frame_velocity(quadruped, q, v, name, "body"), db.frame_velocity(quadruped, q, v, name, "inertial"))
