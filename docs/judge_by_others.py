"""Judges controllers that others have labelled by eye, as they move in those others' own simulator.

Connor-Mattson/RobotSwarmSimulator has 124 genomes in `data/diffdrivegenomes`, each labelled with one of the six
classes of D. S. Brown et al. (DARS 2018). Every one runs twice, with 30 robots, in the simulator of that repository
(`novel_swarms`), and `rsrs.judge` labels what their robots did for aggregation and for dispersal:

    git clone https://github.com/Connor-Mattson/RobotSwarmSimulator
    pip install novel-swarms==0.1.9a0 pygame-ce numpy matplotlib rsrs
    python3 docs/judge_by_others.py RobotSwarmSimulator/data/diffdrivegenomes runs

`runs` keeps the trajectories, which take hours of one core; `docs/judge_by_others.csv` and two pictures are written
anew from them in a minute.
"""

import csv
import os
import sys
from collections import Counter
from pathlib import Path

import matplotlib
import numpy as np
import rsrs

matplotlib.use("agg")
os.environ["SDL_VIDEODRIVER"] = "dummy"

import matplotlib.pyplot as plt
from matplotlib.patches import Circle
from novel_swarms.config.AgentConfig import DiffDriveAgentConfig
from novel_swarms.config.WorldConfig import RectangularWorldConfig
from novel_swarms.sensors.BinaryLOSSensor import BinaryLOSSensor
from novel_swarms.sensors.SensorSet import SensorSet
from novel_swarms.world.RectangularWorld import RectangularWorld

HERE = Path(__file__).parent
LABELS = ["aggregation", "dispersal", "cyclic", "milling", "wall-following", "random"]
RUNS = (1, 2)
# A unit of theirs is a centimetre, and a tick 0.1 s, as in `docs/atlas/brown_classes`.
UNIT_M, PERIOD_S, RADIUS_M = 0.01, 0.1, 0.05
TICKS, TICKS_LONG = 1200, 3600
# Their robots see without end, so how near a neighbour must be is ours to say.
REACHES_M = (0.2, 0.3, 0.4, 0.5, 0.75)
SHOWN_REACH_M = 0.3


def genomes(folder: Path, label: str) -> list[list[float]]:
    """The wheels' speeds, left and right, without and with a robot in sight."""
    with open(folder / f"{label}.csv") as file:
        return [[float(value) for value in row if value.strip()] for row in csv.reader(file) if row]


def simulate(genome: list[float], seed: int, ticks: int) -> np.ndarray:
    """Poses in their units and radians; shape [ticks, 30, 3]."""
    agent = DiffDriveAgentConfig(controller=genome, sensors=SensorSet([BinaryLOSSensor(angle=0)]), seed=seed)
    world = RectangularWorld(
        RectangularWorldConfig(size=(500, 500), n_agents=30, seed=seed, behavior=[], agentConfig=agent, padding=15)
    )
    poses = np.empty((ticks, 30, 3), dtype="f4")
    for tick in range(ticks):
        world.step()
        poses[tick] = [(agent.x_pos, agent.y_pos, agent.angle) for agent in world.population]
    return poses


def trajectory(folder: Path, kept: Path, label: str, row: int, run: int, ticks: int) -> np.ndarray:
    """Poses in metres and radians, simulated if nobody has yet."""
    path = kept / f"{label}_{row:02}_{run}_{ticks}.npy"
    if not path.exists():
        np.save(path, simulate(genomes(folder, label)[row], run, ticks))
    poses = np.load(path).astype("f8")
    poses[:, :, :2] *= UNIT_M
    return poses


def sheet(path: Path, panels: list[tuple[str, np.ndarray]]) -> None:
    """Draws where robots end, and where they were in the last 10 s."""
    columns = 6
    rows = -(-len(panels) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(2.0 * columns, 2.2 * rows), squeeze=False)
    for axis in axes.flat:
        axis.set_axis_off()
    for axis, (title, poses) in zip(axes.flat, panels):
        axis.set_title(title, fontsize=7)
        axis.plot(poses[-100:, :, 0], poses[-100:, :, 1], color="0.75", linewidth=0.6)
        for x_m, y_m, _ in poses[-1]:
            axis.add_patch(Circle((x_m, y_m), RADIUS_M, color="#1f5a94"))
        axis.add_patch(plt.Rectangle((0.15, 0.15), 4.7, 4.7, fill=False, linewidth=0.5, color="0.4"))
        axis.set_aspect("equal")
        axis.set_xlim(0, 5)
        axis.set_ylim(0, 5)
    figure.tight_layout()
    figure.savefig(path, dpi=90)
    plt.close(figure)


def main() -> None:
    folder, kept = map(Path, sys.argv[1:3])
    kept.mkdir(parents=True, exist_ok=True)
    found, missed = [], {"aggregation": [], "dispersal": []}
    for label in LABELS:
        for row in range(len(genomes(folder, label))):
            for run in RUNS:
                for ticks in (TICKS, TICKS_LONG) if label == "aggregation" else (TICKS,):
                    poses = trajectory(folder, kept, label, row, run, ticks)
                    asked = [("aggregation", REACHES_M[-1])]
                    if ticks == TICKS:
                        asked += [("dispersal", reach_m) for reach_m in REACHES_M]
                    for behaviour, reach_m in asked:
                        verdict = rsrs.judge(
                            poses, period_s=PERIOD_S, radius_m=RADIUS_M, reach_m=reach_m, behaviour=behaviour
                        )
                        share = verdict.order["clustered" if behaviour == "aggregation" else "lost"]
                        found.append((label, row, run, ticks, behaviour, reach_m, verdict.phase, f"{share:.2f}"))
                        is_shown = (ticks, reach_m) in [(TICKS_LONG, REACHES_M[-1]), (TICKS, SHOWN_REACH_M)]
                        if label == behaviour and is_shown and not verdict.is_wanted:
                            words = "in one cluster" if behaviour == "aggregation" else "alone"
                            missed[behaviour].append((f"row {row}, run {run}\n{share:.0%} {words}", poses))
    with open(HERE / "judge_by_others.csv", "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["label", "row", "run", "ticks", "behaviour", "reach_m", "phase", "share"])
        table.writerows(found)
    for behaviour, panels in missed.items():
        if panels:
            sheet(HERE / f"judge_by_others_{behaviour}.png", panels)
    for (label, ticks, behaviour, reach_m, phase), n in sorted(
        Counter((label, ticks, behaviour, reach_m, phase) for label, _, _, ticks, behaviour, reach_m, phase, _ in found).items()
    ):
        print(f"{n:3} runs of {label}, {ticks} ticks, as {behaviour} at {reach_m} m: {phase}")


if __name__ == "__main__":
    main()
