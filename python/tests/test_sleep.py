"""Resting islands that sleep."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import dualbody as db
from dualbody.contact import Contacts, Rigid, Terrain


def simulator(sleeping: Any) -> db.Simulator:
    world = db.World()
    world.add_box("low", (0.2, 0.2, 0.2), mass=1.0, position=(0.0, 0.0, 0.1))
    world.add_box("top", (0.2, 0.2, 0.2), mass=1.0, position=(0.0, 0.0, 0.3))
    world.add_sphere("ball", 0.1, mass=1.0, position=(1.0, 0.0, 0.1))
    contacts = Contacts(Terrain.flat(0.0), Rigid(), collisions=True)
    return db.Simulator(world.build(), contacts=contacts, time_step=2e-3, sleeping=sleeping)


def rested(own: db.Simulator) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    rollout = own.rollout(own.model.neutral(), np.zeros(own.model.nv), 100)
    return rollout.q[-1], rollout.v[-1], rollout.contact[-1]


def test_what_sleeps_is_in_the_state() -> None:
    own = simulator((1e-3, 0.05))
    assert own.n_sleep == own.n_contact == 2 * 3
    state = rested(own)
    assert own.asleep(*state) == ["ball", "low", "top"] and not state[1].any()
    assert own.asleep(*state[:2]) == []
    for same in (copy.deepcopy(state), pickle.loads(pickle.dumps(state))):
        q, v, contact = own.step(*same[:2], contact=same[2])
        assert (q == state[0]).all() and (contact == state[2]).all() and not v.any()
    other = pickle.loads(pickle.dumps(own))
    assert other.asleep(*state) == ["ball", "low", "top"]


def test_a_push_wakes_an_island() -> None:
    own, plain = simulator((1e-3, 0.05)), simulator(None)
    q, v, contact = rested(own)
    v = v.copy()
    v[own.model.joint_v("top").start] = 0.5
    assert own.asleep(q, v, contact) == ["ball"]
    pushed = own.step(q, v, contact=contact)
    assert own.asleep(*pushed) == ["ball"]
    boxes = slice(own.model.joint_v("low").start, own.model.joint_v("top").stop)
    assert (pushed[1][boxes] == plain.step(q, v)[1][boxes]).all()


def test_batches_sleep_and_derivatives_do_not() -> None:
    own, plain = simulator((1e-3, 0.05)), simulator(False)
    q, v, contact = rested(own)
    many = own.step(np.stack([q] * 3), np.stack([v] * 3), contact=np.stack([contact] * 3))
    assert (many[0] == q).all() and (many[2] == contact).all()
    (a, _), (b, _) = own.linearize(q, v, contact=contact), plain.linearize(q, v)
    assert (a == b).all()


def test_bad_thresholds_are_refused() -> None:
    for bad in ((np.nan, 0.1), (0.1, -1.0), (np.inf, 0.1)):
        with pytest.raises(ValueError, match="islands sleep"):
            simulator(bad)
    with pytest.raises(ValueError, match="expected True, False"):
        simulator("often")
    assert simulator(True).n_sleep == 6 and simulator(False).n_sleep == 0


def test_weights_of_contact_skip_what_sleeps() -> None:
    world = db.World()
    for k in range(2):
        world.add_sphere(f"ball {k}", 0.1, mass=1.0, position=(k, 0.0, 0.0999))
    contacts = Contacts(Terrain.flat(0.0), db.contact.SoftContact.estimate(1.0, 1, 1e-3))
    awake, asleep = (db.Simulator(world.build(), contacts=contacts, time_step=1e-3, sleeping=own) for own in (False, True))
    assert asleep.n_contact == awake.n_contact + asleep.n_sleep and asleep.n_sleep > 0
    v, steps = np.tile([0.3, 0.1, 0.0, 0.0, 0.0, 0.0], 2), 20
    weights = np.random.default_rng(1).normal(size=(steps + 1, awake.n_contact))
    padded = np.concatenate([weights, np.ones((steps + 1, asleep.n_sleep))], axis=1)
    q, inputs = awake.model.neutral(), np.zeros((steps, awake.nu))
    expected = awake.rollout_vjp(q, v, inputs, by_contact=weights)
    assert np.abs(expected.start).max() > 0.1
    np.testing.assert_allclose(asleep.rollout_vjp(q, v, inputs, by_contact=padded).start, expected.start, rtol=1e-12, atol=1e-12)
