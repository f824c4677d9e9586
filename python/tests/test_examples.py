"""The examples and the notebooks, run with little to do."""

import csv
import os
import subprocess
import sys

import nbformat
import pytest
from nbclient import NotebookClient

from conftest import REPOSITORY, rsrs

NOTEBOOKS = REPOSITORY / "docs" / "notebooks"


@pytest.fixture
def executed(tmp_path, monkeypatch):
    """Executes a notebook where it lies; what goes wrong in a cell is raised."""
    for name in ["IPYTHONDIR", "JUPYTER_RUNTIME_DIR", "MPLCONFIGDIR"]:
        monkeypatch.setenv(name, str(tmp_path / "jupyter"))

    def execute(notebook):
        read = nbformat.read(NOTEBOOKS / notebook, as_version=4)
        assert not any(cell.get("outputs") for cell in read.cells), "the notebook has outputs in it"
        nbformat.validate(read)
        resources = {"metadata": {"path": str(NOTEBOOKS)}}
        return NotebookClient(read, kernel_name="python3", timeout=300, resources=resources).execute()

    return execute


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_cma_learns_from_the_detection_bit(tmp_path):
    tiny = "--generations 2 --population 4 --swarms 2 --duration 30 --episodes 2".split()
    done = subprocess.run(
        [sys.executable, REPOSITORY / "python/examples/learn_to_mill.py", *tiny, "--picture", tmp_path / "curve.png"],
        capture_output=True,
        text=True,
        env=os.environ | {"MPLCONFIGDIR": str(tmp_path)},
    )

    assert done.returncode == 0, done.stderr
    assert done.stdout.count("generation ") == 2 and "stable milling in " in done.stdout
    assert (tmp_path / "curve.png").stat().st_size > 5_000


def test_the_notebook_of_figures_has_the_numbers_of_the_command_line(swept, run, tmp_path, monkeypatch, executed):
    (tmp_path / "bags").mkdir()
    (tmp_path / "sweep").symlink_to(swept)
    (tmp_path / "bags" / "run_1").symlink_to(run)

    figures = tmp_path / "figures"
    monkeypatch.setenv("RESULTS", str(tmp_path))
    monkeypatch.setenv("FIGURES", str(figures))

    executed("figures.ipynb")

    for picture in ["phase_diagram.png", "order_over_time.png", "comparison.png"]:
        assert (figures / picture).stat().st_size > 5_000
    found = rows(figures / "cells.csv")
    expected = [float(row["b_s"]) for row in rows(swept / "cells.csv")]
    assert [float(row["b_s"]) for row in found] == pytest.approx(expected, abs=1e-6)
    (labelled,) = rsrs("label", run)
    (of_run,) = rows(figures / "runs.csv")
    assert of_run["phase"] == labelled["phase"]
    assert float(of_run["rotation"]) == pytest.approx(labelled["evidence"]["rotation"], abs=1e-12)
    over_time = rows(figures / "order_over_time.csv")
    assert [float(row["end_s"]) for row in over_time] == pytest.approx([60, 70, 80, 90, 100, 110, 119], abs=1)


def test_the_figure_of_the_paper_has_ten_lines(executed):
    (cell,) = [cell for cell in executed("phase_plot2.ipynb").cells if cell["cell_type"] == "code"]

    lines = [line for line in cell["source"].splitlines() if line and "import " not in line]
    assert len(lines) == 10
    (picture,) = [output["data"]["image/png"] for output in cell["outputs"] if "image/png" in output.get("data", {})]
    assert len(picture) > 10_000
