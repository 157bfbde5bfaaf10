"""Worlds: robots and objects in one model."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from conftest import asset

import dualbody as db


def cell() -> db.World:
    world = db.World("cell")
    world.add(db.samples.arm(), prefix="left/", position=(-0.4, 0, 0.7))
    world.add(db.samples.arm(), prefix="right/", position=(0.4, 0, 0.7), quaternion=(0, 0, 0, 1))
    world.add_box("table", (1.2, 0.8, 0.1), fixed=True, position=(0, 0, 0.65))
    world.add_sphere("ball", 0.05, mass=0.2, position=(0, 0, 1), color=(1, 0, 0, 1))
    return world


def test_two_arms_at_a_table_move_as_one_arm() -> None:
    model = cell().build()
    assert (model.nq, model.nv) == (21, 20)
    assert model.joint_names[0] == "ball" and model.joint_names[1].startswith("left/")
    simulator = db.Simulator(model, time_step=0.01)
    assert simulator.nu == 14
    alone = db.Simulator(db.samples.arm(), time_step=0.01)
    rng = np.random.default_rng(1)
    q, v, u = (rng.uniform(-1, 1, (2, 7)) for _ in range(3))
    q_all = np.concatenate([model.neutral()[:7], *q])
    q_next, v_next = simulator.step(q_all, np.concatenate([np.zeros(6), *v]), u.ravel())[:2]
    q_arm, v_arm = alone.step(q[0], v[0], u[0])[:2]
    np.testing.assert_allclose(q_next[7:14], q_arm, atol=1e-12)
    np.testing.assert_allclose(v_next[6:13], v_arm, atol=1e-12)
    assert v_next[2] == pytest.approx(-0.0981)


def test_a_world_pickles_and_does_not_depend_on_the_order() -> None:
    world = cell()
    model = world.build()
    assert pickle.loads(pickle.dumps(model)) == model
    world.remove("left/")
    world.add(db.samples.arm(), prefix="left/", position=(-0.4, 0, 0.7))
    assert world.members == ["ball", "left/", "right/", "table"]
    assert world.build() == model


def test_objects_are_mounted_on_frames() -> None:
    world = db.World(gravity=(0, 0, -1.6))
    world.add(db.samples.arm(), prefix="arm/")
    world.add_cylinder("cup", 0.04, 0.1, on="arm/tool", mass=0.3)
    world.add(db.samples.pendulum(), prefix="bob/", on="arm/tool")
    world.add_capsule("pin", 0.01, 0.2, density=1000.0, has_gravity=False)
    model = world.build()
    mass = db.samples.arm().total_mass + db.samples.pendulum().total_mass + 0.3
    mass += 1000 * np.pi * 0.01**2 * (0.2 + 4 / 3 * 0.01)
    assert model.total_mass == pytest.approx(mass)
    assert model.gravity == (0, 0, -1.6)
    assert "bob/pivot" in model.joint_names


def test_a_state_is_carried_by_name() -> None:
    world = cell()
    before = world.build()
    q, v = before.neutral(), np.arange(20.0)
    world.add_box("another", (0.1, 0.1, 0.1), density=500.0, position=(5, 5, 5))
    world.remove("right/")
    after = world.build()
    q_new, v_new = db.carried_state(before, after, q, v)
    assert after.joint_names[0] == "another"
    np.testing.assert_array_equal(v_new, [*np.zeros(6), *v[:13]])
    np.testing.assert_array_equal(q_new, after.neutral())


def test_mistakes_are_named() -> None:
    world, arm = cell(), db.samples.arm()
    with pytest.raises(ValueError, match="left/"):
        world.add(arm, prefix="left/")
    with pytest.raises(ValueError, match="norm"):
        world.add(arm, prefix="c/", quaternion=(1, 1, 0, 0))
    with pytest.raises(ValueError, match="c/"):
        world.add(arm, prefix="c/", position=(0, float("nan"), 0))
    with pytest.raises(ValueError, match="mass"):
        world.add_sphere("marble", 0.01)
    with pytest.raises(ValueError, match="both"):
        world.add_sphere("marble", 0.01, mass=1.0, density=1.0)
    with pytest.raises(ValueError, match="weight"):
        world.add_sphere("marble", 0.01, weight=1.0)  # type: ignore[call-arg]
    with pytest.raises(KeyError, match="left/"):
        world.remove("lft/")
    assert world.build() == cell().build()
    world.add(arm, prefix="c/", on="left/tol")
    with pytest.raises(KeyError, match="left/tool"):
        world.build()


def test_an_sdf_world_is_read_whole() -> None:
    ball = "<model name='{0}'><pose>0 0 {1} 0 0 0</pose><link name='l'><inertial><mass>1</mass></inertial></link></model>"
    text = f"<sdf version='1.9'><world name='two'>{ball.format('a', 1)}{ball.format('b', 2)}</world></sdf>"
    model = db.Model.from_sdf(text, all_models=True)
    assert model.joint_names == ["a::floating_base", "b::floating_base"]
    both = db.World()
    both.add(model, prefix="near/")
    dog = db.Model.from_urdf(asset("quadruped"))
    both.add(dog, prefix="dog/")
    assert both.build().nv == 12 + dog.nv
