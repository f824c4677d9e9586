"""A robot's base driver in rclpy: wheels, odometry, and a distance sensor that sees other robots.

    python rclpy_robot.py --ros-args -r __ns:=/robot_1 -p others:="[robot_2, robot_3]" -p x:=0.7
    rsrs node robot --robots robot_1 --driver ros --interface wlan0

The second program decides, records and holds the lease; this one is where your hardware goes.
"""

import math
import time

import rclpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import Range

PERIOD_S, SIGHT_M, HALF_ANGLE_RAD = 0.05, 0.75, 0.2
WHEELS_TIMEOUT_S = 0.25  # They stop by themselves, whoever dies.


class Robot(Node):
    def __init__(self):
        super().__init__("base")
        self.x, self.y, self.heading = (
            self.declare_parameter(name, 0.0).value for name in ["x", "y", "heading"])
        self.speed = self.turn_rate = self.commanded_s = 0.0
        self.others = {}
        for name in self.declare_parameter("others", ["robot_2"]).value:
            self.create_subscription(Odometry, f"/{name}/odom", lambda m, n=name: self.see(n, m), 10)
        self.create_subscription(Twist, "hardware/cmd_vel", self.obey, 1)
        self.range = self.create_publisher(Range, "hardware/range", 10)
        self.odom = self.create_publisher(Odometry, "odom", 10)
        self.create_timer(PERIOD_S, self.live)

    def see(self, name, odometry):
        self.others[name] = odometry.pose.pose.position

    def obey(self, twist):
        self.speed, self.turn_rate, self.commanded_s = twist.linear.x, twist.angular.z, time.monotonic()

    def live(self):
        if time.monotonic() - self.commanded_s < WHEELS_TIMEOUT_S:
            self.x += self.speed * PERIOD_S * math.cos(self.heading)
            self.y += self.speed * PERIOD_S * math.sin(self.heading)
            self.heading += self.turn_rate * PERIOD_S
        offsets = [(other.x - self.x, other.y - self.y) for other in self.others.values()]
        ahead = [math.hypot(x, y) for x, y in offsets
                 if abs(math.remainder(math.atan2(y, x) - self.heading, math.tau)) < HALF_ANGLE_RAD]
        self.range.publish(Range(max_range=SIGHT_M, range=min([SIGHT_M + 1.0, *ahead])))
        odometry = Odometry()
        odometry.header.stamp = self.get_clock().now().to_msg()
        position, turned = odometry.pose.pose.position, odometry.pose.pose.orientation
        position.x, position.y = self.x, self.y
        turned.z, turned.w = math.sin(self.heading / 2), math.cos(self.heading / 2)
        self.odom.publish(odometry)


rclpy.init()
rclpy.spin(Robot())
