"""The robots of the comparison, in the form that each program reads."""

import pathlib
import xml.etree.ElementTree as ElementTree

import mujoco
import pinocchio as pin

# Name, file among the robots of example-robot-data, base.
ROBOTS = [
    ("Panda", "panda_description/urdf/panda.urdf", "fixed"),
    ("UR5", "ur_description/urdf/ur5_robot.urdf", "fixed"),
    ("HyQ", "hyq_description/robots/hyq_no_sensors.urdf", "floating"),
    ("G1", "g1_description/urdf/g1_29dof_rev_1_0.urdf", "floating"),
    ("Talos", "talos_data/robots/talos_reduced.urdf", "floating"),
]
TIME_STEP = 1e-3


def urdf(file):
    """The wheels put programs and data below one prefix, the modules of Python at lib/pythonX.Y/site-packages in it."""
    prefix = pathlib.Path(pin.__file__).resolve().parents[4]
    return prefix / "share" / "example-robot-data" / "robots" / file


def write_pinocchio(path, base, target):
    """As text: see pinocchio.cpp. Joints that mimic others are independent, as with us."""
    root = [pin.JointModelFreeFlyer()] if base == "floating" else []
    pin.buildModelFromUrdf(str(path), *root).saveToText(str(target))


def write_mujoco(path, base, target):
    """The tree of joints alone: no shapes, contacts, limits, dry friction; every joint with a motor, like ours."""
    spec = mujoco.MjSpec.from_string(mujoco_urdf(path, base))
    for joint in spec.joints:
        if joint.type in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            motor = spec.add_actuator(name=joint.name, target=joint.name)
            motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
    model = spec.compile()
    model.opt.timestep = TIME_STEP
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    # Damping is explicit with us: the implicit kind would be more work.
    disable = mujoco.mjtDisableBit
    model.opt.disableflags |= disable.mjDSBL_CONTACT | disable.mjDSBL_CONSTRAINT | disable.mjDSBL_EULERDAMP
    mujoco.mj_saveModel(model, str(target), None)


def mujoco_urdf(path, base):
    xml = ElementTree.parse(path).getroot()
    for link in xml.findall("link"):
        for shape in link.findall("visual") + link.findall("collision"):
            link.remove(shape)
    if base == "floating":
        # MuJoCo welds the root to the world; so it gets one to float in.
        children = {joint.find("child").get("link") for joint in xml.findall("joint")}
        (root,) = [link.get("name") for link in xml.findall("link") if link.get("name") not in children]
        ElementTree.SubElement(xml, "link", name="ground_of_comparison")
        joint = ElementTree.SubElement(xml, "joint", name="base_of_comparison", type="floating")
        ElementTree.SubElement(joint, "parent", link="ground_of_comparison")
        ElementTree.SubElement(joint, "child", link=root)
    # Links without inertia are merged where they are fixed, and get a trace of it where they move.
    settings = ElementTree.SubElement(xml, "mujoco")
    ElementTree.SubElement(
        settings, "compiler", fusestatic="true", balanceinertia="true", boundmass="1e-9", boundinertia="1e-12"
    )
    return ElementTree.tostring(xml, encoding="unicode")
