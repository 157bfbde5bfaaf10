"""Actuators, constraints, external forces and sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ._value import Value

if TYPE_CHECKING:
    from typing import Literal

    from numpy.typing import ArrayLike

    from ._dualbody import Array, Model, RepresentationName
    from .contact import HuntCrossley


@dataclass(frozen=True)
class Actuator:
    """A motor. torque_speed: (torque, threshold, maximum): full torque up to the threshold speed, none from the maximum; effort: limit,
    N·m or N; friction: a force that holds the joint at rest, or (Coulomb force, slip velocity), smoothed through rest; position: (lower, upper,
    HuntCrossley) joint limits; velocity: (speed, damping) of a speed limit; servo: (gear n, gain g, bias b, position gain k, velocity gain d) with the
    input u as target: the force n (g u + b - k n q - d n v) of the end of a step; input_range, force_range: (least, largest) u and force before the gear
    of the servo."""

    torque_speed: tuple[float, float, float] | None = None
    effort: float | None = None
    friction: float | tuple[float, float] | None = None
    position: tuple[float | None, float | None, HuntCrossley | Sequence[float]] | None = None
    velocity: tuple[float, float] | None = None
    servo: tuple[float, float, float, float, float] | None = None
    input_range: tuple[float, float] | None = None
    force_range: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.servo is None and not (self.input_range is None and self.force_range is None):
            raise ValueError("input_range and force_range are those of a servo, and there is none: servo=(1, 1, 0, 0, 0) is a motor")
        if self.position is not None:
            lower, upper, stop = self.position
            if isinstance(stop, Sequence):
                from .contact import HuntCrossley

                object.__setattr__(self, "position", (lower, upper, HuntCrossley(*stop)))


@dataclass(frozen=True)
class Actuation:
    """Motors of all joints: "ideal", or those of the description ("model"); named joints override them.

    Without an actuation, limits of position, speed and effort and dry friction of the description do not act. `Simulator(actuation="model")` is short for
    Actuation("model").
    """

    base: Literal["ideal", "model"] = "ideal"
    actuators: Mapping[str, Actuator] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Anchor(Value):
    """An attachment frame: a pose (4, 4), or a translation (3,), m, relative to a frame or link, or to the world (None). It is relative to the link frame,
    not to the centre of mass."""

    frame: str | None = None
    placement: ArrayLike = (0.0, 0.0, 0.0)

    def pose_in_world(self, model: Model, q: ArrayLike) -> Array:
        """Its pose in the world, (4, 4)."""
        from . import frame_pose

        placement = np.asarray(self.placement, dtype=float)
        if placement.shape == (3,):
            placement = np.block([[np.eye(3), placement[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])
        return placement if self.frame is None else frame_pose(model, q, self.frame) @ placement

    def brought_to(self, other: Anchor, model: Model, q: ArrayLike) -> Anchor:
        """Returns an attachment frame on this frame with the pose of the other one at the configuration q."""
        here = Anchor(self.frame).pose_in_world(model, q)
        return Anchor(self.frame, np.linalg.solve(here, other.pose_in_world(model, q)))


@dataclass(frozen=True)
class Regularisation:
    """Makes the rows φ of a constraint yield as the equalities of MuJoCo: φ̈ + b φ̇ + k d φ + R f = 0 with the impedance d and R = (1 - d) / d · w.

    b and k follow from time constant (s) and damping ratio, or from stiffness and damping (`direct`), as in RelaxedRigid; impedance: least, largest, width, midpoint,
    power over the size of the error. w is inverse_mass (1/kg for rows in m), for angles of a weld inverse_inertia, 1/(kg m²). lever (m): length by which an angle
    counts in the size of the error.
    """

    time_constant: float = 0.02
    damping_ratio: float = 1.0
    #: (stiffness, damping) of the reference acceleration instead
    direct: tuple[float, float] | None = None
    impedance: tuple[float, float, float, float, float] = (0.9, 0.95, 1e-3, 0.5, 2.0)
    inverse_mass: float = 1.0
    inverse_inertia: float = 1.0
    lever: float = 0.5


@dataclass(frozen=True)
class Weld:
    """Two attachment frames coincide in position and orientation.

    time_constant: of the error decay, s. spring: (stiffness, damping) of each row, N/m and N·s/m (N·m/rad and N·m·s/rad for angles), instead of a rigid
    constraint. largest_force: bound of the force of each row, N or N·m, at which it yields. regularisation: makes it yield as in MuJoCo, instead of a spring. All
    constraints have these options.
    """

    a: Anchor
    b: Anchor
    time_constant: float | None = None
    spring: tuple[float, float] | None = None
    largest_force: float | None = None
    regularisation: Regularisation | None = None


@dataclass(frozen=True)
class Ball:
    """The origins of two attachment frames coincide."""

    a: Anchor
    b: Anchor
    time_constant: float | None = None
    spring: tuple[float, float] | None = None
    largest_force: float | None = None
    regularisation: Regularisation | None = None


@dataclass(frozen=True)
class Distance:
    """The origins of two attachment frames have a constant distance, length (m)."""

    a: Anchor
    b: Anchor
    length: float
    time_constant: float | None = None
    spring: tuple[float, float] | None = None
    largest_force: float | None = None
    regularisation: Regularisation | None = None


@dataclass(frozen=True)
class Coupler:
    """Couples two joints: q₁ = ratio · q₂ + offset, or by a polynomial.

    higher: coefficients of q₂², q₂³ and q₂⁴, as many as there are."""

    joints: tuple[str, str]
    ratio: float
    offset: float = 0.0
    time_constant: float | None = None
    spring: tuple[float, float] | None = None
    largest_force: float | None = None
    regularisation: Regularisation | None = None
    higher: Sequence[float] = ()


@dataclass(frozen=True)
class Tendon:
    """A fixed tendon: the sum of coefficient times position of joints of one degree of freedom equals a length.

    joints: coefficient of each joint by name, for example the radius of its pulley, m.
    """

    joints: Mapping[str, float]
    length: float = 0.0
    time_constant: float | None = None
    spring: tuple[float, float] | None = None
    largest_force: float | None = None
    regularisation: Regularisation | None = None


@dataclass(frozen=True)
class ExternalForce:
    """A constant force and torque (6,) at an attachment frame: [linear; angular], N and N·m, in a representation: "mixed" in world axes, "body" in the
    axes of the attachment frame, which rotate with it."""

    place: Anchor
    force: Sequence[float]
    representation: RepresentationName = "mixed"


@dataclass(frozen=True)
class TendonServo:
    """A servo along a tendon, with its own input: joints: {name: coefficient c} of its length, the sum of c q; servo, input_range and force_range as of an
    Actuator, along the tendon; effort: limit, N·m or N. With one joint it is an additional servo of that joint."""

    name: str
    joints: Mapping[str, float]
    servo: tuple[float, float, float, float, float]
    effort: float | None = None
    input_range: tuple[float, float] | None = None
    force_range: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class ActuatorNetwork(Value):
    """A learned actuator: a multilayer perceptron from (errors u - q, then velocities v) at some ages, in steps, 0 is now, to a force, N·m or N. layers: pairs of
    weights (rows, columns) and offsets (rows,), with the softsign y / (1 + |y|) after each but the last, which has one row."""

    layers: Sequence[tuple[ArrayLike, ArrayLike]]
    ages: Sequence[int] = (0,)


@dataclass(frozen=True)
class Activation:
    """Delay (whole steps) and dynamics between an input and its motor or servo, with a state of its own: the last numbers of `contact`.

    dynamics: "none", a delay alone; "filter", a first-order lag of time_constant (s), exact over each step; "explicit_filter", the same by Euler's explicit
    method; "integrator" of the input; or an ActuatorNetwork. input_range: (least, largest) input of the dynamics; range: that of the state of a filter or
    integrator; early: the motor gets the state after the step, not the one before.
    """

    dynamics: Literal["none", "filter", "explicit_filter", "integrator"] | ActuatorNetwork = "none"
    time_constant: float | None = None
    delay: int = 0
    input_range: tuple[float, float] | None = None
    range: tuple[float, float] | None = None
    early: bool = False


@dataclass(frozen=True)
class FrameActuator:
    """An actuator at an attachment frame: a wrench (6,) per unit of its input, with optional limits (lower, upper) of the input.

    servo: (gear n, gain g, bias b, position gain k, velocity gain d) of a servo along the wrench w, with the input as its target: the force is w times that of
    the servo at the end of a step, see `Actuator`. In "mixed" representation its position is w · (p, θ), with the position p of the frame in the world and
    its rotation vector θ; in the others, whose axes move, there is a velocity only. input_range, force_range: (least, largest) input and force of the servo.
    """

    name: str
    place: Anchor
    wrench: Sequence[float]
    representation: RepresentationName = "body"
    limits: tuple[float, float] | None = None
    servo: tuple[float, float, float, float, float] | None = None
    input_range: tuple[float, float] | None = None
    force_range: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.servo is None and not (self.input_range is None and self.force_range is None):
            raise ValueError("input_range and force_range are those of a servo, and there is none: `limits` bounds an input that scales the wrench")

    @staticmethod
    def thruster(
        name: str, place: Anchor, direction: Sequence[float], torque_ratio: float = 0.0, limits: tuple[float, float] | None = None
    ) -> FrameActuator:
        """A force along a direction in the axes of the attachment frame, with a torque about it: torque_ratio · force, m."""
        length = sum(x * x for x in direction) ** 0.5
        if not 0.0 < length < float("inf"):
            raise ValueError(f"direction {tuple(direction)} of {name!r} has no length")
        along = [x / length for x in direction]
        wrench = (*along, *(torque_ratio * x for x in along))
        return FrameActuator(name, place, wrench, "body", limits)


@dataclass(frozen=True)
class Sensor:
    """A sensor of a robot, on the joint, link or frame named `on`. Axes and origin are those of the link or frame.

    kind: "joint_position" (rad, m), "joint_velocity", "joint_force" (the force that the joint transmits along its axes, N·m, N); on a link or frame "gyro" (3),
    "accelerometer" (3), "magnetometer" (3) of a `field` in the world, "frame_pose" (7: position, quaternion w, x, y, z), "frame_velocity" (6),
    "frame_acceleration" (6) in a `representation`, "range_finder" along a `direction`, up to a `range`, m, "lidar" along several directions: `horizontal`
    about z from x, and for each of these `vertical` above the xy-plane, each as number of rays, first and last angle (rad), vertical ones outermost; on a
    link "wrench" (6: the force and torque that hold the link, on it), "touch" (sum of normal forces, N), "contact_force" (6); on nothing "center_of_mass" (3), "center_of_mass_velocity" (3) and
    "momentum" (6), in the world.
    """

    kind: Literal[
        "joint_position", "joint_velocity", "joint_force", "gyro", "accelerometer", "magnetometer", "frame_pose", "frame_velocity",
        "frame_acceleration", "wrench", "touch", "contact_force", "range_finder", "lidar", "center_of_mass", "center_of_mass_velocity", "momentum",
    ]
    on: str | None = None
    field: Sequence[float] = (0.0, 0.0, 0.0)
    direction: Sequence[float] = (0.0, 0.0, 1.0)
    range: float = 10.0
    representation: RepresentationName = "body"
    horizontal: tuple[int, float, float] = (1, 0.0, 0.0)
    vertical: tuple[int, float, float] = (1, 0.0, 0.0)


@dataclass(frozen=True)
class SensorNoise:
    """Imperfections of a sensor. A sample is taken every `period` (s; 0: in each step): reading plus offset plus bias plus noise, rounded to the `resolution` and
    clamped to ± the `limit`; it appears after the `delay`, s. white: standard deviation of the noise of each sample; bias: of the initial bias; bias_walk:
    of its change over one second. Units are those of the reading."""

    white: float = 0.0
    bias: float = 0.0
    bias_walk: float = 0.0
    resolution: float = 0.0
    limit: float = float("inf")
    period: float = 0.0
    delay: float = 0.0
    offset: float = 0.0
