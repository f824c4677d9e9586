"""Three predictions of how often robots mill, beside how often they do on floors that are not the simulator's.

    python docs/floors/compare.py FOLDER [FLOOR]…

FOLDER is made, or gone on with: each floor has a folder in it, and `results.json` has all numbers. FLOOR is mujoco,
swarmsim or rays (default: all). For a test, RUNS and REPLICATES state how many runs each cell gets on a
floor and in a simulated world, PROFILES how many pseudo-realities are drawn, and CELLS how many cells are run.
BINARIES names a folder with `rsrs` and `examples/floors`; without it, both are built.

    python docs/floors/compare.py --tables docs/floors/results.json

prints the tables of docs/predictors.md.
"""

import csv
import importlib
import itertools
import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import evaluation

ROOT = Path(__file__).resolve().parent.parent.parent
FLOORS = ("mujoco", "swarmsim", "rays")
MEASURED_ROBOTS = 5
DURATION_S = 100.0
WIDENING = 2
# Of a plan: what a lab expects of its robots.
PLANS = {
    "mujoco": "--turn-rate 0.4,1.6 --range 1.0 --half-angle 0.5 --radius 0.07 --period 0.1",
    "swarmsim": "--turn-rate 0.4,1.6 --range 0.9 --half-angle 0.4 --radius 0.075 --period 0.1",
    "rays": "--turn-rate 0.4,1.6 --range 0.9 --half-angle 0.4 --radius 0.075 --period 0.13",
}
# Runs of each cell; a run of one floor takes ten times as long as one of another.
RUNS = {"mujoco": 20, "swarmsim": 20, "rays": 30}
# How many robots: two numbers of each floor of which simulated ones mill sometimes, and not always.
ROBOTS = {"mujoco": (6, 12), "swarmsim": (6, 9), "rays": (6, 9)}
AXES = {
    "placement_radius_m": (0.6, 1.0),
    "speed_m_s": (0.08, 0.24),
    "turn_rate_rad_s": (0.5, 1.0),
}

# Where not all cells are run, because a run takes long: those that are, by their values in the order above.
RUN = {
    "mujoco": lambda robots, disc_m, speed_m_s, rate_rad_s: robots == 6 or (speed_m_s, rate_rad_s) == (0.24, 0.5),
    "swarmsim": lambda robots, disc_m, speed_m_s, rate_rad_s: robots == 6 or (speed_m_s, rate_rad_s) == (0.08, 1.0),
}


def number(name, usual):
    return int(os.environ.get(name, usual))


class Programs:
    """What is built of the repository."""

    def __init__(self):
        target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
        self.folder = Path(os.environ.get("BINARIES", target / "release")).resolve()
        if "BINARIES" not in os.environ:
            build = "cargo build --release -p rsrs --bin rsrs --example floors"
            subprocess.run(build.split(), cwd=ROOT, check=True)
        self.floors = self.folder / "examples/floors"

    def rsrs(self, folder, arguments):
        done = subprocess.run([self.folder / "rsrs", *arguments.split()], cwd=folder, stdout=subprocess.PIPE)
        if done.returncode not in (0, 3):  # 3: done, and the answer is negative.
            sys.exit(f"rsrs {arguments} ended with {done.returncode}")
        return json.loads(done.stdout) if "--format json" in arguments else None

    def rsrs_once(self, folder, file, arguments):
        """What a command reports as JSON, kept in a file."""
        file = folder / file
        if not file.exists():
            file.write_text(json.dumps(self.rsrs(folder, arguments)))
        return json.loads(file.read_text())


def measure(programs, floor, folder):
    """Trials of five robots, and the profile that is fitted to them."""
    import measuring

    if (folder / "profile.yaml").exists():
        return
    # What an interrupted call left.
    shutil.rmtree(folder / "trials", ignore_errors=True)
    programs.rsrs(
        folder,
        f"measure plan --quiet --robots {MEASURED_ROBOTS} --speed 0.05,0.25 --commands 3 --track 1 --precision 0.05 "
        f"--distances 8 --bearings 7 --rate-precision 0.1 -o trials {PLANS[floor.name]}",
    )
    measuring.fill_in(floor, folder / "trials")
    others = range(MEASURED_ROBOTS + 1, max(ROBOTS[floor.name]) + 1)
    measuring.drive_alone(floor, others, 15.0, folder / "alone.csv")
    programs.rsrs(
        folder,
        "measure fit --quiet --plan trials --trajectories trials/drives.csv "
        f"--contact {floor.contact} --radius {floor.radius_m} --name {floor.name} -o profile.yaml",
    )


def predict(programs, floor, folder):
    """The cells, each with what is predicted of it; and whether single robots stay within reach."""
    axes = ", ".join(
        f"{axis}: [{', '.join(map(str, values))}]"
        for axis, values in {"robots": ROBOTS[floor.name], **AXES}.items()
    )
    (folder / "sweep.yaml").write_text(
        f"profile: profile.yaml\naxes: {{{axes}}}\nfixed: {{arena_m: 15, walls: none}}\n"
        f"replicates: {number('REPLICATES', 400)}\nduration_s: {DURATION_S:g}\nseed: 1\n"
    )
    programs.rsrs(folder, "sweep sweep.yaml --quiet -o swept")
    profiles = number("PROFILES", 200)
    pseudo = programs.rsrs_once(
        folder,
        "choice.json",
        f"choose swept --quiet --confirm 100 --pseudo-realities {profiles} --widening {WIDENING} --format json",
    )["pseudo_realities"]
    validation = programs.rsrs_once(
        folder, "validation.json", "validate swept --trajectories alone.csv --robots 500 --quiet --format json"
    )
    with open(folder / "swept/cells.csv") as table:
        swept = list(csv.DictReader(table))
    cells = []
    for row, drawn in zip(swept, pseudo["cells"], strict=True):
        cells.append(
            {
                **{axis: float(row[axis]) for axis in ("robots", *AXES)},
                "as_measured": float(row["as_measured_b_s"]),
                "harsher": float(row["b_s"]),
                "pseudo_mean": drawn["mean"],
                "pseudo_worst_tenth": drawn["worst_tenth"],
            }
        )
    return cells, {
        "n_simulated": int(swept[0]["n"]),
        "n_profiles": pseudo["n_profiles"],
        "n_runs_of_each": pseudo["n_replicates"],
        "widening": pseudo["widening"],
        "n_drives": validation["n_trials"],
        "n_drives_within_reach": validation["n_inside"],
        "p_value": validation["p_value"],
    }


def cells_of(floor):
    """Robots, radius of the disc in metres, speed in m/s and turning rate in rad/s, in the order of the sweep."""
    is_run = RUN.get(floor, lambda *_: True)
    cells = [cell for cell in itertools.product(ROBOTS[floor], *AXES.values()) if is_run(*cell)]
    return cells[:: max(1, len(cells) // number("CELLS", len(cells)))]


def run(floor, folder):
    """All runs on a floor, each in a file of its own; what is there is not run again."""
    import numpy as np
    from floor import Controller, seeded, starts

    (folder / "runs").mkdir(exist_ok=True)
    for repetition in range(number("RUNS", RUNS[floor.name])):
        for place, cell in enumerate(cells_of(floor.name)):
            file = folder / f"runs/{place}_{repetition}.npz"
            if file.exists():
                continue
            robots, disc_m, speed_m_s, rate_rad_s = cell
            seed = 1_000_000 + 1000 * place + repetition
            placed = starts(robots, disc_m, floor.radius_m, seeded(floor.name, "starts", seed))
            controller = Controller.of_cell(speed_m_s, rate_rad_s)
            found = floor.drive(range(1, robots + 1), placed, controller, DURATION_S, seed)
            part = file.with_suffix(".part.npz")
            np.savez_compressed(
                part, period_s=found.period_s, poses=np.float32(found.poses), commands=np.float32(found.commands)
            )
            part.rename(file)


def judge(programs, folder):
    """The phase of every run, by cell, in the order of the runs."""
    import numpy as np

    phases = {}
    with subprocess.Popen(
        [programs.floors, "judge", "swept"], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as program:
        for file in sorted(folder.glob("runs/*_*.npz"), key=lambda file: [*map(int, file.stem.split("_"))]):
            found = np.load(file)
            recorded = {
                "period_s": float(found["period_s"]),
                "poses": found["poses"].round(5).tolist(),
                "commands": found["commands"].round(5).tolist(),
            }
            print(json.dumps(recorded), file=program.stdin, flush=True)
            phase = json.loads(program.stdout.readline())["phase"]
            phases.setdefault(int(file.stem.split("_")[0]), []).append(phase)
    return phases


def compare(programs, name, folder):
    """All numbers of one floor."""
    module = importlib.import_module(f"{name}_floor" if name != "rays" else "ray_floor")
    floor = module.Floor(programs.floors) if name == "rays" else module.Floor()
    folder.mkdir(parents=True, exist_ok=True)
    measure(programs, floor, folder)
    predicted, facts = predict(programs, floor, folder)
    run(floor, folder)
    phases = judge(programs, folder)
    cells = []
    for place, cell in enumerate(cells_of(name)):
        found = next(it for it in predicted if [it[axis] for axis in ("robots", *AXES)] == list(map(float, cell)))
        n_mills = phases[place].count("stable_milling")
        cells.append({**found, "n_runs": len(phases[place]), "n_mills": n_mills})
    return {"name": name, **facts, "duration_s": DURATION_S, "cells": cells}


def main():
    if sys.argv[1:2] == ["--tables"] and len(sys.argv) == 3:
        print(evaluation.tables(json.loads(Path(sys.argv[2]).read_text())))
        return
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    folder = Path(sys.argv[1]).resolve()
    programs = Programs()
    names = sys.argv[2:] or FLOORS
    if unknown := set(names) - set(FLOORS):
        sys.exit(f"no floor is called {', '.join(sorted(unknown))}; there are {', '.join(FLOORS)}")
    results = {"machine": machine(), "floors": [compare(programs, name, folder / name) for name in names]}
    (folder / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    print(evaluation.tables(results))
    evaluation.draw(results, folder / "floors.png")


def machine():
    """What the processor is called, and how many there are."""
    with open("/proc/cpuinfo") as file:
        name = next(line.split(":")[1].strip() for line in file if line.startswith("model name"))
    return f"{os.cpu_count()} cores of {name}, {platform.system()}"


if __name__ == "__main__":
    main()
