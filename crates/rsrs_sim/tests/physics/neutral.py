"""A second world and a second judge, slow and plain, for the phase shares of a few cells.

Written from the paper and from the rules of docs and DESIGN alone: one step of the world is sense, decide,
move, for all robots at once; a phase is a table of thresholds over the last 60 s. Nothing here was taken
from the program that it checks, and no random number is shared with it.

Reads cells with the shares that the program found; prints how many agree, or fails with a table.
"""

import json
import sys

import numpy as np

N = 9
RADIUS = 0.075
PERIOD = 0.13
RANGE, HALF_ANGLE = 0.75, 0.2
FRONT = np.radians(70)
DISC = 0.825
BOX = 15.0
DURATION, WINDOW = 300.0, 60.0
# Bodies are seen, so centres are seen from further away.
REACH = RANGE + RADIUS
PHASES = ["stable_milling", "semi_stable_milling", "colliding_unstable", "dispersion", "unformed"]
F = np.float32


def gains(draw, shape, mean, sd):
    """Normal, cut off at three standard deviations."""
    found = draw.normal(size=shape)
    while (off := np.abs(found) > 3).any():
        found[off] = draw.normal(size=off.sum())
    return (mean + sd * found).astype(F)


def starts(draw, runs):
    """Anywhere in the disc, at least 2.2 radii apart, facing away from its centre."""
    x, y = np.full((runs, N), np.inf), np.full((runs, N), np.inf)
    for robot in range(N):
        left = np.ones(runs, bool)
        while left.any():
            radius = DISC * np.sqrt(draw.random(left.sum()))
            angle = 2 * np.pi * draw.random(left.sum())
            px, py = radius * np.cos(angle), radius * np.sin(angle)
            gap = np.hypot(x[left, :robot] - px[:, None], y[left, :robot] - py[:, None])
            fits = (gap >= 2.2 * RADIUS).all(axis=1)
            rows = np.flatnonzero(left)[fits]
            x[rows, robot], y[rows, robot] = px[fits], py[fits]
            left[rows] = False
    return x.astype(F), y.astype(F), np.arctan2(y, x).astype(F)


def simulate(draw, cell, runs):
    """Positions, headings and nearest neighbours in the last minute, by time, run and robot."""
    speed_gain = gains(draw, (runs, N), cell["gain_mean"], cell["gain_sd"])
    turn_gain = gains(draw, (runs, N), cell["gain_mean"], cell["gain_sd"])
    x, y, heading = starts(draw, runs)
    steps, kept = int(DURATION / PERIOD), int(WINDOW / PERIOD) + 1
    own = np.eye(N, dtype=bool)
    cos_edge, sin_edge = F(np.cos(HALF_ANGLE)), F(np.sin(HALF_ANGLE))
    window = []
    for step in range(steps + 1):
        cos, sin = np.cos(heading), np.sin(heading)
        dx, dy = x[:, None, :] - x[:, :, None], y[:, None, :] - y[:, :, None]
        squared = dx * dx + dy * dy
        squared[:, own] = np.inf
        if step > steps - kept:
            window.append((x, y, heading, squared.min(axis=2) <= REACH**2))
        if step == steps:
            break
        ahead = dx * cos[:, :, None] + dy * sin[:, :, None]
        aside = np.abs(dy * cos[:, :, None] - dx * sin[:, :, None])
        # Some of the body lies in the cone: the nearest point of the cone is less than a radius away.
        # Beside the cone it is on the edge, else on the arc.
        on_edge = np.clip(ahead * cos_edge + aside * sin_edge, 0, F(RANGE))
        from_edge = np.hypot(ahead - on_edge * cos_edge, aside - on_edge * sin_edge)
        within = np.arctan2(aside, ahead) <= HALF_ANGLE
        near = np.where(within, squared <= REACH**2, from_edge <= RADIUS)
        near[:, own] = False
        seen = near.any(axis=2)
        touching = (squared < (2 * RADIUS) ** 2) & (ahead > np.cos(FRONT) * np.sqrt(squared))
        blocked = touching.any(axis=2)
        chance = np.where(seen, cell["true_positive"], cell["false_positive"])
        turn = np.where(draw.random((runs, N)) < chance, cell["turn"], -cell["turn"]).astype(F)
        speed = np.where(blocked, 0, F(cell["speed"]) * speed_gain)
        nx, ny = x + speed * cos * F(PERIOD), y + speed * sin * F(PERIOD)
        stays = np.maximum(np.abs(nx), np.abs(ny)) > BOX / 2 - RADIUS
        x, y = np.where(stays, x, nx), np.where(stays, y, ny)
        heading = heading + turn * turn_gain * F(PERIOD)
    return [np.array(part) for part in zip(*window)]


def measure(window, speed):
    """What a stretch of time shows of each run."""
    x, y, heading, has_neighbour = window
    lost = ((~has_neighbour).mean(axis=0) > 0.5).mean(axis=1)

    second = round(1 / PERIOD)
    gone = np.hypot(x[second:] - x[:-second], y[second:] - y[:-second])
    blocked_at = gone < 0.2 * speed * second * PERIOD
    blocked = blocked_at.mean(axis=(0, 2))
    stuck = (blocked_at.mean(axis=0) > 0.9).mean(axis=1)

    x, y = x - x.mean(axis=2, keepdims=True), y - y.mean(axis=2, keepdims=True)
    radius = np.maximum(np.hypot(x, y), 1e-9)
    cos, sin = np.cos(heading), np.sin(heading)
    rotation = np.abs(((x * sin - y * cos) / radius).mean(axis=(0, 2)))
    angle = np.arctan2(x[:-1] * y[1:] - y[:-1] * x[1:], x[:-1] * x[1:] + y[:-1] * y[1:])
    orbit = np.abs((angle * radius[1:]).mean(axis=(0, 2))) / (speed * PERIOD)
    fatness = (1 - (radius.min(axis=2) / radius.max(axis=2)) ** 2).mean(axis=0)
    tangentness = np.abs((x * cos + y * sin) / radius).mean(axis=(0, 2))
    circliness = 1 - np.maximum(fatness, tangentness)

    whole = (rotation >= 0.9) & (orbit >= 0.8) & (circliness >= 0.5)
    return lost, blocked, stuck, rotation, orbit, whole & (blocked < 0.02) & (lost == 0)


def judge(window, speed):
    """The phase of each run: a table of thresholds, from the top."""
    lost, blocked, stuck, rotation, orbit, mills = measure(window, speed)
    # A stable mill lasts: at most one of its six blocks of ten seconds may look otherwise.
    blocks = [measure(block, speed)[-1] for block in zip(*(np.array_split(p, 6) for p in window))]
    lasts = np.sum(blocks, axis=0) >= 5
    table = [
        ("dispersion", lost >= 0.25),
        ("colliding_unstable", (stuck >= 0.2) | (blocked >= 0.25)),
        ("stable_milling", mills & lasts),
        ("semi_stable_milling", (rotation >= 0.6) & (orbit >= 0.5)),
    ]
    return np.select([rule for _, rule in table], [phase for phase, _ in table], "unformed")


def main():
    draw = np.random.default_rng(20261122)
    lines, wrong = [], 0
    for cell in json.load(open(sys.argv[1])):
        runs = cell["runs_there"]
        phases = judge(simulate(draw, cell, runs), cell["speed"])
        for phase in PHASES:
            here, there = (phases == phase).mean(), cell["counts"][phase] / cell["runs"]
            both = (here * runs + there * cell["runs"]) / (runs + cell["runs"])
            error = np.sqrt(both * (1 - both) * (1 / runs + 1 / cell["runs"]))
            agrees = abs(here - there) <= 4 * error + 0.03
            wrong += not agrees
            mark = "" if agrees else "   <-"
            lines.append(f"{cell['name']:40} {phase:20} {here:6.3f} {there:6.3f}{mark}")
    table = "\n".join(lines)
    assert not wrong, f"{wrong} shares differ, this one and that of the program:\n{table}"
    print(table, file=sys.stderr)
    print(len(lines), "shares agree")


main()
