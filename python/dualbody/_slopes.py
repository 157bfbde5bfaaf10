"""Slopes of costs of dynamics, steps and rollouts, on NumPy arrays: what reverse modes of other libraries call.

Each function takes the arguments of a function, its results, and the slopes of a cost in the results; it gives the slopes in the arguments.
All have the same batch before them. Slopes in q are in its coordinates, quaternions included.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _dualbody, dynamics

if TYPE_CHECKING:
    from ._dualbody import Array, Model, Simulator

Arrays = tuple["Array", ...]


def check(simulator: Simulator, library: str) -> None:
    """Refuses contacts with a state, which the functions of other libraries do not hand on."""
    if simulator.n_contact:
        raise ValueError(f"contacts with a state are not supported in {library}: choose a rigid or relaxed rigid law")


def _from_left(row: Array, matrix: Array) -> Array:
    """rowᵀ matrix."""
    product: Array = np.einsum("...i,...ij->...j", row, matrix)
    return product


def to_coordinates(model: Model, q: Array, tangent: Array) -> Array:
    """Slopes in the coordinates of q from those in its tangent."""
    return _from_left(tangent, _dualbody._difference_jacobian(model, q))


def to_tangent(model: Model, q: Array, coordinates: Array) -> Array:
    """Slopes in the tangent of q from those in its coordinates."""
    return _from_left(coordinates, _dualbody._integrate_jacobian(model, q))


def of_dynamics(model: Model, derivatives: Callable[..., Any], arguments: Arrays, slope: Array) -> Arrays:
    """Slopes in the arguments (q, v, a or tau) of a function of the dynamics with these derivatives."""
    by_q, *rest = (_from_left(slope, block) for block in derivatives(model, *arguments))
    return (to_coordinates(model, arguments[0], by_q), *rest)


def of_inverse_dynamics(model: Model, q: Array, v: Array, a: Array, tau: Array, slope: Array) -> Arrays:
    return of_dynamics(model, dynamics.inverse_dynamics_derivatives, (q, v, a), slope)


def of_forward_dynamics(model: Model, q: Array, v: Array, tau: Array, a: Array, slope: Array) -> Arrays:
    return of_dynamics(model, dynamics.forward_dynamics_derivatives, (q, v, tau), slope)


def of_step(simulator: Simulator, arguments: Arrays, results: Arrays, slopes: Arrays, parameters: bool) -> Arrays:
    """Slopes in q, v, u, and in all parameters if they are wanted, of a step."""
    (q, v, u), model = arguments, simulator.model
    adjoint = np.concatenate([to_tangent(model, results[0], slopes[0]), slopes[1]], axis=-1)
    gradient = simulator.vjp(q, v, u, adjoint, parameters=parameters)
    by_q = to_coordinates(model, q, gradient.state[..., : model.nv])
    own = (by_q, gradient.state[..., model.nv :], gradient.input)
    return (*own, gradient.parameters) if parameters else own


def of_rollout(simulator: Simulator, arguments: Arrays, results: Arrays, slopes: Arrays, parameters: bool) -> Arrays:
    """Slopes in q, v, inputs, and in all parameters if they are wanted, of a rollout."""
    (q, v, inputs), model = arguments, simulator.model
    gradient = simulator.rollout_vjp(q, v, inputs, by_q=slopes[0], by_v=slopes[1], parameters=parameters)
    by_q = to_coordinates(model, q, gradient.start[..., : model.nv])
    own = (by_q, gradient.start[..., model.nv :], gradient.inputs)
    return (*own, gradient.parameters) if parameters else own


def for_each_robot(
    simulator: Simulator, parameters: Array, run: Callable[..., Arrays], arrays: Arrays
) -> Arrays:
    """run(simulator, arrays) with these parameters (..., n) of the model: once for all states whose parameters are the same."""
    batch = parameters.shape[:-1]
    flat = parameters.reshape(-1, parameters.shape[-1])
    different, index = np.unique(flat, axis=0, return_inverse=True)

    def changed(own: Array) -> Simulator:
        return simulator.replace(model=simulator.model.with_parameters(own))

    if len(different) == 1:
        return run(changed(different[0]), *arrays)
    rows = [x.reshape(len(flat), *x.shape[len(batch) :]) for x in arrays]
    parts = [run(changed(own), *(x[index.ravel() == k] for x in rows)) for k, own in enumerate(different)]
    order = np.argsort(np.concatenate([np.flatnonzero(index.ravel() == k) for k in range(len(different))]))
    together = (np.concatenate(part)[order] for part in zip(*parts, strict=True))
    return tuple(x.reshape(*batch, *x.shape[1:]) for x in together)
