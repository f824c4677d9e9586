"""Uses a robot's parameters and topics as any ROS 2 program would; prints what it saw as JSON."""

import json
import sys

import rclpy
from rcl_interfaces.msg import ParameterEvent
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import QoSProfile
from std_msgs.msg import Bool

CONTROLLER = "/robot_3/controller"


def answer(node, ask):
    """The answer to a request, which is asked again when it is lost."""
    for _ in range(10):
        future = ask()
        rclpy.spin_until_future_complete(node, future, timeout_sec=2.0)
        if future.done():
            return future.result()
    sys.exit("no answer in 10 tries")


def wait_for(node, what, condition):
    """Spins until something has come."""
    for _ in range(300):
        if condition():
            return
        rclpy.spin_once(node, timeout_sec=0.1)
    sys.exit(f"{what} did not come in 30 s")


def values(response):
    return [rclpy.parameter.parameter_value_to_python(value) for value in response.values]


def dump(node, name):
    """What `ros2 param dump` asks of a node."""
    client = AsyncParameterClient(node, name)
    if not client.wait_for_services(timeout_sec=30.0):
        sys.exit(f"{name} has no parameter services")
    names = list(answer(node, lambda: client.list_parameters([], 0)).result.names)
    described = answer(node, lambda: client.describe_parameters(names)).descriptors
    found = values(answer(node, lambda: client.get_parameters(names)))
    return {descriptor.name: value for descriptor, value in zip(described, found, strict=True)}


def main():
    rclpy.init()
    node = rclpy.create_node("visitor")
    node.declare_parameter("gain", 1.0)
    detections, ends, events = [], [], []
    node.create_subscription(Bool, "/robot_3/detection", lambda m: detections.append(m.data), 10)
    node.create_subscription(Bool, "/robot_2/detection", ends.append, 10)
    node.create_subscription(ParameterEvent, "/parameter_events", events.append, QoSProfile(depth=1000))
    client = AsyncParameterClient(node, CONTROLLER)
    if not client.wait_for_services(timeout_sec=30.0):
        sys.exit("no parameter services")
    names = ["speed", "turn_rate"]

    seen = {"listed": list(answer(node, lambda: client.list_parameters([], 0)).result.names)}
    seen["first"] = values(answer(node, lambda: client.get_parameters(names)))
    (described,) = answer(node, lambda: client.describe_parameters(["speed"])).descriptors
    limits = described.floating_point_range[0]
    seen["described"] = [described.description, described.type, limits.from_value, limits.to_value]

    def set_all(*pairs):
        parameters = [Parameter(name, value=value) for name, value in pairs]
        result = answer(node, lambda: client.set_parameters_atomically(parameters)).result
        return [result.successful, result.reason]

    seen["set"] = set_all(("speed", 0.2), ("turn_rate", 0.5))
    seen["out of range"] = set_all(("turn_rate", 0.6), ("speed", 0.5))
    seen["wrong type"] = set_all(("speed", "fast"))
    seen["undeclared"] = set_all(("height", 1.0))
    single = answer(node, lambda: client.set_parameters([Parameter("speed", value=0.25)]))
    seen["set one"] = [result.successful for result in single.results]
    seen["last"] = values(answer(node, lambda: client.get_parameters(names)))

    wait_for(node, "a detection", lambda: detections)
    seen["detection"] = detections[0]

    def changes():
        changed = [p for e in events if e.node == CONTROLLER for p in e.changed_parameters]
        return [p.name for p in changed if p.value.double_value == 0.25]

    wait_for(node, "an event", changes)
    seen["changed"] = changes()

    def nodes():
        return sorted(f"{space.rstrip('/')}/{name}" for name, space in node.get_node_names_and_namespaces())

    wait_for(node, "the list of nodes", lambda: len(nodes()) >= 4)
    seen["nodes"] = nodes()
    seen["dumps"] = {name: dump(node, name) for name in nodes() if name != "/visitor"}
    services = node.get_service_names_and_types_by_node("controller", "/robot_3")
    seen["services"] = sorted(name.rsplit("/", 1)[1] for name, _ in services)
    publishers = node.get_publisher_names_and_types_by_node("controller", "/robot_3")
    seen["publishers"] = {name: types for name, types in publishers}
    # Until then the other side may not have received the answer to its request.
    wait_for(node, "the end", lambda: ends)
    seen["gain"] = node.get_parameter("gain").value
    print(json.dumps(seen))
    node.destroy_node()
    rclpy.shutdown()


main()
