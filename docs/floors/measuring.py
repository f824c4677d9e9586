"""Fills in the tables of `rsrs measure plan` by what robots do on a floor, as a person with a tracker would."""

import csv
import itertools
import math

import numpy as np

from floor import Controller, seeded

# Robots drive for so long before a trial begins, so that they have their speed.
RUN_UP_S = 1.0
STANDING = Controller.constant(0.0, 0.0)
HEADER = ("robot", "trial", "time_s", "x_m", "y_m", "heading_rad", "commanded_m_s", "commanded_rad_s")


def fill_in(floor, trials):
    """Makes every trial of a plan; `trials` is its folder."""
    number = itertools.count(1)
    drives = []

    def driven(row, speed_m_s, rate_rad_s, duration_s):
        robot = number_of(row["robot"])
        controller = Controller.constant(speed_m_s, rate_rad_s)
        found = floor.drive([robot], [(0.0, 0.0, 0.0)], controller, duration_s, next(number))
        drives.append((row["robot"], found))
        return found

    def straight(row):
        speed_m_s, track_m = float(row["commanded_m_s"]), float(row["distance_m"])
        found = driven(row, speed_m_s, 0.0, RUN_UP_S + 2.0 * track_m / speed_m_s)
        begin = round(RUN_UP_S / found.period_s)
        x, y, heading = found.poses[begin:, 0].T
        cosine, sine = math.cos(heading[0]), math.sin(heading[0])
        ahead = (x - x[0]) * cosine + (y - y[0]) * sine
        end = first(ahead >= track_m)
        row["distance_m"] = f"{ahead[end]:.4f}"
        row["duration_s"] = f"{end * found.period_s:.2f}"
        row["lateral_m"] = f"{(y[end] - y[0]) * cosine - (x[end] - x[0]) * sine:.4f}"
        row["heading_change_rad"] = f"{np.unwrap(heading)[end] - heading[0]:.4f}"

    def turn(row):
        rate_rad_s, angle_rad = float(row["commanded_rad_s"]), float(row["angle_rad"])
        speed_m_s = float(row.get("commanded_m_s", 0.0))
        found = driven(row, speed_m_s, rate_rad_s, RUN_UP_S + 2.0 * angle_rad / abs(rate_rad_s))
        turned = np.unwrap(found.poses[:, 0, 2])[round(RUN_UP_S / found.period_s) :]
        turned = np.abs(turned - turned[0])
        end = first(turned >= angle_rad)
        row["angle_rad"] = f"{turned[end]:.4f}"
        row["duration_s"] = f"{end * found.period_s:.2f}"

    def look(row):
        robots, starts = [number_of(row["robot"])], [(0.0, 0.0, 0.0)]
        if row["distance_m"]:
            far_m, bearing = float(row["distance_m"]), float(row["bearing_rad"])
            # The other robot is any other one of the fleet.
            robots.append(robots[0] % 2 + 1)
            starts.append((far_m * math.cos(bearing), far_m * math.sin(bearing), 0.0))
        # The first reading is made while robots are put there.
        n = int(row["samples"])
        found = floor.drive(robots, starts, STANDING, (n + 1) * floor.period_s, next(number))
        row["detections"] = int(found.detections[1 : n + 1, 0].sum())

    periods = {}

    def period(row):
        if row["robot"] not in periods:
            seed = next(number)
            found = floor.drive([number_of(row["robot"])], [(0.0, 0.0, 0.0)], STANDING, 30.0, seed)
            periods[row["robot"]] = iter(found.periods_s)
        row["period_s"] = f"{next(periods[row['robot']]):.4f}"

    for table, trial in (
        ("speed", straight), ("turn", turn), ("arcs", turn), ("detection", look), ("period", period),
    ):
        with open(trials / f"{table}.csv") as file:
            rows = list(csv.DictReader(file))
        for row in rows:
            trial(row)
        with open(trials / f"{table}.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(rows)
    write_trajectories(trials / "drives.csv", drives)


def first(reached):
    """The first sample in which it is so; of a robot that did not get there, the last one."""
    return int(np.argmax(reached)) if reached.any() else len(reached) - 1


def number_of(robot):
    return int(robot.removeprefix("robot_"))


def drive_alone(floor, robots, duration_s, path):
    """Drives of robots that the fit did not use, for `rsrs validate`: four of each, 15 s long, of which
    the command changes sides whenever its sensor errs."""
    drives = []
    for robot, trial in itertools.product(robots, range(4)):
        speed_m_s, rate_rad_s = (0.08, 0.5) if trial % 2 else (0.2, 1.2)
        controller = Controller.of_cell(speed_m_s, rate_rad_s)
        seed = 10_000 + 10 * robot + trial
        drives.append((f"robot_{robot}", floor.drive([robot], [(0.0, 0.0, 0.0)], controller, duration_s, seed)))
    write_trajectories(path, drives)


def write_trajectories(path, drives):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(HEADER)
        for trial, (robot, found) in enumerate(drives, 1):
            for time_s, pose, command in zip(found.time_s, found.poses[:, 0], found.commands[:, 0]):
                writer.writerow((robot, trial, f"{time_s:.3f}", *(f"{it:.5f}" for it in pose), *command))
