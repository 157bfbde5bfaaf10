"""The equations of motion:  M(q) a + h(q, v) = tau + sum J' F.  Functions of arrays (..., n); see the package."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from . import _dualbody
from ._base import BaseVelocity
from ._dualbody import *  # noqa: F403
from ._forces import joint_forces

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import ArrayLike

__all__ = [
    "BaseVelocity", "ForwardDynamicsDerivatives", "InverseDynamicsDerivatives", "StateDerivatives", "acceleration_from_representation",
    "acceleration_to_representation", "average_velocity", "average_velocity_jacobian", "bias_forces", "center_of_mass",
    "center_of_mass_acceleration", "center_of_mass_derivatives", "center_of_mass_jacobian", "center_of_mass_velocity", "centroidal_momentum",
    "centroidal_momentum_derivatives", "centroidal_momentum_matrix", "centroidal_momentum_matrix_derivative", "centroidal_momentum_rate",
    "check_mass_matrix", "coriolis_matrix", "elastic_energy", "external_forces", "force_from_representation", "force_to_representation",
    "forward_dynamics", "forward_dynamics_derivatives", "forward_kinematics", "frame_acceleration", "frame_bias_acceleration", "frame_jacobian",
    "frame_jacobian_derivative", "frame_placement_derivatives", "frame_pose", "frame_velocity", "frame_velocity_derivatives", "gravity_forces",
    "inverse_dynamics", "inverse_dynamics_derivatives", "inverse_dynamics_second_derivatives", "jacobian_to_representation", "joint_forces",
    "joint_torque_regressor", "kinetic_energy", "kinetic_energy_regressor", "link_accelerations", "link_jacobian_derivatives", "link_jacobians",
    "link_velocities", "locked_inertia", "mass_matrix", "mass_matrix_inverse", "mass_matrix_to_representation", "momentum", "momentum_matrix",
    "passive_forces", "potential_energy", "potential_energy_regressor", "velocity_from_representation", "velocity_to_representation",
]


class InverseDynamicsDerivatives(NamedTuple):
    """Derivatives of tau, (..., nv, nv) each: in tangent directions of q, in v, in a (the mass matrix)."""

    dq: Array
    dv: Array
    da: Array


class ForwardDynamicsDerivatives(NamedTuple):
    """Derivatives of the acceleration, (..., nv, nv) each: in tangent directions of q, in v, in tau (the inverse mass matrix)."""

    dq: Array
    dv: Array
    dtau: Array


class StateDerivatives(NamedTuple):
    """Derivatives of a quantity in q and v, (..., rows, nv) each."""

    dq: Array
    dv: Array


def inverse_dynamics_derivatives(
    model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, *, out: Array | None = None
) -> InverseDynamicsDerivatives:
    """Derivatives of inverse dynamics, exact, along the tree. q (..., nq), v and a (..., nv); out (..., 3, nv, nv) takes all three."""
    x = _dualbody._inverse_dynamics_derivatives(model, q, v, a, out=out)
    return InverseDynamicsDerivatives(x[..., 0, :, :], x[..., 1, :, :], x[..., 2, :, :])


def forward_dynamics_derivatives(
    model: Model, q: ArrayLike, v: ArrayLike, tau: ArrayLike, *, out: Array | None = None
) -> ForwardDynamicsDerivatives:
    """Derivatives of forward dynamics, exact, along the tree. q (..., nq), v and tau (..., nv); out (..., 3, nv, nv) takes all three."""
    x = _dualbody._forward_dynamics_derivatives(model, q, v, tau, out=out)
    return ForwardDynamicsDerivatives(x[..., 0, :, :], x[..., 1, :, :], x[..., 2, :, :])


def frame_velocity_derivatives(
    model: Model, q: ArrayLike, v: ArrayLike, frame: str, representation: RepresentationName = "body"
) -> StateDerivatives:
    """Derivatives of a frame's velocity, (..., 6, nv) each. q (..., nq), v (..., nv)."""
    x = _dualbody._frame_velocity_derivatives(model, q, v, frame, representation)
    return StateDerivatives(x[..., 0, :, :], x[..., 1, :, :])


def centroidal_momentum_derivatives(model: Model, q: ArrayLike, v: ArrayLike) -> StateDerivatives:
    """Derivatives of the centroidal momentum, (..., 6, nv) each. q (..., nq), v (..., nv)."""
    x = _dualbody._centroidal_momentum_derivatives(model, q, v)
    return StateDerivatives(x[..., 0, :, :], x[..., 1, :, :])


def sum_of_frame_forces(
    of_one: Callable[..., Any], model: Model, q: Any, forces: Mapping[str, Any], representation: RepresentationName = "mixed", **options: Any
) -> Any:
    """Forces on the bodies, from a function of the force on one frame."""
    if not forces:
        import numpy as np

        return of_one(model, q, np.zeros(6), model.frame_names[0], representation, **options)
    parts = [of_one(model, q, force, name, representation, **options) for name, force in forces.items()]
    return sum(parts[1:], start=parts[0])


def external_forces(model: Model, q: ArrayLike, forces: Mapping[str, ArrayLike], representation: RepresentationName = "mixed") -> Array:
    """Forces on the bodies in their frames, (..., n_bodies, 6), from forces on frames and links by name: the argument `external` of the dynamics.

    q (..., nq); forces {name: (..., 6)}: [linear; angular] (N, N·m) in a representation.
    """
    return sum_of_frame_forces(_dualbody._frame_force, model, q, forces, representation)


def jacobian_to_representation(model: Model, q: ArrayLike, jacobian: ArrayLike, representation: RepresentationName) -> Array:
    """Jacobian for velocities whose base part is in another representation, (..., rows, nv). q (..., nq), jacobian (..., rows, nv)."""
    import numpy as np

    rows = np.asarray(jacobian, dtype=float)
    q = np.broadcast_to(np.asarray(q, dtype=float)[..., None, :], (*rows.shape[:-1], model.nq))
    return _dualbody._row_to_representation(model, q, rows, representation)
