"""Single runs: simulated, by a controller of one's own, and out of bags."""

import os
import pickle
import signal
import threading
import time

import numpy as np
import polars
import pytest

import rsrs
from conftest import FLOCKBOT, rsrs as command

CELL = {"speed_m_s": 0.15, "turn_rate_rad_s": 0.75}


def conditions(**change):
    return rsrs.Conditions(**{"profile": FLOCKBOT, "robots": 9, **CELL, **change})


def test_episodes_are_the_replicates_of_the_sweep_to_the_bit(swept):
    result = rsrs.SweepResult(swept)
    rows = polars.DataFrame(result.replicates).filter(polars.col("replicate") < 3)

    assert len(rows) == 36
    for row in rows.iter_rows(named=True):
        cell = {axis: row[axis] for axis in result.axes}
        verdict = result.episode(cell, replicate=row["replicate"], world=row["world"]).judge()
        assert verdict.phase == row["phase"]
        for name, value in verdict.order.as_dict().items():
            assert value == row[name], (row, name)


def test_an_episode_is_that_of_the_bag_of_the_command_line(swept, bag):
    result = rsrs.SweepResult(swept)
    simulated, recorded = result.episode(CELL, replicate=2), rsrs.Bag(bag).trajectory()

    n = min(len(simulated), len(recorded))
    assert n > 900
    np.testing.assert_allclose(recorded.poses[:n], simulated.poses[:n], rtol=0, atol=1e-9)
    np.testing.assert_array_equal(recorded.commands[:n], simulated.commands[:n])
    assert recorded.judge().phase == simulated.judge().phase == command("label", bag)[0]["phase"]
    assert rsrs.judge(rsrs.Bag(bag)).as_dict() == command("label", bag)[0]


def test_arrays_have_their_shapes_and_cannot_be_written_to():
    run = rsrs.episode(conditions(), duration_s=90)

    assert (len(run), run.period_s) == (692, 0.13)
    assert run.poses.shape == (692, 9, 3) and run.commands.shape == (692, 9, 2)
    assert run.detections.shape == (692, 9) and run.detections.dtype == bool
    assert run.poses is run.poses and run.robots[8] == "robot_9"
    assert (run.radius_m, run.reach_m, run.behaviour) == (0.075, 0.825, "milling")
    turns = np.where(run.detections, 0.75, -0.75)
    np.testing.assert_array_equal(run.commands, np.stack([0 * turns + 0.15, turns], axis=-1))
    for array in [run.poses, run.commands, run.detections]:
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    assert repr(run) == "Trajectory(692 samples of 9 robots, 90 s at 0.13 s)"


def test_a_trajectory_is_judged_as_its_arrays_are():
    run = rsrs.episode(conditions(), duration_s=120)
    known = {"period_s": run.period_s, "radius_m": run.radius_m, "reach_m": run.reach_m}
    by_hand = rsrs.judge(run.poses, commands=run.commands, **known)

    assert rsrs.judge(run).as_dict()["evidence"] == by_hand.as_dict()["evidence"]
    assert run.judge(behaviour="dispersal").behaviour == "dispersal"
    assert rsrs.judge(run, reach_m=0.01).phase == "dispersion"
    with pytest.raises(rsrs.RsrsError, match="give neither"):
        rsrs.judge(run, period_s=0.1)


def test_conditions_are_those_of_the_cell_of_a_sweep(sweep_file):
    sweep = rsrs.Sweep(sweep_file)
    ours = conditions(placement_radius_m=0.825)

    assert ours == sweep.conditions(CELL) == sweep.conditions("speed_m_s=0.15,turn_rate_rad_s=0.75")
    measured = conditions(placement_radius_m=0.825, harsher=False)
    assert measured == sweep.conditions(CELL, world="as_measured") and measured.digest != ours.digest
    assert pickle.loads(pickle.dumps(ours)) == ours
    assert (ours.n_robots, ours.period_s, ours.reach_m) == (9, 0.13, 0.825)
    assert conditions(profile=rsrs.Profile.load(FLOCKBOT)) == conditions()
    assert repr(ours).startswith("Conditions(9 robots, milling; 0.15 m/s and 0.75 rad/s where something")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"speed_m_s": 9}, "^Conditions: speed_m_s is 9: this looks like mm/s"),
        ({"speed_m_s": 0.6}, "^Conditions: cell `.*`: speed_m_s is 0.6, beyond the robots' limits"),
        ({"sped_m_s": 0.1}, "^Conditions, at `sped_m_s: 0.1`: .*speed_m_s"),
        ({"robots": 0}, "robots"),
        ({"robots": 10**12}, "robots"),
        ({"behaviour": "miling"}, "milling"),
        ({"walls": "soft"}, "walls|clamp"),
        ({"placement": {"kind": "file", "path": "no/such.csv"}}, "no/such.csv"),
        ({"harsher": {"miss_factor": 0.1}}, "miss_factor"),
        ({"speed_m_s": float("nan")}, "nan|NaN|compliant"),
    ],
)
def test_conditions_that_make_no_world_are_refused(change, message):
    with pytest.raises(rsrs.RsrsError, match=message):
        rsrs.episode(conditions(**change), duration_s=60)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"duration_s": 1e12}, "duration_s is 1000000000000, expected seconds from 0 to 604800"),
        ({"duration_s": 604800.0}, "4.18.*e7 poses, expected at most 5e7"),
        ({"duration_s": -1.0}, "duration_s is -1"),
        ({"duration_s": float("nan")}, "duration_s is NaN"),
        ({"seed": 2**63}, "seed is 9223372036854775808, expected below 2\\^63"),
    ],
)
def test_runs_that_would_fill_the_memory_are_refused_at_once(change, message):
    many = conditions(robots=90, placement_radius_m=5) if change.get("duration_s") == 604800.0 else conditions()
    start = time.monotonic()
    with pytest.raises(rsrs.RsrsError, match=message.replace("4.18.*e7", "4.18.*e8")):
        rsrs.episode(many, **change)
    assert time.monotonic() - start < 1


def test_robots_that_find_no_place_are_refused_with_what_to_do():
    with pytest.raises(rsrs.RsrsError, match="help: "):
        rsrs.episode(conditions(robots=500, placement_radius_m=0.5))


def test_a_function_is_a_controller():
    calls = []

    def controller(detections):
        calls.append(detections)
        return np.where(detections[:, None], [0.15, 0.75], [0.15, -0.75])

    ours = rsrs.episode(conditions(), duration_s=60, controller=controller)
    theirs = rsrs.episode(conditions(), duration_s=60)

    np.testing.assert_array_equal(ours.poses, theirs.poses)
    assert len(calls) == 461 and calls[0].shape == (9,) and calls[0].dtype == bool
    straight = rsrs.episode(conditions(), duration_s=60, controller=lambda _: (0.1, 0.0))
    np.testing.assert_array_equal(straight.commands, np.broadcast_to([0.1, 0.0], (461, 9, 2)))


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (np.zeros((8, 2)), r"shape \(8, 2\), expected \(9, 2\)"),
        (np.zeros(3), r"shape \(3,\)"),
        ((np.nan, 0), "returned NaN, expected numbers from -1000 to 1000"),
        ((1e30, 0), "returned 1000000000000000000000000000000, expected"),
        (None, "returned NaN"),
        ("forward", "expected an array of numbers"),
    ],
)
def test_what_a_controller_must_not_return_is_refused(answer, message):
    with pytest.raises(rsrs.RsrsError, match=message):
        rsrs.episode(conditions(), controller=lambda _: answer)


def test_what_a_controller_raises_ends_the_run():
    with pytest.raises(ZeroDivisionError):
        rsrs.episode(conditions(), controller=lambda detections: 1 / 0)


@pytest.mark.parametrize("controller", [None, lambda _: (0.1, 0.2)])
def test_ctrl_c_ends_an_episode(interruptible, controller):
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        rsrs.episode(conditions(), duration_s=600_000, controller=controller)
    assert time.monotonic() - start < 5


def test_bags_have_their_record_and_topics(bag, run):
    for path in (bag, run):
        opened = rsrs.Bag(path)
        assert opened.record["conditions"]["robots"] == 9
        assert "/robot_1/odom" in [topic["name"] for topic in opened.info()["topics"]]
        assert os.fspath(opened) == str(path) and repr(opened) == f"Bag({path})"
    assert rsrs.Bag(run).trajectory().detections is None
    with pytest.raises(rsrs.RsrsError):
        rsrs.Bag("no/such/bag")
