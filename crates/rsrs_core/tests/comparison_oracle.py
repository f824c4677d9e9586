"""Checks the evidence of comparisons against adaptive quadrature and scipy's distributions."""

import json
import math
import sys

import numpy as np
from scipy import integrate, stats

ODDS = [math.sqrt(2), 2, 4, 8, 16, 32, 64, 256]
BETS = [(0.15, 0.1), (0.35, 0.1), (0.6, 0.2), (0.8, 0.3), (1.0, 0.3)]


def near(found, expected, what):
    # Where the margin meets the simulated share there is a kink, which panels see less finely.
    assert abs(found - expected) <= 1e-3 * max(abs(expected), 1e-9), (what, found, expected)


def mean(simulated, of):
    """The expectation over what the simulated runs leave open, with a uniform prior."""
    hits, n = simulated
    posterior = stats.beta(hits + 1, n - hits + 1)
    edges = np.linspace(posterior.ppf(1e-17), posterior.isf(1e-17), 9)
    panels = zip(edges[:-1], edges[1:])
    options = {"epsabs": 0, "epsrel": 1e-8, "limit": 400}
    return sum(
        integrate.quad(lambda p: posterior.pdf(p) * of(p), *panel, **options)[0]
        for panel in panels
    )


def less(real, simulated):
    hits, n = real
    equal = mean(simulated, lambda p: p**hits * (1 - p) ** (n - hits))

    def ratio(factor):
        def worse(p):
            odds = p / (1 - p) / factor
            return (odds / (1 + odds)) ** hits * (1 / (1 + odds)) ** (n - hits)

        return mean(simulated, worse) / equal

    return np.array([ratio(factor) for factor in ODDS])


def at_least(real, simulated, margin):
    hits, n = real

    def short(p):
        share = max(p - margin, 0.005)
        return share**hits * (1 - share) ** (n - hits)

    whole = mean(simulated, short)

    def won(bet):
        def capital(share):
            p = max(share, margin)
            return (1 + bet * (1 - p + margin)) ** hits * (1 - bet * (p - margin)) ** (n - hits)

        return mean(simulated, lambda p: short(p) * capital(p)) / whole

    return np.array([won(part / (1 - margin)) for part, _ in BETS])


def check(case):
    cells, margin = case["cells"], case["margin"]
    lesses = np.array([less(real, simulated) for real, simulated in cells])
    together = lesses.prod(axis=0).mean()
    near(case["pooled"]["e_violated"], (together + lesses.mean()) / 2, "e_violated")

    wons = np.array([at_least(real, simulated, margin) for real, simulated in cells])
    n = sum(real[1] for real, _ in cells)
    weights = np.array([real[1] / n for real, _ in cells])
    posteriors = [stats.beta(hits + 1, of - hits + 1) for _, (hits, of) in cells]
    centre = sum(w * p.mean() for w, p in zip(weights, posteriors))
    spread = sum(w**2 * p.var() for w, p in zip(weights, posteriors))
    size = centre * (1 - centre) / spread - 1
    above = stats.beta.sf(margin, centre * size, (1 - centre) * size)
    capital = np.array([part for _, part in BETS]) @ wons.prod(axis=0)
    near(case["pooled"]["e_supported"], capital / max(above, 1e-12), "e_supported")

    mills = np.array([1.0])
    for (_, of), (hits, n_simulated) in cells:
        law = stats.betabinom(of, hits + 1, n_simulated - hits + 1)
        mills = np.convolve(mills, law.pmf(np.arange(of + 1)))
    seen = sum(real[0] for real, _ in cells)
    near(case["pooled"]["p_value"], mills[: seen + 1].sum(), "p_value")


cases = json.load(open(sys.argv[1]))
for case in cases:
    check(case)
print(len(cases), "cases agree")
