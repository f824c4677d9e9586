"""Discs that start apart, are moved apart, and are in clusters: what second worlds in NumPy share.

Written from what the documentation states of contact and placement; bodies are moved apart in another way, pair after
pair, each by half of what it overlaps, until none overlaps. All functions work on many runs at once.
"""

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
