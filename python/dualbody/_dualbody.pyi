"""The compiled module; written by `stubs.py`."""

import builtins
from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self, TypedDict, Unpack

from . import codegen as _codegen
from . import contact as _contact
from . import cuda as _cuda
from . import identify as _identify
from . import model as _model
from . import native as _native
from . import sim as _sim
from . import trajopt as _trajopt
from . import view as _view

Array = NDArray[np.float64]
Path = str | PathLike[str]
RepresentationName = Literal["body", "mixed", "inertial"]
MomentumFrameName = Literal["centroidal", "world", "base"]
EngineName = Literal["pinocchio", "mujoco", "jaxsim"]
IntegratorName = Literal["semi_implicit_euler", "implicit_velocity", "runge_kutta_4", "implicit_midpoint"]
Vector3 = tuple[float, float, float]
Guess = tuple[ArrayLike | None, ArrayLike]
Report = Callable[[int, float, float, float], object]
Constraint = _sim.Weld | _sim.Ball | _sim.Distance | _sim.Coupler | _sim.Tendon

__version__: str

class LoaderKeywords(TypedDict, total=False):
    base: Literal["auto", "fixed", "floating"]
    gravity: Sequence[float]
    independent_mimic_joints: bool
    kept_joints: Sequence[str]
    locked_joints: Mapping[str, float | Sequence[float]]
    massless_links: Literal["kept", "refused"] | tuple[float, float]
    mesh_up_axis: Literal["auto", "honour", "ignore"]
    all_models: bool
    model_name: str
    search_paths: Sequence[Path]
    roots: Sequence[Path]

class ObjectKeywords(TypedDict, total=False):
    mass: float
    density: float
    fixed: bool
    position: Sequence[float]
    quaternion: Sequence[float]
    on: str
    color: Sequence[float]
    has_gravity: bool

class DdpKeywords(TypedDict, total=False):
    max_iterations: int
    tolerance: float
    threads: int
    line_search_steps: int
    exact_curvature: bool
    constraint_tolerance: float
    penalty: float

def _call(of: Model | Simulator, text: str, arrays: Sequence[Array], out: Sequence[Array]) -> None: ...
def _signature(of: Model | Simulator, function: str, given: int, has_parameters: bool, steps: int, names: Sequence[str] | None = None) -> tuple[list[list[int]], list[list[int]]]: ...
def _table() -> list[tuple[str, list[str], str | None, list[tuple[str, str | None]], bool]]: ...
def _trace_model(name: str, model: Model) -> Graph: ...
def _trace_step(simulator: Simulator) -> Graph: ...
def _srdf(model: Model, description: Path, prefix: str) -> tuple[list[list[str]], list[str]]: ...
def _estimate_soft_contact(mass: float, points: int, depth: float) -> tuple[float, list[float]]: ...
def _with_restitution(law: _contact.SoftContact, restitution: float, speed: float) -> list[float]: ...
def _restitution(law: _contact.SoftContact, speed: float) -> float | None: ...
def _impact_time(law: _contact.SoftContact, mass: float, speed: float) -> float: ...
def _nearest(model: Model, q: ArrayLike, first: str, second: str, smoothing: float) -> list[Array]: ...
def _terrain_surface(terrain: _contact.Terrain, x: float, y: float) -> tuple[float, float, float]: ...
def _lqr(discrete: bool, a: ArrayLike, b: ArrayLike, q: ArrayLike, r: ArrayLike) -> tuple[Any, ...]: ...
def _finite_horizon_lqr(a: ArrayLike, b: ArrayLike, q: ArrayLike, r: ArrayLike, final_cost: ArrayLike) -> tuple[Any, ...]: ...
def _computed_torque(model: Model, gains: tuple[ArrayLike, ArrayLike], q: ArrayLike, v: ArrayLike, target_q: ArrayLike, target_v: ArrayLike) -> Array: ...
def check_mass_matrix(model: Model) -> None:
    """Raises a ValueError that names the joints that nothing resists, if the mass matrix is singular."""
def _prepare(model: Model, preparation: _identify.Preparation, experiments: Sequence[_identify.Experiment]) -> tuple[list[tuple[str, float, float, Array, Array, Array, Array]], list[tuple[str, float, int]]]: ...
def _hold_back(data: _identify.Dataset, share: float) -> list[list[tuple[str, float, float, Array, Array, Array, Array]]]: ...
def _estimate(regressor: _identify.Regressor, data: _identify.Dataset) -> tuple[Array, Array, Array, list[float], list[int], float, int, Array]: ...
def _intervals(estimate: _identify.Estimate, level: float) -> list[tuple[str, float, float, float, float]]: ...
def _consistent(estimate: _identify.Estimate, regularization: float | None, gap: float | None) -> tuple[Array, list[Array], float, float, int]: ...
def _report(estimate: _identify.Estimate, robot: _identify.Robot, validation: _identify.Dataset, level: float) -> tuple[str, str]: ...
def _identified(estimate: _identify.Estimate) -> list[Array]: ...
def _excite(regressor: _identify.Regressor, options: dict[str, Any]) -> tuple[float, Array, Array, float, float]: ...
def _excited(motion: _identify.Excitation, times: ArrayLike) -> list[Array]: ...
def _regressor(regressor: _identify.Regressor) -> tuple[list[str], Array]: ...
def _regressor_matrix(regressor: _identify.Regressor, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array: ...
def _base_parameters(regressor: _identify.Regressor) -> tuple[list[int], list[int], Array, list[int], list[str]]: ...
def _predict(robot: _identify.Robot, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array: ...
def _validate(robot: _identify.Robot, data: _identify.Dataset) -> tuple[list[list[float]], list[Array]]: ...
def _shoot(simulator: Simulator, data: _identify.Dataset, adjustable: Sequence[object], level: float, options: dict[str, Any]) -> tuple[Array, list[tuple[str, float, float, float, float]] | None, float, str, bool, int, Array]: ...
def _foreign_function() -> object: ...
def _foreign_name(of: Model | Simulator) -> str: ...
def _loss(loss: tuple[str, float], s: ArrayLike) -> list[Array]: ...
def _least_squares(residuals: Callable[[Array], ArrayLike], jacobian: Callable[[Array], ArrayLike], start: ArrayLike, manifold: tuple[int, Callable[[Array, Array], ArrayLike]] | None, loss: tuple[str, float], bounds: Sequence[ArrayLike | None], report: Report | None, options: dict[str, Any]) -> tuple[Any, ...]: ...
def _command(arguments: Sequence[str]) -> int: ...
def set_memory_limit(bytes: int | None) -> None:
    """Sets the bytes above which a result is refused with a MemoryError before any work; None for what the machine has."""
def memory_limit() -> int:
    """Returns the bytes above which a result is refused with a MemoryError before any work."""
def _check_grid(nx: int, ny: int) -> None: ...
def _build_model(name: str, gravity: Sequence[float], base: str, independent_mimic_joints: bool, links: Sequence[_model.LinkSpec], joints: Sequence[_model.JointSpec], frames: Sequence[tuple[str, str, ArrayLike]]) -> Model: ...
def _edited(model: Model, method: str, arguments: tuple[Any, ...]) -> Array: ...
def _hardware(model: Model, links: Sequence[tuple[str, Sequence[str], str]] | None) -> tuple[list[str], Array]: ...
def _hardware_model(model: Model, links: Sequence[tuple[str, Sequence[str], str]] | None, x: ArrayLike) -> Model: ...
def _hardware_jacobian(model: Model, links: Sequence[tuple[str, Sequence[str], str]] | None, x: ArrayLike) -> Array: ...
def _load_model(format: str, text: str | None, path: Path | None, options: dict[str, Any]) -> Model: ...
def _random_state(model: Model, seed: int, bounds: tuple[Sequence[Sequence[float]], Sequence[Sequence[float]] | None, Sequence[Sequence[float]], Sequence[Sequence[float]], Sequence[float], Sequence[float]]) -> tuple[Array, Array]: ...
def _unit_joint_forces(model: Model, joint: str) -> Array: ...
def _import_report(file: str, bases: Sequence[str], root_link: str, limited_joints: int, warnings: Sequence[tuple[str, str, int, str]], ignored: Sequence[tuple[str, str, int, str]]) -> ImportReport: ...
def _sample(name: str, *arguments: int) -> Model: ...
def _sample_urdf(name: str) -> str: ...
def _simulator(class_: ArrayLike, model: ArrayLike, parts: dict[str, Any]) -> Array: ...
def _rotation(question: str, x: Sequence[float]) -> list[float]: ...
def _pose(question: str, x: Sequence[float]) -> list[float]: ...
def set_threads(threads: int) -> None:
    """Sets the number of threads of batches, 0 for one for each core."""
def threads() -> int:
    """Returns the number of threads of batches."""
def _ddp(problem: _trajopt.Problem, options: dict[str, Any], guess: Guess | None = None, report: Report | None = None) -> tuple[Any, ...]: ...
def _trajectory_cost(problem: _trajopt.Problem, states: ArrayLike | None, inputs: ArrayLike) -> tuple[float, float]: ...
def _position_bounds(simulator: Simulator) -> tuple[list[float], list[float]]: ...
def _single_shooting(problem: _trajopt.Problem, options: dict[str, Any], guess: Guess | None = None, report: Report | None = None) -> tuple[Any, ...]: ...
def _shooting_at(problem: _trajopt.Problem, options: dict[str, Any], question: str, z: ArrayLike) -> Array: ...
def _shooting_variables(problem: _trajopt.Problem, options: dict[str, Any], guess: Guess | None = None) -> Array: ...
def _transcription(problem: _trajopt.Problem, options: dict[str, Any], guess: Guess | None = None, from_: tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike] | None = None, report: Report | None = None) -> tuple[Any, ...]: ...
def _curve_at(problem: _trajopt.Problem, points: tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike], times: ArrayLike) -> tuple[Array, Array]: ...
def _plot(title: str, axes: Sequence[str], size: tuple[int, int], is_logarithmic: bool, lines: Sequence[tuple[str, Sequence[tuple[float, float]]]]) -> Plot: ...
def _recording(class_: type[Recording], text: str, models: Sequence[Model]) -> Recording: ...
def _world(name: str, gravity: Sequence[float] | None, calls: Sequence[tuple[str, tuple[Any, ...], dict[str, Any]]]) -> World: ...
def _build_world(name: str, gravity: Sequence[float] | None, calls: Sequence[tuple[str, tuple[Any, ...], dict[str, Any]]]) -> Model: ...
def carried_state(before: Model, after: Model, q: ArrayLike, v: ArrayLike) -> list[Array]:
    """The state (q, v) of one model in another, joint by joint of the same name: a world with other members, say.

    Free bodies keep their pose in the world; joints that `before` does not have are neutral and at rest.
    """
def velocity_to_representation(model: Model, q: ArrayLike, v: ArrayLike, representation: RepresentationName, *, out: Array | None = None) -> Array:
    """Velocity whose base part is in another representation, (..., nv). q (..., nq), v (..., nv)."""
def velocity_from_representation(model: Model, q: ArrayLike, v: ArrayLike, representation: RepresentationName, *, out: Array | None = None) -> Array:
    """Velocity of this library from one whose base part is in another representation, (..., nv). q (..., nq), v (..., nv)."""
def force_to_representation(model: Model, q: ArrayLike, tau: ArrayLike, representation: RepresentationName, *, out: Array | None = None) -> Array:
    """Joint forces whose base part is in another representation, (..., nv). q (..., nq), tau (..., nv)."""
def force_from_representation(model: Model, q: ArrayLike, tau: ArrayLike, representation: RepresentationName, *, out: Array | None = None) -> Array:
    """Joint forces of this library from some whose base part is in another representation, (..., nv). q (..., nq), tau (..., nv)."""
def acceleration_to_representation(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, representation: RepresentationName, *, out: Array | None = None) -> Array:
    """Acceleration whose base part is in another representation, (..., nv). q (..., nq), v and a (..., nv)."""
def acceleration_from_representation(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, representation: RepresentationName, *, out: Array | None = None) -> Array:
    """Acceleration of this library from one whose base part is in another representation, (..., nv). q (..., nq), v and a (..., nv)."""
def _row_to_representation(model: Model, q: ArrayLike, row: ArrayLike, representation: RepresentationName, *, out: Array | None = None) -> Array: ...
def mass_matrix_to_representation(model: Model, q: ArrayLike, mass_matrix: ArrayLike, representation: RepresentationName, *, out: Array | None = None) -> Array:
    """Mass matrix for velocities whose base part is in another representation, (..., nv, nv). q (..., nq), mass_matrix (..., nv, nv)."""
def _base_state_tangents(model: Model, q: ArrayLike, v: ArrayLike, base: str, *, out: Array | None = None) -> Array: ...
def inverse_dynamics(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, *, external: ArrayLike | None = None, out: Array | None = None) -> Array:
    """Joint forces that produce the accelerations ``a``:  tau = M(q) a + h(q, v) - sum J' f.

    q (..., nq), v and a (..., nv; rad/s, rad/s² or m/s, m/s²), external (..., n_bodies, 6): force on each body in its
    frame, [linear; angular] (N, N·m), see external_forces. Returns (..., nv), N·m or N. [Featherstone 2008, table 5.1]
    """
def forward_dynamics(model: Model, q: ArrayLike, v: ArrayLike, tau: ArrayLike, *, external: ArrayLike | None = None, out: Array | None = None) -> Array:
    """Accelerations that the joint forces ``tau`` produce:  a = M(q)⁻¹ (tau - h(q, v) + sum J' f).

    q (..., nq), v (..., nv; rad/s or m/s), tau (..., nv; N·m or N), external as in inverse_dynamics. Returns (..., nv), rad/s² or m/s².
    A singular mass matrix is a ValueError that names the joints. [Featherstone 2008, table 7.1]
    """
def bias_forces(model: Model, q: ArrayLike, v: ArrayLike, *, external: ArrayLike | None = None, out: Array | None = None) -> Array:
    """h(q, v): Coriolis, centrifugal and gravity forces, (..., nv), N·m or N.

    q (..., nq), v (..., nv; rad/s or m/s), external as in inverse_dynamics.
    """
def gravity_forces(model: Model, q: ArrayLike, *, out: Array | None = None) -> Array:
    """Joint forces that hold the robot still against gravity, (..., nv), N·m or N. q (..., nq)."""
def mass_matrix(model: Model, q: ArrayLike, *, out: Array | None = None) -> Array:
    """Mass matrix M(q), (..., nv, nv), rotors included. q (..., nq). [Featherstone 2008, table 6.2]"""
def mass_matrix_inverse(model: Model, q: ArrayLike, *, out: Array | None = None) -> Array:
    """Inverse of the mass matrix, (..., nv, nv). q (..., nq). [Carpentier 2018]"""
def coriolis_matrix(model: Model, q: ArrayLike, v: ArrayLike, *, out: Array | None = None) -> Array:
    """C(q, v) with C v = Coriolis and centrifugal forces and dM/dt - 2 C skew, (..., nv, nv).

    q (..., nq), v (..., nv). [Echeandia, Wensing 2021]
    """
def _inverse_dynamics_derivatives(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, *, out: Array | None = None) -> Array: ...
def _forward_dynamics_derivatives(model: Model, q: ArrayLike, v: ArrayLike, tau: ArrayLike, *, out: Array | None = None) -> Array: ...
def kinetic_energy(model: Model, q: ArrayLike, v: ArrayLike, *, out: Array | None = None) -> Array:
    """Kinetic energy, (...), J. q (..., nq), v (..., nv)."""
def potential_energy(model: Model, q: ArrayLike, *, out: Array | None = None) -> Array:
    """Potential energy of gravity, -m g' p_com, (...), J: it grows with height. q (..., nq)."""
def elastic_energy(model: Model, q: ArrayLike, *, out: Array | None = None) -> Array:
    """Energy of the joints' springs, (...), J. q (..., nq)."""
def passive_forces(model: Model, q: ArrayLike, v: ArrayLike, *, out: Array | None = None) -> Array:
    """Forces of springs and damping, (..., nv), N·m or N. q (..., nq), v (..., nv)."""
def joint_torque_regressor(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, *, out: Array | None = None) -> Array:
    """Matrix Y with tau = Y p, p the ten inertial parameters of each body, (..., nv, 10 n_bodies). q (..., nq), v and a (..., nv)."""
def kinetic_energy_regressor(model: Model, q: ArrayLike, v: ArrayLike, *, out: Array | None = None) -> Array:
    """Row y with T = y p, p the ten inertial parameters of each body, (..., 10 n_bodies). q (..., nq), v (..., nv)."""
def potential_energy_regressor(model: Model, q: ArrayLike, *, out: Array | None = None) -> Array:
    """Row y with U = y p, p the ten inertial parameters of each body, (..., 10 n_bodies). q (..., nq)."""
def _frame_force(model: Model, q: ArrayLike, force: ArrayLike, frame: str, representation: RepresentationName, *, out: Array | None = None) -> Array: ...
def forward_kinematics(model: Model, q: ArrayLike, *, out: Array | None = None) -> Array:
    """Poses of all frames in the world, in the order of ``model.frame_names``, (..., n_frames, 4, 4). q (..., nq)."""
def frame_velocity(model: Model, q: ArrayLike, v: ArrayLike, frame: str, representation: RepresentationName = "body", *, out: Array | None = None) -> Array:
    """Velocity of a frame, [linear; angular], (..., 6), m/s and rad/s. q (..., nq), v (..., nv).

    representation: "body" in the frame's axes, "mixed" of its origin in the world's axes, "inertial" of the point of the body at the world's
    origin: LOCAL, LOCAL_WORLD_ALIGNED and WORLD of Pinocchio.
    """
def frame_acceleration(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, frame: str, representation: RepresentationName = "body", *, out: Array | None = None) -> Array:
    """Acceleration of a frame, [linear; angular], (..., 6), without gravity: classical if mixed, else spatial (ω × v less). q (..., nq), v and a (..., nv)."""
def frame_bias_acceleration(model: Model, q: ArrayLike, v: ArrayLike, frame: str, representation: RepresentationName = "body", *, out: Array | None = None) -> Array:
    """Acceleration of a frame where a is zero: the rate of its Jacobian times v, (..., 6). q (..., nq), v (..., nv)."""
def frame_jacobian(model: Model, q: ArrayLike, frame: str, representation: RepresentationName = "body", *, out: Array | None = None) -> Array:
    """Jacobian of a frame: its velocity is J v, (..., 6, nv). q (..., nq); representation "body", "mixed" or "inertial"."""
def frame_jacobian_derivative(model: Model, q: ArrayLike, v: ArrayLike, frame: str, representation: RepresentationName = "body", *, out: Array | None = None) -> Array:
    """Rate of a frame's Jacobian along v, (..., 6, nv). q (..., nq), v (..., nv)."""
def _frame_velocity_derivatives(model: Model, q: ArrayLike, v: ArrayLike, frame: str, representation: RepresentationName = "body", *, out: Array | None = None) -> Array: ...
def frame_pose(model: Model, q: ArrayLike, frame: str, *, out: Array | None = None) -> Array:
    """Pose of a frame or link in the world as a matrix [[R, p], [0, 1]], (..., 4, 4). q (..., nq)."""
def frame_placement_derivatives(model: Model, q: ArrayLike, frame: str, *, out: Array | None = None) -> Array:
    """Derivative of a frame's pose in tangent directions of q, (..., 12, nv): the entries of the rotation matrix, column by column, then the
    translation. q (..., nq).
    """
def link_velocities(model: Model, q: ArrayLike, v: ArrayLike, representation: RepresentationName = "body", *, out: Array | None = None) -> Array:
    """Velocities of all links in the order of ``model.link_names``, (..., n_links, 6). q (..., nq), v (..., nv)."""
def link_accelerations(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, representation: RepresentationName = "body", *, out: Array | None = None) -> Array:
    """Accelerations of all links, (..., n_links, 6): classical if mixed, else spatial. q (..., nq), v and a (..., nv)."""
def link_jacobians(model: Model, q: ArrayLike, representation: RepresentationName = "body", *, out: Array | None = None) -> Array:
    """Jacobians of all links in the order of ``model.link_names``, (..., n_links, 6, nv). q (..., nq)."""
def link_jacobian_derivatives(model: Model, q: ArrayLike, v: ArrayLike, representation: RepresentationName = "body", *, out: Array | None = None) -> Array:
    """Rates of the Jacobians of all links along v, (..., n_links, 6, nv). q (..., nq), v (..., nv)."""
def integrate(model: Model, q: ArrayLike, dv: ArrayLike, *, out: Array | None = None) -> Array:
    """Configuration q moved by the tangent vector dv, (..., nq). q (..., nq), dv (..., nv)."""
def difference(model: Model, q0: ArrayLike, q1: ArrayLike, *, out: Array | None = None) -> Array:
    """Tangent vector that leads from q0 to q1, in the axes of the bodies at q0: (..., nv). q0 and q1 (..., nq). The shorter way about a turn."""
def _deviation(model: Model, q: ArrayLike, v: ArrayLike, q0: ArrayLike, v0: ArrayLike, *, out: Array | None = None) -> Array: ...
def center_of_mass(model: Model, q: ArrayLike, *, out: Array | None = None) -> Array:
    """Centre of mass in the world, (..., 3), m. q (..., nq)."""
def center_of_mass_velocity(model: Model, q: ArrayLike, v: ArrayLike, *, out: Array | None = None) -> Array:
    """Velocity of the centre of mass in the world, (..., 3), m/s. q (..., nq), v (..., nv)."""
def center_of_mass_acceleration(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, *, out: Array | None = None) -> Array:
    """Acceleration of the centre of mass in the world, (..., 3), m/s². q (..., nq), v and a (..., nv)."""
def center_of_mass_jacobian(model: Model, q: ArrayLike, *, out: Array | None = None) -> Array:
    """Jacobian of the centre of mass: its velocity is J v, (..., 3, nv). q (..., nq)."""
def center_of_mass_derivatives(model: Model, q: ArrayLike, *, out: Array | None = None) -> Array:
    """Derivative of the centre of mass in tangent directions of q, (..., 3, nv), m. q (..., nq)."""
def centroidal_momentum(model: Model, q: ArrayLike, v: ArrayLike, *, out: Array | None = None) -> Array:
    """Momentum about the centre of mass, [linear; angular], (..., 6), kg·m/s and kg·m²/s. q (..., nq), v (..., nv)."""
def centroidal_momentum_matrix(model: Model, q: ArrayLike, *, out: Array | None = None) -> Array:
    """Matrix A of the centroidal momentum A v, (..., 6, nv). q (..., nq). [Orin, Goswami, Lee 2013]"""
def centroidal_momentum_rate(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, *, out: Array | None = None) -> Array:
    """Rate of the centroidal momentum, (..., 6), N and N·m. q (..., nq), v and a (..., nv)."""
def centroidal_momentum_matrix_derivative(model: Model, q: ArrayLike, v: ArrayLike, *, out: Array | None = None) -> Array:
    """Rate of the centroidal momentum matrix along v, (..., 6, nv). q (..., nq), v (..., nv)."""
def _centroidal_momentum_derivatives(model: Model, q: ArrayLike, v: ArrayLike, *, out: Array | None = None) -> Array: ...
def momentum(model: Model, q: ArrayLike, v: ArrayLike, frame: MomentumFrameName = "centroidal", *, out: Array | None = None) -> Array:
    """Momentum of all bodies in a frame ("centroidal", "world", "base"), [linear; angular], (..., 6). q (..., nq), v (..., nv)."""
def momentum_matrix(model: Model, q: ArrayLike, frame: MomentumFrameName = "centroidal", *, out: Array | None = None) -> Array:
    """Matrix of the momentum, (..., 6, nv). q (..., nq)."""
def locked_inertia(model: Model, q: ArrayLike, frame: MomentumFrameName = "centroidal", *, out: Array | None = None) -> Array:
    """Inertia of the robot as one body, (..., 6, 6). q (..., nq)."""
def average_velocity(model: Model, q: ArrayLike, v: ArrayLike, frame: MomentumFrameName = "centroidal", *, out: Array | None = None) -> Array:
    """Velocity that the robot would have as one body of the same momentum, (..., 6). q (..., nq), v (..., nv)."""
def average_velocity_jacobian(model: Model, q: ArrayLike, frame: MomentumFrameName = "centroidal", *, out: Array | None = None) -> Array:
    """Matrix of the average velocity, (..., 6, nv). q (..., nq)."""
def _integrate_jacobian(model: Model, q: ArrayLike, *, out: Array | None = None) -> Array: ...
def _difference_jacobian(model: Model, q: ArrayLike, *, out: Array | None = None) -> Array: ...
def inverse_dynamics_second_derivatives(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, *, out: Array | None = None) -> Array:
    """Second derivatives of tau in (q, v, a), tangent: (..., nv, 3 nv, 3 nv). q (..., nq), v and a (..., nv)."""
class BaseFunctions:
    """Methods of `BaseVelocity`."""

    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Joint forces that produce the accelerations ``a``:  tau = M(q) a + h(q, v) - sum J' f.

        q (..., nq), v and a (..., nv; rad/s, rad/s² or m/s, m/s²), external (..., n_bodies, 6): force on each body in its
        frame, [linear; angular] (N, N·m), see external_forces. Returns (..., nv), N·m or N. [Featherstone 2008, table 5.1]
        """
    def forward_dynamics(self, q: ArrayLike, v: ArrayLike, tau: ArrayLike) -> Array:
        """Accelerations that the joint forces ``tau`` produce:  a = M(q)⁻¹ (tau - h(q, v) + sum J' f).

        q (..., nq), v (..., nv; rad/s or m/s), tau (..., nv; N·m or N), external as in inverse_dynamics. Returns (..., nv), rad/s² or m/s².
        A singular mass matrix is a ValueError that names the joints. [Featherstone 2008, table 7.1]
        """
    def bias_forces(self, q: ArrayLike, v: ArrayLike) -> Array:
        """h(q, v): Coriolis, centrifugal and gravity forces, (..., nv), N·m or N.

        q (..., nq), v (..., nv; rad/s or m/s), external as in inverse_dynamics.
        """
    def gravity_forces(self, q: ArrayLike) -> Array:
        """Joint forces that hold the robot still against gravity, (..., nv), N·m or N. q (..., nq)."""
    def mass_matrix(self, q: ArrayLike) -> Array:
        """Mass matrix M(q), (..., nv, nv), rotors included. q (..., nq). [Featherstone 2008, table 6.2]"""
    def mass_matrix_inverse(self, q: ArrayLike) -> Array:
        """Inverse of the mass matrix, (..., nv, nv). q (..., nq). [Carpentier 2018]"""
    def coriolis_matrix(self, q: ArrayLike, v: ArrayLike) -> Array:
        """C(q, v) with C v = Coriolis and centrifugal forces and dM/dt - 2 C skew, (..., nv, nv).

        q (..., nq), v (..., nv). [Echeandia, Wensing 2021]
        """
    def frame_velocity(self, q: ArrayLike, v: ArrayLike, frame: str, representation: RepresentationName = "body") -> Array:
        """Velocity of a frame, [linear; angular], (..., 6), m/s and rad/s. q (..., nq), v (..., nv).

        representation: "body" in the frame's axes, "mixed" of its origin in the world's axes, "inertial" of the point of the body at the world's
        origin: LOCAL, LOCAL_WORLD_ALIGNED and WORLD of Pinocchio.
        """
    def frame_acceleration(self, q: ArrayLike, v: ArrayLike, a: ArrayLike, frame: str, representation: RepresentationName = "body") -> Array:
        """Acceleration of a frame, [linear; angular], (..., 6), without gravity: classical if mixed, else spatial (ω × v less). q (..., nq), v and a (..., nv)."""
    def frame_bias_acceleration(self, q: ArrayLike, v: ArrayLike, frame: str, representation: RepresentationName = "body") -> Array:
        """Acceleration of a frame where a is zero: the rate of its Jacobian times v, (..., 6). q (..., nq), v (..., nv)."""
    def frame_jacobian(self, q: ArrayLike, frame: str, representation: RepresentationName = "body") -> Array:
        """Jacobian of a frame: its velocity is J v, (..., 6, nv). q (..., nq); representation "body", "mixed" or "inertial"."""
    def frame_jacobian_derivative(self, q: ArrayLike, v: ArrayLike, frame: str, representation: RepresentationName = "body") -> Array:
        """Rate of a frame's Jacobian along v, (..., 6, nv). q (..., nq), v (..., nv)."""
    def center_of_mass_velocity(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Velocity of the centre of mass in the world, (..., 3), m/s. q (..., nq), v (..., nv)."""
    def center_of_mass_acceleration(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Acceleration of the centre of mass in the world, (..., 3), m/s². q (..., nq), v and a (..., nv)."""
    def center_of_mass_jacobian(self, q: ArrayLike) -> Array:
        """Jacobian of the centre of mass: its velocity is J v, (..., 3, nv). q (..., nq)."""
    def centroidal_momentum_rate(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Rate of the centroidal momentum, (..., 6), N and N·m. q (..., nq), v and a (..., nv)."""
    def centroidal_momentum_matrix_derivative(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Rate of the centroidal momentum matrix along v, (..., 6, nv). q (..., nq), v (..., nv)."""
    def momentum(self, q: ArrayLike, v: ArrayLike, frame: MomentumFrameName = "centroidal") -> Array:
        """Momentum of all bodies in a frame ("centroidal", "world", "base"), [linear; angular], (..., 6). q (..., nq), v (..., nv)."""
    def momentum_matrix(self, q: ArrayLike, frame: MomentumFrameName = "centroidal") -> Array:
        """Matrix of the momentum, (..., 6, nv). q (..., nq)."""
    def average_velocity_jacobian(self, q: ArrayLike, frame: MomentumFrameName = "centroidal") -> Array:
        """Matrix of the average velocity, (..., 6, nv). q (..., nq)."""
@final
class Graph:
    @property
    def conditions(self) -> list[str]:
        """Conditions of the graph, as text: if one is violated, evaluation raises a ValueError."""
    @property
    def inputs(self) -> list[tuple[str, int, int, str]]:
        """Inputs, in the order of the input array: [(name, rows, columns, unit)]."""
    @property
    def n_inputs(self) -> int:
        """Number of entries of all inputs."""
    @property
    def n_outputs(self) -> int:
        """Number of entries of all outputs."""
    @property
    def operations(self) -> int:
        """Number of operations."""
    @property
    def outputs(self) -> list[tuple[str, int, int, str]]:
        """Outputs, likewise; matrices in column-major order."""
    def evaluate(self, inputs: ArrayLike) -> Array:
        """Outputs (..., n_outputs) at inputs (..., n_inputs)."""
    def jacobian(self, outputs: Sequence[str], inputs: Sequence[str]) -> Graph:
        """Graph of the Jacobians of outputs in inputs: an output dy_dx for each of outputs y and inputs x."""
    def gradient(self, output: str, inputs: Sequence[str]) -> Graph:
        """Graph of the gradient of a scalar output: an output dy_dx for each of the inputs x."""
    def adjoint(self, inputs: Sequence[str]) -> Graph:
        """Graph of products of weights with the Jacobian: an additional input y_weight for each output y, an output x_weight for each of the inputs x."""
    def check_origin(self, model: Model) -> None:
        """Raises a ValueError unless the graph was recorded from this robot with its current parameters."""
    def to_c(self, name: str, precision: Literal["double", "single"] = "double") -> _codegen.Source:
        """The graph as a function of C99: a Source (name, header, source). precision: "double" or "single"."""
@final
class CudaSimulator:
    @property
    def parameter_names(self) -> list[str]:
        """Names of the parameters that differ between states."""
    @property
    def simulator(self) -> Simulator:
        """The original simulator."""
    def __len__(self) -> int: ...
    def __new__(cls, simulator: Simulator, count: int, *, parameters: Mapping[str, ArrayLike] | None = None, precision: Literal["double", "single"] = "double", derivatives: Sequence[Literal["jacobians", "gradients"]] | None = None, device: int | None = None, cache: Path | None = None) -> CudaSimulator: ...
    def step(self, q: ArrayLike, v: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None) -> tuple[Array, ...]:
        """Advances all states by one time step: the next (q, v), or (q, v, contact) if contact is given.

        q (count, nq), v (count, nv), u (count, nu; N·m or N; zero if left out), contact (count, n_contact); arguments that are equal for all states
        may lack the first axis, except one of them. Raises FloatingPointError that names the first state whose step fails.
        """
    def rollout(self, q: ArrayLike, v: ArrayLike, steps: int | None = None, *, inputs: ArrayLike | None = None, every: int | None = None, contact: ArrayLike | None = None) -> _cuda.Rollout:
        """Takes steps from each state, and returns a cuda.Rollout of each `every`-th state (of the first and the last state for 0).

        q, v, contact as in step; inputs (count, steps, nu) or (steps, nu) for all, zero if left out.
        """
    def linearize(self, q: ArrayLike, v: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None) -> _sim.Linearization:
        """Jacobians of the step of each state, as Simulator.linearize: a (count, n_tangent, n_tangent), b (count, n_tangent, nu). Arguments as in
        step. Needs derivatives=["jacobians"], and one robot for all states.
        """
    def vjp(self, q: ArrayLike, v: ArrayLike, u: ArrayLike, adjoint: ArrayLike, *, contact: ArrayLike | None = None) -> _sim.StepGradient:
        """Gradients of ⟨adjoint, next state⟩ of each state, as Simulator.vjp: a StepGradient (state, input, parameters, friction), in the parameters
        that differ between states, without friction.

        adjoint (count, n_tangent). Needs derivatives=["gradients"]. Raises FloatingPointError that names the first state without a gradient.
        """
    def states(self, q: ArrayLike, v: ArrayLike, *, contact: ArrayLike | None = None) -> CudaStates:
        """Puts states on the GPU, where they stay: a cuda.States. Arguments as in step."""
@final
class CudaStates:
    @property
    def status(self) -> list[_sim.Status]:
        """The Status of each state, with the step at which its motion ended, counted from the last copy_from. Waits for the device."""
    def __len__(self) -> int: ...
    def __dlpack_device__(self) -> tuple[Any, ...]: ...
    def advance(self, u: Any | None = None, steps: int | None = None) -> None:
        """Takes `steps` steps of all states with an input that is held: u (nu, count), an array on the GPU of the simulator's precision, in C order
        (`actions.T.contiguous()` of a policy's (count, nu)); zero if it is left out.
        """
    def copy_from(self, states: Any) -> None:
        """Replaces all states by those of an array on the GPU, (n, count), as `torch.from_dlpack(states)` makes it: for example, `torch.where(done, start, x)`
        begins some anew. Motions that had ended go on.
        """
    def numbers(self) -> Array:
        """All numbers, (count, n): q, v, contact of each state, from the device."""
    def __dlpack__(self, *, stream: Any | None = None, max_version: tuple[int, int] | None = None, dl_device: tuple[int, int] | None = None, copy: bool | None = None) -> Any: ...
@final
class EngineCoordinates:
    @property
    def engine(self) -> EngineName:
        """Name of the engine."""
    @property
    def model(self) -> Model:
        """The robot."""
    @property
    def nq(self) -> int:
        """Number of the engine's configuration coordinates."""
    def joint_q(self, name: str) -> builtins.slice:
        """Range of a joint in the engine's configuration."""
    def joint_v(self, name: str) -> builtins.slice:
        """Range of a joint in the engine's velocities and forces."""
    def configuration_to(self, q: ArrayLike) -> Array:
        """Configuration in the engine's coordinates, (..., its nq). q (..., nq)."""
    def configuration_from(self, q: ArrayLike) -> Array:
        """Configuration of this robot, (..., nq), from that of the engine, (..., its nq). Angles given as (cos, sin) become angles in (−π, π]."""
    def tangent_to(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Velocity, small displacement or gradient in the engine's coordinates, (..., nv). q (..., nq), v (..., nv)."""
    def tangent_from(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Velocity, small displacement or gradient of this library from the engine's, (..., nv). q (..., nq), v (..., nv)."""
    def force_to(self, q: ArrayLike, tau: ArrayLike) -> Array:
        """Joint forces in the engine's coordinates, (..., nv), of the same power: tau'·v' = tau·v. q (..., nq), tau (..., nv)."""
    def force_from(self, q: ArrayLike, tau: ArrayLike) -> Array:
        """Joint forces of this library from the engine's, (..., nv). q (..., nq), tau (..., nv)."""
    def acceleration_to(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Acceleration in the engine's coordinates, the rate of the velocity there, (..., nv). q (..., nq), v and a (..., nv) of this library."""
    def acceleration_from(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Acceleration of this library from the engine's, (..., nv). q (..., nq) and v (..., nv) of this library, a (..., nv) of the engine."""
    def jacobian_to(self, q: ArrayLike, jacobian: ArrayLike) -> Array:
        """Jacobian whose columns are the engine's directions, (..., rows, nv); its rows stay. q (..., nq), jacobian (..., rows, nv)."""
    def jacobian_from(self, q: ArrayLike, jacobian: ArrayLike) -> Array:
        """Jacobian of this library from one whose columns are the engine's directions, (..., rows, nv). q (..., nq), jacobian (..., rows, nv)."""
    def mass_matrix_to(self, q: ArrayLike, mass_matrix: ArrayLike) -> Array:
        """Mass matrix, its inverse or another symmetric matrix in the engine's coordinates, (..., nv, nv). q (..., nq), mass_matrix (..., nv, nv)."""
    def mass_matrix_from(self, q: ArrayLike, mass_matrix: ArrayLike) -> Array:
        """Mass matrix, its inverse or another symmetric matrix of this library from the engine's, (..., nv, nv). q (..., nq), mass_matrix (..., nv, nv)."""
    def __new__(cls, model: Model, engine: EngineName, joint_order: Sequence[str] | None = None) -> EngineCoordinates: ...
@final
class Model:
    @property
    def armature(self) -> Array:
        """Inertia of the rotor of each velocity coordinate (nv,), kg·m² or kg."""
    @property
    def body_names(self) -> list[str]:
        """Names of the moving bodies (the first link on each), in the order of external forces."""
    @property
    def damping(self) -> Array:
        """Damping of each velocity coordinate (nv,), N·m·s/rad or N·s/m."""
    @property
    def frame_names(self) -> list[str]:
        """Names of all frames, those of links among them."""
    @property
    def gravity(self) -> tuple[float, float, float]:
        """Acceleration of gravity, m/s²."""
    @property
    def has_floating_base(self) -> bool:
        """Whether its root moves freely."""
    @property
    def import_report(self) -> ImportReport | None:
        """Remarks of the reader; None for a robot that was built in code."""
    @property
    def joint_names(self) -> list[str]:
        """Names of the joints, in the order of the tree."""
    @property
    def link_inertias(self) -> Array:
        """Inertias of all links in their frames, in the order of link_names, (n_links, 6, 6)."""
    @property
    def link_masses(self) -> Array:
        """Masses of all links in the order of link_names, (n_links,), kg."""
    @property
    def link_names(self) -> list[str]:
        """Names of the links, in the order of the tree."""
    @property
    def n_bodies(self) -> int:
        """Number of moving bodies."""
    @property
    def n_joints(self) -> int:
        """Number of named joints."""
    @property
    def name(self) -> str:
        """Name of the robot."""
    @property
    def nq(self) -> int:
        """Number of configuration coordinates."""
    @property
    def nv(self) -> int:
        """Number of velocity coordinates: degrees of freedom."""
    @property
    def parameter_names(self) -> list[str]:
        """Names of the parameters, in the order of `parameters`."""
    @property
    def parameters(self) -> Array:
        """Masses, inertias, placements, gravity, damping, rotors and springs in one vector; named by parameter_names."""
    @property
    def remarks(self) -> list[str]:
        """Remarks of the reader of its file, a sentence each."""
    @property
    def sensors(self) -> dict[str, tuple[_sim.Sensor, _sim.SensorNoise]]:
        """Sensors of the file: {name: (sim.Sensor, sim.SensorNoise)}, those that are modelled; empty for a robot that was built in code."""
    @property
    def total_mass(self) -> float:
        """Mass of what moves, kg."""
    def integrate(self, q: ArrayLike, dv: ArrayLike) -> Array:
        """Configuration q ⊕ dv, moved by a tangent vector (velocity times time): (..., nq). q (..., nq), dv (..., nv).

        It differs from q + dv for quaternions: dv contains rotations about body axes, rad, and translations of a floating base along them, m.
        """
    def difference(self, q0: ArrayLike, q1: ArrayLike) -> Array:
        """Tangent vector q1 ⊖ q0 from q0 to q1, in body axes at q0: (..., nv). q0 and q1 (..., nq). Rotations take the shorter way."""
    def integrate_jacobian(self, q: ArrayLike) -> Array:
        """Derivative of a configuration in tangent directions, (..., nq, nv): of integrate(q, dv) in dv at zero, so that the rate of q is J v."""
    def difference_jacobian(self, q: ArrayLike) -> Array:
        """Tangent vector of a change of a configuration's coordinates, (..., nv, nq): the derivative of difference(q, q1) in q1 at q."""
    def deviation(self, q: ArrayLike, v: ArrayLike, q0: ArrayLike, v0: ArrayLike) -> Array:
        """Deviation (difference(q0, q), v - v0) of a state from another, (..., 2 nv): the argument of a linear controller that is designed at the reference."""
    def link_mass(self, link: str) -> float:
        """Mass of a link, kg: of the link alone, also if several fixed links form one body."""
    def link_center_of_mass(self, link: str) -> Array:
        """Centre of mass of a link in its frame, (3,), m; NaN for a link without mass."""
    def link_inertia(self, link: str) -> Array:
        """Inertia of a link in its frame, (6, 6), rows and columns [linear; angular]."""
    def with_gravity(self, gravity: Sequence[float]) -> Model:
        """The robot with another gravity, m/s²."""
    def with_damping(self, v: int | str, damping: float) -> Model:
        """The robot with another damping, N·m·s/rad or N·s/m, of a joint by its name, or of a velocity coordinate by its index."""
    def with_armature(self, v: int | str, armature: float) -> Model:
        """The robot with another rotor inertia, kg·m² or kg, of a joint by its name, or of a velocity coordinate by its index."""
    def with_spring(self, v: int | str, stiffness: float, rest: float = 0.0) -> Model:
        """The robot with another spring, N·m/rad or N/m, at rest at `rest`, of a joint by its name, or of a velocity coordinate by its index."""
    def with_link_mass(self, link: str, mass: float) -> Model:
        """The robot with another mass of a link, kg; its inertia is scaled."""
    def with_link_inertia(self, link: str, mass: float, com: Sequence[float], inertia: Sequence[Sequence[float]]) -> Model:
        """The robot with another inertia of a link: mass (kg), centre of mass in the link frame (m), matrix about it (kg·m²)."""
    def with_locked_joints(self, positions: Mapping[str, float | Sequence[float]]) -> Model:
        """The robot with joints locked at positions {name: position}: their links become one body."""
    def with_kept_joints(self, names: Sequence[str], positions: Mapping[str, float | Sequence[float]] | None = None) -> Model:
        """The robot with only some joints; the others are held, at positions {name: position} or neutral."""
    def with_attached(self, other: Model, frame: str, prefix: str, pose: ArrayLike | None = None) -> Model:
        """The robot with another one welded to a frame, at a pose (4, 4) in it; the other's names get a prefix."""
    def with_frame(self, name: str, parent: str, pose: ArrayLike) -> Model:
        """The robot with an additional frame, at a pose (4, 4) in a frame or link."""
    def with_body(self, link: _model.LinkSpec, joint: _model.JointSpec) -> Model:
        """The robot with an additional link (LinkSpec) on a joint (JointSpec)."""
    def scaled(self, length: float, density: float) -> Model:
        """The robot with all lengths and densities multiplied."""
    def with_parameters(self, parameters: ArrayLike) -> Model:
        """The robot with other parameters."""
    def to_engine(self, engine: EngineName, q: ArrayLike, v: ArrayLike, joint_order: Sequence[str] | None = None) -> tuple[Array, Array]:
        """State of this robot in the coordinates of "pinocchio", "mujoco" or "jaxsim": (q, v). Joints may be in another order. q (..., nq), v (..., nv);
        `EngineCoordinates` has forces, accelerations and matrices too.
        """
    def from_engine(self, engine: EngineName, q: ArrayLike, v: ArrayLike, joint_order: Sequence[str] | None = None) -> tuple[Array, Array]:
        """State (q, v) of this robot from the coordinates of "pinocchio", "mujoco" or "jaxsim". q (..., the engine's nq), v (..., nv)."""
    @staticmethod
    def from_urdf(description: Path, **keywords: Unpack[LoaderKeywords]) -> Model:
        """Loads a robot from a URDF: a text that begins with "<", or the path of a file.

        base: "auto" (fixed if the root link is called "world"; else it floats, an arm too, with a warning), "fixed" or "floating"; gravity: m/s², (0, 0, -9.81) if left out;
        independent_mimic_joints: joints that mimic others get coordinates of their own; kept_joints: names, the others are held;
        locked_joints: {name: position}; search_paths, roots: directories of meshes; massless_links: "kept", "refused" or (mass, radius);
        mesh_up_axis: "auto", "honour" or "ignore". What the loader remarks is in `import_report`.
        """
    @staticmethod
    def from_sdf(description: Path, **keywords: Unpack[LoaderKeywords]) -> Model:
        """Loads a robot from an SDF: a text that begins with "<", or the path of a file. The keywords are those of from_urdf, and
        model_name where there are several.
        """
    @staticmethod
    def from_mjcf(description: Path, **keywords: Unpack[LoaderKeywords]) -> Model:
        """Loads a robot from an MJCF, the XML of MuJoCo: a text that begins with "<", or the path of a file. The keywords are those of from_urdf; with base
        "auto" the robot stands or floats as the file says. Joints, bodies and sites keep their names, and q has the numbers of qpos. What the model
        cannot hold, such as actuators and sensors, is in `import_report`.
        """
    def neutral(self) -> Array:
        """Neutral configuration (nq,)."""
    def random_configuration(self, seed: int) -> Array:
        """Random configuration within the limits, (nq,); equal seeds give equal results."""
    def interpolate(self, q0: ArrayLike, q1: ArrayLike, t: float) -> Array:
        """Configuration on the path from q0 (t = 0) to q1 (t = 1): (..., nq)."""
    def random_velocity(self, seed: int, speed: float = 1.0) -> Array:
        """Random velocity of at most a speed in each coordinate, (nv,); equal seeds give equal results."""
    def joint_q(self, name: str) -> builtins.slice:
        """Range of a joint in q."""
    def joint_v(self, name: str) -> builtins.slice:
        """Range of a joint in v."""
    def joint_kind(self, name: str) -> str:
        """Kind of a joint: "revolute", "prismatic", …"""
    def limits(self, name: str) -> _model.Limits:
        """Limits of a joint: (lower, upper, velocity, effort), None where there is none."""
    def inertia_flaws(self) -> list[tuple[str, str]]:
        """Links with physically inconsistent inertia: [(link, reason)]."""
    def to_urdf(self) -> str:
        """The robot as a URDF text."""
    def to_mjcf(self) -> str:
        """The robot as a MuJoCo XML text."""
    def tree(self) -> str:
        """The tree of links and joints as a text."""
    def to_html(self) -> str:
        """HTML viewer of the robot, as text."""
    def _repr_html_(self) -> str: ...
    def show(self, width: str = "100%", height: str = "480") -> _view.Page:
        """The HTML viewer in a frame of given size, for notebooks: width and height as in HTML."""
@final
class ImportReport:
    @property
    def base(self) -> str:
        """Base of the robot: "fixed" or "floating"."""
    @property
    def file(self) -> str:
        """File, or "text"."""
    @property
    def ignored(self) -> list[tuple[str, str, int, str]]:
        """[(element, name, line, reason)] of unused content."""
    @property
    def root_link(self) -> str:
        """Name of the link at the root."""
    @property
    def warnings(self) -> list[tuple[str, str, int, str]]:
        """[(element, name, line, reason)] of corrected or doubtful content."""
    def __str__(self) -> str: ...
    def _repr_html_(self) -> str: ...
@final
class NativeFunction:
    @property
    def n_inputs(self) -> int:
        """Number of entries of all inputs."""
    @property
    def n_outputs(self) -> int:
        """Number of entries of all outputs."""
    def __call__(self, inputs: ArrayLike) -> Array: ...
    def __new__(cls, graph: Graph, name: str, compiler: _native.Compiler | None = None) -> NativeFunction: ...
@final
class Sensors:
    @property
    def missing_shapes(self) -> list[str]:
        """Collision shapes that range finders do not see, a sentence each; empty without range finders."""
    @property
    def names(self) -> list[str]:
        """Name of each reading: that of its sensor, with ".x", ".qw", ".fx" and so on if the sensor has several readings."""
    @property
    def units(self) -> list[str]:
        """Unit of each reading; empty for dimensionless readings."""
    def __new__(cls, model: Model, sensors: Mapping[str, _sim.Sensor]) -> Sensors: ...
    def __len__(self) -> int: ...
    def slice(self, name: str) -> builtins.slice:
        """Range of a sensor's readings in the vector. Raises KeyError if there is no sensor of this name."""
    def read(self, simulator: Simulator, q: ArrayLike, v: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None, out: Array | None = None) -> Array:
        """Readings (..., len) of the step from a state under the input; the state is not changed. Arguments as in Simulator.step; out: an array for the result.

        Raises FloatingPointError if a reading is not finite.
        """
    def linearize(self, simulator: Simulator, q: ArrayLike, v: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None) -> _sim.SensorLinearization:
        """Jacobians of the step and of its readings, in tangent coordinates: SensorLinearization of a, b as from Simulator.linearize, c (..., len,
        n_tangent) and d (..., len, nu). Arguments as in Simulator.step.
        """
    def noisy(self, noise: Mapping[str, _sim.SensorNoise], time_step: float, seeds: Sequence[int]) -> NoisySensors:
        """The sensors with noise, for one state per seed: a NoisySensors. noise: a mapping from names to `sim.SensorNoise`; time_step: time between
        two samples, s; seeds: (n,), whole numbers.
        """
@final
class NoisySensors:
    def sample(self, readings: ArrayLike) -> Array:
        """Returns readings with noise from exact readings of a step, (n, len), or (len,) for one state."""
    def __len__(self) -> int: ...
    def reset(self, seeds: Sequence[int], mask: Sequence[bool] | None = None) -> None:
        """Restarts states with the random numbers of their seeds: (n,) whole numbers. mask: (n,), the selected states; all by default."""
@final
class _Balance:
    def seed(self, seeds: Sequence[int | None]) -> None:
        """Seeds the states whose seed is not None, from their next episode on."""
    def step(self, actions: ArrayLike) -> tuple[NDArray[np.float32], Array, NDArray[np.bool_], NDArray[np.bool_], NDArray[np.float32] | None]:
        """Takes the steps of actions (n, nu)."""
    def __new__(cls, simulator: Simulator, n: int, start: tuple[ArrayLike, ArrayLike], within: tuple[ArrayLike, ArrayLike], max_steps: int, steps_per_action: int, mode: str) -> _Balance: ...
    def reset(self, mask: ArrayLike | None = None) -> NDArray[np.float32]:
        """Begins episodes, those of a mask or all: observations."""
    def first(self) -> tuple[Array, Array, int]:
        """The first state (nq,), (nv,), and the number of actions of its episode so far."""
@final
class BatchSimulator:
    @property
    def contact(self) -> Array:
        """States of contact (n, n_contact): a copy."""
    @property
    def q(self) -> Array:
        """Configurations (n, nq): a copy."""
    @property
    def running(self) -> NDArray[np.bool_]:
        """Whether each state runs (n,): it does until it diverges, and again once it is set."""
    @property
    def simulator(self) -> Simulator:
        """The simulator of all states, without the parameters in which they differ."""
    @property
    def v(self) -> Array:
        """Velocities (n, nv): a copy."""
    def __len__(self) -> int: ...
    def __new__(cls, simulator: Simulator, n: int, *, parameters: Mapping[str, ArrayLike] | None = None) -> BatchSimulator: ...
    def set(self, q: ArrayLike, v: ArrayLike, *, contact: ArrayLike | None = None, mask: ArrayLike | None = None) -> None:
        """Sets states: all, or those whose flag is true in mask (n,). q (n, nq) or (nq,), v likewise; contact is neutral if it is left out."""
    def step(self, u: ArrayLike | None = None, *, steps: int | None = None) -> None:
        """Takes time steps with the input held: u (n, nu) or (nu,), N·m or N, zero if it is left out; steps: their number, the decimation of a policy."""
class Simulator:
    @property
    def actuated(self) -> list[int]:
        """The velocity coordinate of each joint input."""
    @property
    def contact_points(self) -> list[tuple[str, list[float], str]]:
        """The contact points: [(link, centre in the frame of the link (3,), kind)]."""
    @property
    def divergence_bound(self) -> float:
        """Speed beyond which a motion counts as diverged, m/s or rad/s."""
    @property
    def effort_bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of the input by effort limits: (nu,) each, infinite for no limit."""
    @property
    def input_names(self) -> list[str]:
        """Names of the inputs."""
    @property
    def integrator(self) -> IntegratorName:
        """Integrator: "semi_implicit_euler", "implicit_velocity", "runge_kutta_4" or "implicit_midpoint"."""
    @property
    def keyframes(self) -> dict[str, tuple[Array, Array, Array, Array]]:
        """Named states of the MJCF file: {name: (q, v, u, contact)}, first "qpos0" at rest without inputs; empty for other simulators. contact ends with the
        activations; what the file does not state of it is zero.
        """
    @property
    def model(self) -> Model:
        """The robot."""
    @property
    def n_activation(self) -> int:
        """Numbers of the activations of inputs, in `contact`."""
    @property
    def n_contact(self) -> int:
        """Numbers of the state beside q and v, which are called `contact`: those of contacts with bristles, then n_activation of activations, then n_sleep
        of what sleeps.
        """
    @property
    def n_sleep(self) -> int:
        """Numbers of what sleeps: the last ones of `contact`. All zeros: everything is awake."""
    @property
    def n_tangent(self) -> int:
        """Number of tangent directions of the state."""
    @property
    def nu(self) -> int:
        """Number of inputs."""
    @property
    def parameter_names(self) -> list[str]:
        """Names of the parameters, in the order of `parameters`: "pivot: Coulomb friction", "contact 0 of foot: friction", "time step"."""
    @property
    def parameters(self) -> Array:
        """All parameters of a step, (n,), named by parameter_names: those of the model, then of motors, joint limits, constraints, contact points and
        models, ground and forces, and the time step.
        """
    @property
    def shapes_without_points(self) -> list[tuple[str, str]]:
        """Collision shapes without contact points: [(link, reason)]."""
    @property
    def tangent_names(self) -> list[str]:
        """Name of each direction of the tangent space of the state: rows and columns of A."""
    @property
    def time_step(self) -> float:
        """Time step, s."""
    def acceleration(self, q: ArrayLike, v: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None, forces: Mapping[str, ArrayLike] | None = None, representation: RepresentationName = "mixed", models: Sequence[Model] | None = None, out: Array | None = None) -> Array:
        """Acceleration dv/dt at a state under the input, (..., nv), rad/s² or m/s²: forward dynamics with all forces at this instant.

        Arguments as in step; out: an array for the result. Motors, limits, friction, springs, constraints and contact are evaluated at this state,
        while a step evaluates some of them at its end. Rigid contact has forces over a whole step only; the acceleration is the mean over one step.
        Raises FloatingPointError if an acceleration is not finite.
        """
    def remarks(self, q: ArrayLike, v: ArrayLike | None = None) -> list[str]:
        """Remarks on a time step that is too long for springs, dampers, limits and soft contact near this pose, and for rotations if a velocity is given."""
    def contact_report(self, q: ArrayLike, v: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None) -> _sim.ContactReport:
        """Report on contact in a state under an input: a ContactReport."""
    def _contact_forces(self, q: ArrayLike, v: ArrayLike, u: ArrayLike | None, contact: ArrayLike | None) -> list[Array]: ...
    def _pair_jacobians(self, q: ArrayLike, v: ArrayLike, points: ArrayLike, are_rates: bool) -> Array: ...
    def contact_frames(self, q: ArrayLike) -> Array:
        """Poses of the frames of all contact points, (..., n, 4, 4): the origin at the point, the axes of its link. q (..., nq)."""
    def _contact_points(self, q: ArrayLike, v: ArrayLike) -> Array: ...
    def contact_jacobians(self, q: ArrayLike, representation: RepresentationName = "mixed") -> Array:
        """Jacobians of the frames of all contact points, (..., n, 6, nv). q (..., nq).

        In the mixed representation the first three rows give the velocity of the body at the point, in world axes. A frame is fixed to its body.
        """
    def contact_jacobian_derivatives(self, q: ArrayLike, v: ArrayLike, representation: RepresentationName = "mixed") -> Array:
        """Rates of the Jacobians of the frames of all contact points along v, (..., n, 6, nv). q (..., nq), v (..., nv)."""
    def links_in_contact(self, q: ArrayLike) -> NDArray[np.bool_]:
        """Whether a point of each link is below the ground, in the order of ``model.link_names``, (..., n_links) of bool. q (..., nq)."""
    def _equilibrium(self, q: ArrayLike, u: ArrayLike | None = None, contact: ArrayLike | None = None) -> tuple[Any, ...]: ...
    def _equilibrium_lqr(self, at: Sequence[ArrayLike], q: ArrayLike, r: ArrayLike) -> tuple[Any, ...]: ...
    def vjp(self, q: ArrayLike, v: ArrayLike, u: ArrayLike, adjoint: ArrayLike, *, contact: ArrayLike | None = None, models: Sequence[Model] | None = None, parameters: bool = True) -> _sim.StepGradient:
        """Gradient of ⟨adjoint, next state⟩, the vector-Jacobian product of a step: a StepGradient (state, input, parameters, friction,
        simulator_parameters).

        q (..., nq), v (..., nv), u (..., nu), adjoint (..., n_tangent): weights of the tangent of the next state. The cost is three to six steps, for
        any number of parameters. parameters: False omits parameters and friction.
        """
    def __new__(cls, model: Model, *, time_step: float | None = None, integrator: IntegratorName | None = "semi_implicit_euler", actuated: Sequence[str] | None = None, contacts: _contact.Contacts | None = None, actuation: _sim.Actuation | Literal["ideal", "model"] | None = None, constraints: Sequence[Constraint] | None = None, external_forces: Sequence[_sim.ExternalForce] | None = None, frame_actuators: Sequence[_sim.FrameActuator] | None = None, tendon_servos: Sequence[_sim.TendonServo] | None = None, activations: Mapping[str, _sim.Activation] | None = None, sleeping: bool | tuple[float, float] | None = None, divergence_bound: float | None = None, parameters: ArrayLike | None = None, _scene: ArrayLike | None = None) -> Self: ...
    @staticmethod
    def from_mjcf(description: Path, **keywords: Unpack[LoaderKeywords]) -> Simulator:
        """Makes a simulator of the supported content of an MJCF file, the XML of MuJoCo: a text that begins with "<", or the path of a file.

        The time step and the method, joint limits and friction, constraints, contacts with the ground and between bodies, and an input for each actuator that
        is modelled: its control, those of joints first, then those of sites, then those of tendons and further ones of joints. What is not used is in
        model.import_report. The keywords are those of Model.from_mjcf. `replace` changes parts, and adds constraints, forces, frame_actuators and
        tendon_servos to those of the file. keyframes has its named states.
        """
    @staticmethod
    def from_urdf(description: Path, **keywords: Unpack[LoaderKeywords]) -> Simulator:
        """Makes a simulator of a URDF, a text that begins with "<", or the path of a file, with the inputs that it states in <ros2_control> or <transmission>.

        Limits and friction of joints act as with actuation="model". Joints with a command interface have inputs, in the order of the file; if the file
        states none at all, all joints have one. An effort is the input itself. A position or velocity with gains (parameters kp, kd, p, d, pos_kp,
        position_kp, vel_kp, … of the interface or its joint) is the target of a servo; without gains the input is the effort, with a warning. min and max are the
        range of the input, the reduction of a simple transmission is the gear of the servo. What is not used is in model.import_report. The
        keywords are those of Model.from_urdf.
        """
    def replace(self, **changes: Any) -> Self:
        """The simulator with parts replaced: the keywords of its constructor."""
    def with_parameters(self, parameters: ArrayLike) -> Self:
        """The simulator with other parameters, (n,), named by parameter_names. Raises a ValueError that names a parameter out of range.

        Placements are relative to those of the description, as in Model.with_parameters.
        """
    def linearize(self, q: ArrayLike, v: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None, models: Sequence[Model] | None = None) -> _sim.Linearization:
        """Jacobians of the step in tangent coordinates: a (..., n_tangent, n_tangent), b (..., n_tangent, nu). Arguments as in step.

        δq is a tangent vector, as from Model.difference: three entries for a rotation of a ball joint or base, in body axes, not the four of a
        quaternion. Where contacts begin or end the Jacobians are those of one side. With soft contact the state includes its bristles.
        """
    def linearize_rate(self, q: ArrayLike, v: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None) -> _sim.Linearization:
        """Jacobians of the rate (v, acceleration) in continuous time, in tangent coordinates: shapes and arguments as in linearize.

        Raises ValueError with rigid contact, whose forces act over a step. [Carpentier, Mansard 2018]
        """
    def neutral_contact(self) -> Array:
        """The state of contact of a robot that touches nothing and is awake, and activations of 0, (n_contact,)."""
    def asleep(self, q: ArrayLike, v: ArrayLike, contact: ArrayLike | None = None) -> list[str]:
        """Names of the links that sleep in a state of which `contact` says what sleeps; a state without `contact` is awake."""
    def constraint_errors(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Errors of the constraints in a state, row by row."""
    def assemble(self, q: ArrayLike, v: ArrayLike) -> tuple[Array, Array]:
        """A nearby state that satisfies the constraints: (q, v). Raises a ValueError with the remaining error if none is found."""
    def rollout(self, q: ArrayLike, v: ArrayLike, steps: int | None = None, *, control: Callable[[int, Array, Array], ArrayLike] | None = None, inputs: ArrayLike | None = None, contact: ArrayLike | None = None, models: Sequence[Model] | None = None, progress: bool | Callable[[int], object] | None = None) -> _sim.Rollout:
        """Takes steps from a state, or from each state of a batch, and returns a Rollout.

        q (..., nq), v (..., nv), contact (..., n_contact; neutral if left out); inputs (..., steps, nu) or (steps, nu) for all, or control(k, q, v) -> u with the
        arrays of all states of step k, which counts steps and is no time; without both, the inputs are zero. models: a robot for each state of a batch,
        of the same structure. progress: True for a bar (tqdm, if it is installed), or a function of the number of steps done. A trajectory that stops
        says so in the status; its numbers are NaN from there on: ask `is_completed` before the last state is used.
        """
    def rollout_vjp(self, q: ArrayLike, v: ArrayLike, inputs: ArrayLike, *, by_q: ArrayLike | None = None, by_v: ArrayLike | None = None, by_contact: ArrayLike | None = None, by_u: ArrayLike | None = None, contact: ArrayLike | None = None, models: Sequence[Model] | None = None, parameters: bool = True, checkpoints: int | str | None = None) -> _sim.RolloutGradient:
        """Gradient of Σₖ ⟨by_q[k], q[k]⟩ + ⟨by_v[k], v[k]⟩ + ⟨by_contact[k], contact[k]⟩ + ⟨by_u[k], u[k]⟩ over a rollout, the vector-Jacobian
        product of all its steps: a RolloutGradient (start, inputs, parameters, friction, status, simulator_parameters).

        q (..., nq), v (..., nv), inputs (..., steps, nu) or (steps, nu) for all; by_q (..., steps + 1, nq) in coordinates, by_v (..., steps + 1, nv),
        by_contact (..., steps + 1, n_contact), by_u (..., steps, nu); zero if left out. parameters: False leaves parameters and friction out;
        checkpoints: states that are kept, "all", "square_root", or one in so many. A trajectory that does not come to its end has no slopes.
        """
    def step(self, q: ArrayLike, v: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None, forces: Mapping[str, ArrayLike] | None = None, representation: RepresentationName = "mixed", models: Sequence[Model] | None = None, out: tuple[Any, ...] | None = None) -> tuple[Array, ...]:
        """Advances by one time step with the input held: the next (q, v), or (q, v, contact) if contact is given.

        q (..., nq), v (..., nv), u (..., nu; N·m or N; zero if left out); models: a robot of the same structure for each state of a batch.
        contact (..., n_contact): the state of soft contact, neutral if left out. Hand on the one that is returned: without it bristles begin anew
        at each step, and nothing sticks. forces {frame or link: (..., 6)}: [linear; angular], N and N·m, in a representation, held as the input is.
        out: arrays for the next state, which may be those of the state. Soft contact and stiff springs need
        short steps (0.1 ms to 1 ms), rigid contact 1 ms to 10 ms. Raises FloatingPointError if the next state is not finite.
        """
    def live(self, q: ArrayLike | None = None, v: ArrayLike | None = None) -> Live:
        """Runs the simulation interactively in the browser, from a state (the neutral one at rest by default): pause, step, speed, reset, pull bodies
        with the mouse, move joints by sliders (through servos). Its address is `.url`; a notebook shows it in a frame.
        """
@final
class NativeSimulator:
    @property
    def reason(self) -> str | None:
        """Reason why the step was not compiled; None if it was."""
    @property
    def simulator(self) -> Simulator:
        """The original simulator."""
    def __new__(cls, simulator: Simulator, compiler: _native.Compiler | None = None) -> NativeSimulator: ...
    @staticmethod
    def or_own(simulator: Simulator, compiler: _native.Compiler | None = None) -> NativeSimulator:
        """As the constructor, with the library's own code if compilation fails; `reason` contains the cause."""
    def step(self, q: ArrayLike, v: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None, out: tuple[Any, ...] | None = None) -> tuple[Array, ...]:
        """Advances by one time step, as Simulator.step; a batch on all cores."""
    def linearize(self, q: ArrayLike, v: ArrayLike, u: ArrayLike | None = None, *, contact: ArrayLike | None = None) -> _sim.Linearization:
        """Jacobians of the step, as Simulator.linearize, by the library's own code."""
    def rollout(self, q: ArrayLike, v: ArrayLike, steps: int | None = None, *, control: Callable[[int, Array, Array], ArrayLike] | None = None, inputs: ArrayLike | None = None, contact: ArrayLike | None = None, progress: bool | Callable[[int], object] | None = None) -> _sim.Rollout:
        """Takes steps from one state and returns a Rollout, as Simulator.rollout, which also runs batches on vector registers."""
@final
class RecedingHorizon:
    def _solution(self) -> tuple[Any, ...]: ...
    def __new__(cls, problem: _trajopt.Problem, guess: Guess | None = None, **options: Unpack[DdpKeywords]) -> RecedingHorizon: ...
    def control(self, q: ArrayLike, v: ArrayLike, contact: ArrayLike | None = None) -> Array:
        """Input (nu,) for the state (q, v)."""
    def set_costs(self, stage_cost: Iterable[_trajopt.Term], final_cost: Iterable[_trajopt.Term]) -> None:
        """Replaces the costs."""
@final
class Live:
    @property
    def state(self) -> tuple[Array, Array]:
        """The current state: (nq,) and (nv,)."""
    @property
    def url(self) -> str:
        """URL of the page, for browsers of this machine; it contains a secret."""
    def recording(self) -> Recording:
        """The recording since the start or the last reset, with at most 60 times per second."""
    def stop(self) -> None:
        """Ends the simulation; its page reports this."""
    def _repr_html_(self) -> str: ...
@final
class Pictures:
    @property
    def warnings(self) -> list[str]:
        """Remarks on meshes that are not shown as they are."""
    def __new__(cls, recording: Recording, width: int = 640, height: int = 480) -> Pictures: ...
    def of(self, *q: ArrayLike) -> NDArray[np.uint8]:
        """The picture of the robots at configurations q, one of each: (height, width, 3), uint8."""
@final
class Plot:
    def with_size(self, width: int, height: int) -> Plot:
        """The plot with another size, pixels."""
    def to_png(self) -> bytes:
        """The plot as the bytes of a PNG."""
    def save_png(self, path: Path) -> None:
        """Writes the plot as PNG, and creates its folders; an OSError names a file that cannot be written."""
    def _repr_svg_(self) -> str: ...
    def to_svg(self) -> str:
        """The plot as a text of SVG."""
    def save_svg(self, path: Path) -> None:
        """Writes the plot as SVG."""
    def __new__(cls, title: str = "", *, x: str = "", y: str = "", size: tuple[int, int] | None = None, logarithmic: bool = False) -> Plot: ...
    def with_line(self, name: str, x: ArrayLike, y: ArrayLike) -> Plot:
        """The plot with an additional curve through the points (x, y)."""
class Recording:
    @property
    def robots(self) -> list[str]:
        """Names of the robots."""
    @property
    def times(self) -> Array:
        """Recorded times, (n,), s."""
    @property
    def title(self) -> str:
        """Title of the page."""
    @title.setter
    def title(self, title: str) -> None: ...
    def _repr_html_(self) -> str: ...
    def plot(self, *columns: str) -> Plot:
        """Plots columns over time, named as in the table."""
    def phase_plot(self, x: str, y: str) -> Plot:
        """Plots one column over another."""
    def to_html(self) -> str:
        """The page as a text: it works offline, in one file."""
    def save_html(self, path: Path) -> None:
        """Writes the page, which needs nothing else."""
    def to_csv(self) -> str:
        """The table of all columns as a text of CSV: times (s), coordinates, inputs by what they act on ("u.pivot"; "u0", "u1" where that is unknown), series."""
    def save_csv(self, path: Path) -> None:
        """Writes the table of all columns as CSV, as of to_csv."""
    def to_json(self) -> str:
        """The recording as a text of JSON, which `read` reads."""
    def save_json(self, path: Path) -> None:
        """Writes the recording as JSON, which `read` reads."""
    @staticmethod
    def read(path: Path, *models: Model) -> Recording:
        """Reads a recording from a table or a JSON file; the robots are not in it."""
    def show(self, width: str = "100%", height: str = "480") -> _view.Page:
        """The HTML viewer in a frame of given size, for notebooks: width and height as in HTML."""
    def picture(self, time: float, width: int = 640, height: int = 480) -> NDArray[np.uint8]:
        """The picture at a time (s), between moments interpolated: (height, width, 3), uint8."""
    def save_png(self, path: Path, time: float, width: int = 640, height: int = 480) -> None:
        """Writes the picture at a time as PNG, and the folders above it; an OSError names a file that cannot be written."""
    def save_gif(self, path: Path, width: int = 640, height: int = 480, rate: float = 25.0, speed: float = 1.0) -> None:
        """Writes the motion as an animation that repeats, a GIF, and the folders above it; an OSError names a file that cannot be written."""
    def to_gif(self, width: int = 640, height: int = 480, rate: float = 25.0, speed: float = 1.0) -> bytes:
        """The animation of save_gif as bytes: a notebook shows them by IPython.display.Image."""
    @staticmethod
    def from_rollout(model: Model, rollout: _sim.Rollout) -> Recording:
        """The recording of a rollout of one state (of a batch: of rollout[i])."""
    def __len__(self) -> int: ...
    def __new__(cls, *models: Model) -> Self: ...
    @staticmethod
    def of_simulation(simulator: Simulator, rollout: _sim.Rollout) -> Recording:
        """The recording of a rollout with the ground, contacts and constraints of the simulator."""
    def push(self, time: float, *states: tuple[ArrayLike, ...]) -> None:
        """Adds the states of all robots at a time: (q, v) or (q, v, u) of each."""
    def add_series(self, name: str, values: ArrayLike) -> None:
        """Adds a scalar for each time, plotted over time."""
    def spread(self, distance: float) -> None:
        """Places the robots side by side."""
    def show_ground(self, terrain: _contact.Terrain) -> None:
        """Draws a terrain."""
    def trace(self, frame: str, robot: int = 0) -> None:
        """Draws the path of a frame."""
    def show_frame(self, frame: str, robot: int = 0) -> None:
        """Draws the axes of a frame."""
    def add_force(self, frame: str, values: ArrayLike, robot: int = 0) -> None:
        """Draws forces at the origin of a frame, in the world's axes: (len, 3), N."""
    def add_applied_forces(self, simulator: Simulator, robot: int = 0) -> None:
        """Draws the forces that act in a simulator, frame by frame."""
    def place(self, placement: ArrayLike, robot: int = 0) -> None:
        """Displays a robot at another position, by a pose (4, 4) or a translation."""
    def add_shape(self, name: str, shape: _model.Shape, placement: ArrayLike | None = None, color: Sequence[float] = ...) -> None:
        """Adds a fixed shape (Box, Sphere, …)."""
    def add_axes(self, name: str, placement: ArrayLike | None = None) -> None:
        """Adds fixed axes."""
    def set_camera(self, look_at: Sequence[float], distance: float, azimuth: float, elevation: float) -> None:
        """Sets the camera: target point (m), distance (m), azimuth and elevation (degrees)."""
@final
class World:
    @property
    def members(self) -> list[str]:
        """Prefixes of the robots and names of the objects, in their order in the model."""
    def remove(self, member: str) -> None:
        """Removes a robot by its prefix, or an object by its name."""
    def build(self) -> Model:
        """Builds the model."""
    def add_box(self, name: str, size: Sequence[float], **object: Unpack[ObjectKeywords]) -> None:
        """Adds a box with full edge lengths, m."""
    def add_sphere(self, name: str, radius: float, **object: Unpack[ObjectKeywords]) -> None:
        """Adds a ball; radius in m."""
    def add_cylinder(self, name: str, radius: float, length: float, **object: Unpack[ObjectKeywords]) -> None:
        """Adds a cylinder about z; radius and full length in m."""
    def add_capsule(self, name: str, radius: float, length: float, **object: Unpack[ObjectKeywords]) -> None:
        """Adds a capsule about z; radius, and length between the half balls, in m."""
    def __new__(cls, name: str = "world", *, gravity: Sequence[float] | None = None) -> World: ...
    def add(self, model: Model, prefix: str = '', position: Sequence[float] = ..., quaternion: Sequence[float] = ..., on: str | None = None) -> None:
        """Adds a robot with a prefix before all its names, at a pose of its root link in the world; fixed to the frame `on` of another member, if one is given."""
    def add_mesh(self, name: str, path: Path, scale: Sequence[float] = ..., **object: Unpack[ObjectKeywords]) -> None:
        """Adds an object with the shape of a mesh file; an object with mass needs a closed surface."""
