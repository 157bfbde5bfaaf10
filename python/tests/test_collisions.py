"""Bodies that touch each other, and distances between links."""

import numpy as np
import pytest

import dualbody as db


def two_balls():
    world = db.World(gravity=(0.0, 0.0, 0.0))
    world.add_sphere("a", 0.15, mass=1.0, position=(-0.3, 0, 0))
    world.add_sphere("b", 0.15, mass=1.0, position=(0.5, 0, 0))
    return world.build()


@pytest.mark.parametrize("dt", [1e-3, 1e-2])
def test_equal_balls_exchange_their_velocities(dt):
    model = two_balls()
    law = db.contact.Rigid(friction=0.0, restitution=1.0)
    contacts = db.contact.Contacts(db.contact.Terrain.flat(-5.0), law, collisions=True)
    simulator = db.Simulator(model, time_step=dt, contacts=contacts)
    q, v = model.neutral(), np.zeros(model.nv)
    v[0] = 1.6
    for _ in range(round(1.0 / dt)):
        q, v = simulator.step(q, v)[:2]
    assert abs(v[0]) < 1e-12 and abs(v[6] - 1.6) < 1e-12


def test_a_report_names_the_links_that_touch():
    model = two_balls()
    contacts = db.contact.Contacts(db.contact.Terrain.flat(-5.0), "relaxed", collisions=db.contact.Collisions())
    simulator = db.Simulator(model, contacts=contacts)
    q = model.neutral()
    q[7] = -0.51  # of b, beside where it was added: 1 cm into a
    [pair] = simulator.contact_report(q, np.zeros(model.nv)).pairs
    assert pair.links == ("a", "b") and abs(pair.depth - 0.01) < 1e-12
    assert pair.force[0] < -1.0 and np.allclose(pair.normal, [-1, 0, 0])


def test_excluded_links_and_unknown_ones():
    model = two_balls()
    excluded = db.contact.Collisions(excluded=[("a", "b")])
    contacts = db.contact.Contacts(db.contact.Terrain.flat(-5.0), "relaxed", collisions=excluded)
    simulator = db.Simulator(model, contacts=contacts)
    q = model.neutral()
    q[7] = -0.51
    assert simulator.contact_report(q, np.zeros(model.nv)).pairs == []
    unknown = db.contact.Collisions(excluded=[("a", "nobody")])
    with pytest.raises(KeyError, match="nobody"):
        db.Simulator(model, contacts=db.contact.Contacts(law="relaxed", collisions=unknown))
    with pytest.raises(ValueError, match="soft"):
        db.Simulator(model, contacts=db.contact.Contacts(law="soft", collisions=True))


def test_distances_of_links_have_gradients():
    world = db.World()
    arm = db.samples.arm()
    world.add_sphere("ball", 0.1, mass=1.0, position=(0.1, 0.2, 1.0))
    world.add_box("table", (1, 1, 0.2), fixed=True)
    world.add(arm, prefix="left/")
    model = world.build()
    rng = np.random.default_rng(0)
    q = model.integrate(model.neutral(), 0.3 * rng.standard_normal(model.nv))
    near = db.contact.nearest(model, q, "ball", "table")
    assert near.points.shape == (2, 3) and near.normal.shape == (3,) and near.gradient.shape == (model.nv,)
    assert np.allclose(near.points[1] - near.points[0], near.distance * near.normal)
    for k in range(model.nv):
        dq = np.zeros(model.nv)
        dq[k] = 1e-6
        after, before = (db.contact.nearest(model, model.integrate(q, s * dq), "ball", "table").distance for s in (1, -1))
        assert abs((after - before) / 2e-6 - near.gradient[k]) < 1e-7
    with pytest.raises(KeyError, match="tabel"):
        db.contact.nearest(model, q, "ball", "tabel")


def test_contacts_with_collisions_pickle():
    import pickle

    contacts = db.contact.Contacts(law="rigid", collisions=True)
    assert pickle.loads(pickle.dumps(contacts)) == contacts
    simulator = db.Simulator(two_balls(), contacts=contacts)
    copy = pickle.loads(pickle.dumps(simulator))
    q, v = simulator.model.neutral(), np.full(simulator.model.nv, 0.1)
    assert all(np.array_equal(a, b) for a, b in zip(simulator.step(q, v)[:2], copy.step(q, v)[:2], strict=True))
