"""Trials: fitted to profiles, and held against the simulator."""

import polars
import pandas
import pyarrow
import pytest

import rsrs
from conftest import FLOCKBOT, rsrs as command

TRIALS = FLOCKBOT.parent / "flockbot_trials"
KINDS = ["speed", "turn", "detection", "period"]


def frames(read):
    return {kind: read(TRIALS / f"{kind}.csv") for kind in KINDS}


def test_a_profile_is_that_of_the_command_line(tmp_path):
    fitted = rsrs.fit("flockbot", **frames(str))

    options = [word for kind in KINDS for word in (f"--{kind}", TRIALS / f"{kind}.csv")]
    written = command("measure", "fit", *options, "--name", "flockbot", "-o", tmp_path / "theirs.yaml")
    assert {**written, "lost_capabilities": None} == {**fitted.as_dict(), "lost_capabilities": None}
    fitted.profile.save(tmp_path / "ours.yaml")
    assert (tmp_path / "ours.yaml").read_text() == (tmp_path / "theirs.yaml").read_text()
    assert fitted.profile == rsrs.Profile.load(tmp_path / "theirs.yaml")


def test_frames_of_anybody_give_the_same_numbers():
    fitted = rsrs.fit("flockbot", **frames(str))
    readers = [
        polars.read_csv,
        pandas.read_csv,
        lambda path: pyarrow.table(polars.read_csv(path)),
        lambda path: polars.read_csv(path).to_dict(as_series=False),
        lambda path: {name: column.to_numpy() for name, column in pandas.read_csv(path).items()},
    ]
    for read in readers:
        other = rsrs.fit("flockbot", **frames(read))
        assert polars.DataFrame(other.intervals).equals(polars.DataFrame(fitted.intervals))
        ours, theirs = other.profile.as_dict(), fitted.profile.as_dict()
        assert {**ours, "provenance": None} == {**theirs, "provenance": None}
        # Where numbers come from is named as the tables are, and not as files that nobody has.
        assert "speed.csv" in str(ours["provenance"]) and "rsrs_" not in str(ours["provenance"])


def test_every_number_has_its_interval():
    table = polars.DataFrame(rsrs.fit("flockbot", **frames(str)).intervals)

    assert {"speed_gain", "turn_gain", "true_positive", "false_positive", "period_s"} <= set(table["quantity"])
    sure = table.drop_nulls(["low", "high"])
    assert len(sure) > 20 and (sure["low"] <= sure["value"]).all() and (sure["value"] <= sure["high"]).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"speed": None}, "no speed: give its table"),
        ({"detection": None}, "in none of the bags does a robot stand and sense"),
        ({"speed": "no/such.csv"}, "no/such.csv"),
        ({"speed": {"robot": ["a"], "sped": [1.0]}}, "^speed.csv:1"),
        ({"speed": {"robot": ["a"], "sped": []}}, "speed.csv: the columns have different lengths"),
        ({"turn": 3}, "turn.csv: expected a path, a data frame or a dictionary"),
        ({"name": "no name"}, "the name is `no name`"),
        ({"radius_m": -1.0}, "the radius is -1"),
        ({"contact": "shove"}, "`shove` is no contact"),
        ({"plan": "trials"}, "give none beside it"),
    ],
)
def test_trials_that_make_no_profile_are_refused(change, message):
    given = {"name": "flockbot", **frames(str), **change}
    with pytest.raises(rsrs.RsrsError, match=message):
        rsrs.fit(**given)


def test_a_simulated_robot_is_validated_as_by_the_command_line(sweep_file, tmp_path):
    conditions = rsrs.Conditions(FLOCKBOT, harsher=False, robots=1, speed_m_s=0.15, turn_rate_rad_s=0.75)
    rows = []
    for trial in range(4):
        run = rsrs.episode(conditions, replicate=trial, duration_s=20, controller=lambda _: (0.15, 0.0))
        for sample in range(len(run)):
            x_m, y_m, heading_rad = run.poses[sample, 0]
            rows.append(("robot_1", trial, sample * 0.13, x_m, y_m, heading_rad, 0.15, 0.0))
    names = ["robot", "trial", "time_s", "x_m", "y_m", "heading_rad", "commanded_m_s", "commanded_rad_s"]
    table = polars.DataFrame(rows, schema=names, orient="row")
    table.write_csv(tmp_path / "driven.csv")

    validation = rsrs.validate(rsrs.Sweep(sweep_file), [table], detection=TRIALS / "detection.csv", robots=400)

    written = command("validate", sweep_file, "--trajectories", tmp_path / "driven.csv", "--detection",
                      TRIALS / "detection.csv", "--robots", 400)
    assert {**validation.as_dict(), "provenance": None} == {**written, "provenance": None}
    assert validation.n_trials == 4 and repr(validation).startswith("Validation(")
    with pytest.raises(rsrs.RsrsError, match="robots is 2000000"):
        rsrs.validate(sweep_file, [table], robots=2_000_000)
    with pytest.raises(rsrs.RsrsError, match="^trajectories_1.csv:1"):
        rsrs.validate(sweep_file, [{"robot": ["a"]}])
