"""swarmsim, the simulator of the paper's group, as they ship it (pip install swarmsim)."""

import numpy as np
from swarmsim.agent.MazeAgent import MazeAgent, MazeAgentConfig
from swarmsim.agent.control.BinaryController import BinaryController
from swarmsim.sensors.BinaryFOVSensor import BinaryFOVSensor
from swarmsim.world.RectangularWorld import RectangularWorld, RectangularWorldConfig

from floor import Recording, seeded

SIDE_M = 100.0
HALF_ANGLE_RAD, RANGE_M = 0.3, 0.8
MISSED, INVENTED = 0.10, 0.03
# What wheels make of commands, by robot: mean and standard deviation of a factor of speed and of turning rate.
SPEED, TURN = (0.95, 0.03), (0.90, 0.03)
# Periods by which motors are late, besides the one between a reading and the step that it decides.
LATE = 1


class Floor:
    """Robots that sense and move one after the other, and act on what they sensed a step before."""

    name = "swarmsim"
    radius_m = 0.075
    period_s = 0.1
    contact = "push"

    def drive(self, robots, starts, controller, duration_s, seed):
        """Lets robots, by number, drive from their starts."""
        draws = seeded(self.name, seed)
        config = RectangularWorldConfig(
            size=(SIDE_M, SIDE_M), time_step=self.period_s, seed=draws.getrandbits(31),
            collide_walls=False, stop_at=None,
        )
        world = RectangularWorld(config)
        for robot, (x, y, heading) in zip(robots, starts):
            of_robot = seeded(self.name, "robot", robot)
            gains = np.array([of_robot.gauss(*SPEED), of_robot.gauss(*TURN)])
            agent = MazeAgent(
                MazeAgentConfig(
                    position=(x + SIDE_M / 2, y + SIDE_M / 2), angle=heading,
                    agent_radius=self.radius_m, delay=LATE,
                ),
                world,
            )
            agent.controller = BinaryController(
                gains * controller.unseen, gains * controller.seen, agent=agent
            )
            agent.sensors = [
                BinaryFOVSensor(
                    agent, theta=HALF_ANGLE_RAD, distance=RANGE_M, walls=None,
                    false_positive=INVENTED, false_negative=MISSED, seed=draws.getrandbits(31),
                )
            ]
            world.population.append(agent)
        world.setup()
        n = round(duration_s / self.period_s)
        found = Recording.empty(self.period_s, n, len(robots))
        for sample in range(n):
            for place, agent in enumerate(world.population):
                is_seen = bool(agent.sensors[0].current_state)
                found.poses[sample, place] = (*(agent.pos - SIDE_M / 2), agent.angle)
                found.detections[sample, place] = is_seen
                found.commands[sample, place] = controller.seen if is_seen else controller.unseen
            world.step()
        assert len(world.population) == len(robots)
        return found
