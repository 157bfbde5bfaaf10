"""Control: linear-quadratic regulators, computed torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from . import _dualbody
from ._value import Value

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._dualbody import Array, Model, Simulator

__all__ = ["ComputedTorque", "Equilibrium", "EquilibriumLqr", "FiniteHorizonLqr", "Lqr"]


@dataclass(frozen=True, eq=False)
class Lqr(Value):
    """Regulator u = -gain x with least cost: gain (nu, nx), cost_to_go (nx, nx), eigenvalues of the closed loop, the least stable first."""

    gain: Array
    cost_to_go: Array
    closed_loop_eigenvalues: NDArray[np.complex128]
    residual: float
    iterations: int
    #: The loop is stable and the gain optimal, or the reason why not, in words
    status: str
    is_stabilized: bool

    @staticmethod
    def discrete(a: ArrayLike, b: ArrayLike, q: ArrayLike, r: ArrayLike, *, check: bool = True) -> Lqr:
        """Of x⁺ = a x + b u at the cost Σ x' q x + u' r u. a and q (nx, nx), b (nx, nu), r (nu, nu).

        A ValueError says why there is no such regulator; with check=False that is its `status`."""
        return Lqr._design(True, a, b, q, r, check)

    @staticmethod
    def continuous(a: ArrayLike, b: ArrayLike, q: ArrayLike, r: ArrayLike, *, check: bool = True) -> Lqr:
        """Of ẋ = a x + b u at the cost ∫ x' q x + u' r u. a and q (nx, nx), b (nx, nu), r (nu, nu).

        A ValueError says why there is no such regulator; with check=False that is its `status`."""
        return Lqr._design(False, a, b, q, r, check)

    @staticmethod
    def _design(discrete: bool, a: ArrayLike, b: ArrayLike, q: ArrayLike, r: ArrayLike, check: bool) -> Lqr:
        found = Lqr(*_dualbody._lqr(discrete, a, b, q, r))
        if check and not found.is_stabilized:
            raise ValueError(f"{found.status} (check=False returns what was found)")
        return found

    def control(self, x: ArrayLike) -> Array:
        """Input -gain x, (..., nu), for deviations x (..., nx)."""
        return np.asarray(x, dtype=float) @ -self.gain.T

    @property
    def spectral_radius(self) -> float:
        """Largest modulus of the eigenvalues: below one, a discrete loop is stable."""
        return float(max(abs(self.closed_loop_eigenvalues), default=float("nan")))

    @property
    def spectral_abscissa(self) -> float:
        """Largest real part of the eigenvalues: below zero, a continuous loop is stable."""
        return float(max(self.closed_loop_eigenvalues.real, default=float("nan")))

    def __repr__(self) -> str:
        return f"Lqr(gain={self.gain.tolist()}, {self.status})"


@dataclass(frozen=True, eq=False)
class FiniteHorizonLqr(Value):
    """Finite-horizon regulator: gains (stages, nu, nx), costs_to_go (stages + 1, nx, nx)."""

    gains: Array
    costs_to_go: Array
    status: str
    is_solved: bool

    @staticmethod
    def discrete(a: ArrayLike, b: ArrayLike, q: ArrayLike, r: ArrayLike, final_cost: ArrayLike) -> FiniteHorizonLqr:
        """Of x⁺ = a[k] x + b[k] u at the cost Σ x' q[k] x + u' r[k] u + x' final_cost x: a matrix for each stage."""
        return FiniteHorizonLqr(*_dualbody._finite_horizon_lqr(a, b, q, r, final_cost))

    def control(self, stage: int, x: ArrayLike) -> Array:
        """Input (..., nu) at a stage for deviations x (..., nx)."""
        return np.asarray(x, dtype=float) @ -self.gains[stage].T


@dataclass(frozen=True, eq=False)
class Equilibrium(Value):
    """An equilibrium: a pose q (nq,), contact (the state of soft contact, otherwise empty), and the input u (nu,) that holds the robot at rest.

    >>> import dualbody as db
    >>> sim = db.Simulator(db.samples.cartpole(), actuated=["linear"])
    >>> rest = db.control.Equilibrium.find(sim, [0.0, 0.1])
    >>> bool(abs(rest.q[1]) < 1e-6)
    True
    """

    simulator: Simulator
    q: Array
    contact: Array
    u: Array
    #: Largest acceleration that is left, rad/s² or m/s²
    acceleration: float
    iterations: int
    status: str
    is_found: bool

    @staticmethod
    def find(simulator: Simulator, q: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None, check: bool = True) -> Equilibrium:
        """Finds an equilibrium near the pose q (nq,) and the input u (nu,; zero by default): pose, input and bristles of soft contact together.

        A floating robot with contacts is first moved to the ground; points within a centimetre of the ground then support it. Usually many poses are
        equilibria; the result is one near the guess. Raises a ValueError if none is found; with check=False `status` reports it."""
        found = Equilibrium(simulator, *simulator._equilibrium(q, u, contact))
        if check and not found.is_found:
            raise ValueError(f"no equilibrium: {found.status} (check=False returns what was found)")
        return found

    def lqr(self, q: ArrayLike, r: ArrayLike, *, check: bool = True) -> EquilibriumLqr:
        """Regulator at the cost Σ δx' q δx + δu' r δu, δx = (δq, δv): q (2 nv, 2 nv), r (nu, nu).

        Bristles of soft contact follow their points, and unreachable directions are dropped. Raises a ValueError if the reachable part cannot be
        stabilised or the dropped part is unstable; with check=False `status` reports it."""
        found = EquilibriumLqr(self, *self.simulator._equilibrium_lqr([self.q, self.contact, self.u], q, r))
        if check and not found.is_stabilized:
            worst = f"; dropped: {', '.join(found.dropped)}" if found.dropped else ""
            raise ValueError(f"{found.status}{worst} (check=False returns what was found)")
        return found


@dataclass(frozen=True, eq=False)
class EquilibriumLqr(Value):
    """Regulator u = u₀ - gain (q ⊖ q₀, v - v₀) about an Equilibrium, for the part of the state that is reachable from the inputs: gain (nu, 2 nv)."""

    at: Equilibrium
    gain: Array
    closed_loop_eigenvalues: NDArray[np.complex128]
    status: str
    is_stabilized: bool
    #: Numbers of the points of contact whose bristles follow them
    bristles: list[int]
    #: Directions (2 nv, n) of (δq, δv) that no input reaches, the name of the largest part of each, and the eigenvalues among them
    dropped_directions: Array
    dropped: list[str]
    dropped_eigenvalues: NDArray[np.complex128]

    def control(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Input (..., nu) in states (..., nq), (..., nv)."""
        dq = self.at.simulator.model.difference(self.at.q, q)
        return self.at.u - np.concatenate([dq, np.asarray(v, float)], axis=-1) @ self.gain.T

    @property
    def spectral_radius(self) -> float:
        """Largest modulus of the eigenvalues of the regulated part: below one, it is stable."""
        return float(max(abs(self.closed_loop_eigenvalues), default=float("nan")))


class ComputedTorque:
    """Inverse dynamics as a controller: the errors of all joints satisfy  ë + velocity_gain ė + position_gain e = 0."""

    def __init__(self, model: Model, position_gain: ArrayLike, velocity_gain: ArrayLike) -> None:
        """The gains are numbers, or vectors (nv,)."""
        self.model = model
        self.position_gain = np.ascontiguousarray(np.broadcast_to(np.asarray(position_gain, float), (model.nv,)))
        self.velocity_gain = np.ascontiguousarray(np.broadcast_to(np.asarray(velocity_gain, float), (model.nv,)))

    def torque(self, q: ArrayLike, v: ArrayLike, target_q: ArrayLike, target_v: ArrayLike | None = None) -> Array:
        """Joint forces (..., nv) in the state (q, v) for the target (target_q, target_v), at rest by default."""
        target_v = np.zeros(self.model.nv) if target_v is None else target_v
        gains = (self.position_gain, self.velocity_gain)
        return _dualbody._computed_torque(self.model, gains, q, v, target_q, target_v)
