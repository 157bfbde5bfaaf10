# pyright: reportAttributeAccessIssue=false
# Where PyTorch is not installed, its name means this very file to Pyright.
"""Functions of PyTorch: under autograd, `torch.func.grad`, `vjp`, `jacrev` and `vmap`.

>>> import torch, dualbody as db, dualbody.torch as dt
>>> model = db.samples.pendulum()
>>> q = torch.zeros(1, dtype=torch.float64, requires_grad=True)
>>> dt.inverse_dynamics(model, q, q.detach(), q.detach())[0].backward()
>>> float(q.grad[0])  # m g l / 2
4.905

Values and slopes are the library's own, exact ones, in reverse: a rollout is one call, and so is its gradient in start, inputs and the parameters
of the robot. They are computed on the CPU in float64, whatever tensors come in; results have the device of the first and the type of all tensors.
`vmap` is one call for the batch. First derivatives in reverse only: no `jacfwd`, no `hessian`. Changes of q are changes of its coordinates,
quaternions included.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
import torch

from . import _dualbody, _slopes
from ._dualbody import Model, Simulator

__all__ = [
    "bias_forces",
    "forward_dynamics",
    "gravity_forces",
    "inverse_dynamics",
    "mass_matrix",
    "rollout",
    "step",
]


class _Call(torch.autograd.Function):  # type: ignore[misc, unused-ignore]
    """A function of NumPy arrays with a batch, (arrays) -> tuple, and its slopes, (arrays, results, slopes) -> tuple."""

    @staticmethod
    def forward(function: Callable[..., Any], slopes: Callable[..., Any] | None, *tensors: Any) -> Any:
        results = function(*(x.detach().cpu().numpy().astype(np.float64, copy=False) for x in tensors))
        dtype = functools.reduce(torch.promote_types, (x.dtype for x in tensors))
        one = functools.partial(torch.as_tensor, dtype=dtype, device=tensors[0].device)
        return tuple(one(np.array(x)) for x in results)

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.slopes = inputs[1]
        ctx.save_for_backward(*inputs[2:], *output)

    @staticmethod
    def backward(ctx: Any, *slopes: Any) -> Any:
        if ctx.slopes is None:
            raise NotImplementedError("dualbody.torch gives first derivatives only")
        return None, None, *_Call.apply(ctx.slopes, None, *ctx.saved_tensors, *slopes)

    @staticmethod
    def vmap(info: Any, in_dims: Any, function: Any, slopes: Any, *tensors: Any) -> Any:
        batched = (
            x.expand(info.batch_size, *x.shape) if dim is None else x.movedim(dim, 0)
            for x, dim in zip(tensors, in_dims[2:], strict=True)
        )
        results = _Call.apply(function, slopes, *batched)
        return results, (0,) * len(results)


def _tensors(arrays: tuple[Any, ...], axes: tuple[int, ...]) -> list[Any]:
    """Tensors of floats of one batch, of so many axes each behind it."""
    given = [torch.as_tensor(x) for x in arrays]
    given = [x if x.is_floating_point() else x.to(torch.get_default_dtype()) for x in given]
    batch = torch.broadcast_shapes(*(x.shape[: x.ndim - n] for x, n in zip(given, axes, strict=True)))
    return [x.expand(*batch, *x.shape[x.ndim - n :]) for x, n in zip(given, axes, strict=True)]


def _dynamics(function: Callable[..., Any], slopes: Callable[..., Any], model: Model, *arrays: Any) -> Any:
    call = functools.partial(function, model)
    own_slopes = functools.partial(slopes, model)
    return _Call.apply(lambda *x: (call(*x),), own_slopes, *_tensors(arrays, (1,) * len(arrays)))[0]


def inverse_dynamics(model: Model, q: Any, v: Any, a: Any) -> Any:
    """Joint forces (..., nv) that produce the accelerations a. See `dualbody.inverse_dynamics`."""
    return _dynamics(_dualbody.inverse_dynamics, _slopes.of_inverse_dynamics, model, q, v, a)


def forward_dynamics(model: Model, q: Any, v: Any, tau: Any) -> Any:
    """Accelerations (..., nv) that the joint forces produce. See `dualbody.forward_dynamics`."""
    return _dynamics(_dualbody.forward_dynamics, _slopes.of_forward_dynamics, model, q, v, tau)


def bias_forces(model: Model, q: Any, v: Any) -> Any:
    """Coriolis, centrifugal and gravity forces (..., nv)."""
    return inverse_dynamics(model, q, v, torch.zeros_like(torch.as_tensor(v)))


def gravity_forces(model: Model, q: Any) -> Any:
    """Joint forces (..., nv) that hold the robot still against gravity."""
    q = torch.as_tensor(q)
    still = q.new_zeros(model.nv)
    return inverse_dynamics(model, q, still, still)


def mass_matrix(model: Model, q: Any) -> Any:
    """Mass matrix (..., nv, nv): column i is the force of a unit acceleration in i without gravity."""
    q = torch.as_tensor(q)
    units = torch.eye(model.nv, dtype=q.dtype, device=q.device)
    forces = inverse_dynamics(model, q[..., None, :], q.new_zeros(model.nv), units)
    return (forces - gravity_forces(model, q)[..., None, :]).transpose(-1, -2)


def _simulated(
    simulator: Simulator,
    run: Callable[..., Any],
    slopes: Callable[..., Any],
    given: tuple[tuple[Any, Any, Any], tuple[int, int, int]],
    parameters: Any,
) -> Any:
    """A step or a rollout, of this robot or with other parameters of it."""
    _slopes.check(simulator, "PyTorch")
    (arrays, axes), wanted = given, parameters is not None

    def back(own: Simulator, *x: Any) -> Any:
        return slopes(own, x[:3], x[3:5], x[5:], wanted)

    if not wanted:
        return _Call.apply(
            functools.partial(run, simulator), functools.partial(back, simulator), *_tensors(arrays, axes)
        )

    def of_robots(function: Callable[..., Any]) -> Callable[..., Any]:
        return lambda *x: _slopes.for_each_robot(simulator, x[3], function, (*x[:3], *x[4:]))

    return _Call.apply(of_robots(run), of_robots(back), *_tensors((*arrays, parameters), (*axes, 1)))


def step(simulator: Simulator, q: Any, v: Any, u: Any, parameters: Any = None) -> Any:
    """The next (q, v) with the input u held. See `Simulator.step`.

    parameters (..., n): those of the robot, instead of `simulator.model.parameters`; the step is differentiable in them.
    """
    return _simulated(simulator, _step, _slopes.of_step, ((q, v, u), (1, 1, 1)), parameters)


def _step(simulator: Simulator, q: Any, v: Any, u: Any) -> Any:
    return tuple(simulator.step(q, v, u))


def rollout(simulator: Simulator, q: Any, v: Any, inputs: Any, parameters: Any = None) -> Any:
    """States (..., steps + 1, nq) and (..., steps + 1, nv) under inputs (..., steps, nu): one call, and one for the gradient.

    parameters (..., n): those of the robot, instead of `simulator.model.parameters`; the rollout is differentiable in them. What a trajectory
    does not reach, because it diverges, is NaN.
    """
    return _simulated(simulator, _rollout, _slopes.of_rollout, ((q, v, inputs), (1, 1, 2)), parameters)


def _rollout(simulator: Simulator, q: Any, v: Any, inputs: Any) -> Any:
    out = simulator.rollout(q, v, inputs=inputs)
    return out.q, out.v
