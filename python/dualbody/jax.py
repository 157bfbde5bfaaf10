"""Functions of JAX: under `jit`, `vmap`, `jvp`, `grad`.

>>> import jax, dualbody as db, dualbody.jax as dj
>>> jax.config.update("jax_enable_x64", True)
>>> model = db.samples.pendulum()
>>> float(jax.grad(lambda q: dj.inverse_dynamics(model, q, q * 0, q * 0)[0])(jax.numpy.zeros(1))[0])  # m g l / 2
4.905

Values and derivatives are the library's own, exact ones: `custom_jvp` hands them over. On the CPU compiled programs call the library through
JAX's foreign-function interface, without the interpreter; elsewhere they call it on the host (`pure_callback`), which costs some tens of
microseconds more. `vmap` is one call for the batch. First derivatives only. Arrays are float64 if JAX is told so (`jax_enable_x64`), else
their results are rounded to float32. Changes of q are changes of its coordinates, quaternions included.

A program names its robot by a digest of what the robot is, and the process keeps each robot that a program was made of.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from . import _dualbody
from ._dualbody import Model, Simulator
from ._slopes import check

__all__ = [
    "bias_forces",
    "forward_dynamics",
    "gravity_forces",
    "inverse_dynamics",
    "mass_matrix",
    "rollout",
    "step",
]


#: Name of the function of the compiled module that programs call.
_TARGET = "dualbody"

#: The functions that programs call, as functions of NumPy.
_ON_HOST: dict[str, Callable[..., Any]] = {
    "difference_jacobian": _dualbody._difference_jacobian,
    "forward_dynamics": _dualbody.forward_dynamics,
    "forward_dynamics_derivatives": _dualbody._forward_dynamics_derivatives,
    "integrate_jacobian": _dualbody._integrate_jacobian,
    "inverse_dynamics": _dualbody.inverse_dynamics,
    "inverse_dynamics_derivatives": _dualbody._inverse_dynamics_derivatives,
    "linearize": lambda simulator, *x: tuple(simulator.linearize(*x)),
    "rollout": lambda simulator, q, v, u: (lambda out: (out.q, out.v))(simulator.rollout(q, v, inputs=u)),
    "step": lambda simulator, *x: tuple(simulator.step(*x)),
}


@functools.cache
def _is_foreign() -> bool:
    """Whether programs call the library itself, and not through the interpreter: on the CPU, where this JAX has the interface."""
    foreign = getattr(jax, "ffi", None)
    if foreign is None or jax.default_backend() != "cpu":
        return False
    foreign.register_ffi_target(_TARGET, _dualbody._foreign_function(), platform="cpu")
    return True


def _call(function: str, of: Model | Simulator, shapes: Any, *arguments: Any) -> Any:
    """Calls a function of the library, whose results have these shapes, one batch at a time under `vmap`."""
    dtype = jnp.result_type(float)
    struct: Callable[..., Any] = jax.ShapeDtypeStruct
    is_several = bool(shapes) and isinstance(shapes[0], tuple)
    results: Any = tuple(struct(shape, dtype) for shape in shapes) if is_several else struct(shapes, dtype)
    if _is_foreign():
        call: Any = jax.ffi.ffi_call(_TARGET, results, vmap_method="broadcast_all")
        return call(*arguments, function=function, of=_dualbody._foreign_name(of))

    def host(*arrays: Any) -> Any:
        out = _ON_HOST[function](of, *(np.asarray(array, np.float64) for array in arrays))
        return jax.tree.map(lambda x: np.asarray(x, dtype), out)

    return jax.pure_callback(host, results, *arguments, vmap_method="broadcast_all")


def _times(matrix: Any, vector: Any) -> Any:
    return jnp.einsum("...ij,...j->...i", matrix, vector)


def _tangent(model: Model, q: Any, dq: Any) -> Any:
    """Tangent vector of a change of coordinates."""
    shape = (*q.shape[:-1], model.nv, model.nq)
    return _times(_call("difference_jacobian", model, shape, q), dq)


def _coordinates(model: Model, q: Any, tangent: Any) -> Any:
    """Change of coordinates of a tangent vector."""
    shape = (*q.shape[:-1], model.nq, model.nv)
    return _times(_call("integrate_jacobian", model, shape, q), tangent)


def _floats(*arrays: Any) -> list[Any]:
    """Arrays of JAX's float, of one batch."""
    given = [jnp.asarray(x, jnp.result_type(float)) for x in arrays]
    batch = jnp.broadcast_shapes(*(x.shape[:-1] for x in given))
    return [jnp.broadcast_to(x, (*batch, x.shape[-1])) for x in given]


def _differentiable(function: str) -> Callable[..., Any]:
    """A function of (q, v, a or tau) that gives (..., nv), with its derivatives in all three."""

    @functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
    def call(model: Model, q: Any, v: Any, x: Any) -> Any:
        return _call(function, model, v.shape, q, v, x)

    @call.defjvp
    def _(model: Model, primals: Any, tangents: Any) -> Any:
        dq, dv, dx = tangents
        shape = (*primals[1].shape[:-1], 3, model.nv, model.nv)
        by_q, by_v, by_x = jnp.moveaxis(_call(f"{function}_derivatives", model, shape, *primals), -3, 0)
        change = _times(by_q, _tangent(model, primals[0], dq)) + _times(by_v, dv) + _times(by_x, dx)
        return call(model, *primals), change

    return call


_inverse_dynamics = _differentiable("inverse_dynamics")
_forward_dynamics = _differentiable("forward_dynamics")


def inverse_dynamics(model: Model, q: Any, v: Any, a: Any) -> Any:
    """Joint forces (..., nv) that produce the accelerations a. See `dualbody.inverse_dynamics`."""
    return _inverse_dynamics(model, *_floats(q, v, a))


def forward_dynamics(model: Model, q: Any, v: Any, tau: Any) -> Any:
    """Accelerations (..., nv) that the joint forces produce. See `dualbody.forward_dynamics`."""
    return _forward_dynamics(model, *_floats(q, v, tau))


def bias_forces(model: Model, q: Any, v: Any) -> Any:
    """Coriolis, centrifugal and gravity forces (..., nv)."""
    return inverse_dynamics(model, q, v, jnp.zeros(model.nv))


def gravity_forces(model: Model, q: Any) -> Any:
    """Joint forces (..., nv) that hold the robot still against gravity."""
    return inverse_dynamics(model, q, jnp.zeros(model.nv), jnp.zeros(model.nv))


def mass_matrix(model: Model, q: Any) -> Any:
    """Mass matrix (..., nv, nv): column i is the force of a unit acceleration in i without gravity."""
    still = jnp.zeros(model.nv)
    columns = jax.vmap(lambda a: inverse_dynamics(model, q, still, a) - gravity_forces(model, q))(jnp.eye(model.nv))
    return jnp.moveaxis(columns, 0, -1)


def step(simulator: Simulator, q: Any, v: Any, u: Any) -> tuple[Any, Any]:
    """The next (q, v) with the input u held. See `Simulator.step`."""
    check(simulator, "JAX")
    q1, v1 = _step(simulator, *_floats(q, v, u))
    return q1, v1


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def _step(simulator: Simulator, q: Any, v: Any, u: Any) -> Any:
    return _call("step", simulator, (q.shape, v.shape), q, v, u)


@_step.defjvp
def _(simulator: Simulator, primals: Any, tangents: Any) -> Any:
    q, v, u = primals
    dq, dv, du = tangents
    model = simulator.model
    nv, batch = model.nv, v.shape[:-1]
    shapes = ((*batch, 2 * nv, 2 * nv), (*batch, 2 * nv, simulator.nu))
    a, b = _call("linearize", simulator, shapes, q, v, u)
    q1, v1 = _step(simulator, q, v, u)
    dx = _times(a, jnp.concatenate([_tangent(model, q, dq), dv], axis=-1)) + _times(b, du)
    return (q1, v1), (_coordinates(model, q1, dx[..., :nv]), dx[..., nv:])


def rollout(simulator: Simulator, q: Any, v: Any, inputs: Any) -> tuple[Any, Any]:
    """States (..., steps + 1, nq) and (..., steps + 1, nv) under inputs (..., steps, nu): one call, and one for all Jacobians of its steps.

    What a trajectory does not reach, because it diverges, is NaN.
    """
    check(simulator, "JAX")
    inputs = jnp.asarray(inputs, jnp.result_type(float))
    q, v = _floats(q, v)
    batch = jnp.broadcast_shapes(q.shape[:-1], inputs.shape[:-2])
    qs, vs = _rollout(
        simulator,
        jnp.broadcast_to(q, (*batch, q.shape[-1])),
        jnp.broadcast_to(v, (*batch, v.shape[-1])),
        jnp.broadcast_to(inputs, (*batch, *inputs.shape[-2:])),
    )
    return qs, vs


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def _rollout(simulator: Simulator, q: Any, v: Any, inputs: Any) -> Any:
    batch, steps = q.shape[:-1], inputs.shape[-2]
    shapes = ((*batch, steps + 1, q.shape[-1]), (*batch, steps + 1, v.shape[-1]))
    return _call("rollout", simulator, shapes, q, v, inputs)


@_rollout.defjvp
def _(simulator: Simulator, primals: Any, tangents: Any) -> Any:
    q, v, inputs = primals
    dq, dv, dinputs = tangents
    model = simulator.model
    nv, batch, steps = model.nv, q.shape[:-1], inputs.shape[-2]
    qs, vs = _rollout(simulator, q, v, inputs)
    shapes = ((*batch, steps, 2 * nv, 2 * nv), (*batch, steps, 2 * nv, simulator.nu))
    jacobians = _call("linearize", simulator, shapes, qs[..., :-1, :], vs[..., :-1, :], inputs)
    # δx⁺ = A δx + B δu, step by step.
    a, b, du = (jnp.moveaxis(x, len(batch), 0) for x in (*jacobians, dinputs))

    def advance(dx: Any, given: Any) -> Any:
        a, b, du = given
        dx = _times(a, dx) + _times(b, du)
        return dx, dx

    first = jnp.concatenate([_tangent(model, q, dq), dv], axis=-1)
    _, rest = jax.lax.scan(advance, first, (a, b, du))
    dx = jnp.moveaxis(jnp.concatenate([first[None], rest]), 0, len(batch))
    return (qs, vs), (_coordinates(model, qs, dx[..., :nv]), dx[..., nv:])
