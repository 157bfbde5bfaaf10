"""Forces of contact by pair and by link, in batches and from rollouts."""

import numpy as np
import pytest

import dualbody as db

LOWER, UPPER = 2.0, 1.0
G = 9.81


def tower(law="relaxed", time_step=2e-3):
    """A small box on a large one on the ground."""
    world = db.World()
    world.add_box("lower", (0.4, 0.4, 0.2), mass=LOWER, position=(0, 0, 0.1))
    world.add_box("upper", (0.2, 0.2, 0.2), mass=UPPER, position=(0, 0, 0.3))
    contacts = db.contact.Contacts(law=law, collisions=True)
    return db.Simulator(world.build(), time_step=time_step, contacts=contacts)


def settled(simulator):
    model = simulator.model
    end = simulator.rollout(model.neutral(), np.zeros(model.nv), 300)
    return end.q[-1], end.v[-1]


def test_forces_at_rest_are_weights():
    simulator = tower()
    q, v = settled(simulator)
    found = db.sim.contact_forces(simulator, q, v)
    assert np.allclose(found.force_between("upper", "lower"), [0, 0, UPPER * G], atol=1e-2)
    assert np.array_equal(found.force_between("lower", "upper"), -found.force_between("upper", "lower"))
    assert np.allclose(found.ground.sum(axis=0), [0, 0, (LOWER + UPPER) * G], atol=3e-2)
    assert np.allclose(found.wrench("lower"), [0, 0, LOWER * G, 0, 0, 0], atol=3e-2)
    assert found.are_touching("lower", "upper") and found.is_touching("upper") and found.in_contact.all()
    with pytest.raises(KeyError, match="middle"):
        found.is_touching("middle")


def test_forces_equal_those_of_the_report_in_batches():
    simulator = tower()
    q, v = settled(simulator)
    rng = np.random.default_rng(1)
    qs = simulator.model.integrate(np.broadcast_to(q, (2, 3, len(q))), 1e-3 * rng.standard_normal((2, 3, len(v))))
    qs[1, 2, 9] += 1.0  # the upper one far above
    vs = 1e-2 * rng.standard_normal((2, 3, len(v)))
    found = db.sim.contact_forces(simulator, qs, vs)
    assert found.touching.shape == (2, 3, len(found.link_names)) and found.wrenches.shape == (2, 3, len(found.link_names), 6)
    for k in np.ndindex(2, 3):
        report = simulator.contact_report(qs[k], vs[k])
        n = len(report.pairs)
        assert (found.links[k][n:] == -1).all() and not found.forces[k][n:].any()
        assert np.array_equal(found.wrenches[k], report.links) and np.array_equal(found.ground[k], report.forces)
        for i, pair in enumerate(report.pairs):
            assert tuple(found.link_names[j] for j in found.links[k][i]) == pair.links
            assert np.array_equal(found.forces[k][i], pair.force) and found.depths[k][i] == pair.depth
            frame = found.frames[k][i]
            assert np.array_equal(frame[:3, 2], pair.normal) and np.array_equal(frame[:3, 3], pair.position)
            assert np.allclose(frame[:3, :3].T @ frame[:3, :3], np.eye(3)) and np.linalg.det(frame) > 0
    assert found.are_touching("upper", "lower")[0, 0] and not found.are_touching("upper", "lower")[1, 2]


def test_forces_by_the_jacobians_of_all_points_balance_gravity():
    simulator = tower()
    q, v = settled(simulator)
    found = db.sim.contact_forces(simulator, q, v)
    tau = np.einsum("mij,mi->j", found.jacobians()[:, :3], found.forces)
    tau += np.einsum("mij,mi->j", simulator.contact_jacobians(q)[:, :3], found.ground)
    assert np.abs(tau - db.dynamics.gravity_forces(simulator.model, q)).max() < 0.03


def test_jacobians_give_velocities_and_their_rates_equal_differences():
    simulator = tower()
    q, _ = settled(simulator)
    model = simulator.model
    v = np.sin(1.3 * np.arange(model.nv) + 0.4)
    found = db.sim.contact_forces(simulator, np.stack([q, q]), np.stack([v, 0 * v]))
    velocities = (found.jacobians() @ found.v[:, None, :, None])[..., :3, 0]
    assert np.abs(velocities - found.velocities).max() < 1e-3  # points are half way between those of the links
    # Of points at rest in space the rates of the angular rows are those of the axes alone.
    h = 1e-6
    after, before = (db.sim.contact_forces(simulator, model.integrate(q, s * h * v), v) for s in (1, -1))
    slopes = (after.jacobians() - before.jacobians())[:, 3:] / (2 * h)
    assert np.abs(slopes - found.jacobian_derivatives()[0][:, 3:]).max() < 1e-7
    assert not found.jacobian_derivatives()[1].any()


def test_forces_of_a_rollout_are_those_of_its_states():
    simulator = tower()
    model = simulator.model
    q = np.stack([model.neutral(), model.neutral()])
    q[1, 9] += 0.01
    v = np.zeros((2, model.nv))
    v[1, 8] = -0.1
    rollout = simulator.rollout(q, v, 20)
    found = db.sim.rollout_contact_forces(simulator, rollout)
    assert found.touching.shape == (2, 20, len(found.link_names))
    direct = db.sim.contact_forces(simulator, rollout.q[1, 7], rollout.v[1, 7])
    assert np.array_equal(found.wrenches[1, 7], direct.wrenches)
    assert found.jacobians().shape[-2:] == (6, model.nv)
    one = db.sim.rollout_contact_forces(simulator, rollout[0])
    assert np.array_equal(one.wrenches, found.wrenches[0])


def test_steps_that_were_not_taken_have_no_contact():
    simulator = tower().replace(divergence_bound=0.05)
    model = simulator.model
    q = model.neutral()
    q[9] += 1.0
    q[2] -= 0.001  # the lower one into the ground
    rollout = simulator.rollout(q, np.zeros(model.nv), 20)
    assert rollout.status.kind == "diverged"
    found = db.sim.rollout_contact_forces(simulator, rollout)
    taken = rollout.status.step
    assert found.touching[0].any() and not found.touching[taken:].any()
    assert np.isfinite(found.wrenches).all() and np.isfinite(found.jacobians()).all()


def test_soft_contact_touches():
    law = db.contact.SoftContact(friction=0.5, stiffness=1e4, damping=1.0, stiffness_exponent=0.0, damping_exponent=0.0)
    simulator = tower(law, 1e-4)
    q = simulator.model.neutral()
    q[9] -= 0.001
    found = db.sim.contact_forces(simulator, q, np.zeros(simulator.model.nv))
    assert found.are_touching("upper", "lower") and found.force_between("upper", "lower")[2] > 1.0


def test_robots_without_contact_have_none():
    simulator = db.Simulator(db.samples.arm())
    model = simulator.model
    found = db.sim.contact_forces(simulator, model.neutral(), np.zeros(model.nv))
    assert found.ground.shape == (0, 3) and found.forces.shape == (0, 3) and not found.touching.any()
    assert found.jacobians().shape == (0, 6, model.nv)
