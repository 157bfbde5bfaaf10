"""Nonlinear least squares: min ½ Σ ρ(r(x)²) within bounds, by the Levenberg–Marquardt method, for Python functions.

>>> import numpy as np
>>> from dualbody import least_squares
>>> valley = lambda x: [10 * (x[1] - x[0] ** 2), 1 - x[0]]
>>> slopes = lambda x: [[-20 * x[0], 10], [-1, 0]]
>>> found = least_squares.solve(valley, slopes, [-1.2, 1.0])
>>> found.is_converged, np.round(found.x, 9)
(True, array([1., 1.]))
>>> np.round(least_squares.solve(valley, slopes, [-1.2, 1.0], bounds=(None, [0.5, 2.0])).x, 9)
array([0.5 , 0.25])

A step d solves min ½ |J d + r|² + ½ λ |D d|² within the bounds, with D the largest norms of the columns of J so far, so the units of the variables do not
matter. A call of a Python function costs microseconds; the fits of `dualbody.identify` call none.
[Levenberg 1944; Marquardt 1963; Moré 1978]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from . import _dualbody
from ._convert import given
from ._value import Value

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._dualbody import Array, Report

__all__ = ["Loss", "Solution", "solve"]


@dataclass(frozen=True)
class Loss:
    """Loss ρ(s) of the square s = r² of a residual: `square`, `huber`, `soft_l1` or `cauchy`.

    delta: the residual above which the loss grows more slowly, positive, in the unit of the residual. [Huber 1964; Triggs et al. 2000]
    """

    kind: Literal["square", "huber", "soft_l1", "cauchy"] = "square"
    delta: float = 1.0

    @staticmethod
    def square() -> Loss:
        """ρ = s."""
        return Loss()

    @staticmethod
    def huber(delta: float) -> Loss:
        """The square up to delta, then linear. Convex."""
        return Loss("huber", delta)

    @staticmethod
    def soft_l1(delta: float) -> Loss:
        """ρ = 2 δ² (√(1 + s/δ²) - 1), a smooth form of `huber`. Convex."""
        return Loss("soft_l1", delta)

    @staticmethod
    def cauchy(delta: float) -> Loss:
        """ρ = δ² ln(1 + s/δ²): outliers have almost no influence, and there may be several minima."""
        return Loss("cauchy", delta)

    def value(self, s: ArrayLike) -> Array:
        """ρ of squares s (n,)."""
        return _dualbody._loss((self.kind, self.delta), s)[0]

    def weight(self, s: ArrayLike) -> Array:
        """ρ' of squares s (n,): 1 for small residuals, less for large ones."""
        return _dualbody._loss((self.kind, self.delta), s)[1]


@dataclass(frozen=True, eq=False)
class Solution(Value):
    """The best point found, and the course of the run.

    x (n,); residuals (m,) there; cost ½ Σ ρ(r²); history: the cost of the start, then after each iteration; held: directions with an active bound;
    normal_matrix Jᵀ W J with the weights of the loss; variance of a residual and covariance of the variables to first order, None if there are not more
    residuals than free directions, or a direction has no effect. [Bard 1974, section 7.5]
    """

    x: Array
    residuals: Array
    cost: float
    status: str
    is_converged: bool
    iterations: int
    history: Array
    held: list[int]
    normal_matrix: Array
    variance: float | None
    covariance: Array | None

    def __repr__(self) -> str:
        return f"Solution({self.status}, x = {self.x}, cost {self.cost:.6g})"


def solve(
    residuals: Callable[[Array], ArrayLike], jacobian: Callable[[Array], ArrayLike], start: ArrayLike, *,
    bounds: tuple[ArrayLike | None, ArrayLike | None] = (None, None), loss: Loss | None = None,
    manifold: tuple[int, Callable[[Array, Array], ArrayLike]] | None = None, report: Report | None = None, max_iterations: int | None = None,
    gradient_tolerance: float | None = None, cost_tolerance: float | None = None, step_tolerance: float | None = None,
    offset_tolerance: float | None = None, damping: float | None = None
) -> Solution:
    """Minimises from a start (n,).

    residuals(x) returns (m,), jacobian(x) their derivatives (m, n); a point with values that are not finite is rejected. bounds: (lower, upper), (n,)
    each, infinite for no bound. manifold: (number of directions, retract(x, d) -> x moved by d) for variables on a manifold, such as quaternions; the
    Jacobian is then that in directions. report(iteration, cost, gradient, damping) is called after each iteration. max_iterations is 100 by default; None
    means the default of the other options.

    An exception of a function ends the run and is raised.
    """
    options = given(locals(), "residuals", "jacobian", "start", "bounds", "loss", "manifold", "report")
    own = loss or Loss()
    return Solution(*_dualbody._least_squares(residuals, jacobian, start, manifold, (own.kind, own.delta), (bounds[0], bounds[1]), report, options))
