"""A second world of robots that push objects, slow and plain, for the share of objects in the largest cluster.

Written from what the documentation states of objects, of sensors and of contact, and with another way of moving
bodies apart: pair after pair, each by half of what it overlaps, until none overlaps. Nothing here was taken from the
program that it checks, and no random number is shared with it.

Reads conditions as JSON; prints the mean share at each time, and its standard error.
"""

import json
import sys

import numpy as np

# Bodies are apart when they overlap by no more than this, in metres.
APART = 2e-5


def starts(draw, runs, radii, robots, box, side):
    """Robots anywhere in the box, objects anywhere in the arena, a tenth further apart than touching."""
    n = len(radii)
    x, y = np.full((runs, n), 1e3) * np.arange(1, n + 1), np.zeros((runs, n))
    for body in range(n):
        half = box / 2 if body < robots else side / 2 - radii[body]
        todo = np.arange(runs)
        while todo.size:
            x[todo, body] = draw.uniform(-half, half, todo.size)
            y[todo, body] = draw.uniform(-half, half, todo.size)
            near = np.hypot(x[todo, :body] - x[todo, body, None], y[todo, :body] - y[todo, body, None])
            todo = todo[(near < 1.1 * (radii[:body] + radii[body])).any(axis=1)]
    return x, y


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


def move_apart(x, y, radii, side):
    """Pair after pair, each by half, in all runs at once, until none overlaps."""
    n = len(radii)
    one, other = np.triu_indices(n, 1)
    touching = radii[one] + radii[other]
    for _ in range(500):
        near = np.hypot(x[:, one] - x[:, other], y[:, one] - y[:, other]) < touching - APART
        if not near.any():
            return
        # The pairs that overlap somewhere, in an order of their own each time.
        for pair in np.flatnonzero(near.any(axis=0)):
            a, b = one[pair], other[pair]
            dx, dy = x[:, a] - x[:, b], y[:, a] - y[:, b]
            distance = np.maximum(np.hypot(dx, dy), 1e-9)
            by = np.maximum(touching[pair] - distance, 0) / 2 / distance
            x[:, a] += by * dx
            y[:, a] += by * dy
            x[:, b] -= by * dx
            y[:, b] -= by * dy
            for body in (a, b):
                most = side / 2 - radii[body]
                np.clip(x[:, body], -most, most, out=x[:, body])
                np.clip(y[:, body], -most, most, out=y[:, body])


def largest(x, y, near):
    """Share of the discs in the largest cluster of each run."""
    linked = np.hypot(x[:, :, None] - x[:, None, :], y[:, :, None] - y[:, None, :]) < near
    for _ in range(x.shape[1].bit_length() + 1):
        linked = (linked.astype(np.float32) @ linked.astype(np.float32)) > 0
    return linked.sum(axis=2).max(axis=1) / x.shape[1]


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
