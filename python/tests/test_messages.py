"""Invalid arguments: each error names the argument, its value and the expected one, in words of Python."""

from __future__ import annotations

import inspect
import pickle
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import dualbody as db
import dualbody._dualbody as compiled
from dualbody.contact import Contacts, RelaxedRigid, Rigid, SoftContact, Terrain
from dualbody.sim import Actuation, Anchor, Ball, Weld


@pytest.fixture(scope="module")
def pole() -> db.Simulator:
    return db.Simulator(db.samples.cartpole(), time_step=0.01)


COUNTS = [
    ("steps", lambda s, n: s.rollout([0, 0], [0, 0], steps=n)),
    ("seed", lambda s, n: s.model.random_configuration(n)),
    ("seed", lambda s, n: s.model.random_velocity(n)),
    ("n", lambda s, n: db.samples.random_tree(n, 1)),
    ("threads", lambda s, n: db.set_threads(n)),
    ("bytes", lambda s, n: db.set_memory_limit(n)),
    ("v", lambda s, n: s.model.with_damping(n, 1.0)),
    ("points", lambda s, n: SoftContact.estimate(1.0, n, 1e-3)),
    ("mesh_points", lambda s, n: db.Simulator(s.model, contacts=Contacts(mesh_points=n))),
    ("robot", lambda s, n: db.Recording(s.model).trace("pole", n)),
    ("horizon", lambda s, n: db.trajopt.Ddp(db.trajopt.Problem(s, n, np.zeros(4))).solve()),
    ("max_iterations", lambda s, n: db.least_squares.solve(lambda x: x, lambda x: np.eye(1), [0.0], max_iterations=n)),
]


@pytest.mark.parametrize(("name", "call"), COUNTS)
def test_counts_are_named(pole: db.Simulator, name: str, call: Any) -> None:
    with pytest.raises(ValueError, match=f"^{name} is -1, expected no less than zero"):
        call(pole, -1)
    with pytest.raises(TypeError, match=f"^{name}: .*float"):
        call(pole, 1.5)
    with pytest.raises(ValueError, match=f"^{name} is {2**70}, which is too large"):
        call(pole, 2**70)


def test_parts_that_are_none_are_named(pole: db.Simulator) -> None:
    model = pole.model
    wrong: list[tuple[str, dict[str, Any]]] = [
        ("contacts is of the type Plane, expected Contacts", {"contacts": Terrain.flat()}),
        ("terrain is of the type str, expected Terrain", {"contacts": Contacts("flat")}),  # type: ignore[arg-type]
        ("law is of the type int, expected SoftContact, RelaxedRigid or Rigid", {"contacts": Contacts(law=3)}),  # type: ignore[arg-type]
        ("actuation is of the type float, expected Actuation", {"actuation": 1.0}),
        (r'actuators\["pivot"\] is of the type float', {"actuation": Actuation(actuators={"pivot": 2.0})}),  # type: ignore[dict-item]
        (r"constraints\[0\] is of the type str", {"constraints": ["weld"]}),
        (r"external_forces\[0\] is of the type Anchor", {"external_forces": [Anchor()]}),
        (r"a is of the type str, expected Anchor", {"constraints": [Ball("pole", Anchor())]}),  # type: ignore[arg-type]
    ]
    for text, parts in wrong:
        with pytest.raises(TypeError, match=text):
            db.Simulator(model, **parts)
    for text, parts in (('law is "hard"', {"contacts": Contacts(law="hard")}), ('actuation is "real"', {"actuation": "real"})):  # type: ignore[arg-type]
        with pytest.raises(ValueError, match=text):
            db.Simulator(model, **parts)


def test_kinds_by_name_are_those_objects() -> None:
    box = db.samples.load("box")
    q, v = box.neutral(), np.array([0.5, 0.0, -0.5, 0.1, 0.2, 0.3])
    q[2] = 0.05
    laws = {"rigid": Rigid(), "relaxed": RelaxedRigid(), "soft": SoftContact.estimate(box.total_mass, 4, 1e-3)}
    for name, law in laws.items():
        own, other = (db.Simulator(box, time_step=1e-4, contacts=Contacts(law=one)) for one in (name, law))  # type: ignore[arg-type]
        for x, y in zip(own.step(q, v), other.step(q, v), strict=True):
            np.testing.assert_array_equal(x, y)
        again = pickle.loads(pickle.dumps(own))
        np.testing.assert_array_equal(again.step(q, v)[1], own.step(q, v)[1])
    cartpole = db.samples.load("cartpole")
    short, long = (db.Simulator(cartpole, actuation=one) for one in ("model", Actuation("model")))
    assert short.parameter_names == long.parameter_names != db.Simulator(cartpole).parameter_names


def test_a_state_of_a_batch_is_named(pole: db.Simulator) -> None:
    good, bad = np.zeros((3, 2)), np.array([[0, 0], [0, 0], [np.nan, 0]])
    for call in (lambda q, u: pole.step(q, good, u), lambda q, u: pole.linearize(q, good, u)):
        with pytest.raises(ValueError, match=r"state 2 of the batch: q\[0\]"):
            call(bad, good)
        with pytest.raises(ValueError, match=r"state 2 of the batch: u\[0\]"):
            call(good, bad)
    with pytest.raises(ValueError, match=r"state 2 of the batch: q\[0\]"):
        pole.rollout(bad, good, steps=2)


FREE = """<robot name="r"><link name="base"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="continuous"><parent link="base"/><child link="l"/><axis xyz="0 0 1"/></joint>
<link name="l"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


def test_an_arm_that_floats_is_warned_of() -> None:
    with pytest.warns(UserWarning, match='"r" floats.*base="fixed" holds it'):
        arm = db.Model.from_urdf(FREE)
    for call in (lambda: db.mass_matrix(arm, [0.0]), lambda: db.Simulator(arm).step([0.0], [0.0])):
        with pytest.raises(ValueError, match=r"q has the shape \[1\].*base=.fixed. it stands"):
            call()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        db.Model.from_urdf(FREE, base="floating")
        db.Model.from_urdf(FREE, base="fixed")
        db.samples.load("quadruped")
        db.samples.load("box")


def test_no_message_has_words_of_rust(tmp_path: Any) -> None:
    report = db.samples.load("quadruped").import_report
    assert report is not None and "base=fixed" in str(report)
    texts = [str(report), report._repr_html_()]
    lost = '<robot name="r"><link name="a"><collision><geometry><mesh filename="absent.stl"/></geometry></collision></link></robot>'
    texts.append(str(db.Model.from_urdf(lost, roots=[tmp_path]).import_report))
    wrong = FREE.replace("<axis", '<mimic joint="none"/><axis')
    for call in (
        lambda: db.Model.from_urdf(wrong),
        lambda: db.Model.from_urdf("<robot name='r'><link name='a'/></robot>", base="floating").to_mjcf(),
        lambda: db.check_mass_matrix(db.Model.from_urdf("<robot name='r'><link name='a'/></robot>", base="floating")),
    ):
        with pytest.raises(ValueError) as caught:
            call()
        texts.append(str(caught.value))
    for text in texts:
        assert "::" not in text and "MasslessLinks" not in text, text


def test_signatures_show_their_defaults() -> None:
    found = []
    for owner in [compiled, *(own for own in vars(compiled).values() if inspect.isclass(own))]:
        for name, own in vars(owner).items():
            text = getattr(own, "__text_signature__", None)
            found += [f"{name}{text}"] if text and "..." in text else []
    assert found == []


def test_the_package_lists_what_it_has() -> None:
    public = [name for name in dir(db) if not name.startswith("__")]
    assert set(public) == set(db.__all__) - {"__version__"}
    assert all(hasattr(db, name) for name in public)


def test_reports_plots_and_recordings_pickle(pole: db.Simulator) -> None:
    report = db.samples.load("ur5", base="fixed").import_report
    assert pickle.loads(pickle.dumps(report)) == report
    plot = db.Plot("wave", x="t", y="x", size=(300, 200)).with_line("x", [0.0, 1.0, 2.0], [0.5, np.nan, 1.0])
    assert pickle.loads(pickle.dumps(plot)).to_svg() == plot.to_svg()
    recording = db.Recording.of_simulation(pole, pole.rollout([0.1, 0.2], [0.0, 0.0], steps=10))
    recording.title = "pole"
    recording.add_series("height", np.arange(11.0))
    recording.trace("pole")
    again = pickle.loads(pickle.dumps(recording))
    assert again.to_json() == recording.to_json() and again.to_html() == recording.to_html() and again.title == "pole"


def test_an_empty_report_has_no_table() -> None:
    bare = db.Model.from_urdf("<robot name='r'><link name='world'/></robot>").import_report
    assert bare is not None and "<table>" not in bare._repr_html_() and "FIXED" in bare._repr_html_()


def test_models_are_equal_by_content() -> None:
    text = db.samples.urdf("quadruped")
    one, other = db.Model.from_urdf(text), db.samples.load("quadruped")
    assert one == other and hash(one) == hash(other) and len({one, other}) == 1
    assert one == pickle.loads(pickle.dumps(one)) == one.with_parameters(one.parameters)
    joint = one.joint_names[0]
    assert one != one.with_damping(joint, 3.0) and one != "quadruped" and one != db.samples.cartpole()
    v = one.joint_v(joint).start
    assert one.with_damping(joint, 3.0) == one.with_damping(v, 3.0)
    assert one.with_damping(joint, 3.0).damping[v] == 3.0 and one.with_armature(joint, 0.5).armature[v] == 0.5
    with pytest.raises(KeyError, match="no joint"):
        one.with_damping("nose", 1.0)
    with pytest.raises(ValueError, match="v is 99"):
        one.with_damping(99, 1.0)


def test_kinds_are_written_in_one_way() -> None:
    box = db.samples.load("box")
    simulator = db.Simulator(box, time_step=1e-3, contacts=Contacts(law="rigid"))
    q = box.neutral()
    q[2] = 1.0
    report = simulator.contact_report(q, np.zeros(6))
    assert set(report.modes) == {"separated"} and report.certificate[0] == "converged"


def test_columns_of_inputs_have_the_names_of_what_they_act_on(tmp_path: Any) -> None:
    simulator = db.Simulator(db.samples.cartpole(), actuated=["pivot"])
    recording = db.Recording.of_simulation(simulator, simulator.rollout([0.1, 0.2], [0.0, 0.0], steps=3))
    table = recording.to_csv()
    assert table.splitlines()[0].split(",")[-1] == "u.pivot"
    recording.save_csv(tmp_path / "a" / "named.csv")
    assert (tmp_path / "a" / "named.csv").read_text() == table
    again = db.Recording.read(tmp_path / "a" / "named.csv", simulator.model)
    assert again.to_csv() == table


def test_numbers_that_would_become_nan_are_refused() -> None:
    model = db.samples.cartpole()
    q = model.neutral()
    for t in (np.nan, np.inf):
        with pytest.raises(ValueError, match="the fraction t must be finite"):
            model.interpolate(q, q, t)
    for period in (0.0, -1.0, np.nan):
        motion = db.identify.Excitation(period, np.zeros(2), np.zeros((2, 4)), 1.0, 1.0)
        with pytest.raises(ValueError, match="period of a motion must be positive and finite"):
            motion.at([0.5])


def test_a_joint_has_one_input() -> None:
    with pytest.raises(ValueError, match='the actuated joint "pivot" is named twice'):
        db.Simulator(db.samples.cartpole(), actuated=["pivot", "pivot"])


def test_a_weld_needs_anchors() -> None:
    with pytest.raises(TypeError, match="b is of the type tuple, expected Anchor"):
        db.Simulator(db.samples.cartpole(), constraints=[Weld(Anchor("pole"), (0.0, 0.0, 0.0))])  # type: ignore[arg-type]


def test_the_program_names_no_words_of_rust(tmp_path: Path) -> None:
    limited = FREE.replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 1"/><limit effort="1" velocity="2"/><dynamics friction="0.1"/>')
    file = tmp_path / "robot.urdf"
    file.write_text(limited.replace("</robot>", "<gazebo reference='j'><springStiffness>1</springStiffness></gazebo></robot>"))
    done = subprocess.run([sys.executable, "-m", "dualbody", "check", str(file)], capture_output=True, text=True)
    for words in ("base=fixed", "limits of position", "friction 0.1", "springStiffness"):
        assert words in done.stdout
    assert "::" not in done.stdout, done.stdout
