"""How many finds show on the floor what they were found for, at once and within some attempts."""

from evaluation import fisher, interval

# Mattson et al. (AAMAS 2025), on eight HeRo+ robots: finds, those that worked at once, and within three attempts.
# They state 70 and 90 % of 30, and 22 and 27 % of 18; counts are the whole numbers nearest to these.
PUBLISHED = {"calibrated": (30, 21, 27), "uncalibrated": (18, 4, 5)}
# What `rsrs explore` calls finds that are not deployed.
NAMELESS = ("no_order", "other")
JAMMED = 0.25  # Robots are blocked for this share of the judged minute, or more.
NUMERALS = {1: "one", 2: "two", 3: "three"}


def works(find):
    """At once, and within all attempts."""
    shows = [attempt["shows"] for attempt in find["attempts"]]
    return shows[0], any(shows)


def predicted(finds, key, n_attempts):
    """How many would work at once, and within all attempts, if each attempt did so by this simulated share."""
    return sum(find[key] for find in finds), sum(1 - (1 - find[key]) ** n_attempts for find in finds)


def stated(hits, n):
    low, high = interval(hits, n)
    return f"{hits} of {n}: {hits / n:.2f} ({low:.2f} to {high:.2f})"


def counts(finds):
    """Finds, those that work at once, and within all attempts."""
    return len(finds), *(sum(works(find)[within] for find in finds) for within in (0, 1))


def compared(one, other):
    """Two shares, and whether they differ by chance; each has how many of how many."""
    p = fisher(*one, *other)
    stated = "p < 0.001" if p < 0.001 else f"p = {p:.{3 if p < 0.01 else 2}f}"
    return f"{one[0]} of {one[1]}, {other[0]} of {other[1]}: {stated}"


def row(*cells):
    return f"| {' | '.join(map(str, cells))} |"


def head(*cells):
    return [row(*cells), "|---" * len(cells) + "|"]


def tables(results):
    """The tables of the page."""
    worlds, n_attempts = results["worlds"], results["n_attempts"]
    # Of one attempt there is nothing more to state.
    heads = ["at the first attempt", f"within {NUMERALS[n_attempts]}"][: min(n_attempts, 2)]
    parts = (
        searched(worlds), worked(worlds, n_attempts, heads), tested(worlds, heads), expected(worlds, n_attempts, heads),
        by_class(worlds, heads), misnamed(worlds), started(worlds), jammed(worlds),
    )
    return "\n\n".join("\n".join(lines) for lines in parts)


def searched(worlds):
    """What was found, and how much of it was deployed how often."""
    (n_controllers,) = {it["n_controllers"] for it in worlds.values()}
    searches = f"searches of {n_controllers} controllers"
    lines = head("search", searches, "finds", "with a name that counts", "deployed", "attempts")
    for world, it in worlds.items():
        n_named = sum(count for name, count in it["n_found"].items() if name not in NAMELESS)
        n_attempted = sum(len(find["attempts"]) for find in it["finds"])
        n_found = sum(it["n_found"].values())
        lines.append(row(world, it["n_searches"], n_found, n_named, len(it["finds"]), n_attempted))
    return lines


def worked(worlds, n_attempts, heads):
    """How many finds worked, beside those that were published."""
    lines = head("search", *heads)
    for world, it in worlds.items():
        n, *hits = counts(it["finds"])
        lines.append(row(world, *(stated(k, n) for k in hits[: len(heads)])))
    for world, (n, at_once, within) in PUBLISHED.items():
        others = [stated(at_once, n), ("" if n_attempts == 3 else "within three: ") + stated(within, n)]
        lines.append(row(f"published, {world}", *others[: len(heads)]))
    return lines


def tested(worlds, heads):
    """Whether they differ by chance."""
    calibrated, ideal = (it["finds"] for it in worlds.values())
    pairs = {
        "calibrated, ideal": (counts(calibrated), counts(ideal)),
        "the same, milling and aggregation": (counts(explained(calibrated)), counts(explained(ideal))),
        "calibrated, published": (counts(calibrated), PUBLISHED["calibrated"]),
        "ideal, published uncalibrated": (counts(ideal), PUBLISHED["uncalibrated"]),
    }
    lines = head("Fisher's exact test, two-sided", *heads)
    for words, ((n, *hits), (other_n, *others)) in pairs.items():
        tests = [compared((k, n), (other, other_n)) for k, other in zip(hits, others)]
        lines.append(row(words, *tests[: len(heads)]))
    return lines


def expected(worlds, n_attempts, heads):
    """How many would have worked if the floor were the simulator."""
    lines = head("search", "simulated robots", *heads)
    for world, it in worlds.items():
        for key, words in (("share", "harsher"), ("share_as_measured", "as in the profile")):
            sums = [f"{k:.1f} of {len(it['finds'])}" for k in predicted(it["finds"], key, n_attempts)]
            lines.append(row(world, words, *sums[: len(heads)]))
    return lines


def by_class(worlds, heads):
    """Each name for itself."""
    lines = head(
        "class", "search", "found", "deployed", *heads, "simulated share, harsher, of those that worked",
        "of the others",
    )
    for name in dict.fromkeys(find["name"] for find in all_finds(worlds)):
        for world, it in worlds.items():
            finds = [find for find in it["finds"] if find["name"] == name]
            n, *hits = counts(finds)
            shares = (
                ", ".join(f"{find['share']:.2f}" for find in finds if works(find)[1] == has_worked)
                for has_worked in (True, False)
            )
            lines.append(row(name, world, it["n_found"].get(name, 0), n, *hits[: len(heads)], *shares))
    return lines


def misnamed(worlds):
    """How wide the name of aggregation is."""
    lines = head(
        "search", "aggregation that worked", "of these milling, too", "attempts of other finds",
        "of these called aggregation, too", "of these worked", "of these blocked for a quarter of the time",
    )
    for world, it in worlds.items():
        attempts = [(find["name"], attempt) for find in it["finds"] for attempt in find["attempts"]]
        gathered = [attempt for name, attempt in attempts if name == "aggregation" and attempt["shows"]]
        others = [attempt for name, attempt in attempts if name != "aggregation"]
        too = [attempt for attempt in others if "aggregation" in attempt["names"]]
        lines.append(
            row(
                world, len(gathered), sum("milling" in it["names"] for it in gathered), len(others), len(too),
                sum(it["shows"] for it in too), sum(it["blocked"] >= JAMMED for it in too),
            )
        )
    return lines


def started(worlds):
    """How many would have worked from the floor's starts."""
    lines = head(
        "search", "milling and aggregation: finds", "worked at once", "by simulated shares",
        "by those from the floor's starts", "all finds: most blocked in the simulator",
    )
    for world, it in worlds.items():
        finds = explained(it["finds"])
        sums = (f"{sum(find[key] for find in finds):.1f}" for key in ("share_as_measured", "share_on_grid"))
        most = f"{max(find['blocked'] for find in it['finds']):.2f}"
        lines.append(row(world, len(finds), sum(works(find)[0] for find in finds), *sums, most))
    return lines


def jammed(worlds):
    """Whether those were blocked that failed, and those that worked."""
    lines = head("first attempts that were blocked for a quarter of the time", "those that failed, those that worked")
    for words, is_of in (
        ("all", lambda name: True),
        ("aggregation", lambda name: name == "aggregation"),
        ("all others", lambda name: name != "aggregation"),
    ):
        first = [find["attempts"][0] for find in all_finds(worlds) if is_of(find["name"])]
        blocked = [[it["blocked"] >= JAMMED for it in first if it["shows"] == shows] for shows in (False, True)]
        lines.append(row(words, compared(*((sum(are), len(are)) for are in blocked))))
    return lines


def all_finds(worlds):
    return [find for it in worlds.values() for find in it["finds"]]


def explained(finds):
    """Those that simulated robots were tried with from the floor's starts, milling and aggregation."""
    return [find for find in finds if "share_on_grid" in find]


def draw(results, run_file, rectangle_m, path):
    """The first attempt of each find: what robots drove in its judged minute, and whether it shows its name."""
    import matplotlib
    import numpy as np

    matplotlib.use("agg")
    from matplotlib import pyplot

    columns = 8
    rows = {world: -(-len(it["finds"]) // columns) for world, it in results["worlds"].items()}
    figure, panels = pyplot.subplots(
        sum(rows.values()), columns, figsize=(1.45 * columns, 1.42 * sum(rows.values())), layout="constrained"
    )
    for panel in panels.flat:
        panel.axis("off")
    first = 0
    for world, it in results["worlds"].items():
        for find, panel in zip(it["finds"], panels[first:].flat):
            poses = np.load(run_file(world, find, 0))["poses"][-600:]
            shows = find["attempts"][0]["shows"]
            for robot in range(poses.shape[1]):
                panel.plot(*poses[::2, robot, :2].T, linewidth=0.4)
            panel.plot(*poses[-1, :, :2].T, "o", color="black", markersize=2)
            panel.axis("on")
            panel.set(xticks=[], yticks=[], aspect="equal")
            panel.set(xlim=(-rectangle_m[0] / 2, rectangle_m[0] / 2), ylim=(-rectangle_m[1] / 2, rectangle_m[1] / 2))
            panel.set_title(f"{find['name']}, {find['share']:.2f}", fontsize=6, pad=2)
            for spine in panel.spines.values():
                spine.set(color="#2ca02c" if shows else "#d62728", linewidth=2)
        panels[first, 0].text(
            -0.12, 0.5, world, transform=panels[first, 0].transAxes, rotation=90, va="center", ha="right", fontsize=8
        )
        first += rows[world]
    figure.savefig(path, dpi=100)


def film(results, run_file, rectangle_m, path):
    """Of each world the first find that worked at once, and the first that did not: 120 s, ten times as fast."""
    import numpy as np
    from PIL import Image, ImageDraw

    scale, gap, title_px = 140, 14, 16
    width_px, height_px = (round(scale * side_m) for side_m in rectangle_m)
    panels = []
    for row, (world, it) in enumerate(results["worlds"].items()):
        for column, shows in enumerate((True, False)):
            find = next((find for find in it["finds"] if find["attempts"][0]["shows"] == shows), None)
            if find is not None:
                corner = (gap + column * (width_px + gap), title_px + row * (height_px + title_px + gap))
                panels.append((corner, world, find, shows, np.load(run_file(world, find, 0))["poses"]))
    size = (gap + 2 * (width_px + gap), 2 * (height_px + title_px + gap))
    frames = []
    for sample in range(0, min(len(poses) for *_, poses in panels), 10):
        frame = Image.new("RGB", size, "white")
        pen = ImageDraw.Draw(frame)
        for (left, top), world, find, shows, poses in panels:
            colour = "#2ca02c" if shows else "#d62728"
            pen.text((left, top - title_px + 3), f"{world}: {find['name']}, {sample // 10} s", fill="black")
            pen.rectangle((left, top, left + width_px, top + height_px), outline=colour, width=3)
            for x_m, y_m, heading_rad in poses[sample]:
                x, y = left + width_px / 2 + scale * x_m, top + height_px / 2 - scale * y_m
                reach = 0.07 * scale
                pen.ellipse((x - reach, y - reach, x + reach, y + reach), fill="#bcd3ea", outline="#1a1a1a")
                ahead = (x + reach * np.cos(heading_rad), y - reach * np.sin(heading_rad))
                pen.line((x, y, *ahead), fill="#1a1a1a", width=2)
        frames.append(frame.quantize(16))
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=100, loop=0, optimize=True)
