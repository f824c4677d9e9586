"""Plain rclpy robots in one process, each with another quality of service; see interop_robot.rs.

    python robots.py [--further=NAME,...] [--objects=N] NAME:COMMANDS:SUBSCRIBES:PUBLISHES[:tracked] ...

COMMANDS is twist or twist_stamped, the next two are a quality of service below. Each robot publishes
`detection` and `odom`, and obeys `cmd_vel`. Of one that is tracked, `pose` has its place on the floor as
well, and its odometry starts at 0, 0. With --further, `detection/NAME` of each is true for a second in two.
With --objects, a tracker with a clock of its own sees so many objects, of which the first is pushed along; now
and then it has lost the second. --frame is the frame of their poses.
"""

import argparse
import math
import time

import rclpy
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from std_msgs.msg import Bool

PERIOD_S = 0.13
QUALITIES = {
    "default": QoSProfile(depth=10),
    "sensor": qos_profile_sensor_data,
    "kept": QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL),
    "depth_1": QoSProfile(depth=1),
}


class Robot(Node):
    def __init__(self, index, further, name, commands, subscribes, publishes, tracked=None):
        super().__init__("base", namespace=name)
        self.x, self.y, self.heading = float(index), 0.0, 0.0
        self.origin = self.x if tracked else 0.0
        self.pose = self.create_publisher(PoseStamped, "pose", 10) if tracked else None
        self.twist, self.commanded_s = Twist(), 0.0
        if commands == "twist":
            self.create_subscription(Twist, "cmd_vel", self.obey, QUALITIES[subscribes])
        else:
            self.create_subscription(
                TwistStamped, "cmd_vel", lambda m: self.obey(m.twist), QUALITIES[subscribes])
        self.detection = self.create_publisher(Bool, "detection", QUALITIES[publishes])
        self.further = [
            self.create_publisher(Bool, f"detection/{it}", QUALITIES[publishes]) for it in further]
        self.odom = self.create_publisher(Odometry, "odom", QUALITIES[publishes])
        self.create_timer(PERIOD_S, self.live)

    def obey(self, twist):
        self.twist, self.commanded_s = twist, time.monotonic()

    def live(self):
        if time.monotonic() - self.commanded_s < 0.5:
            self.x += self.twist.linear.x * PERIOD_S * math.cos(self.heading)
            self.y += self.twist.linear.x * PERIOD_S * math.sin(self.heading)
            self.heading += self.twist.angular.z * PERIOD_S
        for further in self.further:
            further.publish(Bool(data=int(time.monotonic()) % 2 == 1))
        self.detection.publish(Bool(data=False))
        odometry = Odometry()
        odometry.header.stamp = self.get_clock().now().to_msg()
        odometry.header.frame_id = "map"
        position, turned = odometry.pose.pose.position, odometry.pose.pose.orientation
        position.x, position.y = self.x - self.origin, self.y
        turned.z, turned.w = math.sin(self.heading / 2), math.cos(self.heading / 2)
        self.odom.publish(odometry)
        if self.pose:
            pose = PoseStamped(header=odometry.header)
            pose.pose.position.x, pose.pose.position.y = self.x, self.y
            pose.pose.orientation = turned
            self.pose.publish(pose)


class Tracker(Node):
    def __init__(self, n_objects):
        super().__init__("objects")
        names = [f"/objects/object_{number + 1}/pose" for number in range(n_objects)]
        self.poses = [
            self.create_publisher(PoseStamped, name, qos_profile_sensor_data) for name in names]
        self.start_s = time.monotonic()
        self.create_timer(0.1, self.look)

    def look(self):
        passed_s = time.monotonic() - self.start_s
        for number, publisher in enumerate(self.poses):
            pose = PoseStamped()
            pose.header.frame_id = given.frame
            # Seconds since it was switched on.
            pose.header.stamp.sec, pose.header.stamp.nanosec = int(passed_s), int(passed_s % 1 * 1e9)
            pose.pose.position.x, pose.pose.position.y = 0.5 * number, 1.0
            if number == 0:
                pose.pose.position.y += 0.01 * passed_s
            if number == 1 and passed_s % 1 < 0.3:
                pose.pose.position.x = math.nan
            publisher.publish(pose)


arguments = argparse.ArgumentParser()
arguments.add_argument("--further", type=lambda names: names.split(","), default=[])
arguments.add_argument("--objects", type=int, default=0)
arguments.add_argument("--frame", default="map")
arguments.add_argument("robots", nargs="+")
given = arguments.parse_args()
rclpy.init()
executor = SingleThreadedExecutor()
for index, robot in enumerate(given.robots):
    executor.add_node(Robot(index, given.further, *robot.split(":")))
if given.objects:
    executor.add_node(Tracker(given.objects))
executor.spin()
