"""The measures of measures.rs on MuJoCo: errors against the time step, as a table.

    python -m venv VENV && VENV/bin/pip install mujoco==4.0.0
    VENV/bin/python benches/peers/measures.py

Cones of friction instead of pyramids, else the defaults, whose reference acceleration and impedance are those of relaxed rigid contact here. MuJoCo has no restitution.
"""

import math

import mujoco
import numpy as np

TIME_STEPS = [0.01, 0.005, 0.002, 0.001, 0.0005]
GRAVITY, FRICTION, SPEED = 9.81, 0.4, 2.0


def model(bodies, dt, integrator, friction):
    return mujoco.MjModel.from_xml_string(f"""<mujoco>
      <option timestep="{dt}" cone="elliptic" integrator="{integrator}"/>
      <default><geom friction="{friction} 0 0" condim="3"/></default>
      <worldbody><geom type="plane" size="0 0 1"/>{bodies}</worldbody></mujoco>""")


def run(m, d, duration, each=lambda: None):
    for _ in range(round(duration / m.opt.timestep)):
        mujoco.mj_step(m, d)
        each()


def body(geom, at):
    return f'<body pos="{at[0]} {at[1]} {at[2]}"><freejoint/><geom {geom}/></body>'


def sliding_box(dt, integrator):
    m = model(body('type="box" size="0.18 0.12 0.06" mass="1"', [0, 0, 0.06]), dt, integrator, FRICTION)
    d = mujoco.MjData(m)
    run(m, d, 0.5)
    start, depth = d.qpos[:2].copy(), [0.0]
    d.qvel[:2] = SPEED / math.sqrt(2)
    run(m, d, 1.0, lambda: depth.append(max([-c.dist for c in d.contact] or [0.0])))
    distance = np.linalg.norm(d.qpos[:2] - start)
    return abs(distance / (SPEED**2 / (2 * FRICTION * GRAVITY)) - 1), 1e3 * max(depth)


def rolling_ball(dt, integrator):
    m = model(body('type="sphere" size="0.1" mass="1"', [0, 0, 0.1]), dt, integrator, FRICTION)
    d = mujoco.MjData(m)
    run(m, d, 0.5)
    d.qvel[0] = SPEED
    run(m, d, 1.0)
    start = d.qpos[0]
    run(m, d, 0.1)
    return abs((d.qpos[0] - start) / 0.1 / (SPEED * 5 / 7) - 1)


def heap(dt, integrator):
    places = [(k, k % 3, k // 3 % 3, k // 9) for k in range(27)]
    at = [[0.21 * x + 1e-3 * (k % 7), 0.21 * y - 1e-3 * (k % 7), 0.21 * z + 0.1] for k, x, y, z in places]
    m = model("".join(body('type="sphere" size="0.1" mass="10"', x) for x in at), dt, integrator, 0)
    d, depths = mujoco.MjData(m), []
    run(m, d, 1.0, lambda: depths.extend(-c.dist / 0.1 for c in d.contact if c.dist < 0))
    return np.mean(depths)


def main():
    print("| measure | integrator |" + "".join(f" {dt * 1e3:g} ms |" for dt in TIME_STEPS))
    print("|---|---|" + "---|" * len(TIME_STEPS))
    measures = {
        "sliding box: stopping distance": lambda *x: sliding_box(*x)[0],
        "sliding box: penetration, mm": lambda *x: sliding_box(*x)[1],
        "rolling ball: speed": rolling_ball,
        "heap of 27 balls: mean penetration, in radii": heap,
    }
    for name, measure in measures.items():
        for integrator in ["Euler", "implicitfast", "RK4"]:
            row = [measure(dt, integrator) for dt in TIME_STEPS]
            print(f"| {name} | {integrator} |" + "".join(f" {x:.1e} |" for x in row))


if __name__ == "__main__":
    main()
