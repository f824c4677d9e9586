"""How many finds show on the floor what they were found for, at once and within some attempts."""

from evaluation import interval

# Mattson et al. (AAMAS 2025), on eight HeRo+ robots: finds, those that worked at once, and within three attempts.
PUBLISHED = {"calibrated": (30, 21, 27), "uncalibrated": (18, 4, 5)}
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
    return len(finds), *(sum(column) for column in zip(*map(works, finds)))


def row(*cells):
    return f"| {' | '.join(map(str, cells))} |"


def tables(results):
    """The tables of the page: all finds, what simulated robots would do, and each class."""
    worlds, n_attempts = results["worlds"], results["n_attempts"]
    # Of one attempt there is nothing more to state.
    shown = slice(0, 1 if n_attempts == 1 else 2)
    heads = ["at the first attempt", f"within {NUMERALS[n_attempts]}"][shown]
    lines = [row("search", *heads), "|---" * (1 + len(heads)) + "|"]
    for world, it in worlds.items():
        n, *hits = counts(it["finds"])
        lines.append(row(world, *(stated(k, n) for k in hits[shown])))
    for world, (n, at_once, within) in PUBLISHED.items():
        others = [stated(at_once, n), f"within three: {stated(within, n)}"][shown]
        lines.append(row(f"published, {world}", *others))
    lines += ["", row("search", "simulated robots", *heads), "|---" * (2 + len(heads)) + "|"]
    for world, it in worlds.items():
        for key, words in (("share", "harsher"), ("share_as_measured", "as in the profile")):
            expected = [f"{k:.1f} of {len(it['finds'])}" for k in predicted(it["finds"], key, n_attempts)]
            lines.append(row(world, words, *expected[shown]))
    lines += [
        "",
        row(
            "search", "milling and aggregation: finds", "worked at once", "by simulated shares",
            "by those from the floor's starts", "all finds: failed at once",
            "of these blocked for a quarter of the time", "most blocked in the simulator",
        ),
        "|---" * 8 + "|",
    ]
    for world, it in worlds.items():
        explained = [find for find in it["finds"] if "share_on_grid" in find]
        failed = [find["attempts"][0] for find in it["finds"] if not works(find)[0]]
        expected = (f"{sum(find[key] for find in explained):.1f}" for key in ("share_as_measured", "share_on_grid"))
        lines.append(
            row(
                world, len(explained), sum(works(find)[0] for find in explained), *expected, len(failed),
                sum(attempt["blocked"] >= 0.25 for attempt in failed),
                f"{max(find['blocked'] for find in it['finds']):.2f}",
            )
        )
    lines += [
        "",
        row(
            "class", "search", "found", "deployed", *heads, "simulated share, harsher, of those that worked",
            "of the others",
        ),
        "|---" * (6 + len(heads)) + "|",
    ]
    names = dict.fromkeys(find["name"] for it in worlds.values() for find in it["finds"])
    for name in names:
        for world, it in worlds.items():
            finds = [find for find in it["finds"] if find["name"] == name]
            n, *hits = counts(finds) if finds else (0, 0, 0)
            shares = (
                ", ".join(f"{find['share']:.2f}" for find in finds if works(find)[1] == worked)
                for worked in (True, False)
            )
            lines.append(row(name, world, it["n_found"].get(name, 0), n, *hits[shown], *shares))
    return "\n".join(lines)


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
