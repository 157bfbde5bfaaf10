"""Makes the golden values in this folder from two independent engines.

    pip install pin==4.1.0 mujoco==4.0.0 numpy
    python tests/golden/make.py

Run by hand, and only when a robot in assets/ changes. Each file is one robot on one base in one engine:

    # engine and versions
    key word word ...                    robot, base, mimic, joints, ...
    state 0                              the records up to the next state belong to this state
    name rows columns number number ...  row by row

Everything is written in the conventions of the crate: quaternions (w, x, y, z), the velocity of a floating base in the base frame,
[linear; angular], SI units, gravity 9.81 down z. Only the order of the joints is that of the engine: see the key `joints`.
"""

import pathlib
import xml.etree.ElementTree as ElementTree

import mujoco
import numpy as np
import pinocchio as pin

HERE = pathlib.Path(__file__).resolve().parent
ASSETS = HERE.parent.parent / "assets"
GRAVITY = 9.81

# States per robot; the matrices of a humanoid are large.
STATES = {"humanoid": 1, "quadruped": 2}
DEFAULT_STATES = 3

# One simulated second.
TIME_STEP = 1e-3
STEPS = 1000
# The files have no rotors, and no damping or this much: MuJoCo gets both on every joint.
DAMPING = 0.1
ARMATURE = 0.01

FRAMES = {
    "body": pin.ReferenceFrame.LOCAL,
    "mixed": pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
    "inertial": pin.ReferenceFrame.WORLD,
}


def main():
    for old in HERE.glob("*.txt"):
        old.unlink()
    for path in sorted(ASSETS.glob("*.urdf")):
        rng = np.random.default_rng(sum(path.stem.encode()))
        for base in ["fixed", "floating"]:
            xml = description(path, base)
            if base == "fixed" and not moving_joints(xml):
                continue  # nothing moves
            if base == "floating" and not has_mass(xml, base_link(xml)):
                continue  # a base without mass cannot float
            kinds = ["independent"] + (["coupled"] if xml.find("joint/mimic") is not None else [])
            for mimic in kinds:
                PinocchioRobot(path.stem, xml, base, mimic).write(rng)
            write_mujoco(path.stem, xml, base, rng)


# --- descriptions -------------------------------------------------------------------------------------------------------------


def description(path, base):
    """The parsed file; for a floating base without a link `world`, if a link is fixed to it, which then floats."""
    xml = ElementTree.parse(path).getroot()
    world = next((link for link in xml.findall("link") if link.get("name") == "world"), None)
    if base == "floating" and world is not None:
        (joint,) = [j for j in xml.findall("joint") if j.find("parent").get("link") == "world"]
        if joint.get("type") == "fixed":
            xml.remove(world)
            xml.remove(joint)
    return xml


def base_link(xml):
    children = {joint.find("child").get("link") for joint in xml.findall("joint")}
    (root,) = [link for link in xml.findall("link") if link.get("name") not in children]
    return root


def has_mass(xml, link):
    """Whether the link, or one that is fixed to it, has mass."""
    fixed = {
        joint.find("child").get("link")
        for joint in xml.findall("joint")
        if joint.get("type") == "fixed" and joint.find("parent").get("link") == link.get("name")
    }
    on_it = [other for other in xml.findall("link") if other.get("name") in fixed]
    return link.find("inertial") is not None or any(has_mass(xml, other) for other in on_it)


def moving_joints(xml):
    return [joint for joint in xml.findall("joint") if joint.get("type") != "fixed"]


# --- the files ----------------------------------------------------------------------------------------------------------------


class Output:
    """Collects the lines of one file."""

    def __init__(self, header):
        self.lines = [f"# {header}, numpy {np.__version__}; made by make.py"]

    def key(self, key, *words):
        assert not any(" " in str(word) for word in words)
        self.lines.append(" ".join([key, *map(str, words)]))

    def record(self, name, value):
        value = np.atleast_1d(np.asarray(value, dtype=float))
        rows, columns = value.shape if value.ndim == 2 else (len(value), 1)
        # Adding zero turns -0.0 into 0.0; integers are written without their fraction.
        numbers = (repr(float(x) + 0.0).removesuffix(".0") for x in value.flatten())
        self.lines.append(" ".join([name, str(rows), str(columns), *numbers]))

    def save(self, name):
        (HERE / f"{name}.txt").write_text("\n".join(self.lines) + "\n")


# --- Pinocchio ----------------------------------------------------------------------------------------------------------------


class PinocchioRobot:
    """A robot in Pinocchio, with coordinates of the crate.

    Not every algorithm of Pinocchio takes joints that mimic others. So the engine always gets independent joints, with
    velocities G v, and what is coupled is projected: M = Gᵀ M G, τ = Gᵀ τ, J G. `check_mimic` compares with its own mimic joints.
    """

    def __init__(self, name, xml, base, mimic):
        self.name, self.base, self.mimic = name, base, mimic
        self.text = ElementTree.tostring(xml, encoding="unicode")
        roots = [pin.JointModelFreeFlyer()] if base == "floating" else []
        self.model = pin.buildModelFromXML(self.text, *roots)
        self.model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
        self.data = self.model.createData()
        self.base_nv = 6 if base == "floating" else 0
        self.base_nq = 7 if base == "floating" else 0
        all_joints = list(self.model.names)[1 + len(roots) :]
        followers = self.followers(xml) if mimic == "coupled" else {}
        self.joints = [joint for joint in all_joints if joint not in followers]
        nv = self.base_nv + len(self.joints)
        self.G = np.zeros((self.model.nv, nv))
        self.offset = np.zeros(self.model.nv)
        self.G[: self.base_nv, : self.base_nv] = np.eye(self.base_nv)
        for joint in all_joints:
            leader, multiplier, offset = followers.get(joint, (joint, 1.0, 0.0))
            row = self.model.joints[self.model.getJointId(joint)].idx_v
            self.G[row, self.base_nv + self.joints.index(leader)] = multiplier
            self.offset[row] = offset

    @staticmethod
    def followers(xml):
        out = {}
        for joint in moving_joints(xml):
            mimic = joint.find("mimic")
            if mimic is not None:
                numbers = float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0))
                out[joint.get("name")] = mimic.get("joint"), *numbers
        return out

    def random_q(self, rng):
        """A random configuration in the crate's coordinates, one number a joint."""
        base = []
        if self.base_nq:
            quaternion = rng.normal(size=4)
            base = [rng.uniform(-1, 1, 3), quaternion / np.linalg.norm(quaternion)]
        joints = [
            rng.uniform(-1, 1) if "P" in self.sort_of(joint) else rng.uniform(-np.pi, np.pi)
            for joint in self.joints
        ]
        return np.concatenate([*base, joints])

    def sort_of(self, joint):
        """P for a prismatic joint (JointModelPX, JointModelPrismaticUnaligned, …), R for one that turns."""
        name = self.model.joints[self.model.getJointId(joint)].shortname()
        return "P" if name.startswith(("JointModelP", "JointModelPrismatic")) else "R"

    def configuration(self, q):
        """Pinocchio's coordinates: quaternions (x, y, z, w), continuous joints as (cos, sin)."""
        out = pin.neutral(self.model)
        if self.base_nq:
            out[:7] = np.concatenate([q[:3], q[4:7], q[3:4]])
        x = self.G[self.base_nv :, self.base_nv :] @ q[self.base_nq :] + self.offset[self.base_nv :]
        for joint in list(self.model.joints)[1 + (self.base_nq > 0) :]:
            angle = x[joint.idx_v - self.base_nv]
            if joint.nq == 2:
                out[joint.idx_q : joint.idx_q + 2] = np.cos(angle), np.sin(angle)
            else:
                out[joint.idx_q] = angle
        return out

    def write(self, rng):
        out = Output(f"pinocchio {pin.__version__}")
        out.key("engine", "pinocchio")
        out.key("robot", self.name)
        out.key("base", self.base)
        out.key("mimic", self.mimic)
        out.key("joints", *self.joints)
        self.tip = self.deepest_link()
        out.key("tip", self.tip.name)
        for k in range(STATES.get(self.name, DEFAULT_STATES)):
            out.key("state", k)
            q = self.random_q(rng)
            v, a, tau = rng.uniform(-1, 1, (3, self.G.shape[1]))
            for name, value in [("q", q), ("v", v), ("a", a), ("tau", tau)]:
                out.record(name, value)
            self.dynamics(out, q, v, a, tau)
            self.derivatives(out, q, v, a, tau)
            self.frames(out, q, v, a)
            self.whole_body(out, q, v, a)
            if self.mimic == "coupled":
                self.check_mimic(q, v, a)
        out.save(f"{self.name}_{self.base}_{self.mimic}_pinocchio")

    def deepest_link(self):
        links = [frame for frame in self.model.frames if frame.type == pin.FrameType.BODY]
        return max(links, key=lambda frame: len(self.model.supports[frame.parentJoint]))

    def dynamics(self, out, q, v, a, tau):
        model, data, G, x = self.model, self.data, self.G, self.configuration(q)
        M = G.T @ full_mass_matrix(model, data, x) @ G
        h = G.T @ pin.nonLinearEffects(model, data, x, G @ v)
        out.record("mass_matrix", M)
        out.record("bias_forces", h)
        out.record("gravity_forces", G.T @ pin.computeGeneralizedGravity(model, data, x))
        # Coriolis matrices are not unique; the one of Pinocchio comes from Christoffel symbols of the bodies, like the crate's.
        out.record("coriolis_matrix", G.T @ pin.computeCoriolisMatrix(model, data, x, G @ v) @ G)
        out.record("inverse_dynamics", G.T @ pin.rnea(model, data, x, G @ v, G @ a))
        self.vdot = np.linalg.solve(M, tau - h)
        if self.mimic == "independent":
            self.vdot = pin.aba(model, data, x, v, tau).copy()
        out.record("forward_dynamics", self.vdot)

    def derivatives(self, out, q, v, a, tau):
        model, data, G, x = self.model, self.data, self.G, self.configuration(q)
        dq, dv, M = (G.T @ d @ G for d in pin.computeRNEADerivatives(model, data, x, G @ v, G @ a))
        out.record("inverse_dynamics_dq", dq)
        out.record("inverse_dynamics_dv", dv)
        if self.mimic == "independent":
            dq, dv, dtau = (d.copy() for d in pin.computeABADerivatives(model, data, x, v, tau))
        else:
            dq, dv, M = (
                G.T @ d @ G for d in pin.computeRNEADerivatives(model, data, x, G @ v, G @ self.vdot)
            )
            dtau = np.linalg.inv(G.T @ full_mass_matrix(model, data, x) @ G)
            dq, dv = -dtau @ dq, -dtau @ dv
        out.record("forward_dynamics_dq", dq)
        out.record("forward_dynamics_dv", dv)
        out.record("forward_dynamics_dtau", dtau)

    def frames(self, out, q, v, a):
        model, data, G, x = self.model, self.data, self.G, self.configuration(q)
        pin.forwardKinematics(model, data, x, G @ v, G @ a)
        pin.updateFramePlacements(model, data)
        for i, frame in enumerate(model.frames):
            if frame.type == pin.FrameType.BODY:
                out.record(f"frame_pose:{frame.name}", data.oMf[i].homogeneous[:3])
        tip = model.getFrameId(self.tip.name, pin.FrameType.BODY)
        pin.computeJointJacobians(model, data, x)
        pin.computeJointJacobiansTimeVariation(model, data, x, G @ v)
        pin.forwardKinematics(model, data, x, G @ v, G @ a)
        pin.updateFramePlacements(model, data)
        for name, frame in FRAMES.items():
            out.record(f"frame_velocity:{name}", pin.getFrameVelocity(model, data, tip, frame).vector)
            J = pin.getFrameJacobian(model, data, tip, frame)
            out.record(f"frame_jacobian:{name}", J @ G)
            dJ = pin.getFrameJacobianTimeVariation(model, data, tip, frame)
            out.record(f"frame_jacobian_derivative:{name}", dJ @ G)
            # The derivative of the mixed velocity [ṗ; ω] is the classical acceleration, that of the others the spatial one.
            acceleration = pin.getFrameClassicalAcceleration if name == "mixed" else pin.getFrameAcceleration
            out.record(f"frame_acceleration:{name}", acceleration(model, data, tip, frame).vector)

    def whole_body(self, out, q, v, a):
        model, data, G, x = self.model, self.data, self.G, self.configuration(q)
        pin.centerOfMass(model, data, x, G @ v, G @ a)
        out.record("center_of_mass", data.com[0])
        out.record("center_of_mass_velocity", data.vcom[0])
        out.record("center_of_mass_acceleration", data.acom[0])
        out.record("center_of_mass_jacobian", pin.jacobianCenterOfMass(model, data, x) @ G)
        pin.computeCentroidalMomentumTimeVariation(model, data, x, G @ v, G @ a)
        out.record("centroidal_momentum", data.hg.vector)
        out.record("centroidal_momentum_rate", data.dhg.vector)
        out.record("centroidal_momentum_matrix", pin.ccrba(model, data, x, G @ v) @ G)
        out.record("kinetic_energy", pin.computeKineticEnergy(model, data, x, G @ v))
        out.record("potential_energy", pin.computePotentialEnergy(model, data, x))

    def check_mimic(self, q, v, a):
        """The projection against Pinocchio's own mimic joints, as far as it has them."""
        roots = [pin.JointModelFreeFlyer()] if self.base == "floating" else []
        model = pin.buildModelFromXML(self.text, *roots, mimic=True)
        data = model.createData()
        assert model.nv == self.G.shape[1]
        x = np.concatenate([q[:3], q[4:7], q[3:4], q[7:]]) if self.base_nq else q
        tau = pin.rnea(model, data, x, v, a)
        here = self.G.T @ pin.rnea(
            self.model, self.data, self.configuration(q), self.G @ v, self.G @ a
        )
        M = full_mass_matrix(model, data, x)
        projected = self.G.T @ full_mass_matrix(self.model, self.data, self.configuration(q)) @ self.G
        assert np.allclose(tau, here, rtol=1e-12, atol=1e-12)
        assert np.allclose(M, projected, rtol=1e-12, atol=1e-12)


def full_mass_matrix(model, data, x):
    """Pinocchio fills the upper triangle."""
    M = pin.crba(model, data, x)
    return np.triu(M) + np.triu(M, 1).T


# --- MuJoCo -------------------------------------------------------------------------------------------------------------------


def mujoco_model(xml, base):
    """The robot in MuJoCo, without contacts, limits and dry friction; fingers move independently."""
    xml = ElementTree.fromstring(ElementTree.tostring(xml))
    if base == "floating":
        # MuJoCo welds the root to the world; so it gets one to float in.
        root = base_link(xml).get("name")
        ElementTree.SubElement(xml, "link", name="golden_ground")
        joint = ElementTree.SubElement(xml, "joint", name="golden_base", type="floating")
        ElementTree.SubElement(joint, "parent", link="golden_ground")
        ElementTree.SubElement(joint, "child", link=root)
    settings = ElementTree.SubElement(xml, "mujoco")
    ElementTree.SubElement(settings, "compiler", discardvisual="true", fusestatic="true", inertiafromgeom="false")
    model = mujoco.MjModel.from_xml_string(ElementTree.tostring(xml, encoding="unicode"))
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.opt.timestep = TIME_STEP
    model.opt.gravity[:] = 0.0, 0.0, -GRAVITY
    # MuJoCo makes a soft constraint of `mimic`: it is left out with all others.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    first = 6 if base == "floating" else 0
    model.dof_damping[first:] = DAMPING
    model.dof_armature[first:] = ARMATURE
    return model


def rotation(q):
    out = np.zeros(9)
    mujoco.mju_quat2Mat(out, q[3:7])
    return out.reshape(3, 3)


def to_mujoco(model, floating, q):
    """T, with v_MuJoCo = T v: MuJoCo has the linear velocity of a free body in the axes of the world."""
    T = np.eye(model.nv)
    if floating:
        T[:3, :3] = rotation(q)
    return T


def write_mujoco(name, xml, base, rng):
    model = mujoco_model(xml, base)
    data = mujoco.MjData(model)
    floating = base == "floating"
    out = Output(f"mujoco {mujoco.__version__}")
    out.key("engine", "mujoco")
    out.key("robot", name)
    out.key("base", base)
    out.key("mimic", "independent")
    joints = [model.joint(k).name for k in range(int(floating), model.njnt)]
    out.key("joints", *joints)
    out.key("damping", DAMPING)
    out.key("armature", ARMATURE)
    for k in range(DEFAULT_STATES):
        out.key("state", k)
        q, v = random_state(model, floating, rng)
        tau = rng.uniform(-1, 1, model.nv)
        tau[: 6 * floating] = 0
        T = to_mujoco(model, floating, q)
        for key, value in [("q", q), ("v", v), ("tau", tau)]:
            out.record(key, value)
        data.qpos[:], data.qvel[:] = q, T @ v
        mujoco.mj_forward(model, data)
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        out.record("mass_matrix", T.T @ M @ T)
        # v̇_MuJoCo = T v̇ + Ṫ v, with Ṫ v = R (ω × v) in the linear part.
        rate = np.zeros(model.nv)
        if floating:
            rate[:3] = rotation(q) @ np.cross(v[3:6], v[:3])
        out.record("bias_forces", T.T @ (data.qfrc_bias + M @ rate))
        if k == 0:
            simulate(out, model, data, floating, q, v, tau)
    out.save(f"{name}_{base}_mujoco")


def random_state(model, floating, rng):
    q = rng.uniform(-1, 1, model.nq)
    if floating:
        q[3:7] = rng.normal(size=4)
        q[3:7] /= np.linalg.norm(q[3:7])
    return q, rng.uniform(-1, 1, model.nv)


def simulate(out, model, data, floating, q, v, tau):
    """One second under constant forces."""
    mujoco.mj_resetData(model, data)
    data.qpos[:], data.qvel[:] = q, to_mujoco(model, floating, q) @ v
    data.qfrc_applied[:] = tau
    for _ in range(STEPS):
        mujoco.mj_step(model, data)
    out.record("final_q", data.qpos)
    out.record("final_v", to_mujoco(model, floating, data.qpos).T @ data.qvel)


if __name__ == "__main__":
    main()
