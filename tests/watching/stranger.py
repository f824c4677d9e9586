"""Publishes a std_msgs/Bool on a topic of DDS, of any name, over Cyclone DDS; ends with its input."""

import select
import sys
from dataclasses import dataclass

from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic


@dataclass
class Bool(IdlStruct, typename="std_msgs::msg::dds_::Bool_"):
    data: bool


participant = DomainParticipant(42)
writers = [DataWriter(participant, Topic(participant, name, Bool)) for name in sys.argv[1:]]
# The input is readable when it ends.
while not select.select([sys.stdin], [], [], 0.1)[0]:
    for writer in writers:
        writer.write(Bool(data=True))
