"""What one robot on the floor of discovery.py does that comes to a wall and drives on.

    python docs/floors/wall.py FILE

writes what each trial did to FILE as JSON, and a table of them, in about a minute.

    python docs/floors/wall.py --tables docs/floors/wall.json

prints the table again. Each trial begins 1 mm from a wall, at an angle between its heading and the wall's normal, and
goes on for 120 s with one command, which turns left. In half of the trials the wall has no friction.
"""

import itertools
import json
import math
import sys
from pathlib import Path

SPEEDS_M_S, RATE_RAD_S = (0.09, 0.05), 0.8
ANGLES_RAD = (-1.2, -0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9, 1.2)
DURATION_S, GAP_M = 120.0, 0.001
# A robot is away from the wall if its body is so far from it.
AWAY_M = 0.02
# MuJoCo takes the greater friction of two, the robot's here, unless one has priority.
WITHOUT_FRICTION = 'friction="0" priority="2"'


def trial(speed_m_s, angle_rad, has_friction):
    """When the robot was away, if it came away, and how far it had turned and slid by then or by the end."""
    import numpy as np

    import discovery
    import mujoco_floor
    from floor import Controller

    made = discovery.floor(discovery.RECTANGLE_M)
    usual = mujoco_floor.physics.WALL
    if not has_friction:
        mujoco_floor.physics.WALL = usual.replace('friction="0.3"', WITHOUT_FRICTION)
        assert mujoco_floor.physics.WALL != usual
    touching_m = discovery.RECTANGLE_M[0] / 2 - made.radius_m
    start = (touching_m - GAP_M, 0.0, angle_rad)
    command = Controller.constant(speed_m_s, RATE_RAD_S)
    poses = made.drive([1], [start], command, DURATION_S, f"wall {angle_rad}").poses[:, 0]
    mujoco_floor.physics.WALL = usual
    is_away = poses[:, 0] < touching_m - AWAY_M
    end = int(np.argmax(is_away)) if is_away.any() else len(poses) - 1
    turned = np.unwrap(poses[:, 2])
    return {
        "speed_m_s": speed_m_s,
        "angle_rad": angle_rad,
        "has_friction": has_friction,
        "away_after_s": round(end * made.period_s, 1) if is_away.any() else None,
        "turned_rad": round(float(turned[end] - turned[0]), 2),
        "slid_m": round(float(poses[end, 1] - poses[0, 1]), 3),
    }


def tables(trials):
    """Of each speed and wall: how many trials stayed at it, how far they turned and slid, and when others left."""
    lines = [
        "| speed | friction at the wall | still there after 120 s | turned left until then | slid along it by at most "
        "| the others left after |",
        "|---|---|---|---|---|---|",
    ]
    span = lambda values, unit: f"{min(values)} to {max(values)} {unit}" if values else ""
    for has_friction, speed_m_s in itertools.product((True, False), SPEEDS_M_S):
        of_kind = [it for it in trials if (it["speed_m_s"], it["has_friction"]) == (speed_m_s, has_friction)]
        stayed = [it for it in of_kind if it["away_after_s"] is None]
        left_s = [it["away_after_s"] for it in of_kind if it["away_after_s"] is not None]
        slid = f"{max(abs(it['slid_m']) for it in stayed):.2f} m" if stayed else ""
        lines.append(
            f"| {speed_m_s} m/s | {'as everywhere' if has_friction else 'none'} | {len(stayed)} of {len(of_kind)} "
            f"| {span([it['turned_rad'] for it in stayed], 'rad')} | {slid} | {span(left_s, 's')} |"
        )
    return "\n".join(lines)


def main():
    if sys.argv[1:2] == ["--tables"] and len(sys.argv) == 3:
        print(tables(json.loads(Path(sys.argv[2]).read_text())))
        return
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    kinds = itertools.product((True, False), SPEEDS_M_S, ANGLES_RAD)
    trials = [trial(speed_m_s, angle_rad, has_friction) for has_friction, speed_m_s, angle_rad in kinds]
    Path(sys.argv[1]).write_text("[\n" + ",\n".join(f" {json.dumps(it)}" for it in trials) + "\n]\n")
    print(tables(trials))


if __name__ == "__main__":
    main()
