"""Dynamics with the base velocity in a chosen representation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _dualbody

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._dualbody import Array, Model, MomentumFrameName, RepresentationName, Simulator
    from ._rollout import Linearization


@dataclass(frozen=True)
class BaseVelocity:
    """The dynamics of a robot with its base velocity in a representation, which applies to all velocities, accelerations, forces and matrices.

    representation: "body" (axes of the base), "mixed" (its origin, axes of the world), "inertial" (origin and axes of the world). Each method corresponds
    to the function of its name in this package; those of frames also take a representation of their output. q is in the format of this package. For robots
    with a fixed base the representation has no effect. v, a, tau: (..., nv); for a floating base the first six entries are its velocity in the
    representation, the rate of that velocity, and the dual force and moment.

    >>> import dualbody as db
    >>> db.BaseVelocity(db.samples.cartpole(), "mixed").mass_matrix([0.0, 0.0]).shape
    (2, 2)
    """

    model: Model
    representation: RepresentationName = "mixed"

    def _call(self, name: str, *arguments: Any) -> Array:
        found: Array = getattr(_dualbody, name)(self.model, *arguments)
        return found

    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Joint forces M a + h that produce accelerations, (..., nv)."""
        return self._call("_base_inverse_dynamics", q, v, a, self.representation)

    def forward_dynamics(self, q: ArrayLike, v: ArrayLike, tau: ArrayLike) -> Array:
        """Accelerations that joint forces produce, (..., nv)."""
        return self._call("_base_forward_dynamics", q, v, tau, self.representation)

    def bias_forces(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Bias forces h = C v + g, (..., nv): those that keep the acceleration zero."""
        return self._call("_base_bias_forces", q, v, self.representation)

    def gravity_forces(self, q: ArrayLike) -> Array:
        """Joint forces g that balance gravity, (..., nv)."""
        return self._call("_base_gravity_forces", q, self.representation)

    def mass_matrix(self, q: ArrayLike) -> Array:
        """Mass matrix M, (..., nv, nv)."""
        return self._call("_base_mass_matrix", q, self.representation)

    def mass_matrix_inverse(self, q: ArrayLike) -> Array:
        """Inverse of the mass matrix, (..., nv, nv)."""
        return self._call("_base_mass_matrix_inverse", q, self.representation)

    def coriolis_matrix(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Coriolis matrix C, (..., nv, nv), with h = C v + g and dM/dt - 2 C skew."""
        return self._call("_base_coriolis_matrix", q, v, self.representation)

    def frame_velocity(self, q: ArrayLike, v: ArrayLike, frame: str, representation: RepresentationName = "body") -> Array:
        """Velocity of a frame, (..., 6)."""
        return self._call("_base_frame_velocity", q, v, frame, representation, self.representation)

    def frame_acceleration(
        self, q: ArrayLike, v: ArrayLike, a: ArrayLike, frame: str, representation: RepresentationName = "body"
    ) -> Array:
        """Acceleration J a + dJ/dt v of a frame, (..., 6): classical if mixed, else spatial."""
        return self._call("_base_frame_acceleration", q, v, a, frame, representation, self.representation)

    def frame_bias_acceleration(
        self, q: ArrayLike, v: ArrayLike, frame: str, representation: RepresentationName = "body"
    ) -> Array:
        """Bias acceleration dJ/dt v of a frame, (..., 6): its acceleration where a is zero."""
        return self._call("_base_frame_bias_acceleration", q, v, frame, representation, self.representation)

    def frame_jacobian(self, q: ArrayLike, frame: str, representation: RepresentationName = "body") -> Array:
        """Jacobian J of a frame, (..., 6, nv)."""
        return self._call("_base_frame_jacobian", q, frame, representation, self.representation)

    def frame_jacobian_derivative(
        self, q: ArrayLike, v: ArrayLike, frame: str, representation: RepresentationName = "body"
    ) -> Array:
        """Rate dJ/dt of the Jacobian of a frame along v, (..., 6, nv)."""
        return self._call("_base_frame_jacobian_derivative", q, v, frame, representation, self.representation)

    def momentum(self, q: ArrayLike, v: ArrayLike, frame: MomentumFrameName = "centroidal") -> Array:
        """Momentum of all bodies, (..., 6)."""
        return self._call("_base_momentum", q, v, frame, self.representation)

    def momentum_matrix(self, q: ArrayLike, frame: MomentumFrameName = "centroidal") -> Array:
        """Matrix of the momentum, (..., 6, nv)."""
        return self._call("_base_momentum_matrix", q, frame, self.representation)

    def centroidal_momentum_rate(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Rate of the centroidal momentum, (..., 6)."""
        return self._call("_base_centroidal_momentum_rate", q, v, a, self.representation)

    def centroidal_momentum_matrix_derivative(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Rate of the centroidal momentum matrix along v, (..., 6, nv)."""
        return self._call("_base_centroidal_momentum_matrix_derivative", q, v, self.representation)

    def average_velocity_jacobian(self, q: ArrayLike, frame: MomentumFrameName = "centroidal") -> Array:
        """Matrix of the average velocity, (..., 6, nv)."""
        return self._call("_base_average_velocity_jacobian", q, frame, self.representation)

    def center_of_mass_velocity(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Velocity of the centre of mass in the world, (..., 3)."""
        return self._call("_base_center_of_mass_velocity", q, v, self.representation)

    def center_of_mass_jacobian(self, q: ArrayLike) -> Array:
        """Jacobian of the centre of mass, (..., 3, nv)."""
        return self._call("_base_center_of_mass_jacobian", q, self.representation)

    def center_of_mass_acceleration(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Acceleration of the centre of mass in the world, (..., 3)."""
        return self._call("_base_center_of_mass_acceleration", q, v, a, self.representation)

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
