"""A node over Cyclone DDS with one parameter, as rmw_cyclonedds offers it; see parameters.rs.

The first line of the input has the schemas of the messages; the end of the input is the end.
"""

import json
import sys
import time

from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from cyclone_services import HEADER, QOS, SERVICES, Messages, python_value
from cyclone_types import messages
from until_end import input_has_ended


class Node:
    """`/foreign`, whose gain may be anything up to 5."""

    def __init__(self, schemas):
        self.participant, self.messages = DomainParticipant(42), Messages(schemas, HEADER)
        self.gain = 1.0
        answers = {
            "get_parameters": self.get,
            "list_parameters": self.list,
            "set_parameters_atomically": self.set,
        }
        self.ends = [self.end(service, answer) for service, answer in answers.items()]

    def end(self, service, answer):
        """Requests, their answers, and what makes one out of the other."""
        name = SERVICES[service][0]
        request, response = (self.messages.of(f"{name}_{kind}") for kind in ["Request", "Response"])
        requests = Topic(self.participant, f"rq/foreign/{service}Request", request)
        replies = Topic(self.participant, f"rr/foreign/{service}Reply", response)
        reader = DataReader(self.participant, requests, QOS)
        writer = DataWriter(self.participant, replies, QOS)
        return reader, writer, lambda asked: response(asked.guid, asked.sequence, answer(asked))

    def get(self, request):
        return [self.messages.value(self.gain) for _ in request.names]

    def list(self, _):
        kind = self.messages.types.get("rcl_interfaces/msg/ListParametersResult")
        return kind(names=["gain"], prefixes=[])

    def set(self, request):
        kind = self.messages.types.get("rcl_interfaces/msg/SetParametersResult")
        (gain,) = [python_value(parameter.value) for parameter in request.parameters]
        if gain > 5.0:
            return kind(successful=False, reason="too much")
        self.gain = gain
        return kind(successful=True, reason="")

    def answer_all(self):
        for reader, writer, answer in self.ends:
            for request in messages(reader):
                writer.write(answer(request))


def main():
    node = Node(json.loads(sys.stdin.readline())["schemas"])
    while not input_has_ended():
        node.answer_all()
        time.sleep(0.002)
    print(json.dumps(node.gain), flush=True)


main()
