"""A second world of robots of several classes, slow and plain, for the share of a class in its largest cluster.

Written from what the documentation states of classes, of sensors and of contact, and with another way of moving bodies
apart (`discs.py`). Nothing here was taken from the program that it checks, and no random number is shared with it.

Reads conditions as JSON; prints the mean share at each time, and its standard error.
"""

import json
import sys

import numpy as np

from discs import largest, move_apart, starts


def seen(x, y, heading, classes, of):
    """What each robot's sensor reports: 0 for nothing, 1 for kin, 2 for others. Of the centres within its angle and range
    the nearest counts to which no body lies across the straight way."""
    runs, n = x.shape
    dx, dy = x[:, None, :] - x[:, :, None], y[:, None, :] - y[:, :, None]
    cosine, sine = np.cos(heading)[..., None], np.sin(heading)[..., None]
    ahead, aside = dx * cosine + dy * sine, dy * cosine - dx * sine
    far = np.hypot(ahead, aside)
    inside = (np.abs(np.arctan2(aside, ahead)) <= of["half_angle_rad"]) & (far <= of["range_m"])
    inside[:, np.arange(n), np.arange(n)] = False
    # Whether the body of the last index lies across the way from the first to the second.
    along = (ahead[:, :, None, :] * ahead[:, :, :, None] + aside[:, :, None, :] * aside[:, :, :, None]) / np.maximum(
        far[:, :, :, None], 1e-12
    )
    across2 = np.maximum(far[:, :, None, :] ** 2 - along**2, 0)
    between = (along > 0) & (along < far[:, :, :, None]) & (across2 <= of["robot_m"] ** 2)
    one = np.arange(n)
    between[:, one, :, one] = False
    between[:, :, one, one] = False
    at = np.where(inside & ~between.any(axis=3), far, np.inf)
    first = at.argmin(axis=2)
    is_nothing = np.isinf(np.take_along_axis(at, first[..., None], 2)[..., 0])
    return np.where(is_nothing, 0, np.where(classes[first] == classes, 1, 2))


def main():
    of = json.load(open(sys.argv[1]))
    draw = np.random.default_rng(12)
    robots, runs, side = of["robots"], of["runs"], of["side_m"]
    classes = np.arange(robots) % of["classes"]
    radii = np.full(robots, of["robot_m"])
    x, y = starts(draw, runs, radii, robots, of["box_m"], side)
    heading = draw.uniform(-np.pi, np.pi, (runs, robots))
    speeds, rates = np.array(of["speeds_m_s"]), np.array(of["turn_rates_rad_s"])
    looks = {round(time / of["period_s"]) for time in of["times_s"]}
    found = []
    most = side / 2 - radii
    near = 2 * of["robot_m"] + of["apart_m"]
    for step in range(max(looks) + 1):
        if step in looks:
            kin = [classes == one for one in range(of["classes"])]
            shares = np.mean([largest(x[:, one], y[:, one], near) for one in kin], axis=0)
            found.append([shares.mean(), shares.std(ddof=1) / np.sqrt(runs)])
        what = seen(x, y, heading, classes, of)
        way = speeds[what] * of["period_s"]
        x = np.clip(x + way * np.cos(heading), -most, most)
        y = np.clip(y + way * np.sin(heading), -most, most)
        heading = heading + rates[what] * of["period_s"]
        move_apart(x, y, radii, side)
    print(json.dumps(found))


main()
