"""What several tests use: swarms as arrays, and a sweep and a run by the command line."""

import json
import os
import shutil
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
FLOCKBOT = REPOSITORY / "launch_configs" / "profiles" / "flockbot.yaml"
PERIOD_S = 0.13
SPEED_M_S = 0.15


def ring(duration_s, n_robots=9, radius_m=0.7, speed_m_s=SPEED_M_S):
    """Robots that drive on one ring: poses of shape (T, N, 3)."""
    time_s = np.arange(int(duration_s / PERIOD_S + 1e-9))[:, None] * PERIOD_S
    angle = 2 * np.pi * np.arange(n_robots)[None, :] / n_robots + speed_m_s / radius_m * time_s
    return np.stack([radius_m * np.cos(angle), radius_m * np.sin(angle), angle + np.pi / 2], axis=-1)


def leaving(duration_s, n_robots=9):
    """Robots that drive away from each other."""
    time_s = np.arange(int(duration_s / PERIOD_S + 1e-9))[:, None] * PERIOD_S
    angle = 2 * np.pi * np.arange(n_robots)[None, :] / n_robots + 0 * time_s
    way_m = 0.5 + SPEED_M_S * time_s
    return np.stack([way_m * np.cos(angle), way_m * np.sin(angle), angle], axis=-1)


def rsrs(*arguments):
    """Runs the command line and returns what it prints, which must be JSON."""
    command = shutil.which(os.environ.get("RSRS", "rsrs"))
    assert command, "these tests hold the package against the command line: put its path into RSRS"
    done = subprocess.run([command, *map(str, arguments), "--format", "json"], capture_output=True, text=True)
    assert done.returncode in (0, 3), done.stderr
    return json.loads(done.stdout)


@pytest.fixture
def interruptible():
    """Ctrl-C raises, also where a shell has started the tests with it ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


SWEEP = """
profile: PROFILE
axes:
  speed_m_s: [0.1, 0.15, 0.2]
  turn_rate_rad_s: [0.5, 0.75]
fixed: {robots: 9, placement_radius_m: 0.825}
replicates: 8
duration_s: 120
seed: 7
"""


@pytest.fixture(scope="session")
def sweep_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("sweep") / "sweep.yaml"
    path.write_text(SWEEP.replace("PROFILE", str(FLOCKBOT)))
    return path


@pytest.fixture(scope="session")
def swept(sweep_file):
    """The folder of a sweep that the command line made."""
    folder = sweep_file.parent / "swept"
    rsrs("sweep", sweep_file, "-o", folder)
    return folder


EXPERIMENT = """
fleet: FLEET
cell: {speed_m_s: 0.15, turn_rate_rad_s: 0.75, robots: 9}
placement: {kind: disc_facing_out, radius_m: 0.825}
duration_s: 120
seed: 99
robot_lost: abort
simulator: {time: lockstep, profile: measured}
"""


@pytest.fixture(scope="session")
def run(swept):
    """A run over ROS 2, with a simulator in place of the robots, in a network of its own."""
    experiment = swept.parent / "experiment.yaml"
    fleet = REPOSITORY / "launch_configs" / "fleets" / "nine_virtual.yaml"
    experiment.write_text(EXPERIMENT.replace("FLEET", str(fleet)))
    rsrs("run", experiment, "-o", swept.parent / "run")
    return swept.parent / "run"


@pytest.fixture(scope="session")
def bag(swept):
    """A bag of one of its replicates, by the command line."""
    folder = swept.parent / "bag"
    rsrs("episode", swept, "--cell", "speed_m_s=0.15,turn_rate_rad_s=0.75", "--replicate", 2, "-o", folder)
    return folder
