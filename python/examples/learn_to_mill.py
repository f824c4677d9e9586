"""CMA-ES learns to mill from one bit, in the vector environment of rsrs.

A controller is four numbers: speed and turning rate where nothing is detected, and where something is. All
candidates of a generation drive side by side, each in as many swarms; their fitness is the sum of the
environment's rewards. The picture shows how many swarms of the search's mean mill at the end of their episode,
beside those of the paper's controller.

    pip install cma matplotlib gymnasium pettingzoo
    python python/examples/learn_to_mill.py --picture learning.png
"""

import argparse
from pathlib import Path

import cma
import numpy as np

import rsrs

FLOCKBOT = Path(__file__).parents[2] / "launch_configs" / "profiles" / "flockbot.yaml"
PAPER = np.array([[0.15, -0.75], [0.15, 0.75]])


def driven(environment, controllers, seed):
    """The sum of rewards and the share of swarms that mill at the end, of each controller.

    `controllers` are of shape (C, 2, 2): with nothing detected and with something, speed and turning rate.
    """
    swarm_of = np.repeat(np.arange(len(controllers)), environment.num_envs // len(controllers))
    observations, _ = environment.reset(seed=seed)
    total, is_over = np.zeros(environment.num_envs), False
    while not is_over:
        actions = controllers[swarm_of[:, None], observations]
        observations, rewards, _, truncated, _ = environment.step(actions)
        total += rewards
        is_over = truncated.all()
    mills = environment.worlds.margin() > 0
    return total.reshape(len(controllers), -1).mean(axis=1), mills.reshape(len(controllers), -1).mean(axis=1)


def learnt(conditions, *, generations, population, swarms, duration_s, seed):
    """The controller that is learnt, and how many swarms mill by the search's mean and by the paper's, (G, 2)."""
    environment = rsrs.vector_env(
        conditions, (population + 2) * swarms, duration_s=duration_s, reward_every=50
    )
    low, high = np.array(environment.worlds.command_range).T

    def controllers(points):
        return low + (high - low) * np.reshape(points, (-1, 2, 2))

    # It begins with robots that drive straight on, whatever they detect.
    search = cma.CMAEvolutionStrategy(
        4 * [0.5], 0.2, {"bounds": [0, 1], "popsize": population, "seed": seed, "verbose": -9}
    )
    shares = []
    for generation in range(generations):
        points = search.ask()
        candidates = controllers([*points, search.result.xfavorite])
        returns, mills = driven(environment, np.concatenate([candidates, [PAPER]]), seed + generation)
        search.tell(points, -returns[:population])
        shares.append(mills[population:])
        print(f"generation {generation + 1}: return {returns[-2]:.2f}, {mills[-2]:.0%} of {swarms} swarms mill")
    return controllers(search.result.xfavorite)[0], np.array(shares)


def share_that_mills(conditions, controller, episodes, seed):
    """How many episodes of 300 s the judge finds in stable milling, on seeds that nobody learnt from."""
    phases = [
        rsrs.episode(
            conditions, seed=seed, replicate=replicate, controller=lambda seen: controller[seen.astype(int)]
        ).judge().phase
        for replicate in range(episodes)
    ]
    return phases.count("stable_milling") / episodes


def draw(shares, path):
    """The curve of learning, and the paper's controller on the same draws."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot
    from matplotlib.ticker import MaxNLocator, PercentFormatter

    figure, axes = pyplot.subplots(figsize=(7, 3.5), layout="constrained")
    generations = range(1, len(shares) + 1)
    axes.plot(generations, shares[:, 1], color="#333333", linestyle=":", label="the paper's controller")
    axes.plot(generations, shares[:, 0], color="#0072b2", marker=".", label="learnt from the detection bit")
    axes.set(xlabel="generation", ylabel="swarms that mill", ylim=(-0.02, 1.02))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.yaxis.set_major_formatter(PercentFormatter(1))
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="lower right")
    figure.savefig(path, dpi=120)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--generations", type=int, default=30, help="(default: 30)")
    parser.add_argument("--population", type=int, default=16, help="controllers in a generation (default: 16)")
    parser.add_argument("--swarms", type=int, default=64, help="swarms for each controller (default: 64)")
    parser.add_argument("--duration", type=float, default=120, help="seconds of an episode (default: 120)")
    parser.add_argument("--episodes", type=int, default=100, help="episodes at the end (default: 100)")
    parser.add_argument("--seed", type=int, default=1, help="(default: 1)")
    parser.add_argument("--picture", type=Path, help="file of the curve")
    given = parser.parse_args()

    conditions = rsrs.Conditions(
        FLOCKBOT, robots=9, speed_m_s=0.15, turn_rate_rad_s=0.75, placement_radius_m=0.825
    )
    controller, shares = learnt(
        conditions,
        generations=given.generations,
        population=given.population,
        swarms=given.swarms,
        duration_s=given.duration,
        seed=given.seed,
    )
    for (speed_m_s, turn_rate_rad_s), name in zip(controller, ["nothing", "something"]):
        print(f"where {name} is detected: {speed_m_s:.3f} m/s, {turn_rate_rad_s:.2f} rad/s")
    fresh = given.seed + 1_000_000
    found, paper = (share_that_mills(conditions, of, given.episodes, fresh) for of in (controller, PAPER))
    print(f"stable milling in {found:.0%} of {given.episodes} fresh episodes, the paper's controller in {paper:.0%}")
    if given.picture:
        draw(shares, given.picture)


if __name__ == "__main__":
    main()
