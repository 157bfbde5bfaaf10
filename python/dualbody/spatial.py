"""Rotations and poses as values: `Quaternion`, `Transform`.

>>> from dualbody.spatial import Quaternion, Transform
>>> turn = Transform(Quaternion.from_roll_pitch_yaw(0.0, 0.0, 0.5), (1.0, 0.0, 0.0))
>>> (turn @ Transform(translation=(0.0, 0.0, 2.0))).translation
(1.0, 0.0, 2.0)

A pose X of frame B in frame A maps quantities expressed in B to A. A Transform can be used for any argument that is a pose (4, 4).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from . import _dualbody

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from ._dualbody import Array, Vector3

__all__ = ["Quaternion", "Transform"]

#: Tolerance on the norm of a quaternion and on the orthonormality of a matrix: single precision keeps it.
_TOLERANCE = 1e-6


def _numbers(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    array = np.asarray(value, dtype=float)
    if array.shape != shape or not np.isfinite(array).all():
        raise ValueError(f"{name} is {value!r}, expected finite numbers of the shape {shape}")
    return array


@dataclass(frozen=True)
class Quaternion:
    """A rotation as a quaternion (w, x, y, z) of unit norm; its negative is the same rotation, but not equal."""

    w: float = 1.0
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    def __post_init__(self) -> None:
        numbers = _numbers("a quaternion", self.numbers, (4,))
        norm = float(np.linalg.norm(numbers))
        if abs(norm - 1.0) > _TOLERANCE:
            raise ValueError(f"{self.numbers} has the norm {norm}: a quaternion of a rotation has 1")
        for name, number in zip("wxyz", numbers.tolist()):
            object.__setattr__(self, name, number)

    @staticmethod
    def identity() -> Quaternion:
        """No rotation."""
        return Quaternion()

    @staticmethod
    def from_matrix(matrix: ArrayLike) -> Quaternion:
        """The rotation of a matrix (3, 3), with w not negative."""
        given = _numbers("a rotation matrix", matrix, (3, 3))
        if np.abs(given.T @ given - np.eye(3)).max() > _TOLERANCE or np.linalg.det(given) < 0.0:
            raise ValueError(f"{matrix!r} is not a rotation")
        return _quaternion("from_matrix", given.ravel())

    @staticmethod
    def from_roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> Quaternion:
        """Rotation by three angles (rad) about the fixed axes x, y, z in this order, as in URDF and SDF."""
        return _quaternion("from_roll_pitch_yaw", _numbers("angles", (roll, pitch, yaw), (3,)))

    @staticmethod
    def exp(vector: ArrayLike) -> Quaternion:
        """Rotation by a rotation vector (3,): about it, by its length, rad."""
        return _quaternion("exp", _numbers("a rotation vector", vector, (3,)))

    def log(self) -> Array:
        """The rotation vector (3,), rad, of length at most π."""
        return np.array(_dualbody._rotation("log", list(self.numbers)))

    @property
    def numbers(self) -> tuple[float, float, float, float]:
        """The numbers (w, x, y, z)."""
        return (self.w, self.x, self.y, self.z)

    @property
    def matrix(self) -> Array:
        """The rotation matrix, (3, 3): its columns are the rotated axes."""
        return np.array(_dualbody._rotation("to_matrix", list(self.numbers))).reshape(3, 3)

    @property
    def roll_pitch_yaw(self) -> Vector3:
        """Three angles (rad) about the fixed axes x, y, z in this order; the pitch is at most a right angle."""
        roll, pitch, yaw = _dualbody._rotation("to_roll_pitch_yaw", list(self.numbers))
        return (roll, pitch, yaw)

    def inverse(self) -> Quaternion:
        """The inverse rotation."""
        return Quaternion(self.w, -self.x, -self.y, -self.z)

    def __matmul__(self, other: Quaternion) -> Quaternion:
        """The product: this rotation after another one."""
        if not isinstance(other, Quaternion):
            return NotImplemented
        return _quaternion("times", (*self.numbers, *other.numbers))

    def rotate(self, vectors: ArrayLike) -> Array:
        """Rotated vectors, (..., 3)."""
        return np.asarray(vectors, dtype=float) @ self.matrix.T


def _quaternion(question: str, numbers: Sequence[float] | Array) -> Quaternion:
    found = np.array(_dualbody._rotation(question, [float(x) for x in numbers]))
    return Quaternion(*(found / np.linalg.norm(found)).tolist())


@dataclass(frozen=True)
class Transform:
    """The pose of frame B in frame A: a rotation, whose matrix has the axes of B as columns, and the position of B's origin, m."""

    rotation: Quaternion = Quaternion()
    translation: Vector3 = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not isinstance(self.rotation, Quaternion):
            raise TypeError(f"rotation is {self.rotation!r}, not a Quaternion")
        p = _numbers("translation", self.translation, (3,))
        object.__setattr__(self, "translation", tuple(p.tolist()))

    @staticmethod
    def identity() -> Transform:
        """Frames A and B coincide."""
        return Transform()

    @staticmethod
    def from_matrix(matrix: ArrayLike) -> Transform:
        """The pose of a matrix [[R, p], [0, 1]], (4, 4), as `frame_pose` gives it."""
        given = _numbers("a pose", matrix, (4, 4))
        if np.abs(given[3] - (0.0, 0.0, 0.0, 1.0)).max() > _TOLERANCE:
            raise ValueError(f"the last row of a pose is (0, 0, 0, 1), not {given[3]}")
        return Transform(Quaternion.from_matrix(given[:3, :3]), cast("Vector3", tuple(given[:3, 3])))

    @staticmethod
    def exp(motion: ArrayLike) -> Transform:
        """The pose after unit time with a constant velocity [linear; angular] (6,) in the moving frame."""
        found = _dualbody._pose("exp", _numbers("a motion", motion, (6,)).tolist())
        return Transform(_quaternion("times", (*found[:4], 1.0, 0.0, 0.0, 0.0)), cast("Vector3", tuple(found[4:])))

    def log(self) -> Array:
        """The constant velocity (6,) that reaches this pose in unit time: the inverse of `exp`."""
        return self._ask("log")

    @property
    def matrix(self) -> Array:
        """The matrix [[R, p], [0, 1]], (4, 4)."""
        out = np.eye(4)
        out[:3, :3] = self.rotation.matrix
        out[:3, 3] = self.translation
        return out

    @property
    def adjoint(self) -> Array:
        """The matrix (6, 6) that maps motions [linear; angular] from B to A."""
        return self._ask("adjoint").reshape(6, 6)

    @property
    def adjoint_inverse(self) -> Array:
        """The matrix (6, 6) that maps motions from A to B."""
        return self._ask("adjoint_inverse").reshape(6, 6)

    @property
    def force_adjoint(self) -> Array:
        """The matrix (6, 6) that maps forces [force; moment] from B to A: the inverse transpose of `adjoint`."""
        return self._ask("force_adjoint").reshape(6, 6)

    @property
    def force_adjoint_inverse(self) -> Array:
        """The matrix (6, 6) that maps forces from A to B: the transpose of `adjoint`."""
        return self._ask("force_adjoint_inverse").reshape(6, 6)

    def inverse(self) -> Transform:
        """The pose of A in B."""
        back = self.rotation.inverse()
        return Transform(back, cast("Vector3", tuple(-back.rotate(self.translation) + 0.0)))

    def __matmul__(self, other: Transform) -> Transform:
        """The pose of C in A, from this one of B in A and that of C in B."""
        if not isinstance(other, Transform):
            return NotImplemented
        return Transform(self.rotation @ other.rotation, cast("Vector3", tuple(self.point(other.translation))))

    def point(self, points: ArrayLike) -> Array:
        """Points (..., 3) of B in A, m."""
        return self.rotation.rotate(points) + self.translation

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        """The matrix (4, 4), for NumPy."""
        return np.asarray(self.matrix, dtype=dtype)

    def _ask(self, question: str) -> Array:
        return np.array(_dualbody._pose(question, [*self.rotation.numbers, *self.translation]))
