"""Makes the golden values of the descriptions in this folder with MuJoCo.

    pip install mujoco==4.0.0 numpy
    python tests/mjcf/make.py

Run by hand, and only when a description changes. Each text file is one description:

    # engine and version
    key word word ...                    joints, mass
    state 0                              the records up to the next state belong to this state
    name rows columns number number ...  row by row

Contacts, limits, friction losses and equalities (but in `equalities`) are switched off, and actuators but in `servos` and `activations`, where each state has a control (in the order of the file) and no
applied force; springs and dampers are in the accelerations, not in the bias. Numbers are in the
conventions of the crate: the velocity of a free body is in the body, [linear; angular].
"""

import pathlib

import mujoco
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
NAMES = ["chain", "free", "world", "attach", "servos", "sensors", "activations", "rays", "equalities"]
ACTUATED = ["servos", "activations"]
# Activations are held over the stages of our steps of Runge and Kutta; rays are compared at states, and so are equalities, which make motions fast.
WITHOUT_MOTION = ["activations", "rays", "equalities"]
STATES = 3
# One second of motion by the Runge–Kutta method.
TIME_STEP = 1e-4
STEPS = 10000


def main():
    for name in NAMES:
        model = mujoco.MjModel.from_xml_path(str(HERE / f"{name}.xml"))
        off = mujoco.mjtDisableBit
        if name == "equalities":
            model.opt.disableflags |= off.mjDSBL_CONTACT | off.mjDSBL_LIMIT | off.mjDSBL_FRICTIONLOSS
            model.opt.tolerance = 0
        else:
            model.opt.disableflags |= off.mjDSBL_CONSTRAINT
        if name not in ACTUATED:
            model.opt.disableflags |= off.mjDSBL_ACTUATION
        rng = np.random.default_rng(sum(name.encode()))
        lines = [f"# mujoco {mujoco.__version__}", "joints " + " ".join(joint_names(model)), f"mass {model.body_mass.sum()!r}"]
        for k in range(STATES):
            q = model.qpos0.copy()
            if k > 0:
                mujoco.mj_integratePos(model, q, rng.uniform(-1, 1, model.nv), 1.0)
            v, tau = rng.uniform(-1, 1, model.nv), rng.uniform(-1, 1, model.nv)
            ctrl = control(name, model, rng)
            act = rng.uniform(-1, 1, model.na) if model.na else np.zeros(0)
            lines += [f"state {k}"] + records(model, q, v, tau, ctrl, act)
        if name not in WITHOUT_MOTION:
            lines += motion(model, rng.uniform(-0.5, 0.5, model.nv), control(name, model, rng))
        (HERE / f"{name}.txt").write_text("\n".join(lines) + "\n")


def control(name, model, rng):
    """Beyond the ranges, too."""
    return rng.uniform(-2, 2, model.nu) if name in ACTUATED else np.zeros(0)


def joint_names(model):
    return [model.joint(j).name for j in range(model.njnt) if model.joint(j).name]


def turned(model, q):
    """T in v_mujoco = T v: the linear velocity of a free body is in the world there."""
    T = np.eye(model.nv)
    for at, dof in free_joints(model):
        T[dof : dof + 3, dof : dof + 3] = rotation(q[at + 3 : at + 7])
    return T


def free_joints(model):
    free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
    return [(model.jnt_qposadr[j], model.jnt_dofadr[j]) for j in free]


def rotation(quaternion):
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, quaternion)
    return R.reshape(3, 3)


def turning(model, T, v):
    """The rate of T times v, in the coordinates of MuJoCo."""
    out = np.zeros(model.nv)
    for _, dof in free_joints(model):
        out[dof : dof + 3] = T[dof : dof + 3, dof : dof + 3] @ np.cross(v[dof + 3 : dof + 6], v[dof : dof + 3])
    return out


def mass_matrix(model, data):
    columns = []
    for unit in np.eye(model.nv):
        column = np.zeros(model.nv)
        mujoco.mj_mulM(model, data, column, unit)
        columns.append(column)
    return np.array(columns).T


def records(model, q, v, tau, ctrl, act):
    data = mujoco.MjData(model)
    data.act[:] = act
    if len(ctrl):
        data.ctrl[:], tau = ctrl, np.zeros(model.nv)
    T = turned(model, q)
    data.qpos[:], data.qvel[:], data.qfrc_applied[:] = q, T @ v, T @ tau
    mujoco.mj_forward(model, data)
    M, rate = mass_matrix(model, data), turning(model, T, v)
    bias = data.qfrc_bias - data.qfrc_gravcomp
    lines = [
        record("q", q),
        record("v", v),
        record("tau", tau),
        *controls(ctrl),
        record("mass_matrix", T.T @ M @ T),
        record("bias_forces", T.T @ (bias + M @ rate)),
        record("acceleration", T.T @ (data.qacc - rate)),
    ]
    bodies = [(model.body(i).name, data.xpos[i], data.xmat[i]) for i in range(1, model.nbody)]
    sites = [(model.site(i).name, data.site_xpos[i], data.site_xmat[i]) for i in range(model.nsite)]
    for name, position, matrix in bodies + sites:
        lines.append(record(f"pose:{name}", np.concatenate([position, matrix])))
    for k in range(model.nsensor):
        start, n = model.sensor_adr[k], model.sensor_dim[k]
        lines.append(record(f"sensor:{model.sensor(k).name}", data.sensordata[start : start + n]))
    return lines + activations(model, data, act)


def activations(model, data, act):
    """Activations before and after a step of Euler; the first of what is delayed is 0."""
    if not len(act):
        return []
    before = record("activation", act)
    mujoco.mj_step(model, data)
    return [before, record("next_activation", data.act)]


def controls(ctrl):
    return [record("control", ctrl)] if len(ctrl) else []


def motion(model, v, ctrl):
    data = mujoco.MjData(model)
    if len(ctrl):
        data.ctrl[:] = ctrl
    model.opt.timestep, model.opt.integrator = TIME_STEP, mujoco.mjtIntegrator.mjINT_RK4
    data.qvel[:] = turned(model, data.qpos) @ v
    lines = [f"motion {STEPS}", record("q", data.qpos), record("v", v), *controls(ctrl)]
    for _ in range(STEPS):
        mujoco.mj_step(model, data)
    return lines + [record("end_q", data.qpos), record("end_v", turned(model, data.qpos).T @ data.qvel)]


def record(name, array):
    array = np.atleast_2d(np.asarray(array, dtype=float))
    numbers = " ".join(repr(float(x)) for x in array.flatten())
    return f"{name} {array.shape[0]} {array.shape[1]} {numbers}"


if __name__ == "__main__":
    main()
