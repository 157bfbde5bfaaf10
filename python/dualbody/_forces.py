"""Forces by name: along joints, on frames, and as inputs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from . import _dualbody

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import ArrayLike

    from ._dualbody import Array, Model, Simulator

#: Coordinates of a force.
_AXES = ("fx", "fy", "fz", "nx", "ny", "nz")

#: Simulators with an input for each force on frames that a step or an acceleration was given by name.
_FORCED: WeakKeyDictionary[Simulator, dict[tuple[Any, ...], Simulator]] = WeakKeyDictionary()

#: How many of them a simulator keeps.
_KEPT = 8


def joint_forces(model: Model, forces: Mapping[str, ArrayLike]) -> Array:
    """Joint forces tau, (..., nv), from forces by the name of the joint; those of others are zero.

    forces {joint: (...) for one degree of freedom, (..., n) for n}: N·m or N. A mimic joint has its own force, which acts on the leader with the ratio of
    their rates.

    >>> import dualbody as db
    >>> db.joint_forces(db.samples.cartpole(), {"pivot": 2.0})
    array([0., 2.])
    """
    import numpy as np

    return np.asarray(sum_of_joint_forces(lambda x: np.asarray(x, dtype=float), model, forces))


def sum_of_joint_forces(array: Callable[[Any], Any], model: Model, forces: Mapping[str, Any]) -> Any:
    """`joint_forces` on arrays that a function makes."""
    tau = array([0.0] * model.nv)
    for name, given in forces.items():
        unit = _dualbody._unit_joint_forces(model, name)
        own = array(given)
        if len(unit) == 1 and (own.ndim == 0 or own.shape[-1] != 1):
            own = own[..., None]
        if own.ndim == 0 or own.shape[-1] != len(unit):
            raise ValueError(f"the force of joint {name!r} has the shape {own.shape}, expected (..., {len(unit)})")
        tau = tau + (own[..., :, None] * array(unit)).sum(-2)
    return tau


def named_inputs(simulator: Simulator, values: Mapping[str, ArrayLike]) -> Array:
    """Inputs u, (..., nu), from values (...) by the names in ``simulator.input_names``; the others are zero.

    >>> import dualbody as db
    >>> db.sim.named_inputs(db.Simulator(db.samples.cartpole()), {"pivot": 2.0})
    array([0., 2.])
    """
    import numpy as np

    names = simulator.input_names
    unknown = sorted(set(values) - set(names))
    if unknown:
        raise KeyError(f"there is no input {', '.join(map(repr, unknown))}; inputs are {', '.join(map(repr, names))}")
    arrays = [np.asarray(values.get(name, 0.0), dtype=float) for name in names]
    return np.stack(np.broadcast_arrays(*arrays), axis=-1) if arrays else np.zeros(0)


def _forced(
    simulator: Simulator, actuators: Sequence[Any] | None, u: ArrayLike | None, forces: Mapping[str, ArrayLike], representation: str
) -> tuple[Simulator, ArrayLike | None]:
    """A simulator with an actuator for each coordinate of forces on frames by name, and the input with these forces."""
    import numpy as np

    if not hasattr(forces, "values"):
        raise TypeError(f"forces is of the type {type(forces).__name__}, expected {{frame: force}}")
    if not forces:
        return simulator, u
    given = [np.asarray(force, dtype=float) for force in forces.values()]
    for name, force in zip(forces, given):
        if force.ndim == 0 or force.shape[-1] != len(_AXES):
            raise ValueError(f"forces[{name!r}] has the shape {force.shape}, expected (..., {len(_AXES)})")
    own = np.zeros(simulator.nu) if u is None else np.asarray(u, dtype=float)
    batch = np.broadcast_shapes(*(x.shape[:-1] for x in (own, *given)))
    own, *given = (np.broadcast_to(x, (*batch, x.shape[-1])) for x in (own, *given))
    forced = _with_inputs(simulator, actuators, tuple(forces), representation)
    # Inputs of tendons come after those of frames.
    first = forced.input_names.index(f"force on {next(iter(forces))}: {_AXES[0]}")
    return forced, np.concatenate([own[..., :first], *given, own[..., first:]], axis=-1)


def _with_inputs(simulator: Simulator, actuators: Sequence[Any] | None, frames: tuple[str, ...], representation: str) -> Simulator:
    import numpy as np

    from ._parts import Anchor, FrameActuator

    kept = _FORCED.setdefault(simulator, {})
    key = (frames, representation)
    if key not in kept:
        unit = np.eye(len(_AXES))
        added = [
            FrameActuator(f"force on {frame}: {axis}", Anchor(frame), tuple(unit[k]), representation)  # type: ignore[arg-type]
            for frame in frames
            for k, axis in enumerate(_AXES)
        ]
        if len(kept) == _KEPT:
            kept.pop(next(iter(kept)))
        kept[key] = simulator.replace(frame_actuators=[*(actuators or ()), *added])
    return kept[key]
