"""Controllers that `rsrs explore` finds for robots as they were measured, and for ideal ones, on a floor in MuJoCo.

    python docs/floors/discovery.py FOLDER

FOLDER is made, or gone on with; `discovery.json` in it has all numbers, and `discovery.png` the runs. For a test,
SEARCHES and CONTROLLERS state how many searches a world gets at most and how many controllers each of them tries, FINDS
how many controllers of each world are deployed, and ATTEMPTS how often at most. BINARIES names a folder with `rsrs` and
`examples/floors`; without it, both are built.

    python docs/floors/discovery.py --tables docs/floors/discovery.json

prints the tables of docs/discovery.md, that of `wall.json` beside the file included.

What is deployed is chosen by a rule that was fixed before anything was: see `chosen`.
"""

import csv
import itertools
import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

import deployment
import wall
from compare import Programs, machine, number

# The floor of Mattson et al. (AAMAS 2025), as far as we know it: arXiv 2502.15937.
ROBOTS = 8
RECTANGLE_M = (1.70, 1.42)
COLUMNS, ROWS = 4, 3
FASTEST_M_S, FASTEST_RAD_S = 0.09, 1.6
# 60 s as there, and then the 60 s that are judged.
DURATION_S = 120.0
# Finds that are deployed, as many as there.
WORLDS = {"calibrated": 30, "ideal": 18}
ATTEMPTS = 3
# At most so many searches of a world, each of so many controllers.
SEARCHES, CONTROLLERS = 8, 256
EXPLAINED_RUNS = 100
# What is deployed: all names of `rsrs explore` but that of runs without order, and of those without a name.
CLASSES = ("milling", "aggregation", "dispersal", "wall_following", "rotating_crowd")
# Of what `rsrs explore` reports of a find.
KEPT = ("name", "seed", "number", "controller", "share", "share_as_measured", "needs_contact")
# What somebody would write who measures nothing: a line of sight, and robots that do what they are commanded.
IDEAL = """\
name: ideal
body: {radius_m: RADIUS, front_half_angle_rad: 1.2217, rotates_while_blocked: true, contact: push}
actuation:
  speed: {limits_m_s: [0.02, 0.09], gain_by_command: [{commanded_m_s: 0.09, mean: 1}], robot_sd: 0, step_sd: 0}
  turn: {limits_rad_s: [0.2, 1.6], gain_by_command: [{commanded_rad_s: 1.6, mean: 1}], robot_sd: 0, step_sd: 0,
         bias_sd_rad_s: 0, heading_noise_sd_rad: 0}
  gust: {sd_m_s: 0, time_constant_s: 1}
  yaw_lag_s: 0
sensing: {sees: body, cone: {half_angle_rad: 0, range_m: 2}, true_positive: 1, false_positive: 0, latency_steps: 0}
computation: {period_s: 0.1}
provenance: {source: "nominal numbers, nothing was measured"}
"""


def floor(rectangle_m=None):
    """The robots of docs/floors/mujoco_floor.py with a sensor that looks straight ahead and 2 m far."""
    import mujoco_floor

    mujoco_floor.physics.CAMERA_HALF_ANGLE_RAD, mujoco_floor.physics.COLUMNS = 0.1, 7
    mujoco_floor.physics.CAMERA_RANGE_M, mujoco_floor.physics.CAMERA_RANGE_SD_M = 2.0, 0.08
    mujoco_floor.physics.CAMERA_FARTHEST_M = 3.0
    made = mujoco_floor.Floor()
    made.rectangle_m = rectangle_m
    return made


def starts(draws):
    """Robots on as many cells of a grid over the arena, each in the middle of its own, heading anywhere."""
    import math

    cells = draws.sample(list(itertools.product(range(COLUMNS), range(ROWS))), ROBOTS)
    width_m, height_m = RECTANGLE_M[0] / COLUMNS, RECTANGLE_M[1] / ROWS
    return [
        (
            (column + 0.5) * width_m - RECTANGLE_M[0] / 2,
            (row + 0.5) * height_m - RECTANGLE_M[1] / 2,
            math.tau * draws.random() - math.pi,
        )
        for column, row in cells
    ]


def measure(programs, folder):
    """Trials of five of the robots where there are no walls, and the profile that is fitted to them."""
    import shutil

    import measuring

    if (folder / "calibrated.yaml").exists():
        return
    # What an interrupted call left.
    shutil.rmtree(folder / "trials", ignore_errors=True)
    robots = floor()
    programs.rsrs(
        folder,
        f"measure plan --quiet --robots 5 --speed 0.02,{FASTEST_M_S} --turn-rate 0.2,{FASTEST_RAD_S} --commands 3 "
        "--track 0.5 --precision 0.05 --range 2 --half-angle 0.1 --radius 0.07 --period 0.1 --distances 8 "
        "--bearings 7 --rate-precision 0.1 -o trials",
    )
    measuring.fill_in(robots, folder / "trials")
    programs.rsrs(
        folder,
        "measure fit --quiet --plan trials --trajectories trials/drives.csv "
        f"--contact {robots.contact} --radius {robots.radius_m} --name mujoco -o calibrated.yaml",
    )


def search(programs, folder):
    """The finds of all searches, by world: each with the seed of its search.

    A world is searched, with seeds 1, 2 and so on, until it has as many finds as are deployed.
    """
    width_m, height_m = RECTANGLE_M
    (folder / "arena.yaml").write_text(f"arena: {{rectangle_m: [{width_m}, {height_m}]}}\n")
    (folder / "ideal.yaml").write_text(IDEAL.replace("RADIUS", str(floor().radius_m)))
    found = {world: [] for world in WORLDS}
    for seed, world in itertools.product(range(1, number("SEARCHES", SEARCHES) + 1), WORLDS):
        if len(chosen(found[world], n_deployed(world))) == n_deployed(world):
            continue
        explored = programs.rsrs_once(
            folder,
            f"{world}_{seed}.json",
            f"explore {world}.yaml -o {world}_{seed} --robots {ROBOTS} --world-file arena.yaml "
            f"--controllers {number('CONTROLLERS', CONTROLLERS)} --duration {DURATION_S:g} --seed {seed} --quiet "
            "--format json",
        )
        found[world] += [{"seed": seed, **find} for find in explored["found"]]
    return found


def n_deployed(world):
    return number("FINDS", WORLDS[world])


def chosen(found, n):
    """Which finds of a world are deployed.

    Finds have the names of `CLASSES`. Of each name they come in the order of their searches' seeds, and within a
    search in that of its gallery, the surest first. One of each name is taken in turn, in the order of `CLASSES`,
    until there are `n` or none is left.
    """
    queues = [[find for find in found if find["name"] == name] for name in CLASSES]
    rounds = itertools.zip_longest(*queues)
    return [find for find in itertools.chain.from_iterable(rounds) if find is not None][:n]


def deploy(programs, folder, world, finds):
    """What each attempt of each find shows, by the names of the searches of its world.

    All finds are tried once, and then those that have not worked yet, until there are no more attempts.
    """
    attempts = [[] for _ in finds]
    (folder / "runs").mkdir(exist_ok=True)
    judge = [programs.floors, "call", f"{world}_1"]
    with subprocess.Popen(judge, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as program:
        for attempt in range(number("ATTEMPTS", ATTEMPTS)):
            for find, before in zip(finds, attempts):
                if any(it["shows"] for it in before):
                    continue
                file = run_file(folder, world, find, attempt)
                if not file.exists():
                    run(find, file)
                print(recording(file), file=program.stdin, flush=True)
                seen = json.loads(program.stdout.readline())
                names, blocked = seen["names"], seen["order_parameters"]["blocked"]
                before.append({"shows": find["name"] in names, "names": names, "blocked": round(blocked, 3)})
    return attempts


def run(find, file):
    """One attempt on the floor, from starts of its own."""
    import numpy as np
    from floor import Controller, seeded

    controller = find["controller"]
    unseen = controller["undetected"]
    commands = Controller(*((it["speed_m_s"], it["turn_rate_rad_s"]) for it in (unseen, controller)))
    placed = starts(seeded("starts on the floor", file.stem))
    driven = floor(RECTANGLE_M).drive(range(1, ROBOTS + 1), placed, commands, DURATION_S, file.stem)
    part = file.with_suffix(".part.npz")
    np.savez_compressed(part, poses=np.float32(driven.poses), commands=np.float32(driven.commands))
    part.rename(file)


def recording(file):
    """A run as the judge takes it."""
    import numpy as np

    driven = np.load(file)
    return json.dumps({"period_s": 0.1, **{key: driven[key].round(5).tolist() for key in ("poses", "commands")}})


def run_file(folder, world, find, attempt):
    """Named after the search, and after the number of the controller in it; what is there is not run again."""
    return folder / f"runs/{world}_{find['seed']}_{find['number']}_{attempt}.npz"


def explain(programs, folder, world, find):
    """How often simulated robots as in the profile show a behaviour where they start as on the floor.

    This was added when runs on the floor had been seen.
    """
    from floor import seeded

    if find["name"] not in ("milling", "aggregation"):
        return {}
    lines = ["replicate,x_m,y_m,heading_rad"]
    draws = seeded("starts of simulated robots")
    for replicate in range(EXPLAINED_RUNS):
        lines += [f"{replicate},{x:.4f},{y:.4f},{heading:.4f}" for x, y, heading in starts(draws)]
    (folder / "starts.csv").write_text("\n".join(lines) + "\n")
    controller = find["controller"]
    fixed = {f"undetected_{key}": value for key, value in controller["undetected"].items()}
    fixed |= {"turn_rate_rad_s": controller["turn_rate_rad_s"], "robots": ROBOTS, "walls": "stop"}
    name = f"explained/{world}_{find['seed']}_{find['number']}"
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / f"{name}.yaml").write_text(
        f"profile: ../{world}.yaml\nharsher: none\nbehaviour: {find['name']}\nworld: ../arena.yaml\n"
        f"axes: {{speed_m_s: [{controller['speed_m_s']}]}}\nfixed: {json.dumps(fixed)}\n"
        f"placement: {{kind: file, path: ../starts.csv}}\n"
        f"replicates: {EXPLAINED_RUNS}\nduration_s: {DURATION_S:g}\nseed: 1\n"
    )
    programs.rsrs(folder, f"sweep {name}.yaml --quiet -o {name}")
    with open(folder / name / "cells.csv") as table:
        return {"share_on_grid": float(next(csv.DictReader(table))["b_s"])}


def discover(programs, folder):
    """All numbers."""
    measure(programs, folder)
    found = search(programs, folder)
    results = {"machine": machine(), "n_attempts": number("ATTEMPTS", ATTEMPTS), "worlds": {}}
    for world in WORLDS:
        finds = chosen(found[world], n_deployed(world))
        attempts = deploy(programs, folder, world, finds)
        results["worlds"][world] = {
            "n_searches": max(it["seed"] for it in found[world]),
            "n_controllers": number("CONTROLLERS", CONTROLLERS),
            "n_found": {name: count for name, count in Counter(it["name"] for it in found[world]).items()},
            "finds": [
                {
                    **{key: it[key] for key in KEPT},
                    "blocked": round(it["order_parameters"]["blocked"], 3),
                    **explain(programs, folder, world, it),
                    "attempts": each,
                }
                for it, each in zip(finds, attempts)
            ],
        }
    return results


def main():
    if sys.argv[1:2] == ["--tables"] and len(sys.argv) == 3:
        file = Path(sys.argv[2])
        trials = json.loads(file.with_name("wall.json").read_text())
        print(deployment.tables(json.loads(file.read_text())), wall.tables(trials), sep="\n\n")
        return
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    folder = Path(sys.argv[1]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    results = discover(Programs(), folder)
    (folder / "discovery.json").write_text(json.dumps(results, indent=1) + "\n")
    print(deployment.tables(results))
    files = lambda *run: run_file(folder, *run)
    deployment.draw(results, files, RECTANGLE_M, folder / "discovery.png")
    deployment.film(results, files, RECTANGLE_M, folder / "discovery.gif")


if __name__ == "__main__":
    main()
