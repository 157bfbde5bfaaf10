"""Contact: the ground, contact models, and distances of links."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from . import _dualbody
from ._value import Value

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from os import PathLike
    from typing import Any, Literal

    from numpy.typing import ArrayLike

    from ._dualbody import Array, Model

    Vector3 = tuple[float, float, float]
    Law = "SoftContact | RelaxedRigid | Rigid"

__all__ = [
    "Collisions", "Contacts", "HeightField", "HuntCrossley", "Material", "Nearest", "Plane", "RelaxedRigid", "Rigid", "Smoothing",
    "SoftContact", "SolverOptions", "Surface", "Terrain", "nearest", "pairs_of_srdf",
]


class Terrain:
    """The ground: from `flat`, `plane`, `incline`, or a `HeightField`."""

    @staticmethod
    def flat(height: float = 0.0) -> Plane:
        """A plane z = height, m."""
        return Plane((0.0, 0.0, height), (0.0, 0.0, 1.0))

    @staticmethod
    def plane(point: Vector3, normal: Vector3) -> Plane:
        """The plane through a point (m) with a normal that points upwards."""
        return Plane(point, normal)

    @staticmethod
    def function(height: Callable[[Array, Array], ArrayLike], x: tuple[float, float], y: tuple[float, float], spacing: float) -> HeightField:
        """The ground z = height(x, y), m: a function of NumPy arrays, sampled on a grid over the ranges x and y (m) at this spacing (m).

        Between the nodes the ground is a spline with two continuous derivatives. Errors of heights are of order spacing⁴ and those of slopes of order
        spacing³; near the border, where the spline is straight, spacing² and spacing. The function is called once, here; a MemoryError reports a grid that
        is too large. Each height is a parameter of the simulator: a gradient in all of them costs a pass over the grid for each step in contact. Beyond
        the ranges the ground is level at the height of the border.
        """
        if not spacing > 0.0:
            raise ValueError(f"spacing is {spacing}, expected a positive length")
        cells = [np.ceil((upper - lower) / spacing) for lower, upper in (x, y)]
        if not min(cells) >= 1:
            raise ValueError(f"the ranges x {x} and y {y} are empty")
        if not np.isfinite(cells).all():
            raise ValueError(f"the ranges x {x} and y {y} have no end at a spacing of {spacing}")
        counts = [int(cell) + 1 for cell in cells]
        _dualbody._check_grid(*counts)
        axes: list[Array] = [lower + spacing * np.arange(count, dtype=np.float64) for (lower, _), count in zip((x, y), counts, strict=True)]
        heights = np.broadcast_to(np.asarray(height(*np.meshgrid(*axes, indexing="ij")), float), tuple(counts))
        return HeightField((x[0], y[0]), (spacing, spacing), heights)

    @staticmethod
    def incline(angle: float) -> Plane:
        """A plane through the origin that rises along x at an angle (rad): objects on it slide towards -x."""
        import math

        return Plane((0.0, 0.0, 0.0), (-math.sin(angle), 0.0, math.cos(angle)))

    def surface(self, x: float, y: float) -> tuple[float, float, float]:
        """Height (m) and slopes ∂h/∂x, ∂h/∂y at (x, y)."""
        return _dualbody._terrain_surface(self, x, y)


@dataclass(frozen=True)
class Plane(Terrain):
    """A plane through a point (m) with a normal that points upwards."""

    point: Vector3
    normal: Vector3


@dataclass(frozen=True, eq=False)
class HeightField(Terrain, Value):
    """Heights (m) on a grid: heights[i][j] at origin + (i, j) · spacing; a smooth spline between the nodes."""

    origin: tuple[float, float]
    spacing: tuple[float, float]
    heights: ArrayLike

    @staticmethod
    def tiled(tiles: Sequence[HeightField], columns: int) -> tuple[HeightField, Array]:
        """Lays grids of one spacing and shape side by side on one: `columns` of them along x, then the next row along y. The first one keeps its place.

        Returns the grid, and the shifts (len(tiles), 2), m: a robot that starts at (x, y) of its own tile starts at (x, y) plus its shift. Neighbours have
        one cell between them, and the last row is filled up with copies of the last tile. All nodes keep their heights; about the border of a tile the
        spline bends on to the neighbour.

        >>> import dualbody as db
        >>> low, high = (db.contact.HeightField((-1, -1), (0.5, 0.5), [[h] * 5] * 5) for h in (0.1, 0.3))
        >>> ground, shifts = db.contact.HeightField.tiled([low, high], 2)
        >>> shifts.tolist(), round(ground.surface(2.5, 0.0)[0], 2)
        ([[0.0, 0.0], [2.5, 0.0]], 0.3)
        """
        heights, shifts = _dualbody._tiled(list(tiles), columns)
        return HeightField(tiles[0].origin, tiles[0].spacing, heights), shifts


@dataclass(frozen=True)
class HuntCrossley:
    """Force over a depth d and its rate:  stiffness · d^(1 + p) + damping · d^q · rate, p and q the exponents; linear by default."""

    stiffness: float
    damping: float
    stiffness_exponent: float = 0.0
    damping_exponent: float = 0.0


@dataclass(frozen=True)
class SoftContact:
    """Compliant contact: a Hunt–Crossley normal force (see `HuntCrossley`), friction by bristles, which have a state: `contact` of steps and rollouts. It
    is stiff: use steps of 0.1 ms to 1 ms, or integrator="implicit_velocity".

    With a damping exponent of 1 + the stiffness exponent, as by default, derivatives through an impact are correct if it lasts fifty steps."""

    friction: float
    stiffness: float
    damping: float
    stiffness_exponent: float = 1.5
    damping_exponent: float = 2.5

    @staticmethod
    def estimate(mass: float, points: int, depth: float) -> SoftContact:
        """Parameters with which a mass (kg) on a number of points penetrates by a depth (m)."""
        friction, normal = _dualbody._estimate_soft_contact(mass, points, depth)
        return SoftContact(friction, *normal)

    def with_restitution(self, restitution: float, speed: float) -> SoftContact:
        """The contact with a coefficient of restitution (0 to 1) at an impact speed (m/s) in free motion; it is lower for faster impacts. Sets damping and
        its exponent."""
        return SoftContact(self.friction, *_dualbody._with_restitution(self, restitution, speed))

    def restitution(self, speed: float) -> float | None:
        """Coefficient of restitution at an impact speed (m/s); None if the damping exponent is not 1 + the stiffness exponent."""
        return _dualbody._restitution(self, speed)

    def impact_time(self, mass: float, speed: float) -> float:
        """Contact time of an impact, s, of a mass (kg) at a speed (m/s), without damping; steps of a fiftieth of it resolve the impact."""
        return _dualbody._impact_time(self, mass, speed)


@dataclass(frozen=True)
class RelaxedRigid:
    """Regularised (MuJoCo-style) rigid contact: a reference acceleration by time constant (s) and damping ratio, or by stiffness and damping; an impedance
    that grows with the depth."""

    friction: float = 0.5
    time_constant: float = 0.02
    damping_ratio: float = 1.0
    #: (stiffness, damping) of the reference instead
    direct: tuple[float, float] | None = None
    #: least, largest, width (m), midpoint, power
    impedance: tuple[float, float, float, float, float] = (0.9, 0.95, 1e-3, 0.5, 2.0)
    friction_impedance_ratio: float = 1.0


@dataclass(frozen=True)
class Rigid:
    """Rigid contact: exact Coulomb friction, restitution, and the recovery time (s) of a penetration.

    Jacobians of a step are exact. Chained through impacts over whole steps they are those of impacts at fixed times, so later gradients are biased.
    """

    friction: float = 0.5
    restitution: float = 0.0
    recovery_time: float = 0.02


@dataclass(frozen=True)
class Smoothing:
    """Smoothing of rigid contact: kappa (a larger value is smoother), and its reach above the ground, m."""

    kappa: float
    reach: float | None = None


@dataclass(frozen=True)
class SolverOptions:
    """Options of the solver of rigid contacts.

    warm_start: each step of a rollout of one state starts from the forces of the step before, which is quicker where bodies lie. Forces may differ in their last
    digits. Batches, single steps and derivatives always start from no forces.
    """

    tolerance: float = 1e-12
    iterations: int = 200
    acceptable: float = 1e-6
    points_per_link: int = 4
    points: int = 256
    warm_start: bool = False


@dataclass(frozen=True)
class Material:
    """Friction, coefficient of restitution (0 to 1) and margin of a material.

    Restitution is for rigid contact only. margin, m: contact begins at a distance of the margins of both surfaces together, and depth counts from there. torsional_friction and rolling_friction, m: bounds of the moments about the normal and about the tangents, as
    lengths times the normal force; between two materials the larger ones count. compliance: how the surface yields, in place of the contact model's parameters:
    (stiffness, damping) for soft contact; for regularised contact a RelaxedRigid, of which reference and impedance count. Between two materials regularised
    contact has the means of both, soft contact springs in series, 2 a b / (a + b); if only one has a compliance, it is that of the pair.

    >>> import dualbody as db
    >>> world = db.World()
    >>> world.add_box("plate", (1, 1, 0.2), fixed=True, position=(0, 0, -0.1))
    >>> world.add_sphere("ball", 0.1, mass=1.0, position=(0, 0, 0.1 - 9.81e-3))
    >>> law = db.contact.SoftContact(0.5, 1e6, 10.0, 0.0, 0.0)
    >>> foam, rubber = db.contact.Material(compliance=(1.5e3, 10.0)), db.contact.Material(compliance=(0.75e3, 10.0))
    >>> collisions = db.contact.Collisions(materials={"plate": foam, "ball": rubber})
    >>> contacts = db.contact.Contacts(db.contact.Terrain.flat(-1.0), law, collisions=collisions)
    >>> simulator = db.Simulator(world.build(), contacts=contacts)
    >>> v = simulator.rollout(simulator.model.neutral(), [0.0] * 6, 1).v[-1]  # at rest: m g / 1000 N/m deep
    >>> bool(abs(v).max() < 1e-12)
    True
    """

    friction: float = 0.5
    restitution: float = 0.0
    torsional_friction: float = 0.0
    rolling_friction: float = 0.0
    compliance: RelaxedRigid | tuple[float, float] | None = None
    margin: float = 0.0


@dataclass(frozen=True)
class Surface:
    """A triangle mesh that bodies touch from outside: vertices (n, 3), m, and indices (k, 3), counter-clockwise as seen from outside.

    Bodies slide and roll over inner edges without bumps. The mesh has no volume: a body that is too deep falls through.
    """

    vertices: Sequence[Vector3] | Array
    triangles: Sequence[tuple[int, int, int]] | Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", np.asarray(self.vertices, float).tolist())
        object.__setattr__(self, "triangles", np.asarray(self.triangles).tolist())

    @staticmethod
    def grid(heights: ArrayLike, origin: tuple[float, float], spacing: tuple[float, float]) -> Surface:
        """A grid of heights (ny, nx), m, from the point origin on, (x, y), at a spacing along both, m."""
        return Surface(*_dualbody._surface_grid(heights, origin, spacing))


@dataclass(frozen=True)
class Collisions:
    """Contact between bodies, by their collision shapes; meshes are replaced by their convex hulls.

    Robots and objects of a world collide; with self_collision also links of one robot, except those connected by a joint. law: contact model of all pairs,
    of the same kind as that of the ground (its default). Soft contact has no bristles between bodies: friction is that of the damper, and loaded contacts
    creep. excluded: pairs of links that never touch. materials: of links, by name; between two links, friction and restitution are the harmonic means 2 a
    b / (a + b). pairs: materials between two links, by both names, in place of the mean. surfaces: triangle meshes on links that are fixed to the world, by name. speculative: regularised rigid contact acts on points that would
    arrive within a step, so bodies do not pass through thin walls; rigid contact always does. torsional_friction, rolling_friction: of links without material.
    """

    law: SoftContact | RelaxedRigid | Rigid | Literal["rigid", "relaxed", "soft"] | None = None
    self_collision: bool = False
    excluded: Sequence[tuple[str, str]] = ()
    materials: Mapping[str, Material] = field(default_factory=dict)
    pairs: Mapping[tuple[str, str], Material] = field(default_factory=dict)
    surfaces: Mapping[str, Surface] = field(default_factory=dict)
    speculative: bool = False
    torsional_friction: float = 0.0
    rolling_friction: float = 0.0


def pairs_of_srdf(
    model: Model, description: str | PathLike[str], prefix: str = ""
) -> tuple[list[tuple[str, str]], list[str]]:
    """The pairs of links of <disable_collisions> in an SRDF file (text or path), for `Collisions.excluded`; and remarks on its other content.

    prefix: of link names, as in World.add.

    >>> import dualbody as db
    >>> text = '<robot><disable_collisions link1="link1" link2="link3"/></robot>'
    >>> db.contact.pairs_of_srdf(db.samples.arm(), text)
    ([('link1', 'link3')], [])
    """
    pairs, rest = _dualbody._srdf(model, description, prefix)
    return [(first, second) for first, second in pairs], rest


class Nearest(NamedTuple):
    """The nearest points of two links; batch axes come first."""

    #: m; not positive where the links overlap: the least translation that separates them, negative
    distance: Any
    #: in the world, the first link's first, (2, 3), m
    points: Array
    #: from the first link to the second, in the world, (3,)
    normal: Array
    #: derivative of the distance in the tangent of q, (nv,)
    gradient: Array


def nearest(model: Model, q: ArrayLike, first: str, second: str, smoothing: float = 0.0) -> Nearest:
    """The nearest points of two links, by their collision shapes, and the gradient of their distance. q (nq,), or with leading batch axes, which all
    results then have.

    smoothing: width w of a soft minimum over near vertices, edges, faces and shapes, m, for gradients that are continuous where the nearest feature switches; for N pairs
    of polytopes with n₁ and n₂ vertices the distance is lower than the exact one by at most w (ln N + ln n₁ + ln n₂). 0 is the exact distance.

    >>> import dualbody as db
    >>> world = db.World()
    >>> world.add_sphere("ball", 0.1, mass=1.0, position=(0, 0, 1))
    >>> world.add_box("table", (1, 1, 0.2), fixed=True)
    >>> model = world.build()
    >>> near = db.contact.nearest(model, model.neutral(), "table", "ball")
    >>> round(near.distance, 12), near.gradient.tolist()[2]
    (0.8, 1.0)
    """
    distance, points, normal, gradient = _dualbody._nearest(model, q, first, second, smoothing)
    return Nearest(distance if distance.ndim else float(distance), points, normal, gradient)


@dataclass(frozen=True)
class Contacts:
    """Contacts of a robot's collision shapes with a terrain, with a contact model.

    law: a contact model, or its kind by name: "rigid" and "relaxed" with their default parameters, "soft" as SoftContact.estimate(mass of the robot, 4,
    1e-3). links: only these links have contact points; laws: other contact models for some links; mesh_points: maximum number of points of a mesh;
    smoothing and solver: of rigid contact. collisions: contact between bodies, True for the defaults of `Collisions`. turning: torsional and rolling friction of
    links against the ground, m, (torsional, rolling) by name: bounds of moments about the normal and the tangents, as lengths times the normal force.
    margins: height above the ground at which contact of a link begins, m, by name; between bodies it is one of `Material`.

    >>> import dualbody as db
    >>> world = db.World()
    >>> world.add_sphere("ball", 0.1, mass=1.0)
    >>> contacts = db.contact.Contacts(turning={"ball": (0.005, 0.0)})
    >>> simulator = db.Simulator(world.build(), time_step=1e-3, contacts=contacts)
    >>> q, v = [0, 0, 0.1, 1, 0, 0, 0], [0, 0, 0, 0, 0, 5.0]
    >>> rollout = simulator.rollout(q, v, 1)
    >>> round(float(rollout.v[-1][5]), 6)  # 5 - 0.001 * 0.005 * 1 * 9.81 / 0.004
    4.987738
    """

    terrain: Terrain = field(default_factory=Terrain.flat)
    law: SoftContact | RelaxedRigid | Rigid | Literal["rigid", "soft", "relaxed"] = field(default_factory=Rigid)
    links: Sequence[str] | None = None
    laws: Mapping[str, SoftContact | RelaxedRigid | Rigid | Literal["rigid", "soft", "relaxed"]] = field(default_factory=dict)
    mesh_points: int = 64
    smoothing: Smoothing | None = None
    solver: SolverOptions | None = None
    collisions: Collisions | bool | None = None
    turning: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    margins: Mapping[str, float] = field(default_factory=dict)
    #: The points themselves, as a simulator knows them: what travels with a pickled one.
    points: list[Any] | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if isinstance(self.collisions, bool):
            object.__setattr__(self, "collisions", Collisions() if self.collisions else None)

    def _with_points(self, points: list[Any]) -> Contacts:
        return dataclasses.replace(self, points=points, links=None)
