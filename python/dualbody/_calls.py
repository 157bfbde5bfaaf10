"""What JAX and PyTorch have in common: calls of the library with their derivatives, and functions of arrays made of them.

A call is a value, a push (changes of the results along directions of the inputs) or a pull (slopes of weighted sums of the results in the inputs).
Arrays have one batch before the shape of a row; those of a push or pull have an axis of directions between the two.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial, wraps
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import _dualbody, dynamics
from ._base import BaseVelocity
from ._contact_forces import contact_kinematics, kinematics_of
from ._forces import sum_of_joint_forces

if TYPE_CHECKING:
    from ._dualbody import Model, Simulator

#: Functions whose result is a tuple, by the name of the entry in the table.
_TUPLES: dict[str, Any] = {
    "_centroidal_momentum_derivatives": dynamics.StateDerivatives,
    "_forward_dynamics_derivatives": dynamics.ForwardDynamicsDerivatives,
    "_frame_velocity_derivatives": dynamics.StateDerivatives,
    "_inverse_dynamics_derivatives": dynamics.InverseDynamicsDerivatives,
}


class Call(NamedTuple):
    """A call: of a model or simulator, kind, function, arguments by name, number of vectors, whether parameters follow, active inputs, steps."""

    of: Model | Simulator
    kind: str
    function: str
    names: tuple[str, ...]
    given: int
    has_parameters: bool
    active: tuple[int, ...] = ()
    steps: int = 0
    #: Shapes of a row of the inputs and of the results of the function.
    shapes: tuple[tuple[tuple[int, ...], ...], tuple[tuple[int, ...], ...]] = ((), ())

    @classmethod
    def of_values(cls, of: Model | Simulator, function: str, names: list[Any], given: int, has_parameters: bool, steps: int) -> Call:
        """The call of a function."""
        both = _dualbody._signature(of, function, given, has_parameters, steps, names)
        inputs, outputs = (tuple(map(tuple, shapes)) for shapes in both)
        return cls(of, "value", function, tuple(names), given, has_parameters, (), steps, (inputs, outputs))

    @property
    def n_inputs(self) -> int:
        """Number of inputs of the function."""
        return self.given + self.has_parameters

    def batch(self, arrays: Any) -> tuple[int, ...]:
        """The batch of arrays."""
        shape = arrays[0].shape
        return tuple(shape[: len(shape) - len(self.shapes[0][0])])

    def directions(self, arrays: Any) -> int:
        """Number of directions of a push or pull."""
        return int(arrays[self.n_inputs].shape[len(self.batch(arrays))]) if self.kind != "value" else 0

    def results(self, arrays: Any) -> list[tuple[int, ...]]:
        """Shapes of what the call gives."""
        inputs, outputs = self.shapes
        tails = [inputs[i] for i in self.active] if self.kind == "pull" else outputs
        middle = () if self.kind == "value" else (self.directions(arrays),)
        return [(*self.batch(arrays), *middle, *tail) for tail in tails]

    def text(self, arrays: Any) -> str:
        """The call as the library reads it."""
        numbers = (int(np.prod(self.batch(arrays), dtype=int)), self.directions(arrays), self.steps)
        lines = (self.kind, self.function, self.given, int(self.has_parameters), ",".join(map(str, self.active)), *numbers, *self.names)
        return "\n".join(map(str, lines))

    def on_numpy(self, arrays: Any) -> list[Any]:
        """Makes the call on arrays of NumPy."""
        given = [np.require(x, np.float64, ["C", "A"]) for x in arrays]
        out = [np.empty(shape) for shape in self.results(given)]
        _dualbody._call(self.of, self.text(given), given, out)
        return out

    def pushed(self, active: tuple[int, ...]) -> Call:
        """The call that takes changes of some inputs to those of the results."""
        return self._replace(kind="push", active=active)

    def transposed(self) -> Call:
        """The call that is the transpose of a push, or of a pull."""
        return self._replace(kind="pull" if self.kind == "push" else "push")

    def on_batch(self, xp: Any, bind: Callable[..., Any], arrays: list[Any], axes: list[int | None], size: int) -> tuple[list[Any], list[int]]:
        """Makes calls side by side: arrays that have an axis for them, or None. Returns the results and where their axis is.

        Where only changes or weights have it, it becomes one of directions, of which the library makes one Jacobian.
        """

        def front(x: Any, axis: int | None) -> Any:
            return xp.broadcast_to(x, (size, *x.shape)) if axis is None else xp.moveaxis(x, axis, 0)

        if self.kind == "value" or any(axis is not None for axis in axes[: self.n_inputs]):
            return list(bind(self, *map(front, arrays, axes))), [0] * len(self.results(arrays))
        inputs, more = arrays[: self.n_inputs], arrays[self.n_inputs :]
        at = len(self.batch(inputs))
        moved = [xp.moveaxis(front(x, axis), 0, at) for x, axis in zip(more, axes[self.n_inputs :], strict=True)]
        merged = [xp.reshape(x, (*x.shape[:at], x.shape[at] * x.shape[at + 1], *x.shape[at + 2 :])) for x in moved]
        out = bind(self, *inputs, *merged)
        return [xp.reshape(x, (*x.shape[:at], size, x.shape[at] // max(size, 1), *x.shape[at + 1 :])) for x in out], [at] * len(out)


class _Entry(NamedTuple):
    """A function of the table."""

    name: str
    arguments: list[str]
    option: str | None
    keywords: list[tuple[str, str | None]]
    is_of_simulator: bool


class Library(NamedTuple):
    """What is different in JAX and PyTorch."""

    #: The module with `broadcast_to`, `moveaxis`, `reshape`, …
    xp: Any
    #: bind(call, *arrays) makes a call whose arrays have one batch.
    bind: Callable[..., Any]
    #: Arrays of one type of floats.
    floats: Callable[..., list[Any]]


def functions(library: Library) -> dict[str, Any]:
    """All functions of the table under a library, by name."""
    entries = [_Entry(*entry) for entry in _dualbody._table()]
    own = {entry.name: _function(library, entry) for entry in entries}
    for name, make in _TUPLES.items():
        own[name[1:]] = partial(_split, own[name], make)

    @wraps(dynamics.jacobian_to_representation)
    def jacobian_to_representation(model: Model, q: Any, jacobian: Any, representation: str, **options: Any) -> Any:
        rows = own["_row_to_representation"]
        return rows(model, library.floats(q)[0][..., None, :], jacobian, representation, **options)

    @wraps(contact_kinematics)
    def kinematics(simulator: Simulator, q: Any, v: Any, **options: Any) -> Any:
        return kinematics_of(own["_contact_points"](simulator, q, v, **options))

    own |= {"jacobian_to_representation": jacobian_to_representation, "contact_kinematics": kinematics}
    own["external_forces"] = partial(dynamics.sum_of_frame_forces, own["_frame_force"])
    own["joint_forces"] = partial(sum_of_joint_forces, lambda x: library.floats(x)[0])

    @dataclass(frozen=True)
    class Own(BaseVelocity):
        #: Parameters of the model, instead of its own.
        parameters: Any = None

        def _call(self, name: str, *arguments: Any) -> Any:
            return own[name](self.model, *arguments, parameters=self.parameters)

    own["BaseVelocity"] = Own
    return own


def _split(function: Callable[..., Any], make: Any, *arguments: Any, **options: Any) -> Any:
    """The parts of a result as a tuple with names."""
    x = function(*arguments, **options)
    return make(*(x[..., k, :, :] for k in range(len(make._fields))))


def _function(library: Library, entry: _Entry) -> Callable[..., Any]:
    """A function of the table under a library: vectors, things by name, then `parameters` of the model."""
    vectors = [*entry.arguments, *([entry.option] if entry.option else [])]
    order = [*entry.arguments, *(name for name, _ in entry.keywords), "parameters"]

    def call(of: Any, /, *arguments: Any, **options: Any) -> Any:
        named = dict(zip(order, arguments))
        if len(arguments) > len(order) or set(named) & set(options) or not set(options) <= {*order, *vectors}:
            raise TypeError(f"{entry.name}() takes {', '.join(dict.fromkeys([*order, *vectors]))}, each once")
        named |= options
        if "u" in order and named.get("u") is None:
            named["u"] = np.zeros(of.nu)
        names = [named.get(name, default) for name, default in entry.keywords]
        given = {name: named[name] for name in (*vectors, "parameters") if named.get(name) is not None}
        has_parameters = "parameters" in given
        if len(given) - has_parameters < len(entry.arguments) or None in names:
            raise TypeError(f"{entry.name}() needs {', '.join([*entry.arguments, *(name for name, x in entry.keywords if x is None)])}")
        for name, x in given.items():
            if "complex" in str(getattr(x, "dtype", "")):
                raise TypeError(f"{name} holds {x.dtype}, expected real numbers")
        arrays = library.floats(*given.values())
        steps = int(arrays[2].shape[-2]) if entry.name == "rollout" and arrays[2].ndim > 1 else 0
        whole = Call.of_values(of, entry.name, names, len(given) - has_parameters, has_parameters, steps)
        results = library.bind(whole, *_one_batch(library, whole, dict(zip(given, arrays, strict=True))))
        return tuple(results) if entry.name in ("step", "rollout") else results[0]

    call.__name__ = call.__qualname__ = entry.name
    documented = getattr(_dualbody, entry.name, None) or getattr(_dualbody.Simulator, entry.name, None)
    call.__doc__ = documented.__doc__ if documented else f"{entry.name} of {', '.join(vectors)}: what `Simulator.contact_report` has by this name."
    return call


def _one_batch(library: Library, call: Call, arrays: dict[str, Any]) -> list[Any]:
    """Arrays of one batch, whose rows have the shapes that the function wants."""
    tails, batches = dict(zip(arrays, call.shapes[0], strict=True)), {}
    for name, x in arrays.items():
        tail, shape = tails[name], tuple(x.shape)
        if shape[max(len(shape) - len(tail), 0) :] != tail:
            raise ValueError(f"{name} has the shape {shape}, expected (..., {', '.join(map(str, tail))})")
        batches[name] = shape[: len(shape) - len(tail)]
    try:
        batch = np.broadcast_shapes(*batches.values())
    except ValueError:
        raise ValueError(f"the batches of {call.function} do not fit: {', '.join(f'{name} {own}' for name, own in batches.items())}") from None
    return [library.xp.broadcast_to(x, (*batch, *tails[name])) for name, x in arrays.items()]
