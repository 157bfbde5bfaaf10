"""Identification: data of robots whose numbers are known."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import OTHER_ALGORITHM, SAME_ALGEBRA

import dualbody as db
from dualbody import identify
from dualbody.identify import Channel, Dataset, Experiment, Inertia, Parameter, Preparation, Regressor, Segment

ARM = db.samples.double_pendulum()


def motion(model: db.Model, n: int = 400) -> Segment:
    """A motion with its exact forces, sampled without noise."""
    t = 0.02 * np.arange(n)[:, None]
    k = 1.0 + np.arange(model.nv)
    q = np.sin(k * t) + 0.3 * np.cos(2.3 * k * t)
    v = k * np.cos(k * t) - 0.69 * k * np.sin(2.3 * k * t)
    a = -k * k * np.sin(k * t) - 1.587 * k * k * np.cos(2.3 * k * t)
    return Segment("sweep", 0.0, 50.0, q, v, a, db.inverse_dynamics(model, q, v, a) + model.damping * v)


def test_exact_data_give_exact_numbers() -> None:
    robot = ARM.with_damping(0, 0.3).with_damping(1, 0.1)
    learn, held = Dataset([motion(robot)]).hold_back(0.25)
    assert (learn.n_samples, held.n_samples, held.segments[0].start) == (300, 100, 6.0)
    regressor = Regressor(ARM, damping=True)
    found = identify.estimate(regressor, learn)
    damping = [k for k, name in enumerate(regressor.names) if name.endswith("damping")]
    np.testing.assert_allclose(found.unknowns[damping], [0.3, 0.1], atol=OTHER_ALGORITHM)
    assert found.robot().validate(held).coordinates[0].rms < OTHER_ALGORITHM
    s = held.segments[0]
    np.testing.assert_allclose(found.robot().predict(s.q, s.v, s.a), s.tau, atol=OTHER_ALGORITHM)
    # Y x = tau for the true parameters, and base parameters hold all that Y tells.
    truth = Regressor(robot, damping=True)
    y = truth.matrix(s.q, s.v, s.a)
    np.testing.assert_allclose(y @ truth.nominal, s.tau, atol=SAME_ALGEBRA * 100)
    base = truth.base_parameters()
    values = truth.nominal[base.independent] + base.combination @ truth.nominal[base.dependent]
    np.testing.assert_allclose(y[..., base.independent] @ values, s.tau, atol=OTHER_ALGORITHM)
    np.testing.assert_allclose(found.values, values, atol=1e-8)


def test_noise_widens_intervals_that_hold_the_truth_and_bodies_stay_bodies(tmp_path: Path) -> None:
    exact = motion(ARM)
    noisy = exact.tau + 0.05 * np.random.default_rng(0).normal(size=exact.tau.shape)
    segment = Segment("noisy", 0.0, 50.0, exact.q, exact.v, exact.a, noisy)
    regressor = Regressor(ARM.with_link_mass(ARM.link_names[-1], 1.7))
    found = identify.estimate(regressor, Dataset([segment]))
    np.testing.assert_allclose(found.force_deviations, 0.05, rtol=0.15)
    truth = Regressor(ARM)
    base = found.regressor.base_parameters()
    values = truth.nominal[base.independent] + base.combination @ truth.nominal[base.dependent]
    inside = [i.lower <= x <= i.upper for i, x in zip(found.intervals(0.999), values, strict=True)]
    assert all(inside)
    consistent = found.consistent()
    assert not consistent.robot.model.inertia_flaws() and consistent.excess < len(values) + 10
    np.testing.assert_allclose(found.information @ found.covariance, np.eye(len(values)), atol=1e-6)
    again = pickle.loads(pickle.dumps(found))
    assert again.intervals() == found.intervals() and repr(again) == repr(found)
    np.testing.assert_array_equal(again.consistent().unknowns, consistent.unknowns)
    np.testing.assert_array_equal(again.robot().model.parameters, found.robot().model.parameters)
    with pytest.raises(ValueError, match="^covariance has the shape"):
        replace(found, covariance=np.eye(1)).intervals()
    report = found.report(consistent.robot, Dataset([segment]))
    report.save_html(tmp_path / "report.html")
    assert "base parameters" in str(report) and (tmp_path / "report.html").read_text().startswith("<!doctype html>")
    assert "<iframe" in report._repr_html_() and "base parameters" in repr(found)


def swing() -> tuple[db.Simulator, db.Rollout]:
    robot = db.samples.cartpole().with_damping(0, 0.4).with_damping(1, 0.05)
    simulator = db.Simulator(robot, time_step=1e-3)
    t = 1e-3 * np.arange(3000)
    u = np.stack([4 * np.sin(7 * t) + 2 * np.cos(3 * t), 0.5 * np.sin(5 * t)], axis=1)
    return simulator, simulator.rollout([0.0, 2.0], [0.0, 0.0], inputs=u)


def test_a_rollout_becomes_data_and_data_a_robot() -> None:
    simulator, rollout = swing()
    nominal = db.samples.cartpole()
    experiment = Experiment.from_rollout("push", simulator, rollout)
    data = Preparation(4, 2).prepare(nominal, [experiment])
    assert data.n_samples == 3000 - 8 and not data.left_out
    consistent = identify.estimate(Regressor(nominal, damping=True), data).consistent()
    np.testing.assert_allclose(consistent.robot.model.damping, [0.4, 0.05], atol=0.02)
    # Through the simulator, from a wrong first guess.
    shots = Preparation(4, 2, decimation=1).prepare(nominal, [experiment])
    start = simulator.replace(model=simulator.model.with_damping(0, 0.1))
    (name,) = [n for n in start.model.parameter_names if n.endswith("damping") and "linear" in n]
    found = identify.shoot(start, shots, [Parameter(name)], samples=100, max_iterations=20)
    assert found.is_converged and abs(found.values[0] - 0.4) < 0.01
    assert found.model.damping[0] == found.values[0] and found.intervals is not None
    assert pickle.loads(pickle.dumps(data)).segments[0].experiment == "push"


def test_channels_have_units_gaps_and_names() -> None:
    pendulum = db.samples.pendulum()
    angle = np.sin(0.02 * np.arange(500.0))
    angle[240:260] = np.nan
    degrees = Experiment("swing", [Channel("pivot", "position", np.degrees(angle), "degree")], 100.0, passive=["pivot"])
    data = Preparation(8, 4).prepare(pendulum, [degrees])
    assert len(data.segments) == 2
    np.testing.assert_allclose(data.segments[0].a[0, 0], -4 * np.sin(0.16), atol=1e-6)
    for channels, error, text in [
        ([Channel("nobody", "position", angle)], (KeyError, ValueError), "nobody"),
        ([Channel("pivot", "position", angle, "furlong")], ValueError, "unit"),
        ([], ValueError, "position"),
    ]:
        with pytest.raises(error, match=text):
            Preparation(8, 4).prepare(pendulum, [Experiment("swing", channels, 100.0, passive=["pivot"])])
    with pytest.raises(KeyError, match="forearm"):
        _ = Regressor(pendulum, known_links=["forearm"]).names
    with pytest.raises(ValueError, match="degree"):
        Preparation(1, 5).prepare(pendulum, [degrees])


def test_an_exciting_motion_is_better_than_its_start() -> None:
    motion = identify.excite(Regressor(ARM), harmonics=3, max_iterations=10, starts=1)
    assert motion.condition < motion.start_condition
    q, v, _ = motion.at([0.3, 1.7, 1.7 + motion.period])
    np.testing.assert_allclose(q[1], q[2], atol=1e-9)
    h = 1e-6
    near = motion.at([1.7 - h, 1.7 + h])[0]
    np.testing.assert_allclose((near[1] - near[0]) / (2 * h), v[1], atol=1e-6)
    with pytest.raises(TypeError, match="harmonic"):
        identify.excite(Regressor(ARM), harmonic=3)  # type: ignore[call-arg]


def test_an_inertia_is_found_by_shooting() -> None:
    simulator, rollout = swing()
    data = Preparation(4, 2).prepare(simulator.model, [Experiment.from_rollout("push", simulator, rollout)])
    link = simulator.model.link_names[-1]
    wrong = simulator.replace(model=simulator.model.with_link_mass(link, 1.3))
    found = identify.shoot(wrong, data, [Inertia(link)], samples=100, max_iterations=20)
    assert len(found.values) == 10 and not found.model.inertia_flaws()
    q, v = np.array([0.1, 0.7]), np.array([0.2, -0.4])
    expected = db.forward_dynamics(simulator.model, q, v, [0.5, 0.1])
    np.testing.assert_allclose(db.forward_dynamics(found.model, q, v, [0.5, 0.1]), expected, rtol=2e-2)


def test_the_mass_of_a_link_is_found_with_its_moments() -> None:
    simulator, rollout = swing()
    data = Preparation(4, 2).prepare(simulator.model, [Experiment.from_rollout("push", simulator, rollout)])
    link = simulator.model.link_names[-1]
    wrong = simulator.replace(model=simulator.model.with_link_mass(link, 1.3))
    found = identify.shoot(wrong, data, [identify.LinkMass(link)], samples=100, max_iterations=20)
    names, true = simulator.model.parameter_names, simulator.model.parameters
    start = names.index(f"{link}: mass")
    np.testing.assert_allclose(found.values, true[start], rtol=1e-2)
    # All ten parameters of the body, in proportion.
    own = found.model.parameters[start : start + 10]
    np.testing.assert_allclose(own, true[start : start + 10] * (own[0] / true[start]), atol=1e-12)
    with pytest.warns(UserWarning, match="LinkMass"):
        identify.shoot(wrong, data, [Parameter(f"{link}: mass")], samples=100, max_iterations=1)
    with pytest.raises(KeyError):
        identify.shoot(wrong, data, [identify.LinkMass("nose")])
