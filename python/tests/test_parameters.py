"""All parameters of a simulator: their values, derivatives in them, and robots that differ within a batch."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import dualbody as db
from dualbody.contact import Contacts, Terrain
from dualbody.sim import Actuation, Actuator, TendonServo

STEPS = 20
#: Of central differences.
DIFFERENCES = 1e-6


@pytest.fixture(scope="module")
def rubbed() -> db.Simulator:
    """A cart-pole with dry friction in its pivot and a motor on its rail."""
    motors = {"pivot": Actuator(friction=(0.3, 0.05)), "linear": Actuator(torque_speed=(8.0, 0.5, 6.0))}
    return db.Simulator(db.samples.cartpole(), time_step=0.01, actuation=Actuation(actuators=motors))


def end(simulator: db.Simulator) -> float:
    rollout = simulator.rollout([0.1, 0.3], [0.9, 0.5], inputs=np.full((STEPS, 2), 6.0))
    return float(rollout.q[-1].sum())


@pytest.mark.parametrize("name", ["pivot: Coulomb friction", "pivot: slip velocity", "linear: motor torque", "time step", "pole: mass"])
def test_slopes_in_numbers_of_the_simulator_equal_differences(rubbed: db.Simulator, name: str) -> None:
    names = rubbed.parameter_names
    k = names.index(name)
    weights = np.zeros((STEPS + 1, 2))
    weights[-1] = 1.0
    gradient = rubbed.rollout_vjp([0.1, 0.3], [0.9, 0.5], np.full((STEPS, 2), 6.0), by_q=weights)
    ends = []
    for sign in (1.0, -1.0):
        x = rubbed.parameters
        x[k] += sign * 1e-6
        ends.append(end(rubbed.with_parameters(x)))
    slope = (ends[0] - ends[1]) / 2e-6
    assert abs(gradient.simulator_parameters[k] - slope) < DIFFERENCES * max(1.0, abs(slope))
    n = len(rubbed.model.parameters)
    np.testing.assert_array_equal(gradient.simulator_parameters[:n], gradient.parameters)
    assert gradient.simulator_parameters.shape == rubbed.parameters.shape == (len(names),)
    step = rubbed.vjp([0.1, 0.3], [0.9, 0.5], [6.0, 6.0], np.ones(4))
    assert step.simulator_parameters.shape == (len(names),)


def test_parameters_of_a_simulator_are_set_and_pickle(rubbed: db.Simulator) -> None:
    x = rubbed.parameters
    k = rubbed.parameter_names.index("time step")
    assert x[k] == 0.01
    x[k] = 0.02
    changed = rubbed.with_parameters(x)
    assert changed.time_step == 0.02 and changed.model == rubbed.model
    again = pickle.loads(pickle.dumps(changed))
    np.testing.assert_array_equal(again.parameters, x)
    assert end(again) == end(changed) != end(rubbed)
    with pytest.raises(ValueError, match="give parameters too"):
        changed.replace(integrator="implicit_velocity")
    assert changed.replace(parameters=None).time_step == 0.01
    x[k] = -1.0
    with pytest.raises(ValueError, match="time step"):
        rubbed.with_parameters(x)


def test_robots_differ_within_a_batch() -> None:
    models = [db.samples.cartpole().with_damping("pivot", 0.1 * k) for k in range(11)]
    simulator = db.Simulator(models[0], time_step=0.01)
    rng = np.random.default_rng(1)
    q, v, u = (rng.uniform(-1, 1, (11, 2)) for _ in range(3))
    q1, v1 = simulator.step(q, v, u, models=models)
    a, b = simulator.linearize(q, v, u, models=models)
    weights, inputs = rng.uniform(-1, 1, (11, 4)), rng.uniform(-1, 1, (11, 5, 2))
    by_q = np.ones((11, 6, 2))
    step = simulator.vjp(q, v, u, weights, models=models)
    rollout = simulator.rollout_vjp(q, v, inputs, by_q=by_q, models=models)
    for k, model in enumerate(models):
        own = simulator.replace(model=model)
        np.testing.assert_array_equal(own.step(q[k], v[k], u[k])[1], v1[k])
        np.testing.assert_allclose(own.linearize(q[k], v[k], u[k]).a, a[k], atol=1e-13)
        np.testing.assert_allclose(own.vjp(q[k], v[k], u[k], weights[k]).parameters, step.parameters[k], atol=1e-12)
        one = own.rollout_vjp(q[k], v[k], inputs[k], by_q=by_q[k])
        np.testing.assert_allclose(one.simulator_parameters, rollout.simulator_parameters[k], atol=1e-12)
    assert b.shape == (11, 4, 2) and q1.shape == q.shape
    with pytest.raises(ValueError, match="10 models for 11 states"):
        simulator.step(q, v, models=models[1:])
    with pytest.raises(ValueError, match="models are for a batch"):
        simulator.linearize(q[0], v[0], models=models[:1])
    with pytest.raises(ValueError, match="joint"):
        simulator.vjp(q, v, u, weights, models=[db.samples.double_pendulum()] * 11)


def test_ground_from_a_function_is_that_function() -> None:
    ground = Terrain.function(lambda x, y: 0.1 * np.sin(2 * x) + 0.05 * np.cos(y), (-2.0, 2.0), (-1.0, 1.0), 0.05)
    for x, y in [(0.31, 0.12), (-0.77, 0.4), (1.2, -0.33)]:
        height, by_x, by_y = ground.surface(x, y)
        assert height == pytest.approx(0.1 * np.sin(2 * x) + 0.05 * np.cos(y), abs=1e-6)
        assert by_x == pytest.approx(0.2 * np.cos(2 * x), abs=1e-4) and by_y == pytest.approx(-0.05 * np.sin(y), abs=1e-4)
    level = Terrain.function(lambda x, y: 0.25, (0.0, 1.0), (0.0, 1.0), 0.5)
    assert level.surface(0.3, 0.3)[0] == pytest.approx(0.25)
    box = db.samples.load("box")
    db.Simulator(box, contacts=Contacts(ground, "rigid"))
    with pytest.raises(ValueError, match="spacing"):
        Terrain.function(lambda x, y: x, (0, 1), (0, 1), 0.0)
    with pytest.raises(ValueError, match="empty"):
        Terrain.function(lambda x, y: x, (1, 0), (0, 1), 0.1)


def test_servos_take_ranges_of_input_and_force() -> None:
    motor = Actuator(servo=(2.0, 3.0, 0.0, 0.0, 0.0), input_range=(-1.0, 2.0), force_range=(-2.0, 5.0))
    simulator = db.Simulator(db.samples.pendulum(), actuation=Actuation(actuators={"pivot": motor}))
    assert [bound[0] for bound in simulator.effort_bounds] == [-1.0, 2.0]
    still, *pushed = (simulator.acceleration([0.0], [0.0], [u])[0] for u in (0.0, 0.5, 9.0, -9.0))
    force = np.array(pushed) - still
    assert np.allclose(force / force[0], [1.0, 10.0 / 3.0, -4.0 / 3.0])
    with pytest.raises(ValueError, match="there is none"):
        Actuator(input_range=(-1.0, 1.0))


def test_servos_along_tendons_have_inputs_of_their_own() -> None:
    model = db.samples.double_pendulum().with_gravity([0, 0, 0])
    joints = dict.fromkeys(model.joint_names, 1.0)
    both = TendonServo("sum", joints, servo=(1.0, 1e4, 0.0, 1e4, 100.0), input_range=(-0.5, 0.5))
    simulator = db.Simulator(model, time_step=0.01, actuated=[], tendon_servos=[both])
    assert simulator.input_names == ["sum"] and simulator.effort_bounds[1][0] == 0.5
    rollout = simulator.rollout([0.0, 0.0], [0.0, 0.0], inputs=np.tile([0.4], (300, 1)))
    assert abs(rollout.q[-1].sum() - 0.4) < 1e-3
    pushed = simulator.acceleration([0.0, 0.0], [0.0, 0.0], [0.4], forces={model.link_names[-1]: [0, 0, 0, 0, 0, 0]})
    assert np.allclose(pushed, simulator.acceleration([0.0, 0.0], [0.0, 0.0], [0.4]))


def test_servos_are_stable_and_dry_friction_holds() -> None:
    stiff, held = Actuator(servo=(1.0, 1e4, 0.0, 1e4, 100.0)), Actuator(friction=0.2)
    simulator = db.Simulator(db.samples.cartpole(), time_step=0.01, actuation=Actuation(actuators={"linear": stiff, "pivot": held}))
    rest = simulator.step([0.0, 0.01], [0.0, 0.0], [0.0, 0.0])
    assert rest[1][1] == 0.0
    rollout = simulator.rollout([0.0, 0.0], [0.0, 0.0], inputs=np.tile([0.3, 0.0], (500, 1)))
    assert abs(rollout.q[-1][0] - 0.3) < 1e-2
