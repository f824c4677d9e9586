"""Sends back every sample over rclpy, and reports how it sees our publishers; see main.rs.

The first line of the input is the list of topics; the end of the input is the end.
"""

import importlib
import json
import sys

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from until_end import input_has_ended


def kind_of(type_name):
    package, _, name = type_name.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def qos_of(topic):
    reliable, keeps = topic["reliable"], topic["transient_local"]
    return QoSProfile(
        depth=topic["depth"],
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if keeps else DurabilityPolicy.VOLATILE,
    )


def seen(node, topic):
    """Type and quality of service of what others publish on a topic."""
    others = [p for p in node.get_publishers_info_by_topic(topic["name"]) if p.node_name == "ours"]
    return [
        [
            publisher.topic_type,
            publisher.qos_profile.reliability == ReliabilityPolicy.RELIABLE,
            publisher.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL,
        ]
        for publisher in others
    ]


def main():
    topics = json.loads(sys.stdin.readline())
    rclpy.init()
    node = rclpy.create_node("echo")
    for topic in topics:
        kind, qos = kind_of(topic["type_name"]), qos_of(topic)
        publisher = node.create_publisher(kind, "/echo" + topic["name"], qos)
        node.create_subscription(kind, topic["name"], publisher.publish, qos)
    print(json.dumps("ready"), flush=True)
    while not input_has_ended():
        rclpy.spin_once(node, timeout_sec=0.01)
    print(json.dumps({topic["name"]: seen(node, topic) for topic in topics}), flush=True)
    node.destroy_node()
    rclpy.shutdown()


main()
