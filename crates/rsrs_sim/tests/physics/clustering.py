"""A second world of robots that push objects, slow and plain, for the share of objects in the largest cluster.

Written from what the documentation states of objects, of sensors and of contact, and with another way of moving
bodies apart (`discs.py`). Nothing here was taken from the program that it checks, and no random number is shared with it.

Reads conditions as JSON; prints the mean share at each time, and its standard error.
"""

import json
import sys

import numpy as np

from discs import largest, move_apart, starts


def seen(x, y, heading, radii, robots, reach):
    """What the line of sight of each robot meets first: 0 for nothing, 1 for a robot, 2 for an object."""
    dx, dy = x[:, None, :] - x[:, :robots, None], y[:, None, :] - y[:, :robots, None]
    cosine, sine = np.cos(heading)[..., None], np.sin(heading)[..., None]
    ahead, aside = dx * cosine + dy * sine, dy * cosine - dx * sine
    hits = (np.abs(aside) <= radii) & (ahead > 0)
    hits[:, np.arange(robots), np.arange(robots)] = False
    at = np.where(hits, ahead - np.sqrt(np.maximum(radii**2 - aside**2, 0)), np.inf)
    first = at.argmin(axis=2)
    nothing = np.take_along_axis(at, first[..., None], 2)[..., 0] > reach
    return np.where(nothing, 0, np.where(first < robots, 1, 2))


def main():
    of = json.load(open(sys.argv[1]))
    draw = np.random.default_rng(11)
    robots, objects, runs = of["robots"], of["objects"], of["runs"]
    radii = np.array([of["robot_m"]] * robots + [of["object_m"]] * objects)
    x, y = starts(draw, runs, radii, robots, of["box_m"], of["side_m"])
    heading = draw.uniform(-np.pi, np.pi, (runs, robots))
    speeds, rates = np.array(of["speeds_m_s"]), np.array(of["turn_rates_rad_s"])
    looks = {round(time / of["period_s"]) for time in of["times_s"]}
    found = []
    most = side = of["side_m"]
    for step in range(max(looks) + 1):
        if step in looks:
            shares = largest(x[:, robots:], y[:, robots:], 4 * of["object_m"])
            found.append([shares.mean(), shares.std(ddof=1) / np.sqrt(runs)])
        what = seen(x, y, heading, radii, robots, of["range_m"])
        way = speeds[what] * of["period_s"]
        most = side / 2 - radii[:robots]
        x[:, :robots] = np.clip(x[:, :robots] + way * np.cos(heading), -most, most)
        y[:, :robots] = np.clip(y[:, :robots] + way * np.sin(heading), -most, most)
        heading = heading + rates[what] * of["period_s"]
        move_apart(x, y, radii, side)
    print(json.dumps(found))


main()
