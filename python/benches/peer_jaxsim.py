"""Times of JaxSim's compiled step of the cart-pole and of its `jacfwd`, ns, with their values, as one line of JSON; `table.py` runs it.

Needs the package `jaxsim`. It reads SDF by itself, and URDF by a program of Gazebo's; so the robot of assets/cartpole.urdf stands here once more.
"""

import json
import os

os.environ["JAX_PLATFORMS"] = "cpu"

import jax  # noqa: E402

jax.config.update("jax_enable_x64", True)

import jax.numpy as jnp  # noqa: E402
import jaxsim  # noqa: E402
import jaxsim.api as js  # noqa: E402
from clock import least  # noqa: E402


def link(name: str, mass: float, inertia: tuple[float, float, float], height: float) -> str:
    moments = "".join(f"<i{axis}>{x}</i{axis}>" for axis, x in zip(("xx", "yy", "zz"), inertia, strict=True))
    zeros = "<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz>"
    center = f"<pose>0 0 {height} 0 0 0</pose>"
    body = f"<inertial>{center}<mass>{mass}</mass><inertia>{moments}{zeros}</inertia></inertial>"
    return f'<link name="{name}"><pose>0 0 1.2 0 0 0</pose>{body}</link>'


def joint(name: str, kind: str, parent: str, child: str, axis: str = "") -> str:
    return f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{axis}</joint>'


def axis(direction: str, lower: float, upper: float) -> str:
    return f"<axis><xyz>{direction}</xyz><limit><lower>{lower}</lower><upper>{upper}</upper></limit></axis>"


CARTPOLE = "".join(
    [
        '<sdf version="1.7"><model name="cartpole">',
        link("rail", 5.0, (10.416697916666667, 6.25e-05, 10.416697916666667), 0.0),
        link("cart", 1.0, (0.0035416666666666674, 0.0010416666666666669, 0.0041666666666666675), 0.0),
        link("pole", 0.5, (0.04166979166666667, 0.04166979166666667, 6.25e-06), 0.5),
        joint("world_to_rail", "fixed", "world", "rail"),
        joint("linear", "prismatic", "rail", "cart", axis("0 1 0", -2.4, 2.4)),
        joint("pivot", "revolute", "cart", "pole", axis("1 0 0", -1e16, 1e16)),
        "</model></sdf>",
    ]
)
model = js.model.JaxSimModel.build_from_model_description(CARTPOLE, is_urdf=False, time_step=0.01)


def state(x: jax.Array) -> js.data.JaxSimModelData:
    return js.data.JaxSimModelData.build(model, joint_positions=x[:2], joint_velocities=x[2:])


def advance(data: js.data.JaxSimModelData, u: jax.Array) -> js.data.JaxSimModelData:
    return js.model.step(model, data, joint_force_references=u)


def numbers(x: jax.Array, u: jax.Array) -> jax.Array:
    after = advance(state(x), u)
    return jnp.concatenate([after.joint_positions, after.joint_velocities])


x, u = jnp.array([0.1, 0.2, 0.3, 0.4]), jnp.zeros(2)
data, step = state(x), jax.jit(advance)
slopes = jax.jit(jax.jacfwd(numbers, argnums=(0, 1)))
a, b = slopes(x, u)
found = {
    "version": jaxsim.__version__,
    "next": jax.jit(numbers)(x, u).tolist(),
    "a": a.tolist(),
    "b": b.tolist(),
    "step": least(lambda: jax.block_until_ready(step(data, u)), 1, 2000),
    "jacfwd": least(lambda: jax.block_until_ready(slopes(x, u)), 1, 2000),
}
print(json.dumps(found))
