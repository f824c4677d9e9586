"""Holds Cohen's kappa and its interval against statsmodels and scipy."""

import json
import math
import sys

import numpy
from scipy.stats import binomtest
from statsmodels.stats.inter_rater import cohens_kappa

with open(sys.argv[1], encoding="utf-8") as file:
    cases = json.load(file)


def near(found, expected):
    assert math.isclose(found, expected, rel_tol=1e-9, abs_tol=1e-12), (found, expected)


n_large = 0
for case in cases:
    table = numpy.array(case["table"], dtype=float)
    agreement = case["agreement"]
    theirs = cohens_kappa(table)
    n, n_same = int(table.sum()), int(numpy.diag(table).sum())
    near(agreement["kappa"], theirs.kappa)
    exact = binomtest(n_same, n).proportion_ci(0.95, "exact")
    near(agreement["share_interval"]["low"], exact.low)
    near(agreement["share_interval"]["high"], exact.high)
    n_used = int(((table.sum(axis=0) + table.sum(axis=1)) > 0).sum())
    if n < 2 * n_used**2 or n_same in (0, n):
        chance = float(table.sum(axis=0) @ table.sum(axis=1)) / n**2
        near(agreement["share_by_chance"], chance)
        for bound in ("low", "high"):
            kappa = (getattr(exact, bound) - chance) / (1.0 - chance)
            near(agreement["kappa_interval"][bound], max(-1.0, kappa))
    else:
        n_large += 1
        near(agreement["kappa_interval"]["low"], max(-1.0, theirs.kappa_low))
        near(agreement["kappa_interval"]["high"], min(1.0, theirs.kappa_upp))

assert n_large > 20, n_large
print(f"{len(cases)} cases agree")
