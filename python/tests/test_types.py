"""Types and docstrings: what editors and people see."""

import inspect
import os
import subprocess
import sys
from pathlib import Path

import pytest

import rsrs

PACKAGE = Path(rsrs.__file__).parent

USE = """
import numpy as np
import rsrs

verdict = rsrs.judge(np.zeros((500, 9, 3)), commands=(0.15, 0.75), period_s=0.13, reach_m=0.825)
lost: float | None = verdict.order.lost
result: rsrs.SweepResult = rsrs.Sweep("sweep.yaml").run(progress=lambda doing, done, total: None)
viable: bool = result.choose(confirm=10).is_viable
lit: float = float(rsrs.vector_env("sweep.yaml", 16).reset()[0].mean())
poses: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]" = rsrs.Bag("bag").trajectory().poses
"""


def mypy(*arguments):
    environment = dict(os.environ)
    if "site-packages" not in PACKAGE.parts:
        environment["MYPYPATH"] = str(PACKAGE.parent)
    command = [sys.executable, "-m", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=environment)


def test_mypy_accepts_the_package_and_its_use(tmp_path):
    (tmp_path / "use.py").write_text(USE)

    is_installed = "site-packages" in PACKAGE.parts
    for what in [["-p", "rsrs"] if is_installed else [PACKAGE], [tmp_path / "use.py"]]:
        done = mypy("mypy", "--strict", *what)
        assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("wrong", ["rsrs.judge(period=1)", "rsrs.Sweep('a').run(threads='2')", "result.cell"])
def test_mypy_names_what_is_wrong(tmp_path, wrong):
    (tmp_path / "use.py").write_text(USE + wrong + "\n")

    done = mypy("mypy", "--strict", tmp_path / "use.py")

    assert done.returncode == 1 and f"use.py:{USE.count(chr(10)) + 1}: error" in done.stdout, done.stdout


def test_the_stubs_are_those_of_the_module():
    done = mypy("mypy.stubtest", "rsrs")

    assert done.returncode == 0, done.stdout


def test_everything_public_has_a_docstring_with_its_parameters():
    missing = []
    for name in rsrs.__all__:
        if name == "__version__":
            continue
        it = getattr(rsrs, name)
        members = [] if not inspect.isclass(it) else [
            (f"{name}.{key}", getattr(it, key)) for key in vars(it) if not key.startswith("_")
        ]
        for path, member in [(name, it), *members]:
            doc = inspect.getdoc(member) or ""
            if not doc:
                missing.append(path)
            if inspect.isroutine(it):
                signature = inspect.signature(it)
                of_waiting = {"threads", "progress"}
                missing += [f"{path}({p})" for p in signature.parameters if p not in doc and p not in of_waiting]
    assert not missing
