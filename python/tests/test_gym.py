"""Environments of Gymnasium."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode  # noqa: E402

import dualbody as db  # noqa: E402
import dualbody.gym as gym  # noqa: E402
from dualbody.gym.draws import keys  # noqa: E402

NAMES = ["dualbody/CartPole-v0", "dualbody/PushBlock-v0", "dualbody/Quadruped-v0"]


@pytest.mark.parametrize("name", NAMES)
def test_environments_pass_the_checker_of_gymnasium(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of unbounded observations
        check_env(gymnasium.make(name).unwrapped, skip_render_check=True)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_a_batch_equals_single_environments(name: str, mode: AutoresetMode) -> None:
    n, steps = 5, 60
    envs = gymnasium.make_vec(name, num_envs=n, vectorization_mode="vector_entry_point", autoreset_mode=mode)
    singles = gymnasium.vector.SyncVectorEnv([lambda: gymnasium.make(name, disable_env_checker=True)] * n, autoreset_mode=mode)
    envs.action_space.seed(0)
    actions = [envs.action_space.sample() for _ in range(steps)]
    np.testing.assert_allclose(envs.reset(seed=11)[0], singles.reset(seed=11)[0], atol=1e-6)
    ends = 0
    for action in actions:
        one, other = envs.step(action), singles.step(action)
        for x, y in zip(one[:4], other[:4], strict=True):
            np.testing.assert_allclose(x, y, atol=1e-3, rtol=1e-3)
        assert envs.observation_space.contains(one[0])
        ended = one[2] | one[3]
        ends += int(ended.sum())
        if mode is AutoresetMode.SAME_STEP and ended.any():
            i = int(np.flatnonzero(ended)[0])
            np.testing.assert_allclose(one[4]["final_obs"][i], other[4]["final_obs"][i], atol=1e-3, rtol=1e-3)
    assert ends > 0 or "CartPole" not in name


def test_seeds_make_episodes_the_same() -> None:
    one, other = (gym.BatchEnv(gym.cartpole(), 4) for _ in range(2))
    np.testing.assert_array_equal(one.reset(seed=3)[0], other.reset(seed=[3, 4, 5, 6])[0])
    assert not np.array_equal(one.reset()[0], other.reset(seed=9)[0])
    with pytest.raises(ValueError, match="seeds"):
        one.reset(seed=[1, 2])


def test_random_numbers_of_a_row_depend_on_its_seed_only() -> None:
    every, some = gym.Draws(keys(range(10, 5010))), gym.Draws(keys([12, 17]))
    for size in (1, 4, 3):
        np.testing.assert_array_equal(every.uniform(-1, 1, size)[[2, 7]], some.uniform(-1, 1, size))
    x, y = every.uniform(2.0, 4.0, 40), every.normal(40)
    assert 2.0 <= x.min() < 2.001 and 3.999 < x.max() < 4.0
    # Means of 200,000 numbers within four deviations; neighbours in a row and in a column are not correlated.
    assert abs(x.mean() - 3.0) < 4 * np.sqrt(1 / 3 / x.size) and abs(y.mean()) < 4 / np.sqrt(y.size)
    assert abs(y.std() - 1.0) < 4 / np.sqrt(2 * y.size)
    for one, other in ((y[:, 1:], y[:, :-1]), (y[1:], y[:-1])):
        assert abs((one * other).mean()) < 4 / np.sqrt(one.size)


def test_seeds_of_none_differ_and_leave_the_others_alone() -> None:
    one, other = (gym.BatchEnv(gym.cartpole(), 3) for _ in range(2))
    first, second = one.reset(seed=[5, None, 7])[0], other.reset(seed=[5, None, 7])[0]
    np.testing.assert_array_equal(first[[0, 2]], second[[0, 2]])
    assert not np.array_equal(first[1], second[1])
    again = one.reset(seed=[5, None, None])[0]
    np.testing.assert_array_equal(again[0], first[0])
    assert not np.array_equal(again[1:], first[1:])


def test_without_autoreset_a_mask_resets() -> None:
    env = gym.BatchEnv(gym.cartpole(), 3, autoreset_mode=AutoresetMode.DISABLED)
    env.reset(seed=0)
    push = np.full((3, 1), 10.0, np.float32)
    over = np.zeros(3, bool)
    while not over.any():
        observations, _, over, _, _ = env.step(push)
    with pytest.raises(RuntimeError, match="reset_mask"):
        env.step(push)
    again, _ = env.reset(options={"reset_mask": over})
    assert (np.abs(again[over]) <= 0.05).all()
    np.testing.assert_array_equal(again[~over], observations[~over])
    env.step(push)


def test_actions_of_a_wrong_shape_or_not_finite_are_refused() -> None:
    envs = gym.BatchEnv(gym.cartpole(), 4)
    envs.reset(seed=1)
    with pytest.raises(ValueError, match=r"actions has the shape \[4\], expected \(4, 1\)"):
        envs.step(np.full(4, 5.0, np.float32))
    actions = np.zeros((4, 1), np.float32)
    actions[2] = np.nan
    with pytest.raises(ValueError, match="environment 2 is not finite"):
        envs.step(actions)
    robots = gym.BatchEnv(gym.quadruped(), 2)
    robots.reset(seed=1)
    with pytest.raises(ValueError, match=r"actions has the shape \(2,\), expected \(2, 12\)"):
        robots.step(np.zeros(2, np.float32))
    with pytest.raises(ValueError, match="environment 1 is not finite"):
        robots.step(np.stack([np.zeros(12), np.full(12, np.inf)]))


def test_a_state_that_diverges_ends_its_episode_only() -> None:
    simulator = gym.cartpole().simulator.replace(divergence_bound=2.0)
    wild = gym.Task(
        simulator,
        lambda rng: (np.zeros(2), np.array([0.0, 1.9 if rng.random() < 0.5 else 0.0])),
        lambda q, v: np.concatenate([q, v], axis=1),
        lambda q, v, u: np.ones(len(q)),
        lambda q, v: np.zeros(len(q), bool),
        bounds=([-10], [10]),
    )
    data = gym.Balance(simulator, ([0, 0, 0, 1.5], [0, 0, 0, 2.0]), (np.full(4, -np.inf), np.full(4, np.inf)), bounds=([-10], [10]))
    for task in (wild, data):
        env = gym.BatchEnv(task, 16)
        env.reset(seed=1)
        ends = np.zeros(16, bool)
        for _ in range(12):
            observations, _, over, _, _ = env.step(np.zeros((16, 1), np.float32))
            assert np.isfinite(observations).all()
            ends |= over
        assert ends.any() and (task is data or not ends.all())


def test_a_balance_is_the_task_of_functions_that_says_the_same() -> None:
    task = gym.cartpole()
    first = gym.BatchEnv(task, 9).reset(seed=4)[0].astype(float)
    functions = gym.Task(
        task.simulator,
        lambda rng: (np.zeros(2), np.zeros(2)),
        lambda q, v: np.concatenate([q, v], axis=1),
        lambda q, v, u: np.ones(len(q)),
        lambda q, v: (np.abs(q[:, 0]) > 2.4) | (np.abs(q[:, 1]) > np.radians(12)),
        max_steps=500,
        bounds=([-10.0], [10.0]),
        starts=lambda draws: (np.float64(first[: len(draws), :2]), np.float64(first[: len(draws), 2:])),
    )
    one, other = (gym.BatchEnv(t, 9, AutoresetMode.DISABLED) for t in (task, functions))
    np.testing.assert_array_equal(one.reset(seed=4)[0], other.reset(seed=4)[0])
    one.action_space.seed(1)
    while True:
        action = one.action_space.sample()
        for x, y in zip((a := one.step(action))[:4], other.step(action)[:4], strict=True):
            np.testing.assert_allclose(x, y, atol=1e-5)
        if (a[2] | a[3]).any():
            break
    # Of any number of environments, on any number of threads, each has the episodes of its seed.
    many, few = gym.BatchEnv(task, 300), gym.BatchEnv(task, 1)
    np.testing.assert_array_equal(many.reset(seed=0)[0][200:201], few.reset(seed=200)[0])
    for _ in range(80):
        x, y = many.step(np.full((300, 1), 3.0, np.float32)), few.step(np.full((1, 1), 3.0, np.float32))
        for a, b in zip(x[:4], y[:4], strict=True):
            np.testing.assert_array_equal(a[200:201], b)


def test_a_balance_refuses_what_it_cannot_be() -> None:
    task = gym.cartpole()
    low, high = np.full(4, -1.0), np.full(4, 1.0)
    for start, within, text in (
        ((low, high[:3]), (low, high), r"start has the shape"),
        ((high, low), (low, high), "start: the bounds of entry 0 are 1 and -1"),
        ((low * np.inf, high), (low, high), "start: the bounds of entry 0"),
        ((low, high), (low, high * np.nan), "within"),
    ):
        with pytest.raises(ValueError, match=text):
            gym.BatchEnv(gym.Balance(task.simulator, start, within), 2).reset()
    with pytest.raises(ValueError, match="max_steps is 0"):
        gym.BatchEnv(gym.Balance(task.simulator, (low, high), (low, high), max_steps=0), 2).reset()
    env = gym.BatchEnv(task, 3, AutoresetMode.DISABLED)
    env.reset(seed=1)
    with pytest.raises(ValueError, match=r"reset_mask has the shape"):
        env.reset(options={"reset_mask": np.ones(2, bool)})


def test_render_is_a_page() -> None:
    env = gymnasium.make("dualbody/Quadruped-v0", render_mode="html")
    env.reset(seed=0)
    env.action_space.seed(0)
    for _ in range(5):
        env.step(env.action_space.sample())
    assert "<html" in env.unwrapped.render()
    envs = gym.BatchEnv(gym.cartpole(), 2, render_mode="html")
    envs.reset(seed=0)
    envs.step(np.zeros((2, 1), np.float32))
    assert "<html" in envs.render()


def test_the_quadruped_stands_by_a_spring_in_each_joint() -> None:
    env = gym.BatchEnv(gym.quadruped(), 3)
    observations, _ = env.reset(seed=2)
    pose = np.tile([0.0, 0.6, -1.2], 4)
    for _ in range(100):
        # (z, quaternion, joints; velocity)
        u = 60 * (pose - observations[:, 5:17]) - 1.0 * observations[:, 23:35]
        observations, _, over, _, _ = env.step(np.clip(u, -25, 25).astype(np.float32))
        assert not over.any()
    assert (observations[:, 0] > 0.28).all()
    assert env.single_action_space.high.tolist() == [25.0] * 12


def test_a_linear_policy_learns_to_balance() -> None:
    """A cross-entropy search over linear policies, one environment for each candidate: it reaches 500 points."""
    rng = np.random.default_rng(0)
    mean, spread = np.zeros(4), np.full(4, 10.0)
    env = gym.BatchEnv(gym.cartpole(), 64, autoreset_mode=AutoresetMode.SAME_STEP)
    best = 0.0
    for _ in range(12):
        gains = mean + spread * rng.standard_normal((64, 4))
        observations, _ = env.reset(seed=1)
        points, alive = np.zeros(64), np.ones(64, bool)
        for _ in range(500):
            action = np.clip((gains * observations).sum(axis=1, keepdims=True), -10, 10)
            observations, reward, over, cut, _ = env.step(action.astype(np.float32))
            points += reward * alive
            alive &= ~(over | cut)
            if not alive.any():
                break
        elite = gains[np.argsort(-points)[:8]]
        mean, spread, best = elite.mean(axis=0), elite.std(axis=0) + 0.1, points.max()
        if np.sort(points)[-8] == 500:
            break
    assert best == 500
    assert db.__version__


def test_the_example_learns_to_balance(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("cma")
    monkeypatch.syspath_prepend(str(Path(__file__).resolve().parents[1] / "examples"))
    import learn_cartpole

    assert learn_cartpole.main([]) >= learn_cartpole.SOLVED


@pytest.mark.parametrize("name", NAMES)
def test_frames_show_the_state(name: str) -> None:
    env = gymnasium.make(name, render_mode="rgb_array")
    env.reset(seed=1)
    first = env.render()
    assert first.shape == (480, 640, 3) and first.dtype == np.uint8
    env.action_space.seed(1)
    for _ in range(10):
        # Gently, so that no episode is over.
        env.step(0.1 * env.action_space.sample())
    assert not np.array_equal(first, env.render())


def test_a_finger_behind_the_block_pushes_it_to_the_goal() -> None:
    """Walks around the block to the far side of it, then pushes it along its way to the goal."""
    task = gym.push_block()
    env = gym.SingleEnv(task)
    pushed, first = 0, []
    for seed in range(4):
        observed, _ = env.reset(seed=seed)
        first.append(np.hypot(*observed[:2]))
        for _ in range(task.max_steps):
            block, finger, speed = observed[:2], observed[7:9], observed[-2:]
            behind = block + block / np.hypot(*block) * 0.075
            side = finger - block
            if np.hypot(*(finger - behind)) > 0.04 and side @ block < 0.8 * np.hypot(*side) * np.hypot(*block):
                # Around the block at a distance.
                turn = np.array([-side[1], side[0]]) * np.sign(side[0] * block[1] - side[1] * block[0])
                goal = block + 0.13 * (side + 0.6 * turn) / np.hypot(*(side + 0.6 * turn))
            else:
                goal = block
            observed, _, over, cut, _ = env.step(np.clip(40.0 * (goal - finger) - 4.0 * speed, -5.0, 5.0).astype(np.float32))
            if np.hypot(*observed[:2]) < 0.03:
                pushed += 1
                break
            if over or cut:
                break
    assert pushed >= 3, pushed
    assert min(first) > 0.09
