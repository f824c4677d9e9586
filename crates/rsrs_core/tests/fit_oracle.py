"""Checks fits against scipy and statsmodels; prints how many cases agree, or fails.

Closed forms agree to 1e-9, iterative fits to 1e-6, both relative.
"""

import json
import sys
import warnings

import numpy as np
import pandas as pd
import statsmodels.formula.api as smf
from scipy import stats
from scipy.optimize import brentq
from statsmodels.regression.mixed_linear_model import MixedLMParams
from statsmodels.stats.proportion import proportion_confint

CLOSED = 1e-9
ITERATIVE = 1e-6


def near(found, expected, tolerance, what):
    scale = max(abs(expected), 1e-12)
    assert abs(found - expected) <= tolerance * scale, f"{what}: {found}, expected {expected}"


def check_robots(frame, report):
    for row in report["speed"]:
        robot = int(row["robot"].split("_")[1])
        own = frame[(frame.robot == robot) & (frame.command == row["commanded_m_s"])]
        gains, speeds = own.gain, own.speed
        near(row["mean_m_s"], speeds.mean(), CLOSED, "mean speed")
        near(row["gain"], gains.mean(), CLOSED, "gain")
        if len(own) < 2:
            assert row["gain_low"] is None and row["sd_m_s"] is None
            continue
        near(row["sd_m_s"], speeds.std(ddof=1), CLOSED, "sd of speeds")
        low, high = stats.t.interval(0.95, len(own) - 1, gains.mean(), stats.sem(gains))
        near(row["gain_low"], low, CLOSED, "gain_low")
        near(row["gain_high"], high, CLOSED, "gain_high")


def within(frame):
    model = smf.ols("gain ~ C(cell)", frame).fit()
    return model, model.ssr / model.df_resid, model.df_resid


def check_trial_sd(frame, details):
    model, square, df = within(frame)
    sd = details["speed"]["trial_sd"]
    near(sd["value"], np.sqrt(square), CLOSED, "trial sd")
    near(sd["low"], np.sqrt(df * square / stats.chi2.ppf(0.975, df)), CLOSED, "trial sd, low")
    near(sd["high"], np.sqrt(df * square / stats.chi2.ppf(0.025, df)), CLOSED, "trial sd, high")
    p_values = model.outlier_test(method="bonferroni").iloc[:, 2]
    expected = {int(frame.line[index]): p for index, p in p_values.items() if p < 0.05}
    found = {row["line"]: row["p_value"] for row in details["speed"]["outliers"]}
    assert found.keys() == expected.keys() and 2 in found, (found, expected)
    for line, p in found.items():
        near(p, expected[line], ITERATIVE, "outlier")


def interval(terms):
    """Ting, Burdick, Graybill, Jeyaratnam and Lu (1990), term by term."""
    alpha, infinite = 0.025, np.inf
    F = lambda tail, n, m: stats.chi2.isf(tail, n) / n if m == infinite else stats.f.isf(tail, n, m)
    G = lambda n: 1 - 1 / F(alpha, n, infinite)
    H = lambda n: 1 / F(1 - alpha, n, infinite) - 1
    value = sum(weight * square for weight, square, _ in terms)
    lower = upper = 0.0
    added = [term for term in terms if term[0] > 0]
    taken = [term for term in terms if term[0] < 0]
    for c, s, n in added:
        lower += (G(n) * c * s) ** 2
        upper += (H(n) * c * s) ** 2
    for c, s, n in taken:
        lower += (H(n) * c * s) ** 2
        upper += (G(n) * c * s) ** 2
    for c, s, n in added:
        for d, t, m in taken:
            f = F(alpha, n, m)
            lower += ((f - 1) ** 2 - (G(n) * f) ** 2 - H(m) ** 2) / f * c * s * -d * t
            f = F(1 - alpha, n, m)
            upper += ((1 - f) ** 2 - (H(n) * f) ** 2 - G(m) ** 2) / f * c * s * -d * t
    for one in range(len(added)):
        for other in range(one + 1, len(added)):
            (c, s, n), (d, t, m) = added[one], added[other]
            both = (1 - 1 / F(alpha, n + m, infinite)) ** 2 * (n + m) ** 2 / (n * m)
            star = (both - G(n) ** 2 * n / m - G(m) ** 2 * m / n) / (len(added) - 1)
            lower += star * c * s * d * t
    low = value - np.sqrt(max(lower, 0))
    return max(value, 0), max(low, 0), value + np.sqrt(max(upper, 0))


def check_robot_sd(frame, details):
    means = frame.groupby(["robot", "command"]).gain.mean().unstack()
    robots, commands = means.shape
    overall = means.mean(axis=1)
    square = commands * overall.var(ddof=1)
    terms = [(1 / commands, square, robots - 1)]
    if commands > 1:
        rest = means.sub(overall, axis=0).sub(means.mean(axis=0), axis=1) + overall.mean()
        df = (robots - 1) * (commands - 1)
        terms.append((1 - 1 / commands, (rest**2).to_numpy().sum() / df, df))
    _, square, df = within(frame)
    share = (1 / frame.groupby(["robot", "command"]).gain.count()).mean()
    terms.append((-share, square, df))
    sd = details["speed"]["robot_sd"]
    for key, expected in zip(["value", "low", "high"], interval(terms)):
        near(sd[key], np.sqrt(expected), CLOSED, f"robot sd, {key}")


def check_likelihood(frame, details):
    """Iterative: two independent maxima of the restricted likelihood, to 1e-6."""
    found = details["speed"]["likelihood"]
    for name, (alike, rest) in [("scipy", dense_reml(frame)), ("statsmodels", mixed_model(frame))]:
        near(found["alike_sd"], np.sqrt(alike), ITERATIVE, f"REML of {name}, robots")
        near(found["rest_sd"], np.sqrt(rest), ITERATIVE, f"REML of {name}, rest")
    sizes = frame.cell.value_counts()
    if frame.command.nunique() == 1 and sizes.nunique() == 1:
        # For balanced data the analysis of variance is the restricted maximum likelihood.
        speed = details["speed"]
        near(speed["robot_sd"]["value"], found["alike_sd"], CLOSED, "closed form, robots")
        near(speed["trial_sd"]["value"], found["rest_sd"], CLOSED, "closed form, rest")


def dense_reml(frame):
    """The likelihood's slope in whole matrices, and its root by scipy."""
    gains = frame.gain.to_numpy()
    means = pd.get_dummies(frame.command).to_numpy(float)
    robots = pd.get_dummies(frame.robot).to_numpy(float)
    shared = robots @ robots.T
    df = len(gains) - means.shape[1]

    def projection(ratio):
        inverse = np.linalg.inv(np.eye(len(gains)) + ratio * shared)
        fixed = inverse @ means
        return inverse - fixed @ np.linalg.solve(means.T @ fixed, fixed.T)

    def slope(ratio):
        weights = projection(ratio)
        away = weights @ gains
        return df * (away @ shared @ away) / (gains @ away) - np.trace(weights @ shared)

    if slope(0.0) <= 0.0:
        ratio = 0.0
    else:
        ratio = brentq(slope, 0.0, 1e6, xtol=1e-13, rtol=1e-13)
    rest = gains @ projection(ratio) @ gains / df
    return ratio * rest, rest


def mixed_model(frame):
    """The maximum of MixedLM's own likelihood.

    Its optimisers stop anywhere from 1e-4 to 1e-12 of it, so scipy goes on to the root of its score.
    """
    formula = "gain ~ C(command)" if frame.command.nunique() > 1 else "gain ~ 1"
    model = smf.mixedlm(formula, frame, groups="robot")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fitted = model.fit(reml=True, gtol=1e-12)
    start = fitted.cov_re.iloc[0, 0] / fitted.scale

    def score(ratio):
        at = MixedLMParams.from_components(fitted.fe_params.to_numpy(), np.array([[ratio]]))
        return model.score(at, profile_fe=True)[-1]

    if start < 1e-6:
        return 0.0, fitted.scale
    ratio = brentq(score, start / 2, start * 2, xtol=1e-13, rtol=1e-13)
    at = MixedLMParams.from_components(fitted.fe_params.to_numpy(), np.array([[ratio]]))
    fixed, _ = model.get_fe_params(at.cov_re, at.vcomp)
    groups = frame.groupby("robot").indices.values()
    away = frame.gain.to_numpy() - model.exog @ fixed
    squares = sum(
        (away[rows] ** 2).sum() - ratio / (1 + ratio * len(rows)) * away[rows].sum() ** 2
        for rows in groups
    )
    rest = squares / (len(away) - len(fixed))
    return ratio * rest, rest


def check_rates(report, details):
    sensor = report["sensor"]
    for name in ["true_positive", "false_positive"]:
        rate = details["sensor"][name]
        low, high = proportion_confint(rate["detections"], rate["samples"], method="beta")
        near(sensor[name], rate["detections"] / rate["samples"], CLOSED, name)
        near(sensor[f"{name}_low"], low, CLOSED, f"{name}_low")
        near(sensor[f"{name}_high"], high, CLOSED, f"{name}_high")


def check_period(periods, details):
    frame = pd.DataFrame(periods, columns=["robot", "period"])
    means = frame.groupby("robot").period.mean()
    low, high = stats.t.interval(0.95, len(means) - 1, means.mean(), stats.sem(means))
    found = details["period"]["period_s"]
    near(found["value"], means.mean(), CLOSED, "period")
    near(found["low"], low, CLOSED, "period, low")
    near(found["high"], high, CLOSED, "period, high")


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        cases = json.load(file)
    for case in cases:
        frame = pd.DataFrame(case["trials"]).rename(
            columns={"commanded_m_s": "command", "speed_m_s": "speed"}
        )
        frame["gain"] = frame.speed / frame.command
        frame["cell"] = frame.robot.astype(str) + "@" + frame.command.astype(str)
        check_robots(frame, case["report"])
        check_trial_sd(frame, case["details"])
        check_robot_sd(frame, case["details"])
        check_likelihood(frame, case["details"])
        check_rates(case["report"], case["details"])
        check_period(case["periods"], case["details"])
    print(f"{len(cases)} cases agree")


main()
