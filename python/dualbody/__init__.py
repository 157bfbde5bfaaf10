"""Differentiable multibody dynamics and robot simulation, on NumPy arrays.

>>> import dualbody as db
>>> model = db.samples.cartpole()
>>> simulator = db.Simulator(model, time_step=0.01, actuated=["linear"])
>>> a, b = simulator.linearize([0.0, 0.0], [0.0, 0.0], [0.0])
>>> db.Lqr.discrete(a, b, [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], [[1]]).is_stabilized
True

Units are SI; spatial vectors are [linear; angular]; quaternions are (w, x, y, z); q has nq numbers, velocities, accelerations and forces have
nv. Vector arguments have the shape (..., n): what stands before n is a batch, which runs on vector registers and cores without the interpreter
lock. Arrays of float64 in C order are used as they are, anything else that holds numbers is converted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from . import dynamics
from ._dualbody import ImportReport, Model, Plot, Recording, Simulator, __version__, set_threads, threads
from .dynamics import (
    acceleration_from_representation,
    acceleration_to_representation,
    average_velocity,
    average_velocity_jacobian,
    bias_forces,
    center_of_mass,
    center_of_mass_acceleration,
    center_of_mass_derivatives,
    center_of_mass_jacobian,
    center_of_mass_velocity,
    centroidal_momentum,
    centroidal_momentum_derivatives,
    centroidal_momentum_matrix,
    centroidal_momentum_matrix_derivative,
    centroidal_momentum_rate,
    check_mass_matrix,
    coriolis_matrix,
    elastic_energy,
    external_forces,
    force_from_representation,
    force_to_representation,
    forward_dynamics,
    forward_dynamics_derivatives,
    forward_kinematics,
    frame_acceleration,
    frame_bias_acceleration,
    frame_jacobian,
    frame_jacobian_derivative,
    frame_placement_derivatives,
    frame_pose,
    frame_velocity,
    frame_velocity_derivatives,
    gravity_forces,
    inverse_dynamics,
    inverse_dynamics_derivatives,
    inverse_dynamics_second_derivatives,
    jacobian_to_representation,
    joint_torque_regressor,
    kinetic_energy,
    kinetic_energy_regressor,
    locked_inertia,
    mass_matrix,
    mass_matrix_inverse,
    mass_matrix_to_representation,
    momentum,
    momentum_matrix,
    passive_forces,
    potential_energy,
    potential_energy_regressor,
    velocity_from_representation,
    velocity_to_representation,
)

if TYPE_CHECKING:
    from . import contact, control, samples, sim, trajopt, view
    from .control import ComputedTorque, FiniteHorizonLqr, Lqr
    from .model import JointSpec, Limits, LinkSpec, ModelBuilder
    from .sim import ContactReport, Linearization, Rollout, Status

#: Modules, and what comes from them: imported when it is asked for first, so that the package is there at once.
_MODULES = ("contact", "control", "model", "samples", "sim", "trajopt", "view")
_FROM = {
    "ComputedTorque": "control",
    "ContactReport": "sim",
    "FiniteHorizonLqr": "control",
    "JointSpec": "model",
    "Limits": "model",
    "Linearization": "sim",
    "LinkSpec": "model",
    "Lqr": "control",
    "ModelBuilder": "model",
    "Rollout": "sim",
    "Status": "sim",
}


def __getattr__(name: str) -> object:
    from importlib import import_module

    if name in _MODULES:
        return import_module(f".{name}", __name__)
    if name in _FROM:
        value = getattr(import_module(f".{_FROM[name]}", __name__), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


__all__ = [
    "ComputedTorque",
    "ContactReport",
    "FiniteHorizonLqr",
    "ImportReport",
    "JointSpec",
    "Limits",
    "Linearization",
    "LinkSpec",
    "Lqr",
    "Model",
    "ModelBuilder",
    "Plot",
    "Recording",
    "Rollout",
    "Simulator",
    "Status",
    "__version__",
    "acceleration_from_representation",
    "acceleration_to_representation",
    "average_velocity",
    "average_velocity_jacobian",
    "bias_forces",
    "center_of_mass",
    "center_of_mass_acceleration",
    "center_of_mass_derivatives",
    "center_of_mass_jacobian",
    "center_of_mass_velocity",
    "centroidal_momentum",
    "centroidal_momentum_derivatives",
    "centroidal_momentum_matrix",
    "centroidal_momentum_matrix_derivative",
    "centroidal_momentum_rate",
    "check_mass_matrix",
    "contact",
    "control",
    "coriolis_matrix",
    "dynamics",
    "elastic_energy",
    "external_forces",
    "force_from_representation",
    "force_to_representation",
    "forward_dynamics",
    "forward_dynamics_derivatives",
    "forward_kinematics",
    "frame_acceleration",
    "frame_bias_acceleration",
    "frame_jacobian",
    "frame_jacobian_derivative",
    "frame_placement_derivatives",
    "frame_pose",
    "frame_velocity",
    "frame_velocity_derivatives",
    "gravity_forces",
    "inverse_dynamics",
    "inverse_dynamics_derivatives",
    "inverse_dynamics_second_derivatives",
    "jacobian_to_representation",
    "joint_torque_regressor",
    "kinetic_energy",
    "kinetic_energy_regressor",
    "locked_inertia",
    "mass_matrix",
    "mass_matrix_inverse",
    "mass_matrix_to_representation",
    "momentum",
    "momentum_matrix",
    "passive_forces",
    "potential_energy",
    "potential_energy_regressor",
    "samples",
    "set_threads",
    "sim",
    "threads",
    "trajopt",
    "velocity_from_representation",
    "velocity_to_representation",
    "view",
]
