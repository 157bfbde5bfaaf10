"""Simulation: what acts on a robot, steps, rollouts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from ._dualbody import Simulator, set_threads, threads

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Literal

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._dualbody import Array, Model, RepresentationName
    from .contact import HuntCrossley

__all__ = [
    "Actuation",
    "Actuator",
    "Anchor",
    "Ball",
    "ContactReport",
    "Coupler",
    "Distance",
    "ExternalForce",
    "FrameActuator",
    "Linearization",
    "Rollout",
    "Simulator",
    "Status",
    "Weld",
    "set_threads",
    "threads",
]


class Linearization(NamedTuple):
    """Jacobians of a step in tangent coordinates:  δx⁺ = a δx + b δu,  δx = (δq, δv, δcontact)."""

    a: Array
    b: Array


@dataclass(frozen=True)
class Actuator:
    """A motor. torque_speed: (torque, threshold, maximum): full torque up to the threshold speed, none from the maximum; effort: limit,
    N·m or N; friction: (Coulomb force, slip velocity); position: (lower, upper, HuntCrossley) stops; velocity: (speed, damping) beyond."""

    torque_speed: tuple[float, float, float] | None = None
    effort: float | None = None
    friction: tuple[float, float] | None = None
    position: tuple[float | None, float | None, HuntCrossley | Sequence[float]] | None = None
    velocity: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.position is not None and not isinstance(self.position[2], Sequence):
            lower, upper = self.position[:2]
            stop: Any = self.position[2]
            numbers = (stop.stiffness, stop.damping, stop.stiffness_exponent, stop.damping_exponent)
            object.__setattr__(self, "position", (lower, upper, numbers))


@dataclass(frozen=True)
class Actuation:
    """Motors of all joints: "ideal" ones, or those of the description ("model"), but for the joints that are named."""

    base: Literal["ideal", "model"] = "ideal"
    actuators: Mapping[str, Actuator] = field(default_factory=dict)


@dataclass(frozen=True)
class Anchor:
    """A place on a frame or link, or on the world (None): a pose (4, 4) in it, or a translation (3,), m."""

    frame: str | None = None
    placement: ArrayLike = (0.0, 0.0, 0.0)

    def pose_in_world(self, model: Model, q: ArrayLike) -> Array:
        """Its pose (4, 4) in the world."""
        import numpy as np

        from . import frame_pose

        placement = np.asarray(self.placement, dtype=float)
        if placement.shape == (3,):
            placement = np.block([[np.eye(3), placement[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])
        return placement if self.frame is None else frame_pose(model, q, self.frame) @ placement

    def brought_to(self, other: Anchor, model: Model, q: ArrayLike) -> Anchor:
        """A place on this frame that is where the other is in the configuration q."""
        import numpy as np

        here = Anchor(self.frame).pose_in_world(model, q)
        return Anchor(self.frame, np.linalg.solve(here, other.pose_in_world(model, q)))


@dataclass(frozen=True)
class Weld:
    """Two places coincide, axes too. time_constant: in which an error is undone, s."""

    a: Anchor
    b: Anchor
    time_constant: float | None = None
    _kind = "weld"


@dataclass(frozen=True)
class Ball:
    """The origins of two places coincide."""

    a: Anchor
    b: Anchor
    time_constant: float | None = None
    _kind = "ball"


@dataclass(frozen=True)
class Distance:
    """The origins of two places are a length (m) apart."""

    a: Anchor
    b: Anchor
    length: float
    time_constant: float | None = None
    _kind = "distance"


@dataclass(frozen=True)
class Coupler:
    """The second joint follows the first:  q₂ = ratio · q₁ + offset."""

    joints: tuple[str, str]
    ratio: float
    offset: float = 0.0
    time_constant: float | None = None
    _kind = "coupler"


@dataclass(frozen=True)
class ExternalForce:
    """A constant force and torque (6,) at a place: [linear; angular], N and N·m, in a representation."""

    place: Anchor
    force: Sequence[float]
    representation: RepresentationName = "mixed"


@dataclass(frozen=True)
class FrameActuator:
    """An input that acts at a place: a wrench (6,) for each unit of it, within limits (lower, upper) if there are any."""

    name: str
    place: Anchor
    wrench: Sequence[float]
    representation: RepresentationName = "body"
    limits: tuple[float, float] | None = None

    @staticmethod
    def thruster(
        name: str,
        place: Anchor,
        direction: Sequence[float],
        torque_ratio: float = 0.0,
        limits: tuple[float, float] | None = None,
    ) -> FrameActuator:
        """A force along a direction of the place's axes, with a torque about it: torque_ratio · force, m."""
        length = sum(x * x for x in direction) ** 0.5
        if not 0.0 < length < float("inf"):
            raise ValueError(f"direction {tuple(direction)} of {name!r} has no length")
        along = [x / length for x in direction]
        wrench = (*along, *(torque_ratio * x for x in along))
        return FrameActuator(name, place, wrench, "body", limits)


class ContactReport(NamedTuple):
    """What touches: places, velocities, normals (n, 3) and depths (n,) of the points, forces on them (n, 3), on the links (links, 6), modes
    and reasons in words, forces of constraints, and the solver's certificate (status, iterations, residual, violations)."""

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


class Status(NamedTuple):
    """How a trajectory ended: "completed", or "diverged" or "non_finite_input" at a step."""

    kind: str
    step: int | None = None

    @property
    def is_completed(self) -> bool:
        return self.kind == "completed"

    def __str__(self) -> str:
        return self.kind if self.step is None else f"{self.kind} at step {self.step}"


@dataclass(frozen=True)
class Rollout:
    """Trajectories. q (..., steps + 1, nq), v (..., steps + 1, nv), contact (..., steps + 1, n_contact), u (..., steps, nu).

    The arrays of the states are views of one array; what a trajectory did not reach is NaN. status is a `Status`, or a list of them for a
    batch; rollout[i] is one trajectory of a batch.
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
        """Number of trajectories; 1 if it is no batch."""
        return len(self.status) if isinstance(self.status, list) else 1

    @property
    def steps(self) -> int:
        """Steps that were asked for."""
        return int(self.q.shape[-2]) - 1

    @property
    def n_states(self) -> int | NDArray[np.int64]:
        """Number of states that were reached; an array for a batch."""
        import numpy as np

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
        import numpy as np

        times: Array = np.arange(self.steps + 1, dtype=np.float64) * self.time_step
        return times

    def __getitem__(self, index: int | tuple[int, ...]) -> Rollout:
        """One trajectory of a batch."""
        import numpy as np

        shape = self.q.shape[:-2]
        if not isinstance(self.status, list):
            raise TypeError("the rollout is no batch")
        indices = index if isinstance(index, tuple) else (index,)
        if len(indices) != len(shape):
            raise IndexError(f"{len(shape)} indices are expected")
        wrapped = tuple(range(n)[i] for i, n in zip(indices, shape, strict=True))
        k = int(np.ravel_multi_index(wrapped, shape))
        u = self.u if self.u.ndim == 2 else self.u[wrapped]
        return Rollout(
            self.q[wrapped],
            self.v[wrapped],
            u,
            self.contact[wrapped],
            self.status[k],
            self.solver_failure[k],
            self.time_step,
            self.input_names,
        )

    def __len__(self) -> int:
        if not isinstance(self.status, list):
            raise TypeError("the rollout is no batch")
        return int(self.q.shape[0])

    def __repr__(self) -> str:
        stopped = [] if isinstance(self.status, Status) else [s for s in self.status if not s.is_completed]
        if isinstance(self.status, Status):
            status = str(self.status)
        else:
            status = f"{len(stopped)} of {len(self.status)} stopped early" if stopped else "completed"
        shapes = f"q {self.q.shape}, v {self.v.shape}, u {self.u.shape}"
        return f"Rollout({shapes}, {self.steps} steps of {self.time_step} s, {status})"


def _rollout(
    simulator: Simulator,
    batch: list[int],
    arrays: tuple[Array, Array | None, Array | None],
    statuses: list[tuple[str, int | None]],
    failures: list[tuple[int, str] | None],
    bar: Any,
) -> Rollout:
    """The rollout of a simulator's numbers."""
    import numpy as np

    rows, controlled, given = arrays
    nq, nv = simulator.model.nq, simulator.model.nv
    count, steps = len(statuses), rows.shape[1] - 1
    rows = rows[:count].reshape((*batch, steps + 1, rows.shape[2]))
    if controlled is not None:
        u = controlled.reshape((*batch, steps, simulator.nu))
    elif given is not None:
        u = np.broadcast_to(given, (*batch, *given.shape[-2:]))
    else:
        u = np.broadcast_to(np.zeros(simulator.nu), (*batch, steps, simulator.nu))
    if bar is not None:
        bar.close()
    every = [Status(*status) for status in statuses]
    return Rollout(
        rows[..., :nq],
        rows[..., nq : nq + nv],
        u,
        rows[..., nq + nv :],
        every if batch else every[0],
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
