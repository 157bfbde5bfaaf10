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


def test_soft_balls_repel_each_other_by_the_law_of_the_ground():
    model = two_balls()
    law = db.contact.SoftContact(friction=0.5, stiffness=1e4, damping=1.0, stiffness_exponent=0.0, damping_exponent=0.0)
    simulator = db.Simulator(model, contacts=db.contact.Contacts(db.contact.Terrain.flat(-5.0), law, collisions=True))
    q = model.neutral()
    q[7] = -0.51  # of b, beside where it was added: 1 cm into a
    [pair] = simulator.contact_report(q, np.zeros(model.nv)).pairs
    assert np.allclose(pair.force, [-100.0, 0, 0])


def test_materials_of_links_decide_their_restitution():
    model = two_balls()
    law = db.contact.Rigid(friction=0.0)
    materials = {"a": db.contact.Material(0.0, 0.5), "b": db.contact.Material(0.0, 1.0)}
    collisions = db.contact.Collisions(materials=materials)
    simulator = db.Simulator(model, time_step=1e-3, contacts=db.contact.Contacts(db.contact.Terrain.flat(-5.0), law, collisions=collisions))
    q, v = model.neutral(), np.zeros(model.nv)
    v[0] = 1.6
    for _ in range(1000):
        q, v = simulator.step(q, v)[:2]
    assert abs(v[6] - v[0] - 1.6 * 2 / 3) < 1e-12  # 2 · ½ · 1 / 1½
    with pytest.raises(KeyError, match="nobody"):
        unknown = db.contact.Collisions(materials={"nobody": db.contact.Material()})
        db.Simulator(model, contacts=db.contact.Contacts(law="rigid", collisions=unknown))
    with pytest.raises(TypeError, match="Material"):
        db.Simulator(model, contacts=db.contact.Contacts(law="rigid", collisions=db.contact.Collisions(materials={"a": 0.5})))


def balls_on_a_plate(law, depths, **options):
    world = db.World()
    world.add_box("plate", (9, 9, 0.2), fixed=True, position=(0, 0, -0.1))
    for k, depth in enumerate(depths):
        world.add_sphere(f"ball {k}", 0.1, mass=1.0, position=(k, 0, 0.1 - depth))
    contacts = db.contact.Contacts(db.contact.Terrain.flat(-5.0), law, links=[], collisions=db.contact.Collisions(**options))
    return db.Simulator(world.build(), time_step=2e-3, contacts=contacts)


def test_balls_rest_at_the_depth_of_both_materials_or_of_their_pair():
    Material, RelaxedRigid = db.contact.Material, db.contact.RelaxedRigid

    def relaxed(time, d):
        return Material(compliance=RelaxedRigid(time_constant=time, impedance=(0.9, d, 1e-5, 0.5, 2.0)))

    materials = {"plate": relaxed(0.04, 0.9), "ball 0": relaxed(0.02, 0.98)}
    rest = [9.81 * (1 - d) * time**2 for time, d in ((0.03, 0.94), (0.04, 0.9), (0.05, 0.95))]
    pairs = {("ball 2", "plate"): relaxed(0.05, 0.95)}
    simulator = balls_on_a_plate("relaxed", rest, materials=materials, pairs=pairs)
    _, v = simulator.step(simulator.model.neutral(), np.zeros(18))[:2]
    assert abs(v).max() < 1e-12
    names = simulator.parameter_names
    assert "material of pair 0: time constant" in names and "shape 0 of ball 0: time constant" in names
    with pytest.raises(ValueError, match="does not have"):
        balls_on_a_plate("rigid", [0.0], materials=materials)
    with pytest.raises(TypeError, match="names of two links"):
        balls_on_a_plate("rigid", [0.0], pairs={"plate": Material()})
    with pytest.raises(TypeError, match="compliance is of the type str"):
        balls_on_a_plate("rigid", [0.0], materials={"plate": Material(compliance="soft")})
    with pytest.raises(KeyError, match="nobody"):
        balls_on_a_plate("rigid", [0.0], pairs={("plate", "nobody"): Material()})


@pytest.mark.parametrize("speculative", [False, True])
def test_speculative_contact_stops_a_fast_ball_at_a_thin_wall(speculative):
    world = db.World(gravity=(0.0, 0.0, 0.0))
    world.add_box("wall", (0.02, 2, 2), fixed=True)
    world.add_sphere("ball", 0.05, mass=1.0, position=(-1.0, 0, 0))
    model = world.build()
    collisions = db.contact.Collisions(speculative=speculative)
    contacts = db.contact.Contacts(db.contact.Terrain.flat(-5.0), "relaxed", collisions=collisions)
    simulator = db.Simulator(model, time_step=5e-3, contacts=contacts)
    q, v = model.neutral(), np.zeros(model.nv)
    v[0] = 60.0
    for _ in range(20):
        q, v = simulator.step(q, v)[:2]
    assert (v[0] < 1e-6) == speculative


def test_a_ball_rests_on_a_surface():
    world = db.World()
    world.add_box("ground", (0.1, 0.1, 0.1), fixed=True, position=(0, 0, -5))
    world.add_sphere("ball", 0.1, mass=1.0, position=(0.02, 0.3, 0.2))
    model = world.build()
    trough = db.contact.Surface.grid([[1.0, 0.0, 1.0], [1.0, 0.0, 1.0]], (-1.0, -1.0), (1.0, 2.0))
    assert np.shape(trough.triangles) == (4, 3)
    lifted = db.contact.Surface(np.array(trough.vertices) + [0, 0, 5], trough.triangles)
    collisions = db.contact.Collisions(surfaces={"ground": lifted})
    simulator = db.Simulator(model, time_step=5e-3, contacts=db.contact.Contacts(db.contact.Terrain.flat(-9.0), "rigid", collisions=collisions))
    q, v = model.neutral(), np.zeros(model.nv)
    for _ in range(400):
        q, v = simulator.step(q, v)[:2]
    height = db.dynamics.frame_pose(model, q, "ball")[2, 3]
    assert abs(height - 0.1 * np.sqrt(2)) < 1e-6
    with pytest.raises(ValueError, match="vertex 9"):
        broken = db.contact.Collisions(surfaces={"ground": db.contact.Surface([(0, 0, 0)], [(0, 0, 9)])})
        db.Simulator(model, contacts=db.contact.Contacts(law="rigid", collisions=broken))


def test_pairs_of_an_srdf():
    text = '<robot>\n<group name="all"/>\n<disable_collisions link1="link1" link2="link3"/></robot>'
    pairs, rest = db.contact.pairs_of_srdf(db.samples.arm(), text)
    assert pairs == [("link1", "link3")] and len(rest) == 1 and "group" in rest[0]
    db.contact.Collisions(self_collision=True, excluded=pairs)
    with pytest.raises(ValueError, match="left/link1"):
        db.contact.pairs_of_srdf(db.samples.arm(), text, prefix="left/")
    with pytest.raises(FileNotFoundError):
        db.contact.pairs_of_srdf(db.samples.arm(), "/nowhere/arm.srdf")


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


def test_smoothed_distances_have_gradients_that_do_not_jump():
    world = db.World()
    world.add_box("table", (2, 2, 0.2), fixed=True, position=(0, 0, -0.1))
    world.add_box("box", (0.4, 0.2, 0.2), mass=1.0, position=(0, 0, 0.5))
    model = world.build()
    tilted = [model.integrate(model.neutral(), [0, 0, 0, 0, s * 1e-7, 0]) for s in (-1, 1)]
    exact, soft = ([db.contact.nearest(model, q, "table", "box", smoothing=w) for q in tilted] for w in (0.0, 1e-3))
    assert abs(exact[0].gradient[4] - exact[1].gradient[4]) > 0.39
    assert abs(soft[0].gradient[4] - soft[1].gradient[4]) < 1e-4
    assert exact[0].distance - 1e-3 * 2 * np.log(8) < soft[0].distance < exact[0].distance
    assert db.contact.nearest(model, tilted[0], "table", "box").distance == exact[0].distance
    with pytest.raises(ValueError, match="width of -1 m is negative"):
        db.contact.nearest(model, tilted[0], "table", "box", smoothing=-1.0)


def test_bodies_rest_at_the_height_of_their_margins():
    world = db.World()
    world.add_box("plate", (1, 1, 0.2), fixed=True, position=(0, 0, -0.1))
    world.add_sphere("ball", 0.1, mass=1.0, position=(0, 0, 0.13))
    material = db.contact.Material
    collisions = db.contact.Collisions(materials={"plate": material(margin=0.01), "ball": material(margin=0.02)})
    between = db.contact.Contacts(db.contact.Terrain.flat(-1.0), "rigid", collisions=collisions)
    ground = db.contact.Contacts(law="rigid", margins={"ball": 0.03})
    for contacts in (between, ground):
        simulator = db.Simulator(world.build(), contacts=contacts, time_step=1e-3)
        assert abs(simulator.step(simulator.model.neutral(), [0.0] * 6)[1]).max() < 1e-12
    with pytest.raises(ValueError, match="margin"):
        db.Simulator(world.build(), contacts=db.contact.Contacts(margins={"ball": -0.1}))
    with pytest.raises(KeyError, match="bal"):
        db.Simulator(world.build(), contacts=db.contact.Contacts(margins={"bal": 0.1}))


def test_contacts_with_collisions_pickle():
    import pickle

    contacts = db.contact.Contacts(law="rigid", collisions=True)
    assert pickle.loads(pickle.dumps(contacts)) == contacts
    simulator = db.Simulator(two_balls(), contacts=contacts)
    copy = pickle.loads(pickle.dumps(simulator))
    q, v = simulator.model.neutral(), np.full(simulator.model.nv, 0.1)
    assert all(np.array_equal(a, b) for a, b in zip(simulator.step(q, v)[:2], copy.step(q, v)[:2], strict=True))


@pytest.mark.parametrize("law", ["rigid", "relaxed"])
def test_rollouts_with_a_warm_start_are_near_those_without(law):
    world = db.World()
    for k in range(5):
        world.add_box(f"box {k}", (0.2, 0.2, 0.2), mass=1.0, position=(0, 0, 0.1 + 0.201 * k))
    model = world.build()

    def end(warm_start):
        options = db.contact.SolverOptions(warm_start=warm_start)
        contacts = db.contact.Contacts(law=law, solver=options, collisions=True)
        simulator = db.Simulator(model, time_step=2e-3, contacts=contacts)
        return simulator.rollout(model.neutral(), np.zeros(model.nv), steps=30).q[-1]

    cold, warm = end(False), end(True)
    assert np.abs(warm - cold).max() < 1e-6
    assert np.array_equal(end(True), warm)
