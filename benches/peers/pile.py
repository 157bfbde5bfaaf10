"""A pile of boxes and spheres in a bin beside MuJoCo: times of a step on one core, in turn.

    python -m venv VENV && VENV/bin/pip install mujoco==4.0.0
    cargo bench --bench pile --no-run                          # prints the path of the program
    taskset -c 0 VENV/bin/python benches/peers/pile.py PROGRAM [BODIES [REPETITIONS]]

Both sides drop the same bodies, 0.2 m large, into a bin and take steps of 2 ms with friction 0.5. Regularised contact of this crate has the reference
acceleration and impedance of MuJoCo; rigid contact has no peer there. MuJoCo has its defaults: Newton's method to 1e-8 from its last solution, once with
its pyramids of friction, once with cones, which this crate has. Ours goes to 1e-12, from nothing in each step. The bodies tumble, so positions part after the
first impacts; what is compared is the mean time of all steps, and of the last ones, in which they lie.
"""

import statistics
import subprocess
import sys
import time

import mujoco

STEPS, LAST, TIME_STEP = 1000, 250, 0.002
HALF, BIN, HEIGHT, WALL, FRICTION = 0.1, 0.6, 1.0, 0.1, 0.5


def model(program, bodies, cone):
    scene = subprocess.run([program, "scene", str(bodies)], check=True, capture_output=True, text=True).stdout
    out, long = BIN + WALL / 2, BIN + WALL
    walls = [(-out, 0, WALL / 2, long), (out, 0, WALL / 2, long), (0, -out, long, WALL / 2), (0, out, long, WALL / 2)]
    geoms = [f'<geom type="box" pos="{x} {y} {HEIGHT / 2}" size="{w} {d} {HEIGHT / 2}"/>' for x, y, w, d in walls]
    for line in scene.splitlines():
        kind, *at = line.split()
        size = f"{HALF} {HALF} {HALF}" if kind == "box" else f"{HALF}"
        geom = f'<geom type="{kind}" size="{size}" mass="1"/>'
        geoms.append(f'<body pos="{" ".join(at)}"><freejoint/>{geom}</body>')
    return mujoco.MjModel.from_xml_string(f"""<mujoco>
      <option timestep="{TIME_STEP}" cone="{cone}"/>
      <size memory="200M"/>
      <default><geom friction="{FRICTION} 0.005 0.0001" condim="3"/></default>
      <worldbody><geom type="plane" size="0 0 1"/>{"".join(geoms)}</worldbody>
    </mujoco>""")


def peer(model):
    """ms a step, of all and of the last ones; points and iterations at the end."""
    data = mujoco.MjData(model)
    times = []
    for _ in range(STEPS):
        begin = time.perf_counter()
        mujoco.mj_step(model, data)
        times.append(1e3 * (time.perf_counter() - begin))
    return {"all": statistics.mean(times), "last": statistics.mean(times[-LAST:]), "points": data.ncon}


def ours(program, bodies, law):
    arguments = [program, "times", str(bodies), law, str(STEPS), str(LAST)]
    text = subprocess.run(arguments, check=True, capture_output=True, text=True).stdout
    return dict(line.split() for line in text.splitlines())


def main():
    program = sys.argv[1]
    bodies, repetitions = (int(x) for x in [*sys.argv[2:], 100, 3][:2]) if len(sys.argv) < 4 else map(int, sys.argv[2:4])
    peers = {cone: model(program, bodies, cone) for cone in ["pyramidal", "elliptic"]}
    rounds = []
    for _ in range(repetitions):
        theirs = {cone: peer(model) for cone, model in peers.items()}
        rounds.append((theirs, {law: ours(program, bodies, law) for law in ["relaxed", "rigid"]}))
    for law in ["relaxed", "rigid"]:
        own = rounds[-1][1][law]
        print(f"{law}: {own['points']} points at the end, status {own['status']}, speed {own['speed']}")
    for cone in peers:
        for part in ["all", "last"]:
            theirs = statistics.median(r[0][cone][part] for r in rounds)
            for law in ["relaxed", "rigid"]:
                own = statistics.median(float(r[1][law][part]) for r in rounds)
                ratio = statistics.median(float(r[1][law][part]) / r[0][cone][part] for r in rounds)
                print(f"{law:8} {part:5} {own:7.2f} ms, MuJoCo {cone:9} {theirs:7.2f} ms, ratio {ratio:.2f}")


main()
