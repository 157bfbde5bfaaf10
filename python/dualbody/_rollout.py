"""Results of simulations: trajectories, Jacobians, gradients, reports; how the compiled module makes them, and progress of what takes long."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ._value import Value

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from ._dualbody import Array, Simulator


class Linearization(NamedTuple):
    """Jacobians of a step in tangent coordinates:  δx⁺ = a δx + b δu,  δx = (δq, δv, δcontact)."""

    a: Array
    b: Array


class SensorLinearization(NamedTuple):
    """Jacobians of a step and of its sensor readings:  δx⁺ = a δx + b δu,  δy = c δx + d δu,  δx = (δq, δv, δcontact)."""

    a: Array
    b: Array
    c: Array
    d: Array


class PairContact(NamedTuple):
    """A point at which two links are near each other, in world axes: the midpoint between both. The normal points out of the second link; the velocity is
    that of the first link minus that of the second; the force acts on the first link, and the opposite force on the second."""

    links: tuple[str, str]
    position: Array
    velocity: Array
    normal: Array
    depth: float
    force: Array
    mode: str
    reason: str


class ContactReport(NamedTuple):
    """Report on contact: positions, velocities, normals (n, 3) and depths (n,) of the points, forces on them (n, 3), on the links (links, 6), modes
    ("separated", "touching", "sticking", "impending", "sliding", …) and reasons as text, forces of constraints, the certificate of the solver (status,
    usually "converged", iterations, residual, violations), and the points between bodies. Positions and forces are in world axes."""

    positions: Array
    velocities: Array
    normals: Array
    depths: Array
    forces: Array
    links: Array
    modes: list[str]
    reasons: list[str]
    constraints: Array
    certificate: tuple[str, int, float, float, float, float]
    pairs: list[PairContact]


class Status(NamedTuple):
    """Status of a trajectory at its end: "completed", or "diverged", "non_finite_input" or "out_of_memory" at a step."""

    kind: str
    step: int | None = None

    @property
    def is_completed(self) -> bool:
        """Whether all steps were taken."""
        return self.kind == "completed"

    def __str__(self) -> str:
        return self.kind if self.step is None else f"{self.kind} at step {self.step}"


@dataclass(frozen=True, eq=False)
class Rollout(Value):
    """Trajectories. q (..., steps + 1, nq), v (..., steps + 1, nv), contact (..., steps + 1, n_contact), u (..., steps, nu).

    The arrays of the states are views of one array; states that a trajectory did not reach are NaN. status is a `Status`, or a list of them for a batch;
    rollout[i] is one trajectory of a batch.
    """

    q: Array
    v: Array
    u: Array
    contact: Array
    status: Status | list[Status]
    #: (step, status) of the first step in which the solver of forces failed, or None; a list of them for a batch
    solver_failure: Any
    time_step: float
    input_names: list[str]

    @property
    def n_batch(self) -> int:
        """Number of trajectories; 1 without a batch."""
        return len(self.status) if isinstance(self.status, list) else 1

    @property
    def steps(self) -> int:
        """Requested number of steps."""
        return int(self.q.shape[-2]) - 1

    @property
    def n_states(self) -> int | NDArray[np.int64]:
        """Number of states reached; an array for a batch."""
        if isinstance(self.status, Status):
            return self.steps + 1 if self.status.step is None else self.status.step + 1
        reached = [self.steps if s.step is None else s.step for s in self.status]
        return np.asarray(reached).reshape(self.q.shape[:-2]) + 1

    @property
    def is_completed(self) -> bool:
        """Whether all steps of all trajectories were taken."""
        statuses = self.status if isinstance(self.status, list) else [self.status]
        return all(status.is_completed for status in statuses)

    @property
    def times(self) -> Array:
        """Times of the states, (steps + 1,), s."""
        return np.arange(self.steps + 1, dtype=np.float64) * self.time_step

    def __getitem__(self, index: int | tuple[int, ...]) -> Rollout:
        """One trajectory of a batch."""
        shape = self.q.shape[:-2]
        if not isinstance(self.status, list):
            raise TypeError("the rollout is not a batch")
        indices = index if isinstance(index, tuple) else (index,)
        if len(indices) != len(shape):
            raise IndexError(f"{len(shape)} indices are expected")
        wrapped = tuple(range(n)[i] for i, n in zip(indices, shape, strict=True))
        k = int(np.ravel_multi_index(wrapped, shape))
        u = self.u if self.u.ndim == 2 else self.u[wrapped]
        parts = {name: getattr(self, name)[wrapped] for name in ("q", "v", "contact")}
        return replace(self, **parts, u=u, status=self.status[k], solver_failure=self.solver_failure[k])

    def __len__(self) -> int:
        if not isinstance(self.status, list):
            raise TypeError("the rollout is not a batch")
        return int(self.q.shape[0])

    def __repr__(self) -> str:
        stopped = [] if isinstance(self.status, Status) else [s for s in self.status if not s.is_completed]
        if isinstance(self.status, Status):
            status = str(self.status)
        else:
            status = f"{len(stopped)} of {len(self.status)} stopped early" if stopped else "completed"
        shapes = f"q {self.q.shape}, v {self.v.shape}, u {self.u.shape}"
        return f"Rollout({shapes}, {self.steps} steps of {self.time_step} s, {status})"


class StepGradient(NamedTuple):
    """Gradient of ⟨adjoint, next state⟩ of a step: in the state along its tangent (..., n_tangent), in the input (..., nu), in all parameters
    of the model (..., n), named by `Model.parameter_names`, in the friction of each contact point (..., points), and in all parameters of the simulator
    (..., n), named by `Simulator.parameter_names`: those of the model first, then motors, dry friction, joint limits, constraints,
    contact points and models, ground, forces, time step. The last three are empty if not requested; the last one is None on GPUs."""

    state: Array
    input: Array
    parameters: Array
    friction: Array
    simulator_parameters: Any = None


class RolloutGradient(NamedTuple):
    """Gradient of a cost of a rollout: in the start along its tangent (..., n_tangent), in the inputs (..., steps, nu), in all parameters of the
    model (..., n) and in the friction of each contact point (..., points); status as of a Rollout. The gradient of an incomplete trajectory is zero. cost:
    the value, if the gradient is that of a cost function; otherwise None. simulator_parameters (..., n): in all parameters of the
    simulator, named by `Simulator.parameter_names`."""

    start: Array
    inputs: Array
    parameters: Array
    friction: Array
    status: Status | list[Status]
    cost: Any = None
    simulator_parameters: Any = None


#: Of all trajectories that came to their end: there may be very many.
_COMPLETED = Status("completed")

#: Trajectories that did not come to their end, by index, with kind and step.
Stopped = list[tuple[int, tuple[str, int | None]]]


def _statuses(count: int, stopped: Stopped, is_batch: bool) -> Status | list[Status]:
    """The status of a trajectory, or a list of those of a batch."""
    every = [_COMPLETED] * count
    for k, status in stopped:
        every[k] = Status(*status)
    return every if is_batch else every[0]


def _rollout(
    simulator: Simulator,
    batch: list[int],
    arrays: tuple[Array, Array | None, Array | None],
    ends: tuple[int, Stopped, list[tuple[int, tuple[int, str]]]],
    bar: Any,
) -> Rollout:
    """The rollout of a simulator's numbers."""
    rows, controlled, given = arrays
    count, stopped, failed = ends
    nq, nv = simulator.model.nq, simulator.model.nv
    steps = rows.shape[1] - 1
    rows = rows[:count].reshape((*batch, steps + 1, rows.shape[2]))
    if controlled is not None:
        u = controlled.reshape((*batch, steps, simulator.nu))
    elif given is not None:
        # A copy: what the caller does to its array later is not what was simulated.
        u = np.broadcast_to(given.copy(), (*batch, *given.shape[-2:]))
    else:
        u = np.broadcast_to(np.zeros(simulator.nu), (*batch, steps, simulator.nu))
    if bar is not None:
        bar.close()
    failures: list[tuple[int, str] | None] = [None] * count
    for k, failure in failed:
        failures[k] = failure
    return Rollout(
        rows[..., :nq],
        rows[..., nq : nq + nv],
        u,
        rows[..., nq + nv :],
        _statuses(count, stopped, bool(batch)),
        failures if batch else failures[0],
        simulator.time_step,
        simulator.input_names,
    )


class _Progress:
    """Calls a function, or moves a bar, by the steps that were taken."""

    def __init__(self, show: Callable[[int], object], close: Callable[[], object], scale: float, total: int) -> None:
        self._show, self._close, self._scale, self._total = show, close, scale, total

    def __call__(self, done: int) -> None:
        self._show(min(int(done * self._scale), self._total))

    def close(self) -> None:
        self._show(self._total)
        self._close()


def _progress(progress: Any, sizes: tuple[int, int], controlled: bool, width: int) -> _Progress | None:
    """What shows how far a rollout has come. A batch counts the steps of groups of `width` states."""
    if progress is None or progress is False:
        return None
    steps, count = sizes
    groups = 1 if controlled else -(-count // width)
    if not callable(progress) and progress is not True:
        raise TypeError(f"progress is {progress!r}, expected True or a function of the number of steps")
    if callable(progress):
        return _Progress(progress, lambda: None, 1.0 / groups, steps)
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped, unused-ignore]
    except ImportError:
        return None
    bar = tqdm(total=steps, unit="step")

    def show(done: int) -> None:
        bar.update(done - bar.n)

    return _Progress(show, bar.close, 1.0 / groups, steps)
