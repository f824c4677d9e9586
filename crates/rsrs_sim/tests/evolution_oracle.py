"""How many samples the package `cma` needs for what is asked, the median over seeds, as JSON."""

import json
import statistics
import sys

import cma
import numpy


def sphere(point):
    return float(numpy.sum(point**2))


def ellipsoid(point):
    stretched = 1e6 ** (numpy.arange(len(point)) / (len(point) - 1))
    return float(numpy.sum(stretched * point**2))


def rosenbrock(point):
    return float(numpy.sum(100 * (point[:-1] ** 2 - point[1:]) ** 2 + (point[:-1] - 1) ** 2))


FUNCTIONS = {"sphere": sphere, "ellipsoid": ellipsoid, "rosenbrock": rosenbrock}


def samples(cost, asked, seed):
    options = {
        "seed": seed,
        "popsize": asked["population"],
        # The strategy of the tutorial, without the later negative weights.
        "CMA_active": False,
        "verbose": -9,
        "maxfevals": asked["most_samples"],
        "tolfun": 0,
        "tolx": 0,
        "tolfunhist": 0,
        "tolstagnation": asked["most_samples"],
    }
    strategy = cma.CMAEvolutionStrategy([asked["start"]] * asked["n"], asked["step"], options)
    n_samples = 0
    while n_samples < asked["most_samples"]:
        points = strategy.ask()
        costs = [cost(numpy.asarray(point)) for point in points]
        hits = [index for index, found in enumerate(costs) if found < asked["target"]]
        if hits:
            return n_samples + hits[0] + 1
        n_samples += len(points)
        strategy.tell(points, costs)
    return asked["most_samples"]


asked = json.loads(sys.argv[1])
medians = {
    name: statistics.median_low(
        samples(FUNCTIONS[name], asked, seed) for seed in range(1, asked["seeds"] + 1)
    )
    for name in asked["functions"]
}
print(json.dumps(medians))
