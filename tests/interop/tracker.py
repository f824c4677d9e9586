"""A tracker of four robots in rclpy, in millimetres and with y up; see motion_capture.rs.

It publishes where they stand in one array without names, and of each robot as a pose and as odometry.
"""

import math

import rclpy
from geometry_msgs.msg import Pose, PoseArray, PoseStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data

ROBOTS = ["robot_1", "robot_2", "robot_3", "robot_4"]


def seen(robot):
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = 500.0 * robot, 60.0, 250.0
    pose.orientation.y, pose.orientation.w = math.sin(0.25), math.cos(0.25)
    return pose


class Tracker(Node):
    def __init__(self):
        super().__init__("tracker")
        self.array = self.create_publisher(PoseArray, "/mocap/poses", qos_profile_sensor_data)
        self.poses = [self.create_publisher(PoseStamped, f"/{robot}/tracked/pose", 10) for robot in ROBOTS]
        self.odometry = [self.create_publisher(Odometry, f"/{robot}/tracked/odom", 10) for robot in ROBOTS]
        self.create_timer(0.02, self.publish)

    def stamped(self, message):
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id = "mocap"
        return message

    def publish(self):
        box = Pose()
        order = [seen(3), box, seen(2), seen(1), seen(0)]
        self.array.publish(self.stamped(PoseArray(poses=order)))
        for robot in range(len(ROBOTS)):
            self.poses[robot].publish(self.stamped(PoseStamped(pose=seen(robot))))
            odometry = self.stamped(Odometry())
            odometry.pose.pose = seen(robot)
            self.odometry[robot].publish(odometry)


rclpy.init()
rclpy.spin(Tracker())
