"""Scenes in contact in this crate and in MuJoCo, which read the same MJCF: steps, Jacobians, batches, loading, dry friction.

    python -m venv VENV && VENV/bin/pip install mujoco==4.0.0 gymnasium==1.4.0
    cargo bench --bench scenes --no-run     # prints the path of the program
    VENV/bin/python benches/peers/scenes.py PROGRAM FOLDER [REPETITIONS]

- humanoid: that of Gymnasium, capsules and spheres that touch the floor and one another. It falls under sines of its motors and ends up on the floor, three
  seconds in steps of 3 ms; the Jacobians are taken at every twentieth state;
- gripper: two fingers hold a box of half a kilogram, a position servo lifts it, steps of 2 ms. As one, and as a batch of 1024 on two threads;
- quadruped: it stands on four feet under position servos whose targets move, with gyroscope, accelerometer and orientation of the trunk, steps of 1 ms. As
  one, and as a batch of 1024 on two threads;
- flight: the humanoid without weight and without input, nothing touches; with its geoms, and with all that could touch taken away;
- dry friction: arm, quadruped and humanoid of `assets/` in free motion, without dry friction, with so little in every joint that all slide, and with so much
  that all stick.

Both sides go their own ways from the same start with the same controls. MuJoCo has Euler's method, elliptic cones and its Newton solver; its C++ `rollout` runs
the steps, its solver starts from its last solution. Its Jacobians are one-sided finite differences. Batches keep all states and readings. Programs run in turn;
the ratios are medians of ratios, below 1 ours is faster (for rates of batches: above 1).
"""

import math
import os
import pathlib
import subprocess
import sys
import time
from statistics import median

import mujoco
from mujoco import rollout
import numpy as np

# What they share with contact.rs and scenes.rs.
FEET, CROUCH, EVERY, SPREAD = ["FR_foot", "FL_foot", "RR_foot", "RL_foot"], [0.0, 0.8, -1.6], 20, 0.01
STATES, THREADS, ROUNDS, BATCH_STEPS = 1024, 2, 9, 50
# N·m or N: all joints slide, all stick.
FRICTION = [0.002, 0.5]
FULL = mujoco.mjtState.mjSTATE_FULLPHYSICS

GRIPPER = """<mujoco model="gripper">
  <compiler autolimits="true"/>
  <option timestep="0.002" cone="elliptic"/>
  <default><geom condim="3" friction="0.8 0.005 0.0001"/></default>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <body name="palm" pos="0 0 0.12">
      <joint name="lift" type="slide" axis="0 0 1" damping="5"/>
      <geom type="box" size="0.1 0.03 0.015" mass="1"/>
      <body name="left" pos="-0.04 0 -0.06">
        <joint name="close left" type="slide" axis="1 0 0" damping="5"/>
        <geom type="box" size="0.01 0.025 0.04" mass="0.1"/>
      </body>
      <body name="right" pos="0.04 0 -0.06">
        <joint name="close right" type="slide" axis="-1 0 0" damping="5"/>
        <geom type="box" size="0.01 0.025 0.04" mass="0.1"/>
      </body>
    </body>
    <body name="box" pos="0 0 0.03">
      <freejoint name="box"/>
      <geom type="box" size="0.03 0.03 0.03" mass="0.5"/>
    </body>
  </worldbody>
  <actuator>
    <position name="lift" joint="lift" kp="2000" kv="100"/>
    <motor name="close left" joint="close left"/>
    <motor name="close right" joint="close right"/>
  </actuator>
  <keyframe><key name="start" qpos="0 0 0 0 0 0.03 1 0 0 0"/></keyframe>
</mujoco>
"""


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} failed:\n{done.stderr}")
    return {name: float(value) for name, value in (line.split() for line in done.stdout.splitlines())}


class Scene:
    """A file, and the controls of each step."""

    def __init__(self, name, xml, steps, control, folder):
        self.name, self.file, self.controls_file = name, folder / f"{name}.xml", folder / f"{name}.controls"
        self.file.write_text(xml)
        self.model = mujoco.MjModel.from_xml_path(str(self.file))
        self.controls = np.array([control(k, self.model) for k in range(steps)])
        np.savetxt(self.controls_file, self.controls, fmt="%.9f")
        self.few_file = folder / f"{name}.few"
        np.savetxt(self.few_file, self.controls[:BATCH_STEPS], fmt="%.9f")
        self.data = [mujoco.MjData(self.model) for _ in range(THREADS)]

    def start(self):
        data = self.data[0]
        mujoco.mj_resetData(self.model, data)
        if self.model.nkey:
            mujoco.mj_resetDataKeyframe(self.model, data, 0)

    def state(self):
        out = np.zeros(mujoco.mj_stateSize(self.model, FULL))
        mujoco.mj_getState(self.model, self.data[0], out, FULL)
        return out

    def times(self):
        """As `scenes times` prints them, µs: of each call the median over the rounds, which leaves out interruptions, then the mean."""
        model, data, n = self.model, self.data[0], 2 * self.model.nv + self.model.na
        a, b, force = np.zeros((n, n)), np.zeros((n, model.nu)), np.zeros(6)
        steps, jacobians, touching = np.zeros((9, len(self.controls))), np.zeros((3, len(self.controls[::EVERY]))), []
        for times in steps:
            self.start()
            for k, control in enumerate(self.controls):
                data.ctrl[:] = control
                begin = time.perf_counter()
                mujoco.mj_step(model, data)
                times[k] = time.perf_counter() - begin
        for times in jacobians:
            self.start()
            for k, control in enumerate(self.controls):
                data.ctrl[:] = control
                if k % EVERY == 0:
                    mujoco.mj_forward(model, data)
                    touching.append(sum(self.presses(i, force) for i in range(data.ncon)))
                    begin = time.thread_time()
                    mujoco.mjd_transitionFD(model, data, 1e-6, 0, a, b, None, None)
                    times[k // EVERY] = time.thread_time() - begin
                mujoco.mj_step(model, data)
        means = [1e6 * np.median(times, axis=0).mean() for times in [steps, jacobians]]
        return {"step": means[0], "linearize": means[1], "touching": np.mean(touching)}

    def presses(self, contact, force):
        mujoco.mj_contactForce(self.model, self.data[0], contact, force)
        return force[0] > 0

    def rate(self):
        """Steps a second of a batch."""
        self.start()
        data, initial = self.data[0], np.zeros((STATES, len(self.state())))
        q = data.qpos.copy()
        for k in range(STATES):
            data.qpos[:] = q
            dv = np.array([SPREAD * math.sin(1 + k * (2 * j + 3)) for j in range(self.model.nv)])
            mujoco.mj_integratePos(self.model, data.qpos, dv, 1.0)
            initial[k] = self.state()
        controls = np.repeat(self.controls[None, :BATCH_STEPS], STATES, axis=0)
        steps, readings = controls.shape[1], self.model.nsensordata
        states, sensors = np.zeros((STATES, steps, initial.shape[1])), np.zeros((STATES, steps, readings)) if readings else None
        best = math.inf
        with rollout.Rollout(nthread=THREADS) as threads:
            for _ in range(ROUNDS):
                begin = time.perf_counter()
                threads.rollout(self.model, self.data, initial, controls, nstep=steps, state=states, sensordata=sensors)
                best = min(best, time.perf_counter() - begin)
        assert np.isfinite(states).all()
        return STATES * steps / best


def loading(file):
    text, times = file.read_text(), []
    for _ in range(41):
        begin = time.perf_counter()
        mujoco.MjModel.from_xml_string(text)
        times.append(time.perf_counter() - begin)
    return 1e6 * median(times)


def elliptic(spec):
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    return spec


def gymnasium_humanoid(flies=False, touches=True):
    """Its own solver and its number of iterations are those of an older MuJoCo. Without weight it stays above the floor."""
    import gymnasium

    file = pathlib.Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets" / "humanoid.xml"
    spec = elliptic(mujoco.MjSpec.from_file(str(file)))
    spec.option.iterations = 100
    if flies:
        spec.option.gravity = [0, 0, 0]
    for body in [] if touches else spec.bodies:
        for geom in body.geoms:
            geom.contype = geom.conaffinity = 0
    spec.compile()
    # What is written leaves out that the base has no limits, which the defaults of the file demand.
    return spec.to_xml().replace('type="free"', 'type="free" limited="false"')


def text_of(program, robot):
    return subprocess.run([program, "mjcf", robot], check=True, capture_output=True, text=True).stdout


def standing(program):
    """The quadruped of assets/ on its feet, under servos, with an inertial unit."""
    spec = elliptic(mujoco.MjSpec.from_string(text_of(program, "quadruped")))
    for body in spec.bodies:
        for geom in body.geoms:
            touches = geom.group == 3 and body.name in FEET
            geom.contype, geom.conaffinity = int(touches), 0
            if touches:
                geom.friction, geom.condim = [0.8, 0.005, 0.0001], 3
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], contype=0, conaffinity=1, condim=3, friction=[0.8, 0.005, 0.0001])
    spec.option.timestep = 1e-3
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    legs = [joint for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_HINGE]
    for joint in legs:
        servo = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        servo.set_to_position(kp=60, kv=2)
    trunk = spec.worldbody.first_body()
    trunk.add_site(name="imu")
    sensor, site = mujoco.mjtSensor, mujoco.mjtObj.mjOBJ_SITE
    for name, kind in [("gyro", sensor.mjSENS_GYRO), ("accelerometer", sensor.mjSENS_ACCELEROMETER), ("orientation", sensor.mjSENS_FRAMEQUAT)]:
        spec.add_sensor(name=name, type=kind, objtype=site, objname="imu")
    spec.add_key(name="start", qpos=[0, 0, 0.3, 1, 0, 0, 0, *CROUCH * 4], ctrl=CROUCH * 4)
    spec.compile()
    return spec.to_xml()


def free(program, robot, friction):
    """A robot of assets/ in free motion, with motors."""
    spec = elliptic(mujoco.MjSpec.from_string(text_of(program, robot)))
    spec.option.timestep = 1e-3
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    for joint in spec.joints:
        if joint.type in [mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE]:
            joint.frictionloss, joint.limited = friction, False
    for body in spec.bodies:
        for geom in body.geoms:
            geom.contype = geom.conaffinity = 0
    spec.compile()
    return spec.to_xml()


def waves(size):
    def control(k, model):
        low, high = model.actuator_ctrlrange.T
        middle, half = (low + high) / 2, np.where(high > low, (high - low) / 2, 1.0)
        return middle + size * half * np.sin(0.02 * k + np.arange(model.nu))

    return control


def closing(k, _model):
    return [0.1 * min(1.0, k / 200), 15.0, 15.0]


def squats(k, _model):
    bend = 0.1 * math.sin(0.01 * k)
    return [CROUCH[0], CROUCH[1] + bend, CROUCH[2] - 2 * bend] * 4


def compare(scene, program, repetitions):
    rounds = [(run(program, "times", scene.file, scene.controls_file), scene.times()) for _ in range(repetitions)]
    words = f"{scene.name}: {rounds[0][0]['touching']:.1f} points press on average, there {rounds[0][1]['touching']:.1f}"
    for name in ["step", "linearize"]:
        ours, theirs = (median(r[k][name] for r in rounds) for k in [0, 1])
        words += f"; {name} {ours:.2f} / {theirs:.2f} µs = **{median(a[name] / b[name] for a, b in rounds):.2f}**"
    print(words, flush=True)
    return median(a["step"] for a, _ in rounds)


def compare_rates(scene, program, repetitions):
    ours = lambda: run(program, "batch", scene.file, scene.few_file, STATES, THREADS)["rate"]
    rounds = [(ours(), scene.rate()) for _ in range(repetitions)]
    a, b = (median(r[k] for r in rounds) for k in [0, 1])
    print(f"{scene.name}, batch: {a:.3g} / {b:.3g} steps/s = **{median(x / y for x, y in rounds):.1f}**", flush=True)


def main():
    program, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    repetitions = int(sys.argv[3]) if len(sys.argv) > 3 else 7
    folder.mkdir(parents=True, exist_ok=True)
    print(f"load {os.getloadavg()[0]:.1f} before the start, {os.cpu_count()} cores, medians of {repetitions} repetitions")
    humanoid = Scene("humanoid", gymnasium_humanoid(), 1000, waves(0.5), folder)
    gripper = Scene("gripper", GRIPPER, 400, closing, folder)
    quadruped = Scene("quadruped", standing(program), 400, squats, folder)
    for scene in [humanoid, gripper, quadruped]:
        compare(scene, program, repetitions)
    rounds = [(run(program, "load", humanoid.file)["load"], loading(humanoid.file)) for _ in range(repetitions)]
    print("loading of the humanoid: {:.0f} / {:.0f} µs".format(*(median(r[k] for r in rounds) for k in [0, 1])))
    flights = [Scene(f"flight, touches {x}", gymnasium_humanoid(True, x), 300, lambda _k, model: np.zeros(model.nu), folder) for x in [True, False]]
    with_pairs, alone = (compare(scene, program, repetitions) for scene in flights)
    print(f"looking for contact takes {with_pairs / alone - 1:.2f} of a step without")
    for robot in ["panda", "quadruped", "humanoid"]:
        scenes = [Scene(f"free {robot}, friction {x}", free(program, robot, x), 300, waves(0.001), folder) for x in [0.0, *FRICTION]]
        none, *with_friction = [compare(scene, program, repetitions) for scene in scenes]
        print(f"{robot}: dry friction in every joint takes", " and ".join(f"{time / none:.2f}" for time in with_friction), "of a step without")
    for scene in [quadruped, gripper]:
        compare_rates(scene, program, max(1, repetitions // 2))


main()
