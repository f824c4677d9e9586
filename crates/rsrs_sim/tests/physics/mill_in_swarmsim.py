"""A mill in swarmsim, the simulator of the paper's group, from given starting poses.

Reads JSON from standard input: `poses` (a list of `[x_m, y_m, heading_rad]`), `speed_m_s`,
`turn_rate_rad_s`, `half_angle_rad`, `range_m`, `radius_m`, `period_s`, `steps`, `window`.
Writes JSON: mean radius and swarmsim's own circliness over the last `window` steps.
"""

import json
import sys

import numpy as np
from swarmsim.agent.MazeAgent import MazeAgent, MazeAgentConfig
from swarmsim.agent.control.BinaryController import BinaryController
from swarmsim.metrics.Circliness import Circliness
from swarmsim.sensors.BinaryFOVSensor import BinaryFOVSensor
from swarmsim.world.RectangularWorld import RectangularWorld, RectangularWorldConfig

SIDE_M = 100.0


def make_world(task):
    world = RectangularWorld(RectangularWorldConfig(
        size=(SIDE_M, SIDE_M), time_step=task["period_s"], seed=1,
        collide_walls=False, stop_at=None))
    speed, turn = task["speed_m_s"], task["turn_rate_rad_s"]
    for x, y, heading in task["poses"]:
        config = MazeAgentConfig(
            position=(x + SIDE_M / 2, y + SIDE_M / 2), angle=heading,
            agent_radius=task["radius_m"])
        agent = MazeAgent(config, world)
        # Without and with a detection.
        agent.controller = BinaryController((speed, -turn), (speed, turn), agent=agent)
        agent.sensors = [BinaryFOVSensor(
            agent, theta=task["half_angle_rad"], distance=task["range_m"], walls=None)]
        world.population.append(agent)
    return world


def main():
    task = json.load(sys.stdin)
    world = make_world(task)
    world.setup()
    circliness = Circliness(history=task["window"], avg_history_max=task["window"])
    circliness.attach_world(world)
    radii = []
    for step in range(task["steps"]):
        world.step()
        if step >= task["steps"] - task["window"]:
            circliness.calculate()
            places = np.array([agent.getPosition() for agent in world.population])
            radii.append(np.linalg.norm(places - places.mean(axis=0), axis=1).mean())
    assert len(world.population) == len(task["poses"])
    result = {"radius_m": float(np.mean(radii)), "circliness": float(circliness._calculate())}
    print(json.dumps(result))


if __name__ == "__main__":
    main()
