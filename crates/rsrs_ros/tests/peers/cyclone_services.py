"""Parameter services over Cyclone DDS, each way of naming a request."""

import time

from cyclonedds.core import Policy, Qos
from cyclonedds.idl import types as idl
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from cyclone_types import Types, fields_of, messages, struct

# Request and response of each service, as in rcl_interfaces.
SERVICES = {
    "get_parameters": ("GetParameters", "string[] names", "ParameterValue[] values"),
    "list_parameters": (
        "ListParameters",
        "string[] prefixes\nuint64 depth",
        "ListParametersResult result",
    ),
    "set_parameters": ("SetParameters", "Parameter[] parameters", "SetParametersResult[] results"),
    "set_parameters_atomically": (
        "SetParametersAtomically",
        "Parameter[] parameters",
        "SetParametersResult result",
    ),
    "describe_parameters": (
        "DescribeParameters",
        "string[] names",
        "ParameterDescriptor[] descriptors",
    ),
    "get_parameter_types": ("GetParameterTypes", "string[] names", "uint8[] types"),
}
# What rmw_cyclonedds puts in front of requests and replies: half of a GUID, and a number.
HEADER = {"guid": idl.uint64, "sequence": idl.int64}
QOS = Qos(
    Policy.Reliability.Reliable(duration(seconds=10)),
    Policy.Durability.Volatile,
    Policy.History.KeepLast(10),
)


class Messages:
    """The types of the services, with or without the header."""

    def __init__(self, schemas, header):
        self.types, self.header, self.made = Types(schemas), header, {}
        for name, request, response in SERVICES.values():
            self.types.texts[f"rcl_interfaces/srv/{name}_Request"] = request
            self.types.texts[f"rcl_interfaces/srv/{name}_Response"] = response

    def of(self, name):
        """The class of a request or response."""
        name = f"rcl_interfaces/srv/{name}"
        if name not in self.made:
            fields = fields_of(self.types.texts[name])
            members = {field: self.types.type_of(name, *rest) for field, *rest in fields}
            self.made[name] = struct(name, self.header | members)
        return self.made[name]

    def value(self, value):
        """A ParameterValue; the only field that counts is that of its type."""
        number = {bool: 1, int: 2, float: 3, str: 4}[type(value)]
        field = {1: "bool_value", 2: "integer_value", 3: "double_value", 4: "string_value"}[number]
        lists = ["byte", "bool", "integer", "double", "string"]
        nothing = dict(bool_value=False, integer_value=0, double_value=0.0, string_value="")
        nothing |= {f"{name}_array_value": [] for name in lists}
        kind = self.types.get("rcl_interfaces/msg/ParameterValue")
        return kind(type=number, **(nothing | {field: value}))

    def parameter(self, name, value):
        return self.types.get("rcl_interfaces/msg/Parameter")(name=name, value=self.value(value))


def python_value(value):
    """What a ParameterValue holds; None if it holds nothing."""
    fields = {1: "bool_value", 2: "integer_value", 3: "double_value", 4: "string_value"}
    return getattr(value, fields[value.type]) if value.type in fields else None


class Client:
    """Asks one service of one node."""

    def __init__(self, participant, types, node, service):
        name = SERVICES[service][0]
        self.request, self.service = types.of(f"{name}_Request"), f"{node}/{service}"
        self.headed = bool(types.header)
        requests = Topic(participant, f"rq{self.service}Request", self.request)
        replies = Topic(participant, f"rr{self.service}Reply", types.of(f"{name}_Response"))
        self.reader = DataReader(participant, replies, QOS)
        self.writer = DataWriter(participant, requests, QOS)
        self.sequence = 0

    def ask(self, **fields):
        """The reply to a request, which is asked again when it is lost."""
        end = time.monotonic() + 30
        while not self.writer.get_matched_subscriptions():
            if time.monotonic() > end:
                raise TimeoutError(f"{self.service} is not there")
            time.sleep(0.01)
        for _ in range(10):
            self.sequence += 1
            # Its high half is not zero either: both must come back.
            header = {"guid": 0x0110_CAFE_0000_0001, "sequence": (7 << 32) + self.sequence}
            self.writer.write(self.request(**(header if self.headed else {}), **fields))
            reply = self.wait_for(header)
            if reply:
                return reply
        raise TimeoutError(f"{self.service} gives no answer in 10 tries")

    def wait_for(self, header):
        end = time.monotonic() + 2
        while time.monotonic() < end:
            for reply in messages(self.reader):
                if not self.headed or {name: getattr(reply, name) for name in header} == header:
                    return reply
            time.sleep(0.002)
        return None
