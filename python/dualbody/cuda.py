"""Many states of a robot, or of variants of it, on an NVIDIA GPU: steps, rollouts, Jacobians and gradients, in double or single precision.

The step is recorded for the robot, written as CUDA, compiled by NVRTC, and stored in the user's cache folder. Arrays are those of `dualbody.Simulator`,
with one row for each state. Ctrl-C ends compilation before the next kernel: NVRTC cannot be interrupted. Needs a package that is built with this feature,

    MATURIN_PEP517_ARGS="--features cuda" pip install ./python

and, where it runs, NVIDIA's driver and NVRTC (`pip install nvidia-cuda-nvrtc-cu12`). Neither is needed to build it.

States can also stay on the GPU, under a policy of PyTorch, CuPy or JAX that is there too; arrays are exchanged by DLPack, without a way over the host:

    gpu = dualbody.cuda.Simulator(simulator, 4096, precision="single")
    states = gpu.states(q, v)
    while training:
        x = torch.from_dlpack(states)               # (nq + nv + contact, 4096), a copy
        u = policy(x.T).T.contiguous()              # (nu, 4096)
        states.advance(u, steps=4)
        states.copy_from(torch.where(done, start, x))   # where episodes begin anew
"""

from __future__ import annotations

import ctypes
import importlib.util
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ._rollout import Stopped, _statuses
from .sim import Status
from ._value import Value


def _load_nvrtc() -> None:
    """Loads the NVRTC of its package of PyPI, if that is installed: its folder is not one in which the system looks."""
    try:
        found = importlib.util.find_spec("nvidia.cuda_nvrtc")
    except ModuleNotFoundError:
        return
    for folder in (found and found.submodule_search_locations) or ():
        for path in Path(folder, "lib").glob("libnvrtc.so.12"):
            ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL)


_load_nvrtc()
try:
    from ._dualbody import CudaSimulator as Simulator
    from ._dualbody import CudaStates as States
except ImportError:
    raise ImportError(
        "dualbody was built without CUDA; MATURIN_PEP517_ARGS=\"--features cuda\" pip install ./python, in its repository, builds it with",
        name=__name__,
    ) from None

if TYPE_CHECKING:
    from . import Simulator as Own
    from ._dualbody import Array

__all__ = ["Rollout", "Simulator", "States"]


@dataclass(frozen=True, eq=False)
class Rollout(Value):
    """Trajectories from a GPU. q (count, kept, nq), v (count, kept, nv), contact (count, kept, n_contact): the stored states, including the first, NaN
    after the end of a trajectory; last: (q, v, contact) of the last valid state of each, (count, ·); interval: between stored states, s. A `Status` of the
    kind "broken_condition" means that a step violated a condition of the recorded graph."""

    q: Array
    v: Array
    contact: Array
    last: tuple[Array, Array, Array]
    status: list[Status]
    interval: float

    @property
    def is_completed(self) -> bool:
        """Whether all steps of all trajectories were taken."""
        return all(status.is_completed for status in self.status)

    @property
    def times(self) -> Array:
        """Times of the stored states, (kept,), s."""
        return np.arange(self.q.shape[1], dtype=np.float64) * self.interval

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        stopped = sum(not status.is_completed for status in self.status)
        return f"cuda.Rollout(q {self.q.shape}, v {self.v.shape}, {f'{stopped} of {len(self)} stopped early' if stopped else 'completed'})"


def _rollout(simulator: Own, kept: Array, last: Array, interval: float, stopped: Stopped) -> Rollout:
    """The rollout of a simulator's numbers."""
    nq, nv = simulator.model.nq, simulator.model.nv

    def parts(x: Array) -> tuple[Array, Array, Array]:
        return x[..., :nq], x[..., nq : nq + nv], x[..., nq + nv :]

    statuses = _statuses(len(last), stopped, True)
    assert isinstance(statuses, list)
    return Rollout(*parts(kept), parts(last), statuses, interval)
