"""Whether robots in MuJoCo that push a puck stay within the reach of simulated robots that push one.

    python docs/floors/pushing.py FOLDER

FOLDER is made, or gone on with; it gets the measured profile, drives with pucks as tables, and `pushing.json`, which
has all numbers. BINARIES names a folder with `rsrs`; without it, it is built.

    python docs/floors/pushing.py --tables docs/floors/pushing.json

prints the table again. Five robots are measured as in compare.py, and push each puck straight ahead, which shows how
heavy it is: robots of speed v that push it at u have `weight` v / u - 1. Seven others then meet it in its middle, and
off it.
"""

import csv
import itertools
import json
import math
import sys
from pathlib import Path

# In kg. A puck is a disc as wide as a robot, which slides on the floor. Of two bodies that touch, MuJoCo takes the
# friction of that with priority.
PUCKS_KG = {"light": 0.3, "heavy": 0.55}
RADIUS_M, HEIGHT_M, FRICTION = 0.07, 0.06, 0.3
PUCK = f"""
<body name="puck" pos="0 0 {HEIGHT_M / 2}">
  <freejoint name="puck"/>
  <geom type="cylinder" size="{RADIUS_M} {HEIGHT_M / 2}" mass="{{kg}}" friction="{FRICTION}" priority="2"
        contype="3" conaffinity="3"/>
</body>
"""
MEASURED, OTHERS = range(1, 6), range(6, 13)
SPEEDS_M_S, GAP_M, DURATION_S = (0.08, 0.16, 0.24), 0.05, 5.0
# How far the middle of the puck is beside the robot's path, in m.
OFFSETS_M = {"in its middle": (0.0,), "off its middle": (-0.04, 0.04)}
# What the world's object is: times the weight that was measured, and its friction.
OBJECTS = ((1.0, FRICTION), (10.0, FRICTION), (1.0, FRICTION / 3))
HEADER = (
    "robot", "trial", "time_s", "x_m", "y_m", "heading_rad", "commanded_m_s", "commanded_rad_s", "object_x_m",
    "object_y_m",
)


class PuckFloor:
    """The floor of compare.py with a puck on it."""

    def __init__(self, kg):
        import mujoco_floor

        self.physics = mujoco_floor.physics
        self.period_s = mujoco_floor.Floor.period_s
        usual = self.physics.WORLD
        self.physics.WORLD = usual.replace("{robots}", "{robots}" + PUCK.format(kg=kg))
        names = [f"robot_{number}" for number in range(1, max(OTHERS) + 1)]
        self.world = self.physics.Physics(names, mujoco_floor.FLEET)
        self.physics.WORLD = usual

    def drive(self, robot, speed_m_s, offset_m, seed):
        """One robot drives straight at the puck, which is that far to its left: times, poses and the puck's places."""
        import numpy as np

        from floor import seeded

        world, name = self.world, f"robot_{robot}"
        world.draws = seeded("pushing", robot, speed_m_s, offset_m, seed)
        world.place({name: (0.0, 0.0, 0.0)})
        puck = world.model.joint("puck")
        place, motion = puck.qposadr[0], puck.dofadr[0]
        ahead_m = math.sqrt(max(0.0, (2 * RADIUS_M + GAP_M) ** 2 - offset_m**2))
        world.data.qpos[place : place + 7] = (ahead_m, offset_m, HEIGHT_M / 2, 1, 0, 0, 0)
        world.data.qvel[motion : motion + 6] = 0.0
        begin_s = world.time_s
        rows = []
        for sample in range(round(DURATION_S / self.period_s) + 1):
            world.advance(begin_s + sample * self.period_s)
            noise = [world.draws.gauss(0.0, self.physics.TRACKER_SD_M) for _ in range(2)]
            at_m = world.data.qpos[place : place + 2] + np.array(noise)
            rows.append((sample * self.period_s, *world.tracked(name), speed_m_s, 0.0, *at_m))
            world.obey(name, speed_m_s, 0.0)
        return rows


def speed_m_s(rows, begin_s, end_s):
    """Along the first heading, from one time to another."""
    (begin, end) = (min(rows, key=lambda row: abs(row[0] - time_s)) for time_s in (begin_s, end_s))
    return (end[1] - begin[1]) / (end[0] - begin[0])


def weight(floor):
    """How heavy the puck is: over that of a robot."""
    ratios = []
    for robot, speed in itertools.product(MEASURED, SPEEDS_M_S):
        pushed, free = floor.drive(robot, speed, 0.0, 1), floor.drive(robot, speed, 1.0, 1)
        touching_s = GAP_M / speed + 0.5
        ratios.append(speed_m_s(free, touching_s, DURATION_S) / speed_m_s(pushed, touching_s, DURATION_S) - 1)
    return ratios


def write(path, drives):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(HEADER)
        for (robot, *_), trial, rows in drives:
            writer.writerows((f"robot_{robot}", trial, *(f"{it:.5f}" for it in row)) for row in rows)


def hold_against(programs, folder, puck, kg):
    """What `rsrs validate` says of the puck's drives, for each of the world's objects."""
    floor = PuckFloor(kg)
    ratios = weight(floor)
    mean = sum(ratios) / len(ratios)
    found = []
    for (where, offsets_m), (factor, friction) in itertools.product(OFFSETS_M.items(), OBJECTS):
        name = f"{puck}_{len(found) + 1}"
        kinds = itertools.product(OTHERS, SPEEDS_M_S, offsets_m)
        write(folder / f"{name}.csv", [(kind, trial, floor.drive(*kind, 2)) for trial, kind in enumerate(kinds, 1)])
        (folder / f"{name}_world.yaml").write_text(
            f"objects: [{{count: 1, radius_m: {RADIUS_M}, friction: {friction:g}, weight: {mean * factor:.3f}}}]\n"
        )
        (folder / f"{name}.yaml").write_text(
            f"profile: profile.yaml\nworld: {name}_world.yaml\naxes: {{speed_m_s: [{SPEEDS_M_S[0]}]}}\n"
            "fixed: {turn_rate_rad_s: 0.5, robots: 1, arena_m: 15}\nreplicates: 2\nduration_s: 100\nseed: 1\n"
        )
        answer = programs.rsrs(
            folder, f"validate {name}.yaml --trajectories {name}.csv --robots 500 -o {name} --quiet --format json"
        )
        exits = {"robot": lambda trial: trial["exits"], "puck": lambda trial: trial["object"]["exits"]}
        last = lambda of: [it[-1] for it in map(exits[of], answer["trials"]) if it]
        found.append(
            {
                "where": where,
                "weight": round(mean * factor, 3),
                "friction": friction,
                **{key: answer[key] for key in ("n_trials", "n_inside", "p_value")},
                **{f"n_{of}_left": len(last(of)) for of in exits},
                "most_turned_rad": round(max((abs(it["turned_rad"]) for it in last("robot")), default=0.0), 2),
            }
        )
    return {"kg": kg, "weights": [round(it, 3) for it in (min(ratios), max(ratios))], "held": found}


def tables(results):
    lines = [
        "| puck | `weight` that robots show | met | `weight`, `friction` in the world | drives inside | the robot left "
        "| the puck left | p |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for of in results["pucks"]:
        for it in of["held"]:
            p = "< 0.0001" if it["p_value"] < 0.0001 else f"{it['p_value']:.4f}"
            lines.append(
                f"| {of['kg']} kg | {of['weights'][0]:.2f} to {of['weights'][1]:.2f} | {it['where']} "
                f"| {it['weight']:.2f}, {it['friction']:g} | {it['n_inside']} of {it['n_trials']} | {it['n_robot_left']} "
                f"| {it['n_puck_left']} | {p} |"
            )
    return "\n".join(lines)


def main():
    if sys.argv[1:2] == ["--tables"] and len(sys.argv) == 3:
        print(tables(json.loads(Path(sys.argv[2]).read_text())))
        return
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    import compare
    import mujoco_floor

    folder = Path(sys.argv[1]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    programs = compare.Programs()
    compare.measure(programs, mujoco_floor.Floor(), folder)
    pucks = [hold_against(programs, folder, puck, kg) for puck, kg in PUCKS_KG.items()]
    results = {"machine": compare.machine(), "pucks": pucks}
    (folder / "pushing.json").write_text(json.dumps(results, indent=1) + "\n")
    print(tables(results))


if __name__ == "__main__":
    main()
