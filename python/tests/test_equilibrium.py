"""Poses that can be held, and regulators about them."""

from __future__ import annotations

import numpy as np
import pytest

import dualbody as db
from dualbody.contact import Contacts, SoftContact

FEET = ["FR_foot", "FL_foot", "RR_foot", "RL_foot"]


@pytest.fixture(scope="module")
def standing(quadruped: db.Model) -> db.Simulator:
    contacts = Contacts(law=SoftContact.estimate(quadruped.total_mass, 4, 2e-3), links=FEET)
    return db.Simulator(
        quadruped, contacts=contacts, actuation="model", integrator="implicit_velocity", time_step=2e-3
    )


def crouching(model: db.Model) -> np.ndarray:
    q = model.neutral()
    q[7:] = np.tile([0.0, 0.8, -1.6], 4)
    return q


def test_a_quadruped_stands_and_returns_after_a_push(standing: db.Simulator) -> None:
    model = standing.model
    rest = db.control.Equilibrium.find(standing, crouching(model))
    weight = np.diag([100.0] * 6 + [1.0] * 12 + [0.1] * 18)
    regulator = rest.lqr(weight, 0.1 * np.eye(12))
    assert regulator.spectral_radius < 1
    assert (regulator.bristles, regulator.dropped) == ([0, 1, 2, 3], [])
    v = np.zeros(18)
    v[1], v[3] = 0.1, 0.2
    stood = standing.rollout(
        rest.q, v, steps=1500, contact=rest.contact, control=lambda k, q, v: regulator.control(q, v)
    )
    assert np.abs(model.difference(rest.q, stood.q[-1])).max() < 1e-2
    batch = regulator.control(stood.q[-3:], stood.v[-3:])
    np.testing.assert_array_equal(batch[1], regulator.control(stood.q[-2], stood.v[-2]))


def test_what_is_not_held_says_so(quadruped: db.Model) -> None:
    falling = db.Simulator(quadruped)
    with pytest.raises(ValueError, match="not held"):
        db.control.Equilibrium.find(falling, quadruped.neutral())
    assert not db.control.Equilibrium.find(falling, quadruped.neutral(), check=False).is_found
    with pytest.raises(ValueError, match="one state is expected"):
        db.control.Equilibrium.find(falling, np.stack([quadruped.neutral()] * 2))


def test_weights_of_wrong_shapes_are_refused(standing: db.Simulator) -> None:
    rest = db.control.Equilibrium.find(standing, crouching(standing.model))
    with pytest.raises(ValueError, match=r"q has the shape \(48, 48\), expected \(36, 36\)"):
        rest.lqr(np.eye(48), np.eye(12))
