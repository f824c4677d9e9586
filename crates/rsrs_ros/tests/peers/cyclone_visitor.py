"""Uses the parameters of many nodes as ROS 2 does over Cyclone DDS; see parameters.rs.

The first line of the input has the schemas of the messages and the names of the nodes; what it saw
in each mapping is printed as one line of JSON, by node. The end of the input is the end.
"""

import json
import sys

from cyclonedds.domain import DomainParticipant

from cyclone_services import HEADER, SERVICES, Client, Messages, python_value


class Visitor:
    """Clients of all services of one node."""

    def __init__(self, participant, messages, node):
        self.messages = messages
        self.clients = {s: Client(participant, messages, node, s) for s in SERVICES}

    def parameters(self, pairs):
        return [self.messages.parameter(name, value) for name, value in pairs]

    def set(self, *pairs):
        asked = self.parameters(pairs)
        results = self.clients["set_parameters"].ask(parameters=asked).results
        return [[result.successful, result.reason] for result in results]

    def set_atomically(self, *pairs):
        asked = self.parameters(pairs)
        result = self.clients["set_parameters_atomically"].ask(parameters=asked).result
        return [result.successful, result.reason]

    def dump(self):
        """All parameters with their types, values, descriptions and ranges."""
        names = sorted(self.clients["list_parameters"].ask(prefixes=[], depth=0).result.names)
        values = self.clients["get_parameters"].ask(names=names).values
        kinds = self.clients["get_parameter_types"].ask(names=names).types
        described = self.clients["describe_parameters"].ask(names=names).descriptors
        ranges = [[[r.from_value, r.to_value] for r in d.floating_point_range] for d in described]
        return {
            name: [kind, python_value(value), descriptor.description, limits]
            for name, kind, value, descriptor, limits in zip(
                names, kinds, values, described, ranges, strict=True
            )
        }


def look(visitor, speed, turn_rate):
    """Everything that `ros2 param` does with one node."""
    return {
        "first": visitor.dump(),
        "set": visitor.set(("speed", speed)),
        "too fast": visitor.set(("speed", 0.5)),
        "both": visitor.set_atomically(("speed", speed), ("turn_rate", turn_rate)),
        "one of two": visitor.set_atomically(("turn_rate", 0.1), ("height", 1.0)),
        "last": visitor.dump(),
    }


def main():
    asked = json.loads(sys.stdin.readline())
    for header in [HEADER, {}]:
        # Two types of one name need two participants.
        participant = DomainParticipant(42)
        messages = Messages(asked["schemas"], header)
        seen = {}
        for index, node in enumerate(asked["nodes"], start=1):
            speed, turn_rate = (index + 4 * len(header)) / 64, index / 8
            seen[node] = look(Visitor(participant, messages, node), speed, turn_rate)
        print(json.dumps(seen), flush=True)
    sys.stdin.readline()
    print(json.dumps("end"), flush=True)


main()
