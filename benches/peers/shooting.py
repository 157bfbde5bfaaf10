"""Identification through the simulator beside MuJoCo's toolbox `mujoco.sysid`: the same log, shots and parameters.

    python -m venv VENV && VENV/bin/pip install "mujoco[sysid]==4.0.0"
    cargo bench --features full --bench shooting --no-run                      # prints the path of the program
    VENV/bin/python benches/peers/shooting.py PROGRAM [REPETITIONS]

A UR5 follows sines under a PD controller for two seconds, simulated by MuJoCo in steps of a millisecond (semi-implicit Euler, dampers
with the forces of the end of the step, as ours); positions and velocities get errors. Unknown are damping and armature of each joint and the ten numbers of the forearm's
inertia, 22 in all, as a pseudo-inertia with them and as standard parameters with us. Both compare states after each step with the
log, weighted by the deviations of its errors, in shots of 100 steps from measured states. Theirs differentiates by finite differences on
all cores, ours exactly, on all cores too. Reported are time, the deviation of the residuals (one, where all that is left is the errors), and the
largest error of damping and armature beside the true ones; medians.
"""

import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import mujoco
import numpy as np
from mujoco import sysid

STEPS, SHOT, TIME_STEP = 2000, 100, 1e-3
# As in shooting.rs.
LINK, DEVIATIONS = "forearm_link", (1e-4, 1e-3)
# Of the true robot beside the nominal one.
MASS, LARGEST = 1.4, 3.0


def nominal(program):
    text = subprocess.run([program, "mjcf"], check=True, capture_output=True, text=True).stdout
    spec = mujoco.MjSpec.from_string(text)
    disable = mujoco.mjtDisableBit
    spec.option.disableflags |= disable.mjDSBL_LIMIT
    spec.option.disableflags |= disable.mjDSBL_FRICTIONLOSS | disable.mjDSBL_CONTACT
    spec.option.timestep, spec.option.integrator = TIME_STEP, mujoco.mjtIntegrator.mjINT_EULER
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    for joint in spec.joints:
        motor = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_motor()
    return spec


def log(spec, rng):
    """The true numbers of joints, then q, v and u of each sample."""
    spec = spec.copy()
    numbers = []
    for joint in spec.joints:
        joint.damping[0] *= rng.uniform(0.4, LARGEST / 2)
        joint.armature *= rng.uniform(0.4, LARGEST / 2)
        numbers.append((joint.damping[0], joint.armature))
    body = spec.body(LINK)
    body.mass *= MASS
    body.fullinertia *= MASS
    body.inertia *= MASS
    model = spec.compile()
    data = mujoco.MjData(model)
    phases, speeds = rng.uniform(0, 6, model.nv), rng.uniform(3, 8, model.nv)
    rows = []
    for k in range(STEPS + 1):
        wanted = 0.8 * np.sin(speeds * k * TIME_STEP + phases)
        data.ctrl[:] = 200 * (wanted - data.qpos) - 10 * data.qvel
        rows.append(np.concatenate([data.qpos, data.qvel, data.ctrl]))
        mujoco.mj_step(model, data)
    rows = np.array(rows)
    n = model.nv
    rows[:, :n] += DEVIATIONS[0] * rng.standard_normal((STEPS + 1, n))
    rows[:, n : 2 * n] += DEVIATIONS[1] * rng.standard_normal((STEPS + 1, n))
    return np.array(numbers).T.ravel(), rows


def joint_parameter(name, attribute):
    def modify(spec, parameter):
        joint, value = spec.joint(name), parameter.value[0]
        if attribute == "damping":
            joint.damping[0] = value
        else:
            joint.armature = value

    return modify


def set_inertia(spec, parameter):
    sysid.apply_body_inertia(spec, LINK, parameter)
    # The toolbox of 4.0.0 leaves the turn undefined, and then the compiler refuses the full inertia.
    spec.body(LINK).iquat = [1, 0, 0, 0]


def parameters(spec):
    out = sysid.ParameterDict()
    for attribute in ["damping", "armature"]:
        for joint in spec.joints:
            value = joint.damping[0] if attribute == "damping" else joint.armature
            modify = joint_parameter(joint.name, attribute)
            out.add(sysid.Parameter(f"{joint.name}: {attribute}", value, 0.0, 10 * value, modifier=modify))
    model = spec.compile()
    kind = sysid.InertiaType.Pseudo
    out.add(sysid.body_inertia_param(spec, model, LINK, kind, modifier=set_inertia))
    return out


def residuals(rows, n):
    """Errors of the states after each step of a shot, which knows its place by its time, in the unit of positions; those of velocities by their weight.

    Not by the deviations themselves: the damping of the toolbox's method has a largest value, which is too small for residuals so large.
    """

    def compare(params, predicted, measured, model, return_all, state, sensor_weights=None):
        first = round(measured.times[0] / TIME_STEP)
        log = rows[first + 1 : first + 1 + len(state)]
        own = state[:, 1 : 1 + 2 * n]
        scale = np.repeat(DEVIATIONS, n) / DEVIATIONS[0]
        return (log[:, : 2 * n] - own) / scale, measured, measured

    return compare


def theirs(spec, rows):
    model = spec.compile()
    n = model.nv
    times = np.arange(STEPS + 1) * TIME_STEP
    shots = []
    for first in range(0, STEPS, SHOT):
        part = slice(first, first + SHOT + 1)
        start = sysid.create_initial_state(model, rows[first, :n], rows[first, n : 2 * n])
        control = sysid.TimeSeries.from_control_names(times[part], rows[part, 2 * n :], model)
        sensors = sysid.TimeSeries(times[part], np.zeros((SHOT + 1, 0)))
        shots.append(sysid.SystemTrajectory(model, control, sensors, start, None))
    sequences = sysid.ModelSequences("ur5", spec, "log", [s.initial_state for s in shots], [s.control for s in shots], [s.sensordata for s in shots])
    residual = sysid.build_residual_fn(
        models_sequences=[sequences], modify_residual=residuals(rows, n), resample_true=False
    )
    start = time.perf_counter()
    found, result = sysid.optimize(parameters(spec), residual, verbose=False)
    seconds = time.perf_counter() - start
    errors = np.concatenate(residual(result.x, found)[0]) / DEVIATIONS[0]
    deviation = np.sqrt(errors @ errors / (errors.size - result.x.size))
    return seconds, deviation, result.x[: 2 * n]


def ours(program, rows):
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "log.txt"
        np.savetxt(file, rows, fmt="%.17g")
        words = [program, "fit", str(file), str(SHOT)]
        text = subprocess.run(words, check=True, capture_output=True, text=True).stdout
    first, values = text.splitlines()
    seconds, deviation = (float(x) for x in first.split()[:2])
    return seconds, deviation, np.array([float(x) for x in values.split()])


def main(program, repetitions=3):
    spec = nominal(program)
    truth, rows = log(spec, np.random.default_rng(1))
    seconds = {"ours": [], "theirs": []}
    for _ in range(repetitions):
        for name, found in [("ours", ours(program, rows)), ("theirs", theirs(spec, rows))]:
            seconds[name].append(found[0])
            worst = np.abs(found[2][: truth.size] / truth - 1).max()
            print(f"{name}: {found[0]:.3f} s, deviation {found[1]:.4f}, largest error {worst:.1e}")
    a, b = (statistics.median(seconds[name]) for name in ["ours", "theirs"])
    print(f"median {a:.3f} s and {b:.3f} s: {b / a:.0f} times faster")


if __name__ == "__main__":
    main(sys.argv[1], *(int(x) for x in sys.argv[2:]))
