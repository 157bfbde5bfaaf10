"""Dynamics with the base velocity in a chosen representation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _dualbody

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._dualbody import Array, BaseFunctions, Model, RepresentationName, Simulator
    from ._rollout import Linearization
else:
    #: The methods are those of the table that have a base; see the end of this file.
    BaseFunctions = object


@dataclass(frozen=True)
class BaseVelocity(BaseFunctions):
    """The dynamics of a robot with its base velocity in a representation, which applies to all velocities, accelerations, forces and matrices.

    representation: "body" (axes of the base), "mixed" (its origin, axes of the world), "inertial" (origin and axes of the world). Each method corresponds
    to the function of its name in this package, and has its arguments except `external` and `out`; those of frames also take a representation of their output. q is in the format of this package. For robots
    with a fixed base the representation has no effect. v, a, tau: (..., nv); for a floating base the first six entries are its velocity in the
    representation, the rate of that velocity, and the dual force and moment.

    >>> import dualbody as db
    >>> db.BaseVelocity(db.samples.cartpole(), "mixed").mass_matrix([0.0, 0.0]).shape
    (2, 2)
    """

    model: Model
    representation: RepresentationName = "mixed"

    def _call(self, name: str, *arguments: Any) -> Array:
        return getattr(_dualbody, name)(self.model, *arguments)

    def state_tangent(self, q: ArrayLike, v: ArrayLike) -> tuple[Array, Array]:
        """Map S of tangents (dq, dv) of a state to the representation, and its inverse: (..., 2 nv, 2 nv) each.

        dq becomes a small motion in the representation: for "mixed" the change of the base's position in the world, then a rotation vector in axes of the world.
        dv becomes the change of the converted velocity, which also depends on q. v is in the representation.
        """
        own = self._call("velocity_from_representation", q, v, self.representation)
        both = self._call("_base_state_tangents", q, own, self.representation)
        return both[..., 0, :, :], both[..., 1, :, :]

    def linearize(
        self, simulator: Simulator, q: ArrayLike, v: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None
    ) -> Linearization:
        """Jacobians (a, b) of a step between states with the base in the representation: S(next) a S^-1 and S(next) b.

        v is in the representation; the tangent of the configuration is that of `state_tangent`. Inputs are unchanged.
        """
        own = self._call("velocity_from_representation", q, v, self.representation)
        a, b = simulator.linearize(q, own, u, contact=contact)
        following = simulator.step(q, own, u, contact=contact)
        _, back = self._square(q, own, a.shape[-1])
        to, _ = self._square(following[0], following[1], a.shape[-1])
        from ._rollout import Linearization

        return Linearization(to @ a @ back, to @ b)

    def _square(self, q: ArrayLike, v: ArrayLike, n: int) -> tuple[Array, Array]:
        """The maps of tangents, with ones for the state of contact; v is the package's own."""
        import numpy as np

        both = self._call("_base_state_tangents", q, v, self.representation)
        known = both.shape[-1]
        out = np.zeros((*both.shape[:-2], n, n))
        out[..., :known, :known] = both
        out[..., range(known, n), range(known, n)] = 1.0
        return out[..., 0, :, :], out[..., 1, :, :]


def _method(name: str, vectors: list[str], keywords: list[tuple[str, str | None]]) -> Any:
    """A method with the arguments and the documentation of the function of its name."""
    given = [*vectors, *(key if default is None else f"{key}={default!r}" for key, default in keywords)]
    passed = [*vectors, *(key for key, _ in keywords)]
    method = eval(f"lambda self, {', '.join(given)}: self._call('_base_{name}', {', '.join(passed)}, self.representation)")
    method.__name__, method.__qualname__ = name, f"BaseVelocity.{name}"
    method.__doc__ = getattr(_dualbody, name).__doc__
    return method


_PREFIX = "_base_"
_KEYWORDS = {name: keywords for name, _, _, keywords, _ in _dualbody._table()}
for _name, _vectors, *_ in _dualbody._table():
    if (_own := _name.removeprefix(_PREFIX)) != _name and _own in _KEYWORDS:
        setattr(BaseVelocity, _own, _method(_own, _vectors, _KEYWORDS[_own]))
