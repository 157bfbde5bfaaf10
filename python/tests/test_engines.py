"""Coordinates of other engines: against the engines where they are installed, and what holds without them."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from conftest import OTHER_ALGORITHM, SAME_ALGEBRA, asset

import dualbody as db

ENGINES = ["pinocchio", "mujoco", "jaxsim"]
COUNT = 5


@pytest.fixture(scope="module")
def model() -> db.Model:
    return db.Model.from_urdf(asset("quadruped"), base="floating")


def states(model: db.Model) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    q = np.array([model.random_configuration(k) for k in range(COUNT)])
    v, a = (np.array([model.random_velocity(seed + k) for k in range(COUNT)]) for seed in (100, 200))
    return q, v, a


def close(actual: np.ndarray, expected: np.ndarray) -> None:
    scale = max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(actual, expected, rtol=0, atol=OTHER_ALGORITHM * scale)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_way_there_and_back_is_closed(model: db.Model, engine: str) -> None:
    names = model.joint_names[::-1]
    own, (q, v, a) = db.EngineCoordinates(model, engine, names), states(model)
    np.testing.assert_allclose(own.configuration_from(own.configuration_to(q)), q, atol=SAME_ALGEBRA)
    np.testing.assert_allclose(own.tangent_from(q, own.tangent_to(q, v)), v, atol=SAME_ALGEBRA)
    np.testing.assert_allclose(own.force_from(q, own.force_to(q, v)), v, atol=SAME_ALGEBRA)
    np.testing.assert_allclose(own.acceleration_from(q, v, own.acceleration_to(q, v, a)), a, atol=1e-11)
    mass, jacobian = db.mass_matrix(model, q), db.center_of_mass_jacobian(model, q)
    np.testing.assert_allclose(own.mass_matrix_from(q, own.mass_matrix_to(q, mass)), mass, atol=1e-11)
    np.testing.assert_allclose(own.jacobian_from(q, own.jacobian_to(q, jacobian)), jacobian, atol=1e-11)
    assert own.joint_v(names[0]).start == 6 and own.nq == own.configuration_to(q[0]).size
    again = pickle.loads(pickle.dumps(own))
    np.testing.assert_array_equal(again.configuration_to(q), own.configuration_to(q))


@pytest.mark.parametrize("engine", ENGINES)
def test_energy_power_and_velocities_do_not_depend_on_coordinates(model: db.Model, engine: str) -> None:
    own, (q, v, a) = db.EngineCoordinates(model, engine), states(model)
    theirs = own.tangent_to(q, v)
    energy = 0.5 * np.einsum("ki,kij,kj->k", theirs, own.mass_matrix_to(q, db.mass_matrix(model, q)), theirs)
    close(energy, db.kinetic_energy(model, q, v))
    tau = db.inverse_dynamics(model, q, v, a)
    close(np.einsum("ki,ki->k", own.force_to(q, tau), theirs), np.einsum("ki,ki->k", tau, v))
    jacobian = own.jacobian_to(q, db.center_of_mass_jacobian(model, q))
    close(np.einsum("kij,kj->ki", jacobian, theirs), db.center_of_mass_velocity(model, q, v))


def test_batches_equal_single_states(model: db.Model) -> None:
    q, v, _ = states(model)
    one = db.EngineCoordinates(model, "mujoco")
    together = one.mass_matrix_to(q, db.mass_matrix(model, q))
    for k in range(COUNT):
        np.testing.assert_array_equal(one.tangent_to(q, v)[k], one.tangent_to(q[k], v[k]))
        np.testing.assert_array_equal(together[k], one.mass_matrix_to(q[k], db.mass_matrix(model, q[k])))
    theirs = model.to_engine("pinocchio", q.reshape(1, COUNT, -1), v.reshape(1, COUNT, -1))
    back = model.from_engine("pinocchio", *theirs)
    np.testing.assert_allclose(back[0][0], q, atol=SAME_ALGEBRA)
    np.testing.assert_allclose(back[1][0], v, atol=SAME_ALGEBRA)


def test_a_joint_is_named_once(model: db.Model) -> None:
    names = [*model.joint_names, model.joint_names[0]]
    with pytest.raises(ValueError, match="twice"):
        model.to_engine("mujoco", model.neutral(), np.zeros(model.nv), joint_order=names)
    with pytest.raises(ValueError, match="engine is"):
        db.EngineCoordinates(model, "bullet")


def test_pinocchio_agrees(model: db.Model) -> None:
    pin = pytest.importorskip("pinocchio")
    theirs = pin.buildModelFromXML(db.samples.urdf("quadruped"), pin.JointModelFreeFlyer())
    data, (q, v, a) = theirs.createData(), states(model)
    own = db.EngineCoordinates(model, "pinocchio", list(theirs.names))
    x, dx, ddx = own.configuration_to(q), own.tangent_to(q, v), own.acceleration_to(q, v, a)
    frame = model.link_names[-1]
    jacobian = own.jacobian_to(q, db.frame_jacobian(model, q, frame, "mixed"))
    mass = own.mass_matrix_to(q, db.mass_matrix(model, q))
    # In that engine, damping is not a part of inverse dynamics.
    tau = own.force_to(q, db.inverse_dynamics(model, q, v, a) - model.damping * v)
    for k in range(COUNT):
        upper = np.triu(pin.crba(theirs, data, x[k]))
        close(mass[k], upper + np.triu(upper, 1).T)
        mixed = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        close(jacobian[k], pin.computeFrameJacobian(theirs, data, x[k], theirs.getFrameId(frame), mixed))
        close(tau[k], pin.rnea(theirs, data, x[k], dx[k], ddx[k]))


def test_mujoco_agrees(model: db.Model) -> None:
    mujoco = pytest.importorskip("mujoco")
    theirs = mujoco.MjModel.from_xml_string(model.to_mjcf())
    data, (q, v, a) = mujoco.MjData(theirs), states(model)
    names = [theirs.joint(j).name for j in range(theirs.njnt)]
    own = db.EngineCoordinates(model, "mujoco", names)
    x, dx, ddx = own.configuration_to(q), own.tangent_to(q, v), own.acceleration_to(q, v, a)
    mass = own.mass_matrix_to(q, db.mass_matrix(model, q))
    tau = own.force_to(q, db.inverse_dynamics(model, q, v, a))
    for k in range(COUNT):
        data.qpos[:], data.qvel[:], data.qacc[:] = x[k], dx[k], 0.0
        mujoco.mj_forward(theirs, data)
        energy = 0.5 * dx[k] @ mass[k] @ dx[k]
        product = np.zeros(theirs.nv)
        mujoco.mj_mulM(theirs, data, product, dx[k])
        close(product, mass[k] @ dx[k])
        close(0.5 * dx[k] @ product, energy)
        data.qacc[:] = ddx[k]
        mujoco.mj_inverse(theirs, data)
        # Joint limits are forces of constraints there.
        close(data.qfrc_inverse + data.qfrc_constraint, tau[k])
