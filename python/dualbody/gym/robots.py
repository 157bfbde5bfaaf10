"""Tasks that come with the library."""

from __future__ import annotations

import numpy as np

from .. import samples
from ..contact import Contacts, Rigid, Terrain
from ..model import Box, JointSpec, Limits, LinkSpec, Model, ModelBuilder, Sphere
from ..sim import Simulator
from .draws import Draws
from .task import Array, Balance, Task


def cartpole() -> Balance:
    """A pole is balanced by pushing its cart: one point for each of 500 steps in which the cart is within 2.4 m and the pole within 12°."""
    simulator = Simulator(samples.cartpole(), time_step=0.02, actuated=["linear"])
    start, within = np.full(4, 0.05), np.array([2.4, np.radians(12), np.inf, np.inf])
    return Balance(simulator, (-start, start), (-within, within), max_steps=500, bounds=([-10.0], [10.0]))


def quadruped_model() -> Model:
    """A quadruped of 12 kg: a trunk, and four legs of three hinges with balls as feet."""
    builder = ModelBuilder("quadruped", base="floating")
    builder.add_link(LinkSpec.solid_box("trunk", (0.4, 0.2, 0.1), 8.0))
    for name, x, y in (("lf", 0.19, 0.1), ("rf", 0.19, -0.1), ("lh", -0.19, 0.1), ("rh", -0.19, -0.1)):
        side = 1.0 if y > 0 else -1.0
        rod = ((2e-3, 0.0, 0.0), (0.0, 2e-3, 0.0), (0.0, 0.0, 4e-4))
        middle = Box((0.03, 0.03, 0.2), placement=(0.0, 0.0, -0.1))
        builder.add_link(LinkSpec(f"{name}_hip", 0.4, inertia=((5e-4, 0.0, 0.0), (0.0, 5e-4, 0.0), (0.0, 0.0, 5e-4))))
        builder.add_link(LinkSpec(f"{name}_thigh", 0.4, (0.0, 0.0, -0.1), rod, [middle]))
        foot = Sphere(0.02, placement=(0.0, 0.0, -0.2))
        builder.add_link(LinkSpec(f"{name}_shank", 0.2, (0.0, 0.0, -0.1), rod, [middle, foot], [foot]))
        limits = Limits(effort=25.0, velocity=20.0)
        joints = (
            ("abduction", "trunk", f"{name}_hip", (x, y, 0.0), (1.0, 0.0, 0.0)),
            ("hip", f"{name}_hip", f"{name}_thigh", (0.0, 0.05 * side, 0.0), (0.0, 1.0, 0.0)),
            ("knee", f"{name}_thigh", f"{name}_shank", (0.0, 0.0, -0.2), (0.0, 1.0, 0.0)),
        )
        for joint, parent, child, placement, axis in joints:
            builder.add_joint(
                JointSpec(
                    f"{name}_{joint}", "revolute", parent, child, placement, axis, limits, damping=0.1, armature=0.01
                )
            )
    return builder.build()


def quadruped() -> Task:
    """A quadruped walks: the reward is the speed along x minus the effort; the episode ends when the trunk falls or tips. Inputs are torques within ±25 N·m."""
    model = quadruped_model()
    contacts = Contacts(Terrain.flat(), Rigid(friction=0.8))
    simulator = Simulator(model, time_step=4e-3, contacts=contacts)
    stand = model.neutral()
    stand[2] = 0.345
    stand[7:] = np.tile([0.0, 0.6, -1.2], 4)

    def start(generator: np.random.Generator) -> tuple[Array, Array]:
        q = stand.copy()
        q[7:] += generator.uniform(-0.05, 0.05, 12)
        return q, generator.uniform(-0.05, 0.05, model.nv)

    def starts(draws: Draws) -> tuple[Array, Array]:
        q = np.tile(stand, (len(draws), 1))
        q[:, 7:] += draws.uniform(-0.05, 0.05, 12)
        return q, draws.uniform(-0.05, 0.05, model.nv)

    def up(q: Array) -> Array:
        x, y = q[:, 4], q[:, 5]
        return 1.0 - 2.0 * (x * x + y * y)

    return Task(
        simulator,
        start,
        observe=lambda q, v: np.concatenate([q[:, 2:], v], axis=1),
        reward=lambda q, v, u: v[:, 0] - 1e-3 * np.square(u).sum(axis=1) + 0.5,
        is_over=lambda q, v: (q[:, 2] < 0.18) | (up(q) < 0.5),
        max_steps=500,
        steps_per_action=5,
        starts=starts,
    )
