"""Simulation: actuation, constraints, steps, rollouts and their gradients."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._contact_forces import ContactForces, ContactKinematics, contact_forces, contact_kinematics, rollout_contact_forces
from ._dualbody import BatchSimulator, NoisySensors, Sensors, Simulator, set_threads, threads
from ._forces import named_inputs
from ._parts import (
    Activation, Actuation, Actuator, ActuatorNetwork, Anchor, Ball, Coupler, Distance, ExternalForce, FrameActuator, Regularisation, Sensor,
    SensorNoise, Tendon, TendonServo, Weld,
)
from ._rollout import ContactReport, Linearization, PairContact, Rollout, RolloutGradient, SensorLinearization, Status, StepGradient

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import ArrayLike

__all__ = [
    "Activation", "Actuation", "Actuator", "ActuatorNetwork", "Anchor", "Ball", "BatchSimulator", "ContactForces", "ContactKinematics",
    "ContactReport", "Coupler", "Distance", "ExternalForce", "FrameActuator", "Linearization", "NoisySensors", "PairContact", "Regularisation",
    "Rollout", "RolloutGradient", "Sensor", "SensorLinearization", "SensorNoise", "Sensors", "Simulator", "Status", "StepGradient", "Tendon",
    "TendonServo", "Weld", "contact_forces", "contact_kinematics", "named_inputs", "rollout_contact_forces", "rollout_gradient", "set_threads",
    "threads",
]


def rollout_gradient(
    simulator: Simulator, q: ArrayLike, v: ArrayLike, inputs: ArrayLike, cost: Callable[[Rollout], tuple[Any, Mapping[str, ArrayLike]]], *,
    contact: ArrayLike | None = None, parameters: bool = True, checkpoints: int | str | None = None
) -> RolloutGradient:
    """Gradient of a cost of the rollout in its start, its inputs and the model's parameters.

    cost(rollout) returns the value, (...), and its gradient {"q": (..., steps + 1, nq), "v": …, "contact": …, "u": (..., steps, nu)} in the entries of
    states and inputs; missing entries are zero. The other arguments are those of `Simulator.rollout_vjp`.
    """
    rollout = simulator.rollout(q, v, inputs=inputs, contact=contact)
    value, slopes = cost(rollout)
    unknown = sorted(set(slopes) - {"q", "v", "contact", "u"})
    if unknown:
        raise KeyError(f"slopes {unknown} are none of 'q', 'v', 'contact', 'u'")
    gradient = simulator.rollout_vjp(
        q,
        v,
        inputs,
        by_q=slopes.get("q"),
        by_v=slopes.get("v"),
        by_contact=slopes.get("contact"),
        by_u=slopes.get("u"),
        contact=contact,
        parameters=parameters,
        checkpoints=checkpoints,
    )
    return gradient._replace(cost=value)
