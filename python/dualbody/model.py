"""Robots: `Model`, and `ModelBuilder` with its parts."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from . import _dualbody
from ._dualbody import ImportReport, Model
from ._value import Value

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Any, Literal

    from numpy.typing import ArrayLike

    from ._dualbody import Array

    Base = Literal["auto", "fixed", "floating"]
    JointKind = Literal[
        "fixed", "revolute", "continuous", "prismatic", "screw", "universal", "spherical", "planar", "floating"
    ]

__all__ = [
    "Box", "Capsule", "Cylinder", "Ellipsoid", "Hardware", "ImportReport", "JointSpec", "Limits", "LinkSpec", "Mesh", "Mimic", "Model",
    "ModelBuilder", "ScaledLink", "Sphere",
]

Vector3 = tuple[float, float, float]
#: A pose (4, 4) or a translation (3,); the identity if nothing is said.
ORIGIN: Any = (0.0, 0.0, 0.0)


class Limits(NamedTuple):
    """Limits of a joint; None for no limit. Positions in rad or m, velocity in rad/s or m/s, effort in N·m or N."""

    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    effort: float | None = None


class Mimic(NamedTuple):
    """Coupling of a mimic joint: q = multiplier · q_leader + offset."""

    leader: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Shape(Value):
    """A shape at a placement in its link, (4, 4) or (3,), m; color (red, green, blue, opacity)."""

    placement: ArrayLike = ORIGIN
    color: tuple[float, float, float, float] | None = None


@dataclass(frozen=True, eq=False)
class Box(Shape):
    """Box of edges size, m."""

    size: Vector3


@dataclass(frozen=True, eq=False)
class Ellipsoid(Shape):
    """Ellipsoid along the axes, of full lengths size, m."""

    size: Vector3


@dataclass(frozen=True, eq=False)
class Sphere(Shape):
    """Sphere, m."""

    radius: float


@dataclass(frozen=True, eq=False)
class Cylinder(Shape):
    """Cylinder along z, m."""

    radius: float
    length: float


@dataclass(frozen=True, eq=False)
class Capsule(Shape):
    """Cylinder along z with hemispheres at its ends; length without the hemispheres, m."""

    radius: float
    length: float


@dataclass(frozen=True, eq=False)
class Mesh(Shape):
    """Mesh from a file."""

    path: str
    scale: Vector3 = (1.0, 1.0, 1.0)


@dataclass(frozen=True, eq=False)
class LinkSpec(Value):
    """A link: mass (kg), centre of mass in its frame (m), inertia about it (kg·m², 3 × 3), visual and collision shapes, and whether gravity acts on it."""

    name: str
    mass: float = 0.0
    com: Vector3 = (0.0, 0.0, 0.0)
    inertia: tuple[Vector3, Vector3, Vector3] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    visuals: Sequence[Shape] = ()
    collisions: Sequence[Shape] = ()
    gravity: bool = True

    @staticmethod
    def solid_box(name: str, size: Vector3, mass: float) -> LinkSpec:
        """A solid box with visual and collision shape."""
        return LinkSpec._solid(name, mass, Box(size))

    @staticmethod
    def solid_sphere(name: str, radius: float, mass: float) -> LinkSpec:
        """A solid ball with visual and collision shape."""
        return LinkSpec._solid(name, mass, Sphere(radius))

    @staticmethod
    def solid_cylinder(name: str, radius: float, length: float, mass: float) -> LinkSpec:
        """A solid cylinder along z with visual and collision shape."""
        return LinkSpec._solid(name, mass, Cylinder(radius, length))

    @staticmethod
    def _solid(name: str, mass: float, shape: Shape) -> LinkSpec:
        return LinkSpec(name, mass, inertia=_dualbody._solid_inertia(shape, mass), visuals=(shape,), collisions=(shape,))


@dataclass(frozen=True, eq=False)
class JointSpec(Value):
    """A joint from a parent link to a child link, at a placement in the parent: (4, 4), or (3,) for a translation, m."""

    name: str
    kind: JointKind
    parent: str
    child: str
    placement: ArrayLike = ORIGIN
    axis: Vector3 = (1.0, 0.0, 0.0)
    limits: Limits = Limits()
    #: N·m·s/rad or N·s/m
    damping: float = 0.0
    #: Coulomb friction, N·m or N: what `Actuation("model")` takes
    friction: float = 0.0
    #: Inertia of the rotor, kg·m² or kg
    armature: float = 0.0
    #: Stiffness (N·m/rad or N/m) and position at rest
    spring: tuple[float, float] = (0.0, 0.0)
    mimic: Mimic | None = None
    #: Of a universal joint
    second_axis: Vector3 | None = None
    #: Of a screw joint: advance along the axis, m/rad
    pitch: float = 0.0


@dataclass
class ModelBuilder:
    """A robot as plain data: add links and joints, then build."""

    name: str
    gravity: Vector3 = (0.0, 0.0, -9.81)
    base: Base = "auto"
    independent_mimic_joints: bool = False
    links: list[LinkSpec] = field(default_factory=list)
    joints: list[JointSpec] = field(default_factory=list)
    frames: list[tuple[str, str, ArrayLike]] = field(default_factory=list)

    def add_link(self, link: LinkSpec) -> ModelBuilder:
        """Adds a link."""
        self.links.append(link)
        return self

    def add_joint(self, joint: JointSpec) -> ModelBuilder:
        """Adds a joint."""
        self.joints.append(joint)
        return self

    def add_frame(self, name: str, link: str, placement: ArrayLike = ORIGIN) -> ModelBuilder:
        """Adds a frame at a placement in a link."""
        self.frames.append((name, link, placement))
        return self

    def build(self) -> Model:
        """Builds the robot. Raises a ValueError that names the defect."""
        return _dualbody._build_model(self.name, self.gravity, self.base, self.independent_mimic_joints, self.links, self.joints, self.frames)


class ScaledLink(NamedTuple):
    """Design parameters of a link: of "x", "y", "z" (edges of a box, scales of a mesh), "radius", "length" and "density".

    masses: "described" (all particles move with the shape) or "homogeneous" (a solid with the mass of the description).
    """

    name: str
    dimensions: Sequence[Literal["x", "y", "z", "radius", "length", "density"]]
    masses: Literal["described", "homogeneous"] = "described"


@dataclass(frozen=True)
class Hardware:
    """A robot with sizes and densities of links as design parameters: of `links`, or of all links with a shape.

    Joints, frames, shapes and inertias move with the sizes. names and nominal (n,) are those of the parameters: m, kg/m³, and scales of meshes.
    """

    model: Model
    links: Sequence[ScaledLink] | None = None

    @property
    def names(self) -> list[str]:
        """Name of each parameter: link and quantity, as in "forearm: length"."""
        return _dualbody._hardware(self.model, self.links)[0]

    @property
    def nominal(self) -> Array:
        """Values of the parameters in the description, (n,)."""
        return _dualbody._hardware(self.model, self.links)[1]

    def scaled_model(self, x: ArrayLike) -> Model:
        """The robot with other values of the parameters, (n,), each positive."""
        return _dualbody._hardware_model(self.model, self.links, x)

    def parameter_jacobian(self, x: ArrayLike) -> Array:
        """Derivatives (parameters of the model, n) of all `Model.parameters` in the design parameters at x (n,).

        For a gradient g in the parameters of the model at x, the gradient in sizes and densities is J.T @ g.
        """
        return _dualbody._hardware_jacobian(self.model, self.links, x)
