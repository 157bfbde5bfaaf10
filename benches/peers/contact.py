"""Regularised contact of this crate compared with MuJoCo, whose reference acceleration and impedance it has: motions, and times.

    python -m venv VENV && VENV/bin/pip install mujoco==4.0.0
    cargo bench --bench contact --no-run                       # prints the path of the program
    taskset -c 0 VENV/bin/python benches/peers/contact.py PROGRAM [REPETITIONS]

A ball that is thrown with a spin, a tilted box with a spin and a quadruped that lands on its feet with springs in its joints, one
second each in steps of a millisecond: same models (in the MJCF that this crate writes), semi-implicit Euler, elliptic cones, friction,
`solref`, `solimp`, `impratio` 1. Two differences are known, and each is taken away in turn:

- MuJoCo puts a contact midway between the surfaces, this crate at the lowest point of the body: "point" moves it there. A ball that
  rolls feels it as another radius;
- MuJoCo makes R of a diagonal that it estimates once for each body, in the pose in which the robot was built; this crate takes the
  true one of J M⁻¹ Jᵀ along the normal: "diagonal" takes that in MuJoCo too. Along the normal of a ball the estimate is right. R is
  proportional to (1 − d) / d: this difference goes as d goes to 1, which the last lines of each robot show.

What is left must be below the tolerances, or this fails: roundings, and where the two solvers stop. Both drop J̇ v. The columns are
the largest differences of position, orientation, joints and velocity; velocities differ most during impacts.

Times: the quadruped standing on four feet, a step and its Jacobians (there by one-sided finite differences); medians, in turn. Their
solver starts from its last solution, and has nothing to do at rest; ours starts anew each time.
"""

import statistics
import subprocess
import sys
import time

import mujoco
import numpy as np

STEPS, TIME_STEP = 1000, 1e-3
# As in contact.rs.
FRICTION, FEET = 0.6, ["FR_foot", "FL_foot", "RR_foot", "RL_foot"]
STEPS_TO_REST = 5000
# d at the surface and from a millisecond on: the defaults of both.
IMPEDANCE = (0.9, 0.95)
ROBOTS = ["ball", "box", "quadruped"]
# What may be left where both differences are taken away: m, rad, rad, m/s or rad/s. A hundred times what was.
TOLERANCE = [1e-9, 1e-8, 1e-9, 1e-6]
ROUNDS, CALLS, DIFFERENCE = 15, 200, 1e-6


def load(program, robot, impedance):
    mjcf = subprocess.run([program, "mjcf", robot], check=True, capture_output=True, text=True).stdout
    spec = mujoco.MjSpec.from_string(mjcf)
    surface = {"friction": [FRICTION, 0, 0], "solref": [0.02, 1], "solimp": [*impedance, 1e-3, 0.5, 2], "condim": 3}
    for body in spec.bodies:
        for geom in body.geoms:
            touches = geom.group == 3 and (robot != "quadruped" or body.name in FEET)
            if touches:
                geom.contype = 1
                for name, value in surface.items():
                    setattr(geom, name, value)
    plane = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], contype=0, conaffinity=1)
    for name, value in surface.items():
        setattr(plane, name, value)
    model = spec.compile()
    disable = mujoco.mjtDisableBit
    # Damping is explicit in dualbody, and without actuation it has no limits and no dry friction.
    model.opt.disableflags |= disable.mjDSBL_EULERDAMP | disable.mjDSBL_LIMIT | disable.mjDSBL_FRICTIONLOSS
    model.opt.timestep = TIME_STEP
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    return model


def turned(q):
    out = np.zeros(9)
    mujoco.mju_quat2Mat(out, q[3:7])
    return out.reshape(3, 3)


def put(data, nq, row):
    """A state of ours: there the linear velocity of the base is in the base."""
    data.qpos[:], data.qvel[:] = row[:nq], row[nq:]
    data.qvel[:3] = turned(data.qpos) @ row[nq : nq + 3]


def step(model, data, changes):
    """mj_step in its parts, with what is changed between them."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_makeM(model, data)
    mujoco.mj_factorM(model, data)
    mujoco.mj_collision(model, data)
    if "point" in changes:
        for contact in data.contact:
            contact.pos += 0.5 * contact.dist * contact.frame[:3]
    mujoco.mj_makeConstraint(model, data)
    if "diagonal" in changes and data.nefc:
        jacobian = data.efc_J.reshape(data.nefc, model.nv)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        diagonal = np.einsum("ij,ji->i", jacobian, np.linalg.solve(mass, jacobian.T))
        impedance = data.efc_KBIP[:, 2]
        for normal in range(0, data.nefc, 3):
            r = (1 - impedance[normal]) / impedance[normal] * diagonal[normal]
            data.efc_R[normal : normal + 3], data.efc_D[normal : normal + 3] = r, 1 / r
    mujoco.mj_projectConstraint(model, data)
    mujoco.mj_transmission(model, data)
    mujoco.mj_fwdVelocity(model, data)
    mujoco.mj_fwdActuation(model, data)
    mujoco.mj_fwdAcceleration(model, data)
    mujoco.mj_fwdConstraint(model, data)
    mujoco.mj_Euler(model, data)


def motion(program, robot, impedance):
    words = [program, "motion", robot, STEPS, TIME_STEP, *impedance]
    text = subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True).stdout
    return np.array([[float(x) for x in line.split()] for line in text.splitlines()])


def differences(model, ours, changes):
    """Largest over the motion: position, rotation, joints, velocity."""
    data, nq = mujoco.MjData(model), model.nq
    put(data, nq, ours[0])
    worst = np.zeros(4)
    for row in ours[1:]:
        if changes is None:
            mujoco.mj_step(model, data)
        else:
            step(model, data, changes)
        apart = np.zeros(model.nv)
        mujoco.mj_differentiatePos(model, apart, 1, row[:nq], data.qpos)
        velocity = row[nq:].copy()
        velocity[:3] = turned(row) @ velocity[:3]
        joints = np.abs(apart[6:]).max(initial=0)
        now = [np.linalg.norm(apart[:3]), np.linalg.norm(apart[3:6]), joints, np.abs(data.qvel - velocity).max()]
        worst = np.maximum(worst, now)
    return worst


def compare_motions(program):
    print("largest differences over a second: m, rad, rad (joints), m/s or rad/s")
    variants = [("as it is", None), ("in parts", []), ("point", ["point"]), ("point and diagonal", ["point", "diagonal"])]
    for robot in ROBOTS:
        model = load(program, robot, IMPEDANCE)
        model.opt.tolerance, model.opt.iterations = 1e-15, 200
        ours = motion(program, robot, IMPEDANCE)
        for name, changes in variants:
            worst = differences(model, ours, changes)
            print(f"{robot:10} {name:20}", " ".join(f"{x:8.1e}" for x in worst))
        if (worst > TOLERANCE).any():
            sys.exit(f"{robot}: the motions differ by more than {TOLERANCE}")
        for d in [0.99, 0.999]:
            stiff = load(program, robot, (d, d))
            stiff.opt.tolerance, stiff.opt.iterations = 1e-15, 200
            worst = differences(stiff, motion(program, robot, (d, d)), ["point"])
            print(f"{robot:10} {f'point, d = {d}':20}", " ".join(f"{x:8.1e}" for x in worst))


def peer_times(model, data):
    """Medians over rounds, µs."""
    a, b = np.zeros((2 * model.nv, 2 * model.nv)), np.zeros((2 * model.nv, model.nu))
    steps, jacobians = [], []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        mujoco.mj_step(model, data, CALLS)
        steps.append((time.perf_counter() - begin) / CALLS)
        begin = time.perf_counter()
        for _ in range(10):
            mujoco.mjd_transitionFD(model, data, DIFFERENCE, 0, a, b, None, None)
        jacobians.append((time.perf_counter() - begin) / 10)
    return {"step": 1e6 * statistics.median(steps), "linearize": 1e6 * statistics.median(jacobians)}


def compare_times(program, repetitions):
    model = load(program, "quadruped", IMPEDANCE)
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_AUTO
    data = mujoco.MjData(model)
    put(data, model.nq, motion(program, "quadruped", IMPEDANCE)[0])
    mujoco.mj_step(model, data, STEPS_TO_REST)
    print(f"times, standing: {data.ncon} contacts, {data.solver_niter[0]} iterations, {np.abs(data.qvel).max():.1e} from rest")
    rounds = []
    for _ in range(repetitions):
        text = subprocess.run([program, "times", "quadruped"], check=True, capture_output=True, text=True).stdout
        ours = {name: float(value) for name, value in (line.split() for line in text.splitlines())}
        assert ours["touching"] == data.ncon == 4
        rounds.append((ours, peer_times(model, data)))
    for name in ["step", "linearize"]:
        a, b = (statistics.median(r[i][name] for r in rounds) for i in [0, 1])
        ratio = statistics.median(ours[name] / theirs[name] for ours, theirs in rounds)
        print(f"{name:10} {a:8.2f} µs, MuJoCo {b:8.2f} µs, ratio {ratio:.2f}")


def main():
    program = sys.argv[1]
    repetitions = int(sys.argv[2]) if len(sys.argv) > 2 else 9
    compare_motions(program)
    compare_times(program, repetitions)


main()
