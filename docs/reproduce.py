"""Reproduces the paper's case study: writes REPRODUCTION.md and its pictures.

    python3 docs/reproduce.py [FOLDER]

FOLDER is docs by default. The commands of rsrs run as a person runs them; the robots of step 4 are
the stand-in of crates/rsrs/examples/floor. REPRODUCTION.template.md is the text, into which every
number of this run is filled. PROFILE=dev builds without optimising the command line.
"""

import csv
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TEMPLATE = ROOT / "docs/REPRODUCTION.template.md"
PHASES = {
    key: key.replace("semi_", "semi-").replace("_", " ")
    for key in ("stable_milling", "semi_stable_milling", "unformed", "dispersion", "colliding_unstable")
}
REPLICATES = 100
N_SEEDS = 10

PLANE = (
    "{speed_m_s: {from: 0.05, to: 0.30, steps: 11}, turn_rate_rad_s: {from: 0.25, to: 2.0, steps: 8}}"
)
USUAL = {"robots": 9, "placement_radius_m": 0.825, "arena_m": 15}
FIXED = {"speed_m_s": 0.15, "turn_rate_rad_s": 0.75, **USUAL}
VARIED = {
    "robots": [3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 14],
    "range_m": [0.30, 0.45, 0.60, 0.75, 0.90, 1.20],
    "true_positive": [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0],
    "false_positive": [0, 0.04, 0.08, 0.12, 0.16, 0.20, 0.30],
    "heterogeneity": [0, 0.02, 0.05, 0.10, 0.15, 0.20],
    "placement_radius_m": [0.40, 0.60, 0.825, 1.2, 1.6, 2.5],
}
# Robots of the paper that could not mill: where a mill is searched, and the factors of their fault.
HOPELESS = {
    "smars": (
        "{speed_m_s: {from: 0.05, to: 0.15, steps: 5}, turn_rate_rad_s: {from: 0.5, to: 1.0, steps: 3}}",
        15,
        {"miss_factor", "false_positive_factor", "polygon_scale"},
    ),
    "lta": (
        "{speed_m_s: {from: 0.2, to: 0.4, steps: 5}, turn_rate_rad_s: {from: 0.3, to: 0.6, steps: 3}}",
        60,
        {"gust_factor", "drift_factor"},
    ),
}
# Each agreement whose reason stands in the template; another outcome needs another reason.
EXPLAINED = {"reach": "**no**", "placement": "in part", "smars": "in part", "lta": "yes", "gap": "yes"}


class Program:
    """The binaries, and the folder in which they run."""

    def __init__(self, folder):
        profile = os.environ.get("PROFILE", "release")
        subprocess.run(
            ["cargo", "build", "--profile", profile, "-p", "rsrs", "--bin", "rsrs", "--example", "floor"],
            cwd=ROOT,
            check=True,
        )
        target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
        self.binaries = target / ("debug" if profile == "dev" else profile)
        self.folder = folder

    def floor(self):
        subprocess.run([self.binaries / "examples/floor", "."], cwd=self.folder, check=True)
        return json.loads((self.folder / "floor.json").read_text())

    def rsrs(self, arguments):
        """What a command reports as JSON."""
        command = [self.binaries / "rsrs", *arguments.split()]
        done = subprocess.run(command, cwd=self.folder, stdout=subprocess.PIPE)
        if done.returncode not in (0, 3):  # 3: done, and the answer is negative.
            sys.exit(f"rsrs {arguments} ended with {done.returncode}")
        return json.loads(done.stdout) if "--format json" in arguments else None

    def sweep(self, name, axes=PLANE, profile="flockbot", fixed=None, duration_s=300, seed=1):
        """The cells of a sweep, as dictionaries of texts."""
        settings = ", ".join(f"{key}: {value}" for key, value in (fixed or USUAL).items())
        (self.folder / f"{name}.yaml").write_text(
            f"profile: launch_configs/profiles/{profile}.yaml\nharsher: {{}}\naxes: {axes}\n"
            f"fixed: {{{settings}, walls: stop}}\nreplicates: {REPLICATES}\n"
            f"duration_s: {duration_s}\nseed: {seed}\n"
        )
        self.rsrs(f"sweep {name}.yaml -o {name}")
        with open(self.folder / name / "cells.csv") as table:
            return list(csv.DictReader(table))


def share(cell, phase="stable_milling"):
    return int(cell[phase]) / int(cell["n"])


def n_of(plane, phase):
    """Cells in which this phase is the most frequent one."""
    return sum(cell["phase"] == phase for cell in plane)


def find(plane, **values):
    is_it = lambda cell: all(abs(float(cell[axis]) - value) < 1e-9 for axis, value in values.items())
    return next(filter(is_it, plane))


def agreement(is_so, is_in_part=False):
    return "yes" if is_so else "in part" if is_in_part else "**no**"


def hopeless(program, name):
    """The search for a cell in which such robots mill, made worse."""
    axes, arena_m, of_fault = HOPELESS[name]
    cells, answers = [], {}
    for robots in (4, 6, 9, 12):
        fixed = {"robots": robots, "arena_m": arena_m}
        swept = program.sweep(f"{name}_{robots}", axes, name, fixed)
        cells += [(robots, cell) for cell in swept]
        answers[robots] = program.rsrs(f"choose {name}_{robots} --format json")
    # The first of equals, as `rsrs choose` has it.
    robots, best = max(cells, key=lambda it: (share(it[1]), float(it[1]["as_measured_b_s"])))
    measured = float(best["as_measured_b_s"])
    effects = answers[robots]["factors"]["factors"]
    leaves_half = lambda effect: effect["b_s_alone"] >= measured / 2
    does_it = any(map(leaves_half, effects)) and any(
        effect["factor"] in of_fault and not leaves_half(effect) for effect in effects
    )
    is_viable = any("reason" not in answer for answer in answers.values())
    return {
        "robots": robots,
        "cell": f"speed_m_s={best['speed_m_s']},turn_rate_rad_s={best['turn_rate_rad_s']}",
        "n_cells": len(cells),
        "b_s": share(best),
        "measured": measured,
        "finds": "finds" if is_viable else "does not find",
        "answer": "a viable cell" if is_viable else "no viable cell",
        "reason": answers[robots].get("reason", ""),
        "factors": ", ".join(
            f"`{it['factor']}` {it['b_s_alone']:.2f} alone and {it['b_s_without']:.2f} without it"
            for it in effects
        ),
        "agrees": agreement(not is_viable and measured >= 0.5 and does_it, not is_viable),
    }


def rows(cells):
    line = (
        "| {speed_m_s:.2f} | {turn_rate_rad_s:.2f} | {simulated} | {b_s:.2f} | {phase} | {beside} "
        "| {b_r:.2f} | {verdict} |"
    )
    named = lambda cell: {key: PHASES.get(value, value) for key, value in cell.items()}
    return "\n".join(line.format(**named(cell)) for cell in cells)


def find_all(program):
    """All numbers of the template, by their names in it."""
    plane = program.sweep("plane")
    long = program.sweep("long", duration_s=900)
    group = program.sweep("group", profile="flockbot_group_sensor")
    choice = program.rsrs("choose plane -o plane/choice.json --format json")
    floor = program.floor()
    validation = program.rsrs("validate plane --trajectories alone.csv --format json")
    repeated = floor["repeated"]
    bags = [f"experiment_{number + 1}" for number in range(len(repeated["cells"]))]
    labels = program.rsrs(f"label {' '.join(bags)} --format json")
    assert [label["phase"] for label in labels] == [cell["phase"] for cell in repeated["cells"]]
    comparison = program.rsrs(f"compare plane --format json --bags {' '.join(bags)}")

    chosen = []
    for seed in range(1, N_SEEDS + 1):
        program.sweep(f"seed_{seed}", seed=seed)
        chosen.append(program.rsrs(f"choose seed_{seed} --format json")["cell"])
    recommended = [(it["speed_m_s"], it["turn_rate_rad_s"]) for it in chosen if it]
    n_papers = sum(abs(v - 0.15) < 1e-9 and abs(w - 0.75) < 1e-9 for v, w in recommended)

    varied = {}
    for axis, values in VARIED.items():
        others = {key: value for key, value in FIXED.items() if key != axis}
        varied[axis] = program.sweep(axis, f"{{{axis}: {values}}}", fixed=others)
    placed = [find(varied["placement_radius_m"], placement_radius_m=r) for r in (0.4, 0.825, 2.5)]
    near, usual, far = placed
    of_robots = {n: share(find(varied["robots"], robots=n)) for n in (4, 6, 9, 12)}
    collides = lambda cell: share(cell, "colliding_unstable")
    is_lost = share(far) < 0.5 * share(usual)

    shares = {axis: [f"{share(cell):.2f}" for cell in cells] for axis, cells in varied.items()}

    majorities = {phase: n_of(plane, phase) for phase in PHASES}
    n, n_group = majorities["stable_milling"], n_of(group, "stable_milling")
    tally, tallies = comparison["tally"], repeated["tallies"]
    mean = lambda kind: sum(it[kind] for it in tallies) / len(tallies)
    robots = {name: hopeless(program, name) for name in HOPELESS}
    found_gains = [f"{gain:.2f}" for gain in floor["gains"]]
    violated = [cell for cell in repeated["cells"] if cell["verdict"] == "violated"]
    p_value, shortfall = validation["p_value"], comparison["pooled"]["shortfall_at_most"]
    agrees = {
        "gains": agreement(found_gains == ["0.89", "0.86", "0.89", "0.97", "0.97", "0.97"]),
        "reach": agreement(validation["is_contained"]),
        "some": agreement(0 < n < len(plane) and n_group < len(plane), 0 < n < len(plane)),
        "recommended": agreement(n_papers == N_SEEDS, True),
        "first": agreement(repeated["cells"][0]["phase"] == "stable_milling"),
        "tally": agreement(tally["harder"] == 0 < tally["easier"], tally["harder"] <= tally["easier"]),
        "gap": agreement(not violated, True),
        "placement": agreement(is_lost and collides(near) > collides(usual), is_lost),
        "more": agreement(of_robots[12] < of_robots[9]),
        "collide": agreement(floor["collisions"]["n"] == floor["collisions"]["n_colliding"], True),
        **{name: robot["agrees"] for name, robot in robots.items()},
    }
    for name, explained in EXPLAINED.items():
        if agrees[name] != explained:
            print(f"{name}: {agrees[name]}, and the template gives reasons for {explained}")
    return {
        "grip_percent": 100 * floor["faults"]["grip"],
        "jitter_ms": 1000 * floor["faults"]["jitter_s"],
        "floor": floor,
        "gains": ", ".join(found_gains),
        "agrees": agrees,
        "validation": validation,
        "p_value": "below 0.001" if p_value < 0.001 else f"= {p_value:.3f}",
        "n_cells": len(plane),
        "n_milling": n,
        "n_milling_group": n_group,
        "majorities": ", ".join(f"{n} {PHASES[phase]}" for phase, n in majorities.items() if n),
        "n": majorities,
        "n_dispersing_long": n_of(long, "dispersion"),
        "n_dispersing_group": n_of(group, "dispersion"),
        "unformed_percent": 100 * sum(share(cell, "unformed") for cell in plane) / len(plane),
        "n_recommended": len(recommended),
        "n_papers": n_papers,
        "recommended": ", ".join(sorted({f"({v:g} m/s, {w:g} rad/s)" for v, w in recommended})),
        "b_s_papers": share(find(plane, speed_m_s=0.15, turn_rate_rad_s=0.75)),
        "first": PHASES[repeated["cells"][0]["phase"]],
        "first_mills": repeated["cells"][0]["n_mills"],
        "mean": {kind: mean(kind) for kind in ("same", "easier", "harder")},
        "n_none_harder": sum(it["harder"] == 0 for it in tallies),
        "n_as_paper": sum(it == {"same": 5, "easier": 4, "harder": 0} for it in tallies),
        "n_violated": len(violated) or "none",
        "n_runs": repeated["n"] * len(repeated["cells"]),
        "experiments": rows(repeated["cells"]),
        "repeated": repeated,
        "comparison": comparison,
        "shortfall_percent": 100 if shortfall is None else 100 * shortfall,
        "n_claimed": repeated["pooled"]["n_cells_claimed"],
        "b_r_at_least": repeated["pooled"]["b_r_at_least"] or 0,
        "placed": {"near": share(near), "usual": share(usual), "far": share(far)},
        "collide_percent": {"near": 100 * collides(near), "usual": 100 * collides(usual)},
        "robots": {f"of_{n}": value for n, value in of_robots.items()},
        "choice": choice,
        "choice_percent": {key: 100 * choice[key] for key in ("b_s", "b_s_low", "b_s_high")},
        "varied": {axis: " | ".join(row) for axis, row in shares.items()},
        **robots,
    }


def main():
    docs = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs"
    pictures = docs / "reproduction"
    pictures.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        work = Path(work)
        shutil.copytree(ROOT / "launch_configs/profiles", work / "launch_configs/profiles")
        text = TEMPLATE.read_text().format(**find_all(Program(work)))
        (docs / "REPRODUCTION.md").write_text(text)
        for name in ("diagram.png", "mill.png"):
            shutil.copy(work / name, pictures / name)


if __name__ == "__main__":
    main()
