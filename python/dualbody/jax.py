"""Functions of JAX: under `jit`, `vmap`, `jvp`, `grad`, `jacfwd`, `jacrev`.

>>> import jax, dualbody as db, dualbody.jax as dj
>>> jax.config.update("jax_enable_x64", True)
>>> model = db.samples.pendulum()
>>> float(jax.grad(lambda q: dj.inverse_dynamics(model, q, q * 0, q * 0)[0])(jax.numpy.zeros(1))[0])  # m g l / 2
4.905

All functions of `dualbody.dynamics` are here by their names, with `integrate` and `difference` of configurations, and of a simulator `step`, `rollout`,
`acceleration`, `contact_forces`, `contact_kinematics`, `contact_frames`, `contact_jacobians` and their rates. Arguments are those of the NumPy functions.
Each function also takes `parameters` (..., n): those of the robot, instead of `model.parameters`, and differentiable; contact points are fixed on their
bodies, as in `Simulator.with_parameters`. Steps and rollouts take and return the state of soft contact if it is given.

Values and derivatives are those of the library, exact to rounding. On the CPU compiled programs call the library through JAX's foreign-function interface,
without the interpreter; elsewhere they call it on the host (`pure_callback`), which costs some tens of microseconds more. `vmap` is one call for the
batch, `jacfwd` and `jacrev` are one call for all directions. Only first derivatives exist, also for functions that are derivatives themselves, except
`inverse_dynamics_second_derivatives`. Arrays are float64 with the option `jax_enable_x64`; otherwise results are rounded to float32. Derivatives in q are
those in its coordinates, including quaternions.

A compiled program refers to its robot by a digest, and the process keeps all robots of its programs.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

from . import _dualbody
from ._calls import Call, Library, functions

if TYPE_CHECKING:

    def __getattr__(name: str) -> Any: ...


#: Name of the function of the compiled module that programs call.
_TARGET = "dualbody"

_PRIMITIVE: Any = Primitive("dualbody")
_PRIMITIVE.multiple_results = True


@functools.cache
def _is_foreign() -> bool:
    """Whether programs call the library itself, and not through the interpreter: on the CPU, where this JAX has the interface."""
    foreign = getattr(jax, "ffi", None)
    if foreign is None or jax.default_backend() != "cpu":
        return False
    foreign.register_ffi_target(_TARGET, _dualbody._foreign_function(), platform="cpu")
    return True


def _run(*arrays: Any, call: Call) -> Any:
    """Calls the library."""
    dtype = jnp.result_type(float)
    struct: Any = jax.ShapeDtypeStruct
    results = tuple(struct(shape, dtype) for shape in call.results(arrays))
    if _is_foreign():
        return jax.ffi.ffi_call(_TARGET, results)(*arrays, call=call.text(arrays), of=_dualbody._foreign_name(call.of))

    def host(*x: Any) -> Any:
        return tuple(np.asarray(out, dtype) for out in call.on_numpy(x))

    return jax.pure_callback(host, results, *arrays)


def _abstract(*arrays: Any, call: Call) -> Any:
    return [jax.core.ShapedArray(shape, jnp.result_type(float)) for shape in call.results(arrays)]


def _bind(call: Call, *arrays: Any) -> Any:
    return _PRIMITIVE.bind(*arrays, call=call)


def _is_zero(tangent: Any) -> bool:
    return isinstance(tangent, ad.Zero)


def _jvp(primals: Any, tangents: Any, *, call: Call) -> Any:
    """Values with their changes. Pushforwards and pullbacks are linear in the changes."""
    results, n = _bind(call, *primals), call.n_inputs
    if call.kind == "value":
        active = tuple(i for i, tangent in enumerate(tangents) if not _is_zero(tangent))
        at = len(call.batch(primals))
        moved = (jnp.expand_dims(tangents[i], at) for i in active)
        changes = _bind(call.pushed(active), *primals, *moved)
        return results, [jnp.squeeze(x, at) for x in changes]
    if not all(map(_is_zero, tangents[:n])):
        raise NotImplementedError("dualbody.jax gives first derivatives only")
    return results, _bind(call, *primals[:n], *map(ad.instantiate_zeros, tangents[n:]))


def _transpose(cotangents: Any, *arrays: Any, call: Call) -> Any:
    n = call.n_inputs
    slopes = _bind(call.transposed(), *arrays[:n], *map(ad.instantiate_zeros, cotangents))
    return [None] * n + list(slopes)


def _batched(arrays: Any, axes: Any, *, call: Call) -> Any:
    size = next(x.shape[axis] for x, axis in zip(arrays, axes, strict=True) if axis is not None)
    return call.on_batch(jnp, _bind, list(arrays), list(axes), size)


_PRIMITIVE.def_impl(_run)
_PRIMITIVE.def_abstract_eval(_abstract)
mlir.register_lowering(_PRIMITIVE, mlir.lower_fun(_run, multiple_results=True))
ad.primitive_jvps[_PRIMITIVE] = _jvp
ad.primitive_transposes[_PRIMITIVE] = _transpose
batching.primitive_batchers[_PRIMITIVE] = _batched


def _floats(*arrays: Any) -> list[Any]:
    return [jnp.asarray(x, jnp.result_type(float)) for x in arrays]


_FUNCTIONS = functions(Library(jnp, _bind, _floats))
globals().update(_FUNCTIONS)
__all__ = sorted(name for name in _FUNCTIONS if not name.startswith("_"))
