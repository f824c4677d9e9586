"""Swarms as environments of PettingZoo and Gymnasium, which are installed beside this package.

A robot observes its binary detection, and acts by a speed and a turning rate within the limits of its
profile. By default the reward is how much nearer the swarm came to the wanted phase: the change of the least
margin of that phase's rule over the last 10 s, or what there is of them, every so many steps. Rewards of an
episode add up to the margin at its end less that after its first step.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pettingzoo  # type: ignore[import-untyped]
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from ._rsrs import Conditions, RsrsError, Sweep, Worlds

Reward = str | None | Callable[[dict[str, NDArray[np.float64]]], Any]

# So long may an episode be: a week.
MOST_DURATION_S = 604_800.0
# As long as a block of the judge.
KEEP_S = 10.0


def _conditions(given: Conditions | Sweep | str | os.PathLike[str]) -> Conditions:
    """Those of a sweep are those of its first cell."""
    if isinstance(given, Conditions):
        return given
    sweep = given if isinstance(given, Sweep) else Sweep(given)
    return sweep.conditions(sweep.cells[0])


class _Swarms:
    """Worlds with the end of their episodes and their rewards: what both kinds of environments share."""

    def __init__(
        self,
        conditions: Conditions | Sweep | str | os.PathLike[str],
        n_worlds: int,
        seed: int,
        duration_s: float,
        reward: Reward,
        reward_every: int,
    ) -> None:
        if not 0 < duration_s <= MOST_DURATION_S:
            raise RsrsError(f"duration_s is {duration_s}, expected seconds above 0, to {MOST_DURATION_S}")
        if not (reward is None or reward == "margin" or callable(reward)):
            raise RsrsError(f"reward is {reward!r}, expected 'margin', None or a function of order parameters")
        if reward_every < 1:
            raise RsrsError(f"reward_every is {reward_every}, expected at least 1")
        keep_s = 0.0 if reward is None else KEEP_S
        self.worlds = Worlds(_conditions(conditions), n_worlds, seed=seed, keep_s=keep_s)
        self.n_steps = max(1, int(duration_s / self.worlds.period_s + 1e-9))
        self.reward, self.reward_every = reward, reward_every
        self.seed, self.replicate = seed, 0
        self.margin: NDArray[np.float64] | None = None

    def reset(self, seed: int | None) -> NDArray[np.bool_]:
        """Starts anew: from the first replicates of a seed, or without one from the next."""
        if seed is None:
            self.replicate += self.worlds.n_worlds
        else:
            self.seed, self.replicate = seed, 0
        self.margin = None
        return self.worlds.reset(seed=self.seed, replicate=self.replicate)

    def step(self, commands: NDArray[Any]) -> tuple[NDArray[np.bool_], NDArray[np.float64], bool]:
        """What is detected then, the rewards of the worlds, and whether the episodes are over."""
        detections = self.worlds.step(commands)
        return detections, self._rewards(), self.worlds.step_index >= self.n_steps

    def _rewards(self) -> NDArray[np.float64]:
        nothing = np.zeros(self.worlds.n_worlds)
        step = self.worlds.step_index
        # What rewards begin from is looked at before commands have changed much: a swarm that got lost first
        # would be rewarded for coming back.
        is_first = step == 1 and self.reward == "margin"
        if self.reward is None or (step % self.reward_every and not is_first):
            return nothing
        if callable(self.reward):
            return np.broadcast_to(np.asarray(self.reward(self.worlds.order()), float), nothing.shape)
        before, self.margin = self.margin, self.worlds.margin()
        return nothing if before is None else self.margin - before

    def action_space(self, n_robots: int | None = None) -> gymnasium.spaces.Box:
        """Speed and turning rate of one robot, or of each of so many."""
        low, high = np.array(self.worlds.command_range, np.float32).T
        if n_robots is not None:
            low, high = np.tile(low, (n_robots, 1)), np.tile(high, (n_robots, 1))
        return gymnasium.spaces.Box(low, high, dtype=np.float32)


class SwarmVectorEnv(VectorEnv[Any, Any, Any]):
    """Swarms side by side, each an environment of Gymnasium; see :func:`vector_env`."""

    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": []}

    def __init__(self, swarms: _Swarms) -> None:
        self._swarms, self._is_over = swarms, False
        worlds = swarms.worlds
        self.num_envs = worlds.n_worlds
        self.single_observation_space = gymnasium.spaces.MultiBinary(worlds.n_robots)
        self.single_action_space = swarms.action_space(worlds.n_robots)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)

    @property
    def worlds(self) -> Worlds:
        """The worlds: their poses and order parameters."""
        return self._swarms.worlds

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.int8], dict[str, Any]]:
        """Places all swarms anew; with one seed for all of them."""
        if isinstance(seed, list):
            raise RsrsError("the swarms have one seed together, which each draws from by its number")
        self._is_over = False
        return self._swarms.reset(seed).view(np.int8), {}

    def step(
        self, actions: NDArray[Any]
    ) -> tuple[NDArray[np.int8], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """One control period of all swarms; their episodes end together, and the next step starts anew."""
        none = np.zeros(self.num_envs, bool)
        if self._is_over:
            observations, _ = self.reset()
            return observations, np.zeros(self.num_envs), none, none.copy(), {}
        detections, rewards, self._is_over = self._swarms.step(actions)
        return detections.view(np.int8), rewards, none, np.full(self.num_envs, self._is_over), {}


class SwarmParallelEnv(pettingzoo.ParallelEnv[str, Any, Any]):  # type: ignore[misc]
    """One swarm, each of whose robots is an agent of PettingZoo; see :func:`parallel_env`."""

    metadata: dict[str, Any] = {"name": "rsrs_swarm", "render_modes": []}

    def __init__(self, swarms: _Swarms) -> None:
        self._swarms = swarms
        self.possible_agents = [f"robot_{robot + 1}" for robot in range(swarms.worlds.n_robots)]
        self.agents: list[str] = []
        self.render_mode = None
        self._observations = {agent: gymnasium.spaces.MultiBinary(1) for agent in self.possible_agents}
        self._actions = {agent: swarms.action_space() for agent in self.possible_agents}

    @property
    def worlds(self) -> Worlds:
        """The world: its poses and order parameters."""
        return self._swarms.worlds

    def observation_space(self, agent: str) -> gymnasium.spaces.MultiBinary:
        """Whether the robot detects something."""
        return self._observations[agent]

    def action_space(self, agent: str) -> gymnasium.spaces.Box:
        """Speed in metres per second and turning rate in radians per second."""
        return self._actions[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.int8]], dict[str, dict[str, Any]]]:
        """Places the swarm anew."""
        self.agents = list(self.possible_agents)
        return self._seen(self._swarms.reset(seed)), {agent: {} for agent in self.agents}

    def step(self, actions: dict[str, NDArray[Any]]) -> tuple[
        dict[str, NDArray[np.int8]],
        dict[str, float],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """One control period; all robots have the same reward, and the episode of all ends at once."""
        agents = self.agents
        if not agents:
            return {}, {}, {}, {}, {}
        commands = np.array([[actions[agent] for agent in agents]], float)
        detections, rewards, is_over = self._swarms.step(commands)
        if is_over:
            self.agents = []
        return (
            self._seen(detections),
            dict.fromkeys(agents, float(rewards[0])),
            dict.fromkeys(agents, False),
            dict.fromkeys(agents, is_over),
            {agent: {} for agent in agents},
        )

    def _seen(self, detections: NDArray[np.bool_]) -> dict[str, NDArray[np.int8]]:
        row = detections[0].view(np.int8)
        return {agent: row[robot : robot + 1] for robot, agent in enumerate(self.possible_agents)}


def vector_env(
    conditions: Conditions | Sweep | str | os.PathLike[str],
    worlds: int = 4096,
    *,
    seed: int = 1,
    duration_s: float = 300.0,
    reward: Reward = "margin",
    reward_every: int = 10,
) -> SwarmVectorEnv:
    """Swarms side by side as a vector environment of Gymnasium.

    Parameters
    ----------
    conditions
        What runs depend on; of a sweep, or the path of its file, the first cell. Its controller does not
        count.
    worlds
        How many swarms.
    seed
        Seed of the draws, below 2^63; `reset` without a seed goes on with the next replicates.
    duration_s
        Simulated time of an episode, in seconds, at whose end it is truncated.
    reward
        "margin", None for none, or a function that is given the order parameters of the last 10 s, arrays of
        shape (W,) by name, and returns a reward for each swarm.
    reward_every
        Every how many steps there is one; looking at the past takes longer than a step.
    """
    return SwarmVectorEnv(_Swarms(conditions, worlds, seed, duration_s, reward, reward_every))


def parallel_env(
    conditions: Conditions | Sweep | str | os.PathLike[str],
    *,
    seed: int = 1,
    duration_s: float = 300.0,
    reward: Reward = "margin",
    reward_every: int = 10,
) -> SwarmParallelEnv:
    """One swarm as a parallel environment of PettingZoo; parameters are as for :func:`vector_env`."""
    return SwarmParallelEnv(_Swarms(conditions, 1, seed, duration_s, reward, reward_every))
