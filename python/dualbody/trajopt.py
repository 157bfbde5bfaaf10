"""Trajectory optimisation: `Problem`, `Ddp`, `SingleShooting`, `Transcription`, `RecedingHorizon`.

A state is x = (q, v, contact). A cost is a list of terms, weight · activation(residual); a residual is a small class of this module.

Dynamics and residuals may also be Python functions with their Jacobians, `Dynamics` and `Residual`. Each call takes the interpreter lock and some
additional microseconds, one thread at a time, and second derivatives of these functions are replaced by Gauss–Newton.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, fields
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from . import _dualbody
from ._convert import given
from ._dualbody import RecedingHorizon
from ._value import Value

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from ._dualbody import Array, Guess, Report, RepresentationName, Simulator

__all__ = [
    "Activation", "CenterOfMass", "CentroidalMomentum", "Constraint", "Curve", "Ddp", "Dynamics", "FrameDistance", "FrameOrientation",
    "FramePose", "FramePosition", "FrameVelocity", "InputError", "LinkDistances", "Problem", "RecedingHorizon", "Residual", "ShootingSolution",
    "SingleShooting", "Solution", "StateError", "Term", "Transcription", "TranscriptionSolution", "position_bounds",
]


@dataclass(frozen=True)
class Activation:
    """The cost function of a residual r: `quadratic` (½ Σ r²), `weighted`, `smooth_abs`, `flat` or `barrier`."""

    kind: str = "quadratic"
    x: Sequence[float] = ()
    y: Sequence[float] = ()

    @staticmethod
    def quadratic() -> Activation:
        """½ Σ r²."""
        return Activation()

    @staticmethod
    def weighted(weights: Sequence[float]) -> Activation:
        """½ Σ w r²."""
        return Activation("weighted", tuple(weights))

    @staticmethod
    def smooth_abs(width: float) -> Activation:
        """Σ √(r² + width²) - width: ½ r² / width near zero, |r| far away."""
        return Activation("smooth_abs", (width,))

    @staticmethod
    def flat(width: float) -> Activation:
        """Σ 1 - exp(-½ r² / width²): outliers have no influence."""
        return Activation("flat", (width,))

    @staticmethod
    def barrier(lower: Sequence[float], upper: Sequence[float]) -> Activation:
        """½ Σ dist(r, [lower, upper])²: free inside, bounds may be infinite."""
        return Activation("barrier", tuple(lower), tuple(upper))


@dataclass(frozen=True, eq=False)
class StateError(Value):
    """Deviation of the state from a reference (nx,), from one for each stage (stages, nx), or from neutral (None)."""

    reference: ArrayLike | None = None


@dataclass(frozen=True, eq=False)
class InputError(Value):
    """Deviation of the input from a reference (nu,), from one for each stage (stages, nu), or from zero (None)."""

    reference: ArrayLike | None = None


@dataclass(frozen=True)
class FramePosition:
    """Distance of a frame's origin from a point in the world, m."""

    frame: str
    target: Sequence[float]


@dataclass(frozen=True, eq=False)
class FrameOrientation(Value):
    """Rotation of a frame from the axes of a pose (4, 4), rad."""

    frame: str
    target: ArrayLike


@dataclass(frozen=True, eq=False)
class FramePose(Value):
    """Displacement of a frame from a target pose (4, 4)."""

    frame: str
    target: ArrayLike


@dataclass(frozen=True)
class FrameVelocity:
    """Deviation of a frame's velocity from a target (6,)."""

    frame: str
    target: Sequence[float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    representation: RepresentationName = "mixed"


@dataclass(frozen=True)
class FrameDistance:
    """Distance between a frame's origin and a point (3,) or another frame (its name), m: one number."""

    frame: str
    from_: str | Sequence[float]


@dataclass(frozen=True)
class LinkDistances:
    """Distances of pairs of links by their collision shapes, m: for collision avoidance with obstacles, which are links of fixed objects of a world, and
    for self-collision avoidance.

    One entry per pair; with `samples_between` the same number again for each configuration between a node and the previous one, evenly spaced on the path
    q ⊕ (-s v) with the velocity of the node. The interval before the last node needs a final constraint. Negative if links overlap. smoothing: width of a soft minimum
    over near features, m, as in `contact.nearest`.

    >>> import dualbody as db
    >>> clear = db.trajopt.LinkDistances([("hand", "shelf"), ("hand", "upper_arm")], samples_between=2)
    >>> constraint, soft = clear.at_least(0.05), db.trajopt.Term(10.0, clear, clear.barrier(0.05))
    """

    pairs: Sequence[tuple[str, str]]
    samples_between: int = 0
    smoothing: float = 0.0

    def _bounds(self, distance: float) -> tuple[list[float], list[float]]:
        n = len(self.pairs) * (self.samples_between + 1)
        return [distance] * n, [float("inf")] * n

    def at_least(self, distance: float) -> Constraint:
        """The constraint that all distances are at least `distance`, m."""
        return Constraint(self, self._bounds(distance))

    def barrier(self, distance: float) -> Activation:
        """The activation of the soft form: ½ the sum of squared shortfalls."""
        return Activation.barrier(*self._bounds(distance))


@dataclass(frozen=True)
class CenterOfMass:
    """Deviation of the centre of mass from a point in the world, m."""

    target: Sequence[float]


@dataclass(frozen=True)
class CentroidalMomentum:
    """Deviation of the centroidal momentum from a target (6,)."""

    target: Sequence[float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Residual:
    """A residual as a Python function: value(x, u) returns (dim,), jacobians(x, u) its derivatives (dim, ndx) and (dim, nu).

    x (nx,) and u (nu,), which is empty at the end of the horizon; the derivative in x is along tangent directions of the state.
    """

    dim: int
    value: Callable[[Array, Array], ArrayLike]
    jacobians: Callable[[Array, Array], tuple[ArrayLike, ArrayLike]]


@dataclass(frozen=True)
class Dynamics:
    """Dynamics as a Python function: step(x, u) returns the next state (nx,), jacobians(x, u) its derivatives (nx, nx) and (nx, nu).

    time_step: the factor of running costs, s.
    """

    nx: int
    nu: int
    step: Callable[[Array, Array], ArrayLike]
    jacobians: Callable[[Array, Array], tuple[ArrayLike, ArrayLike]]
    time_step: float = 1.0


@dataclass(frozen=True)
class Term:
    """weight · activation(residual); optionally only in the stages (first, end)."""

    weight: float
    residual: Any
    activation: Activation = Activation()
    stages: tuple[int, int] | None = None


@dataclass(frozen=True)
class Constraint:
    """A residual is zero, or within bounds (lower, upper)."""

    residual: Any
    bounds: tuple[Sequence[float], Sequence[float]] | None = None


@dataclass(frozen=True)
class Problem:
    """Minimises a cost over `horizon` steps of a simulator, or of Python dynamics, from a start x = (q, v, contact)."""

    simulator: Simulator | Dynamics
    horizon: int
    start: ArrayLike
    stage_cost: Sequence[Term] = ()
    final_cost: Sequence[Term] = ()
    input_bounds: tuple[ArrayLike, ArrayLike] | None = None
    constraints: Sequence[Constraint] = ()
    final_constraints: Sequence[Constraint] = ()
    free_start: bool = False

    def cost(self, x: ArrayLike, u: ArrayLike) -> float:
        """Cost of a trajectory: x (horizon + 1, nx), u (horizon, nu)."""
        return _dualbody._trajectory_cost(self, x, u)[0]

    def violation(self, x: ArrayLike, u: ArrayLike) -> float:
        """Largest violation of a constraint by a trajectory."""
        return _dualbody._trajectory_cost(self, x, u)[1]


@dataclass(frozen=True, eq=False)
class Solution(Value):
    """x (horizon + 1, nx), u (horizon, nu), gains (horizon, nu, ndx) of the feedback δu = gain δx, and the status of the solver."""

    x: Array
    u: Array
    gains: Array
    cost: float
    status: str
    is_converged: bool
    iterations: int
    cost_history: Array
    violation: float
    gap: float

    def __repr__(self) -> str:
        return f"Solution({self.status}, {self.iterations} iterations, cost {self.cost:.6g}, violation {self.violation:.1e})"


@dataclass(eq=False)
class _Solver:
    """A problem, and the options of what solves it; None stands for the default."""

    problem: Problem
    _: KW_ONLY
    max_iterations: int | None = None
    tolerance: float | None = None
    constraint_tolerance: float | None = None
    penalty: float | None = None

    @property
    def options(self) -> dict[str, Any]:
        """The options that are given, by name."""
        return given({own.name: getattr(self, own.name) for own in fields(self)}, "problem")


@dataclass(eq=False, kw_only=True)
class Ddp(_Solver):
    """Differential dynamic programming with constraints by an augmented Lagrangian.

    options: max_iterations, tolerance, threads, line_search_steps, exact_curvature (True: with the second derivatives of the steps),
    constraint_tolerance, penalty. None stands for the default.
    """

    threads: int | None = None
    line_search_steps: int | None = None
    exact_curvature: bool | None = None

    def solve(self, guess: Guess | None = None, report: Report | None = None) -> Solution:
        """Solves the problem from a guess (x, u) of the states and inputs (x None: rolled out); without a guess from zero inputs.

        report(iteration, cost, violation, gap) is called after each iteration; if it returns True the solver stops with the best trajectory so far.
        """
        return Solution(*_dualbody._ddp(self.problem, self.options, guess, report))


class ShootingSolution(NamedTuple):
    """x (horizon + 1, nx), u (horizon, nu), its variables (n,), and the status of the minimiser."""

    x: Array
    u: Array
    variables: Array
    cost: float
    status: str
    is_converged: bool
    iterations: int
    cost_history: Array
    violation: float


@dataclass(eq=False, kw_only=True)
class SingleShooting(_Solver):
    """The cost of a rollout as a function of its inputs, with exact first and second derivatives, and its minimisers.

    Variables (n,) are the inputs, stage by stage, transformed if they have bounds, and the start if it is free. options: minimizer
    ("lbfgs", "steepest_descent", "newton_cg", "trust_region"), max_iterations, tolerance, memory, radius, exact_curvature (True: the exact Hessian; False:
    Gauss–Newton), constraint_tolerance, penalty. For problems of a simulator.
    """

    minimizer: Literal["lbfgs", "steepest_descent", "newton_cg", "trust_region"] | None = None
    memory: int | None = None
    radius: float | None = None
    exact_curvature: bool | None = None

    def solve(self, guess: Guess | None = None, report: Report | None = None) -> ShootingSolution:
        """Minimises from the inputs of a guess (x, u); without a guess from zero inputs. report as for `Ddp.solve`."""
        *found, _ = _dualbody._single_shooting(self.problem, self.options, guess, report)  # shooting leaves no gap
        return ShootingSolution(*found)

    def variables(self, guess: Guess | None = None) -> Array:
        """The variables (n,) of a guess."""
        return _dualbody._shooting_variables(self.problem, self.options, guess)

    def trajectory(self, z: ArrayLike) -> tuple[Array, Array]:
        """The trajectory (x, u) of variables."""
        x, u = _dualbody._shooting_at(self.problem, self.options, "trajectory", z)
        return x, u

    def value(self, z: ArrayLike) -> float:
        """The cost, with the penalties of constraints; infinite if the rollout is not finite."""
        return float(_dualbody._shooting_at(self.problem, self.options, "value", z))

    def gradient(self, z: ArrayLike) -> Array:
        """The exact gradient of the value, (n,)."""
        return _dualbody._shooting_at(self.problem, self.options, "gradient", z)

    def hessian(self, z: ArrayLike) -> Array:
        """The Hessian of the value, (n, n): with exact_curvature all second derivatives of the rollout."""
        return _dualbody._shooting_at(self.problem, self.options, "hessian", z)


@dataclass(frozen=True, eq=False)
class Curve(Value):
    """A trajectory in continuous time: on each interval the state is a cubic, the input a parabola.

    states (horizon + 1, nx) and inputs (horizon + 1, nu) at the nodes, middle_states (horizon, nx) and middle_inputs (horizon, nu) between them. At these
    points it satisfies the dynamics of the problem; elsewhere to fourth order in the time step.
    """

    problem: Problem
    states: Array
    middle_states: Array
    inputs: Array
    middle_inputs: Array

    def __repr__(self) -> str:
        return f"Curve({len(self.middle_states)} intervals)"

    @property
    def _points(self) -> tuple[Array, Array, Array, Array]:
        return self.states, self.middle_states, self.inputs, self.middle_inputs

    def at(self, times: ArrayLike) -> tuple[Array, Array]:
        """States (..., nx) and inputs (..., nu) at times (...,), s; before the start and after the end the first and last ones."""
        times = np.asarray(times, dtype=float)
        x, u = _dualbody._curve_at(self.problem, self._points, times.reshape(-1))
        return x.reshape(times.shape + x.shape[1:]), u.reshape(times.shape + u.shape[1:])

    def held(self) -> tuple[Array, Array]:
        """States at the nodes and the mean input over each interval: a guess for solvers with constant inputs over a step."""
        return self.states, (self.inputs[:-1] + 4.0 * self.middle_inputs + self.inputs[1:]) / 6.0


class TranscriptionSolution(NamedTuple):
    """x (horizon + 1, nx) and u (horizon, nu) at the nodes, the curve through them, and the status of the solver; gap: the largest defect of the rate."""

    x: Array
    u: Array
    curve: Curve
    cost: float
    status: str
    is_converged: bool
    iterations: int
    cost_history: Array
    violation: float
    gap: float


@dataclass(eq=False, kw_only=True)
class Transcription(_Solver):
    """Direct collocation (Hermite–Simpson): states and inputs at all nodes and midpoints are variables.

    An interval lasts one time step of the simulator, which may be long. options: max_iterations, tolerance, gap_tolerance (of the rate of the
    state, in its unit), threads, line_search_steps, constraint_tolerance, penalty. For problems of a simulator that has a rate.
    """

    gap_tolerance: float | None = None
    threads: int | None = None
    line_search_steps: int | None = None

    def solve(self, guess: Guess | Curve | None = None, report: Report | None = None) -> TranscriptionSolution:
        """Solves the problem from a guess (x, u), which need not satisfy the dynamics, or from the curve of an earlier solution.

        x None: rolled out; without a guess from zero inputs. report as for `Ddp.solve`.
        """
        points = None
        if isinstance(guess, Curve):
            points = guess._points
            guess = guess.states, guess.inputs[:-1]
        found = _dualbody._transcription(self.problem, self.options, guess, points, report)
        x, u, (middle_states, inputs, middle_inputs), *outcome = found
        return TranscriptionSolution(x, u, Curve(self.problem, x, middle_states, inputs, middle_inputs), *outcome)


def plan(controller: RecedingHorizon) -> Solution:
    """The plan of a controller."""
    return Solution(*controller._solution())


def position_bounds(simulator: Simulator) -> tuple[list[float], list[float]]:
    """Bounds of the deviation of the state from neutral by the position limits of joints, infinite for no limit."""
    return _dualbody._position_bounds(simulator)
