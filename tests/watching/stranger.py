"""Publishes a std_msgs/Bool on a topic of DDS, of any name, over Cyclone DDS; ends with its input."""

import sys
import threading
import time
from dataclasses import dataclass

from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic


@dataclass
class Bool(IdlStruct, typename="std_msgs::msg::dds_::Bool_"):
    data: bool


def end_with_the_input():
    sys.stdin.read()
    ended.set()


ended = threading.Event()
threading.Thread(target=end_with_the_input, daemon=True).start()
participant = DomainParticipant(42)
writers = [DataWriter(participant, Topic(participant, name, Bool)) for name in sys.argv[1:]]
while not ended.is_set():
    for writer in writers:
        writer.write(Bool(data=True))
    time.sleep(0.1)
