"""The judge: anybody's poses, and bags."""

import threading

import numpy as np
import pytest

import rsrs
from conftest import PERIOD_S, SPEED_M_S, leaving, ring
from conftest import rsrs as command

FLOCKBOT = {"period_s": PERIOD_S, "radius_m": 0.075, "reach_m": 0.825}


def test_a_ring_that_runs_is_stable_milling():
    verdict = rsrs.judge(ring(120), commands=(SPEED_M_S, 0.2), **FLOCKBOT)

    assert verdict.phase == "stable_milling"
    assert verdict.is_wanted and verdict.is_settled and verdict.why == []
    assert verdict.order.rotation > 0.99 and verdict.order.lost == 0
    assert (verdict.n_robots, verdict.duration_s) == (9, pytest.approx(120, abs=PERIOD_S))
    assert repr(verdict).startswith("Verdict(stable milling: 9 robots, 120 s, lost 0.00, blocked 0.00")


def test_a_ring_that_stands_is_jammed():
    standing = np.repeat(ring(1)[:1], 1000, axis=0)

    verdict = rsrs.judge(standing, commands=(SPEED_M_S, 0.2), **FLOCKBOT)

    assert verdict.phase == "colliding_unstable"
    assert verdict.why[0] == "stuck 1.00, and 0.20 or more is colliding unstable"


def test_commands_of_any_shape_that_broadcasts_give_the_same():
    poses = ring(90)
    each = np.broadcast_to([SPEED_M_S, 0.2], (len(poses), 9, 2))

    verdicts = [rsrs.judge(poses, commands=it, **FLOCKBOT) for it in [each, each[0], (SPEED_M_S, 0.2)]]

    assert len({str(verdict.as_dict()) for verdict in verdicts}) == 1


def test_without_commands_a_phase_that_hinges_on_them_is_refused_by_name():
    dispersed = rsrs.judge(leaving(120), **FLOCKBOT)
    assert dispersed.phase == "dispersion" and dispersed.is_settled is None
    assert (dispersed.order.blocked, dispersed.order.orbit, dispersed.order.lost) == (None, None, 1.0)
    assert dispersed.why[0] == "lost 1.00, and 0.25 or more is dispersion"
    assert dispersed.why[1].startswith("robot 0 left everybody's reach at ")

    with pytest.raises(rsrs.RsrsError, match="decides between colliding unstable, stable milling, semi-st"):
        rsrs.judge(ring(120), **FLOCKBOT)


def test_a_behaviour_of_ones_own_is_judged_in_its_arena_and_has_what_it_asks_for(tmp_path):
    file = tmp_path / "covering.yaml"
    file.write_text(
        "name: covering\nwords: {noun: covering, swarm: a swarm, verb: [cover, covers, covered]}\n"
        "phases: [{key: covered}, {key: bare}]\notherwise: bare\nwindow: whole_run\n"
        "rules: [{phase: covered, when: {coverage: {at_least: 0.8}}}]\n"
    )
    with pytest.raises(rsrs.RsrsError, match="coverage is of an arena with walls"):
        rsrs.judge(ring(90), behaviour=str(file), **FLOCKBOT)

    verdict = rsrs.judge(ring(90), behaviour=str(file), arena_m=2.0, **FLOCKBOT)

    # The middle one of nine cells stays bare, and at most eight others have a robot.
    assert 0.5 < verdict.order["coverage"] < 8.9 / 9
    assert verdict.order.as_dict()["coverage"] == verdict.order["coverage"]
    assert "coverage" in repr(verdict)
    with pytest.raises(KeyError):
        verdict.order["spread_m"]


def test_a_behaviour_that_asks_for_no_commands_needs_none():
    poses = ring(90)
    poses[..., :2] *= 0.3
    for behaviour in ["aggregation", "dispersal"]:
        without = rsrs.judge(poses, behaviour=behaviour, **FLOCKBOT)
        given = rsrs.judge(poses, commands=(SPEED_M_S, 0.2), behaviour=behaviour, **FLOCKBOT)
        assert without.phase == given.phase and without.is_settled == given.is_settled
    assert rsrs.judge(poses, behaviour="aggregation", **FLOCKBOT).phase == "aggregated"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"poses": np.zeros((1000, 9, 2))}, r"poses have shape \(1000, 9, 2\), expected \(T, N, 3\)"),
        ({"poses": np.zeros(3)}, r"poses have shape \(3,\), expected"),
        ({"poses": np.zeros((1000, 0, 3))}, "no robots, expected at least 1"),
        ({"poses": np.zeros((0, 9, 3))}, "0.0 s recorded, expected at least 60 s"),
        ({"poses": "no/such/bag"}, "give neither"),
        ({"poses": [["a", "b"]]}, "poses: expected an array of numbers"),
        ({"poses": object()}, "poses: expected an array of numbers"),
        ({"poses": [[1.0], [1.0, 2.0]]}, "poses: expected an array of numbers"),
        ({"commands": np.zeros((1000, 8, 2))}, r"commands have shape \(1000, 8, 2\), expected \(1000, 9, 2\)"),
        ({"commands": (np.nan, 0.0)}, "not finite, 0.00 s after the start"),
        ({"commands": (1e300, 0.0)}, "beyond 1e9"),
        ({"period_s": 0.0}, "period_s is 0, expected seconds from 0.001 to 2"),
        ({"period_s": -1.0}, "period_s is -1"),
        ({"period_s": float("nan")}, "period_s is NaN"),
        ({"period_s": float("inf")}, "period_s is inf"),
        ({"period_s": None}, "no period_s"),
        ({"radius_m": -0.1}, "radius_m is -0.1, expected metres"),
        ({"reach_m": float("inf")}, "reach_m is inf, expected metres"),
        ({"reach_m": None}, "the robots' reach is not known, and decides: dispersion below 0"),
        ({"behaviour": "miling"}, "unknown behaviour `miling`, expected one of milling"),
    ],
)
def test_what_cannot_be_judged_is_refused_with_what_is_wrong(change, message):
    given = {"poses": ring(130), "commands": (SPEED_M_S, 0.2), **FLOCKBOT, **change}
    if "poses" not in change and given["commands"] is change.get("commands"):
        given["poses"] = given["poses"][:1000]

    with pytest.raises(rsrs.RsrsError, match=message) as refused:
        rsrs.judge(**given)
    assert isinstance(refused.value, ValueError)


@pytest.mark.parametrize("number", [np.nan, np.inf, 1e17, -1e300])
def test_a_pose_that_can_be_nobodys_is_refused_with_robot_and_time(number):
    poses = ring(90)
    poses[100, 4, 1] = number

    with pytest.raises(rsrs.RsrsError, match="robot 4 has a pose or command .*13.00 s after the start"):
        rsrs.judge(poses, commands=(SPEED_M_S, 0.2), period_s=PERIOD_S, radius_m=0.075)


def test_arrays_of_any_memory_are_read_alike():
    poses = ring(90)
    expected = rsrs.judge(poses, commands=(SPEED_M_S, 0.2), **FLOCKBOT).as_dict()
    wide = np.zeros((len(poses), 9, 6))
    wide[..., ::2] = poses
    for other in [poses.tolist(), np.asfortranarray(poses), wide[..., ::2], poses.astype(">f8")]:
        assert rsrs.judge(other, commands=(SPEED_M_S, 0.2), **FLOCKBOT).as_dict() == expected


def test_a_bag_has_the_label_of_the_command_line(bag):
    verdict = rsrs.judge(bag)

    [label] = command("label", bag)
    assert verdict.as_dict() == label
    assert verdict.phase == label["phase"]
    assert verdict.order.circliness == label["evidence"]["circliness"]
    assert str(bag) in str(verdict)


def test_a_bag_is_judged_by_what_is_given_beside_it(bag):
    assert rsrs.judge(str(bag), reach_m=0.1).phase == "dispersion"
    assert rsrs.judge(bag, behaviour="dispersal").behaviour == "dispersal"
    with pytest.raises(rsrs.RsrsError, match="no/such/bag"):
        rsrs.judge("no/such/bag")


def test_verdicts_cannot_be_changed():
    verdict = rsrs.judge(ring(90), commands=(SPEED_M_S, 0.2), **FLOCKBOT)
    for it, name in [(verdict, "phase"), (verdict.order, "lost")]:
        with pytest.raises(AttributeError):
            setattr(it, name, None)


def test_threads_judge_at_once():
    poses, found = ring(90), []
    threads = [
        threading.Thread(target=lambda: found.append(rsrs.judge(poses, commands=(0.15, 0.2), **FLOCKBOT).phase))
        for _ in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == ["stable_milling"] * 8
