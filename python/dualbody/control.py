"""Control: linear-quadratic regulators, computed torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from . import _dualbody

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._dualbody import Array, Model

__all__ = ["ComputedTorque", "FiniteHorizonLqr", "Lqr"]


@dataclass(frozen=True)
class Lqr:
    """Regulator u = -gain x of least cost: gain (nu, nx), cost_to_go (nx, nx), eigenvalues of the closed loop, the least stable first."""

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
        gain, cost, pairs, residual, iterations, status, stabilized = _dualbody._lqr(discrete, a, b, q, r)
        if check and not stabilized:
            raise ValueError(f"{status} (check=False returns what was found)")
        return Lqr(gain, cost, pairs[:, 0] + 1j * pairs[:, 1], residual, iterations, status, stabilized)

    def control(self, x: ArrayLike) -> Array:
        """Input -gain x, (..., nu), for deviations x (..., nx)."""
        import numpy as np

        u: Array = np.asarray(x, dtype=float) @ -self.gain.T
        return u

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


@dataclass(frozen=True)
class FiniteHorizonLqr:
    """Regulator over stages: gains (stages, nu, nx), costs_to_go (stages + 1, nx, nx)."""

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
        import numpy as np

        u: Array = np.asarray(x, dtype=float) @ -self.gains[stage].T
        return u


class ComputedTorque:
    """Inverse dynamics as a controller: the errors of all joints obey  ë + velocity_gain ė + position_gain e = 0."""

    def __init__(self, model: Model, position_gain: ArrayLike, velocity_gain: ArrayLike) -> None:
        """The gains are numbers, or vectors (nv,)."""
        import numpy as np

        self.model = model
        self.position_gain = np.ascontiguousarray(np.broadcast_to(np.asarray(position_gain, float), (model.nv,)))
        self.velocity_gain = np.ascontiguousarray(np.broadcast_to(np.asarray(velocity_gain, float), (model.nv,)))

    def torque(self, q: ArrayLike, v: ArrayLike, target_q: ArrayLike, target_v: ArrayLike | None = None) -> Array:
        """Joint forces (..., nv) in the state (q, v) for the target (target_q, target_v), at rest if the velocity is left out."""
        import numpy as np

        target_v = np.zeros(self.model.nv) if target_v is None else target_v
        gains = (self.position_gain, self.velocity_gain)
        return _dualbody._computed_torque(self.model, gains, q, v, target_q, target_v)
