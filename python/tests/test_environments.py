"""Worlds that Python commands, and environments over them."""

import time

import numpy as np
import pytest
from gymnasium.vector import VectorEnv
from pettingzoo.test import parallel_api_test, parallel_seed_test

import rsrs
from conftest import FLOCKBOT
from rsrs import parallel_env, vector_env

CONDITIONS = rsrs.Conditions(FLOCKBOT, robots=9, speed_m_s=0.15, turn_rate_rad_s=0.75, placement_radius_m=0.825)


def milling(detections):
    """The paper's controller."""
    turns = np.where(detections, 0.75, -0.75)
    return np.stack([0 * turns + 0.15, turns], axis=-1)


def test_worlds_pass_through_the_poses_of_episodes_with_their_commands():
    worlds = rsrs.Worlds(CONDITIONS, 21, seed=5, replicate=3)
    runs = [rsrs.episode(CONDITIONS, seed=5, replicate=3 + world, duration_s=65) for world in range(21)]

    detections = worlds.detections
    for sample in range(len(runs[0])):
        np.testing.assert_array_equal(worlds.poses, [run.poses[sample] for run in runs])
        np.testing.assert_array_equal(detections, [run.detections[sample] for run in runs])
        detections = worlds.step(milling(detections))

    assert worlds.step_index == 500 and repr(worlds) == "Worlds(21 worlds of 9 robots, after 500 steps)"


def test_order_parameters_are_those_of_the_last_10_seconds():
    worlds = rsrs.Worlds(CONDITIONS, 3)
    poses = []
    for _ in range(600):
        poses.append(worlds.poses)
        worlds.step(milling(worlds.detections))

    order = worlds.order()
    last = np.array(poses[-76:])
    radius_m = np.linalg.norm(last[..., :2] - last[..., :2].mean(axis=2, keepdims=True), axis=-1)
    np.testing.assert_allclose(order["mean_radius_m"], radius_m.mean(axis=(0, 2)), rtol=1e-12)
    bounds = {"rotation": 0.9, "orbit": 0.8, "circliness": 0.5}
    over = [order[name] - bound for name, bound in bounds.items()]
    below = [0.02 - order["blocked"], -order["lost"]]
    np.testing.assert_allclose(worlds.margin(), np.min([*over, *below], axis=0), atol=1e-12)


def test_commands_are_moved_into_the_range_of_the_profile():
    worlds, same = rsrs.Worlds(CONDITIONS, 2), rsrs.Worlds(CONDITIONS, 2)
    (least, most), (right, left) = worlds.command_range

    assert (least, most, right, left) == (0.0, 0.3, -2.5, 2.5)
    worlds.step(np.full((2, 9, 2), 1e6))
    same.step((most, left))
    np.testing.assert_array_equal(worlds.poses, same.poses)
    backward = rsrs.Worlds(CONDITIONS, 1, speed_m_s=(-0.1, 0.1))
    before = backward.poses
    backward.step((-0.1, 0.0))
    assert (np.linalg.norm(backward.poses - before, axis=-1) > 0).any()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"n_worlds": 0}, "no worlds"),
        ({"n_worlds": 10**12}, "expected at most 50000000 poses"),
        ({"seed": 2**63}, "seed is"),
        ({"replicate": 2**64 - 1}, "beyond 2"),
        ({"keep_s": 1e9}, "keep_s is"),
        ({"keep_s": float("nan")}, "keep_s is NaN"),
        ({"speed_m_s": (0.2, 0.1)}, "speed_m_s is from 0.2 to 0.1"),
        ({"turn_rate_rad_s": (0, 1e9)}, "turn_rate_rad_s is from 0"),
        ({"conditions": rsrs.Conditions.from_json(CONDITIONS.to_json())}, "no speed_m_s"),
    ],
)
def test_worlds_that_cannot_be_are_refused_at_once(change, message):
    start = time.monotonic()
    with pytest.raises(rsrs.RsrsError, match=message):
        rsrs.Worlds(**{"conditions": CONDITIONS, "n_worlds": 2, **change})
    assert time.monotonic() - start < 1


@pytest.mark.parametrize(
    ("commands", "message"),
    [(np.zeros((2, 8, 2)), r"shape \(2, 8, 2\), expected \(2, 9, 2\)"), ((np.nan, 0), "not a number"), ("a", "numbers")],
)
def test_commands_that_cannot_be_are_refused_and_change_nothing(commands, message):
    worlds = rsrs.Worlds(CONDITIONS, 2)
    before = worlds.poses
    with pytest.raises(rsrs.RsrsError, match=message):
        worlds.step(commands)
    np.testing.assert_array_equal(worlds.poses, before)
    assert worlds.step_index == 0
    with pytest.raises(rsrs.RsrsError, match="no step was made yet"):
        worlds.margin()
    with pytest.raises(rsrs.RsrsError, match="nothing is kept"):
        rsrs.Worlds(CONDITIONS, 2, keep_s=0).order()


def test_the_parallel_environment_is_one_of_pettingzoo(sweep_file):
    parallel_api_test(parallel_env(CONDITIONS, duration_s=30), num_cycles=500)
    parallel_seed_test(lambda: parallel_env(sweep_file, duration_s=10), num_cycles=100)


def test_the_vector_environment_is_one_of_gymnasium():
    environment = vector_env(CONDITIONS, 6, duration_s=5)
    assert isinstance(environment, VectorEnv) and environment.num_envs == 6
    observations, _ = environment.reset(seed=3)
    first = observations.copy()
    environment.action_space.seed(1)
    ends = []
    for step in range(100):
        assert observations in environment.observation_space
        observations, rewards, terminated, truncated, _ = environment.step(environment.action_space.sample())
        assert rewards.shape == (6,) and not terminated.any()
        ends += [step] if truncated.all() else []
    # 38 steps are 5 s, and one more starts anew.
    assert ends == [37, 76]
    np.testing.assert_array_equal(environment.reset(seed=3)[0], first)


def test_rewards_are_the_way_to_the_wanted_phase():
    environment = vector_env(CONDITIONS, 32, duration_s=120, reward_every=20)
    observations, _ = environment.reset(seed=1)
    total, margins = np.zeros(32), []
    for step in range(1, 901):
        observations, rewards, *_ = environment.step(milling(observations.astype(bool)))
        total += rewards
        assert (rewards == 0).all() or step % 20 == 0
        if step == 1:
            margins.append(environment.worlds.margin())
    margins.append(environment.worlds.margin())

    np.testing.assert_allclose(total, margins[1] - margins[0], atol=1e-12)
    assert np.median(total) > 0.3


def test_a_reward_is_a_function_of_order_parameters_or_none():
    ours = vector_env(CONDITIONS, 4, reward=lambda order: -order["mean_radius_m"], reward_every=1)
    ours.reset(seed=1)
    _, rewards, *_ = ours.step(ours.action_space.sample())
    assert (rewards < 0).all()
    none = vector_env(CONDITIONS, 4, reward=None)
    none.reset(seed=1)
    assert (none.step(none.action_space.sample())[1] == 0).all()
    for wrong in [{"reward": "speed"}, {"reward_every": 0}, {"duration_s": 1e12}, {"duration_s": float("nan")}]:
        with pytest.raises(rsrs.RsrsError):
            vector_env(CONDITIONS, 4, **wrong)
