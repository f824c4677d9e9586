"""The mill in VMAS: 4,096 worlds at once, as tensors of PyTorch on one core.

Nine robots that are driven by speed and turning rate, with a sensor that sees the centres of others in the cone
of `rsrs_benches::flockbots`; they push each other, as bodies of VMAS do, and start where they may overlap. The
sensor does not err, robots are alike, and there are no walls. Prints one line: name, robots, agent-steps, CPU
seconds.
"""

import math
import time
from importlib.metadata import version

import torch
from vmas import make_env
from vmas.simulator.core import Agent, Sphere, World
from vmas.simulator.dynamics.diff_drive import DiffDrive
from vmas.simulator.scenario import BaseScenario

ROBOTS, WORLDS, STEPS = 9, 4096, 30
BODY_M, REACH_M, HALF_ANGLE_RAD, PERIOD_S = 0.075, 0.825, 0.2, 0.13


class Mill(BaseScenario):
    """Observations are the detections of all robots, found together for the first robot of a step."""

    def make_world(self, batch_dim, device, **_):
        world = World(batch_dim, device, dt=PERIOD_S, drag=0)
        for robot in range(ROBOTS):
            world.add_agent(Agent(
                f"robot_{robot}", shape=Sphere(BODY_M), dynamics=DiffDrive(world, integration="euler"),
                u_range=[0.3, 2.5], collide=True, render_action=False))
        return world

    def reset_world_at(self, env_index=None):
        worlds = self.world.batch_dim if env_index is None else 1
        for agent in self.world.agents:
            bearing = 2 * math.pi * torch.rand(worlds, 1)
            distance = 0.825 * torch.rand(worlds, 1).sqrt()
            agent.set_pos(distance * torch.cat([bearing.cos(), bearing.sin()], dim=1), batch_index=env_index)
            agent.set_rot(bearing, batch_index=env_index)

    def observation(self, agent):
        if agent is self.world.agents[0]:
            at = torch.stack([agent.state.pos for agent in self.world.agents], dim=1)
            heading = torch.cat([agent.state.rot for agent in self.world.agents], dim=1)[..., None]
            apart = at[:, None] - at[:, :, None]
            cosine, sine = heading.cos(), heading.sin()
            forward = apart[..., 0] * cosine + apart[..., 1] * sine
            aside = (apart[..., 1] * cosine - apart[..., 0] * sine).abs()
            in_cone = (aside <= math.tan(HALF_ANGLE_RAD) * forward) & (forward > 0)
            self.seen = (in_cone & (apart.square().sum(-1) <= REACH_M**2)).any(dim=2)
        return self.seen[:, self.world.agents.index(agent), None]

    def reward(self, agent):
        return torch.zeros(self.world.batch_dim)


def main():
    torch.set_num_threads(1)
    env = make_env(Mill(), num_envs=WORLDS, device="cpu", continuous_actions=True, seed=1)
    observations = env.reset()
    start = time.process_time()
    for _ in range(STEPS):
        turns = [torch.where(seen, 0.75, -0.75) for seen in observations]
        observations, *_ = env.step([torch.cat([torch.full_like(turn, 0.15), turn], dim=1) for turn in turns])
    elapsed = time.process_time() - start
    print(f"VMAS {version('vmas')} (PyTorch {torch.__version__.split('+')[0]}); {WORLDS} worlds at once,"
          f"{ROBOTS},{STEPS * WORLDS * ROBOTS},{elapsed:.4f}")


if __name__ == "__main__":
    main()
