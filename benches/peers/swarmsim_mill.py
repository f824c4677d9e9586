"""The mill in swarmsim, the simulator of the paper's group.

Robots, sensor and placement are those of `rsrs_benches::flockbots`; contact is swarmsim's, which
pushes bodies apart. Prints one line: name, robots, agent-steps, CPU seconds.
"""

import math
import random
import sys
import time

from swarmsim import __version__
from swarmsim.agent.MazeAgent import MazeAgent, MazeAgentConfig
from swarmsim.agent.control.BinaryController import BinaryController
from swarmsim.sensors.BinaryFOVSensor import BinaryFOVSensor
from swarmsim.world.RectangularWorld import RectangularWorld, RectangularWorldConfig

BODY_M = 0.075


def place(robots):
    """Uniform in a disc, at least 2.2 r apart, facing out."""
    draw = random.Random(1)
    places = []
    while len(places) < robots:
        bearing = draw.uniform(0, 2 * math.pi)
        distance = 0.825 * math.sqrt(robots / 9.0) * math.sqrt(draw.random())
        at = (7.5 + distance * math.cos(bearing), 7.5 + distance * math.sin(bearing))
        if all(math.dist(at, other) >= 2.2 * BODY_M for other, _ in places):
            places.append((at, bearing))
    return places


def main():
    robots = int(sys.argv[1]) if len(sys.argv) > 1 else 9
    world = RectangularWorld(
        RectangularWorldConfig(size=(15.0, 15.0), time_step=0.13, seed=1, collide_walls=False))
    for at, heading in place(robots):
        agent = MazeAgent(MazeAgentConfig(position=at, angle=heading, agent_radius=BODY_M), world)
        agent.controller = BinaryController((0.15, -0.75), (0.15, 0.75), agent=agent)
        agent.sensors = [BinaryFOVSensor(
            agent, theta=0.2, distance=0.75, false_negative=0.20, false_positive=0.08)]
        world.population.append(agent)
    world.setup()
    steps = max(20, 4500 // robots)
    start = time.process_time()
    for _ in range(steps):
        world.step()
    elapsed = time.process_time() - start
    print(f"swarmsim {__version__} (Python),{robots},{steps * robots},{elapsed:.4f}")


if __name__ == "__main__":
    main()
