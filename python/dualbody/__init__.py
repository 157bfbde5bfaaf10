"""Differentiable multibody dynamics and robot simulation, on NumPy arrays.

>>> import dualbody as db
>>> model = db.samples.cartpole()
>>> simulator = db.Simulator(model, time_step=0.01, actuated=["linear"])
>>> a, b = simulator.linearize([0.0, 0.0], [0.0, 0.0], [0.0])
>>> db.Lqr.discrete(a, b, [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], [[1]]).is_stabilized
True

Units are SI; spatial vectors are [linear; angular]; quaternions are (w, x, y, z); q has length nq, velocities, accelerations and forces have length nv.
Vector arguments have the shape (..., n): leading axes are batch axes. Batches run on vector registers and all cores, without the interpreter lock. Arrays
of float64 in C order are used without a copy; other numeric arguments are converted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from . import dynamics
from ._dualbody import EngineCoordinates, ImportReport, Model, Plot, Recording, Simulator, World, __version__, carried_state, memory_limit, set_memory_limit, set_threads, threads
from .dynamics import *  # noqa: F403

if TYPE_CHECKING:
    from . import codegen, contact, control, identify, least_squares, native, samples, sim, spatial, state, trajopt, view
    from .control import ComputedTorque, FiniteHorizonLqr, Lqr
    from .model import JointSpec, Limits, LinkSpec, ModelBuilder
    from .sim import ContactReport, Linearization, Rollout, RolloutGradient, Status, StepGradient

#: Modules, and what comes from them: imported when it is asked for first, so that the package is there at once.
_MODULES = ("codegen", "contact", "control", "identify", "least_squares", "model", "native", "samples", "sim", "spatial", "state", "trajopt", "view")
_FROM = {name: "control" for name in ("ComputedTorque", "FiniteHorizonLqr", "Lqr")}
_FROM |= {name: "model" for name in ("JointSpec", "Limits", "LinkSpec", "ModelBuilder")}
_FROM |= {name: "sim" for name in ("ContactReport", "Linearization", "Rollout", "RolloutGradient", "Status", "StepGradient")}


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
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


__all__ = [
    "ComputedTorque", "ContactReport", "EngineCoordinates", "FiniteHorizonLqr", "ImportReport", "JointSpec", "Limits", "Linearization",
    "LinkSpec", "Lqr", "Model", "ModelBuilder", "Plot", "Recording", "Rollout", "RolloutGradient", "Simulator", "Status", "StepGradient",
    "World", "__version__", "carried_state", "codegen", "contact", "control", "dynamics", "identify", "least_squares", "memory_limit", "native",
    "samples", "set_memory_limit", "set_threads", "sim", "spatial", "state", "threads", "trajopt", "view",
]
__all__ += dynamics.__all__
