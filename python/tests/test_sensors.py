"""Sensors: readings, their Jacobians, noise, of one state and of batches."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import dualbody as db
from dualbody.contact import Contacts, Rigid, Terrain
from dualbody.sim import Sensor, SensorNoise, Sensors, Simulator


def pendulum() -> tuple[Simulator, Sensors]:
    simulator = Simulator(db.samples.pendulum(), time_step=0.01)
    sensors = {
        "encoder": Sensor("joint_position", "pivot"),
        "imu": Sensor("accelerometer", "rod"),
        "gyro": Sensor("gyro", "rod"),
        "bearing": Sensor("wrench", "rod"),
        "torque": Sensor("joint_force", "pivot"),
        "field": Sensor("magnetometer", "rod", field=(0.2, 0.0, -0.5)),
        "speed": Sensor("frame_velocity", "rod", representation="mixed"),
        "com": Sensor("center_of_mass"),
    }
    return simulator, Sensors(simulator.model, sensors)


def test_readings_equal_the_closed_forms() -> None:
    simulator, sensors = pendulum()
    q, v, u = 0.7, -2.0, 0.4
    y = sensors.read(simulator, [q], [v], [u])
    alpha = 3.0 * u - 1.5 * 9.81 * np.sin(q)
    of = {name: y[sensors.slice(name)] for name in ("encoder", "imu", "gyro", "bearing", "torque", "field", "com")}
    assert y.shape == (len(sensors),) == (len(sensors.units),)
    assert sensors.names[:4] == ["encoder", "imu.x", "imu.y", "imu.z"] and sensors.units[:2] == ["rad", "m/s²"]
    np.testing.assert_allclose(of["encoder"], [q])
    np.testing.assert_allclose(of["imu"], [0.0, 9.81 * np.sin(q), 9.81 * np.cos(q)], atol=1e-12)
    np.testing.assert_allclose(of["gyro"], [v, 0.0, 0.0], atol=1e-14)
    force = [0.0, 0.5 * alpha + 9.81 * np.sin(q), 0.5 * v * v + 9.81 * np.cos(q)]
    np.testing.assert_allclose(of["bearing"], [*force, u, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(of["torque"], [u], atol=1e-12)
    np.testing.assert_allclose(of["field"], [0.2, -0.5 * np.sin(q), -0.5 * np.cos(q)], atol=1e-12)
    np.testing.assert_allclose(of["com"], [0.0, 0.5 * np.sin(q), -0.5 * np.cos(q)], atol=1e-12)


def test_a_lidar_has_a_reading_for_each_ray() -> None:
    simulator, _ = pendulum()
    scan = Sensor("lidar", "rod", range=7.0, horizontal=(3, -0.5, 0.5), vertical=(2, 0.0, 0.1))
    sensors = Sensors(simulator.model, {"scan": scan})
    assert sensors.names == [f"scan.{k}" for k in range(6)] and sensors.units == ["m"] * 6
    np.testing.assert_array_equal(sensors.read(simulator, [0.3], [0.0], [0.0]), [7.0] * 6)
    with pytest.raises(ValueError, match="horizontal is not a number of rays"):
        Sensors(simulator.model, {"scan": Sensor("lidar", "rod", horizontal=(-1, 0.0, 0.0))})


def test_batches_give_the_readings_of_single_states(quadruped: db.Model) -> None:
    model = quadruped
    simulator = Simulator(model, contacts=Contacts(Terrain.flat(), Rigid()))
    links = model.link_names
    sensors = Sensors(model, {"imu": Sensor("accelerometer", links[0]), "touch": Sensor("touch", links[-1]), "h": Sensor("momentum")})
    q = np.stack([model.random_configuration(k) for k in range(11)])
    v = np.stack([model.random_velocity(k) for k in range(11)])
    u = np.random.default_rng(2).normal(size=(11, simulator.nu))
    y = sensors.read(simulator, q, v, u)
    assert y.shape == (11, len(sensors))
    for k in range(11):
        np.testing.assert_array_equal(y[k], sensors.read(simulator, q[k], v[k], u[k]))
    out = np.empty_like(y)
    assert sensors.read(simulator, q, v, u, out=out) is out
    np.testing.assert_array_equal(out, y)
    assert sensors.read(simulator, q[:0], v[:0]).shape == (0, len(sensors))


def test_jacobians_equal_differences() -> None:
    simulator, sensors = pendulum()
    q, v, u = np.array([[0.3], [-1.0]]), np.array([[1.0], [2.0]]), np.array([[0.5], [0.0]])
    a, b, c, d = sensors.linearize(simulator, q, v, u)
    assert c.shape == (2, len(sensors), 2) and d.shape == (2, len(sensors), 1)
    own = simulator.linearize(q, v, u)
    np.testing.assert_array_equal(a, own.a)
    np.testing.assert_array_equal(b, own.b)
    h = 1e-6
    by_q = (sensors.read(simulator, q + h, v, u) - sensors.read(simulator, q - h, v, u)) / (2 * h)
    by_u = (sensors.read(simulator, q, v, u + h) - sensors.read(simulator, q, v, u - h)) / (2 * h)
    np.testing.assert_allclose(c[..., 0], by_q, atol=1e-7)
    np.testing.assert_allclose(d[..., 0], by_u, atol=1e-7)


def test_noise_follows_the_seed_of_each_state() -> None:
    _, sensors = pendulum()
    noise = {"gyro": SensorNoise(white=0.1, bias=0.2), "encoder": SensorNoise(resolution=0.5)}
    exact = np.tile(np.linspace(0.0, 1.0, len(sensors)), (3, 1))
    all_states = sensors.noisy(noise, 1e-3, [5, 6, 7])
    y = all_states.sample(exact)
    alone = sensors.noisy(noise, 1e-3, [6]).sample(exact[0])
    np.testing.assert_array_equal(y[1], alone)
    gyro = sensors.slice("gyro")
    assert (y[:, gyro] != exact[:, gyro]).all() and len(np.unique(y[:, gyro])) == 9
    untouched = np.ones(len(sensors), bool)
    untouched[gyro] = untouched[0] = False
    np.testing.assert_array_equal(y[:, untouched], exact[:, untouched])
    all_states.reset([6, 6, 6], [True, False, False])
    again = all_states.sample(exact)
    np.testing.assert_array_equal(again[0], alone)
    assert (again[1, gyro] != alone[gyro]).all()
    with pytest.raises(ValueError, match="3 seeds"):
        all_states.sample(exact[:2])


def test_sensors_pickle_and_refuse_what_is_wrong() -> None:
    simulator, sensors = pendulum()
    again = pickle.loads(pickle.dumps(sensors))
    np.testing.assert_array_equal(again.read(simulator, [0.1], [0.2]), sensors.read(simulator, [0.1], [0.2]))
    model = simulator.model
    with pytest.raises(ValueError, match="sensors\\[\"a\"\\] is of the kind \"sonar\""):
        Sensors(model, {"a": Sensor("sonar", "rod")})  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="is on nothing"):
        Sensors(model, {"a": Sensor("gyro")})
    with pytest.raises((ValueError, KeyError), match="rodd"):
        Sensors(model, {"a": Sensor("gyro", "rodd")})
    with pytest.raises(TypeError, match="expected Sensor"):
        Sensors(model, {"a": "gyro"})  # type: ignore[dict-item]
    with pytest.raises(KeyError, match="missing"):
        sensors.slice("missing")
    with pytest.raises(ValueError, match="another robot"):
        sensors.read(Simulator(db.samples.cartpole()), [0.0, 0.0], [0.0, 0.0])


SDF = """<sdf version="1.9"><model name="pendulum"><link name="rod"><inertial><pose>0 0 -0.5 0 0 0</pose><mass>2</mass>
<inertia><ixx>0.1</ixx><ixy>0</ixy><ixz>0</ixz><iyy>0.1</iyy><iyz>0</iyz><izz>0.1</izz></inertia></inertial>
<sensor name="imu" type="imu"><pose>0 0 -1 0 0 0</pose><update_rate>50</update_rate><imu><angular_velocity>
<x><noise type="gaussian"><mean>0.5</mean><stddev>0.1</stddev></noise></x>
<y><noise type="gaussian"><mean>0.5</mean><stddev>0.1</stddev></noise></y>
<z><noise type="gaussian"><mean>0.5</mean><stddev>0.1</stddev></noise></z></angular_velocity></imu></sensor>
<sensor name="eye" type="lidar"/><sensor name="camera" type="camera"/></link>
<joint name="hinge" type="revolute"><parent>world</parent><child>rod</child><axis><xyz>0 1 0</xyz></axis></joint></model></sdf>"""


def test_sensors_of_a_file_are_read_with_their_noise() -> None:
    model = db.Model.from_sdf(SDF)
    sensors = {name: sensor for name, (sensor, _) in model.sensors.items()}
    noise = {name: noise for name, (_, noise) in model.sensors.items()}
    assert list(sensors) == ["imu/gyro", "imu/accelerometer", "eye"]
    assert sensors["eye"].on == "rod" and tuple(sensors["eye"].direction) == (1.0, 0.0, 0.0) and sensors["eye"].range == 1000.0
    assert noise["imu/gyro"] == SensorNoise(offset=0.5, white=0.1, period=0.02)
    made = Sensors(model, sensors)
    y = made.read(Simulator(model), [0.0], [1.5], [0.0])
    np.testing.assert_allclose(y[made.slice("imu/gyro")], [0.0, 1.5, 0.0], atol=1e-12)
    np.testing.assert_allclose(y[made.slice("imu/accelerometer")], [0.0, 0.0, 9.81 + 1.5**2], atol=1e-12)
    assert made.missing_shapes == []
    noisy = made.noisy({"imu/gyro": SensorNoise(offset=0.5)}, 1e-3, [1])
    np.testing.assert_allclose(noisy.sample(np.zeros((1, 7)))[0], [0.5, 0.5, 0.5, 0.0, 0.0, 0.0, 0.0])
    assert list(pickle.loads(pickle.dumps(model)).sensors) == list(sensors)
    assert model.import_report is not None and "camera" in str(model.import_report)
    assert db.samples.pendulum().sensors == {}
