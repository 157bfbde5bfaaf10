"""Steps, rollouts, Jacobians; single states and batches."""

from __future__ import annotations

import dataclasses
import pickle
from pathlib import Path

import numpy as np
import pytest
from conftest import ASSETS, asset

import dualbody as db
from dualbody.contact import Contacts, HeightField, HuntCrossley, RelaxedRigid, Rigid, SoftContact, SolverOptions, Terrain
from dualbody.sim import Actuation, Actuator, Anchor, Ball, Coupler, Distance, ExternalForce, FrameActuator, Regularisation, Tendon, Weld

DT = 0.01


@pytest.fixture(scope="module")
def pole() -> db.Simulator:
    return db.Simulator(db.Model.from_urdf(asset("cartpole")), time_step=DT, actuated=["linear"])


def starts(n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.uniform(-1, 1, (n, 2)), rng.uniform(-1, 1, (n, 2))


def test_computed_torque_gives_the_numbers_that_are_known_for_this_cartpole(cartpole: db.Model) -> None:
    # -0.25 m, 160°, 3 m/s, 10° per time step; values of an independent engine.
    simulator = db.Simulator(cartpole, time_step=DT)
    controller = db.ComputedTorque(cartpole, 10.0, 6.0)
    q, v = np.array([-0.25, np.radians(160)]), np.array([3.0, np.radians(10) / DT])
    rollout = simulator.rollout(q, v, steps=500, control=lambda k, q, v: controller.torque(q, v, cartpole.neutral()))
    np.testing.assert_allclose(rollout.u[0], [-28.36506, -26.58803], atol=1e-5)
    np.testing.assert_allclose(rollout.q[1], [-0.22155, 2.95380], atol=1e-5)
    np.testing.assert_allclose(rollout.v[1], [2.845, 16.12684], atol=1e-5)
    assert np.abs(rollout.q[-1]).max() < 1e-4 and np.abs(rollout.v[-1]).max() < 1e-4


def test_a_rollout_is_its_steps(pole: db.Simulator) -> None:
    (q,), (v,) = starts(1)
    u = np.sin(np.arange(50))[:, None]
    rollout = pole.rollout(q, v, inputs=u)
    assert rollout.q.shape == (51, 2) and rollout.u.shape == (50, 1) and rollout.status.is_completed
    assert rollout.times[-1] == pytest.approx(0.5)
    for k in range(50):
        np.testing.assert_array_equal(rollout.q[k], q)
        q, v = pole.step(q, v, u[k])
    np.testing.assert_array_equal(rollout.v[-1], v)
    controlled = pole.rollout(rollout.q[0], rollout.v[0], steps=50, control=lambda k, q, v: u[k])
    np.testing.assert_array_equal(controlled.q, rollout.q)
    np.testing.assert_array_equal(controlled.u, u)
    numbers = pole.rollout(rollout.q[0], rollout.v[0], steps=50, control=lambda k, q, v: float(u[k, 0]))
    np.testing.assert_array_equal(numbers.q, rollout.q)


@pytest.mark.parametrize("n", [1, 7, 8, 37])
def test_batches_equal_single_states(pole: db.Simulator, n: int) -> None:
    q, v = starts(n)
    u = np.random.default_rng(1).normal(size=(n, 30, 1))
    together = pole.rollout(q, v, inputs=u)
    assert together.q.shape == (n, 31, 2) and together.is_completed and len(together) == n
    for i in range(n):
        single = pole.rollout(q[i], v[i], inputs=u[i])
        np.testing.assert_allclose(together[i].q, single.q, atol=1e-9)
    stepped = pole.step(q, v, u[:, 0])
    np.testing.assert_array_equal(stepped[0], together.q[:, 1])
    controlled = pole.rollout(q, v, steps=30, control=lambda k, q, v: u[:, k])
    np.testing.assert_array_equal(controlled.v, together.v)
    linear = pole.linearize(q, v, u[:, 0])
    assert linear.a.shape == (n, 4, 4) and linear.b.shape == (n, 4, 1)
    np.testing.assert_array_equal(linear.a[-1], pole.linearize(q[-1], v[-1], u[-1, 0]).a)


def test_leading_dimensions_are_kept(pole: db.Simulator) -> None:
    q, v = (x.reshape(3, 4, 2) for x in starts(12))
    rollout = pole.rollout(q, v, inputs=np.zeros((5, 1)))
    assert rollout.q.shape == (3, 4, 6, 2) and rollout.u.shape == (3, 4, 5, 1)
    np.testing.assert_array_equal(rollout[2, 1].q, pole.rollout(q, v, steps=5).q[2, 1])
    from_one = pole.rollout(q[0, 0], v[0, 0], inputs=np.zeros((6, 5, 1)))
    assert from_one.q.shape == (6, 6, 2)
    assert pole.step(q, v)[0].shape == (3, 4, 2)


def test_each_state_of_a_batch_may_have_a_robot_of_its_own(pole: db.Simulator) -> None:
    q, v = starts(11)
    models = [pole.model.with_link_mass("pole", 0.2 + 0.1 * k) for k in range(11)]
    together = pole.rollout(q, v, steps=40, models=models)
    for i in (0, 7, 10):
        single = pole.replace(model=models[i]).rollout(q[i], v[i], steps=40)
        np.testing.assert_allclose(together[i].q, single.q, atol=1e-9)
    np.testing.assert_array_equal(
        pole.rollout(q, v, steps=40, models=models, control=lambda k, q, v: np.zeros((11, 1))).q, together.q
    )
    assert np.abs(together.q - pole.rollout(q, v, steps=40).q).max() > 1e-3
    with pytest.raises(ValueError, match="3 models for 11 states"):
        pole.rollout(q, v, steps=4, models=models[:3])
    with pytest.raises(ValueError, match="one state"):
        pole.rollout(q[0], v[0], steps=4, models=models[:1])
    with pytest.raises(ValueError, match="pendulum"):
        pole.rollout(q, v, steps=4, models=[db.samples.pendulum()] * 11)


def test_arrays_of_a_rollout_are_views(pole: db.Simulator) -> None:
    rollout = pole.rollout(*starts(9), steps=4)
    assert rollout.q.base is not None and np.shares_memory(rollout.q[..., :], rollout.q)
    assert rollout.q.strides[-2] == rollout.v.strides[-2] == 4 * 8


def test_linearize_equals_central_differences(quadruped: db.Model) -> None:
    simulator = db.Simulator(quadruped, time_step=DT)
    q, v = quadruped.random_configuration(1), quadruped.random_velocity(2)
    u = np.random.default_rng(3).normal(size=simulator.nu)
    a, b = simulator.linearize(q, v, u)
    n, h = quadruped.nv, 1e-5

    def step(dx: np.ndarray, du: np.ndarray) -> np.ndarray:
        q1, v1 = simulator.step(quadruped.integrate(q, dx[:n]), v + dx[n:], u + du)
        return np.concatenate([quadruped.difference(q0, q1), v1 - v0])

    q0, v0 = simulator.step(q, v, u)
    zero_x, zero_u = np.zeros(2 * n), np.zeros(simulator.nu)
    columns = [(step(h * e, zero_u) - step(-h * e, zero_u)) / (2 * h) for e in np.eye(2 * n)]
    np.testing.assert_allclose(a, np.transpose(columns), atol=1e-6 * np.abs(a).max())
    columns = [(step(zero_x, h * e) - step(zero_x, -h * e)) / (2 * h) for e in np.eye(simulator.nu)]
    np.testing.assert_allclose(b, np.transpose(columns), atol=1e-6 * np.abs(b).max())


def test_lqr_balances_the_pole(pole: db.Simulator) -> None:
    a, b = pole.linearize([0, 0], [0, 0], [0])
    lqr = db.Lqr.discrete(a, b, np.eye(4), np.eye(1))
    assert lqr.is_stabilized and lqr.spectral_radius < 1 and lqr.gain.shape == (1, 4)
    p = lqr.cost_to_go
    riccati = a.T @ p @ a - p + np.eye(4) - a.T @ p @ b @ np.linalg.solve(np.eye(1) + b.T @ p @ b, b.T @ p @ a)
    np.testing.assert_allclose(riccati, 0, atol=1e-8 * np.abs(p).max())
    q, v = np.random.default_rng(0).uniform(-0.2, 0.2, (2, 20, 2))
    rollout = pole.rollout(q, v, steps=1500, control=lambda k, q, v: lqr.control(np.concatenate([q, v], -1)))
    assert rollout.is_completed and np.abs(rollout.q[:, -1]).max() < 1e-3
    finite = db.FiniteHorizonLqr.discrete(
        np.tile(a, (400, 1, 1)), np.tile(b, (400, 1, 1)), np.tile(np.eye(4), (400, 1, 1)), np.ones((400, 1, 1)), p
    )
    assert finite.is_solved
    np.testing.assert_allclose(finite.gains[0], lqr.gain, atol=1e-6)
    continuous = db.Lqr.continuous([[0, 1], [0, 0]], [[0], [1]], np.eye(2), np.eye(1))
    np.testing.assert_allclose(continuous.gain, [[1, np.sqrt(3)]], atol=1e-9)  # of a double integrator


def test_centres_of_contact_points_are_those_of_the_link() -> None:
    ball = "<collision><origin xyz='0.3 0 0'/><geometry><sphere radius='0.1'/></geometry></collision>"
    inertial = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>"
    text = f"""<robot name="r"><link name="world"/><link name="arm">{inertial}</link><link name="foot">{ball}</link>
    <joint name="hinge" type="continuous"><parent link="world"/><child link="arm"/><axis xyz="1 0 0"/></joint>
    <joint name="weld" type="fixed"><parent link="arm"/><child link="foot"/><origin xyz="0.1 0.2 -0.9" rpy="1 0 0"/></joint></robot>"""
    contacts = Contacts(Terrain.flat(), Rigid(friction=0.5))
    ((link, center, _),) = db.Simulator(db.Model.from_urdf(text), contacts=contacts).contact_points
    assert link == "foot"
    np.testing.assert_allclose(center, (0.3, 0, 0), atol=1e-15)


def test_grids_and_points_that_memory_has_no_room_for_are_refused_by_name() -> None:
    with pytest.raises(MemoryError, match="grids of .* heights need .*set_memory_limit"):
        Terrain.function(lambda x, y: 0 * x, (0.0, 1e3), (0.0, 1e3), 1e-7)
    with pytest.raises(ValueError, match="have no end"):
        Terrain.function(lambda x, y: 0 * x, (0.0, np.inf), (0.0, 1.0), 0.1)
    # Views that repeat one number take no memory; arrays made from them do.
    wide = HeightField((0.0, 0.0), (1.0, 1.0), np.broadcast_to(0, (10**6, 10**6)))
    with pytest.raises(MemoryError, match="grids of 1000000 × 1000000 heights"):
        wide.surface(0.5, 0.5)
    model = db.Model.from_urdf(asset("box"))
    contacts = Contacts(Terrain.flat(), Rigid())
    few = dataclasses.replace(contacts, solver=SolverOptions(1e-12, 200, points=4))
    try:
        db.set_memory_limit(500)
        with pytest.raises(MemoryError, match="8 contact points need"):
            db.Simulator(model, contacts=contacts)
        # Three matrices of 24 rows.
        db.set_memory_limit(10_000)
        with pytest.raises(MemoryError, match="forces of 8 contact points in a step need 1.4e4 bytes"):
            db.Simulator(model, contacts=contacts)
        assert len(db.Simulator(model, contacts=few).contact_points) == 8
    finally:
        db.set_memory_limit(None)


def test_batches_that_memory_has_no_room_for_are_refused_by_name(pole: db.Simulator) -> None:
    arm, many = db.samples.arm(), np.broadcast_to(0.0, (10**12, 7))
    with pytest.raises(MemoryError, match=r"copies of q of the shape \[1000000000000, 7\]"):
        db.mass_matrix(arm, many)
    with pytest.raises(ValueError, match="1000000000000000 random links need"):
        db.samples.random_tree(10**15, 0)
    try:
        db.set_memory_limit(100_000)
        with pytest.raises(MemoryError, match=r"results of the shape \[300, 7, 7\] need 1.2e5 bytes"):
            db.mass_matrix(arm, np.zeros((300, 7)))
        with pytest.raises(MemoryError, match=r"results of the shape \[1000, 4, 4\]"):
            pole.linearize(np.zeros((1000, 2)), np.zeros((1000, 2)))
        assert db.mass_matrix(arm, np.zeros((200, 7))).shape == (200, 7, 7)
    finally:
        db.set_memory_limit(None)


def test_more_steps_than_memory_holds_are_refused_before_any_work(pole: db.Simulator) -> None:
    for steps in (10**13, 2**62):
        with pytest.raises(MemoryError, match=f"1 trajectories of {steps} steps"):
            pole.rollout([0, 0], [0, 0], steps=steps)
        with pytest.raises(MemoryError, match="set_memory_limit"):
            pole.rollout([0, 0], [0, 0], steps=steps, control=lambda k, q, v: [0.0])
    limit = db.memory_limit()
    try:
        db.set_memory_limit(100_000)
        assert db.memory_limit() == 100_000
        with pytest.raises(MemoryError):
            pole.rollout(np.zeros((100, 2)), np.zeros((100, 2)), steps=1000)
        assert pole.rollout([0, 0], [0, 0], steps=100).is_completed
    finally:
        db.set_memory_limit(None)
    assert db.memory_limit() == limit
    problem = db.trajopt.Problem(pole, 10**13, [0, 0, 0, 0])
    with pytest.raises(MemoryError):
        db.trajopt.Ddp(problem).solve()


def test_a_robot_that_touches_nothing_is_warned_of() -> None:
    inertial = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>"
    mesh = "<collision><geometry><mesh filename='absent.stl'/></geometry></collision>"
    ball = "<collision><geometry><sphere radius='0.1'/></geometry></collision>"

    def robot(shapes: str) -> db.Model:
        return db.Model.from_urdf(f"<robot name='r'><link name='a'>{inertial}{shapes}</link></robot>")

    contacts = Contacts(Terrain.flat(), Rigid(friction=0.5))
    with pytest.warns(UserWarning, match='"r" touches nothing.*link "a": the mesh absent.stl is not found'):
        db.Simulator(robot(mesh), contacts=contacts)
    with pytest.warns(UserWarning, match="has no collision shapes"):
        db.Simulator(robot(""), contacts=contacts)
    with pytest.warns(UserWarning, match="parts of"):
        db.Simulator(robot(mesh + ball), contacts=contacts)


def test_a_design_that_fails_says_why() -> None:
    integrator = ([[0.0]], [[1.0]], [[0.0]], [[1.0]])
    with pytest.raises(ValueError, match="the cost does not see the mode 0"):
        db.Lqr.continuous(*integrator)
    assert not db.Lqr.continuous(*integrator, check=False).is_stabilized


def test_inputs_of_a_rollout_are_those_that_were_simulated(pole: db.Simulator) -> None:
    u = np.ones((5, 1))
    rollout = pole.rollout([0, 0], [0, 0], inputs=u)
    u[:] = 7.0
    np.testing.assert_array_equal(rollout.u, np.ones((5, 1)))


def test_rollouts_stop_where_they_must(pole: db.Simulator) -> None:
    (q,), (v,) = starts(1)
    u = np.zeros((20, 1))
    u[7] = np.nan
    rollout = pole.rollout(q, v, inputs=u)
    assert rollout.status == ("non_finite_input", 7) and rollout.n_states == 8
    assert np.isfinite(rollout.q[:8]).all() and np.isnan(rollout.q[8:]).all()
    many = np.zeros((9, 20, 1))
    many[4, 3] = np.inf
    batch = pole.rollout(*starts(9), inputs=many)
    assert [s.kind for s in batch.status].count("completed") == 8 and batch.status[4].step == 3
    assert np.isnan(batch.q[4, 4:]).all() and np.isfinite(batch.q[5]).all()
    assert batch.n_states.tolist() == [21] * 4 + [4] + [21] * 4 and "1 of 9" in repr(batch)
    wild = pole.replace(divergence_bound=0.5).rollout([0, 1.0], [0, 0], steps=500)
    assert wild.status.kind == "diverged"
    controlled = pole.rollout(*starts(9), steps=20, control=lambda k, q, v: many[:, k])
    assert np.isnan(controlled.q[4, 4:]).all() and controlled.status[4] == ("non_finite_input", 3)


def test_exceptions_of_a_control_come_through(pole: db.Simulator) -> None:
    def broken(k: int, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        if k == 3:
            raise RuntimeError("no plan")
        return np.zeros(q.shape[:-1] + (1,))

    with pytest.raises(RuntimeError, match="no plan"):
        pole.rollout([0, 0], [0, 0], steps=10, control=broken)
    with pytest.raises(RuntimeError, match="no plan"):
        pole.rollout(*starts(10), steps=10, control=broken)
    with pytest.raises(ValueError, match="control's input"):
        pole.rollout([0, 0], [0, 0], steps=10, control=lambda k, q, v: np.zeros(3))


def test_progress_counts_the_steps(pole: db.Simulator) -> None:
    seen: list[int] = []
    pole.rollout([0, 0], [0, 0], steps=5, control=lambda k, q, v: 0.0, progress=seen.append)
    assert seen == [1, 2, 3, 4, 5, 5]
    seen.clear()
    pole.rollout(*starts(64), steps=2000, progress=seen.append)
    assert seen[-1] == 2000 and sorted(seen) == seen


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda s: s.step([0, 0], [0, 0], [0, 0]), ValueError, r"^u has the shape \[2\], expected \(…, 1\)"),
        (lambda s: s.step([0, np.nan], [0, 0], [0]), ValueError, "pivot"),
        (lambda s: s.step([0, 0], [0, 0], [np.inf]), ValueError, r"^u\[0\] is inf"),
        (lambda s: s.step(np.zeros((2, 2)), np.zeros((3, 2)), [0]), ValueError, "^v is a batch"),
        (lambda s: s.rollout([0, 0], [0, 0]), ValueError, "^steps"),
        (lambda s: s.rollout([0, 0], [0, 0], inputs=np.zeros((5, 2))), ValueError, "^inputs has the shape"),
        (lambda s: s.rollout([0, 0], [0, 0], steps=3, inputs=np.zeros((5, 1))), ValueError, "^inputs has the shape"),
        (lambda s: s.rollout([0, 0], [0, 0], steps=-1), ValueError, "steps is -1"),
        (lambda s: s.replace(time_step=-1.0), ValueError, "time step of -1"),
        (lambda s: s.replace(integrator="euler"), ValueError, "integrator is \"euler\""),
        (lambda s: s.replace(actuated=["wheel"]), KeyError, "wheel"),
        (lambda s: s.replace(tempo=3), TypeError, "tempo"),
        (lambda s: s.replace(actuation=Actuation("strong")), ValueError, "actuation is \"strong\""),  # type: ignore[arg-type]
        (lambda s: s.replace(contacts=Contacts(law=Rigid(friction=-1))), ValueError, "friction"),
        (lambda s: s.replace(constraints=[Coupler(("linear", "wheel"), 1.0)]), KeyError, "wheel"),
        (lambda s: s.replace(constraints=[Tendon({"wheel": 1.0})]), KeyError, "wheel"),
        (lambda s: s.replace(constraints=[Tendon({"linear": 1.0}, largest_force=-1.0)]), ValueError, "largest force of -1"),
        (lambda s: s.replace(constraints=[Tendon({"linear": 1.0}, 0.0, 0.1, (1.0, 1.0))]), ValueError, "not several"),
        (lambda s: s.replace(external_forces=[ExternalForce(Anchor("hand"), [0] * 6)]), KeyError, "hand"),
        (lambda s: db.Lqr.discrete(np.eye(2), np.eye(3), np.eye(2), np.eye(3)), ValueError, "^b has the shape"),
        (lambda s: db.Lqr.discrete(np.eye(2), np.ones((2, 1)), np.eye(2), [1]), ValueError, "^r has the shape"),
    ],
)
def test_wrong_arguments_are_errors_that_name_them(pole: db.Simulator, call, error, text) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(error, match=text):
        call(pole)


def test_step_writes_to_out(pole: db.Simulator) -> None:
    q, v = starts(20)
    expected = pole.step(q, v)
    out = pole.step(q, v, out=(q, v))
    assert out[0] is q and out[1] is v
    np.testing.assert_array_equal(q, expected[0])
    with pytest.raises(ValueError, match=r"^out\[1\]"):
        pole.step(q, v, out=(q, v[:3]))


# What acts on a robot.


def test_a_ball_comes_to_rest_on_the_ground() -> None:
    model = db.Model.from_urdf(asset("sphere"))
    for law in (Rigid(), RelaxedRigid()):
        simulator = db.Simulator(model, time_step=1e-3, contacts=Contacts(Terrain.flat(), law))
        q, v = model.neutral(), np.zeros(6)
        q[2] = 0.3
        rollout = simulator.rollout(q, v, steps=2000)
        assert rollout.is_completed and rollout.q[-1, 2] == pytest.approx(0.1, abs=5e-3)
        report = simulator.contact_report(rollout.q[-1], rollout.v[-1])
        assert report.forces[:, 2].sum() == pytest.approx(model.total_mass * 9.81, rel=0.05)
        assert len(report.modes) == len(report.depths) == len(simulator.contact_points)


def test_soft_contact_has_a_state() -> None:
    model = db.Model.from_urdf(asset("box"))
    law = SoftContact.estimate(model.total_mass, 4, 1e-3)
    simulator = db.Simulator(model, time_step=1e-4, contacts=Contacts(Terrain.flat(), law))
    assert simulator.n_contact > 0
    q, v = model.neutral(), np.zeros(6)
    q[2] = 1.0
    q1, v1, contact = simulator.step(q, v, contact=simulator.neutral_contact())
    for own, other in zip(simulator.step(q, v), (q1, v1, contact), strict=True):
        np.testing.assert_array_equal(own, other)
    assert contact.shape == (simulator.n_contact,)
    rollout = simulator.rollout(np.tile(q, (9, 1)), v, steps=100, contact=simulator.neutral_contact())
    assert rollout.contact.shape == (9, 101, simulator.n_contact)
    np.testing.assert_allclose(rollout.q[3, 1], q1, atol=1e-12)
    assert simulator.linearize(q, v, contact=simulator.neutral_contact()).a.shape[0] == simulator.n_tangent


def test_soft_contact_has_a_restitution() -> None:
    law = SoftContact.estimate(1.0, 1, 0.01).with_restitution(0.6, 2.0)
    assert law.damping_exponent == 1 + law.stiffness_exponent
    assert law.restitution(2.0) == pytest.approx(0.6)
    assert SoftContact(0.5, 1e4, 10.0, 0.0, 0.0).restitution(1.0) is None
    # A linear spring: half a period.
    assert SoftContact(0.5, 100.0, 0.0, 0.0, 1.0).impact_time(4.0, 2.0) == pytest.approx(0.2 * np.pi)
    model = db.Model.from_urdf(asset("sphere"))
    flying = db.Simulator(model, time_step=1e-3, contacts=Contacts(law=law))
    q, v = model.neutral(), np.zeros(6)
    q[2], v[2] = 0.2, -2.0
    end = flying.rollout(q, v, steps=200, contact=flying.neutral_contact())
    # Gravity adds to the speed before and takes from it after.
    assert end.v[-1, 2] > 0.0
    assert flying.remarks(q) == []
    said = flying.replace(time_step=0.02).remarks(q)
    assert "too long for soft contact" in said[0]
    with pytest.raises(ValueError, match="not in"):
        law.with_restitution(1.5, 2.0)


def test_remarks_name_the_longest_step() -> None:
    # A damper of 200 N·m·s on 1/3 kg·m²: the Runge–Kutta method is stable up to 2.785 / 600 s.
    pendulum = db.samples.pendulum().with_damping(0, 200.0)
    simulator = db.Simulator(pendulum, time_step=0.01)
    assert simulator.remarks([0.0]) == []
    (said,) = simulator.replace(integrator="runge_kutta_4").remarks([0.0])
    assert "use steps of at most 4.6e-3 s" in said


def test_remarks_on_rotations_need_a_velocity() -> None:
    body = db.Model.from_urdf(asset("box"))
    simulator = db.Simulator(body, time_step=0.01)
    q, tumbling = body.neutral(), [0.0, 0.0, 0.0, 2.0, 20.0, 10.0]
    assert simulator.remarks(q) == simulator.remarks(q, np.zeros(6)) == []
    (said,) = simulator.remarks(q, tumbling)
    assert said.endswith("or Integrator::ImplicitVelocity")
    with pytest.raises(ValueError, match="v"):
        simulator.remarks(q, [1.0])


def test_terrains_have_their_heights() -> None:
    assert Terrain.incline(0.3).surface(2.0, 5.0) == pytest.approx((2 * np.tan(0.3), np.tan(0.3), 0))
    x, y = np.meshgrid(np.arange(5) * 0.5, np.arange(4) * 0.25, indexing="ij")
    field = HeightField((0, 0), (0.5, 0.25), 0.2 * x - 0.4 * y)
    assert field.surface(1.0, 0.5) == pytest.approx((0.0, 0.2, -0.4), abs=1e-9)
    with pytest.raises(ValueError, match="heights"):
        HeightField((0, 0), (1, 1), [1.0, 2.0]).surface(0, 0)
    with pytest.raises(ValueError, match="normal"):
        Terrain.plane((0, 0, 0), (0, 0, -1)).surface(0, 0)


def test_a_box_slides_down_an_incline_as_coulomb_says() -> None:
    # tan 0.5 > mu: acceleration g (sin - mu cos) along the slope.
    model = db.Model.from_urdf(asset("box"))
    angle, mu = 0.5, 0.2
    simulator = db.Simulator(model, time_step=1e-3, contacts=Contacts(Terrain.incline(angle), Rigid(friction=mu)))
    q = model.neutral()
    half = angle / 2
    q[3:7] = np.cos(half), 0, -np.sin(half), 0
    height = -min(point[1][2] for point in simulator.contact_points)
    q[:3] = -np.sin(angle) * height, 0, np.cos(angle) * height
    rollout = simulator.rollout(q, np.zeros(6), steps=500)
    speed = np.linalg.norm(rollout.v[-1, :3])
    assert speed == pytest.approx(0.5 * 9.81 * (np.sin(angle) - mu * np.cos(angle)), rel=0.02)


def test_motors_limit_and_rub() -> None:
    model = db.samples.pendulum()
    weak = db.Simulator(model, time_step=DT, actuation=Actuation("ideal", {model.joint_names[0]: Actuator(effort=1.0)}))
    free = db.Simulator(model, time_step=DT)
    np.testing.assert_array_equal(weak.step([0.3], [0.0], [50.0])[1], free.step([0.3], [0.0], [1.0])[1])
    stop = HuntCrossley(1e4, 1e2)
    stopped = db.Simulator(
        model, time_step=1e-3, actuation=Actuation("ideal", {model.joint_names[0]: Actuator(position=(-0.2, 0.2, stop))})
    )
    assert np.abs(stopped.rollout([0.0], [3.0], steps=1000).q).max() < 0.3
    assert db.Simulator(db.Model.from_urdf(asset("panda")), actuation=Actuation("model")).nu == 8


def test_constraints_hold() -> None:
    model = db.samples.double_pendulum()
    first, second = model.joint_names
    coupled = db.Simulator(model, time_step=1e-3, constraints=[Coupler((first, second), 1.0)])
    q, v = coupled.assemble([0.3, 0.1], [0.0, 0.0])
    assert abs(q[0] - q[1]) < 1e-6
    rollout = coupled.rollout(q, v, steps=500)
    assert np.abs(rollout.q[:, 0] - rollout.q[:, 1]).max() < 1e-3
    assert np.abs(coupled.constraint_errors(rollout.q[-1], rollout.v[-1])).max() < 1e-3
    cam = Coupler((first, second), 0.5, 0.1, higher=(0.4, -0.2))
    cammed = db.Simulator(model, time_step=1e-3, constraints=[cam])
    rollout = cammed.rollout(*cammed.assemble([0.3, 0.1], [0.0, 0.0]), steps=500)
    assert np.abs(rollout.q[:, 0] - np.polyval([-0.2, 0.4, 0.5, 0.1], rollout.q[:, 1])).max() < 1e-3
    with pytest.raises(ValueError, match="at most"):
        db.Simulator(model, constraints=[Coupler((first, second), 0.5, higher=(1, 2, 3, 4))])
    tip, world = Anchor(model.link_names[-1], (0, 0, 0.2)), Anchor()
    there = world.brought_to(tip, model, [0.3, 0.1])
    np.testing.assert_allclose(there.pose_in_world(model, q), tip.pose_in_world(model, [0.3, 0.1]))
    for constraint in (Ball(tip, there), Weld(tip, there)):
        held = db.Simulator(model, time_step=1e-3, constraints=[constraint])
        moved = held.rollout([0.3, 0.1], [0, 0], steps=300)
        assert np.abs(moved.q - [0.3, 0.1]).max() < 1e-2
    rope = Distance(tip, Anchor(None, (5.0, 0, 0)), 3.0)
    with pytest.raises(ValueError, match="row"):
        db.Simulator(model, constraints=[rope]).assemble([0.3, 0.1], [0, 0])


def test_constraints_give_way() -> None:
    model = db.samples.cartpole()
    brake = Tendon({"linear": 1.0}, largest_force=2.0)
    braked = db.Simulator(model, time_step=1e-3, constraints=[brake])
    rest = braked.rollout([0, 0], [0, 0], inputs=np.tile([1.9, 0.0], (50, 1)))
    assert np.abs(rest.q).max() < 1e-9
    assert braked.step([0, 0], [0, 0], [2.5, 0])[1][0] > 1e-5
    model = db.samples.double_pendulum()
    first, second = model.joint_names
    stiffness, damping, dt = 50.0, 2.0, 1e-3
    for spring in (
        Tendon({first: 1.0, second: -0.5}, 0.1, spring=(stiffness, damping)),
        Coupler((first, second), 0.5, 0.1, spring=(stiffness, damping)),
    ):
        soft = db.Simulator(model, time_step=dt, constraints=[spring])
        q, v = soft.step([0.4, 0.2], [0.1, -0.3])
        force = -stiffness * (q[0] - 0.5 * q[1] - 0.1) - damping * (v[0] - 0.5 * v[1])
        assert abs(soft.contact_report([0.4, 0.2], [0.1, -0.3]).constraints[0] - force) < 1e-9


def test_regularised_constraints_follow_their_row() -> None:
    model = db.samples.double_pendulum()
    first, second = model.joint_names
    dt, width, w = 1e-3, 0.4, 0.7
    soft = Regularisation(time_constant=0.03, damping_ratio=0.8, impedance=(0.6, 0.9, width, 0.5, 2.0), inverse_mass=w)
    for tied in (Tendon({first: 1.0, second: -0.5}, 0.1, regularisation=soft), Coupler((first, second), 0.5, 0.1, regularisation=soft)):
        simulator = db.Simulator(model, time_step=dt, constraints=[tied])
        q, v = [0.4, 0.2], [0.1, -0.3]
        a = simulator.acceleration(q, v)
        force = simulator.contact_report(q, v).constraints[0]
        error, rate = 0.4 - 0.1 - 0.1, 0.1 + 0.15
        x = error / width
        d = 0.6 + 0.3 * (2 * x * x if x < 0.5 else 1 - 2 * (1 - x) ** 2)
        b, k = 2 / (0.9 * 0.03), (0.9 * 0.03 * 0.8) ** -2
        row = a[0] - 0.5 * a[1] + b * rate + k * d * error + (1 - d) / d * w * force
        assert abs(row) < 0.02 * k * error  # the force is that of the step
        assert "constraint 0: inverse mass" in simulator.parameter_names
    with pytest.raises(TypeError, match="regularisation"):
        db.Simulator(model, constraints=[Tendon({first: 1.0}, regularisation=0.1)])
    with pytest.raises(ValueError, match="several"):
        db.Simulator(model, constraints=[Tendon({first: 1.0}, time_constant=0.1, regularisation=soft)])


def test_forces_on_frames_act() -> None:
    model = db.Model.from_urdf(asset("sphere"))
    lift = [0, 0, model.total_mass * 9.81, 0, 0, 0]
    link = model.link_names[0]
    floating = db.Simulator(model, time_step=DT, external_forces=[ExternalForce(Anchor(link), lift)])
    assert np.abs(floating.rollout(model.neutral(), np.zeros(6), steps=100).v).max() < 1e-9
    nozzle = FrameActuator.thruster("nozzle", Anchor(link), (0, 0, 2.0), limits=(0.0, 5.0))
    rocket = db.Simulator(model, time_step=DT, frame_actuators=[nozzle])
    assert rocket.nu == 1 and rocket.input_names == ["nozzle"]
    v = rocket.step(model.neutral(), np.zeros(6), [100.0])[1]
    assert v[2] == pytest.approx(DT * (5.0 / model.total_mass - 9.81), rel=1e-9)
    with pytest.raises(ValueError, match="direction"):
        FrameActuator.thruster("none", Anchor(link), (0, 0, 0))


def test_recordings_show_save_and_plot(pole: db.Simulator, tmp_path) -> None:  # type: ignore[no-untyped-def]
    rollout = pole.rollout([0, 0.1], [0, 0], steps=20)
    recording = db.Recording.from_rollout(pole.model, rollout)
    assert len(recording) == 21 and "cartpole" in repr(recording)
    recording.add_series("angle", rollout.q[:, 1])
    recording.trace("pole")
    recording.title = "A pole"
    page = tmp_path / "page.html"
    recording.save_html(page)
    assert "A pole" in page.read_text() and page.read_text() == recording.to_html()
    frame = recording.show(height="300")._repr_html_()
    assert frame.startswith("<iframe srcdoc=") and 'height="300"' in frame
    assert recording._repr_html_().count("<iframe") >= 1 and "<iframe" in pole.model._repr_html_()
    recording.save_json(tmp_path / "motion.json")
    again = db.Recording.read(tmp_path / "motion.json", pole.model)
    assert again.to_csv() == recording.to_csv()
    recording.save_csv(tmp_path / "motion.csv")
    header = recording.to_csv().splitlines()[0].split(",")
    plot = recording.plot(header[1])
    assert plot._repr_svg_().startswith("<svg") and plot.to_png().startswith(b"\x89PNG")
    drawn = db.Plot("line", x="t / s").with_line("y", [0, 1], [0, 2]).with_size(300, 200)
    assert "line" in drawn.to_svg()
    with pytest.raises(KeyError, match="nonsense"):
        recording.plot("nonsense")
    with pytest.raises(ValueError, match="^values has the shape"):
        recording.add_series("short", [1.0])
    with pytest.raises(ValueError, match="batch"):
        db.Recording.from_rollout(pole.model, pole.rollout(*starts(3), steps=2))
    with pytest.raises(OSError):
        recording.save_html(page / "in_a_file.html")
    of = db.Recording.of_simulation(pole, rollout)
    assert of.robots == recording.robots
    both = db.Recording(pole.model, pole.model)
    both.push(0.0, ([0, 0], [0, 0]), ([1, 0], [0, 0]))
    both.spread(1.0)
    assert len(both.robots) == 2 and len(both) == 1


def test_ddp_swings_up_and_a_receding_horizon_balances(pole: db.Simulator) -> None:
    from dualbody.trajopt import Constraint, Ddp, InputError, Problem, RecedingHorizon, StateError, Term, plan, position_bounds

    rail = Constraint(StateError(), position_bounds(pole))
    problem = Problem(
        pole.replace(time_step=0.02),
        horizon=100,
        start=[0, np.pi, 0, 0],
        stage_cost=[Term(0.1, StateError()), Term(1e-2, InputError())],
        final_cost=[Term(10.0, StateError())],
        input_bounds=([-20], [20]),
        constraints=[rail],
        final_constraints=[Constraint(StateError())],
    )
    reported: list[int] = []
    solution = Ddp(problem, max_iterations=300).solve(report=lambda iteration, *rest: reported.append(iteration))
    assert solution.is_converged and reported and solution.x.shape == (101, 4) and solution.gains.shape == (100, 1, 4)
    assert np.abs(solution.x[-1]).max() < 1e-4 and np.abs(solution.u).max() <= 20 + 1e-9
    again = problem.simulator.rollout(solution.x[0, :2], solution.x[0, 2:], inputs=solution.u)
    np.testing.assert_allclose(again.q, solution.x[:, :2], atol=1e-4)
    assert problem.violation(solution.x, solution.u) < 1e-4
    assert problem.cost(solution.x, solution.u) == pytest.approx(solution.cost, rel=1e-6)
    with pytest.raises(TypeError, match="speed"):
        Ddp(problem, speed=3)  # type: ignore[call-arg]
    with pytest.raises(ValueError, match="^start has the shape"):
        Ddp(Problem(pole, 5, [0.0])).solve()

    near = Problem(pole, 40, [0, 0, 0, 0], [Term(1.0, StateError()), Term(1e-3, InputError())], [Term(10.0, StateError())])
    controller = RecedingHorizon(near, max_iterations=3)
    rollout = pole.rollout([0.3, 0.2], [0, 0], steps=500, control=lambda k, q, v: controller.control(q, v))
    assert np.abs(rollout.q[-1]).max() < 1e-2
    assert plan(controller).u.shape == (40, 1)


def test_sdf_is_read() -> None:
    text = """<sdf version="1.9"><model name="ball"><link name="ball"><inertial><mass>2</mass></inertial></link></model></sdf>"""
    model = db.Model.from_sdf(text)
    assert model.total_mass == 2 and model.has_floating_base
    assert (ASSETS / "cartpole.urdf").exists()


def test_mjcf_is_read_from_text_and_file() -> None:
    text = """<mujoco><worldbody><body name="rod"><joint name="hinge" axis="0 1 0" ref="0.1"/>
      <geom type="capsule" fromto="0 0 0 0 0 -1" size="0.02" mass="1"/><site name="tip" pos="0 0 -1"/></body></worldbody>
      <actuator><muscle joint="hinge"/></actuator></mujoco>"""
    model = db.Model.from_mjcf(text)
    assert model.joint_names == ["hinge"] and model.total_mass == 1 and not model.has_floating_base
    assert "tip" in model.frame_names and "muscle" in str(model.import_report)
    attached = db.Model.from_mjcf(ASSETS.parent / "tests" / "mjcf" / "attach.xml")
    assert "left/hip" in attached.joint_names


def test_simulator_of_an_mjcf_has_its_servos_contacts_and_states() -> None:
    text = """<mujoco><option timestep="0.01" integrator="implicitfast" gravity="0 0 0"/><worldbody><geom type="plane" size="1 1 1"/>
      <body name="rod" pos="0 0 2"><joint name="hinge" axis="0 1 0" armature="0.1"/>
        <geom type="capsule" fromto="0 0 0 0 0 -1" size="0.02" mass="1" contype="0" conaffinity="0"/></body>
      <body name="ball" pos="1 0 3"><freejoint name="free"/><geom size="0.1"/></body></worldbody>
      <actuator><position joint="hinge" kp="1e4" kv="2e3" ctrlrange="-0.5 0.5"/></actuator>
      <keyframe><key name="bent" qpos="0.2 1 0 4 1 0 0 0" ctrl="0.3"/></keyframe></mujoco>"""
    simulator = db.Simulator.from_mjcf(text)
    assert (simulator.nu, simulator.time_step, simulator.integrator) == (1, 0.01, "implicit_velocity")
    assert "contact points" in repr(simulator) and simulator.effort_bounds[1][0] == 0.5
    q, v, u, contact = simulator.keyframes["bent"]
    assert contact.shape == (simulator.n_contact,)
    assert q[0] == 0.2 and u[0] == 0.3 and simulator.keyframes["qpos0"][0][0] == 0
    reached = pickle.loads(pickle.dumps(simulator)).rollout(q, v, inputs=np.tile([9.0], (500, 1)))
    assert abs(reached.q[-1][0] - 0.5) < 1e-6
    explicit = simulator.replace(integrator="runge_kutta_4", time_step=1e-4)
    assert explicit.nu == 1 and explicit.integrator == "runge_kutta_4"
    assert db.Simulator(simulator.model).keyframes == {}


URDF = """<robot name="cart"><link name="world"/>
  <link name="a"><inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="b"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="x" type="prismatic"><parent link="world"/><child link="a"/><axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="5000" velocity="90"/></joint>
  <joint name="y" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/><limit lower="-9" upper="9" effort="50" velocity="90"/></joint>
  <ros2_control name="all" type="system"><joint name="x">
    <command_interface name="position"><param name="kp">1e4</param><param name="kd">1e3</param><param name="max">0.5</param></command_interface>
  </joint></ros2_control></robot>"""


def test_simulator_of_a_urdf_has_the_inputs_of_its_command_interfaces() -> None:
    simulator = db.Simulator.from_urdf(URDF, gravity=(0.0, 0.0, 0.0))
    assert simulator.input_names == ["x"] and simulator.keyframes == {} and simulator.effort_bounds[1][0] == 0.5
    copied = pickle.loads(pickle.dumps(simulator)).replace(time_step=0.01)
    reached = copied.rollout(np.zeros(2), np.zeros(2), inputs=np.tile([9.0], (500, 1)))
    assert abs(reached.q[-1][0] - 0.5) < 1e-6
    without = db.Simulator.from_urdf(URDF.replace("kp", "unknown"))
    assert "no gains in the file" in str(without.model.import_report)


def test_servo_of_a_frame_holds_it_under_gains_that_no_explicit_step_bears() -> None:
    box = db.Model.from_urdf(ASSETS / "box.urdf", base="floating")
    box = box.with_gravity((0.0, 0.0, 0.0))
    place = db.sim.Anchor(box.link_names[0])
    servo = db.sim.FrameActuator("x", place, (1, 0, 0, 0, 0, 0), "mixed", servo=(1.0, 1e4, 0.0, 1e4, 100.0), force_range=(-50.0, 50.0))
    simulator = db.Simulator(box, frame_actuators=[servo], time_step=0.01)
    q = box.neutral()
    held = pickle.loads(pickle.dumps(simulator)).rollout(q, np.zeros(6), inputs=np.tile([0.3], (2000, 1)))
    assert abs(held.q[-1][0] - 0.3) < 1e-3
    with pytest.raises(ValueError, match="there is none"):
        db.sim.FrameActuator("x", place, (1, 0, 0, 0, 0, 0), force_range=(-1.0, 1.0))


def test_keyframes_have_activations() -> None:
    text = """<mujoco><worldbody><body><joint name="j"/><geom size="0.1"/></body></worldbody>
      <actuator><general joint="j" dyntype="filter" dynprm="0.1"/></actuator><keyframe><key name="on" act="0.7"/></keyframe></mujoco>"""
    simulator = db.Simulator.from_mjcf(text)
    q, v, u, contact = simulator.keyframes["on"]
    assert contact[-simulator.n_activation :].tolist() == [0.7]
    assert simulator.keyframes["qpos0"][3].tolist() == [0.0]
    simulator.step(q, v, u, contact=contact)


def test_tiles_of_ground_equal_the_library_and_refuse_others() -> None:
    grids = [db.contact.HeightField((k, -1.0), (0.5, 0.25), np.random.default_rng(k).normal(size=(4, 6))) for k in range(5)]
    ground, shifts = db.contact.HeightField.tiled(grids, 2)
    assert np.asarray(ground.heights).shape == (8, 18) and shifts.shape == (5, 2)
    for grid, shift in zip(grids, shifts, strict=True):
        heights = np.asarray(grid.heights)
        for i, j in ((0, 0), (3, 5), (1, 2)):
            x, y = np.asarray(grid.origin) + shift + (0.5 * i, 0.25 * j)
            assert abs(ground.surface(x, y)[0] - heights[i, j]) < 1e-12
    with pytest.raises(ValueError, match="tile 1 has size"):
        db.contact.HeightField.tiled([grids[0], db.contact.HeightField((0, 0), (1, 1), [[0.0] * 2] * 2)], 1)


def test_a_file_is_read_once(tmp_path: Path) -> None:
    file = tmp_path / "rod.xml"
    text = """<mujoco><worldbody><body><joint name="j" axis="0 1 0"/><geom size="0.1"/></body></worldbody>
      <actuator><motor joint="j"/></actuator><keyframe><key name="bent" qpos="0.3"/></keyframe></mujoco>"""
    file.write_text(text)
    simulator = db.Simulator.from_mjcf(file)
    file.unlink()
    slower = simulator.replace(time_step=1e-4)
    heavier = slower.with_parameters(slower.parameters * 1.0)
    for own in (simulator, slower, heavier, pickle.loads(pickle.dumps(heavier))):
        assert own.nu == 1 and own.keyframes["bent"][0] == [0.3]
    assert heavier.time_step == 1e-4 and pickle.loads(pickle.dumps(simulator.model)) == simulator.model
