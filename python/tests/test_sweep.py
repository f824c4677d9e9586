"""Sweeps: from a file or from keys, results as tables, and what follows from them."""

import os
import pickle
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pandas
import polars
import pyarrow
import pytest

import rsrs
from conftest import FLOCKBOT, rsrs as command

KEYS = {
    "profile": FLOCKBOT,
    "axes": {"speed_m_s": [0.1, 0.15, 0.2], "turn_rate_rad_s": np.array([0.5, 0.75])},
    "fixed": {"robots": 9, "placement_radius_m": 0.825},
    "replicates": 8,
    "duration_s": 120,
    "seed": 7,
}


def long_sweep():
    """One that takes minutes."""
    return rsrs.Sweep(**{**KEYS, "replicates": 100_000, "duration_s": 600})


def same_files(one, other):
    names = sorted(path.name for path in Path(one).iterdir() if path.is_file())
    assert names == sorted(path.name for path in Path(other).iterdir() if path.is_file())
    for name in names:
        assert without_commit(Path(one) / name) == without_commit(Path(other) / name), name
    return names


def without_commit(path):
    """The command line may be of another commit where one tries things out."""
    lines = path.read_bytes().split(b"\n")
    return [line for line in lines if not line.startswith(b"  commit: ")]


def test_a_folder_is_that_of_the_command_line_byte_for_byte(sweep_file, swept, tmp_path):
    result = rsrs.Sweep(sweep_file).run(tmp_path / "swept", threads=1)

    assert "replicates.parquet" in same_files(swept, result.folder)


def test_keys_make_the_sweep_of_their_file(sweep_file):
    of_file, of_keys = rsrs.Sweep(sweep_file), rsrs.Sweep(**KEYS)

    assert of_keys.digest == of_file.digest
    assert of_keys.cells[1] == {"speed_m_s": 0.1, "turn_rate_rad_s": 0.75}
    assert of_keys.axes == ["speed_m_s", "turn_rate_rad_s"]
    assert repr(of_keys) == (
        "Sweep(6 cells of speed_m_s x turn_rate_rad_s, 8 replicates of 120 s in 2 worlds, seed 7)"
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"axes": {"sped_m_s": [0.1]}}, "speed_m_s"),
        ({"axes": {"speed_m_s": [9.0]}}, "9"),
        ({"axes": {"speed_m_s": [float("nan")]}}, "NaN|nan|compliant"),
        ({"axes": {}}, "Sweep: give either `axes` or `cells`"),
        ({"duration_s": 1e12}, "duration_s is 1000000000000"),
        ({"duration_s": -1}, "duration_s is -1"),
        ({"duration_s": 10}, "10|60"),
        ({"replicates": 0}, "replicates is 0"),
        ({"replicates": 10**15}, "replicates is 1000000000000000"),
        ({"seed": -1}, "Sweep, at `seed: -1`: `-1` is no whole number"),
        ({"seed": 2**63}, "seed"),
        ({"fixed": {"robots": 10**9, "turn_rate_rad_s": 0.5}, "axes": {"speed_m_s": [0.1]}}, "robots is"),
        ({"profile": "no/such.yaml"}, "no/such.yaml"),
        ({"profile": object()}, "found <object"),
        ({"replicate": 3}, "replicate"),
        ({"axes": {"speed_m_s": {"from": 0.0, "to": 0.3, "steps": 10**12}}}, "steps|cells"),
    ],
)
def test_what_cannot_be_swept_is_refused_with_what_is_wrong(change, message):
    with pytest.raises(rsrs.RsrsError, match=message):
        rsrs.Sweep(**{**KEYS, **change}).run()


def test_a_sweep_is_a_file_or_keys():
    for arguments in [lambda: rsrs.Sweep(), lambda: rsrs.Sweep("sweep.yaml", seed=1)]:
        with pytest.raises(rsrs.RsrsError, match="either the path of a sweep file or its keys"):
            arguments()


def test_tables_are_read_by_polars_pandas_pyarrow_and_numpy(swept):
    result = rsrs.SweepResult(swept)

    for table, n_rows in [(result.cells, 12), (result.replicates, 96)]:
        assert len(table) == n_rows
        frames = [polars.DataFrame(table), pandas.DataFrame.from_arrow(table), pyarrow.table(table)]
        by_numpy = table.to_numpy()
        assert list(by_numpy) == table.columns
        for frame in frames:
            assert list(getattr(frame, "column_names", frame.columns)) == table.columns
        for name in table.columns:
            assert list(frames[0][name]) == list(by_numpy[name])
    cells = polars.DataFrame(result.cells)
    assert cells["world"].unique(maintain_order=True).to_list() == ["harsher", "as_measured"]
    assert cells["n"].to_list() == [8] * 12
    counted = polars.DataFrame(result.replicates).group_by("world", *result.axes).agg(
        b_s=(polars.col("phase") == "stable_milling").mean()
    )
    joined = cells.join(counted, on=["world", *result.axes])
    assert joined["b_s"].to_list() == joined["b_s_right"].to_list()
    assert repr(result.cells).startswith("Table(12 rows: speed_m_s, turn_rate_rad_s, world, n, stable_m")


def test_cells_are_those_of_the_file(swept):
    cells = polars.DataFrame(rsrs.SweepResult(swept).cells)
    written = polars.read_csv(swept / "cells.csv")

    for world, prefix in [("harsher", ""), ("as_measured", "as_measured_")]:
        of_world = cells.filter(polars.col("world") == world)
        for name in ["n", "stable_milling", "dispersion", "phase"]:
            assert of_world[name].to_list() == written[prefix + name].to_list()
        for name in ["b_s", "b_s_low", "b_s_high"]:
            assert of_world[name].to_list() == pytest.approx(written[prefix + name].to_list(), abs=1e-6)


def test_cells_are_a_dataset_of_xarray(swept):
    result = rsrs.SweepResult(swept)
    data = result.to_xarray()

    assert dict(data.sizes) == {"world": 2, "speed_m_s": 3, "turn_rate_rad_s": 2}
    row = polars.DataFrame(result.cells).row(3, named=True)
    at = {"world": row["world"], "speed_m_s": row["speed_m_s"], "turn_rate_rad_s": row["turn_rate_rad_s"]}
    assert float(data.b_s.sel(at)) == row["b_s"] and int(data.n.sel(at)) == 8
    listed = rsrs.Sweep(**{**KEYS, "axes": {}, "cells": result.sweep.cells[:3]}).run().to_xarray()
    assert dict(listed.sizes) == {"world": 2, "cell": 3}
    assert float(listed.turn_rate_rad_s[1]) == 0.75 and int(listed.n[1, 2]) == 8


def test_results_do_not_depend_on_threads_and_outlive_their_sweep():
    one, many = (rsrs.Sweep(**KEYS).run(threads=n) for n in (1, 3))

    frames = [polars.DataFrame(result.replicates) for result in (one, many)]
    assert frames[0].equals(frames[1])
    table, folder = one.replicates, one.folder
    del one
    assert folder.exists() and len(table.to_numpy()["seed"]) == 96
    del table
    assert not folder.exists()


def test_progress_is_shown_and_counts_to_the_end(capsys):
    calls = []
    rsrs.Sweep(**KEYS).run(progress=lambda *call: calls.append(call))
    assert calls[-1] == ("sweeping", 96, 96)
    assert [done for _, done, _ in calls] == sorted(done for _, done, _ in calls)

    rsrs.Sweep(**KEYS).run(progress=True)
    assert capsys.readouterr().err.endswith("sweeping: 96 of 96 runs\n")
    with pytest.raises(rsrs.RsrsError, match="progress is neither"):
        rsrs.Sweep(**KEYS).run(progress="yes")


def test_what_progress_raises_ends_the_sweep():
    def stop(doing, done, total):
        raise KeyError("enough")

    start = time.monotonic()
    with pytest.raises(KeyError, match="enough"):
        long_sweep().run(progress=stop)
    assert time.monotonic() - start < 20


def test_ctrl_c_ends_a_sweep_which_goes_on_where_it_was(interruptible, tmp_path):
    sweep = rsrs.Sweep(**{**KEYS, "replicates": 4000})
    done = []

    def interrupt(doing, n_done, total):
        done.append(n_done)
        if 0 < n_done < total:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        sweep.run(tmp_path / "swept", progress=interrupt)
    with pytest.raises(rsrs.RsrsError, match="unfinished"):
        rsrs.SweepResult(tmp_path / "swept")
    started = []
    resumed = sweep.run(tmp_path / "swept", progress=lambda _, n_done, total: started.append(n_done))

    assert started[0] > 0
    assert polars.DataFrame(resumed.replicates).equals(polars.DataFrame(sweep.run().replicates))


def test_other_threads_run_on_during_a_sweep():
    counted, is_over = [0], threading.Event()

    def count():
        while not is_over.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    start = time.monotonic()
    rsrs.Sweep(**{**KEYS, "replicates": 2000}).run(threads=1)
    took_s = time.monotonic() - start
    is_over.set()
    thread.join()

    # With the interpreter's lock held it would be a few.
    assert counted[0] > took_s * 50


@pytest.mark.parametrize("threads", [0, 10**9])
def test_a_number_of_threads_that_nobody_means_is_refused(threads):
    with pytest.raises(rsrs.RsrsError, match="threads is"):
        rsrs.Sweep(**KEYS).run(threads=threads)


def test_a_choice_is_that_of_the_command_line(swept, tmp_path):
    result = rsrs.SweepResult(swept)
    choice = result.choose(viable=0.3, confirm=50)

    chosen = command("choose", swept, "--viable", 0.3, "--confirm", 50)
    factors = chosen.pop("factors")
    assert factors["cell"] == choice.cell
    assert choice.as_dict() == chosen
    assert choice.is_viable and choice.b_s_low <= choice.b_s <= choice.b_s_high
    assert repr(choice).startswith("Choice(viable: speed_m_s=")
    assert str(choice).startswith("viable: speed_m_s=")
    choice.save(tmp_path / "choice.json")
    assert (tmp_path / "choice.json").read_text().startswith("{")


def test_where_no_cell_is_viable_the_best_is_there(swept):
    choice = rsrs.SweepResult(swept).choose(viable=1.0, confirm=10)

    assert not choice.is_viable and set(choice.cell) == {"speed_m_s", "turn_rate_rad_s"}
    assert str(choice).startswith("no viable cell: ")
    with pytest.raises(rsrs.RsrsError, match="no viable cell"):
        choice.save("choice.json")


@pytest.mark.parametrize(
    ("change", "message"),
    [({"viable": 2.0}, "wanted share is 2"), ({"confirm": 0}, "confirm is 0"), ({"robots": 0}, "robots is 0"),
     ({"robots": 8}, "no cell has 8 robots")],
)
def test_a_choice_that_cannot_be_made_is_refused(swept, change, message):
    with pytest.raises(rsrs.RsrsError, match=message):
        rsrs.SweepResult(swept).choose(**{"confirm": 10, **change})


def test_a_diagram_is_shown_and_saved(swept, tmp_path):
    result = rsrs.SweepResult(swept)
    picture = result.diagram()

    assert picture.svg == (swept / "diagram.svg").read_text() == picture._repr_svg_() == result._repr_svg_()
    marked = result.diagram(choice=result.choose(viable=0.3, confirm=50), world="both", title="Ours")
    assert "Ours" in marked.svg and "confirmed" in marked.svg
    for name in ["d.svg", "d.png", "d.pdf"]:
        picture.save(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 1000
    for value in ["circliness", "settling_time_s", "difference"]:
        assert "<svg" in result.diagram(value=value).svg
    with pytest.raises(rsrs.RsrsError, match="unknown value `speed`, expected one of lost, blocked"):
        result.diagram(value="speed")
    for wrong in [lambda: picture.save("d.doc"), lambda: result.diagram(world="b"), lambda: result.diagram(x="z")]:
        with pytest.raises(rsrs.RsrsError):
            wrong()


def test_profiles_are_values():
    profile = rsrs.Profile.load(FLOCKBOT)

    assert profile == rsrs.Profile(profile.to_yaml()) == pickle.loads(pickle.dumps(profile))
    assert (profile.radius_m, profile.reach_m) == (0.075, 0.825)
    worse = profile.harsher(miss_factor=3)
    assert worse.as_dict()["sensing"]["true_positive"] < profile.as_dict()["sensing"]["true_positive"]
    with pytest.raises(rsrs.RsrsError):
        rsrs.Profile("name: nothing")
    with pytest.raises(rsrs.RsrsError):
        profile.harsher(miss_factr=3)


def test_answers_are_those_of_the_command_line(sweep_file):
    few = {"replicates": 5, "confirm": 20}
    answers = rsrs.answer(rsrs.Sweep(sweep_file), **few)

    assert answers.as_dict() == command("answer", sweep_file, "--replicates", 5, "--confirm", 20)
    assert len(answers.questions) == 5 and "<svg" in answers._repr_svg_()
    assert repr(answers).startswith("Answers(")


def test_a_diagnosis_is_that_of_the_command_line(sweep_file, swept):
    diagnosis = rsrs.diagnose(rsrs.SweepResult(swept), wanted=0.2, confirm=20, costs={"range_m": 2})

    assert diagnosis.as_dict() == command("diagnose", swept, "--b-s", 0.2, "--confirm", 20, "--cost", "range_m=2")
    assert repr(diagnosis).startswith("Diagnosis(")
    with pytest.raises(rsrs.RsrsError, match="unknown"):
        rsrs.diagnose(sweep_file, costs={"rang_m": 2})


def test_controllers_are_found(tmp_path):
    few = {"controllers": 30, "replicates": 2, "duration_s": 100, "robots": 4}
    explored = rsrs.explore(rsrs.Profile.load(FLOCKBOT), tmp_path / "gallery", behaviour="dispersal", **few)

    assert (explored.folder / "gallery.html").exists()
    assert explored.as_dict()["n_controllers"] == 30
    assert repr(explored).startswith("Explored(")
    with pytest.raises(rsrs.RsrsError, match="unknown walls"):
        rsrs.explore(FLOCKBOT, tmp_path / "other", walls="soft")
    with pytest.raises(rsrs.RsrsError, match="controllers is 0"):
        rsrs.explore(FLOCKBOT, tmp_path / "other", controllers=0)


def test_a_search_takes_the_files_of_the_command_line(tmp_path):
    (tmp_path / "room.yaml").write_text("arena: {disc_m: 1.2}\n")
    (tmp_path / "square.yaml").write_text("goals: [{place_m: [0, 0], radius_m: 0.2}]\n")
    (tmp_path / "starts.csv").write_text("x_m,y_m,heading_rad\n0.1,0,0\n0.5,0,1\n0.1,0.4,2\n")
    (tmp_path / "table.yaml").write_text(
        "numbers: {turn_rad_s: {value: 0.5, from: 0.2, to: 1}}\n"
        "rows: [{command: {speed_m_s: 0.1, turn_rate_rad_s: $turn_rad_s}}]\n"
    )
    files = {"controller": tmp_path / "table.yaml", "starts": tmp_path / "starts.csv"}
    few = {"controllers": 4, "replicates": 2, "duration_s": 70, "robots": 3}

    explored = rsrs.explore(FLOCKBOT, tmp_path / "gallery", world_file=tmp_path / "room.yaml", **files, **few)

    typed = ["--world-file", tmp_path / "room.yaml", "--controller", files["controller"], "--starts", files["starts"]]
    typed += ["--controllers", 4, "--replicates", 2, "--duration", 70, "--robots", 3]
    found = command("explore", FLOCKBOT, "-o", tmp_path / "typed", *typed)["found"]
    assert len(found) > 0 and explored.as_dict()["found"] == found
    assert (tmp_path / "gallery" / "world.yaml").exists()
    with pytest.raises(rsrs.RsrsError, match="no `arena_m`"):
        rsrs.explore(FLOCKBOT, tmp_path / "other", world_file=tmp_path / "square.yaml", **few)
    with pytest.raises(rsrs.RsrsError, match="of two commands"):
        rsrs.explore(FLOCKBOT, tmp_path / "other", forward=True, **files, **few)


def test_runs_are_compared_and_reported_as_by_the_command_line(swept, run, bag, tmp_path):
    comparison = rsrs.compare(rsrs.SweepResult(swept), [run])

    assert comparison.as_dict() == command("compare", swept, "--bags", run)
    assert comparison.verdict in ("undecided", "no_claim")
    assert repr(comparison).startswith("Comparison(")
    reported = rsrs.report(swept, tmp_path / "report.html", bags=[run])
    assert reported.verdict == comparison.verdict
    assert rsrs.report(rsrs.SweepResult(swept), tmp_path / "alone.html") is None
    assert "<svg" in (tmp_path / "alone.html").read_text()
    assert (tmp_path / "report.html").read_text().startswith("<!DOCTYPE html>")
    with pytest.raises(rsrs.RsrsError, match="margin is 0.9"):
        rsrs.compare(swept, [run], margin=0.9)
    with pytest.raises(rsrs.RsrsError, match="does not end in .html"):
        rsrs.report(swept, "report.pdf", bags=[run])
    with pytest.raises(rsrs.RsrsError, match="is a replicate of the sweep itself"):
        rsrs.compare(swept, [bag])
