"""Recomputes the evidence of comparisons from their JSON, by the formulas and constants of docs/verdicts.md."""

import json
import sys

import numpy as np
from scipy import optimize, special, stats

DIVISORS = [2**0.5, 2, 4, 8, 16, 32, 64, 128, 256]
BETS = [(0.15, 0.1), (0.35, 0.1), (0.6, 0.2), (0.8, 0.3), (1.0, 0.3)]
STAKES = [(0.0, 0.1), (0.125, 0.35), (1.0, 0.45), (4.0, 0.1)]


def near(found, expected, what):
    # What a search may have left is taken off: evidence is never stated too great.
    assert 0.99 * expected <= found <= (1 + 1e-4) * expected + 1e-12, (what, found, expected)


class Cells:
    """The runs of some cells, of which each number is an array."""

    def __init__(self, cells):
        column = lambda key: np.array([cell[key] for cell in cells], dtype=float)
        self.n, self.m, self.part = column("n_real"), column("n_simulated"), column("part")
        self.hits = np.round(column("b_r") * self.n)
        self.simulated_hits = np.round(column("b_s") * self.m)
        self.shown = (self.simulated_hits + 0.5) / (self.m + 1)

    def staked(self, stake, b):
        """The logarithm of what becomes of a stake on the simulated runs."""
        theta = np.clip(stake, -5 * np.sqrt(self.m), 5 * np.sqrt(self.m))
        return lambda part: theta * part / self.m * self.simulated_hits - self.m * np.log1p(
            b * np.expm1(theta * part / self.m)
        )

    def least(self, capital):
        """The logarithm of the least capital, whatever the shares are; `capital` gives that of each bet."""
        log = lambda b: special.logsumexp(capital(np.clip(b, 0, 1)))
        bounds = [(1e-9, 1 - 1e-9)] * len(self.n)
        ends = []
        for start in (self.shown, np.full(len(self.n), 0.5)):
            end = optimize.minimize(log, start, bounds=bounds, options={"ftol": 1e-15, "gtol": 1e-9})
            ends.append(end.fun)
            if len(self.n) == 1:
                ends.append(optimize.minimize_scalar(log, bounds=(0, 1), options={"xatol": 1e-12}).fun)
        return min(ends)

    def worse(self):
        def capital(b):
            return [
                np.log(part / len(DIVISORS))
                + np.sum(
                    (self.n - self.hits) * np.log(f)
                    - self.n * np.log(b + f * (1 - b))
                    + self.staked(10 + 25 / np.log(f), b)(stake)
                )
                for f in DIVISORS
                for stake, part in STAKES
            ]

        return np.exp(self.least(capital))

    def won(self, bet, margin):
        r = np.maximum(self.shown - margin, 0)
        return special.xlog1py(self.hits, bet * (1 - r)) + special.xlog1py(self.n - self.hits, -bet * r)

    def as_good(self, margin, further=0.0):
        def capital(b):
            return [
                np.log(part * whole)
                + np.sum(
                    self.won(bet / (1 - margin), margin)
                    - bet / (1 - margin) * self.n * (b - self.shown - further)
                    + self.staked(-20 / (bet / (1 - margin)), b)(stake)
                )
                for bet, whole in BETS
                for stake, part in STAKES
            ]

        return np.exp(self.least(capital))

    def share(self, margin):
        """What the average of `B_r` is at least."""

        def log_e(share):
            above = share - np.sum(self.n * (self.shown - margin)) / self.n.sum()
            return special.logsumexp(
                [
                    np.log(whole)
                    + self.won(bet / (1 - margin), margin).sum()
                    - bet / (1 - margin) * self.n.sum() * above
                    for bet, whole in BETS
                ]
            )

        excluded = lambda share: log_e(share) - np.log(20)
        if excluded(0) < 0:
            return 0
        return 1 if excluded(1) > 0 else optimize.brentq(excluded, 0, 1)


def check(case):
    cells, pooled = case["cells"], case["pooled"]
    margin = pooled["margin"]
    everything = Cells(cells)
    alone = [Cells([cell]).worse() for cell in cells]
    in_one = sum(cell["part"] * e for cell, e in zip(cells, alone))
    kept = 1 - sum(cell["part"] for cell in cells)
    near(pooled["e_violated"], (everything.worse() + in_one + kept) / 2, "e_violated")

    clopper_pearson = lambda k, m: stats.beta.ppf(0.025, k, m - k + 1) if k else 0
    claims = lambda cell: clopper_pearson(round(cell["b_s"] * cell["n_simulated"]), cell["n_simulated"]) > margin
    claimed = [cell for cell in cells if claims(cell)]
    assert pooled["n_cells_claimed"] == len(claimed), pooled
    assert pooled["n_real_claimed"] == sum(cell["n_real"] for cell in claimed), pooled
    for cell, e in zip(cells, alone):
        if "e_violated" in cell:
            near(cell["e_violated"], e, "e_violated of a cell")
            assert (cell["e_supported"] is not None) == claims(cell), cell
        if cell.get("e_supported") is not None:
            near(cell["e_supported"], Cells([cell]).as_good(margin), "e_supported of a cell")
    if not claimed:
        assert pooled["e_supported"] is pooled["b_r_at_least"] is pooled["shortfall_at_most"] is None
        return
    claimed = Cells(claimed)
    near(pooled["e_supported"], claimed.as_good(margin), "e_supported")
    assert 0 <= claimed.share(margin) - pooled["b_r_at_least"] <= 0.001001, pooled
    short = pooled["shortfall_at_most"]
    supports = lambda short: claimed.as_good(margin, short - margin) >= 20
    assert not supports(0.99) if short is None else supports(short) and not supports(short - 0.01), pooled


cases = json.load(open(sys.argv[1]))
for case in cases:
    check(case)
print(len(cases), "cases agree")
