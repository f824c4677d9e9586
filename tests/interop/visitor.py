"""Looks at one robot before, during and after a run, as any ROS 2 program may; see interop.rs.

Prints what it saw as one line of JSON for each of the three; whoever reads the first starts the
run, and ends it after the second.
"""

import json
import sys
import time

import rclpy
from geometry_msgs.msg import TwistStamped
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool, String

CONTROLLER = "/robot_3/controller"
NAMES = ["speed", "turn_rate"]
PATIENCE_S = 40.0
PAIRS = 60


class Visitor:
    """A node with the robot's parameters, and what it received on two of its topics."""

    def __init__(self):
        self.node = rclpy.create_node("visitor")
        self.detections, self.commands = {}, {}
        # Deep enough for the whole run, however seldom this thread is let to run.
        reliable = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE)
        for kind, topic, received in [
            (Bool, "/robot_3/detection", self.receive_detection),
            (TwistStamped, "/robot_3/cmd_vel", self.receive_command),
        ]:
            self.node.create_subscription(kind, topic, received, reliable)
        self.notes = {}
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        for topic in ["/swarm/experiment", "/swarm/ending"]:
            self.node.create_subscription(
                String, topic, lambda note, topic=topic: self.receive_note(topic, note), latched)
        self.client = AsyncParameterClient(self.node, CONTROLLER)
        if not self.client.wait_for_services(timeout_sec=PATIENCE_S):
            sys.exit(f"{CONTROLLER} has no parameter services")

    def receive_note(self, topic, note):
        self.notes[topic] = json.loads(note.data)

    def receive_detection(self, message, info):
        """The controller answers the nth detection with the nth command."""
        self.detections[info["publication_sequence_number"]] = message.data

    def receive_command(self, message, info):
        answer = (message.twist.linear.x, message.twist.angular.z)
        sent_ns = info["source_timestamp"]
        self.commands[info["publication_sequence_number"]] = (sent_ns, answer)

    def pairs(self, since_ns):
        """Number, detection and answer of each step that was answered since then."""
        return [
            (step, self.detections[step], *answer)
            for step, (sent_ns, answer) in sorted(self.commands.items())
            if sent_ns >= since_ns and step in self.detections
        ]

    def wait_for(self, what, condition):
        """Spins until something has come."""
        end = time.monotonic() + PATIENCE_S
        while not condition():
            if time.monotonic() > end:
                sys.exit(f"{what} did not come in {PATIENCE_S} s")
            rclpy.spin_once(self.node, timeout_sec=0.1)

    def answer(self, ask):
        """The answer to a request, which is asked again when it is lost."""
        for _ in range(10):
            future = ask()
            rclpy.spin_until_future_complete(self.node, future, timeout_sec=4.0)
            if future.done():
                return future.result()
        sys.exit("no answer in 10 tries")

    def list(self):
        return sorted(self.answer(lambda: self.client.list_parameters([], 0)).result.names)

    def get(self):
        values = self.answer(lambda: self.client.get_parameters(NAMES)).values
        return [parameter_value_to_python(value) for value in values]

    def describe(self):
        (descriptor,) = self.answer(lambda: self.client.describe_parameters(["speed"])).descriptors
        (limits,) = descriptor.floating_point_range
        return [descriptor.description, descriptor.type, limits.from_value, limits.to_value]

    def unanswered(self):
        """All other nodes, and those of them that `ros2 param list` would wait for."""
        names = {
            f"{namespace.rstrip('/')}/{name}"
            for name, namespace in self.node.get_node_names_and_namespaces()
            if name != self.node.get_name() and not name.startswith("_")
        }
        silent = []
        for name in sorted(names):
            client = AsyncParameterClient(self.node, name)
            if not client.wait_for_services(timeout_sec=5.0):
                silent.append(name)
                continue
            self.answer(lambda: client.list_parameters([], 0))
        return sorted(names), silent

    def set(self, name, value):
        """Whether it was set, and why not."""
        parameters = [Parameter(name, value=value)]
        (result,) = self.answer(lambda: self.client.set_parameters(parameters)).results
        return [result.successful, result.reason]


def before(visitor):
    """Nobody runs the robot."""
    return {
        "listed": visitor.list(),
        "at_first": visitor.get(),
        "described": visitor.describe(),
        "set": visitor.set("speed", 0.2),
        "too_fast": visitor.set("speed", 0.5),
        "unknown": visitor.set("sped", 0.1),
        "at_last": visitor.get(),
    }


def during(visitor):
    """The robot is armed, and then moves."""
    # Until it is armed this sets the value that it has in the run anyway.
    visitor.wait_for("the run", lambda: not visitor.set("speed", 0.15)[0])
    armed_ns = time.time_ns()
    visitor.wait_for("the record", lambda: "/swarm/experiment" in visitor.notes)
    record = visitor.notes["/swarm/experiment"]
    nodes, silent = visitor.unanswered()
    seen = {"nodes": nodes, "silent": silent, "robots": record["robots"], "while_armed": visitor.set("speed", 0.2), "values": visitor.get()}

    def enough():
        pairs = visitor.pairs(armed_ns)
        return len(pairs) >= PAIRS and {pair[1] for pair in pairs} == {False, True}

    visitor.wait_for("detections of both kinds, with their commands,", enough)
    return seen | {"pairs": visitor.pairs(armed_ns)}


def after(visitor):
    """The run is over."""
    visitor.wait_for("the end of the run", lambda: visitor.set("speed", 0.2)[0])
    visitor.wait_for("the ending", lambda: "/swarm/ending" in visitor.notes)
    return {"values": visitor.get(), "ending": visitor.notes["/swarm/ending"]["ending"]}


def main():
    rclpy.init()
    visitor = Visitor()
    for look in [before, during, after]:
        print(json.dumps(look(visitor)), flush=True)
    visitor.node.destroy_node()
    rclpy.shutdown()


main()
