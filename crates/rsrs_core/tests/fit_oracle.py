"""Checks fits against scipy and statsmodels; prints how many cases agree, or fails.

Closed forms agree to 1e-9, iterative fits to 1e-6, both relative.
"""

import json
import sys

import numpy as np
import pandas as pd
import statsmodels.formula.api as smf
from scipy import stats
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


def check_mixed_model(frame, details):
    """For balanced data the analysis of variance is the restricted maximum likelihood."""
    model = smf.mixedlm("gain ~ 1", frame, groups="robot").fit(reml=True, gtol=1e-12)
    speed = details["speed"]
    # Its optimiser stops at about 1e-4 of the variances.
    near(speed["robot_sd"]["value"] ** 2, model.cov_re.iloc[0, 0], 1e-3, "REML, robots")
    near(speed["trial_sd"]["value"] ** 2, model.scale, 1e-3, "REML, trials")
    near(speed["by_command"][0]["gain"]["value"], model.params["Intercept"], ITERATIVE, "REML, mean")
    # At our estimates the likelihood is flat and not lower: they are its maximum to 1e-6.
    assert reml(frame, speed["robot_sd"]["value"], speed["trial_sd"]["value"]) >= model.llf - ITERATIVE


def reml(frame, robot_sd, trial_sd):
    """The restricted log-likelihood of a balanced one-way layout."""
    groups = [group.to_numpy() for _, group in frame.groupby("robot").gain]
    size, number = len(groups[0]), sum(len(group) for group in groups)
    means = np.array([group.mean() for group in groups])
    inside = sum(((group - group.mean()) ** 2).sum() for group in groups)
    total = trial_sd**2 + size * robot_sd**2
    between = size * ((means - means.mean()) ** 2).sum()
    return -0.5 * (
        (number - 1) * np.log(2 * np.pi)
        + (number - len(groups)) * np.log(trial_sd**2)
        + (len(groups) - 1) * np.log(total)
        + inside / trial_sd**2
        + between / total
        + np.log(number)
    )


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
        if frame.command.nunique() == 1 and frame.cell.value_counts().nunique() == 1:
            check_mixed_model(frame, case["details"])
        check_rates(case["report"], case["details"])
        check_period(case["periods"], case["details"])
    print(f"{len(cases)} cases agree")


main()
