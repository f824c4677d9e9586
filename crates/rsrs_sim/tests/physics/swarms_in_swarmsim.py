"""Swarms of other behaviours in swarmsim: the trajectories of robots under its controllers.

Cyclic pursuit, dispersal and aggregation are controllers that A. Mattson and D. S. Brown labelled by
hand, as speeds of the left and the right wheel without and with a detection (`demo/simulation` of
RobotSwarmSimulator), with a sensor that is hardly more than a line. Milling is the controller and the
sensor that swarmsim's own configuration of a Flockbot has, which form a ring from a narrow start.
Reads JSON from standard input: `swarms` (a list of `{behaviour, seed, period_s, half_angle_rad}`, the
last one null for that of the sensor), `robots`, `duration_s`, `skipped_s`.
Writes JSON: for each swarm `[x_m, y_m, heading_rad, speed_m_s, turn_rate_rad_s]` of every robot at every
step after `skipped_s`, the command being the one that is obeyed next.
"""

import json
import math
import random
import sys

from swarmsim.agent.MazeAgent import MazeAgent, MazeAgentConfig
from swarmsim.agent.control.BinaryController import BinaryController
from swarmsim.sensors.BinaryFOVSensor import BinaryFOVSensor
from swarmsim.world.RectangularWorld import RectangularWorld, RectangularWorldConfig

WHEELS = {
    "cyclic_pursuit": (-0.7, 0.3, 1.0, 1.0),
    "dispersal": (0.2, 0.7, -0.5, -0.1),
    "aggregation": (-0.7, -1.0, 1.0, -1.0),
}
# Half angle and range of the sensor, and how far from the middle robots start at most.
LINE = {"theta": 0.02, "distance": 20.0, "start": 1.0}
CONE = {"theta": 0.2, "distance": 3.6, "start": 0.6}
# Forward speed and turning rate without and with a detection.
MILL = (0.15, -0.75), (0.15, 0.75)
SIDE_M = 100.0
RADIUS_M = 0.05
# A wheel at 1 is one of 0.2 m/s, and the wheels are two radii apart.
WHEEL_M_S = 0.2


def commands(behaviour):
    if behaviour == "milling":
        return MILL
    wheels = WHEELS[behaviour]
    return command(*wheels[:2]), command(*wheels[2:])


def command(left, right):
    return WHEEL_M_S * (left + right) / 2, WHEEL_M_S * (right - left) / (2 * RADIUS_M)


def make_world(task, swarm):
    world = RectangularWorld(RectangularWorldConfig(
        size=(SIDE_M, SIDE_M), time_step=swarm["period_s"], seed=swarm["seed"],
        collide_walls=False, stop_at=None))
    draw = random.Random(swarm["seed"])
    unseen, seen = commands(swarm["behaviour"])
    sensor = CONE if swarm["behaviour"] == "milling" else LINE
    start = sensor["start"]
    for _ in range(task["robots"]):
        place = tuple(SIDE_M / 2 + draw.uniform(-start, start) for _ in range(2))
        config = MazeAgentConfig(
            position=place, angle=draw.uniform(-math.pi, math.pi), agent_radius=RADIUS_M)
        agent = MazeAgent(config, world)
        agent.controller = BinaryController(unseen, seen, agent=agent)
        agent.sensors = [BinaryFOVSensor(
            agent, theta=swarm["half_angle_rad"] or sensor["theta"], distance=sensor["distance"], walls=None)]
        world.population.append(agent)
    world.setup()
    return world


def trajectory(task, swarm):
    world = make_world(task, swarm)
    rows = []
    skipped = int(task["skipped_s"] / swarm["period_s"])
    for step in range(int(task["duration_s"] / swarm["period_s"])):
        world.step()
        if step < skipped:
            continue
        for agent in world.population:
            x, y = agent.getPosition()
            speed, turn_rate = agent.controller.get_actions(agent)[:2]
            rows.append([float(x), float(y), float(agent.angle), float(speed), float(turn_rate)])
    assert len(world.population) == task["robots"]
    return rows


def main():
    task = json.load(sys.stdin)
    print(json.dumps([trajectory(task, swarm) for swarm in task["swarms"]]))


if __name__ == "__main__":
    main()
