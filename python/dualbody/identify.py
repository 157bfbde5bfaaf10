"""System identification: parameters of a robot from logged motion.

>>> import numpy as np, dualbody as db
>>> from dualbody import identify
>>> model = db.samples.pendulum()                              # 1 kg, 1 m
>>> t = 0.05 * np.arange(200.0)[:, None]
>>> q, v, a = np.sin(t), np.cos(t), -np.sin(t)
>>> segment = identify.Segment("swing", 0.0, 20.0, q, v, a, db.inverse_dynamics(model, q, v, a))
>>> found = identify.estimate(identify.Regressor(model), identify.Dataset([segment]))
>>> np.sort(np.abs(found.values)).round(9)[1:].tolist()        # moment about the pivot, kg·m², and first moment, kg·m; across it is none
[0.333333333, 0.5]

| question | answer |
|---|---|
| logged channels | `Experiment`, or `Experiment.from_rollout` |
| filtered motion and its derivatives, without delay | `Preparation` |
| forces as a linear function of unknowns | `Regressor` |
| identifiable combinations of unknowns | `Regressor.base_parameters` |
| their values and uncertainty | `estimate`, `Estimate.intervals` |
| a physically consistent robot, for simulation | `Estimate.consistent` |
| the most informative motion | `excite` |
| prediction of other motions | `Robot.validate` |
| parameters in which forces are not linear, and friction on the ground | `shoot` |
| a report as text and as an HTML page | `Estimate.report` |

Arrays of samples have a row for each sample. [Atkeson, An, Hollerbach 1986]
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from . import _dualbody
from ._convert import given
from .view import Page
from ._value import Value

if TYPE_CHECKING:
    from os import PathLike

    from numpy.typing import ArrayLike

    from ._dualbody import Array, Model, Simulator
    from ._rollout import Rollout

__all__ = [
    "BaseParameters", "Channel", "ConsistentEstimate", "Dataset", "Estimate", "Excitation", "Experiment", "ForceError", "Friction", "Inertia",
    "Interval", "LeftOut", "LinkMass", "Parameter", "Preparation", "Regressor", "Report", "Robot", "Segment", "ShootingEstimate", "Validation",
    "estimate", "excite", "shoot",
]

UnitName = Literal["si", "degree", "turn", "turn_per_minute", "millimetre"]
QuantityName = Literal["position", "velocity", "acceleration", "force"]
#: ("smooth", slip velocity) or ("sign", dead zone), rad/s or m/s
DryFriction = tuple[Literal["smooth", "sign"], float]


@dataclass(frozen=True, eq=False)
class Channel(Value):
    """Samples of one quantity of one joint: (samples,), or (samples, n) for joints with several coordinates; NaN for a missing sample. unit: a name, or
    the SI value of one unit of the channel."""

    joint: str
    quantity: QuantityName
    values: Array
    unit: UnitName | float = "si"

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", np.asarray(self.values, np.float64))


@dataclass(frozen=True, eq=False)
class Experiment(Value):
    """A logged motion: channels on a common clock, with a rate (samples per second) or times (samples,), s; `passive` joints have no force."""

    name: str
    channels: Sequence[Channel]
    rate: float = 0.0
    times: ArrayLike | None = None
    passive: Sequence[str] = ()

    @staticmethod
    def from_rollout(name: str, simulator: Simulator, rollout: Rollout) -> Experiment:
        """An experiment of one trajectory: positions, velocities and joint inputs.

        Inputs on frames, contact and external forces are not included. The last state, which has no input, is omitted.
        """
        model, samples = simulator.model, rollout.u.shape[0]
        if rollout.q.ndim != 2:
            raise ValueError("rollout is a batch, expected one trajectory")
        tau = np.zeros((samples, model.nv))
        for j, k in enumerate(simulator.actuated):
            tau[:, k] += rollout.u[:, j]
        channels = []
        for joint in _joints(model):
            q, v = joint[1:]
            channels += [
                Channel(joint[0], "position", rollout.q[:samples, q]),
                Channel(joint[0], "velocity", rollout.v[:samples, v]),
                Channel(joint[0], "force", tau[:, v]),
            ]
        return Experiment(name, channels, 1.0 / rollout.time_step)


def _joints(model: Model) -> list[tuple[str, slice, slice]]:
    """Joints with coordinates: name, place in q and in v."""
    # A floating base has seven numbers in q and six in v, which come first.
    base = [("floating base", slice(0, 7), slice(0, 6))] if model.has_floating_base else []
    own = [(name, model.joint_q(name), model.joint_v(name)) for name in model.joint_names]
    return base + [(name, q, v) for name, q, v in own if v.stop > v.start]


@dataclass(frozen=True)
class Preparation:
    """Filters experiments: a polynomial of a given degree about each sample, fitted to `half_width` samples on either side, smooths and differentiates.
    [Savitzky, Golay 1964]

    low_pass: (order, cutoff in Hz) of a Butterworth filter that is applied first to all channels, forwards and backwards. decimation: keeps one sample in
    this number.
    """

    half_width: int
    degree: int
    low_pass: tuple[int, float] | None = None
    decimation: int = 1

    def prepare(self, model: Model, experiments: Sequence[Experiment]) -> Dataset:
        """Data of experiments for a robot. Raises a ValueError or KeyError that names the experiment and the invalid channel."""
        segments, left_out = _dualbody._prepare(model, self, list(experiments))
        return Dataset([Segment(*own) for own in segments], [LeftOut(*own) for own in left_out])


@dataclass(frozen=True, eq=False)
class Segment(Value):
    """A segment of motion without gaps: q (samples, nq), v and a (samples, nv), joint forces tau (samples, nv; N·m or N); start in s, rate in samples per
    second."""

    experiment: str
    start: float
    rate: float
    q: Array
    v: Array
    a: Array
    tau: Array

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        return f"Segment({self.experiment!r}, {len(self)} samples at {self.rate:g} a second from {self.start:g} s)"


class LeftOut(NamedTuple):
    """A segment that was too short for the filters."""

    experiment: str
    start: float
    samples: int


@dataclass(frozen=True, eq=False)
class Dataset(Value):
    """Prepared data."""

    segments: Sequence[Segment]
    left_out: Sequence[LeftOut] = ()

    @property
    def n_samples(self) -> int:
        """Number of samples."""
        return sum(len(segment) for segment in self.segments)

    def hold_back(self, share: float) -> tuple[Dataset, Dataset]:
        """Training data, and the last share of each segment for validation."""
        kept, held = ([Segment(*own) for own in part] for part in _dualbody._hold_back(self, share))
        return Dataset(kept), Dataset(held)


class BaseParameters(NamedTuple):
    """The identifiable combinations of unknowns: unknown[independent] + combination @ unknown[dependent], with their meanings; the unknowns
    `without_effect` do not change any force."""

    independent: list[int]
    dependent: list[int]
    combination: Array
    without_effect: list[int]
    meanings: list[str]


@dataclass(frozen=True)
class Regressor:
    """Joint forces as a linear function of unknowns: tau = Y(q, v, a) x + known(q, v, a).

    Unknowns are the inertial parameters of all bodies except those of `known_links`, and optionally viscous damping, rotor inertia, dry friction
    ("smooth", slip velocity) or ("sign", dead zone), and constant offsets of the measured forces.
    """

    model: Model
    known_links: Sequence[str] = ()
    damping: bool = False
    armature: bool = False
    dry_friction: DryFriction | None = None
    offsets: bool = False

    @property
    def names(self) -> list[str]:
        """Names of the unknowns."""
        return _dualbody._regressor(self)[0]

    @property
    def nominal(self) -> Array:
        """Values of the unknowns in the model, (n,); dry friction and offsets are zero."""
        return _dualbody._regressor(self)[1]

    def matrix(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Y, (..., nv, n). q (..., nq), v and a (..., nv)."""
        return _dualbody._regressor_matrix(self, q, v, a)

    def base_parameters(self) -> BaseParameters:
        """The identifiable combinations of unknowns."""
        return BaseParameters(*_dualbody._base_parameters(self))


class Interval(NamedTuple):
    """An estimate with its confidence interval."""

    name: str
    value: float
    deviation: float
    lower: float
    upper: float


class ForceError(NamedTuple):
    """Error of the predicted force along a velocity coordinate, N·m or N: measured minus predicted; `measured` is the root mean square of the force itself."""

    rms: float
    mean: float
    largest: float
    measured: float


class Validation(NamedTuple):
    """Errors along each velocity coordinate, and the predicted forces (samples, nv) of each segment."""

    coordinates: list[ForceError]
    predicted: list[Array]


@dataclass(frozen=True, eq=False)
class Robot(Value):
    """An identified robot: its model, the force of dry friction along each coordinate (nv,; N·m or N) and constant errors of the measured forces
    (nv,)."""

    model: Model
    dry_friction: Array
    offsets: Array
    shape: DryFriction | None = None

    def predict(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Joint forces (..., nv) of a motion, with springs, damping, dry friction and offsets."""
        return _dualbody._predict(self, q, v, a)

    def validate(self, data: Dataset) -> Validation:
        """Compares predicted with measured forces of data. Use other data than for the identification."""
        errors, predicted = _dualbody._validate(self, data)
        return Validation([ForceError(*own) for own in errors], predicted)


def _robot(regressor: Regressor, numbers: Sequence[Array]) -> Robot:
    parameters, dry_friction, offsets = numbers
    return Robot(regressor.model.with_parameters(parameters), dry_friction, offsets, regressor.dry_friction)


class ConsistentEstimate(NamedTuple):
    """The physically consistent robot nearest to the estimate: all unknowns (n,), the robot, the increase of the weighted squares over the unconstrained
    estimate, the upper bound of the distance of the cost from its minimum, and iterations."""

    unknowns: Array
    robot: Robot
    excess: float
    gap: float
    iterations: int


@dataclass(frozen=True)
class Report:
    """Report of an identification; notebooks show it as an HTML page."""

    text: str
    html: str = field(repr=False)

    def save_html(self, path: str | PathLike[str]) -> None:
        """Writes the page to a file."""
        Path(path).write_text(self.html, encoding="utf-8")

    def __str__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        return Page(self.html)._repr_html_()


@dataclass(frozen=True, eq=False, repr=False)
class Estimate:
    """Base parameters by weighted least squares: values (n,), covariance (n, n) and its inverse, the information, standard deviations of the
    forces (nv,), number of equations of each coordinate, condition of the weighted regressor, degrees of freedom, and all unknowns. Pickles."""

    regressor: Regressor
    values: Array
    covariance: Array
    information: Array
    force_deviations: list[float]
    equations: list[int]
    condition: float
    freedom: int
    unknowns: Array

    def intervals(self, level: float = 0.95) -> list[Interval]:
        """Confidence intervals of the base parameters, by Student's t."""
        return [Interval(*own) for own in _dualbody._intervals(self, level)]

    def robot(self) -> Robot:
        """The robot with these values. Use it to predict forces; for simulation it may be physically inconsistent."""
        return _robot(self.regressor, _dualbody._identified(self))

    def consistent(self, regularization: float | None = None, gap: float | None = None) -> ConsistentEstimate:
        """The nearest physically consistent robot, with nonnegative friction.

        regularization: weight of the distance from the nominal robot; gap: maximum difference of the cost from its minimum.
        """
        unknowns, robot, excess, above, iterations = _dualbody._consistent(self, regularization, gap)
        return ConsistentEstimate(unknowns, _robot(self.regressor, robot), excess, above, iterations)

    def report(self, robot: Robot, validation: Dataset, level: float = 0.95) -> Report:
        """The report of this estimate, with the errors of a robot on validation data."""
        return Report(*_dualbody._report(self, robot, validation, level))

    def __repr__(self) -> str:
        equations = sum(self.equations)
        return f"Estimate({len(self.values)} base parameters from {equations} equations, condition {self.condition:.1f})"


def estimate(regressor: Regressor, data: Dataset) -> Estimate:
    """Estimates the base parameters of a robot from data, by weighted least squares.

    Raises ValueError if data belong to another robot, or if the motion does not determine some unknowns; the error names them.
    """
    return Estimate(regressor, *_dualbody._estimate(regressor, data))


@dataclass(frozen=True, eq=False)
class Excitation(Value):
    """A periodic motion: q_i(t) = c_i + sum over k of a_ik sin(k w t) + b_ik cos(k w t); period in s, center (n,), coefficients (n, 2 · harmonics)
    as a_i1, b_i1, a_i2, ...; condition of the regressor over a period, and that of the random start."""

    period: float
    center: Array
    coefficients: Array
    condition: float
    start_condition: float

    def at(self, times: ArrayLike) -> tuple[Array, Array, Array]:
        """Configurations, velocities and accelerations at times (n,), s: (n, nq) each."""
        q, v, a = _dualbody._excited(self, times)
        return q, v, a


def excite(
    regressor: Regressor, *, period: float | None = None, harmonics: int | None = None, range: float | None = None, reach: float | None = None,
    speed: float | None = None, acceleration: float | None = None, force_deviations: Sequence[float] | None = None,
    max_iterations: int | None = None, starts: int | None = None, seed: int | None = None
) -> Excitation:
    """Finds the most informative periodic motion within joint limits. [Swevers et al. 1997]

    period (s), harmonics, range (share of the position limits), reach, speed, acceleration (for joints without a limit), force_deviations (nv,),
    max_iterations, starts, seed; None means the default.
    """
    return Excitation(*_dualbody._excite(regressor, given(locals(), "regressor")))


@dataclass(frozen=True)
class Inertia:
    """`shoot` adjusts the ten inertial parameters of the body of a link."""

    link: str


@dataclass(frozen=True)
class LinkMass:
    """`shoot` adjusts the mass of the body of a link, kg, and its first moment and moments of inertia in proportion."""

    link: str


@dataclass(frozen=True)
class Parameter:
    """`shoot` adjusts a parameter by name, as in `Simulator.parameter_names`: "elbow: damping".

    All other parameters are fixed: with "pole: mass", first moment and inertia are fixed, so centre of mass and shape of the body change. `LinkMass`
    scales all of them, `Inertia` adjusts all ten.
    """

    name: str


@dataclass(frozen=True)
class Friction:
    """`shoot` adjusts one coefficient of friction for these contact points, by their index in `Simulator.contact_points`."""

    points: Sequence[int]


class ShootingEstimate(NamedTuple):
    """Result of `shoot`: values (n,), their intervals (None if some parameter changes no state), standard deviation of the residuals, status of the
    solver, and the robot with these values."""

    values: Array
    intervals: list[Interval] | None
    deviation: float
    status: str
    is_converged: bool
    iterations: int
    model: Model


def shoot(
    simulator: Simulator, data: Dataset, adjustable: Sequence[Inertia | LinkMass | Parameter | Friction], level: float = 0.95, *,
    samples: int | None = None, starts: Literal["measured", "free"] | None = None, position_deviation: float | None = None,
    velocity_deviation: float | None = None, regularization: float | None = None, max_iterations: int | None = None
) -> ShootingEstimate:
    """Adjusts parameters of a simulator until its motion agrees with the data, by the Levenberg–Marquardt method. [Bock 1987]

    samples of a shot, starts ("measured" or "free"), position_deviation, velocity_deviation, regularization, max_iterations; None stands for the
    default.
    """
    options = given(locals(), "simulator", "data", "adjustable", "level")
    if any(isinstance(own, Parameter) and own.name.endswith(": mass") for own in adjustable):
        text = "a parameter \": mass\" holds the moments of its body: LinkMass scales them with the mass, Inertia finds all ten numbers"
        warnings.warn(text, stacklevel=2)
    found = _dualbody._shoot(simulator, data, list(adjustable), level, options)
    values, intervals, deviation, status, is_converged, iterations, parameters = found
    all_intervals = None if intervals is None else [Interval(*own) for own in intervals]
    model = simulator.model.with_parameters(parameters)
    return ShootingEstimate(values, all_intervals, deviation, status, is_converged, iterations, model)
