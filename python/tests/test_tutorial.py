"""The pages that have Python in them, typed to the letter."""

import contextlib
import io
import re
import time

import pytest

from conftest import REPOSITORY


def blocks_of(page):
    """Fenced blocks: line, language and text."""
    text = (REPOSITORY / page).read_text()
    found = re.finditer(r"^```(\w+)[^\n]*\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [(text.count("\n", 0, it.start()) + 1, it[1], it[2]) for it in found]


@pytest.fixture
def reader(tmp_path, monkeypatch):
    """A folder with what is shipped."""
    (tmp_path / "launch_configs").symlink_to(REPOSITORY / "launch_configs")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def typed(page):
    """Types the page, and holds what is printed against the block of text behind."""
    names, n_held = {}, 0
    blocks = blocks_of(page)
    for (line, language, text), after in zip(blocks, [*blocks[1:], (0, "", "")]):
        if language != "python":
            continue
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile("\n" * line + text, page, "exec"), names)
        if after[1] == "text":
            assert out.getvalue() == after[2], f"{page}:{line}"
            n_held += 1
    return n_held


def test_the_tutorial_works_to_the_letter_in_less_than_a_minute(reader):
    start = time.monotonic()

    assert typed("docs/python.md") >= 8
    assert (reader / "diagram.png").stat().st_size > 10_000
    assert time.monotonic() - start < 60


def test_what_the_readme_has_works(reader, run):
    (reader / "results").mkdir()
    (reader / "results" / "run_1").symlink_to(run)

    typed("README.md")

    assert (reader / "results" / "flockbot" / "cells.csv").exists()
