"""The mill in NumPy: many worlds at once, as arrays of shape (worlds, robots).

Robots, sensor, contact and placement are those of `rsrs_benches::flockbots`. Prints one line: name,
robots, agent-steps, CPU seconds.
"""

import sys
import time

import numpy as np

BODY_M, RANGE_M, HALF_ANGLE_RAD, FRONT_RAD = 0.075, 0.75, 0.2, np.radians(70.0)
SPEED_M_S, TURN_RATE_RAD_S, PERIOD_S = 0.15, 0.75, 0.13
TRUE_POSITIVE, FALSE_POSITIVE = 0.80, 0.08
WALL_M = 7.5 - BODY_M


def place(generator, worlds, robots):
    """Uniform in a disc, at least 2.2 r apart."""
    radius_m = 0.825 * np.sqrt(robots / 9.0)
    x = np.full((worlds, robots), np.inf)
    y = np.full((worlds, robots), np.inf)
    for robot in range(robots):
        todo = np.arange(worlds)
        while todo.size:
            bearing = generator.uniform(0, 2 * np.pi, todo.size)
            distance = radius_m * np.sqrt(generator.uniform(0, 1, todo.size))
            new_x, new_y = distance * np.cos(bearing), distance * np.sin(bearing)
            others = slice(0, robot)
            gap = np.hypot(x[todo, others] - new_x[:, None], y[todo, others] - new_y[:, None])
            free = (gap >= 2.2 * BODY_M).all(axis=1)
            x[todo[free], robot], y[todo[free], robot] = new_x[free], new_y[free]
            todo = todo[~free]
    return x, y


def main():
    robots = int(sys.argv[1]) if len(sys.argv) > 1 else 9
    worlds = 1000 if robots <= 9 else 200
    steps = max(20, 1_000_000 // (worlds * robots))
    generator = np.random.default_rng(1)
    x, y = place(generator, worlds, robots)
    heading = np.arctan2(y, x)
    speed = SPEED_M_S * generator.normal(0.97, 0.05, x.shape)
    turn = TURN_RATE_RAD_S * generator.normal(0.97, 0.05, x.shape)
    edge_x, edge_y = np.cos(HALF_ANGLE_RAD), np.sin(HALF_ANGLE_RAD)
    start = time.process_time()
    for _ in range(steps):
        cosine, sine = np.cos(heading)[:, :, None], np.sin(heading)[:, :, None]
        dx, dy = x[:, None, :] - x[:, :, None], y[:, None, :] - y[:, :, None]
        d2 = dx * dx + dy * dy
        forward, lateral = dx * cosine + dy * sine, dy * cosine - dx * sine
        # From the edge of the cone, and along it.
        aside = np.abs(lateral)
        beside, along = aside * edge_x - forward * edge_y, aside * edge_y + forward * edge_x
        beyond = along - np.clip(along, 0, RANGE_M)
        touches = (beside <= 0) | (beside * beside + beyond * beyond <= BODY_M**2)
        seen = ((d2 <= (RANGE_M + BODY_M) ** 2) & (d2 > 0) & touches).any(axis=2)
        touching = (d2 < (2 * BODY_M) ** 2) & (d2 > 0)
        blocked = (touching & (forward > np.cos(FRONT_RAD) * np.sqrt(d2))).any(axis=2)
        probability = np.where(seen, TRUE_POSITIVE, FALSE_POSITIVE)
        detected = generator.random(x.shape) < probability
        travel = np.where(blocked, 0.0, speed * PERIOD_S)
        new_x, new_y = x + travel * cosine[:, :, 0], y + travel * sine[:, :, 0]
        stays = (np.abs(new_x) > WALL_M) | (np.abs(new_y) > WALL_M)
        x, y = np.where(stays, x, new_x), np.where(stays, y, new_y)
        heading = heading + np.where(detected, turn, -turn) * PERIOD_S
    elapsed = time.process_time() - start
    print(f"NumPy {np.__version__}; {worlds} worlds at once,{robots},{steps * worlds * robots},"
          f"{elapsed:.4f}")


if __name__ == "__main__":
    main()
