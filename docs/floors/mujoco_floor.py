"""The robots of docs/examples/mujoco, stepped without ROS and as fast as it goes."""

import sys
from pathlib import Path

from floor import Recording, seeded

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "examples/mujoco"))
import physics  # noqa: E402

FLEET = 1  # The seed that the robots are made with; they are the same in all trials and runs.
# In steps of 5 ms in place of 2, which takes less than half of the time.
physics.STEP_S = 0.005


class Floor:
    """Rigid bodies that push each other, motors with inertia, tyres that slip, cameras that cast rays."""

    name = "mujoco"
    radius_m = physics.BODY_RADIUS_M
    period_s = 0.1
    contact = "push"
    rectangle_m = None  # Width and height of what walls enclose; nothing does where there is none.

    def drive(self, robots, starts, controller, duration_s, seed):
        """Lets robots, by number, drive from their starts. Each decides by a clock of its own."""
        names = [f"robot_{number}" for number in range(1, max(robots) + 1)]
        world = physics.Physics(names, FLEET, self.rectangle_m)
        draws = seeded(self.name, seed)
        world.draws = draws
        names = [f"robot_{robot}" for robot in robots]
        world.place(dict(zip(names, starts)))
        turns = sorted((self.period_s * draws.random(), robot) for robot in range(len(robots)))
        n = round(duration_s / self.period_s)
        found = Recording.empty(self.period_s, n, len(robots))
        for sample in range(n):
            found.poses[sample] = [world.tracked(name) for name in names]
            for after_s, robot in turns:
                world.advance(self.period_s * sample + after_s)
                is_seen = world.detects(names[robot])
                command = controller.seen if is_seen else controller.unseen
                world.obey(names[robot], *command)
                found.commands[sample, robot], found.detections[sample, robot] = command, is_seen
            world.advance(self.period_s * (sample + 1))
        return found
