"""What predictions are worth: how often they are bounds, how far off they are, and whether they rank cells."""

import math

PREDICTORS = {
    "as_measured": "as measured",
    "harsher": "harsher",
    "pseudo_mean": "pseudo-realities, mean",
    "pseudo_worst_tenth": "pseudo-realities, worst tenth",
}
ERROR = 0.05


def at_most(k, n, p):
    """The chance of k hits or fewer in n runs that each hit with chance p."""
    return math.fsum(math.comb(n, hits) * p**hits * (1 - p) ** (n - hits) for hits in range(k + 1))


def interval(k, n):
    """Clopper and Pearson's 95 % interval of a share."""

    def solve(is_too_small):
        low, high = 0.0, 1.0
        for _ in range(50):
            middle = (low + high) / 2
            low, high = (middle, high) if is_too_small(middle) else (low, middle)
        return low

    low = 0.0 if k == 0 else solve(lambda p: 1 - at_most(k - 1, n, p) < ERROR / 2)
    high = 1.0 if k == n else solve(lambda p: at_most(k, n, p) > ERROR / 2)
    return low, high


def fisher(k, n, other_k, other_n):
    """Fisher's exact test, two-sided: the chance of counts at least as unlikely as these, if both shares were equal."""
    hits = k + other_k
    ways = lambda k: math.comb(n, k) * math.comb(other_n, hits - k)
    every = [ways(it) for it in range(max(0, hits - other_n), min(n, hits) + 1)]
    return sum(it for it in every if it <= ways(k)) / sum(every)


def kendall_tau_b(one, other):
    """Kendall's rank correlation, corrected for ties; None where all of one are alike."""
    pairs = [(i, j) for i in range(len(one)) for j in range(i)]
    sign = lambda values, i, j: (values[i] > values[j]) - (values[i] < values[j])
    both = [(sign(one, i, j), sign(other, i, j)) for i, j in pairs]
    scale = math.sqrt(sum(a != 0 for a, _ in both) * sum(b != 0 for _, b in both))
    return sum(a * b for a, b in both) / scale if scale else None


def evaluate(floor):
    """What each predictor comes to on a floor, by its key."""
    cells = floor["cells"]
    shares = [cell["n_mills"] / cell["n_runs"] for cell in cells]
    found = {}
    for key in PREDICTORS:
        predicted = [cell[key] for cell in cells]
        gaps = [share - p for share, p in zip(shares, predicted)]
        below = [at_most(cell["n_mills"], cell["n_runs"], cell[key]) for cell in cells]
        above = [1 - at_most(cell["n_mills"] - 1, cell["n_runs"], cell[key]) for cell in cells]
        # Of a share by as many runs, with half a run of each kind added, so that none is taken for certain.
        smooth = [(cell["n_mills"] + 0.5) / (cell["n_runs"] + 1) for cell in cells]
        variance = sum(b * (1 - b) / cell["n_runs"] for b, cell in zip(smooth, cells)) / len(cells) ** 2
        found[key] = {
            "n_at_least": sum(gap >= 0 for gap in gaps),
            "n_below": sum(p <= ERROR / len(cells) for p in below),
            "n_above": sum(p <= ERROR / len(cells) for p in above),
            "gap": sum(gaps) / len(gaps),
            "gap_error": 1.96 * math.sqrt(variance),
            "absolute_gap": sum(map(abs, gaps)) / len(gaps),
            "tau": kendall_tau_b(predicted, shares),
        }
    return found


def tables(results):
    """The tables of the page: all predictors of all floors, and then each floor cell by cell."""
    lines = [
        "| floor | runs of each cell | simulated runs of each cell and world | drives of other robots within reach |",
        "|---|---|---|---|",
    ]
    for floor in results["floors"]:
        lines.append(
            f"| {floor['name']} | {floor['cells'][0]['n_runs']} | {floor['n_simulated']} "
            f"| {floor['n_drives_within_reach']} of {floor['n_drives']}, p = {floor['p_value']:.2f} |"
        )
    lines += [
        "",
        "| floor | prediction | `B_r` at least as great, cells | below it beyond chance | above it beyond chance "
        "| mean of `B_r` less prediction | mean distance | Kendall's tau |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for floor in results["floors"]:
        for key, it in evaluate(floor).items():
            tau = "" if it["tau"] is None else f"{it['tau']:.2f}"
            lines.append(
                f"| {floor['name']} | {PREDICTORS[key]} | {it['n_at_least']} of {len(floor['cells'])} "
                f"| {it['n_below']} | {it['n_above']} | {it['gap']:+.2f} ± {it['gap_error']:.2f} "
                f"| {it['absolute_gap']:.2f} | {tau} |"
            )
    for floor in results["floors"]:
        lines += [
            "",
            f"### {floor['name']}",
            "",
            "| robots | start within, m | m/s | rad/s | `B_r`, with 95 % interval | "
            + " | ".join(PREDICTORS.values()) + " |",
            "|---" * (5 + len(PREDICTORS)) + "|",
        ]
        for cell in floor["cells"]:
            low, high = interval(cell["n_mills"], cell["n_runs"])
            lines.append(
                f"| {cell['robots']:.0f} | {cell['placement_radius_m']:.1f} | {cell['speed_m_s']:.2f} "
                f"| {cell['turn_rate_rad_s']:.1f} | {cell['n_mills']} of {cell['n_runs']}: "
                f"{cell['n_mills'] / cell['n_runs']:.2f} ({low:.2f} to {high:.2f}) | "
                + " | ".join(f"{cell[key]:.2f}" for key in PREDICTORS) + " |"
            )
    return "\n".join(lines)


def draw(results, path):
    """All cells of all floors: what robots did, with its interval, beside what was predicted."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    marks = dict(zip(PREDICTORS, (("o", "#1f77b4"), ("v", "#d62728"), ("s", "#2ca02c"), ("_", "#2ca02c"))))
    floors = results["floors"]
    figure, panels = pyplot.subplots(
        len(floors), figsize=(9, 2.6 * len(floors)), squeeze=False, layout="constrained"
    )
    for floor, panel in zip(floors, panels[:, 0]):
        cells = sorted(floor["cells"], key=lambda cell: (cell["n_mills"] / cell["n_runs"], cell["as_measured"]))
        places = range(len(cells))
        shares = [cell["n_mills"] / cell["n_runs"] for cell in cells]
        bounds = [interval(cell["n_mills"], cell["n_runs"]) for cell in cells]
        panel.bar(places, [high - low for low, high in bounds], 0.7, [low for low, _ in bounds], color="#dddddd")
        panel.hlines(shares, [it - 0.35 for it in places], [it + 0.35 for it in places], "black", label="on the floor")
        for offset, (key, (mark, colour)) in zip((-0.2, 0.0, 0.2, 0.2), marks.items()):
            panel.scatter(
                [it + offset for it in places], [cell[key] for cell in cells], 28, colour, mark, label=PREDICTORS[key]
            )
        names = [
            f"{cell['robots']:.0f}, {cell['placement_radius_m']:.1f}\n{cell['speed_m_s']:.2f}, "
            f"{cell['turn_rate_rad_s']:.1f}"
            for cell in cells
        ]
        panel.set_xticks(places, names, fontsize=7)
        panel.set(title=floor["name"], ylabel="share of runs that mill", ylim=(-0.04, 1.04))
        panel.spines[["top", "right"]].set_visible(False)
    panels[-1, 0].set_xlabel("robots, radius of the start in m; m/s, rad/s")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=5, fontsize=8)
    figure.savefig(path, dpi=120)
