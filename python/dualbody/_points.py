"""Kinematics of the contact points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._dualbody import Array, Simulator


class ContactKinematics(NamedTuple):
    """All contact points in the order of ``simulator.contact_points``: positions, velocities and normals of the ground (..., n, 3), depths (..., n), m."""

    positions: Array
    velocities: Array
    normals: Array
    depths: Array


def contact_kinematics(simulator: Simulator, q: ArrayLike, v: ArrayLike) -> ContactKinematics:
    """Positions, velocities, normals and depths of the contact points: a ContactKinematics. q (..., nq), v (..., nv)."""
    return kinematics_of(simulator._contact_points(q, v))


def kinematics_of(x: Any) -> ContactKinematics:
    """The parts of what is known of points, (..., n, 10)."""
    return ContactKinematics(x[..., 0:3], x[..., 3:6], x[..., 6:9], x[..., 9])
