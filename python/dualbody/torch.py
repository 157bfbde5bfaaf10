# pyright: reportAttributeAccessIssue=false
# Where PyTorch is not installed, its name means this very file to Pyright.
"""Functions of PyTorch: under autograd, `torch.func.grad`, `vjp`, `jvp`, `jacrev`, `jacfwd` and `vmap`.

>>> import torch, dualbody as db, dualbody.torch as dt
>>> model = db.samples.pendulum()
>>> q = torch.zeros(1, dtype=torch.float64, requires_grad=True)
>>> dt.inverse_dynamics(model, q, q.detach(), q.detach())[0].backward()
>>> float(q.grad[0])  # m g l / 2
4.905

The functions are those of `dualbody.jax`, with the same arguments: all of `dualbody.dynamics`, and of a simulator steps, rollouts, accelerations and contact.

Values and derivatives are those of the library, exact to rounding: a rollout is one call, and so is its gradient in start, inputs and the parameters of
the robot. They are computed on the CPU in float64 for all input tensors; results have the device of the first tensor and the common type of all tensors.
`vmap` is one call for the batch, a Jacobian one call for all directions. Only first derivatives exist: no `hessian`. Derivatives in q are those in its
coordinates, including quaternions.
"""

from __future__ import annotations

import functools
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import torch

from ._calls import Call, Library, functions

if TYPE_CHECKING:

    def __getattr__(name: str) -> Any: ...


#: Functions of tensors by NumPy's names, of which `vmap` knows more than those of these names in PyTorch.
_XP = SimpleNamespace(broadcast_to=torch.broadcast_to, moveaxis=torch.movedim, reshape=torch.reshape)


class _Call(torch.autograd.Function):  # type: ignore[misc, unused-ignore]
    """A call of the library."""

    @staticmethod
    def forward(call: Call, *tensors: Any) -> Any:
        results = call.on_numpy([x.detach().cpu().double().numpy() for x in tensors])
        dtype = functools.reduce(torch.promote_types, (x.dtype for x in tensors))
        return tuple(torch.as_tensor(x, dtype=dtype, device=tensors[0].device) for x in results)

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.call = inputs[0]
        ctx.save_for_backward(*inputs[1:])
        ctx.save_for_forward(*inputs[1:])

    @staticmethod
    def backward(ctx: Any, *slopes: Any) -> Any:
        call, tensors = ctx.call, ctx.saved_tensors
        inputs, wanted = tensors[: call.n_inputs], ctx.needs_input_grad[1:]
        out: list[Any] = [None] * len(tensors)
        if call.kind == "value":
            active = tuple(i for i, is_wanted in enumerate(wanted) if is_wanted)
            at = len(call.batch(tensors))
            found = _bind(call._replace(kind="pull", active=active), *inputs, *(x.unsqueeze(at) for x in slopes))
            for i, x in zip(active, found, strict=True):
                out[i] = x.squeeze(at)
        else:
            _refuse(wanted[: call.n_inputs])
            out[call.n_inputs :] = _bind(call.transposed(), *inputs, *slopes)
        return None, *out

    @staticmethod
    def jvp(ctx: Any, _: Any, *tangents: Any) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
        call, tensors = ctx.call, ctx.saved_tensors
        inputs, n = tensors[: call.n_inputs], call.n_inputs
        if call.kind == "value":
            active = tuple(i for i, tangent in enumerate(tangents) if tangent is not None)
            at = len(call.batch(tensors))
            found = _bind(call.pushed(active), *inputs, *(tangents[i].unsqueeze(at) for i in active))
            return tuple(x.squeeze(at) for x in found)
        _refuse([tangent is not None for tangent in tangents[:n]])
        more = (torch.zeros_like(x) if tangent is None else tangent for x, tangent in zip(tensors[n:], tangents[n:], strict=True))
        return tuple(_bind(call, *inputs, *more))

    @staticmethod
    def vmap(info: Any, axes: Any, call: Call, *tensors: Any) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
        results, where = call.on_batch(_XP, _bind, list(tensors), list(axes[1:]), info.batch_size)
        return tuple(results), tuple(where)


def _refuse(wanted: Any) -> None:
    if any(wanted):
        raise NotImplementedError("dualbody.torch gives first derivatives only")


def _bind(call: Call, *tensors: Any) -> Any:
    return _Call.apply(call, *tensors)


def _floats(*arrays: Any) -> list[Any]:
    given = [torch.as_tensor(x) for x in arrays]
    return [x if x.is_floating_point() else x.to(torch.get_default_dtype()) for x in given]


_FUNCTIONS = functions(Library(_XP, _bind, _floats))
globals().update(_FUNCTIONS)
__all__ = sorted(name for name in _FUNCTIONS if not name.startswith("_"))
