"""Robots: questions, changes, builders, reports."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import ASSETS, asset

import dualbody as db
from dualbody.contact import Contacts, Rigid, Terrain
from dualbody.model import Box, Hardware, ScaledLink


def test_a_model_tells_what_it_is(cartpole: db.Model) -> None:
    assert (cartpole.nq, cartpole.nv, cartpole.n_joints, cartpole.n_bodies) == (2, 2, 2, 2)
    assert cartpole.joint_names == ["linear", "pivot"]
    assert cartpole.joint_v("pivot") == slice(1, 2, 1)
    assert cartpole.limits("linear").upper > 0
    assert cartpole.joint_kind("linear") == "prismatic"
    assert not cartpole.has_floating_base
    assert cartpole.gravity == (0, 0, -9.81)
    np.testing.assert_array_equal(cartpole.neutral(), [0, 0])
    assert "cartpole" in repr(cartpole) and "nv=2" in repr(cartpole)
    assert "pivot" in cartpole.tree()


def test_text_and_file_give_the_same_robot() -> None:
    text = (ASSETS / "quadruped.urdf").read_text()
    one, other = db.Model.from_urdf(ASSETS / "quadruped.urdf"), db.Model.from_urdf(text)
    np.testing.assert_array_equal(one.parameters, other.parameters)


def test_a_byte_order_mark_begins_a_text() -> None:
    text = (ASSETS / "quadruped.urdf").read_text()
    marked = db.Model.from_urdf("\ufeff" + text)
    np.testing.assert_array_equal(marked.parameters, db.Model.from_urdf(text).parameters)


MESHED = """<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><mesh filename="a.obj"/></geometry></collision></link></robot>"""
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"


def test_a_pickle_finds_its_meshes_from_any_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.obj").write_text(TETRAHEDRON)
    (tmp_path / "r.urdf").write_text(MESHED)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    pickled = pickle.dumps(db.Model.from_urdf("r.urdf"))
    monkeypatch.chdir(tmp_path / "elsewhere")
    contacts = Contacts(Terrain.flat(), Rigid(friction=0.5))
    simulator = db.Simulator(pickle.loads(pickled), contacts=contacts)
    assert len(simulator.contact_points) == 4


LOADED = """
import sys, numpy, dualbody as db
before = set(sys.modules)
db.Model.from_urdf(sys.argv[1])
print(sorted(set(sys.modules) - before))
"""


def test_loading_imports_nothing() -> None:
    done = subprocess.run([sys.executable, "-c", LOADED, asset("cartpole")], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_options_choose_base_gravity_and_joints() -> None:
    floating = db.Model.from_urdf(asset("ur5"), base="floating", gravity=(0, 0, -1.62))
    assert floating.has_floating_base and floating.gravity == (0, 0, -1.62)
    names = db.Model.from_urdf(asset("ur5")).joint_names
    kept = db.Model.from_urdf(asset("ur5"), kept_joints=names[:2], locked_joints={names[3]: 0.5})
    assert kept.joint_names == names[:2]


def test_the_import_report_reads_well() -> None:
    report = db.Model.from_urdf(asset("ur5"), base="floating").import_report
    assert report.base == "floating" and "ur5" in report.file
    assert report.file in str(report) and report.file in report._repr_html_()
    assert all(len(note) == 4 for note in report.warnings + report.ignored)
    bare = db.Model.from_urdf("<robot name='r'><link name='world'/></robot>").import_report
    assert "nothing is left out" in bare._repr_html_() and "FIXED" in bare._repr_html_()
    assert db.samples.arm().import_report is None


def test_integrate_undoes_difference(quadruped: db.Model) -> None:
    q0, q1 = quadruped.random_configuration(1), quadruped.random_configuration(2)
    np.testing.assert_allclose(quadruped.integrate(q0, quadruped.difference(q0, q1))[7:], q1[7:], atol=1e-12)
    np.testing.assert_array_equal(quadruped.random_configuration(1), q0)
    half = quadruped.interpolate(q0, q1, 0.5)
    np.testing.assert_allclose(quadruped.difference(q0, half), quadruped.difference(half, q1), atol=1e-9)


def test_changes_give_new_robots(cartpole: db.Model) -> None:
    heavy = cartpole.with_link_mass("pole", 3.0)
    assert heavy.total_mass > cartpole.total_mass
    locked = cartpole.with_locked_joints({"linear": 0.2})
    assert locked.joint_names == ["pivot"]
    np.testing.assert_allclose(
        db.gravity_forces(locked, [0.3]), db.gravity_forces(cartpole, [0.2, 0.3])[1:], atol=1e-12
    )
    small = cartpole.scaled(0.5, 1.0)
    assert small.total_mass == pytest.approx(cartpole.total_mass / 8)
    pose = np.eye(4)
    pose[:3, 3] = 0, 0, 0.7
    tip = cartpole.with_frame("tip", "pole", pose)
    np.testing.assert_allclose(
        db.frame_pose(tip, [0, 0.4], "tip"), db.frame_pose(cartpole, [0, 0.4], "pole") @ pose, atol=1e-12
    )
    both = cartpole.with_attached(db.samples.pendulum(), "pole", "bob/", pose)
    assert both.nv == 3
    with pytest.raises(KeyError, match="wheel"):
        cartpole.with_link_mass("wheel", 1.0)
    with pytest.raises(ValueError, match="mass"):
        cartpole.with_link_mass("pole", -1.0)


def test_a_built_pendulum_obeys_its_closed_form() -> None:
    # A bob of 2 kg, half a metre below the hinge: tau = m g l sin q at rest, M = m l².
    builder = db.ModelBuilder("pendulum", base="fixed")
    builder.add_link(db.LinkSpec("world"))
    builder.add_link(db.LinkSpec("bob", mass=2.0, com=(0, 0, -0.5), visuals=[Box((0.1, 0.1, 0.1), placement=(0, 0, -0.5))]))
    builder.add_joint(db.JointSpec("hinge", "revolute", "world", "bob", limits=db.Limits(-1, 1)))
    model = builder.build()
    assert db.gravity_forces(model, [0.4])[0] == pytest.approx(2 * 9.81 * 0.5 * np.sin(0.4), rel=1e-12)
    assert db.mass_matrix(model, [0.4])[0, 0] == pytest.approx(0.5, rel=1e-12)
    assert model.limits("hinge") == (-1, 1, None, None)
    again = pickle.loads(pickle.dumps(model))
    np.testing.assert_array_equal(again.parameters, model.parameters)
    builder.add_joint(db.JointSpec("other", "revolute", "world", "missing"))
    with pytest.raises(ValueError, match="missing"):
        builder.build()


def test_other_engines_get_their_coordinates(quadruped: db.Model) -> None:
    q, v = quadruped.random_configuration(4), quadruped.random_velocity(5)
    for engine in ("pinocchio", "mujoco", "jaxsim"):
        back = quadruped.from_engine(engine, *quadruped.to_engine(engine, q, v))
        np.testing.assert_allclose(back[0], q, atol=1e-12)
        np.testing.assert_allclose(back[1], v, atol=1e-12)
    pinocchio = quadruped.to_engine("pinocchio", q, v)[0]
    np.testing.assert_allclose(pinocchio[3:7], q[[4, 5, 6, 3]])


def test_descriptions_are_written(cartpole: db.Model) -> None:
    again = db.Model.from_urdf(cartpole.to_urdf())
    np.testing.assert_allclose(again.parameters, cartpole.parameters, atol=1e-12)
    assert "<mujoco" in cartpole.to_mjcf()


def test_forces_on_frames_are_forces_on_bodies(panda: db.Model) -> None:
    q, zero = panda.random_configuration(7), np.zeros(panda.nv)
    wrench = np.array([1.0, -2.0, 3.0, 0.1, 0.2, -0.3])
    external = db.external_forces(panda, q, {"panda_hand": wrench}, "mixed")
    change = db.inverse_dynamics(panda, q, zero, zero, external=external) - db.inverse_dynamics(panda, q, zero, zero)
    jacobian = db.frame_jacobian(panda, q, "panda_hand", representation="mixed")
    np.testing.assert_allclose(change, -jacobian.T @ wrench, atol=1e-12)
    with pytest.raises(KeyError, match="panda_foot"):
        db.external_forces(panda, q, {"panda_foot": wrench})


def test_the_poses_of_all_frames_are_those_of_each(panda: db.Model) -> None:
    q = np.array([panda.random_configuration(k) for k in range(3)])
    poses = db.forward_kinematics(panda, q)
    assert poses.shape == (3, len(panda.frame_names), 4, 4)
    for k, name in enumerate(panda.frame_names):
        np.testing.assert_allclose(poses[:, k], db.frame_pose(panda, q, name), atol=1e-14)


def test_sizes_of_links_are_parameters() -> None:
    builder = db.ModelBuilder("spinner")
    builder.add_link(db.LinkSpec("world"))
    builder.add_link(db.LinkSpec.solid_cylinder("rod", 1e-6, 1.0, 12.0))
    builder.add_joint(db.JointSpec("hinge", "continuous", "world", "rod", axis=(1.0, 0.0, 0.0)))
    hardware = Hardware(builder.build(), [ScaledLink("rod", ["length"])])
    assert hardware.names == ["rod: length"]
    np.testing.assert_allclose(hardware.nominal, [1.0])
    # J = m l^2 / 12, and m grows with l: l^3, of slope 3 l^2.
    longer = hardware.scaled_model([2.0])
    np.testing.assert_allclose(db.mass_matrix(longer, [0.0]), [[8.0]], atol=1e-9)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(longer)).parameters, longer.parameters)
    h = 1e-6
    differences = (hardware.scaled_model([2 + h]).parameters - hardware.scaled_model([2 - h]).parameters) / (2 * h)
    np.testing.assert_allclose(hardware.parameter_jacobian([2.0])[:, 0], differences, atol=1e-6)
    assert {name.split(": ")[1] for name in Hardware(builder.build()).names} == {"radius", "length", "density"}
    for links, x, error, text in [
        ([ScaledLink("arm", ["length"])], [1.0], KeyError, "arm"),
        ([ScaledLink("rod", ["width"])], [1.0], ValueError, "dimension"),
        ([ScaledLink("rod", ["length"])], [1.0, 2.0], ValueError, "x has the shape"),
        ([ScaledLink("rod", ["length"])], [-1.0], ValueError, "rod: length"),
    ]:
        with pytest.raises(error, match=text):
            Hardware(builder.build(), links).scaled_model(x)


def test_a_model_keeps_the_remarks_of_its_reader() -> None:
    text = '<robot name="arm"><link name="world"/><gazebo><static>true</static></gazebo></robot>'
    assert any("another simulator" in line for line in db.Model.from_urdf(text).remarks)


def test_links_without_gravity_have_no_weight() -> None:
    for gravity, falls in [(True, True), (False, False)]:
        builder = db.ModelBuilder("ball")
        builder.add_link(db.LinkSpec("ball", mass=2.0, inertia=((1, 0, 0), (0, 1, 0), (0, 0, 1)), gravity=gravity))
        simulator = db.Simulator(builder.build())
        end = simulator.rollout(simulator.model.neutral(), np.zeros(6), steps=2)
        assert (end.v[-1, 2] < 0) == falls
    assert simulator.tangent_names == [f"{part}.base.{k}" for part in "qv" for k in range(6)]
