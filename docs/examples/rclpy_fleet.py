"""Robots in plain rclpy, with wheels and sensors that are only calculated: put yours in their place.

    mkfifo placements
    python3 rclpy_fleet.py robot_1 robot_2 robot_3 <> placements

Nothing of rsrs runs on them. Each publishes `detection` once in a period and its pose on `odom`, and
obeys `cmd_vel`; its wheels stop by themselves when commands stay away. A line of JSON on standard
input, as a program gets it from `--place-command`, puts robots elsewhere.
"""

import json
import math
import random
import sys
import threading
import time

import rclpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Bool

PERIOD_S, SIGHT_M, HALF_ANGLE_RAD = 0.1, 0.6, 0.7
WHEELS_TIMEOUT_S = 0.4  # They stop by themselves, whoever dies.
SPEED_GAIN, TURN_GAIN, DRIVING_TURN_GAIN = 0.92, 0.95, 0.88
TRUE_POSITIVE, FALSE_POSITIVE = 0.95, 0.03
robots = {}
moving = threading.Lock()  # A robot that is put elsewhere is not on its way.


class Robot(Node):
    def __init__(self, name, place):
        super().__init__("base", namespace=name)
        self.pose, self.commanded = (3.0 * place, 0.0, 0.0), (0.0, 0.0)
        self.commanded_s = self.moved_s = time.monotonic()
        self.create_subscription(Twist, "cmd_vel", self.obey, 1)
        self.detection = self.create_publisher(Bool, "detection", qos_profile_sensor_data)
        self.odom = self.create_publisher(Odometry, "odom", qos_profile_sensor_data)
        self.create_timer(PERIOD_S, self.sense)
        self.create_timer(PERIOD_S / 4, self.move)

    def obey(self, twist):
        self.move()
        self.commanded, self.commanded_s = (twist.linear.x, twist.angular.z), time.monotonic()

    def move(self):
        with moving:
            now_s = time.monotonic()
            (x, y, heading), (speed, rate) = self.pose, self.commanded
            if now_s - self.commanded_s < WHEELS_TIMEOUT_S:
                passed_s = now_s - self.moved_s
                turned = rate * passed_s * (DRIVING_TURN_GAIN if speed else TURN_GAIN)
                driven = speed * passed_s * SPEED_GAIN
                x += driven * math.cos(heading + turned / 2)
                y += driven * math.sin(heading + turned / 2)
                heading += turned
            self.pose, self.moved_s = (x, y, heading), now_s
        odometry = Odometry()
        odometry.header.stamp = self.get_clock().now().to_msg()
        odometry.header.frame_id = "map"
        position, orientation = odometry.pose.pose.position, odometry.pose.pose.orientation
        position.x, position.y = x, y
        orientation.z, orientation.w = math.sin(heading / 2), math.cos(heading / 2)
        self.odom.publish(odometry)

    def sees(self, other):
        x, y = other.pose[0] - self.pose[0], other.pose[1] - self.pose[1]
        bearing = math.remainder(math.atan2(y, x) - self.pose[2], math.tau)
        return math.hypot(x, y) < SIGHT_M and abs(bearing) < HALF_ANGLE_RAD

    def sense(self):
        seen = any(self.sees(other) for other in robots.values() if other is not self)
        self.detection.publish(Bool(data=random.random() < (TRUE_POSITIVE if seen else FALSE_POSITIVE)))


def place():
    for line in sys.stdin:
        placed = {robot["name"]: robot for robot in json.loads(line)["robots"]}
        for aside, (name, robot) in enumerate(robots.items()):
            to = placed.get(name, {"x_m": 3.0 * aside, "y_m": 20.0, "heading_rad": 0.0})
            with moving:
                robot.pose = (to["x_m"], to["y_m"], to["heading_rad"])


rclpy.init()
robots.update((name, Robot(name, place)) for place, name in enumerate(sys.argv[1:]))
threading.Thread(target=place, daemon=True).start()
executor = SingleThreadedExecutor()
for robot in robots.values():
    executor.add_node(robot)
executor.spin()
