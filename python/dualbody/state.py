"""Pose and velocity of the base in a state, and random states within bounds."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING

import numpy as np

from . import _dualbody
from .spatial import Quaternion

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._dualbody import Array, Model, RepresentationName

    Bounds = tuple[float, float]
    ThreeBounds = tuple[Bounds, Bounds, Bounds]

__all__ = ["StateBounds", "base_pose", "base_velocity", "random_state", "with_base_pose", "with_base_velocity"]

_ONE = (-1.0, 1.0)


@dataclass(frozen=True)
class StateBounds:
    """Bounds (lower, upper) of a random state; each coordinate is uniformly distributed between them. Bounds of the base are for floating bases.

    base_position (m), base_linear_velocity (m/s) and base_angular_velocity (rad/s) are in axes of the world; base_roll_pitch_yaw (rad) is None for
    uniformly distributed rotations. joint_position (rad or m) applies to joints of one degree of freedom, within their limits; joint_velocity (rad/s or
    m/s) to each degree of freedom, within the speed limits of the joints.
    """

    base_position: ThreeBounds = (_ONE, _ONE, _ONE)
    base_roll_pitch_yaw: ThreeBounds | None = None
    base_linear_velocity: ThreeBounds = (_ONE, _ONE, _ONE)
    base_angular_velocity: ThreeBounds = (_ONE, _ONE, _ONE)
    joint_position: Bounds = (-float("inf"), float("inf"))
    joint_velocity: Bounds = _ONE


def random_state(model: Model, seed: int, bounds: StateBounds | None = None) -> tuple[Array, Array]:
    """A random (q, v) within bounds; equal seeds give equal states.

    >>> import dualbody as db
    >>> q, v = db.state.random_state(db.samples.cartpole(), 1, db.state.StateBounds(joint_position=(0.1, 0.2)))
    >>> bool((q >= 0.1).all() and (q <= 0.2).all())
    True
    """
    return _dualbody._random_state(model, seed, astuple(bounds or StateBounds()))


def _check(model: Model) -> None:
    if not model.has_floating_base:
        raise ValueError(f"the base of {model.name!r} is fixed: it has no pose and no velocity in q and v")


def base_pose(model: Model, q: ArrayLike) -> Array:
    """Pose of a floating base in the world, (..., 4, 4). q (..., nq)."""
    _check(model)
    return _dualbody.frame_pose(model, q, model.body_names[0])


def with_base_pose(model: Model, q: ArrayLike, pose: ArrayLike) -> Array:
    """Configurations (..., nq) with another pose (..., 4, 4) of the floating base; q (..., nq). The velocity coordinates in the base frame are unchanged."""
    _check(model)
    own, given = np.asarray(q, dtype=float), np.asarray(pose, dtype=float)
    if own.shape[-1:] != (model.nq,) or given.shape[-2:] != (4, 4):
        raise ValueError(f"q and pose have the shapes {own.shape} and {given.shape}, expected (..., {model.nq}) and (..., 4, 4)")
    batch = np.broadcast_shapes(own.shape[:-1], given.shape[:-2])
    out = np.array(np.broadcast_to(own, (*batch, model.nq)))
    given = np.broadcast_to(given, (*batch, 4, 4))
    out[..., :3] = given[..., :3, 3]
    for index in np.ndindex(batch):
        out[(*index, slice(3, 7))] = Quaternion.from_matrix(given[index][:3, :3]).numbers
    return out


def base_velocity(model: Model, q: ArrayLike, v: ArrayLike, representation: RepresentationName = "mixed") -> Array:
    """Velocity [linear; angular] of a floating base, (..., 6), m/s and rad/s. q (..., nq), v (..., nv)."""
    _check(model)
    return _dualbody.velocity_to_representation(model, q, v, representation)[..., :6]


def with_base_velocity(
    model: Model, q: ArrayLike, v: ArrayLike, velocity: ArrayLike, representation: RepresentationName = "mixed"
) -> Array:
    """Velocities (..., nv) with another velocity (..., 6) of the floating base, at its pose in q. q (..., nq), v (..., nv)."""
    _check(model)
    own, given = np.asarray(v, dtype=float), np.asarray(velocity, dtype=float)
    if own.shape[-1:] != (model.nv,) or given.shape[-1:] != (6,):
        raise ValueError(f"v and velocity have the shapes {own.shape} and {given.shape}, expected (..., {model.nv}) and (..., 6)")
    batch = np.broadcast_shapes(own.shape[:-1], given.shape[:-1])
    converted = np.array(np.broadcast_to(own, (*batch, model.nv)))
    converted[..., :6] = given
    return _dualbody.velocity_from_representation(model, q, converted, representation)
