"""What every floor has in common: a recording of what robots did, and the two commands that they obey."""

import math
import random
from dataclasses import dataclass, field

import numpy as np


@dataclass
class Controller:
    """Speed in m/s and turning rate in rad/s where nothing is detected, and where something is."""

    unseen: tuple
    seen: tuple

    @classmethod
    def of_cell(cls, speed_m_s, turn_rate_rad_s):
        """The paper's: to the right where nothing is detected, and to the left where something is."""
        return cls((speed_m_s, -turn_rate_rad_s), (speed_m_s, turn_rate_rad_s))

    @classmethod
    def constant(cls, speed_m_s, turn_rate_rad_s):
        return cls((speed_m_s, turn_rate_rad_s), (speed_m_s, turn_rate_rad_s))


@dataclass
class Recording:
    """What robots did, sampled every `period_s` seconds.

    `poses` has shape (T, N, 3): x and y in metres, heading in radians; `commands` (T, N, 2): m/s and rad/s;
    `detections` (T, N) of booleans. `periods_s` are the times from one decision of the first robot to its next,
    if they are not all alike.
    """

    period_s: float
    poses: np.ndarray
    commands: np.ndarray
    detections: np.ndarray
    periods_s: list = field(default_factory=list)

    @classmethod
    def empty(cls, period_s, n_samples, n_robots):
        shape = n_samples, n_robots
        return cls(
            period_s, np.zeros((*shape, 3)), np.zeros((*shape, 2)), np.zeros(shape, bool), [period_s] * n_samples
        )

    @property
    def time_s(self):
        return self.period_s * np.arange(len(self.poses))


def starts(n_robots, disc_m, radius_m, draws):
    """Anywhere in a disc, facing away from its centre, at least 2.2 radii of a body apart."""
    poses = []
    while len(poses) < n_robots:
        far_m, angle = disc_m * math.sqrt(draws.random()), math.tau * draws.random()
        place = far_m * math.cos(angle), far_m * math.sin(angle)
        if all(math.dist(place, other[:2]) >= 2.2 * radius_m for other in poses):
            poses.append((*place, angle))
    return poses


def seeded(*parts):
    """Draws that follow from these parts only."""
    return random.Random(" ".join(map(str, parts)))
