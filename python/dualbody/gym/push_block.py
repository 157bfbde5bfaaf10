"""A finger that pushes a block to a goal."""

from __future__ import annotations

import numpy as np

from .._dualbody import World
from ..contact import Collisions, Contacts, RelaxedRigid, Terrain
from ..model import JointSpec, LinkSpec, Model, ModelBuilder
from ..sim import Simulator
from .task import Array, Flags, Task

#: Half width of the block, its height, radius of the finger, distance from the goal that is near enough, reach of the finger, m
HALF, HEIGHT, RADIUS, NEAR, REACH = 0.05, 0.06, 0.02, 0.03, 0.5


def _finger() -> Model:
    """A ball on two rails, along x and y."""
    builder = ModelBuilder("finger")
    builder.add_link(LinkSpec("world"))
    builder.add_link(LinkSpec("rail", 0.1, inertia=((1e-4, 0.0, 0.0), (0.0, 1e-4, 0.0), (0.0, 0.0, 1e-4))))
    builder.add_link(LinkSpec.solid_sphere("tip", RADIUS, 0.2))
    builder.add_joint(JointSpec("x", "prismatic", "world", "rail", (0.0, 0.0, HEIGHT / 2), (1.0, 0.0, 0.0), damping=2.0))
    builder.add_joint(JointSpec("y", "prismatic", "rail", "tip", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), damping=2.0))
    return builder.build()


def push_block() -> Task:
    """A finger pushes a block over the ground to the origin: less than 0.03 m from there one point a step, elsewhere less, the farther away the block is.

    Inputs are the forces on the finger along x and y, within ±5 N. The observation contains position, orientation (unit quaternion) and velocity of the
    block, position and velocity of the finger, and the vector from finger to block. The episode ends when the block or the finger is farther away than 0.5
    m.
    """
    world = World("push block")
    world.add(_finger(), prefix="finger/")
    world.add_box("block", (2 * HALF, 2 * HALF, HEIGHT), mass=0.3, position=(0.0, 0.0, HEIGHT / 2))
    model = world.build()
    law = RelaxedRigid(friction=0.4)
    simulator = Simulator(model, time_step=5e-3, contacts=Contacts(Terrain.flat(), law, collisions=Collisions()), actuated=["finger/x", "finger/y"])
    neutral = model.neutral()
    (block_q, block_v), (x_q, x_v), (y_q, y_v) = (
        (model.joint_q(name).start, model.joint_v(name).start) for name in ("block", "finger/x", "finger/y")
    )

    def start(generator: np.random.Generator) -> tuple[Array, Array]:
        q = neutral.copy()
        angle, turn, side = generator.uniform(-np.pi, np.pi, 3)
        block = generator.uniform(0.1, 0.25) * np.array([np.cos(angle), np.sin(angle)])
        q[block_q : block_q + 2] = block
        # About z; the block is a square.
        q[block_q + 3], q[block_q + 6] = np.cos(turn / 8), np.sin(turn / 8)
        # Anywhere around the block, clear of it.
        q[[x_q, y_q]] = block + (1.5 * HALF + RADIUS + 0.03) * np.array([np.cos(side), np.sin(side)])
        return q, np.zeros(model.nv)

    def observe(q: Array, v: Array) -> Array:
        block, finger = q[:, block_q : block_q + 7], q[:, [x_q, y_q]]
        moving = [v[:, block_v : block_v + 6], v[:, [x_v, y_v]]]
        return np.concatenate([block, finger, block[:, :2] - finger, *moving], axis=1)

    def away(q: Array) -> Array:
        return np.hypot(q[:, block_q], q[:, block_q + 1])

    def reward(q: Array, v: Array, u: Array) -> Array:
        distance = away(q)
        return np.where(distance < NEAR, 1.0, -distance) - 1e-3 * np.square(u).sum(axis=1)

    def is_over(q: Array, v: Array) -> Flags:
        return (away(q) > REACH) | (np.hypot(q[:, x_q], q[:, y_q]) > REACH)

    return Task(
        simulator, start, observe=observe, reward=reward, is_over=is_over, max_steps=200, steps_per_action=5, bounds=([-5.0, -5.0], [5.0, 5.0])
    )
