"""Distances of random shapes that are apart, by this crate and by MuJoCo's `mj_geomDistance`, with both judged where they differ.

    python -m venv VENV && VENV/bin/pip install mujoco==4.0.0
    cargo bench --bench nearest --no-run     # prints the path of the program
    VENV/bin/python benches/peers/nearest.py PROGRAM [PAIRS [SEED]]

PAIRS of each two kinds, `ccd_tolerance` 1e-12 and 1000 iterations. Both get the same numbers: the poses that MuJoCo computed, and of meshes its vertices, which are
of single precision. The distance of points on both shapes is at least theirs: the last columns show by how much the points of each side are not as far apart as it says.
"""

import itertools
import subprocess
import sys

import mujoco
import numpy as np

KINDS = ["sphere", "capsule", "box", "cylinder", "ellipsoid", "hull", "half-space"]
GEOM = {"hull": "mesh", "half-space": "plane"}
# Shapes of each kind, vertices of a hull, and half the width of the space in which they are, m.
SHAPES, VERTICES, SPACE = 40, 12, 1.5
TOLERANCE = 1e-9


def scene(rng):
    """A model with shapes of all kinds at random poses, fixed to the world."""
    assets, geoms = [], []
    for kind in KINDS:
        for k in range(SHAPES):
            size = rng.uniform(0.1, 0.6, 3)
            name = f"{kind} {k}"
            place = f'pos="{numbers(rng.uniform(-SPACE, SPACE, 3))}" quat="{numbers(rng.normal(size=4))}"'
            shape = f'type="{GEOM.get(kind, kind)}" size="{numbers(size)}"'
            if kind == "hull":
                points = rng.uniform(-0.5, 0.5, (VERTICES, 3))
                assets.append(f'<mesh name="{name}" vertex="{numbers(points.ravel())}"/>')
                shape = f'type="mesh" mesh="{name}"'
            geoms.append(f'<geom name="{name}" {shape} {place}/>')
    return f"""<mujoco><option ccd_tolerance="1e-12" ccd_iterations="1000"/><asset>{"".join(assets)}</asset>
        <worldbody>{"".join(geoms)}</worldbody></mujoco>"""


def numbers(values):
    return " ".join(repr(float(x)) for x in values)


def sizes(model, geom, kind):
    """The numbers of a shape of ours."""
    size = model.geom_size[geom]
    if kind == "hull":
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        return model.mesh_vert[first : first + count].astype(float).ravel()
    return size[: {"sphere": 1, "capsule": 2, "cylinder": 2, "half-space": 0}.get(kind, 3)]


def text(model, data, geom, kind):
    own = sizes(model, geom, kind)
    return f"{kind} {len(own)} {numbers([*own, *data.geom_xpos[geom], *data.geom_xmat[geom]])}"


def ours(program, lines):
    answers = subprocess.run([program], input="\n".join(lines), capture_output=True, text=True, check=True)
    return [[float(x) for x in line.split()] for line in answers.stdout.splitlines()]


def lack(points, distance):
    """By how much two points are not as far apart as a distance."""
    return abs(np.linalg.norm(np.subtract(points[3:], points[:3])) - distance)


def compare(program, rng, kinds, count):
    model = mujoco.MjModel.from_xml_string(scene(rng))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    picks = [[KINDS.index(kind) * SHAPES + rng.integers(SHAPES) for kind in kinds] for _ in range(4 * count)]
    picks = [pair for pair in picks if pair[0] != pair[1]]
    lines = [" ".join(text(model, data, geom, kind) for geom, kind in zip(pair, kinds)) for pair in picks]
    errors, fromto = [], np.zeros(6)
    for pair, answer in zip(picks, ours(program, lines)):
        if answer[0] <= 1e-6 or len(errors) == count:
            continue
        theirs = mujoco.mj_geomDistance(model, data, *pair, 1e3, fromto)
        more = theirs - answer[0]
        errors.append([abs(more), more, lack(answer[1:7], answer[0]), lack(fromto, theirs)])
    return np.array(errors)


def main():
    program, count, seed = sys.argv[1], int((sys.argv[2:] or [1000])[0]), int((sys.argv[3:] or [1])[0])
    rng = np.random.default_rng(seed)
    print(f"{'shapes':<24}{'pairs':>8}{'worst':>10}{'median':>10}{'> 1e-9':>8}{'theirs > ours':>15}{'their points':>14}{'our points':>12}")
    for kinds in itertools.combinations_with_replacement(KINDS, 2):
        if kinds == ("half-space", "half-space"):
            continue
        found = compare(program, rng, kinds, count)
        far = found[:, 0] > TOLERANCE
        above = (far & (found[:, 1] > 0)).sum()
        row = [found[:, 0].max(), np.median(found[:, 0])]
        name = "–".join(kinds)
        print(f"{name:<24}{len(found):>8}{row[0]:>10.1e}{row[1]:>10.1e}{far.sum():>8}{above:>15}{found[:, 3].max():>14.1e}{found[:, 2].max():>12.1e}", flush=True)


if __name__ == "__main__":
    main()
