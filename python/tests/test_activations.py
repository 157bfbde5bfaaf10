"""Activations of inputs: lags, integrals, delays and learned actuators."""

import pickle

import numpy as np
import pytest

import dualbody as db
from dualbody.sim import Activation, ActuatorNetwork

NETWORK = ActuatorNetwork([([[1.0, 0.5, -0.2, 0.1], [0.3, -0.4, 0.1, 0.2]], [0.1, -0.2]), ([[4.0, -3.0]], [0.05])], ages=(0, 2))


def cartpole(**activations):
    return db.Simulator(db.samples.cartpole(), time_step=0.01, activations=activations)


def test_closed_forms_of_lag_integral_and_delay():
    simulator = cartpole(linear=Activation("filter", 0.02, delay=1), pivot=Activation("integrator", range=(-1.0, 0.015)))
    assert (simulator.n_activation, simulator.n_contact, simulator.n_tangent) == (3, 3, 7)
    assert simulator.tangent_names[4:] == ["activation0", "activation1", "activation2"]
    rollout = simulator.rollout([0.0, 0.0], [0.0, 0.0], 4, control=lambda k, q, v: [2.0, 1.0])
    decay = np.exp(-0.5)
    lag = [0.0, 0.0, 2.0 * (1.0 - decay), 2.0 * (1.0 - decay**2), 2.0 * (1.0 - decay**3)]
    np.testing.assert_allclose(rollout.contact[:, 1], lag, atol=1e-15)
    np.testing.assert_allclose(rollout.contact[:, 2], [0.0, 0.01, 0.015, 0.015, 0.015], atol=1e-15)
    np.testing.assert_allclose(rollout.contact[:, 0], [0.0, 2.0, 2.0, 2.0, 2.0])


@pytest.mark.parametrize("activation", [Activation("filter", 0.02, delay=2), Activation(NETWORK, delay=1), Activation("explicit_filter", 0.05, early=True)])
def test_jacobians_equal_differences_and_batches_equal_single_steps(activation):
    simulator = cartpole(linear=activation)
    generator = np.random.default_rng(1)
    q, v, u = generator.uniform(-0.5, 0.5, (3, 5, 2))
    w = generator.uniform(-0.5, 0.5, (5, simulator.n_contact))
    batch = simulator.step(q, v, u, contact=w)
    for k in range(5):
        one = simulator.step(q[k], v[k], u[k], contact=w[k])
        for x, y in zip(batch, one):
            np.testing.assert_array_equal(x[k], y)
    a, b = simulator.linearize(q[0], v[0], u[0], contact=w[0])
    x = np.concatenate([q[0], v[0], w[0], u[0]])

    def step(x):
        return np.concatenate(simulator.step(x[:2], x[2:4], x[-2:], contact=x[4:-2]))

    for k in range(len(x)):
        h = 1e-6 * np.eye(len(x))[k]
        difference = (step(x + h) - step(x - h)) / 2e-6
        np.testing.assert_allclose(np.hstack([a, b])[:, k], difference, atol=1e-7)


def test_simulators_with_activations_pickle_and_their_time_constants_are_parameters():
    simulator = cartpole(linear=Activation("filter", 0.02), pivot=Activation(NETWORK))
    again = pickle.loads(pickle.dumps(simulator))
    given = ([0.1, 0.2], [0.3, 0.4], [1.0, 2.0])
    for x, y in zip(simulator.step(*given), again.step(*given)):
        np.testing.assert_array_equal(x, y)
    assert "activation of linear: time constant" in simulator.parameter_names


def test_mjcf_has_its_activations():
    text = """<mujoco><worldbody><body><joint name="j"/><geom size="0.1"/></body></worldbody>
      <actuator><position joint="j" kp="3" timeconst="0.05"/></actuator></mujoco>"""
    simulator = db.Simulator.from_mjcf(text)
    assert simulator.n_activation == 1
    _, _, w = simulator.step([0.0], [0.0], [1.0])
    assert abs(w[0] - (1.0 - np.exp(-simulator.time_step / 0.05))) < 1e-12


@pytest.mark.parametrize(
    ("activations", "expected"),
    [
        ({"elbow": Activation()}, "elbow"),
        ({"linear": Activation("filter")}, "no time_constant"),
        ({"linear": Activation("filter", -1.0)}, "time constant"),
        ({"linear": Activation("lag", 1.0)}, "explicit_filter"),
        ({"linear": Activation(ActuatorNetwork([([[1.0]], [0.0])]))}, "expected 2 columns"),
        ({"linear": Activation(delay=10**6)}, "steps"),
        ({"linear": Activation("integrator", range=(1.0, -1.0))}, "not in order"),
    ],
)
def test_what_makes_no_activation_is_refused(activations, expected):
    with pytest.raises((ValueError, KeyError, TypeError), match=expected):
        cartpole(**activations)
