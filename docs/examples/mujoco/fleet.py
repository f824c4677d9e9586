"""The robots of `physics.py` on ROS 2, as nine robots and a tracker of a laboratory would be.

    python fleet.py FLEET.yaml SOCKET --seed 1

Nothing of rsrs runs here. A robot whose type in the fleet file has `lease: controller` publishes
`detection` and obeys `cmd_vel`; any other has a gate of rsrs before it, so it publishes
`hardware/range` and obeys `hardware/cmd_vel`. The tracker publishes their `pose`s. `place.py` puts robots elsewhere, through SOCKET, as a person would. Time passes as on
the wall; SIGTERM ends it, with a line that states whether the machine kept up.
"""

import argparse
import json
import math
import os
import pathlib
import queue
import signal
import socket
import sys
import threading
import time

import rclpy
import yaml
from geometry_msgs.msg import PoseStamped, Twist
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import Range
from std_msgs.msg import Bool

from physics import CAMERA_HALF_ANGLE_RAD, Physics

DETECTION_S, TRACKER_S = 0.1, 0.04
MOST_BEHIND_S = 2.0  # What a machine cannot catch up with is left out, and counted.


class Clock:
    """Lets simulated time pass as wall time does."""

    def __init__(self, physics):
        self.physics = physics
        self.started_s = time.monotonic() - physics.time_s
        self.began_s, self.began_cpu_s = time.monotonic(), time.process_time()
        self.most_behind_s = self.left_out_s = 0.0

    def advance(self):
        now_s = time.monotonic() - self.started_s
        behind_s = now_s - self.physics.time_s
        self.most_behind_s = max(self.most_behind_s, behind_s)
        if behind_s > MOST_BEHIND_S:
            self.started_s += behind_s
            self.left_out_s += behind_s
            return
        self.physics.advance(now_s)

    def summary(self):
        passed_s, busy_s = time.monotonic() - self.began_s, time.process_time() - self.began_cpu_s
        return (
            f"{passed_s:.0f} s on the wall, {self.left_out_s:.2f} s of them left out, at most "
            f"{1000 * self.most_behind_s:.0f} ms behind; {100 * busy_s / passed_s:.0f} % of a core"
        )


class Robot(Node):
    """What runs on one robot: its base driver and its camera."""

    def __init__(self, name, clock, is_gated):
        super().__init__("base", namespace=name, start_parameter_services=False)
        self.name, self.clock = name, clock
        qos = qos_profile_sensor_data
        if is_gated:
            self.create_subscription(Twist, "hardware/cmd_vel", self.obey, 1)
            self.range = self.create_publisher(Range, "hardware/range", qos)
            self.create_timer(DETECTION_S, self.measure)
        else:
            self.create_subscription(Twist, "cmd_vel", self.obey, 1)
            self.detection = self.create_publisher(Bool, "detection", qos)
            self.create_timer(DETECTION_S, self.sense)

    def obey(self, twist):
        self.clock.advance()
        self.clock.physics.obey(self.name, twist.linear.x, twist.angular.z)

    def sense(self):
        self.clock.advance()
        self.detection.publish(Bool(data=self.clock.physics.detects(self.name)))

    def measure(self):
        self.clock.advance()
        far_m = float(self.clock.physics.nearest_m(self.name))
        stamp = self.get_clock().now().to_msg()
        found = Range(min_range=0.0, max_range=2.0, field_of_view=2 * CAMERA_HALF_ANGLE_RAD, range=far_m)
        found.header.stamp, found.header.frame_id = stamp, f"{self.name}/camera"
        self.range.publish(found)


class Tracker(Node):
    """A tracker under the ceiling, and whoever carries robots about."""

    def __init__(self, names, clock, wanted):
        super().__init__("tracker", start_parameter_services=False)
        self.clock, self.wanted = clock, wanted
        qos = qos_profile_sensor_data
        self.poses = {name: self.create_publisher(PoseStamped, f"/{name}/pose", qos) for name in names}
        self.create_timer(TRACKER_S, self.track)

    def track(self):
        self.clock.advance()
        placed = self.wanted.get() if not self.wanted.empty() else None
        if placed:
            self.clock.physics.place(placed.poses)
        stamp = self.get_clock().now().to_msg()
        for name, publisher in self.poses.items():
            x, y, heading = self.clock.physics.tracked(name)
            seen = PoseStamped()
            seen.header.stamp, seen.header.frame_id = stamp, "map"
            seen.pose.position.x, seen.pose.position.y = x, y
            seen.pose.orientation.z = math.sin(heading / 2)
            seen.pose.orientation.w = math.cos(heading / 2)
            publisher.publish(seen)
        if placed:
            placed.done.set()


class Placement:
    """Where robots are wanted, from the line of JSON that a `--place-command` gets."""

    def __init__(self, line, names):
        robots = json.loads(line)["robots"]
        self.poses = {
            robot["name"]: (robot["x_m"], robot["y_m"], robot["heading_rad"]) for robot in robots
        }
        if unknown := set(self.poses) - set(names):
            raise ValueError(f"no robot is called {', '.join(unknown)}")
        self.done = threading.Event()


def take_placements(server, names, wanted):
    """Answers each placement when the robots stand there and the tracker has published it."""
    while True:
        connection, _ = server.accept()
        with connection, connection.makefile("rw") as stream:
            try:
                placement = Placement(stream.read(), names)
            except (ValueError, KeyError, TypeError) as error:
                stream.write(f"not placed, {type(error).__name__}: {error}\n")
                continue
            wanted.put(placement)
            placement.done.wait()
            stream.write("placed\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("fleet", type=pathlib.Path)
    parser.add_argument("socket")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    fleet = yaml.safe_load(arguments.fleet.read_text())
    kinds = {name: fleet["robot_types"][robot["type"]] for name, robot in fleet["robots"].items()}
    names = list(kinds)
    clock, wanted = Clock(Physics(names, arguments.seed)), queue.SimpleQueue()

    # A Ctrl-C in the terminal is for the programs that command robots, and not for robots.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())
    executor = SingleThreadedExecutor()
    for name in names:
        executor.add_node(Robot(name, clock, kinds[name].get("lease") != "controller"))
        time.sleep(DETECTION_S / len(names))  # Robots are not switched on in the same instant.
    executor.add_node(Tracker(names, clock, wanted))
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(arguments.socket)
        server.listen()
        threading.Thread(target=take_placements, args=(server, names, wanted), daemon=True).start()
        while not ended.is_set():
            executor.spin_once(timeout_sec=TRACKER_S)
        os.unlink(arguments.socket)
    print(clock.summary(), flush=True)
    return 1 if clock.left_out_s > 0.0 else 0


sys.exit(main())
